"""What `workbench sweep` prints: the present and the best candidate side by side."""

import math
from typing import TYPE_CHECKING, Any

import numpy as np

from workbench.commands.printing import print_table, say
from workbench.design.metrics import FLOWN, Metric, for_people
from workbench.design.sweep.best import what_does_not_move, why_no_best
from workbench.design.sweep.table import ARRIVED
from workbench.scenario.axes import find_axis

if TYPE_CHECKING:
    from workbench.design.sweep.best import BestCandidate
    from workbench.design.sweep.table import SweepTable

_NOTHING_FLIES = "no best is chosen: the best candidates were lost on the full diagram"


_RANGE = ("name", "low", "high", "points", "log")
"""What JSON says of a range."""


def sweep_result(table: "SweepTable", best: "BestCandidate | None", metric: str) -> dict[str, Any]:
    """Return everything as JSON has it; angles in rad."""
    swept = [each.name for each in table.ranges]
    measured = [each.name for each in table.metrics]
    return {
        "vehicle": table.vehicle,
        "axis": table.case.axis,
        "amplitude": table.case.amplitude,
        "duration": table.case.duration,
        "set": table.case.settings,
        "variation": table.case.scenario.vehicle.variation,
        "method": table.method,
        "seed": table.seed,
        "ranges": [{key: getattr(each, key) for key in _RANGE} for each in table.ranges],
        "planned": table.planned,
        "flown": len(table),
        "diverged": int(np.isfinite(table.diverged_at).sum()),
        "metric": metric,
        "present": _named(swept, table.present) | _named(measured, table.present_values),
        "no_best": "" if best else why_no_best(table, metric) or _NOTHING_FLIES,
        "unmoved": table.unmoved(metric),
        "withheld": int(table.withheld.sum()),
        "best": None
        if best is None
        else {
            "row": best.index,
            **_named(swept, best.parameters),
            **_named(measured, best.values),
            "on_full_diagram": _named([each.name for each in FLOWN], best.flown),
            "difference": _named([each.name for each in FLOWN], best.difference),
            "refused_rows": best.refused,
        },
        "columns": dict(zip(table.names, table.units, strict=True)),
        "candidates": [_named(table.names, row) for row in table.rows],
    }


def print_sweep(
    table: "SweepTable", best: "BestCandidate | None", metric: str, flown_with: str
) -> None:
    """Print the best candidate beside the present values, and how it flew on the full diagram."""
    case = table.case
    lost = int(np.isfinite(table.diverged_at).sum())
    unit = find_axis(case.axis).unit
    print(
        f"{len(table)} candidates, {case.axis} step of {case.amplitude:g} {unit}, "
        f"{table.vehicle} {flown_with}: {lost} diverged"
    )
    note = what_does_not_move(table, metric)
    withheld = int(table.withheld.sum())
    if withheld:
        say(
            f"{withheld} have no numbers of the response, as they have not settled within "
            f"{case.duration:g} s or did not begin at rest; --duration flies longer"
        )
    if best is None:
        why = why_no_best(table, metric) or _NOTHING_FLIES
        print(why)
        if note and note not in why:
            say(note)
        return
    flew = dict(zip((each.name for each in FLOWN), best.flown, strict=True))
    rows = [("", "present", "best", "full diagram", "")]
    rows += [
        (
            each.name,
            f"{now:.4g}",
            "any" if each.name in best.unmoved else f"{value:.4g}",
            "",
            for_people(each.unit)[1],
        )
        for each, now, value in zip(table.ranges, table.present, best.parameters, strict=True)
    ]
    columns = zip(table.metrics, table.present_values, best.values, strict=True)
    units = table.units[len(table.ranges) :]
    for (each, now, value), unit in zip(columns, units, strict=False):
        checked = _text(each, flew[each.name]) if each.name in flew else ""
        rows.append(
            (
                _marked(each, metric),
                _text(each, now),
                _text(each, value),
                checked,
                for_people(unit)[1],
            )
        )
    print_table(rows, left=(0, 4))
    if note:
        say(note)
    if best.refused:
        say(f"{len(best.refused)} that ranked before it diverged on the full diagram")
    error = best.values[[each.name for each in table.metrics].index("steady_state_error")]
    if not error <= ARRIVED:
        say(f"no candidate comes within {ARRIVED:g} % of the command")


def _named(names: Any, values: Any) -> dict[str, float]:
    return dict(zip(names, map(float, values), strict=True))


def _marked(metric: Metric, chosen: str) -> str:
    """Return a metric's name, with a mark at the one by which the best is chosen."""
    return f"{metric.name} *" if metric.name == chosen else metric.name


def _text(metric: Metric, value: float) -> str:
    scaled = for_people(metric.unit)[0] * value
    return "—" if math.isnan(scaled) else f"{scaled:.4g}"
