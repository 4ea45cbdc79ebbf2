"""What differs between two sets of gains."""

import math
from collections.abc import Mapping
from typing import NamedTuple

from workbench.control.controller import Controller
from workbench.scenario.parameters import parameter_table


class GainChange(NamedTuple):
    """A gain in two sets.

    Attributes:
        name: of the parameter.
        unit: of both values.
        a: value in the first set.
        b: value in the second.
        percent: by how much b is larger, of a's size; NaN if that says nothing, as a is 0.
    """

    name: str
    unit: str
    a: float
    b: float
    percent: float


def diff_gains(
    a: Mapping[str, float],
    b: Mapping[str, float],
    missing: Mapping[str, float],
    controller: Controller | None = None,
) -> tuple[GainChange, ...]:
    """Compare two sets of gains, as two files have them.

    Args:
        a: value by name.
        b: value by name.
        missing: every value by name, for what only one of them has: `gains.rule_values`.
        controller: whose; the default one where none is given.

    Returns:
        A row for every name that is in either, equal ones too, in the parameter table's order.
    """
    all_a, all_b = {**missing, **a}, {**missing, **b}
    return tuple(
        _change(row.name, row.unit, all_a[row.name], all_b[row.name])
        for row in parameter_table(controller)
        if row.name in a or row.name in b
    )


def _change(name: str, unit: str, a: float, b: float) -> GainChange:
    if a == b:
        return GainChange(name, unit, a, b, 0.0)
    return GainChange(name, unit, a, b, 100.0 * (b - a) / abs(a) if a else math.nan)
