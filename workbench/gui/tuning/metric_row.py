"""The numbers of a step as rows of a table with their limits, and their summary."""

import math
import re
from collections.abc import Callable

from workbench.design.load_metrics import ResponseMetrics
from workbench.gui.tuning.limits import LOAD_LIMITS, LOAD_PEAKS, STEP_LIMITS, NumberLimit
from workbench.gui.tuning.number_row import Cell, NumberRow, RowState
from workbench.gui.units import age_text
from workbench.scenario.attitude_axes import AttitudeAxis
from workbench.scenario.axes import CommandAxis
from workbench.scenario.loads import Load


def metric_rows(
    flown: ResponseMetrics | None,
    predicted: ResponseMetrics | None,
    limit_of: Callable[[str], float],
    limits: tuple[NumberLimit, ...] = STEP_LIMITS,
) -> tuple[NumberRow, ...]:
    """Return a row for each number of a step.

    Args:
        flown: numbers of the newest step, None before it.
        predicted: numbers with the proposed gains, None if unknown.
        limit_of: returns a limit by name, as shown.
        limits: limits of the numbers, in order.
    """
    return tuple(_metric_row(limit, flown, predicted, limit_of(limit.name)) for limit in limits)


def step_limits_of(row: CommandAxis | AttitudeAxis | Load) -> tuple[NumberLimit, ...]:
    """Return the limits for a step along an axis or of a load."""
    if isinstance(row, Load):
        return (LOAD_PEAKS[row.response_unit], *LOAD_LIMITS)
    return STEP_LIMITS


def _metric_row(
    limit: NumberLimit,
    flown: ResponseMetrics | None,
    predicted: ResponseMetrics | None,
    most: float,
) -> NumberRow:
    values = [limit.of(numbers) for numbers in (flown, predicted)]
    states = [_verdict(limit, value, most) for value in values]
    reasons = [numbers.withheld if numbers is not None else "" for numbers in (flown, predicted)]
    cells = tuple(
        Cell(
            limit.number_text(value),
            over=state is RowState.OVER,
            help=why if math.isnan(value) and why else limit.help,
            state=state,
        )
        for value, state, why in zip(values, states, reasons, strict=True)
    )
    return NumberRow(limit.label, (*cells, Cell(limit.relation(most))), states[0])


def _verdict(limit: NumberLimit, value: float, most: float) -> RowState:
    """Return whether a number keeps its limit, no verdict on NaN."""
    if math.isnan(value):
        return RowState.NONE
    return RowState.GOOD if limit.keeps(value, most) else RowState.OVER


def response_headline(
    rows: tuple[NumberRow, ...], flown_when: str = "", preparing: str = ""
) -> str:
    """Return a summary of the rows: the flown numbers and the predicted ones, each by themselves.

    Args:
        rows: as `metric_rows` returns them.
        flown_when: how old the flown numbers are, "" for new ones.
        preparing: how long predictions are still prepared, as a sentence; "" once they are known.
    """
    when = f" {flown_when}" if flown_when else ""
    predicted = preparing or f"Predicted: {_verdict_text(rows, 1)}."
    return f"Flown{when}: {_verdict_text(rows, 0)}. {predicted}"


def preparing_text(said: str) -> str:
    """Return how long predictions are still prepared, from a text about what is compiled.

    Args:
        said: with its share and its time so far, as "compiling flights: 40 %, 8 s".
    """
    found = re.search(r"(\d+)\s*%, (\d+)\s*s", said)
    share, seconds = map(int, found.groups()) if found else (0, 0)
    if not share:
        return "Preparing predictions, up to a minute, this once."
    return f"Preparing predictions, about {age_text(seconds * (100 - share) / share)}."


def _verdict_text(rows: tuple[NumberRow, ...], column: int) -> str:
    states = [row.cells[column].state for row in rows]
    over = [
        row.label.lower() for row, state in zip(rows, states, strict=True) if state is RowState.OVER
    ]
    if over:
        return f"{', '.join(over)} over the limit"
    return "nothing yet" if all(state is RowState.NONE for state in states) else "all limits hold"
