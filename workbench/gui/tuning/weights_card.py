"""The card of sensitivities: which gain affects the shown metric most."""

import math
from collections.abc import Callable, Mapping

import pyqtgraph as pg
from PyQt6.QtCore import Qt

from workbench.analysis.queries import Sensitivities
from workbench.gui.analysis import SETTLING_MS, QueryStream
from workbench.gui.errands import single_shot
from workbench.gui.instruments.plane_view import style_axis
from workbench.gui.labels import set_tip
from workbench.gui.layout import buddy, fill, hbox
from workbench.gui.theme import Look
from workbench.gui.tuning.card import TuningCard, set_items, wrapped_label
from workbench.gui.tuning.limits import STEP_LIMITS, NumberLimit, find_limit
from workbench.gui.tuning.trial import NO_TRIAL_STEP_TEXT, TuningTrial
from workbench.gui.wheel import ComboBox
from workbench.gui.workspace import Workspace

GAIN_CHANGE_PERCENT = 10.0
"""Change of a gain to which a bar refers [%]."""
MAX_WEIGHT_BARS = 8
WEIGHT_BAR_SHARE = 0.44
"""Height of a bar, as a share of its row."""
MIN_BAR_SHARE = 0.02
"""Bars below this share of the longest are left out."""


def weight_text(gain: str, slope: float, limit: NumberLimit) -> str:
    """Return a gain's effect, in words."""
    what = f"{GAIN_CHANGE_PERCENT:g} % more {gain}: {limit.label.lower()}"
    return f"{what} {change_text(slope, limit)}"


def change_text(slope: float, limit: NumberLimit) -> str:
    """Return the change of a number with a slope, with its sign and unit."""
    change = limit.factor * GAIN_CHANGE_PERCENT * slope
    sign = "+" if change >= 0.0 else "−"
    return f"{sign}{abs(change):.{limit.decimals + 1}f} {limit.unit}".rstrip()


def strongest_gains(slopes: Mapping[str, float]) -> dict[str, float]:
    """Return the gains that have an effect, the strongest first."""
    known = [(name, slope) for name, slope in slopes.items() if math.isfinite(slope) and slope]
    known.sort(key=lambda each: -abs(each[1]))
    most = abs(known[0][1]) if known else 0.0
    return dict([each for each in known if abs(each[1]) >= MIN_BAR_SHARE * most][:MAX_WEIGHT_BARS])


