"""Sliders that change all gains of a loop together: bandwidth, a margin, and a factor."""

import math

from PyQt6.QtCore import QObject, QSize, Qt, pyqtSignal
from PyQt6.QtGui import QKeyEvent
from PyQt6.QtWidgets import QWidget

from workbench.analysis.queries import ShapeLoop
from workbench.analysis.replies import JudgedLoop, LoopShaped
from workbench.common.parameter import Parameter
from workbench.common.quantity import DisplayUnit
from workbench.control.loop import loop_label
from workbench.design.judge.margins import RobustnessMeasure
from workbench.gui.analysis import SETTLING_MS, QueryStream
from workbench.gui.errands import single_shot
from workbench.gui.gains.gain_input import GainSlider
from workbench.gui.gains.gain_scale import GainScale
from workbench.gui.labels import Label, set_tip
from workbench.gui.layout import NO_MARGINS, choice, grid
from workbench.gui.style import with_class
from workbench.gui.theme import Look
from workbench.gui.tuning.judgement import StabilityFollower
from workbench.gui.tuning.limit_reach import LimitReach
from workbench.gui.tuning.limits import LimitValues, find_limit
from workbench.gui.tuning.trial import TuningTrial
from workbench.gui.units import DEGREE_UNIT, frequency_text
from workbench.gui.workspace import Workspace

BANDWIDTH_PARAMETER = Parameter("bandwidth", "rad/s", "", 0.1, 300.0, default=10.0)
PHASE_MARGIN_PARAMETER = Parameter(
    "phase margin", "rad", "", math.radians(5.0), math.radians(110.0), default=1.0
)
DISK_MARGIN_PARAMETER = Parameter("disk margin", "1", "", 0.05, 1.95, default=0.7)
GAIN_FACTOR_PARAMETER = Parameter("factor", "1", "", 0.1, 10.0, default=1.0)
BANDS_TEXT = (
    "the band is what it can reach, and in its dark and higher part all limits of all loops hold"
)
SHAPING_SLIDERS = (
    (
        BANDWIDTH_PARAMETER,
        "Bandwidth",
        DisplayUnit("rad/s"),
        f"Faster or slower, by all gains of the loop; {BANDS_TEXT}",
    ),
    (
        PHASE_MARGIN_PARAMETER,
        "Phase margin",
        DEGREE_UNIT,
        f"More or less robust, by all gains of the loop; {BANDS_TEXT}",
    ),
    (
        DISK_MARGIN_PARAMETER,
        "Disk margin",
        DisplayUnit(""),
        "More or less robust to gain and phase at once, by all gains of the loop: α, at most 2; "
        f"{BANDS_TEXT}",
    ),
    (
        GAIN_FACTOR_PARAMETER,
        "Gains ×",
        DisplayUnit(""),
        "All gains of the loop times this; it comes back to 1 when it is released",
    ),
)


