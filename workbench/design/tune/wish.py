"""A wish: a metric of an axis, of a loop or of the rotors, and its bound.

A wish file (YAML) has wishes, their steps, and the uncertainty of the vehicle.
"""

import math
import re
from collections.abc import Sequence
from dataclasses import dataclass, field
from pathlib import Path

from workbench.common.errors import WorkbenchError, unknown_name
from workbench.common.yaml_files import as_record, check_schema, read_yaml, with_numbers
from workbench.control.controller import Controller
from workbench.control.controller_file import controller_or_default, load_controller
from workbench.control.installed_laws import DEFAULT_CONTROLLER as DEFAULT_LAW
from workbench.design.metrics import (
    LOOP_KIND,
    ROTORS_KIND,
    STEP_KIND,
    WISHED_METRICS,
    Metric,
    find_metric,
    si_value,
)
from workbench.design.step_response import USUAL_STEPS
from workbench.design.tune.case import Robustness
from workbench.scenario.axes import AXIS_NAMES

DEFAULT_ORIGIN = "default"
"""The origin of a default wish."""
GUARD_ORIGIN = "guard"
"""The origin of a wish that guards a loop without a written wish."""
ATTITUDE_SUBJECTS = ("roll", "pitch")
"""Angles that can have steps, in addition to the axes."""
ATTITUDE_METRICS = ("rise_time", "settling_time", "overshoot")
"""Metrics of such a step; it is not flown, and so has no rotor use."""
_DAMPING_LOOPS = {"roll_rate": "roll", "pitch_rate": "pitch"}
"""Loops that only some laws have, and the loops that provide the damping in others."""
SUBJECT_GROUPS = {"level": ("x", "y"), "tilt": ("roll", "pitch")}
"""Names for several subjects at once."""
_ROBUSTNESS_LIMITS = {"margin_share": (0.0, 1.0), "overshoot_factor": (1.0, 100.0)}
"""Limits of the numbers of `Robustness`; those of shares of the vehicle are 0 and 0.9."""

_WISH_PATTERN = re.compile(
    r"(?P<subject>\w+)\s*\.\s*(?P<metric>\w+)\s*(?P<sign><=|>=|≤|≥|<|>)"
    r"\s*(?P<number>[-+]?[\d.]+(?:[eE][-+]?\d+)?)\s*(?P<unit>[A-Za-z%°]\S*)?"
)


@dataclass(frozen=True)
class Wish:
    """One bound on one number.

    Attributes:
        subject: an axis, a loop, or "rotors".
        metric: its name.
        at_least: whether the bound is the smallest value allowed, else the largest.
        bound: in the unit of the metric.
        origin: its source, or `DEFAULT_ORIGIN`.
    """

    subject: str
    metric: Metric
    at_least: bool
    bound: float
    origin: str = DEFAULT_ORIGIN

    @property
    def name(self) -> str:
        """Name of the bounded number, such as x.rise_time."""
        return f"{self.subject}.{self.metric.name}"

    @property
    def file_name(self) -> str:
        """The same in files and JSON, such as pitch.phase_margin_deg."""
        return f"{self.subject}.{self.metric.file_name}"

    @property
    def is_flown(self) -> bool:
        """Whether it is about a flown step; that of an attitude is by the linear model."""
        return self.metric.kind == STEP_KIND and self.subject in AXIS_NAMES

    @property
    def is_written(self) -> bool:
        """Whether it was written by the user."""
        return self.origin not in (DEFAULT_ORIGIN, GUARD_ORIGIN)

    @property
    def key(self) -> tuple[str, bool]:
        """The key of the number bounded, on which two wishes must not contradict."""
        return self.name, self.at_least

    def __str__(self) -> str:
        return f"{self.name} {'>=' if self.at_least else '<='} {self.metric.text(self.bound)}"


def parse_wish(text: str, origin: str = "--wish", law: Controller | None = None) -> list[Wish]:
    """Return the wishes for a text such as `x.rise_time <= 0.4 s`, one for each subject.

    Args:
        text: of the form above.
        origin: its source.
        law: with the loops; None for the default one.

    Raises:
        WorkbenchError: if it is not of that form, or names something unknown.
    """
    form = _WISH_PATTERN.fullmatch(text.strip())
    if not form:
        raise WorkbenchError(
            f"'{text[:60]}' is not a wish: write SUBJECT.METRIC<=VALUE or >=, as x.rise_time<=0.4 "
            "or pitch.phase_margin>=45deg"
        )
    metric = find_metric(form["metric"], WISHED_METRICS)
    subjects = group_members(form["subject"], metric, controller_or_default(law))
    try:
        number = float(form["number"])
    except ValueError:
        raise WorkbenchError(f"'{text[:60]}': {form['number'][:20]} is not a number") from None
    own_unit = metric.file_unit if form["metric"] != metric.name else ""
    bound = si_value(metric, number, form["unit"] or own_unit)
    at_least = form["sign"] in (">=", "≥", ">")
    return [Wish(subject, metric, at_least, bound, origin) for subject in subjects]


def merged_wishes(wishes: Sequence[Wish]) -> list[Wish]:
    """Return wishes with each bound once; the last one counts.

    Raises:
        WorkbenchError: if two contradict each other.
    """
    found = {wish.key: wish for wish in wishes}
    for (name, at_least), wish in found.items():
        other = found.get((name, not at_least))
        if at_least and other and wish.bound > other.bound:
            raise WorkbenchError(f"{wish} contradicts {other}: both cannot be met, so drop one")
    return list(found.values())


