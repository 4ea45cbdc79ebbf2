"""Fly the four steps of the paper's section 6, and compare them with its figures."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass

import numpy as np

from workbench.design.response_metrics import crossing_time
from workbench.design.step_response import (
    EDGE,
    StepResponse,
    axis_force,
    axis_velocity,
    fly_step,
)
from workbench.scenario.axes import find_axis
from workbench.scenario.scenario import Scenario

WINDOW = "averages run from the command's edge until the response first reaches 90 % of it"
MEAN_ACCELERATION = 5.0
"""Limit of the difference from the paper [%]."""
MEAN_FORCE = {"x": 5.0, "y": 5.0, "z": 3.0, "yaw": None}
"""Limit of the difference from the paper [%]; not for its yaw torque, see its remark."""
OVERSHOOT = 5.0
"""Limit [%]."""
STEADY_STATE_ERROR = 1.0
"""Limit [%]."""
HEIGHT_CHANGE = 0.05
SIDEWAYS_DRIFT = 0.01
"""Limits of the change in height and of the drift along y during the x step [m]."""


@dataclass(frozen=True)
class PaperFigure:
    """The figures that the paper reports for one step; force is a torque [N·m] for yaw."""

    axis: str
    number: int
    command: float
    mean_acceleration: float
    mean_force: float
    remark: str = ""


@dataclass(frozen=True)
class Row:
    """One step compared with that of the paper.

    Attributes:
        paper: the paper's figures.
        flight: ours.
        t90: from the edge to 90 % of the command [s].
        mean_acceleration: over that window [m/s² or rad/s²].
        mean_force: over that window [N or N·m], see `axis_force`.
    """

    paper: PaperFigure
    flight: StepResponse
    t90: float
    mean_acceleration: float
    mean_force: float


PAPER = (
    PaperFigure("z", 8, 1.0, 1.8, 22.3),
    PaperFigure("x", 9, 2.0, 4.0, 7.5),
    PaperFigure("y", 10, 2.0, 4.0, 7.5),
    PaperFigure(
        "yaw",
        11,
        0.2,
        0.33,
        0.72,
        "0.72 N·m at 0.33 rad/s² would need an inertia of 2.18 kg·m² about z, a hundred times the "
        "0.0218 kg·m² that published quadrotor plugins carry; a 1.9 kg airframe cannot have it, so "
        "this torque is reported and not aimed at",
    ),
)
COMMANDS = {figure.axis: figure.command for figure in PAPER}
"""Amplitude of the paper's step along each axis [m/s, rad/s]."""


def reproduce(
    *,
    scenario: Scenario | None = None,
    settings: Mapping[str, float] | None = None,
    progress: Callable[[float], None] | None = None,
) -> list[Row]:
    """Fly the paper's four steps.

    Args:
        scenario: its vehicle and rates are used.
        settings: parameter values for all four.
        progress: called with the share flown of all four, 0 .. 1.
    """
    rows = []
    for index, figure in enumerate(PAPER):

        def report(share: float, done: int = index) -> None:
            if progress:
                progress((done + share) / len(PAPER))

        flight = fly_step(
            figure.axis, figure.command, scenario=scenario, settings=settings, progress=report
        )
        rows.append(compare(figure, flight))
    return rows


def compare(figure: PaperFigure, flight: StepResponse) -> Row:
    """Return the averages of a flown step, with those of the paper."""
    after = flight.recording.between(EDGE, np.inf)
    time = after.time - EDGE
    velocity = axis_velocity(after, flight.axis)
    t90 = crossing_time(time, velocity, 0.9 * flight.amplitude)
    return Row(
        paper=figure,
        flight=flight,
        t90=t90,
        mean_acceleration=(0.9 * flight.amplitude - float(velocity[0])) / t90,
        mean_force=mean_until(time, axis_force(after, flight.axis), t90),
    )


def mean_until(time: np.ndarray, values: np.ndarray, end: float) -> float:
    """Return the mean of a signal from time 0 to `end`, by the trapezoidal rule."""
    inner = time[time < end]
    grid = np.append(inner, end)
    return float(np.trapezoid(np.interp(grid, time, values), grid) / end)


@dataclass(frozen=True)
class Check:
    """One number of a step, and the demand on it.

    Attributes:
        quantity: its name.
        unit: its unit.
        paper: the number in the paper, or None.
        ours: the flown one.
        limit: largest difference from the paper [%], or largest value if the paper has no number;
            None without a demand.
    """

    quantity: str
    unit: str
    paper: float | None
    ours: float
    limit: float | None

    @property
    def difference(self) -> float | None:
        """Difference of our number from the paper's [%]."""
        return None if self.paper is None else 100.0 * (self.ours / self.paper - 1.0)

    @property
    def met(self) -> bool:
        """Whether the demand is met; a NaN never meets it."""
        if self.limit is None:
            return True
        return abs(self.ours if self.difference is None else self.difference) <= self.limit

    @property
    def demand(self) -> str:
        """The demand in words, "" if there is none."""
        if self.limit is None:
            return ""
        if self.paper is None:
            return f"at most {self.limit:g} {self.unit}"
        return f"within {self.limit:g} %"


def implied_t90(row: Row) -> float:
    """Return the time to 90 % that the paper's mean acceleration implies [s]."""
    return 0.9 * row.paper.command / row.paper.mean_acceleration


def checks(row: Row) -> list[Check]:
    """Return all comparisons of a step."""
    axis, metrics, coupling = row.paper.axis, row.flight.metrics, row.flight.coupling
    found = [
        Check("t90", "s", implied_t90(row), row.t90, None),
        Check(
            "mean acceleration",
            find_axis(axis).acceleration_unit,
            row.paper.mean_acceleration,
            row.mean_acceleration,
            MEAN_ACCELERATION,
        ),
        Check(
            "mean torque" if axis == "yaw" else "mean force",
            find_axis(axis).force_unit,
            row.paper.mean_force,
            row.mean_force,
            MEAN_FORCE[axis],
        ),
        Check("overshoot", "%", None, metrics.overshoot, OVERSHOOT),
        Check("steady-state error", "%", None, metrics.steady_state_error, STEADY_STATE_ERROR),
    ]
    if axis == "x":
        found.append(Check("height change", "m", None, coupling.z, HEIGHT_CHANGE))
        found.append(Check("drift along y", "m", None, coupling.y, SIDEWAYS_DRIFT))
    return found


def violations(rows: list[Row]) -> list[str]:
    """Return a phrase for each demand that is not met."""
    return [
        f"{check.quantity} of the {row.paper.axis} step is {check.ours:.4g} {check.unit}"
        + (f", the paper's {check.paper:g}" if check.paper is not None else "")
        + f" ({check.demand})"
        for row in rows
        for check in checks(row)
        if not check.met
    ]


def heading(row: Row) -> str:
    """Return the name of the step."""
    paper = row.paper
    unit = find_axis(paper.axis).unit
    return f"{paper.axis}: command {paper.command:g} {unit} (figure {paper.number})"
