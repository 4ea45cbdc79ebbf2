"""The table of phases: what turned each loop at its crossover, while a slider moves."""

import math

from PyQt6.QtCore import pyqtSignal
from PyQt6.QtWidgets import QVBoxLayout, QWidget

from workbench.analysis.replies import Judged, JudgedLoop
from workbench.gui.tuning.card import SPACING, wrapped
from workbench.gui.tuning.judgement import Judgement
from workbench.gui.tuning.limit_table import written
from workbench.gui.tuning.limits import Limits
from workbench.gui.tuning.margins_card import (
    LimitOf,
    loop_label,
    margins_headline,
    short_label,
    weakest_loop,
)
from workbench.gui.tuning.number_table import NumberTable
from workbench.gui.tuning.table_rows import Cell, Row, State
from workbench.gui.workspace import Workspace

LAW = "law"
PARTS = {
    LAW: "the gains and the rigid body itself, as if all else were at once",
    "filters": "the low-passes and the notch: gyro, setpoint and derivative",
    "estimator": "flying on an estimate instead of the true motion",
    "delay": "late readings, late commands, and the physics step by which these act",
    "hold": "a command stands for a control period, half of one late on average",
    "rotors": "rotors take time to speed up and slow down",
}
"""What turns a phase, in plain words, by its name in `JudgedLoop.turned`."""
ABSENT = {
    "filters": "No filter is on.",
    "estimator": "No estimator flies: the loops have the true motion.",
}
"""What is said where a part turns no loop at all."""
HEADS = {"estimator": "estim."}
"""For which a narrow window has room."""
LEAST = 1e-9
"""An angle that counts as one [rad]."""
ROWS = 9
"""That are expected before they are known."""


def phase_rows(now: Judged, before: Judged | None, limit_of: LimitOf) -> tuple[Row, ...]:
    """Return a row for each loop: its parts in degrees, and its crossover [rad/s].

    Args:
        now: of the gains that count: proposed ones, where there are some.
        before: of those that fly, None where these are the same.
        limit_of: gives a limit by its name, as shown.
    """
    old = {loop.name: loop for loop in before.loops} if before is not None else {}
    weakest = weakest_loop(now, limit_of) if now.stable else None
    return tuple(_row(loop, old.get(loop.name), loop is weakest) for loop in now.loops)


def costliest(loop: JudgedLoop) -> str:
    """Return the part that costs most phase beside the law, "" where none costs any.

    The law is left out: it has the body's own -90 or -180 degrees, and would always be the one.
    """
    costs = [(angle, name) for name, angle in loop.turned if name != LAW]
    cost, name = min(costs, default=(0.0, ""))
    return name if degrees(cost) != degrees(0.0) else ""


def degrees(angle: float, *, fine: bool = False) -> str:
    """Return an angle [rad] in degrees, with a decimal below 10, or always where it is fine."""
    shown = math.degrees(angle)
    return written(shown, 1 if fine or abs(shown) < 9.95 else 0)


def phase_headline(judged: Judged, limit_of: LimitOf) -> str:
    """Return what costs the weakest loop most phase, in a sentence."""
    loop = weakest_loop(judged, limit_of)
    if not judged.stable or loop is None:
        return margins_headline(judged, None, limit_of)
    most = costliest(loop)
    cost = f"; most: {most} {degrees(dict(loop.turned)[most])}°" if most else ""
    return f"Weakest: {loop_label(loop.name)}{cost}"


def missing_phase(judged: Judged) -> str:
    """Return which loops and parts have no phase, and why, in sentences; "" where all have one."""
    if not judged.stable:
        return "Phases are known of a stable closed loop alone."
    said = []
    uncrossed = [loop_label(loop.name) for loop in judged.loops if not loop.turned]
    if uncrossed:
        said.append(f"Without a crossover: {', '.join(uncrossed)}.")
    crossed = [dict(loop.turned) for loop in judged.loops if loop.turned]
    for name, sentence in ABSENT.items() if crossed else ():
        if all(abs(turned[name]) < LEAST for turned in crossed):
            said.append(sentence)
    return " ".join(said)


def _row(loop: JudgedLoop, old: JudgedLoop | None, strong: bool) -> Row:
    label, most = loop_label(loop.name), costliest(loop)
    turned, before = dict(loop.turned), dict(old.turned) if old is not None else {}
    cells = []
    for name, words in PARTS.items():
        help = f"{label}: {name}, {words}"
        if not turned:
            cells.append(Cell("–", help=help))
            continue
        text = degrees(turned[name])
        was = degrees(before[name]) if before else text
        help = f"{help}: {degrees(turned[name], fine=True)}° at {loop.crossover:.3g} rad/s"
        cells.append(
            Cell(text, was if was != text else "", help=help, marked="most" if name == most else "")
        )
    cells.append(_crossover_cell(loop, old if before else None))
    state = State.BROKEN if loop.growing else State.NONE
    return Row(short_label(loop.name), tuple(cells), state, strong)


def _crossover_cell(loop: JudgedLoop, old: JudgedLoop | None) -> Cell:
    label = loop_label(loop.name)
    if not loop.turned:
        return Cell("–", help=f"{label}: no crossover is known")
    text = _frequency(loop)
    was = _frequency(old) if old is not None else text
    hertz = loop.crossover / (2.0 * math.pi)
    help = (
        f"{label}: its gain is 1 at {loop.crossover:.3g} rad/s ({hertz:.3g} Hz); "
        f"there all parts leave {degrees(loop.phase_margin, fine=True)}° to −180°"
    )
    return Cell(text, was if was != text else "", help=help)


def _frequency(loop: JudgedLoop) -> str:
    """Return a crossover [rad/s], for a narrow column."""
    return f"{loop.crossover:.3g}" if loop.crossover >= 1.0 else f"{loop.crossover:.2f}"


class PhaseView(QWidget):
    """Where the phase of each loop went, with proposed gains beside those that fly.

    Args:
        workspace: colours.
        judgement: what is known of both.
        limits: by which the weakest loop is found.
        parent: the Qt parent; this object is deleted with it.

    Attributes:
        headline: what it comes to, in a sentence, and its tone.
        table: a row for each loop.
        missing: what has no phase, in sentences; hidden where there is none.
    """

    changed = pyqtSignal()
    """Something else is shown."""

    def __init__(
        self,
        workspace: Workspace,
        judgement: Judgement,
        limits: Limits,
        parent: QWidget | None = None,
    ) -> None:
        super().__init__(parent)
        self._judgement = judgement
        self._limits = limits
        self.headline = "", "muted"
        self.table = NumberTable(
            "Where the phase of every loop went, in degrees at its crossover",
            [*(f"{HEADS.get(name, name)} °" for name in PARTS), "at rad/s"],
            workspace.look,
            paired=True,
            widest="yaw rate",
            worded=False,
            head_help=[
                *(f"{name}: {words}" for name, words in PARTS.items()),
                "at: the crossover, where the loop's gain is 1; the highest, if there are more",
            ],
        )
        self.table.expect(ROWS)
        self.missing = wrapped()
        body = QVBoxLayout(self)
        body.setContentsMargins(0, 0, 0, 0)
        body.setSpacing(SPACING)
        body.addWidget(self.missing)
        body.addWidget(self.table, 1)
        judgement.changed.connect(self._show)
        limits.changed.connect(lambda _: self._show())
        self._show()

    def _show(self) -> None:
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
            return self._judgement.said or "Not known yet: the analyst is asked.", "muted"
        if caveat := self._judgement.caveat:
            return caveat, "warning"
        return phase_headline(now, self._limits.value), "muted" if now.stable else "bad"
