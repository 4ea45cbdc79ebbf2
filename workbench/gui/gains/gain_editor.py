"""The gains that are being tuned: proposed, flown and kept values."""

from collections.abc import Iterable
from enum import Enum

from PyQt6.QtCore import QObject, pyqtSignal
from PyQt6.QtGui import QUndoStack

from workbench.common.errors import WorkbenchError
from workbench.common.parameter import Parameter
from workbench.control.controller_file import controller_or_default, load_controller
from workbench.control.schedule import GainSchedule, split_label, with_label
from workbench.gains.formats import firmware_of
from workbench.gui.analysis import Analysis
from workbench.gui.flight_model import FlightModel
from workbench.gui.gains.flown_gains import FlownGains, GainValues
from workbench.gui.gains.gain_rows import (
    GainLabel,
    flight_rows,
    gain_count_text,
    gain_label,
    in_gain_file,
    linked_gain,
    loop_gains,
)
from workbench.gui.gains.gain_step import GainStep
from workbench.gui.gains.stability_check import StabilityCheck, same_loops
from workbench.gui.notices import Notices
from workbench.gui.preferences import Preferences
from workbench.gui.units import gain_text
from workbench.live.view import LiveView
from workbench.scenario.scenario import Action
from workbench.session.snapshot import Snapshot

APPLY_AT_ONCE = "at once"
MAX_UNDO_STEPS = 500
"""Limit of undo steps; beyond it the oldest is dropped."""
EXTERNAL_CHANGE = "a change from elsewhere"
SET_SWITCH_HYSTERESIS = 0.1
"""A set stays shown until another is closer by this share of the distance between them."""
SEPARATE_EDIT = -1
"""Edit number of a change that is a step of undo by itself."""


class GainMark(Enum):
    """State of a parameter, in words."""

    KEPT = "kept"
    TRIED = "tried, not kept"
    PROPOSED = "proposed, not flown"


