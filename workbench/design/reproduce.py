"""Fly the four steps of the paper's section 6, and compare them with its figures."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass

import numpy as np

from workbench.design.response_metrics import crossing_time
from workbench.design.step_response import (
    StepResponse,
    axis_force,
    fly_step,
)
from workbench.scenario.axes import find_axis
from workbench.scenario.scenario import Scenario

AVERAGING_WINDOW_TEXT = (
    "averages run from the command's edge until the response first reaches 90 % of it"
)
MAX_PAPER_ACCEL_DIFF_PCT = 5.0
"""Limit of the difference from the paper [%]."""
MAX_PAPER_FORCE_DIFF_PCT = {"x": 5.0, "y": 5.0, "z": 3.0, "yaw": None}
"""Limit of the difference from the paper [%]; not for its yaw torque, see its remark."""
MAX_PAPER_OVERSHOOT_PCT = 5.0
"""Limit [%]."""
MAX_PAPER_ERROR_PCT = 1.0
"""Limit [%]."""
MAX_HEIGHT_CHANGE_M = 0.05
MAX_SIDEWAYS_DRIFT_M = 0.01
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
class ReproducedRow:
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


PAPER_FIGURES = (
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
PAPER_COMMANDS = {figure.axis: figure.command for figure in PAPER_FIGURES}
"""Amplitude of the paper's step along each axis [m/s, rad/s]."""


def reproduce(
    *,
    scenario: Scenario | None = None,
    settings: Mapping[str, float] | None = None,
    progress: Callable[[float], None] | None = None,
) -> list[ReproducedRow]:
    """Fly the paper's four steps.

    Args:
        scenario: its vehicle and rates are used.
        settings: parameter values for all four.
        progress: called with the share flown of all four, 0 .. 1.
    """
    rows = []
    for index, figure in enumerate(PAPER_FIGURES):

        def report(share: float, done: int = index) -> None:
            if progress:
                progress((done + share) / len(PAPER_FIGURES))

        flight = fly_step(
            figure.axis, figure.command, scenario=scenario, settings=settings, progress=report
        )
        rows.append(compare_with_paper(figure, flight))
    return rows


def compare_with_paper(figure: PaperFigure, flight: StepResponse) -> ReproducedRow:
    """Return the averages of a flown step, with those of the paper."""
    after, time = flight.after, flight.time
    velocity = flight.response
    t90 = crossing_time(time, velocity, 0.9 * flight.amplitude)
    return ReproducedRow(
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
class PaperCheck:
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


def implied_t90(row: ReproducedRow) -> float:
    """Return the time to 90 % that the paper's mean acceleration implies [s]."""
    return 0.9 * row.paper.command / row.paper.mean_acceleration


def paper_checks(row: ReproducedRow) -> list[PaperCheck]:
    """Return all comparisons of a step."""
    axis, metrics, coupling = row.paper.axis, row.flight.metrics, row.flight.coupling
    found = [
        PaperCheck("t90", "s", implied_t90(row), row.t90, None),
        PaperCheck(
            "mean acceleration",
            find_axis(axis).acceleration_unit,
            row.paper.mean_acceleration,
            row.mean_acceleration,
            MAX_PAPER_ACCEL_DIFF_PCT,
        ),
        PaperCheck(
            "mean torque" if axis == "yaw" else "mean force",
            find_axis(axis).force_unit,
            row.paper.mean_force,
            row.mean_force,
            MAX_PAPER_FORCE_DIFF_PCT[axis],
        ),
        PaperCheck("overshoot", "%", None, metrics.overshoot, MAX_PAPER_OVERSHOOT_PCT),
        PaperCheck(
            "steady-state error", "%", None, metrics.steady_state_error, MAX_PAPER_ERROR_PCT
        ),
    ]
    if axis == "x":
        found.append(PaperCheck("height change", "m", None, coupling.z, MAX_HEIGHT_CHANGE_M))
        found.append(PaperCheck("drift along y", "m", None, coupling.y, MAX_SIDEWAYS_DRIFT_M))
    return found


def unmet_demands(rows: list[ReproducedRow]) -> list[str]:
    """Return a phrase for each demand that is not met."""
    return [
        f"{check.quantity} of the {row.paper.axis} step is {check.ours:.4g} {check.unit}"
        + (f", the paper's {check.paper:g}" if check.paper is not None else "")
        + f" ({check.demand})"
        for row in rows
        for check in paper_checks(row)
        if not check.met
    ]


def paper_step_name(row: ReproducedRow) -> str:
    """Return the name of the step."""
    paper = row.paper
    unit = find_axis(paper.axis).unit
    return f"{paper.axis}: command {paper.command:g} {unit} (figure {paper.number})"
