"""The gains that are being tuned: proposed, flown and kept values."""

import math
from collections import deque
from collections.abc import Callable, Iterable, Mapping
from enum import Enum
from typing import Any

from PyQt6.QtCore import QObject, pyqtSignal
from PyQt6.QtGui import QUndoCommand, QUndoStack

from workbench.analysis.questions import FindRanges, Judge, Question
from workbench.analysis.replies import Judged
from workbench.common.errors import WorkbenchError
from workbench.control.controller import load_controller
from workbench.control.schedule import Schedule, split_label, with_label
from workbench.gains.autopilots.firmware import firmware_of
from workbench.gui.analysis import Analysis
from workbench.gui.errands import single_shot
from workbench.gui.flight_model import FlightModel
from workbench.gui.gains.gain_rows import (
    GainLabel,
    controller_gains,
    flight_rows,
    gain_label,
    in_gain_file,
    loop_gains,
    partner,
)
from workbench.gui.notices import Notices
from workbench.gui.preferences import Preferences
from workbench.gui.signals import parameter_changes
from workbench.link.backplane import Published
from workbench.live.view import LiveView
from workbench.scenario.parameters import Parameter, parameter_table
from workbench.scenario.scenario import Action
from workbench.session.snapshot import Snapshot

PATIENCE = 1500
"""Delay before the screen says that there is no answer yet [ms]; it may still arrive."""
MOST_ASKED = 20
"""Number of earlier questions whose late answers are recognised."""
RANGES_AFTER = 300
"""Ask for ranges when gains have not changed for this time [ms]."""
AT_ONCE = "at once"
MOST_STEPS = 500
"""Limit of undo steps; beyond it the oldest is dropped."""
SLOTS = ("A", "B", "C")
"""Slots for sets of gains, each compared by one key."""
ELSEWHERE = "a change from elsewhere"
STAYS = 0.1
"""A set stays shown until another is closer by this share of the distance between them."""
ALONE = -1
"""Edit number of a change that is a step of undo by itself."""
_SAME_TIME = 1e-6
"""Times that differ by less are those of one step [s]."""
_JUST_BEGUN = 1.0
"""Time within which a reset is noticed [s]."""
_LATER = 0.05
"""Delay after which values set by a script are read [s]: it acts at the next whole step."""
Values = Mapping[str, float]


