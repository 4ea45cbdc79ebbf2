"""The step that every candidate of a sweep flies, the candidates, and the results of flights."""

import dataclasses
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from workbench.common.errors import WorkbenchError, unknown_name
from workbench.control.controller import Controller
from workbench.control.controller_file import controller_or_default
from workbench.design.metrics import FLOWN_METRICS
from workbench.design.step_response import check_duration, check_step
from workbench.design.sweep.ranges import SEED_NAME, VARIATION_PREFIX, SweepRange
from workbench.estimation.settings import COMPLEMENTARY, EKF, TRUTH
from workbench.parameters.parameter_table import check_parameters
from workbench.plant.variation import Variation
from workbench.scenario.axes import AXIS_NAMES, find_axis
from workbench.scenario.flown_controller import flown_controller
from workbench.scenario.scenario import Scenario

if TYPE_CHECKING:
    from workbench.setup import Setup

_PARAMETER_AXES = {
    "max_tilt": "x",
    "max_speed": "x",
    "max_climb_rate": "z",
    "max_yaw_rate": "yaw",
    "wind_x": "x",
    "wind_y": "y",
    "wind_z": "z",
}
"""Axes of the step for parameters that no loop names."""
DEFAULT_AXIS = "z"
Progress = Callable[[float], None]
"""Function called with the share done, 0 .. 1."""
Stop = Callable[[], bool]
"""Function called regularly; True ends the work with the results so far."""
FlownPart = tuple[Sequence[int], np.ndarray, np.ndarray]
"""Numbers of some candidates (k), their metrics (k, 9), see `FLOWN_METRICS`, NaN for none, and the
times from the edge to their losses (k) [s], NaN without a loss."""


@dataclass(frozen=True)
class SweepCandidate:
    """Values of live parameters by name, and the variation of the drone.

    The seed is that of its turbulence; None for that of the scenario.
    """

    settings: Mapping[str, float]
    variation: Variation
    seed: int | None = None


@dataclass(frozen=True)
class SweepCase:
    """A step flown with many candidates.

    Attributes:
        axis: x, y, z or yaw.
        amplitude: of the command [m/s] or [rad/s].
        duration: flown after the edge of the command [s]; None for until each candidate has
            settled, see `step_duration`.
        scenario: its vehicle, world and rates are used.
        settings: parameter values common to all candidates, by name.

    Raises:
        WorkbenchError: if the step is invalid.
    """

    axis: str
    amplitude: float
    duration: float | None = None
    scenario: Scenario = field(default_factory=Scenario)
    settings: Mapping[str, float] = field(default_factory=dict)

    def __post_init__(self) -> None:
        check_step(self.axis, self.amplitude)
        if self.duration is not None:
            check_duration(self.duration)

    @property
    def controller(self) -> Controller:
        """The controller that flies it."""
        return flown_controller(self.scenario)

    def candidate(self, ranges: Sequence[SweepRange], row: Sequence[float]) -> SweepCandidate:
        """Return the candidate with these values of the swept numbers."""
        swept = {each.name: float(value) for each, value in zip(ranges, row, strict=True)}
        seed = int(swept.pop(SEED_NAME)) if SEED_NAME in swept else None
        settings, factors = dict(self.settings), dict[str, Any]()
        for name, value in swept.items():
            if name.startswith(VARIATION_PREFIX):
                factors[name.removeprefix(VARIATION_PREFIX)] = value
            else:
                settings[name] = value
        variation = dataclasses.replace(self.scenario.vehicle.variation, **factors)
        return SweepCandidate(settings, variation, seed)

    def present(self, ranges: Sequence[SweepRange], setup: "Setup") -> list[float]:
        """Return the values of the swept numbers without a sweep, of the setup of the case."""
        values = dict(setup.values)
        variation = dataclasses.asdict(setup.variation)
        values |= {f"{VARIATION_PREFIX}{name}": value for name, value in variation.items()}
        values[SEED_NAME] = setup.scenario.sensors.seed
        return [values[each.name] for each in ranges]

    def check(self, ranges: Sequence[SweepRange], setup: "Setup") -> None:
        """Check that the setup of the case can fly a sweep.

        Raises:
            WorkbenchError: if it lacks a swept parameter, or a limit would saturate the step.
        """
        table = setup.table
        rows = [row.name for row in table]
        names = [each.name for each in ranges if each.name in rows]
        check_parameters(setup.vehicle, names, table)
        for name in names:
            system, flown = table.find(name).system, self.scenario.estimator
            if system in (COMPLEMENTARY, EKF) and system != flown:
                raise WorkbenchError(
                    f"{name} is swept without effect, because the controller gets "
                    f"{'the truth' if flown == TRUTH else flown}: add --estimator {system}"
                )
        axis = find_axis(self.axis)
        lows = {each.name: each.low for each in ranges}
        most = lows.get(axis.limit, setup.values[axis.limit])
        if abs(self.amplitude) > most:
            raise WorkbenchError(
                f"a step of {self.amplitude:g} {axis.unit} along {self.axis} cannot be "
                f"flown: use an amplitude within ±{most:g}, or raise {axis.limit}"
            )


class SweepResults(NamedTuple):
    """The results of N candidates.

    Attributes:
        done: (N) whether a candidate was flown.
        values: (N, 9) metrics, see `FLOWN_METRICS`; NaN for none.
        diverged_at: (N) time from the edge to the loss [s], NaN without a loss.
    """

    done: np.ndarray
    values: np.ndarray
    diverged_at: np.ndarray


FlySweep = Callable[
    [SweepCase, "Setup", Sequence[SweepCandidate], Stop | None], Iterator[FlownPart]
]
"""Function that flies candidates and yields them part by part: `fly_fastest` or `fly_full`."""


def empty_results(count: int) -> SweepResults:
    """Return empty results for a number of candidates."""
    return SweepResults(
        np.zeros(count, dtype=bool),
        np.full((count, len(FLOWN_METRICS)), np.nan),
        np.full(count, np.nan),
    )


def partial_progress(progress: Progress | None, first: float, last: float) -> Progress | None:
    """Return a function for the progress of a part of the work, between two shares."""
    if progress is None:
        return None
    tell = progress
    return lambda share: tell(first + share * (last - first))


def axis_loop(axis: str, controller: Controller | None = None) -> str:
    """Return the name of the outermost steering loop of an axis.

    Args:
        axis: x, y, z or yaw.
        controller: with the loops; None for the default one.

    Raises:
        WorkbenchError: if there is no such axis, or the controller states no loop for it.
    """
    if axis not in AXIS_NAMES:
        raise unknown_name("axis", axis, AXIS_NAMES)
    law = controller_or_default(controller)
    for loop in law.loops:
        if loop.axis == axis and not loop.hold:
            return loop.name
    raise WorkbenchError(
        f"{law.name} has no loop for {axis}: give a loop in its file axis={axis!r}"
    )


def axis_of(parameter: str, controller: Controller | None = None) -> str:
    """Return the axis of the step that a parameter affects, "" for none or all.

    For a gain it is that of the first loop that names it.
    """
    if parameter in _PARAMETER_AXES:
        return _PARAMETER_AXES[parameter]
    loops = controller_or_default(controller).loops
    return next((each.axis for each in loops if parameter in each.gains and not each.hold), "")


def default_axis(parameters: Iterable[str], controller: Controller | None = None) -> str:
    """Return the axis to step along: that of the first parameter with an axis, else z."""
    axes = (axis_of(each, controller) for each in parameters)
    return next(filter(None, axes), DEFAULT_AXIS)
