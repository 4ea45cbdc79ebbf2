"""The phase budget of loops: what each part costs at the crossover, as a table and a sentence."""

import math

from PyQt6.QtCore import pyqtSignal
from PyQt6.QtGui import QShowEvent
from PyQt6.QtWidgets import QWidget

from workbench.analysis.replies import Judged, JudgedLoop
from workbench.common.quantity import number_text, significant_text
from workbench.control.loop import loop_label
from workbench.gui.layout import NO_MARGINS, vbox
from workbench.gui.tuning.card import CARD_SPACING_PX, wrapped_label
from workbench.gui.tuning.judgement import StabilityFollower, with_caveat
from workbench.gui.tuning.limits import LimitValues, find_limit
from workbench.gui.tuning.margins_card import (
    LimitLookup,
    margins_headline,
    short_label,
    weakest_loop,
)
from workbench.gui.tuning.number_row import Cell, NumberRow, RowState
from workbench.gui.tuning.number_table import NumberTable
from workbench.gui.units import FREQUENCY_DIGITS, frequency_text, hertz_text
from workbench.gui.workspace import Workspace

LAW_PHASE_PART = "law"
PHASE_PARTS = {
    LAW_PHASE_PART: "the gains and the rigid body itself, as if all else were instantaneous",
    "filters": "the low-passes and the notch: gyro, setpoint and derivative",
    "estimator": "flying on an estimate instead of the true motion",
    "delay": "late readings, late commands, and the physics step by which these act",
    "hold": "a command is held for a control period, so it is half a period late on average",
    "rotors": "rotors take time to speed up and slow down",
}
"""Descriptions of the parts of a phase, by their names in `JudgedLoop.turned`."""
ABSENT_PHASE_PARTS = {
    "filters": "No filter is on.",
    "estimator": "No estimator flies: the loops have the true motion.",
}
"""Text for a part that affects no loop."""
SHORT_PHASE_HEADINGS = {"estimator": "estim."}
"""Short headings for a narrow window."""
MIN_PHASE_RAD = 1e-9
"""Smaller angles count as zero [rad]."""
EXPECTED_PHASE_ROWS = 9
"""Number of rows to expect before they are known."""


def phase_rows(now: Judged, before: Judged | None, limit_of: LimitLookup) -> tuple[NumberRow, ...]:
    """Return a row for each loop: the parts of its phase in degrees, and its crossover [rad/s].

    Args:
        now: results for the proposed gains, or else for the flown ones.
        before: results for the flown gains, None if these are the same.
        limit_of: returns a limit by name, as shown.
    """
    old = {loop.name: loop for loop in before.loops} if before is not None else {}
    weakest = weakest_loop(now, limit_of) if now.stable else None
    return tuple(_phase_row(loop, old.get(loop.name), loop is weakest) for loop in now.loops)


def costliest_part(loop: JudgedLoop) -> str:
    """Return the part other than the law that takes the most phase, "" if none takes any.

    The law is left out: it includes the body's own -90 or -180 degrees, and would always be the
    largest.
    """
    costs = [(angle, name) for name, angle in loop.turned if name != LAW_PHASE_PART]
    cost, name = min(costs, default=(0.0, ""))
    return name if degrees_text(cost) != degrees_text(0.0) else ""


def degrees_text(angle: float) -> str:
    """Return an angle [rad] in degrees, as phase margins are shown."""
    return number_text(math.degrees(angle), find_limit("phase_margin").decimals)


def phase_headline(judged: Judged, limit_of: LimitLookup) -> str:
    """Return the part that takes the most phase of the weakest loop, as a sentence."""
    loop = weakest_loop(judged, limit_of)
    if not judged.stable or loop is None:
        return margins_headline(judged, None, limit_of)
    most = costliest_part(loop)
    cost = f"; most: {most} {degrees_text(dict(loop.turned)[most])}°" if most else ""
    return f"Weakest: {loop_label(loop.name)}{cost}"


def missing_phase(judged: Judged) -> str:
    """Return which loops and parts have no phase, and why, in sentences; "" if all have one."""
    if not judged.stable:
        return "Phases are known only for a stable closed loop."
    said = []
    uncrossed = [loop_label(loop.name) for loop in judged.loops if not loop.turned]
    if uncrossed:
        said.append(f"Without a crossover: {', '.join(uncrossed)}.")
    crossed = [dict(loop.turned) for loop in judged.loops if loop.turned]
    for name, sentence in ABSENT_PHASE_PARTS.items() if crossed else ():
        if all(abs(turned[name]) < MIN_PHASE_RAD for turned in crossed):
            said.append(sentence)
    return " ".join(said)


