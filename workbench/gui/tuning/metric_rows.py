"""The table of a step's numbers: flown, predicted, and the limit."""

import math
from collections.abc import Callable

from workbench.analysis.replies import StepNumbers
from workbench.gui.tuning.limit_table import STEP_LIMITS, Limit
from workbench.gui.tuning.table_rows import Cell, Row, State

HEAD = ("flown", "predicted", "limit")


def metric_rows(
    flown: StepNumbers | None,
    predicted: StepNumbers | None,
    limit_of: Callable[[str], float],
) -> tuple[Row, ...]:
    """Return a row for each number of a step.

    Args:
        flown: by the newest step, None before it.
        predicted: of the proposed gains, None where it is not known.
        limit_of: gives a limit by its name, as shown.
    """
    return tuple(_row(limit, flown, predicted, limit_of(limit.name)) for limit in STEP_LIMITS)


def _row(
    limit: Limit, flown: StepNumbers | None, predicted: StepNumbers | None, most: float
) -> Row:
    values = [
        getattr(numbers, limit.name) if numbers is not None else math.nan
        for numbers in (flown, predicted)
    ]
    over = [math.isfinite(value) and not limit.keeps(value, most) for value in values]
    reasons = [numbers.withheld if numbers is not None else "" for numbers in (flown, predicted)]
    cells = tuple(
        Cell(limit.text(value), over=beyond, help=why if math.isnan(value) and why else limit.help)
        for value, beyond, why in zip(values, over, reasons, strict=True)
    )
    unit = f" {limit.unit}" if limit.unit else ""
    state = State.NONE
    if flown is not None:
        if math.isnan(values[0]):
            state = State.NONE if flown.withheld else State.OVER
        else:
            state = State.OVER if over[0] else State.GOOD
    return Row(limit.label, (*cells, Cell(f"{limit.sign} {most:g}{unit}")), state)


def headline(rows: tuple[Row, ...]) -> str:
    """Return what the rows come to, in a sentence."""
    if all(row.state is State.NONE for row in rows):
        return "No step was flown yet."
    over = [row.label.lower() for row in rows if row.state is State.OVER]
    if over:
        return f"Over the limit: {', '.join(over)}."
    if any(row.cells[1].over for row in rows):
        return "Only the prediction is over."
    return "The step keeps all limits."
