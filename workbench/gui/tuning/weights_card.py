"""The card of sensitivities: which gain affects the shown metric most."""

import math
from collections.abc import Callable, Mapping

from PyQt6.QtCore import QRectF, QSize, Qt
from PyQt6.QtGui import QPainter, QPaintEvent
from PyQt6.QtWidgets import QComboBox, QSizePolicy, QWidget

from workbench.analysis.questions import Weigh
from workbench.gui.analysis import Follower
from workbench.gui.errands import single_shot
from workbench.gui.labels import set_tip
from workbench.gui.layout import buddy, fill, hbox
from workbench.gui.theme import Look
from workbench.gui.tuning.card import Card, offer, wrapped
from workbench.gui.tuning.limits import STEP_LIMITS, Limit, find_limit
from workbench.gui.tuning.trial import Trial
from workbench.gui.workspace import Workspace

PERCENT = 10.0
"""Change of a gain to which a bar refers [%]."""
MOST = 8
LEAST = 0.02
"""Bars below this share of the longest are left out."""
REST = 600
"""Gains have settled if they have not changed for this time [ms]."""


def weight_text(gain: str, slope: float, limit: Limit) -> str:
    """Return a gain's effect, in words."""
    change = limit.factor * PERCENT * slope
    decimals = limit.decimals + 1
    sign = "+" if change >= 0.0 else "−"
    number = f"{sign}{abs(change):.{decimals}f} {limit.unit}".rstrip()
    return f"{PERCENT:g} % more {gain}: {limit.label.lower()} {number}"


def strongest(slopes: Mapping[str, float]) -> dict[str, float]:
    """Return the gains that have an effect, the strongest first."""
    known = [(name, slope) for name, slope in slopes.items() if math.isfinite(slope) and slope]
    known.sort(key=lambda each: -abs(each[1]))
    most = abs(known[0][1]) if known else 0.0
    return dict([each for each in known if abs(each[1]) >= LEAST * most][:MOST])


class WeightBars(QWidget):
    """Paints a bar for each gain: to the left if more of it reduces the number.

    Args:
        look: source of colours.
        words: returns a gain's name in words.
    """

    def __init__(self, look: Look, words: Callable[[str], str]) -> None:
        super().__init__()
        self._look, self._words = look, words
        self._slopes: dict[str, float] = {}
        self._limit: Limit | None = None
        self.setMinimumHeight(120)
        self.setSizePolicy(QSizePolicy.Policy.Expanding, QSizePolicy.Policy.Expanding)
        self.setAccessibleName("Effect of each gain on the metric")
        look.changed.connect(self.update)

    @property
    def texts(self) -> tuple[str, ...]:
        """The content in words."""
        if self._limit is None:
            return ()
        slopes = self._slopes.items()
        return tuple(weight_text(self._words(name), each, self._limit) for name, each in slopes)

    def show_slopes(self, slopes: Mapping[str, float], limit: Limit) -> None:
        """Show the effects of gains on a number."""
        self._slopes, self._limit = strongest(slopes), limit
        self.setAccessibleDescription("; ".join(self.texts))
        set_tip(self, "\n".join(self.texts))
        self.update()

    def sizeHint(self) -> QSize:
        """Return the size of all bars."""
        return QSize(320, MOST * (self.fontMetrics().height() + 8))

    def paintEvent(self, event: QPaintEvent | None) -> None:
        """Paint the bars, their names and their numbers."""
        painter = QPainter(self)
        colour = self._look.colour
        if not self._slopes or self._limit is None:
            painter.setPen(colour("muted"))
            painter.drawText(self.rect(), Qt.AlignmentFlag.AlignCenter, "Not known yet")
            return
        height = min(self.height() / len(self._slopes), self.fontMetrics().height() + 12.0)
        names = [*map(self._words, self._slopes)]
        label = max(self.fontMetrics().horizontalAdvance(name) for name in names) + 10.0
        numbers = [text.rsplit(" ", 2 if self._limit.unit else 1) for text in self.texts]
        shown = [" ".join(parts[1:]) for parts in numbers]
        number = max(self.fontMetrics().horizontalAdvance(text) for text in shown) + 10.0
        room = (self.width() - label - number) / 2.0
        most = max(map(abs, self._slopes.values()))
        middle = label + room
        left = Qt.AlignmentFlag.AlignLeft | Qt.AlignmentFlag.AlignVCenter
        right = Qt.AlignmentFlag.AlignRight | Qt.AlignmentFlag.AlignVCenter
        for index, slope in enumerate(self._slopes.values()):
            top = index * height
            painter.setPen(colour("ink"))
            painter.drawText(QRectF(0.0, top, label, height), left, names[index])
            painter.drawText(QRectF(0.0, top, self.width(), height), right, shown[index])
            width = room * slope / most
            bar = QRectF(middle, top + 0.28 * height, width, 0.44 * height).normalized()
            painter.fillRect(bar, self._look.curve(0 if slope < 0.0 else 1))
        painter.setPen(colour("muted"))
        painter.drawLine(round(middle), 0, round(middle), round(len(self._slopes) * height))


class WeightsCard(Card):
    """Asks for the effect of every gain once the proposed ones have settled.

    Args:
        workspace: analysis and colours.
        trial: the gains that are being tried.
    """

    def __init__(self, workspace: Workspace, trial: Trial) -> None:
        super().__init__("Sensitivity")
        self._trial = trial
        self._weighed: Mapping[str, Mapping[str, float]] | None = None
        self._asked: Weigh | None = None
        self._follower = Follower(workspace.analysis, Weigh, self)
        self.number = QComboBox()
        offer(self.number, {row.name: row.label for row in STEP_LIMITS})
        self.bars = WeightBars(workspace.look, trial.gains.words)
        self.words = wrapped()
        line = hbox(buddy("Gains that change the &metric", self.number), (self.number, 1))
        fill(self.body, line, (self.bars, 1), self.words)
        self._rest = single_shot(self._ask, self, REST)
        self.number.currentIndexChanged.connect(self._show)
        trial.changed.connect(self._follow)
        self._follower.answered.connect(self._take)
        self._follower.refused.connect(lambda said: self.said.say(said, "warning"))
        self._show()

    def begin(self) -> None:
        """Clear another vehicle's results."""
        self._follower.forget()
        self._weighed = self._asked = None
        self._show()
        self._follow()

    def set_seen(self, seen: bool) -> None:
        """Ask only while the card is visible."""
        self._follower.set_seen(seen)
        self._say_waiting()

    def _follow(self) -> None:
        if self._asked is not None and self._asked.gains != self._trial.judged:
            self.said.say("For the previous gains; new ones follow …")
        self._rest.start()

    def _ask(self) -> None:
        step, gains = self._trial.step, self._trial.judged
        if step is None:
            self.said.say("Choose a step of a setpoint, not a chirp or a load.")
        elif gains:
            self._follower.ask(Weigh(gains, step))
            self._say_waiting()

    def _say_waiting(self) -> None:
        if self._follower.is_waiting:
            self.said.say("Flying a few hundred steps …")

    def _take(self, asked: Weigh, weighed: Mapping[str, Mapping[str, float]]) -> None:
        self._asked, self._weighed = asked, weighed
        self.said.say("")
        self._show()

    def _show(self) -> None:
        limit = find_limit(self.number.currentData())
        slopes = self._weighed.get(limit.name, {}) if self._weighed is not None else {}
        self.bars.show_slopes(slopes, limit)
        texts = self.bars.texts
        none = "No gain changes it." if self._weighed is not None else ""
        self.words.setText(f"{texts[0]}." if texts else none)