class ShapeSlider(QObject):
    """A slider with its name and its number.

    Args:
        row: its range.
        label: name with its mnemonic.
        unit: unit of the number.
        help: what it does.
        look: source of colours.
    """

    def __init__(
        self, row: Parameter, label: str, unit: DisplayUnit, help: str, look: Look
    ) -> None:
        super().__init__()
        self._unit, self._help = unit, help
        self.value = row.default
        self.name = Label(label)
        self.slider = GainSlider(GainScale(row, unit), look)
        self.name.setBuddy(self.slider)
        self.number = with_class(Label(), "number")
        self.number.setMinimumSize(self._widest())
        for part in (self.slider, self.name, self.number):
            set_tip(part, help)
        self.slider.setAccessibleName(label.replace("&", ""))
        self.show_value(row.default)

    def show_value(self, value: float) -> None:
        """Show a value, a dash without one."""
        if math.isfinite(value):
            self.value = value
            self.slider.show_value(value, value)
        set_tip(self.slider, self._help)
        text = self._unit.text(value)
        self.number.setText(text)
        self.slider.setAccessibleDescription(text)

    def _widest(self) -> QSize:
        width = self.number.fontMetrics().horizontalAdvance("300.00 rad/s")
        return QSize(width if self._unit.symbol == "rad/s" else width // 2, 0)


class LoopShaping(QWidget):
    """Changes the gains of one loop together, as far as the loop allows.

    While a slider is held, shaping starts from the gains at the time when it was grabbed, so that
    the same path leads back to them.

    Args:
        workspace: colours and analysis.
        trial: the gains that are being tried.
        judgement: stability of all loops.
        limits: limits of the margins of all loops.

    Attributes:
        bandwidth, phase, disk, factor: the sliders; of phase and disk margin one is shown.
        margin: which of the two.
        said: what limits the loop, "" if unknown.
        tone: tone of that sentence.
    """

    told = pyqtSignal()
    """The sentence about the loop's limits changed."""

    def __init__(
        self,
        workspace: Workspace,
        trial: TuningTrial,
        judgement: StabilityFollower,
        limits: LimitValues,
    ) -> None:
        super().__init__()
        self._trial, self._judgement = trial, judgement
        look, analysis = workspace.look, workspace.analysis
        self.bandwidth, self.phase, self.disk, self.factor = (
            ShapeSlider(*each, look) for each in SHAPING_SLIDERS
        )
        self.margin = choice(
            "Margin that the second slider sets",
            ("Phase margin", "Disk margin"),
            "Which margin the slider sets: of the phase alone, or the disk margin α of gain and "
            "phase together",
        )
        self.said = self.tone = ""
        self._rest = single_shot(self._ask_at_rest, self, SETTLING_MS)
        self._queries = QueryStream(analysis, self)
        self._queries.answered.connect(self._hear)
        self._queries.refused.connect(lambda said: self._say(said, "warning"))
        self._reach = LimitReach(analysis, limits, self)
        self._reach.changed.connect(self._show_within_limits)
        self._lay_out()
        for each in (self.bandwidth, self.phase, self.disk, self.factor):
            self._connect(each)
        self.margin.currentIndexChanged.connect(self._choose_margin)
        judgement.changed.connect(self._show)
        trial.changed.connect(self._rest.start)
        self.begin()

    def begin(self) -> None:
        """Clear the last flight."""
        self._loop = ""
        self._base: dict[str, float] | None = None
        self._held: ShapeSlider | None = None
        self._ends = False
        self._limited_by = ""
        self._queries.forget()
        self._reach.forget()
        self._show()

    def set_seen(self, seen: bool) -> None:
        """Ask only while the card is visible."""
        self._queries.set_seen(seen)
        self._reach.set_seen(seen)
        if seen:
            self._rest.start()

    def choose(self, loop: str) -> None:
        """Shape another loop."""
        if loop != self._loop:
            self._loop = loop
            self._let_go()
            for each in (self.bandwidth, self.phase, self.disk):
                each.slider.show_stable(None, fresh=False)
            self._reach.forget()
            self._say("")
            self._show()
            self._rest.start()

    def keyPressEvent(self, event: QKeyEvent | None) -> None:
        """Fly proposed gains on Enter, and discard them on Escape, as in the form of gains."""
        key = event.key() if event is not None else None
        if key in (Qt.Key.Key_Return, Qt.Key.Key_Enter):
            self._trial.gains.apply()
        elif key == Qt.Key.Key_Escape and self._trial.gains.unflown:
            self._trial.gains.discard()
        else:
            super().keyPressEvent(event)

    def _lay_out(self) -> None:
        sliders = (self.bandwidth, self.phase, self.disk, self.factor)
        rows = [(each.name, each.slider, each.number) for each in sliders]
        box = grid(of=self, margins=NO_MARGINS, spacing=(6, 2), stretches=(0, 1))
        for line, row in zip((0, 1, 1, 2), rows, strict=True):
            for column, part in enumerate(row):
                box.addWidget(part, line, column)
        for each in (self.phase, self.disk):
            each.name.hide()  # the choice shows its name
        box.addWidget(self.margin, 1, 0)
        self._show_margin()

    @property
    def robust(self) -> ShapeSlider:
        """The slider of the selected margin."""
        return self.disk if self._robustness is RobustnessMeasure.DISK else self.phase

    @property
    def _robustness(self) -> RobustnessMeasure:
        return (
            RobustnessMeasure.DISK if self.margin.currentIndex() == 1 else RobustnessMeasure.PHASE
        )

    def _choose_margin(self) -> None:
        """Select a margin."""
        self._reach.forget()
        self._let_go()
        self._show_margin()

    def _show_margin(self) -> None:
        for each in (self.phase, self.disk):
            for part in (each.slider, each.number):
                part.setVisible(each is self.robust)

    def _connect(self, each: ShapeSlider) -> None:
        slider = each.slider
        slider.edit_begun.connect(lambda: self._take(each))
        slider.dragged.connect(lambda value: self._want(each, value))
        slider.stepped.connect(
            lambda way, size: self._want(each, slider.scale.stepped(each.value, way, size))
        )
        slider.edit_ended.connect(self._release)

    def _take(self, each: ShapeSlider) -> None:
        """Start from the present gains."""
        if self._held is None:
            self._trial.gains.begin_edit()
            self._base = dict(self._trial.judged)
        self._held, self._ends = each, False
        self._show_within_limits()

    def _want(self, each: ShapeSlider, value: float) -> None:
        if not self._loop or self._base is None:
            return
        each.show_value(value)
        if each is self.factor:
            self._multiply()
        else:
            self._ask()

    def _ask(self) -> None:
        assert self._base is not None
        question = ShapeLoop(
            self._base,
            self._loop,
            self.bandwidth.value,
            self.robust.value,
            self._trial.linked_with(self._loop),
            robustness=self._robustness,
        )
        self._queries.ask(question)

    def _multiply(self) -> None:
        """Propose the gains times the factor, within their limits."""
        assert self._base is not None
        editor, linked = self._trial.gains, self._trial.linked_with(self._loop)
        values: dict[str, float] = {}
        for name in self._trial.gains_of(self._loop):
            row = editor.controller.table.find(name)
            value = min(max(self.factor.value * self._base[name], row.minimum), row.maximum)
            values[name] = value
            if name in linked:
                values[linked[name]] = value
        editor.propose_all(values, f"Gains of {loop_label(self._loop)}")

    def _hear(self, asked: ShapeLoop, shaped: LoopShaped) -> None:
        if asked.loop != self._loop or asked.robustness is not self._robustness:
            return
        low, high = shaped.bandwidths
        self.bandwidth.slider.show_stable(
            (low, high) if math.isfinite(low) else None, fresh=shaped.reached
        )
        low, high = shaped.reach
        self.robust.slider.show_stable(
            (low, high) if math.isfinite(low) and high > low else None, fresh=shaped.reached
        )
        if asked.rests:
            self._limited_by = shaped.said
            self._say(shaped.said)
            self._reach.ask(asked, shaped)
            return
        if self._base is None:
            return
        name = loop_label(self._loop)
        self._trial.gains.propose_all(shaped.gains, f"Gains of {name}")
        if not shaped.reached:
            margin = find_limit("phase_margin").text(shaped.phase_margin)
            if asked.robustness is RobustnessMeasure.DISK:
                disk = find_limit("disk_margin").text(shaped.disk_margin)
                margin = f"a disk margin of {disk}"
            reached = f"{frequency_text(shaped.bandwidth)} and {margin}"
            self._say(f"The nearest possible: {reached}. {shaped.said}", "warning")
        else:
            self._say("")
        if self._ends and not self._queries.is_waiting:
            # the evaluation follows later: the next step starts from the proposed gains
            self._show_margins(shaped)
            self._let_go()

    def _show_within_limits(self) -> None:
        """Show where all limits of all loops hold; while a slider is held, only on that one."""
        if self._held is None:
            self._say(" ".join(filter(None, (self._reach.obstacle, self._limited_by))))
        for each, found in (
            (self.bandwidth, self._reach.bandwidths),
            (self.robust, self._reach.margins),
        ):
            shows = self._held in (None, each)
            each.slider.show_within_limits(found(each.value) if shows else None)

    def _release(self) -> None:
        """End the edit, after the last answer."""
        self._ends = True
        if self._held is self.factor or not self._queries.is_waiting:
            self._let_go()

    def _let_go(self) -> None:
        if self._held is not None:
            self._trial.gains.end_edit()
        self._held, self._base, self._ends = None, None, False
        self.factor.show_value(1.0)
        self._rest.start()
        self._show()

    def _say(self, said: str, tone: str = "muted") -> None:
        if (said, tone) != (self.said, self.tone):
            self.said, self.tone = said, tone
            self.told.emit()

    def _ask_at_rest(self) -> None:
        """Ask for the reach of the sliders, and for what limits the loop."""
        gains = dict(self._trial.judged)
        if self._held is None and self._loop and gains:
            question = ShapeLoop(
                gains,
                self._loop,
                linked=self._trial.linked_with(self._loop),
                rests=True,
                robustness=self._robustness,
            )
            self._queries.ask(question)

    def _show(self) -> None:
        """Show the present loop; a held slider shows the requested value."""
        loop = self._judged
        usable = loop is not None and bool(self._trial.gains_of(self._loop))
        self.margin.setEnabled(usable)
        for each in (self.bandwidth, self.phase, self.disk, self.factor):
            each.slider.setEnabled(usable)
        if loop is None or self._held is not None or not self._is_fresh:
            return
        self._show_margins(loop if loop.stable else None)

    def _show_margins(self, shown: LoopShaped | JudgedLoop | None) -> None:
        """Show the bandwidth and the margins of a loop, None if it is unstable."""
        names = ("bandwidth", "phase_margin", "disk_margin")
        for each, name in zip((self.bandwidth, self.phase, self.disk), names, strict=True):
            each.show_value(getattr(shown, name, math.nan))

    @property
    def _is_fresh(self) -> bool:
        """Whether the evaluation belongs to the loop's proposed gains."""
        judged, proposed = self._judgement.proposed, self._trial.judged
        return judged is not None and all(
            self._judgement.gains.get(name) == proposed[name]
            for name in self._trial.gains_of(self._loop)
        )

    @property
    def _judged(self) -> JudgedLoop | None:
        judged = self._judgement.proposed
        if judged is None:
            return None
        return next((each for each in judged.loops if each.name == self._loop), None)