def _phase_row(loop: JudgedLoop, old: JudgedLoop | None, strong: bool) -> NumberRow:
    label, most = loop_label(loop.name), costliest_part(loop)
    turned, before = dict(loop.turned), dict(old.turned) if old is not None else {}
    cells = []
    for name, words in PHASE_PARTS.items():
        help = f"{label}: {name}, {words}"
        if not turned:
            cells.append(Cell("–", help=help))
            continue
        text = degrees_text(turned[name])
        was = degrees_text(before[name]) if before else text
        help = f"{help}: {degrees_text(turned[name])}° at {frequency_text(loop.crossover)}"
        cells.append(
            Cell(text, was if was != text else "", help=help, marked="most" if name == most else "")
        )
    cells.append(_crossover_cell(loop, old if before else None))
    state = RowState.BROKEN if loop.growing else RowState.NONE
    return NumberRow(short_label(loop.name), tuple(cells), state, strong)


def _crossover_cell(loop: JudgedLoop, old: JudgedLoop | None) -> Cell:
    label = loop_label(loop.name)
    if not loop.turned:
        return Cell("–", help=f"{label}: no crossover is known")
    text = significant_text(loop.crossover, FREQUENCY_DIGITS)
    was = significant_text(old.crossover, FREQUENCY_DIGITS) if old is not None else text
    help = (
        f"{label}: its gain is 1 at {hertz_text(loop.crossover)}; "
        f"there, all parts leave {degrees_text(loop.phase_margin)}° to −180°"
    )
    return Cell(text, was if was != text else "", help=help)


class PhaseView(QWidget):
    """The phase budget of each loop, with proposed gains beside the flown ones.

    Args:
        workspace: source of colours.
        judgement: known results for both.
        limits: limits that determine the weakest loop.

    Attributes:
        headline: summary as a sentence, and its tone.
        table: one row per loop.
        missing: loops and parts without a phase, in sentences; hidden if there are none.
    """

    changed = pyqtSignal()
    """The table changed."""

    def __init__(
        self, workspace: Workspace, judgement: StabilityFollower, limits: LimitValues
    ) -> None:
        super().__init__()
        self._judgement = judgement
        self._limits = limits
        self.headline = "", "muted"
        self.table = NumberTable(
            "Where the phase of every loop went, in degrees at its crossover",
            [*(f"{SHORT_PHASE_HEADINGS.get(name, name)} °" for name in PHASE_PARTS), "at rad/s"],
            workspace.look,
            paired=True,
            widest="yaw rate",
            worded=False,
            head_help=[
                *(f"{name}: {words}" for name, words in PHASE_PARTS.items()),
                "at: the crossover, where the loop's gain is 1; the highest, if there are more",
            ],
        )
        self.table.expect(EXPECTED_PHASE_ROWS)
        self.missing = wrapped_label()
        vbox(self.missing, (self.table, 1), of=self, margins=NO_MARGINS, spacing=CARD_SPACING_PX)
        judgement.changed.connect(self._show)
        limits.changed.connect(lambda _: self._show())
        self._show()

    def showEvent(self, event: QShowEvent | None) -> None:
        """Show what was judged while it was hidden."""
        super().showEvent(event)
        self._show()

    def _show(self) -> None:
        if not self.isVisible():
            return
        now, before = self._judgement.proposed, self._judgement.flown
        missing = missing_phase(now) if now is not None else ""
        self.missing.setText(missing)
        self.missing.setVisible(bool(missing))
        self.headline = self._headline(now)
        if now is None:
            self.table.set_rows(())
        else:
            other = before if before is not now else None
            self.table.expect(len(now.loops))
            self.table.set_rows(phase_rows(now, other, self._limits.value))
        self.changed.emit()

    def _headline(self, now: Judged | None) -> tuple[str, str]:
        if now is None:
            return self._judgement.said or "Not known yet: the analyst is computing it.", "muted"
        tone = "muted" if now.stable else "bad"
        return with_caveat(self._judgement.caveat, phase_headline(now, self._limits.value), tone)
