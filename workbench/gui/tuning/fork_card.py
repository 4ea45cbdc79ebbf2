"""The card of forks: from the present instant, fly two sets of gains or controllers in parallel."""

from collections.abc import Callable, Sequence
from dataclasses import replace
from functools import partial

import numpy as np
from PyQt6.QtCore import Qt, pyqtSignal
from PyQt6.QtWidgets import QCheckBox

from workbench.analysis.queries import Fork, RequestedStep
from workbench.common.quantity import DisplayUnit
from workbench.design.branches import Branch, FlownBranch
from workbench.design.step_metrics import StepMetrics
from workbench.gui.analysis import QueryStream
from workbench.gui.charts.curve import CurveStyle
from workbench.gui.charts.static_plot import StaticPlot
from workbench.gui.flight_control import FlightControl
from workbench.gui.gains.gain_rows import controller_gains
from workbench.gui.labels import menu_text, set_tip, tip_text
from workbench.gui.layout import button, fill, hbox
from workbench.gui.number_field import NumberField
from workbench.gui.tuning.card import TuningCard, fields_beside, set_items
from workbench.gui.tuning.designs import Designs, controller_label, gain_differences_text
from workbench.gui.tuning.limits import STEP_LIMITS
from workbench.gui.tuning.number_row import Cell, NumberRow
from workbench.gui.tuning.number_table import NumberTable
from workbench.gui.tuning.trial import NO_TRIAL_STEP_TEXT, TuningTrial
from workbench.gui.wheel import ComboBox
from workbench.gui.workspace import Workspace
from workbench.live.orders import FlightOrder
from workbench.scenario.axes import find_axis
from workbench.session.checkpoint import Checkpoint

FLOWN_BRANCH = "now"
PROPOSED_BRANCH = "proposed"
FORK_COLUMNS = ("rise s", "over %", "settle s", "error %", "rotor %")
"""Headings of the columns, in the order of `STEP_LIMITS`."""
FORK_DURATION_LIMITS_S = (0.5, 20.0)
"""Limits of a fork's duration [s]."""


def axis_displacement(flown: FlownBranch, axis: str) -> np.ndarray:
    """Return the displacement along an axis since the fork [m]; for yaw the total distance."""
    place = find_axis(axis).place
    moved = flown.position - flown.position[:1]
    return np.linalg.norm(moved, axis=1) if place is None else moved[:, place]


FlownBranches = Sequence[tuple[FlownBranch, StepMetrics | None]]
"""Branches, each with the metrics of its step."""
FORK_QUANTITIES: dict[str, tuple[Callable[[FlownBranch, str], np.ndarray], str]] = {
    "velocity": (FlownBranch.response, ""),
    "way flown": (axis_displacement, "m"),
    "tilt": (lambda flown, axis: flown.tilt, "rad"),
    "rotor use": (lambda flown, axis: flown.rotor_use, "1"),
}
"""Quantities by name: the values of a branch along an axis, in SI, and their unit; "" for that of
the axis."""


