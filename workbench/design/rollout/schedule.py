"""When things happen in the flights of a batch."""

import math
from typing import NamedTuple

from workbench.common.errors import WorkbenchError
from workbench.design.step_response import check_duration
from workbench.scenario.scenario import Rates


class Schedule(NamedTuple):
    """When things happen; instants are numbers of control periods from the start.

    Attributes:
        step: of physics [s].
        period: of control [s].
        steps: of physics in a control period.
        edge: instant at which the command steps.
        edge_time: when it was given [s], up to a period earlier.
        end: last instant.
        stride: the first and every stride-th instant after it are kept.
    """

    step: float
    period: float
    steps: int
    edge: int
    edge_time: float
    end: int
    stride: int


def make_schedule(rates: Rates, edge_time: float, duration: float, stride: int) -> Schedule:
    """Return when things happen; a command comes between physics steps, see `Session`.

    Args:
        rates: periods of physics and control.
        edge_time: when the command is given [s].
        duration: flown after it [s].
        stride: of the control periods that are kept.

    Raises:
        WorkbenchError: if that makes no flight.
    """
    check_duration(duration)
    if not (1 <= stride < math.inf and int(stride) == stride):
        raise WorkbenchError(f"the stride is {stride:g}: give it a whole number, 1 or more")
    step = rates.physics_step
    steps = round(rates.control_period / step)
    edge = math.ceil(edge_time / step - 1e-6)
    return Schedule(
        step=step,
        period=rates.control_period,
        steps=steps,
        edge=-(-edge // steps),
        edge_time=edge_time,
        end=math.floor((edge_time + duration) / step + 1e-6) // steps,
        stride=int(stride),
    )
