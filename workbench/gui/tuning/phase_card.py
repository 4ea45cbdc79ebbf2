"""The card of phases: what turned each loop at its crossover, while a slider moves."""

import math

from PyQt6.QtWidgets import QWidget

from workbench.analysis.replies import Judged, JudgedLoop
from workbench.gui.tuning.card import Card
from workbench.gui.tuning.judgement import Judgement
from workbench.gui.tuning.limit_table import find_limit
from workbench.gui.tuning.limits import Limits
from workbench.gui.tuning.margins_card import (
    LimitOf,
    loop_label,
    margin_cell,
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
MARGIN = find_limit("phase_margin")
LEFT = "what is left to −180°: 180° and all parts"
HEADS = {"estimator": "estim."}
"""For which a narrow window has room."""
ROWS = 9
"""That are expected before they are known."""


def phase_rows(now: Judged, before: Judged | None, limit_of: LimitOf) -> tuple[Row, ...]:
    """Return a row for each loop: its parts, and the phase margin that they leave.

    Args:
        now: of the gains that count: proposed ones, where there are some.
        before: of those that fly, None where these are the same.
        limit_of: gives a limit by its name, as shown.
    """
    old = {loop.name: loop for loop in before.loops} if before is not None else {}
    weakest = weakest_loop(now, limit_of) if now.stable else None
    return tuple(_row(loop, old.get(loop.name), loop is weakest, limit_of) for loop in now.loops)


def costliest(loop: JudgedLoop) -> str:
    """Return the part that costs most phase beside the law, "" where none costs any.

    The law is left out: it has the body's own -90 or -180 degrees, and would always be the one.
    """
    cost, name = min((angle, name) for name, angle in loop.turned if name != LAW)
    return name if degrees(cost) != degrees(0.0) else ""


def degrees(angle: float) -> str:
    """Return an angle in degrees; from 10 on without decimals, for a narrow column."""
    shown = math.degrees(angle)
    text = f"{shown:.{0 if abs(shown) >= 9.95 else 1}f}"
    return (text.removeprefix("-") if float(text) == 0.0 else text).replace("-", "−")


def phase_headline(judged: Judged, limit_of: LimitOf) -> str:
    """Return what costs the weakest loop most phase, in a sentence."""
    loop = weakest_loop(judged, limit_of)
    if not judged.stable or loop is None:
        return margins_headline(judged, None, limit_of)
    name = loop_label(loop.name)
    most = costliest(loop) if loop.turned else ""
    if not most:
        return f"Weakest: {name}"
    return f"Weakest: {name}; most: {most} {degrees(dict(loop.turned)[most])}°"


def _row(loop: JudgedLoop, old: JudgedLoop | None, strong: bool, limit_of: LimitOf) -> Row:
    turned, before = dict(loop.turned), dict(old.turned) if old is not None else {}
    most = costliest(loop) if turned else ""
    cells = []
    for name, words in PARTS.items():
        text = degrees(turned[name]) if turned else "–"
        was = degrees(before[name]) if turned and before else text
        help = f"{loop_label(loop.name)}: {name}, {words}"
        if turned:
            help = f"{help}: {text}° at {loop.crossover:.3g} rad/s"
        cells.append(
            Cell(text, was if was != text else "", help=help, marked="most" if name == most else "")
        )
    cells.append(margin_cell(loop, old, MARGIN, limit_of))
    state = State.BROKEN if loop.growing else State.NONE
    return Row(short_label(loop.name), tuple(cells), state, strong)


class PhaseCard(Card):
    """Where the phase of each loop went, with proposed gains beside those that fly.

    Args:
        workspace: colours.
        judgement: what is known of both.
        limits: that phase margins should keep.
        parent: the Qt parent; this object is deleted with it.
    """

    def __init__(
        self,
        workspace: Workspace,
        judgement: Judgement,
        limits: Limits,
        parent: QWidget | None = None,
    ) -> None:
        super().__init__("Phase", parent)
        self._judgement = judgement
        self._limits = limits
        self.table = NumberTable(
            "Where the phase of every loop went, in degrees at its crossover",
            [f"{HEADS.get(name, name)} °" for name in (*PARTS, "margin")],
            workspace.look,
            paired=True,
            widest="yaw rate",
            worded=False,
            head_help=[f"{name}: {words}" for name, words in (*PARTS.items(), ("margin", LEFT))],
        )
        self.table.expect(ROWS)
        self.body.addWidget(self.table, 1)
        judgement.changed.connect(self._show)
        limits.changed.connect(lambda _: self._show())
        self._show()

    def _show(self) -> None:
        now, before = self._judgement.proposed, self._judgement.flown
        if now is None:
            self.said.say(self._judgement.said or "Not known yet.")
            self.table.set_rows(())
            return
        other = before if before is not now else None
        self.table.expect(len(now.loops))
        self.table.set_rows(phase_rows(now, other, self._limits.value))
        if caveat := self._judgement.caveat:
            self.said.say(caveat, "warning")
        else:
            said = phase_headline(now, self._limits.value)
            self.said.say(said, "muted" if now.stable else "bad")
