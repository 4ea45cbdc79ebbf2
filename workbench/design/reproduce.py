"""The four steps of the paper's section 6, flown here and set beside its figures."""

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
from workbench.scenario.scenario import Scenario

WINDOW = "averages run from the command's edge until the response first reaches 90 % of it"


@dataclass(frozen=True)
class PaperFigure:
    """What the paper reports of one step; force is a torque [N·m] for yaw."""

    axis: str
    number: int
    command: float
    mean_acceleration: float
    mean_force: float
    remark: str = ""


@dataclass(frozen=True)
class Row:
    """One step here beside the paper's.

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
        progress: called with the flown share of all four, 0 .. 1.
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
    """Return the averages of a flown step beside the paper's."""
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
    """Return the mean from time 0 to `end` of a signal, by trapezoids between its samples."""
    inner = time[time < end]
    grid = np.append(inner, end)
    return float(np.trapezoid(np.interp(grid, time, values), grid) / end)