class ForkCard(TuningCard):
    """Continues the flight from the present instant in another process, in two branches.

    A branch is a set of gains of the flying controller, or another controller with its own gains: a
    shipped one, or a file that has flown since the window was opened.

    Args:
        workspace: flight, analysis and colours.
        trial: the gains that are being tried.
        designs: the controllers.

    Attributes:
        is_busy: whether a fork is in progress.
    """

    busy_changed = pyqtSignal(bool)
    """Whether a fork for the user is in progress: a ghost must not replace it."""

    def __init__(self, workspace: Workspace, trial: TuningTrial, designs: Designs) -> None:
        super().__init__("Fork the flight")
        self._flight, self._trial = workspace.flight, trial
        self._control = FlightControl(workspace.flight, workspace.preferences, self)
        self._designs = designs
        self.is_busy = False
        self._forks = QueryStream(workspace.analysis, self, seen=True)
        self._branches: tuple[Branch, ...] = ()
        self._forked: FlownBranches = ()
        self._axis = "x"
        self.one, self.other, self.quantity = ComboBox(), ComboBox(), ComboBox()
        self.quantity.addItems([*FORK_QUANTITIES])
        self.duration = NumberField("Time ahead", 1, 0.5)
        self.duration.set_range(DisplayUnit("s"), *FORK_DURATION_LIMITS_S)
        self.duration.show_si(5.0)
        self.duration.refused.connect(lambda _: self.refresh())
        self.with_step = QCheckBox("With a s&tep")
        self.with_step.setChecked(True)
        self.button = button("Fork &now", self.fork, "primary")
        self.plot = StaticPlot(workspace)
        self.plot.set_hint("Fork: both continue from this moment")
        self.table = NumberTable(
            "Numbers of each branch",
            FORK_COLUMNS,
            workspace.look,
            paired=False,
            widest="proposed",
            worded=False,
        )
        self.table.expect(2)
        self.table.hide()
        self.keep_one, self.keep_other = (
            button("", partial(self._keep, index), help="Fly this from now on")
            for index in range(2)
        )
        self._offer()
        self._lay_out()
        self.quantity.currentIndexChanged.connect(self._draw)
        self.one.currentIndexChanged.connect(self._show_state)
        self.other.currentIndexChanged.connect(self._show_state)
        trial.changed.connect(self.refresh)
        trial.gains.state_changed.connect(self.refresh)
        self._forks.answered.connect(self._show_forked)
        self._forks.refused.connect(self._refuse)
        self._seen = True
        self._forks.preparing.connect(lambda said: self.said.say(f"Flying both … {said}"))
        self._show_state()

    def begin(self) -> None:
        """Clear the forks of another flight or controller."""
        self._forked = ()
        self._forks.forget()
        self._draw()
        self._set_busy(False)
        self.said.say("")
        self.refresh()

    def set_seen(self, seen: bool) -> None:
        """Follow slots and gains only while the card is visible."""
        self._seen = seen
        self.refresh()

    def refresh(self) -> None:
        """Offer the filled slots, and the controllers that do not fly."""
        if self._seen:
            self._offer()
            self._show_state()

    def fork(self) -> None:
        """Fork the flight at its present instant."""
        if self.is_busy:
            return
        one, other = (self._branch(each.currentData()) for each in (self.one, self.other))
        if one.name == other.name:  # files of the same name in two folders
            other = replace(other, name=other.controller)
        self._set_busy(True)
        ask = partial(self._ask, (one, other))
        self._flight.do(FlightOrder.GET_CHECKPOINT, ask, self._refuse)

    def _ask(self, branches: tuple[Branch, ...], checkpoint: Checkpoint) -> None:
        step = self._trial.step if self.with_step.isChecked() else None
        self._axis = step.axis if step is not None else self._axis
        duration = self.duration.si
        if step is not None:
            step = RequestedStep(step.axis, step.amplitude, duration)
        self._forks.ask(Fork(checkpoint, branches, duration, step))

    def _show_forked(self, question: Fork, forked: FlownBranches) -> None:
        self._forked, self._branches = forked, question.branches
        self._set_busy(False)
        self._draw()

    def _refuse(self, said: str) -> None:
        self._set_busy(False)
        self.said.say(said, "warning")

    def _draw(self) -> None:
        self._draw_branches()
        self._show_state()

    def _draw_branches(self) -> None:
        self.plot.clear()
        self.table.setVisible(any(numbers for _, numbers in self._forked))
        if not self._forked:
            return
        values_of, unit = FORK_QUANTITIES[self.quantity.currentText()]
        unit = unit or find_axis(self._axis).unit
        self.plot.set_axes("time ahead", self.quantity.currentText(), unit)
        branches = [branch for branch, _ in self._forked]
        for index, branch in enumerate(branches):
            style = CurveStyle.SOLID if index == 0 else CurveStyle.DASHED
            time = branch.time - branch.time[0] if len(branch.time) else branch.time
            self.plot.set_curve(branch.name, time, values_of(branch, self._axis), style, index)
        self.table.set_rows(tuple(_branch_row(branch.name, each) for branch, each in self._forked))
        lost = [f"{each.name}: {each.lost}" for each in branches if each.lost]
        if lost:
            self.said.say("; ".join(lost), "bad")
        else:
            self.said.say(
                _branch_differences(self._branches, controller_label(self._designs.present))
            )

    def _keep(self, index: int) -> None:
        branch = self._branches[index]
        if branch.controller:
            self._control.fly_controller(branch.controller)
        elif branch.name == FLOWN_BRANCH:
            self._trial.gains.discard()
            self.said.say("The present flight continues.")
        else:
            self._trial.gains.adopt(branch.gains, "a branch of a fork")

    def _offer(self) -> None:
        """Offer all branches for both."""
        gains = {FLOWN_BRANCH: FLOWN_BRANCH, PROPOSED_BRANCH: PROPOSED_BRANCH}
        gains |= {each: f"slot {each}" for each in self._trial.gains.slots}
        laws = {each: controller_label(each) for each in self._designs.others}
        for box, first in ((self.one, FLOWN_BRANCH), (self.other, PROPOSED_BRANCH)):
            if not set_items(box, gains | laws, first):
                continue
            for each in laws:
                said = f"The controller {each} takes over, with its own gains"
                box.setItemData(box.findData(each), tip_text(said), Qt.ItemDataRole.ToolTipRole)
            set_tip(box, box.currentText())  # a narrow box truncates names

    def _branch(self, chosen: str) -> Branch:
        """Return the selected branch."""
        flown, slots = self._trial.flown, self._trial.gains.slots
        if chosen == FLOWN_BRANCH:
            return Branch(FLOWN_BRANCH, flown)
        if chosen == PROPOSED_BRANCH:
            return Branch(PROPOSED_BRANCH, self._trial.proposed)
        if chosen in slots:
            return Branch(f"slot {chosen}", {**flown, **controller_gains(slots[chosen])})
        return Branch(controller_label(chosen), {}, chosen)

    def _set_busy(self, busy: bool) -> None:
        if busy != self.is_busy:
            self.is_busy = busy
            self.busy_changed.emit(busy)
        self._show_state()
        if busy:
            self.said.say("Flying both …")

    def _show_state(self) -> None:
        same = self.one.currentData() == self.other.currentData()
        can = bool(self._trial.flown) and not self.duration.fault and not same
        self.button.setEnabled(not self.is_busy and can)
        set_tip(self.button, "Choose two different ones" if same else "")
        has_step = self._trial.step is not None
        self.with_step.setEnabled(has_step)
        said = "The step of the excitation is commanded at once"
        set_tip(self.with_step, said if has_step else NO_TRIAL_STEP_TEXT)
        done = bool(self._forked) and not self.is_busy
        boxes = (self.one, self.other)
        names = [each.name for each in self._branches] if done else [b.currentText() for b in boxes]
        self.keep_one.setText(f"Kee&p {menu_text(names[0])}")
        self.keep_other.setText(f"Keep {menu_text(names[1])}")
        for each in (self.keep_one, self.keep_other):
            each.setEnabled(done)

    def _lay_out(self) -> None:
        fields = (
            ("Fl&y", self.one),
            ("A&gainst", self.other),
            ("Ti&me", self.duration),
            ("Sh&ow", self.quantity),
        )
        for box in (self.one, self.other, self.quantity):
            box.currentTextChanged.connect(partial(set_tip, box))
            set_tip(box, box.currentText())
        self.body.addLayout(fields_beside(fields))
        self.head.addWidget(self.with_step)
        line = hbox(1, self.keep_one, self.keep_other, self.button)
        fill(self.body, (self.plot, 1), self.table, line)


def _branch_row(name: str, numbers: StepMetrics | None) -> NumberRow:
    """Return the numbers of a branch; a lost flight has none."""
    if numbers is None:
        return NumberRow(name, tuple(Cell("–") for _ in STEP_LIMITS))
    return NumberRow(
        name,
        tuple(
            Cell(
                limit.number_text(value := limit.of(numbers)),
                help=(numbers.withheld if value != value else "") or f"{limit.label}, {limit.help}",
            )
            for limit in STEP_LIMITS
        ),
    )


def _branch_differences(branches: Sequence[Branch], flying: str) -> str:
    """Return the differences between the branches, as a sentence."""
    one, other = branches
    others = [each.name for each in branches if each.controller]
    if len(others) == 2:
        return f"{one.name} and {other.name} take over, each with its own gains"
    if others:
        own = other if one.controller else one
        return f"{own.name} flies {flying}; {others[0]} takes over with its own gains"
    return f"{other.name}: {gain_differences_text(other.gains, one.gains)}"