class FlownGains(QObject):
    """The flight's values of the live parameters.

    Published values count, in order; the answer to an order is only earlier. Values changed by the
    flight's own script are read from the flight.

    Args:
        flight: gets the orders.
        parent: the Qt parent.

    Attributes:
        start: values of the flight's start, by name.
        values: the values now.
    """

    changed = pyqtSignal(object)
    """Values changed; the signal has those before, by name."""
    refused = pyqtSignal(object, str)
    """Refused values by name, and the reason."""

    def __init__(self, flight: FlightModel, parent: QObject | None = None) -> None:
        super().__init__(parent)
        self._flight = flight
        self.start: dict[str, float] = {}
        self.values: dict[str, float] = {}
        self._published: dict[str, float] = {}  # time at which a value was last published [s]
        self._time = 0.0
        self._orders = self._first_order = 0
        self._unanswered: dict[str, tuple[int, float]] = {}  # number and value of the newest order
        self._waiting: dict[str, float] = {}
        self._scripted: list[tuple[float, tuple[str, ...]]] = []
        self._script_time = 0.0
        flight.streamed.connect(self._hear)
        flight.viewed.connect(self._watch_script)

    def begin(self, view: LiveView) -> None:
        """Start with the values of a new flight; orders to the last one no longer count."""
        self.start, self.values = dict(view.values), dict(view.values)
        self._published, self._time = {}, 0.0
        self._first_order = self._orders + 1
        self._unanswered, self._waiting = {}, {}
        script = view.scenario.script if view.scenario else ()
        acts = [(action.at + _LATER, _changed_names(action)) for action in script]
        self._scripted, self._script_time = [each for each in acts if each[1]], 0.0

    def reset(self) -> None:
        """Restore the initial values, except those published since the reset."""
        before = dict(self.values)
        published = self._published if self._time < _JUST_BEGUN else {}
        self.values = self.start | {name: self.values[name] for name in published}
        self._tell(before)

    def is_ordered(self, name: str) -> bool:
        """Return whether an order for a parameter is unanswered."""
        return name in self._waiting or name in self._unanswered

    def ordered(self, name: str) -> float:
        """Return the value of the newest unanswered order, or else the flown one."""
        if name in self._waiting:
            return self._waiting[name]
        return self._unanswered[name][1] if name in self._unanswered else self.values[name]

    @property
    def all_ordered(self) -> dict[str, float]:
        """`ordered` of every parameter."""
        return {name: self.ordered(name) for name in self.values}

    def order(self, values: Values) -> None:
        """Order values, all for one step.

        While an order for one of them is unanswered they wait, and later sets with them; of each
        parameter the newest value is sent then, so that no drag floods the flight.
        """
        if any(map(self.is_ordered, values)):
            self._waiting |= values
        elif values:
            self._orders += 1
            number = self._orders
            self._unanswered |= {name: (number, value) for name, value in values.items()}
            self._flight.order(
                lambda live: live.set_all(values),
                done=lambda time: self._answered(number, values, time, ""),
                refused=lambda said: self._answered(number, values, 0.0, said),
            )

    def order_now(self, values: Values) -> None:
        """Order values at once, whatever happened to earlier orders."""
        for name in values:
            self._waiting.pop(name, None)
            self._unanswered.pop(name, None)
        self.order(values)

    def _answered(self, number: int, values: Values, time: float, said: str) -> None:
        if number < self._first_order:
            return  # of an earlier flight
        for name in values:
            if name in self._unanswered and self._unanswered[name][0] == number:
                del self._unanswered[name]
        waiting, self._waiting = self._waiting, {}
        self.order(waiting)
        if said:
            self.refused.emit(values, said)
        else:
            self._confirm(values, time)

    def _confirm(self, values: Values, time: float) -> None:
        """Accept values that fly from a simulated time [s] on, unless later ones were published."""
        before = dict(self.values)
        for name, value in values.items():
            if name in self.values and self._published.get(name, -1.0) < time - _SAME_TIME:
                self.values[name] = value
        self._tell(before)

    def _hear(self, published: Iterable[Published]) -> None:
        before = dict(self.values)
        for each in published:
            time = each.t_ns * 1e-9
            if time < self._time - _SAME_TIME:  # the flight restarted
                self._published = {}
            self._time = time
            for _, name, value in parameter_changes((each,)):
                if name in self.values:
                    self.values[name] = value
                    self._published[name] = time
        self._tell(before)

    def _tell(self, before: Values) -> None:
        if before != self.values:
            self.changed.emit(before)

    def _watch_script(self, view: LiveView) -> None:
        """Read the values that the flight's script has changed, as the flight publishes none."""
        if not self._scripted or view.snapshot is None:
            return
        before, self._script_time = self._script_time, view.snapshot.time
        for at, names in self._scripted:
            if before < at <= self._script_time:
                for name in names:
                    self._ask(name)

    def _ask(self, name: str) -> None:
        self._flight.order(
            lambda live: live.get(name),
            done=lambda value: self._confirm({name: value}, math.inf),  # still the present flight
        )


def _changed_names(action: Action) -> tuple[str, ...]:
    """Return the names of all parameters that an action of a script changes."""
    kinds = [kind for kind in ("gust", "push") if getattr(action, kind) is not None]
    blown = [
        row.name for row in parameter_table() for kind in kinds if row.name.startswith(f"{kind}_")
    ]
    return (*action.set, *blown)


