"""Differences between two sets of gains."""

import math
from collections.abc import Mapping
from typing import NamedTuple

from workbench.control.controller import Controller
from workbench.control.controller_file import controller_or_default


class GainChange(NamedTuple):
    """A gain in two sets.

    Attributes:
        name: of the parameter.
        unit: of both values.
        a: value in the first set.
        b: value in the second.
        percent: difference of b from a, relative to the size of a; NaN if a is 0.
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
    """Compare the gains of two files.

    Args:
        a: value by name.
        b: value by name.
        missing: value by name for gains that only one of them has, from `gain_choice.rule_values`.
        controller: of the gains; None for the default one.

    Returns:
        A row for every name in either, equal ones too, in the order of the parameter table.
    """
    all_a, all_b = {**missing, **a}, {**missing, **b}
    return tuple(
        _change(row.name, row.unit, all_a[row.name], all_b[row.name])
        for row in controller_or_default(controller).table
        if row.name in a or row.name in b
    )


def _change(name: str, unit: str, a: float, b: float) -> GainChange:
    if a == b:
        return GainChange(name, unit, a, b, 0.0)
    return GainChange(name, unit, a, b, 100.0 * (b - a) / abs(a) if a else math.nan)