class WeightBars(pg.PlotWidget):
    """A bar for each gain: to the left if more of it reduces the number.

    Args:
        look: source of colours.
        words: returns a gain's name in words.

    Attributes:
        texts: the content in words.
    """

    def __init__(self, look: Look, words: Callable[[str], str]) -> None:
        super().__init__(enableMenu=False)
        self._look, self._words = look, words
        self.texts: tuple[str, ...] = ()
        self._bars = pg.BarGraphItem(x0=[], y=[], width=[], height=WEIGHT_BAR_SHARE, pen=None)
        self._middle = pg.InfiniteLine(0.0)
        self._none = pg.TextItem("Not known yet", anchor=(0.5, 0.5))
        for item in (self._bars, self._middle, self._none):
            self.addItem(item)
        self.plotItem.hideButtons()
        self.plotItem.setMouseEnabled(False, False)
        self.plotItem.invertY()
        for side in ("left", "right"):
            self.getAxis(side).setStyle(tickLength=0)
        self.setMinimumHeight(120)
        self.setFocusPolicy(Qt.FocusPolicy.NoFocus)
        self.setAccessibleName("Effect of each gain on the metric")
        look.changed.connect(self._apply_colours)
        self._apply_colours()

    def show_slopes(self, slopes: Mapping[str, float], limit: NumberLimit) -> None:
        """Show the effects of gains on a number."""
        shown = strongest_gains(slopes)
        self.texts = tuple(weight_text(self._words(name), x, limit) for name, x in shown.items())
        self.setAccessibleDescription("; ".join(self.texts))
        set_tip(self, "\n".join(self.texts))
        rows, values = range(len(shown)), list(shown.values())
        self._none.setVisible(not shown)
        self._middle.setVisible(bool(shown))
        both = (True, False, bool(shown), False)
        self.plotItem.showAxes(both if shown else False, showValues=both)
        self._bars.setOpts(x0=[0.0] * len(rows), y=rows, width=values)
        self._colour_bars()
        numbers = (change_text(slope, limit) for slope in values)
        for side, texts in (("left", map(self._words, shown)), ("right", numbers)):
            self.getAxis(side).setTicks([list(zip(rows, texts, strict=True))])
        most = max(map(abs, values), default=1.0)
        high = max(len(rows), MAX_WEIGHT_BARS // 2) if shown else 1
        self.setRange(xRange=(-most, most), yRange=(-0.5, high - 0.5), padding=0.0)

    def _apply_colours(self) -> None:
        """Apply the colours of the look."""
        self.setBackground(self._look.colour("card"))
        self._colour_bars()
        self._middle.setPen(self._look.colour("muted"))
        self._none.setColor(self._look.colour("muted"))
        for side in ("left", "right"):
            style_axis(self.getAxis(side), self._look, self.font(), pen=None, text="ink")

    def _colour_bars(self) -> None:
        colours = [self._look.curve(0 if x < 0.0 else 1) for x in self._bars.opts["width"]]
        self._bars.setOpts(brushes=colours)


class WeightsCard(TuningCard):
    """Asks for the effect of every gain once the proposed ones have settled.

    Args:
        workspace: analysis and colours.
        trial: the gains that are being tried.
    """

    def __init__(self, workspace: Workspace, trial: TuningTrial) -> None:
        super().__init__("Sensitivity")
        self._trial = trial
        self._weighed: Mapping[str, Mapping[str, float]] | None = None
        self._asked: Sensitivities | None = None
        self._queries = QueryStream(workspace.analysis, self)
        self.number = ComboBox()
        set_items(self.number, {row.name: row.label for row in STEP_LIMITS})
        self.bars = WeightBars(workspace.look, trial.gains.words)
        self.words = wrapped_label()
        line = hbox(buddy("Gains that change the &metric", self.number), (self.number, 1))
        fill(self.body, line, (self.bars, 1), self.words)
        self._rest = single_shot(self._ask, self, SETTLING_MS)
        self.number.currentIndexChanged.connect(self._show)
        trial.changed.connect(self._follow)
        self._queries.answered.connect(self._take)
        self._queries.refused.connect(self._show_refusal)
        self._show()

    def begin(self) -> None:
        """Clear another vehicle's results."""
        self._queries.forget()
        self._clear()
        self._follow()

    def set_seen(self, seen: bool) -> None:
        """Ask only while the card is visible."""
        self._queries.set_seen(seen)
        self._say_waiting()

    def _clear(self) -> None:
        self._weighed = self._asked = None
        self._show()

    def _follow(self) -> None:
        asked, trial = self._asked, self._trial
        if trial.step is None:
            self._ask()  # no answer follows
            return
        if asked is not None and (asked.gains != trial.judged or asked.step != trial.step):
            of_gains = asked.step == trial.step
            what = "gains; new ones follow" if of_gains else "step; the new one follows"
            self.said.say(f"For the previous {what} …")
        self._rest.start()

    def _ask(self) -> None:
        step, gains = self._trial.step, self._trial.judged
        if step is None:
            self._queries.forget()
            self._clear()  # bars of an earlier step would pass for those of this one
            self.said.say(NO_TRIAL_STEP_TEXT)
        elif gains:
            self._queries.ask(Sensitivities(gains, step))
            self._say_waiting()

    def _say_waiting(self) -> None:
        if self._queries.is_waiting:
            self.said.say("Flying a few hundred steps …")

    def _take(self, asked: Sensitivities, weighed: Mapping[str, Mapping[str, float]]) -> None:
        self._asked, self._weighed = asked, weighed
        self.said.say("")
        self._show()

    def _show_refusal(self, said: str) -> None:
        asked = self._asked
        if asked is not None and asked.step != self._trial.step:
            self._clear()
        self.said.say(said, "warning")

    def _show(self) -> None:
        limit = find_limit(self.number.currentData())
        slopes = self._weighed.get(limit.name, {}) if self._weighed is not None else {}
        self.bars.show_slopes(slopes, limit)
        texts = self.bars.texts
        none = "No gain changes it." if self._weighed is not None else ""
        self.words.setText(f"{texts[0]}." if texts else none)