class StabilityCheck(QObject):
    """Knows which gains are stable, or asks.

    Args:
        analysis: answers the questions.
        start: returns the initial values, for answers that name only differences.
        parent: the Qt parent.

    Attributes:
        ranges: the stable range of each gain by name; None if unknown.
    """

    accepted = pyqtSignal()
    """The gains in the question are stable."""
    doubted = pyqtSignal(str)
    """They are unstable, or their stability is unknown: a sentence. They may still be accepted
    later."""
    ranges_changed = pyqtSignal()
    """The ranges changed."""

    def __init__(
        self, analysis: Analysis, start: Callable[[], Values], parent: QObject | None = None
    ) -> None:
        super().__init__(parent)
        self._analysis, self._start = analysis, start
        self._asked: Values | None = None
        self._asked_before: deque[Values] = deque(maxlen=MOST_ASKED)
        self._range_gains: Values = {}
        self._base: Values = {}
        self.ranges: Mapping[str, tuple[float, float]] | None = None
        self._patience = single_shot(self._tell_late, self, PATIENCE)
        self._rest = single_shot(self._ask_for_ranges, self, RANGES_AFTER)
        analysis.answered.connect(self._hear)
        analysis.refused.connect(self._hear_refused)

    @property
    def is_asking(self) -> bool:
        """Whether an answer is pending."""
        return self._asked is not None

    def begin(self) -> None:
        """Clear everything: another vehicle flies."""
        self.cancel()
        self._rest.stop()
        self.ranges = None
        self.ranges_changed.emit()

    def knows(self, gains: Values) -> bool:
        """Return whether gains are stable by the ranges, without asking.

        A range describes the change of a single gain. If several have moved, each by a share of the
        way to the end of its range, they are stable for certain only if the shares add up to at
        most 1: the region between the ends that cuts the corners, not the box around them.
        """
        if self.ranges is None:
            return False
        used = 0.0
        for name, value in loop_gains(gains).items():
            if name not in self._base:
                return False
            used += _share(value, self._base[name], self.ranges.get(name))
        return used <= 1.0

    def has_ranges_of(self, gains: Values) -> bool:
        """Return whether the ranges were found around these gains."""
        return self.ranges is not None and _has_loops(self._base, gains)

    def ask(self, gains: Values) -> None:
        """Ask about gains; answers about earlier ones no longer count."""
        if self._asked is not None:
            self._asked_before.append(self._asked)
        self._asked = controller_gains(gains)
        self._patience.start()
        self._analysis.ask(Judge(self._asked))

    def cancel(self) -> None:
        """Drop the question."""
        self._asked = None
        self._patience.stop()

    def find_ranges(self, gains: Values) -> None:
        """Find the ranges around gains, once they have not changed for a while."""
        self._range_gains = controller_gains(gains)
        self._rest.start()

    def _ask_for_ranges(self) -> None:
        if self._range_gains and not self.has_ranges_of(self._range_gains):
            self._analysis.ask(FindRanges(self._range_gains))

    def _hear(self, question: Question, reply: Any) -> None:
        if isinstance(question, Judge):
            self._hear_judged(question, reply)
        elif isinstance(question, FindRanges):
            self._base, self.ranges = {**self._start(), **question.gains}, reply
            self.ranges_changed.emit()

    def _hear_judged(self, question: Judge, judged: Judged) -> None:
        if self._asked is None:
            return
        gains = {**self._start(), **question.gains}
        if not _has_loops(gains, self._asked):
            if not any(_has_loops(gains, ours) for ours in self._asked_before):
                self._analysis.ask(Judge(self._asked))  # another question has displaced ours
            return
        self.cancel()
        if judged.stable:
            self.accepted.emit()
        else:
            self.doubted.emit(judged.said or "the closed loop would be unstable")

    def _hear_refused(self, question: Question, said: str) -> None:
        if isinstance(question, Judge) and self._asked is not None:
            self.cancel()
            self.doubted.emit(f"whether this is stable could not be judged, because {said}")

    def _tell_late(self) -> None:
        if self._asked is not None:
            self.doubted.emit(
                "whether this is stable is not known yet: the analyst is starting, or busy"
            )


def same_loops(a: Values, b: Values) -> bool:
    """Return whether two sets of values give the same loops near hover."""
    return loop_gains(a) == loop_gains(b)


def _has_loops(values: Values, gains: Values) -> bool:
    """Return whether values include all that affects the loops near hover."""
    return all(values.get(name) == value for name, value in loop_gains(gains).items())