def subjects_of(metric: Metric, law: Controller) -> tuple[str, ...]:
    """Return the axes, angles, loops, loop points or rotors with a metric.

    A loop is cut at its actuator, or at the named loop point.
    """
    if metric.kind == ROTORS_KIND:
        return ("rotors",)
    loops = [loop.name for loop in law.loops]
    if metric.kind == LOOP_KIND:
        return (*loops, *law.points)
    angles = ATTITUDE_SUBJECTS if metric.name in ATTITUDE_METRICS else ()
    return (*AXIS_NAMES, *(angle for angle in angles if angle in loops))


def groups_of(metric: Metric, law: Controller) -> tuple[str, ...]:
    """Return the names of groups of subjects with a metric."""
    known = subjects_of(metric, law)
    return tuple(group for group, each in SUBJECT_GROUPS.items() if set(each) <= set(known))


def group_members(name: str, metric: Metric, law: Controller) -> tuple[str, ...]:
    """Return the subjects for a name that have a metric.

    Raises:
        WorkbenchError: if there are none; it lists those that have it.
    """
    known, groups = subjects_of(metric, law), groups_of(metric, law)
    if name in known:
        return (name,)
    if name in groups:
        return SUBJECT_GROUPS[name]
    loops = [loop.name for loop in law.loops]
    if name in (*AXIS_NAMES, *SUBJECT_GROUPS, *loops, *law.points, "rotors"):
        listed = ", ".join((*known, *groups))
        raise WorkbenchError(f"{name} has no {metric.name}: that is of {listed}")
    if _DAMPING_LOOPS.get(name) in loops:
        loop = _DAMPING_LOOPS[name]
        raise WorkbenchError(
            f"{law.name} has no loop {name}: it damps the rate in the loop {loop}: use "
            f"{loop}.{metric.name}"
        )
    kind = {STEP_KIND: "axis", LOOP_KIND: "loop", ROTORS_KIND: "subject"}[metric.kind]
    raise unknown_name(kind, name, (*known, *groups))


@dataclass(frozen=True)
class Wishes:
    """Wishes, with steps and robustness.

    Attributes:
        wishes: a bound each; `defaults` adds those of any good flight.
        steps: amplitude of the step that each axis flies [m/s, rad/s].
        robustness: the variations of the vehicle to meet them.
        defaults: whether to add the wishes that follow from the vehicle.
    """

    wishes: tuple[Wish, ...] = ()
    steps: tuple[tuple[str, float], ...] = USUAL_STEPS
    robustness: Robustness = Robustness()
    defaults: bool = True


def wishes_for(*texts: str, defaults: bool = True, controller: str | Path = DEFAULT_LAW) -> Wishes:
    """Return wishes from texts such as `x.rise_time <= 0.4 s`.

    Args:
        texts: with a wish each.
        defaults: whether to add the wishes that follow from the vehicle.
        controller: with the loops, see `load_controller`.

    Raises:
        WorkbenchError: if one is invalid, or two contradict each other.
    """
    law = load_controller(controller)
    wishes = [wish for text in texts for wish in parse_wish(text, "asked", law)]
    return Wishes(wishes=tuple(merged_wishes(wishes)), defaults=defaults)


@dataclass
class _WishFile:
    """The schema of a wish file."""

    wishes: list[str] = field(default_factory=list)
    steps: dict[str, float] = field(default_factory=dict)
    robustness: Robustness = field(default_factory=Robustness)
    defaults: bool = True


def load_wishes(path: Path | str, law: Controller | None = None) -> Wishes:
    """Read and check a wish file.

    Args:
        path: of the file.
        law: with the loops; None for the default one.

    Raises:
        WorkbenchError: with file and line of the error.
    """
    file = read_yaml(Path(path))
    check_schema(file, _WishFile)
    words: _WishFile = as_record(with_numbers(file, _WishFile).data, _WishFile)
    wishes: list[Wish] = []
    for index, text in enumerate(words.wishes):
        where = file.where("wishes", index)
        try:
            wishes += parse_wish(text, where.rstrip(": "), law)
        except WorkbenchError as error:
            raise WorkbenchError(f"{where}{error}") from None
    try:
        kept = tuple(merged_wishes(wishes))
    except WorkbenchError as error:
        raise WorkbenchError(f"{file.where('wishes')}{error}") from None
    for axis, amplitude in words.steps.items():
        if axis not in AXIS_NAMES:
            raise WorkbenchError(
                f"{file.where('steps', axis)}{unknown_name('axis', axis, AXIS_NAMES)}"
            )
        if not 0.0 < abs(amplitude) < math.inf:
            raise WorkbenchError(
                f"{file.where('steps', axis)}the step along {axis} is {amplitude:g}: give it a "
                "finite number, and not 0"
            )
    for name, value in vars(words.robustness).items():
        low, high = _ROBUSTNESS_LIMITS.get(name, (0.0, 0.9))
        if not low <= value <= high:
            raise WorkbenchError(
                f"{file.where('robustness', name)}{name} is {value:g}: keep it within "
                f"{low:g} .. {high:g}"
            )
    steps = tuple({**dict(USUAL_STEPS), **words.steps}.items())
    return Wishes(kept, steps, words.robustness, words.defaults)
