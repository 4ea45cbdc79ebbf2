"""How good an estimate was, as text."""

import math
from typing import TYPE_CHECKING

from workbench.commands.printing import print_table

if TYPE_CHECKING:
    from workbench.design.estimation_errors import EstimateReport

_SHOWN = {
    "rad": ("deg", math.degrees(1.0)),
    "rad/s": ("deg/s", math.degrees(1.0)),
    "1": ("%", 100.0),
}
"""Unit on screens of a unit, and what its numbers are multiplied with."""


def print_estimate(report: "EstimateReport") -> None:
    """Print RMS and worst of every state, NEES, and what each channel told."""
    rows = [("estimate", "RMS error", "worst", "")]
    for state in report.states:
        unit, factor = _SHOWN.get(state.unit, (state.unit, 1.0))
        rows.append((state.name, f"{factor * state.rms:.3f}", f"{factor * state.worst:.3f}", unit))
    print_table(rows, left=(0, 3))
    nees = report.nees
    if nees is None:
        return
    print(
        f"NEES of attitude, position and velocity: mean {nees.mean:.2f} of {nees.states} states, "
        f"{100.0 * nees.within:.1f} % of the time within {nees.lower:.2f} .. {nees.upper:.2f} "
        "(95 %)"
    )
    if not report.innovations:
        return
    print()
    told = [("innovations", "number", "in 95 % bounds")]
    told += [
        (each.channel, f"{each.count}", f"{100.0 * each.within:.1f} %")
        for each in report.innovations
    ]
    print_table(told, left=(0,))