def _share(value: float, base: float, stable: tuple[float, float] | None) -> float:
    """Return a gain's share of the way to the end of its range, 0 .. 1; inf beyond it."""
    if value == base:
        return 0.0 if stable is None or stable[0] <= base <= stable[1] else float("inf")
    if stable is None:
        return float("inf")
    low, high = stable
    if not (low <= base <= high and low <= value <= high):
        return float("inf")
    return (value - base) / ((high if value > base else low) - base)


class Mark(Enum):
    """State of a parameter, in words."""

    KEPT = "kept"
    TRIED = "tried, not kept"
    PROPOSED = "proposed, not flown"


class GainStep(QUndoCommand):
    """A change of proposed values, as one step of undo; it is already made when it is pushed.

    Args:
        restore: proposes values, flies them if told to, and returns whether they fly.
        what: the change in words, as "Speed x".
        before: values before, by name.
        after: values after, of the same names.
        flown: whether it has reached the flight.
        edit: changes of the same gains with the same number are one step, `ALONE` for none.
    """

    def __init__(
        self,
        restore: Callable[[Values, bool], bool],
        what: str,
        before: Values,
        after: Values,
        flown: bool,
        edit: int,
    ) -> None:
        super().__init__(what)
        self._restore, self._edit = restore, edit
        self._before, self._after = dict(before), dict(after)
        self.flown = flown
        self._is_new = True

    def id(self) -> int:
        return self._edit

    def mergeWith(self, other: QUndoCommand | None) -> bool:
        """Merge a later change of the same edit; a step without an effect is removed."""
        if not isinstance(other, GainStep) or other.text() != self.text():
            return False
        if other._before.keys() != self._before.keys():
            return False
        self._after, self.flown = other._after, other.flown
        self.setObsolete(self._before == self._after)
        return True

    def undo(self) -> None:
        flown = self.flown
        self._restore(self._before, flown)
        self.flown = flown  # this step does not, whatever flies now

    def redo(self) -> None:
        if self._is_new:
            self._is_new = False
        else:
            self.flown = self._restore(self._after, self.flown) or self.flown


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
        linked: whether gains of x and y change together.
        shown_set: the shown and evaluated set of scheduled gains; None without a schedule.
        follows: whether that is the set that flies, or has the largest weight.
        warning: why proposed values do not fly without `confirm`, as a sentence; "" if they fly.
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
        self._steps.setUndoLimit(MOST_STEPS)
        self._edits, self._edit = 0, ALONE
        self._vehicle: object = None
        self.table = parameter_table()
        self.rows: tuple[Parameter, ...] = ()
        self.saved_names: tuple[str, ...] = ()
        self.proposed: dict[str, float] = {}
        self.kept: dict[str, float] = {}
        self.slots: dict[str, Values] = {}
        self._compared: Values = {}  # proposed before a slot was recalled
        self.linked = False
        self.shown_set: int | None = None
        self.follows = True
        self.warning = ""
        self._refused: set[str] = set()
        self._told_refusal = ""
        self._flown.changed.connect(self._follow)
        self._flown.refused.connect(self._hear_refused)
        self._stability.accepted.connect(self._fly)
        self._stability.doubted.connect(self._warn)
        self._stability.ranges_changed.connect(self.ranges_changed)
        preferences.changed.connect(lambda _: self.state_changed.emit())

    def words(self, name: str) -> str:
        """Return a parameter's name in words."""
        return self.label(self.table.find(name)).text

    def label(self, row: Parameter) -> GainLabel:
        """Return a row's label, by the firmware's name if the law is a firmware's."""
        return gain_label(row, firmware_of(self.table.controller))

    @property
    def flown(self) -> Values:
        """The flight's values of all rows."""
        return self._flown.values

    @property
    def start(self) -> Values:
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
    def schedule(self) -> Schedule | None:
        """Schedule of the gains of the flying controller."""
        return self.table.controller.schedule

    def of_set(self, values: Values) -> dict[str, float]:
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
        if schedule is None or number is None or not self.follows or self._edit != ALONE:
            return
        value = self.scheduled_value(snapshot)
        nearest = schedule.nearest(value)
        gap = abs(schedule.values[nearest] - schedule.values[number])
        if abs(value - schedule.values[number]) > (0.5 + STAYS) * gap:
            self._show_set(nearest)

    def schedule_gains(self, label: str) -> None:
        """Replace the flight's gains by sets of them; they start with the present values.

        Args:
            label: as `speed=0,4,8`, see `control.schedule`; "" to remove the sets.
        """
        name = with_label(split_label(self.table.controller.reference)[0], label)
        try:
            load_controller(name)
        except WorkbenchError as error:
            self._notices.warn(str(error))
            return
        self._flight.order(lambda live: live.fly_controller(name))

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
        self._stability.begin()
        self.find_ranges()
        self.set_changed.emit()

    @property
    def is_at_once(self) -> bool:
        """Whether proposed values fly at once, and not on Enter."""
        return self._preferences.text("apply_gains") == AT_ONCE

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

    def mark(self, name: str) -> Mark:
        """Return a parameter's state: proposed, flown or kept."""
        ordered = self._flown.ordered(name)
        if self.proposed[name] != ordered:
            return Mark.PROPOSED
        return Mark.TRIED if self.kept.get(name, ordered) != ordered else Mark.KEPT

    def summary(self) -> str:
        """Return the numbers of proposed, tried and kept gains, in words."""
        if not self.rows:
            return "Nothing flies"
        proposed, tried = len(self.unflown), len(self.tried)
        parts = []
        if proposed:
            parts.append(f"{_count(proposed)} proposed, not flown")
        if tried:
            parts.append(f"{_count(tried)} tried, not kept")
        return "; ".join(parts) or "Flown = kept"

    def begin(self, view: LiveView) -> None:
        """Edit the gains of a flight that has begun, or restarted."""
        if view.vehicle is self._vehicle:
            self._flown.reset()
            return
        self._vehicle = view.vehicle
        self._flown.begin(view)
        self.table = parameter_table(view.controller)
        self.rows = flight_rows(view.values, self.table)
        self.saved_names = tuple(row.name for row in self.rows if in_gain_file(row))
        self.shown_set, self.follows = (0 if self.schedule else None), True
        self.proposed = dict(view.values)
        self.kept = self.proposed_gains
        self._steps.clear()
        self.slots, self._compared = {}, {}
        self._stability.begin()
        self._refused.clear()
        self._clear_warning()
        self.begun.emit(view)
        self.state_changed.emit()

    def take_over(self, view: LiveView) -> None:
        """Edit the gains of a new controller that took over in flight.

        If its rows are the same, as after most edits of its file, proposed and kept values remain.
        """
        table = parameter_table(view.controller)
        if flight_rows(view.values, table) != self.rows:
            self._vehicle = None
            self.begin(view)
            return
        self.table = table
        self._stability.begin()
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
        self._edit = ALONE
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
            self._refuse(name, f"the flight does not have {name}: start a flight first")
            return
        row = self.table.find(name)
        try:
            value = row.check(value)
        except WorkbenchError as error:
            self._refuse(name, str(error))
            return
        names = [name, partner(name)] if self.linked and partner(name) else [name]
        changed = self._put(dict.fromkeys(names, value), self.words(name))
        if self.is_at_once:
            self.apply()  # first, because showing it takes longer than ordering it
        else:
            self._clear_warning()  # the entered value is no longer the proposed one
        self._tell_proposed(changed)

    def propose_all(self, values: Values, what: str) -> None:
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

    def adopt(self, values: Values, what: str) -> None:
        """Propose many values in one step whatever is preferred: a gain file, or a search's result.

        Args:
            values: values by name; the others stay.
            what: name of the change, for undo.

        Raises:
            WorkbenchError: if the table refuses one; then none is taken.
        """
        good = {name: self.table.find(name).check(value) for name, value in values.items()}
        self._edit = ALONE
        changed = self._put({name: good[name] for name in good if name in self.proposed}, what)
        self.apply()
        self._tell_proposed(changed)

    def apply(self) -> None:
        """Fly proposed values once they are known to be stable."""
        self._told_refusal = ""
        if self._is_known:
            self._fly()
        else:
            loops = loop_gains(self.proposed)
            rest = [name for name in self.unflown if name not in loops]
            self._flown.order({name: self.proposed[name] for name in rest})
            self._stability.ask(self.of_set(self.proposed))

    def confirm(self) -> None:
        """Fly proposed values in spite of the warning."""
        if self.warning:
            self._fly()

    def discard(self, names: Iterable[str] = ()) -> None:
        """Replace proposed values that do not fly by the flown ones.

        Args:
            names: some parameters; none for all.
        """
        chosen = tuple(names) or self.unflown
        self._edit = ALONE
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
        self._edit = ALONE
        changed = self._put(self.kept, "revert", flown=True)
        self._flown.order_now(dict(self.kept))
        self._clear_warning()
        self._tell_proposed(changed)

    def undo(self) -> None:
        """Undo the last change, also in the flight if it was flown."""
        self._edit = ALONE
        self._steps.undo()
        self.state_changed.emit()

    def redo(self) -> None:
        """Redo the last undone change."""
        self._steps.redo()
        self.state_changed.emit()

    def store(self, slot: str) -> None:
        """Store the proposed gains in a slot."""
        self.slots[slot] = self.proposed_gains
        self._compared = {}
        self.state_changed.emit()

    def compare(self, slot: str) -> None:
        """Fly the values of a slot; if they are already proposed, return to the ones before.

        So one key compares the slot with the present. An empty slot takes the proposed values.
        """
        present = self.proposed_gains
        if slot not in self.slots:
            self.store(slot)
        elif present != self.slots[slot]:
            self._compared = present
            self.adopt(self.slots[slot], f"slot {slot}")
        elif self._compared:
            self.adopt(self._compared, f"back from slot {slot}")

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

    def _fly(self) -> None:
        self._flown.order({name: self.proposed[name] for name in self.unflown})
        index = self._steps.index()
        while index and isinstance(step := self._steps.command(index - 1), GainStep):
            if step.flown:
                break
            step.flown = True
            index -= 1
        self._clear_warning()
        self.state_changed.emit()

    def _put(self, values: Values, what: str, flown: bool = False) -> list[str]:
        """Propose values as a step of undo; return the names of those that changed."""
        before = {name: self.proposed[name] for name in values}
        if before != dict(values):
            step = GainStep(self._restore, what, before, values, flown, self._edit)
            self._steps.push(step)
        return self._set(values)

    def _set(self, values: Values) -> list[str]:
        """Propose values; return the names of those that changed."""
        changed = [name for name, value in values.items() if self.proposed[name] != value]
        self.proposed.update(values)
        for name in self._refused.intersection(values):
            self._refused.discard(name)
            self.value_refused.emit(name, "")
        return changed

    def _restore(self, values: Values, flown: bool) -> bool:
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

    def _refuse(self, name: str, said: str) -> None:
        self._refused.add(name)
        self.value_refused.emit(name, said)

    def _hear_refused(self, values: Values, said: str) -> None:
        for name in values:
            self._refuse(name, said)
        if said != self._told_refusal:  # a broken flight refuses every order
            self._told_refusal = said
            name, *others = values
            stays = f"{name} stays at {self.flown[name]:g}"
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

    def _follow(self, before: Values) -> None:
        """Show the flight's present values; values that are being tried stay proposed."""
        changed = {name: value for name, value in self.flown.items() if value != before[name]}
        shown = {
            name: value
            for name, value in changed.items()
            if not self._flown.is_ordered(name) and self.proposed[name] == before[name]
        }
        if shown:
            self._tell_proposed(self._put(shown, ELSEWHERE, flown=True))
        if loop_gains(shown) and self._is_undecided:
            self.apply()  # the evaluation and the warning have changed with it
        self.flown_changed.emit(changed)
        if loop_gains(changed):
            self.find_ranges()
            self.ranges_changed.emit()
        self.state_changed.emit()


def _count(number: int) -> str:
    return "1 gain" if number == 1 else f"{number} gains"