class GainEditor(QObject):
    """Tries gains on the flight, keeps them or brings the kept ones back.

    Sliders show `proposed`; the flight has `flown`; `kept` is what `revert` restores, at first the
    values of the flight's start. Values that a gain file has (`saved_names`) can be kept,
    reverted, stored and saved. The other rows, as wind, faults and modes, are conditions: they can
    be set and undone here, and do not change when gains are restored.

    Values that would make a loop unstable, or cannot be evaluated, do not fly until `confirm`; kept
    values always fly.

    Args:
        flight: gets the orders.
        analysis: evaluates proposed values.
        preferences: whether proposed values fly at once, or on Enter.
        notices: takes refusals.
        parent: the Qt parent.

    Attributes:
        table: parameter table of the flight's controller.
        rows: rows of that table that the flight has, in order.
        saved_names: names of those rows that a gain file has.
        proposed: values on the sliders, of all rows.
        kept: their values that `revert` restores.
        slots: their stored values, by letter of the slot.
        before_slot: their values before a slot was recalled, else empty.
        linked: whether gains of x and y change together.
        shown_set: the shown and evaluated set of scheduled gains; None without a schedule.
        follows: whether that is the set that flies, or has the largest weight.
        warning: why proposed values do not fly without `confirm`, as a sentence; "" if they fly.
        faults: why entered values are refused, by name of the parameter, the newest last.
    """

    begun = pyqtSignal(object)
    """The first `LiveView` of another flight, to which the gains now belong."""
    proposed_changed = pyqtSignal(str)
    """Name of a parameter whose proposed value changed."""
    flown_changed = pyqtSignal(object)
    """Values that changed in the flight, by name."""
    warning_changed = pyqtSignal(str)
    """`warning` changed."""
    value_refused = pyqtSignal(str, str)
    """Name of a parameter, and why it refuses the requested value; "" if it accepts it."""
    ranges_changed = pyqtSignal()
    """The stable ranges changed, or became outdated."""
    set_changed = pyqtSignal()
    """Another set of scheduled gains is shown and evaluated."""
    state_changed = pyqtSignal()
    """Anything else: kept, slots, undo, links, or the rows themselves."""

    def __init__(
        self,
        flight: FlightModel,
        analysis: Analysis,
        preferences: Preferences,
        notices: Notices,
        parent: QObject | None = None,
    ) -> None:
        super().__init__(parent)
        self._preferences, self._notices, self._flight = preferences, notices, flight
        self._flown = FlownGains(flight, self)
        self._stability = StabilityCheck(analysis, lambda: self.start, self)
        self._steps = QUndoStack(self)
        self._steps.setUndoLimit(MAX_UNDO_STEPS)
        self._edits, self._edit = 0, SEPARATE_EDIT
        self._vehicle: object = None
        self.controller = controller_or_default(None)
        self.rows: tuple[Parameter, ...] = ()
        self.saved_names: tuple[str, ...] = ()
        self.proposed: dict[str, float] = {}
        self.kept: dict[str, float] = {}
        self.slots: dict[str, GainValues] = {}
        self.before_slot: GainValues = {}
        self.linked = False
        self.shown_set: int | None = None
        self.follows = True
        self.warning = ""
        self.faults: dict[str, str] = {}
        self._told_refusal = ""
        self._flown.changed.connect(self._follow)
        self._flown.refused.connect(self._hear_refused)
        self._stability.accepted.connect(self.apply)
        self._stability.doubted.connect(self._warn)
        self._stability.ranges_changed.connect(self.ranges_changed)
        preferences.changed.connect(lambda _: self.state_changed.emit())

    def words(self, name: str) -> str:
        """Return a parameter's name in words."""
        return self.label(self.controller.table.find(name)).text

    def label(self, row: Parameter) -> GainLabel:
        """Return a row's label, by the firmware's name if the law is a firmware's."""
        return gain_label(row, firmware_of(self.controller))

    @property
    def flown(self) -> GainValues:
        """The flight's values of all rows."""
        return self._flown.values

    @property
    def start(self) -> GainValues:
        """Values of the flight's start."""
        return self._flown.start

    @property
    def ordered_gains(self) -> dict[str, float]:
        """The values for a gain file that fly or were ordered."""
        return {name: self._flown.ordered(name) for name in self.saved_names}

    @property
    def proposed_gains(self) -> dict[str, float]:
        """The proposed values for a gain file."""
        return {name: self.proposed[name] for name in self.saved_names}

    @property
    def schedule(self) -> GainSchedule | None:
        """Schedule of the gains of the flying controller."""
        return self.controller.schedule

    def of_set(self, values: GainValues) -> dict[str, float]:
        """Return values except those of sets of gains that are not shown."""
        schedule = self.schedule
        if schedule is None:
            return dict(values)
        shown = (None, self.shown_set)
        return {name: x for name, x in values.items() if schedule.number_of(name) in shown}

    def show_set(self, number: int | None) -> None:
        """Show and evaluate a set of scheduled gains; None to follow the one that flies."""
        self.follows = number is None
        if number is not None:
            self._show_set(number)

    def follow(self, snapshot: Snapshot) -> None:
        """Show the set that flies now, unless a slider is held or another set was chosen."""
        schedule, number = self.schedule, self.shown_set
        if schedule is None or number is None or not self.follows or self._edit != SEPARATE_EDIT:
            return
        value = self.scheduled_value(snapshot)
        nearest = schedule.nearest(value)
        gap = abs(schedule.values[nearest] - schedule.values[number])
        if abs(value - schedule.values[number]) > (0.5 + SET_SWITCH_HYSTERESIS) * gap:
            self._show_set(nearest)

    def schedule_gains(self, label: str) -> None:
        """Replace the flight's gains by sets of them; they start with the present values.

        Args:
            label: as `speed=0,4,8`, see `control.schedule`; "" to remove the sets.
        """
        name = with_label(split_label(self.controller.reference)[0], label)
        try:
            load_controller(name)
        except WorkbenchError as error:
            self._notices.warn(str(error))
            return
        self._flight.do(Action(controller=name))

    def scheduled_value(self, snapshot: Snapshot) -> float:
        """Return the scheduling quantity."""
        assert self.schedule is not None
        return self.schedule.value(
            height=snapshot.p_WB[2],
            velocity=snapshot.v_WB,
            payload=self.flown.get("known_payload_mass", 0.0),
            voltage=snapshot.voltage,
        )

    @property
    def velocity(self) -> tuple[float, float, float]:
        """Velocity of the trimmed flight that the shown set is for, in W [m/s]; 0 without one."""
        schedule, number = self.schedule, self.shown_set
        if schedule is None or number is None or schedule.quantity.name != "speed":
            return (0.0, 0.0, 0.0)
        return (schedule.values[number], 0.0, 0.0)

    def _show_set(self, number: int) -> None:
        if number == self.shown_set:
            return
        self.shown_set = number
        self._stability.begin(self.of_set(self.flown))
        self.set_changed.emit()

    @property
    def is_at_once(self) -> bool:
        """Whether proposed values fly at once, and not on Enter."""
        return self._preferences.text("apply_gains") == APPLY_AT_ONCE

    @property
    def unflown(self) -> tuple[str, ...]:
        """Names whose proposed values differ from the ordered or flown ones."""
        ordered = self._flown.ordered
        return tuple(name for name, value in self.proposed.items() if value != ordered(name))

    @property
    def tried(self) -> tuple[str, ...]:
        """Names of `saved_names` whose flown values differ from the kept ones."""
        ordered = self._flown.ordered
        return tuple(name for name, value in self.kept.items() if value != ordered(name))

    @property
    def next_undo(self) -> str:
        """The change that `undo` would take back, in words; "" for none."""
        return self._steps.undoText()

    @property
    def next_redo(self) -> str:
        """The change that `redo` would make again, in words; "" for none."""
        return self._steps.redoText()

    @property
    def has_fresh_ranges(self) -> bool:
        """Whether the stable ranges belong to the gains that fly."""
        return self._stability.has_ranges_of(self.of_set(self.flown))

    def stable_range(self, name: str) -> tuple[float, float] | None:
        """Return the stable range of a gain with the others fixed; None if unknown."""
        ranges = self._stability.ranges
        return ranges.get(name) if ranges else None

    def mark(self, name: str) -> GainMark:
        """Return a parameter's state: proposed, flown or kept."""
        ordered = self._flown.ordered(name)
        if self.proposed[name] != ordered:
            return GainMark.PROPOSED
        return GainMark.TRIED if self.kept.get(name, ordered) != ordered else GainMark.KEPT

    def summary(self) -> str:
        """Return whether the gains are kept, and the number of those that do not fly, in words."""
        proposed, tried = len(self.unflown), len(self.tried)
        parts = [f"{gain_count_text(tried)} not kept" if tried else "kept"]
        if proposed:
            parts.append(f"{gain_count_text(proposed)} proposed, not flown")
        return " · ".join(parts)

    def begin(self, view: LiveView) -> None:
        """Edit the gains of a flight that has begun, or restarted."""
        if view.vehicle is self._vehicle:
            self._flown.reset()
            return
        self._vehicle = view.vehicle
        self._flown.begin(view)
        self.controller = controller_or_default(view.controller)
        self.rows = flight_rows(view.values, self.controller.table)
        self.saved_names = tuple(row.name for row in self.rows if in_gain_file(row))
        self.shown_set, self.follows = (0 if self.schedule else None), True
        self.proposed = dict(view.values)
        self.kept = self.proposed_gains
        self._steps.clear()
        self.slots, self.before_slot = {}, {}
        self._stability.begin()
        self.faults.clear()
        self._clear_warning()
        self.begun.emit(view)
        self.state_changed.emit()

    def take_over(self, view: LiveView) -> None:
        """Edit the gains of a new controller that took over in flight.

        If its rows are the same, as after most edits of its file, proposed and kept values remain.
        """
        law = controller_or_default(view.controller)
        if flight_rows(view.values, law.table) != self.rows:
            self._vehicle = None
            self.begin(view)
            return
        self.controller, was_undecided = law, self._is_undecided
        self._stability.begin(self.of_set(self.flown))
        if was_undecided:
            self.apply()
        self.state_changed.emit()

    def find_ranges(self) -> None:
        """Find the stable ranges of the flown gains, for display."""
        self._stability.find_ranges(self.of_set(self.flown))

    def begin_edit(self) -> None:
        """Start one step of undo for all following proposals: a slider is held."""
        self._edits += 1
        self._edit = self._edits

    def end_edit(self) -> None:
        """End that step: the slider is released."""
        self._edit = SEPARATE_EDIT
        self.state_changed.emit()

    def propose(self, name: str, value: float) -> None:
        """Propose a value for a parameter, and for the one linked with it.

        It flies at once if the user prefers so and it is known to be stable; otherwise it is
        evaluated first.

        Args:
            name: name of the parameter.
            value: value in SI units; a value that the table refuses only leads to a message.
        """
        if name not in self.proposed:
            self.refuse(name, f"the flight does not have {name}: start a flight first")
            return
        try:
            value = self.controller.table.find(name).check(value)
        except WorkbenchError as error:
            self.refuse(name, str(error))
            return
        names = [name, linked_gain(name)] if self.linked and linked_gain(name) else [name]
        changed = self._put(dict.fromkeys(names, value), self.words(name))
        if self.is_at_once:
            self.apply()  # first, because showing it takes longer than ordering it
        else:
            self._clear_warning()  # the entered value is no longer the proposed one
        self._tell_proposed(changed)

    def refuse(self, name: str, said: str) -> None:
        """Note why an entered value of a parameter is refused, "" if the last one is not."""
        if self.faults.pop(name, "") == said == "":
            return
        if said:
            self.faults[name] = said
        self.value_refused.emit(name, said)

    def propose_all(self, values: GainValues, what: str) -> None:
        """Propose values of several parameters at once, as `propose` does for one.

        Args:
            values: values by name, within their limits, including those of linked parameters.
            what: name of the change, for undo.
        """
        known = {name: value for name, value in values.items() if name in self.proposed}
        changed = self._put(known, what)
        if self.is_at_once:
            self.apply()
        else:
            self._clear_warning()
        self._tell_proposed(changed)

    def adopt(self, values: GainValues, what: str) -> None:
        """Propose many values in one step whatever is preferred: a gain file, or a search's result.

        Args:
            values: values by name; the others stay.
            what: name of the change, for undo.

        Raises:
            WorkbenchError: if the table refuses one; then none is taken.
        """
        find = self.controller.table.find
        good = {name: find(name).check(value) for name, value in values.items()}
        self._edit = SEPARATE_EDIT
        changed = self._put({name: good[name] for name in good if name in self.proposed}, what)
        self.apply()
        self._tell_proposed(changed)

    def apply(self) -> None:
        """Fly proposed values once they are known to be stable."""
        self._told_refusal = ""
        is_known = self._is_known
        waiting = () if is_known else loop_gains(self.proposed)
        self._flown.order({n: self.proposed[n] for n in self.unflown if n not in waiting})
        if not is_known:
            self._stability.ask(self.of_set(self.proposed))
            return
        index = self._steps.index()
        while index and isinstance(step := self._steps.command(index - 1), GainStep):
            if step.flown:
                break
            step.flown = True
            index -= 1
        self._clear_warning()
        self.state_changed.emit()

    def confirm(self) -> None:
        """Fly proposed values in spite of the warning."""
        if self.warning:
            self._stability.accept(self.of_set(self.proposed))
            self.apply()

    def discard(self, names: Iterable[str] = ()) -> None:
        """Replace proposed values that do not fly by the flown ones.

        Args:
            names: some parameters; none for all.
        """
        chosen = tuple(names) or self.unflown
        self._edit = SEPARATE_EDIT
        changed = self._put(
            {name: self._flown.ordered(name) for name in chosen}, "back to what flies"
        )
        if not self.unflown:
            self._clear_warning()
        elif self._is_undecided:
            self.apply()
        self._tell_proposed(changed)

    def keep(self) -> None:
        """Keep the flown values: `revert` will restore them."""
        self.kept = self.ordered_gains
        self.end_edit()

    def revert(self) -> None:
        """Fly the kept values at once, without evaluation or delay.

        Every value is ordered, even if it already flies as far as is known here.
        """
        self._told_refusal = ""
        self._edit = SEPARATE_EDIT
        changed = self._put(self.kept, "revert", flown=True)
        self._flown.order_now(dict(self.kept))
        self._clear_warning()
        self._tell_proposed(changed)

    def undo(self) -> None:
        """Undo the last change, also in the flight if it was flown."""
        self._edit = SEPARATE_EDIT
        self._steps.undo()
        self.state_changed.emit()

    def redo(self) -> None:
        """Redo the last undone change."""
        self._steps.redo()
        self.state_changed.emit()

    def store(self, slot: str) -> None:
        """Store the proposed gains in a slot."""
        self.slots[slot] = self.proposed_gains
        self.before_slot = {}
        self.state_changed.emit()

    def compare(self, slot: str) -> None:
        """Fly the values of a slot; if they are already proposed, return to the ones before.

        From slot to slot, those before the first one stay. An empty slot takes the proposed ones.
        """
        present = self.proposed_gains
        is_own = present not in self.slots.values()
        if slot not in self.slots:
            self.store(slot)
        elif present != self.slots[slot]:
            self.before_slot = present if is_own or not self.before_slot else self.before_slot
            self.adopt(self.slots[slot], f"slot {slot}")
        elif self.before_slot:
            self.adopt(self.before_slot, f"back from slot {slot}")

    def set_linked(self, linked: bool) -> None:
        """Link or unlink gains of x and y for later changes; no value changes now."""
        self.linked = linked
        self.state_changed.emit()

    @property
    def _is_known(self) -> bool:
        """Whether the proposed values fly, were kept, or are within the stable ranges."""
        return (
            same_loops(self.proposed, self._flown.all_ordered)
            or self._stability.knows(self.of_set(self.proposed))
            or same_loops(self.proposed, self.proposed | self.kept)
        )

    @property
    def _is_undecided(self) -> bool:
        """Whether proposed gains are still being evaluated, or there is a warning."""
        return bool(self.warning) or self._stability.is_asking

    def _put(self, values: GainValues, what: str, flown: bool = False) -> list[str]:
        """Propose values as a step of undo; return the names of those that changed."""
        before = {name: self.proposed[name] for name in values}
        if before != dict(values):
            step = GainStep(self._restore, what, before, values, flown, self._edit)
            self._steps.push(step)
        return self._set(values)

    def _set(self, values: GainValues) -> list[str]:
        """Propose values; return the names of those that changed."""
        changed = [name for name, value in values.items() if self.proposed[name] != value]
        self.proposed.update(values)
        for name in values:
            self.refuse(name, "")
        return changed

    def _restore(self, values: GainValues, flown: bool) -> bool:
        """Propose values of the undo stack; fly them if they flew, or if all changes fly at once.

        Returns:
            Whether all proposed values fly.
        """
        changed = self._set({name: values[name] for name in values if name in self.proposed})
        if flown or self.is_at_once:
            self.apply()
        else:
            self._clear_warning()
        self._tell_proposed(changed)
        return not self.unflown

    def _tell_proposed(self, names: Iterable[str]) -> None:
        for name in names:
            self.proposed_changed.emit(name)
        self.state_changed.emit()

    def _hear_refused(self, values: GainValues, said: str) -> None:
        for name in values:
            self.refuse(name, said)
        if said != self._told_refusal:  # a broken flight refuses every order
            self._told_refusal = said
            name, *others = values
            stays = f"{name} stays at {gain_text(self.flown[name])}"
            whole = f"{stays}, and {len(others)} more as they are" if others else stays
            self._notices.warn(f"{whole}: {said}.")
        self.state_changed.emit()

    def _warn(self, said: str) -> None:
        self.warning = said
        self.warning_changed.emit(said)
        self.state_changed.emit()

    def _clear_warning(self) -> None:
        self._stability.cancel()
        if self.warning:
            self.warning = ""
            self.warning_changed.emit("")

    def _follow(self, before: GainValues) -> None:
        """Show the flight's present values; values that are being tried stay proposed.

        What scripts, clients and joysticks do to wind, servos or faults is not to be undone.
        """
        changed = {name: value for name, value in self.flown.items() if value != before[name]}
        free = [name for name in changed if not self._flown.is_ordered(name)]
        shown = {name: changed[name] for name in free if self.proposed[name] == before[name]}
        if shown:
            gains = {name: value for name, value in shown.items() if name in self.kept}
            self._tell_proposed(self._put(gains, EXTERNAL_CHANGE, flown=True) + self._set(shown))
        if loop_gains(shown) and self._is_undecided:
            self.apply()  # the evaluation and the warning have changed with it
        self.flown_changed.emit(changed)
        if loop_gains(changed):
            self.find_ranges()
            self.ranges_changed.emit()
        self.state_changed.emit()
