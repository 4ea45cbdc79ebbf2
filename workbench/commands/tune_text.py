"""What `workbench tune` says: tables, one line of progress, and JSON."""

import math
from pathlib import Path
from typing import TYPE_CHECKING, Any

from workbench.commands.printing import print_table

if TYPE_CHECKING:
    from collections.abc import Sequence

    from workbench.design.tune.tuning import Progress, Result, Tuning


def progress_line(progress: "Progress") -> str:
    """Return how the best so far does, in a line."""
    from workbench.design.metrics import shown

    if progress.best is None or progress.worst is None:
        return progress.phase
    metric = progress.worst.wish.metric
    reserve = 100.0 * progress.best.reserve
    return (
        f"{progress.phase}; best so far: {progress.worst.wish.name} "
        f"{shown(metric, progress.value)} ({reserve:+.0f} % to spare)"
    )


def print_tuning(found: "Tuning") -> None:
    """Print wishes, gains and the proof."""
    from workbench.design.tune.report import gain_rows, proof_rows, wish_rows

    print(f"{found.vehicle}: {len(found.wishes)} wishes, {found.evaluations} candidates looked at")
    for remark in (*found.shortfalls, *found.remarks):
        print(remark)
    print()
    print_table(
        [["", "before", "after", "wished", ""], *wish_rows(found.as_described)], left=(0, 4)
    )
    if found.in_corners:
        print("\nin the worst corner of each:")
        rows = wish_rows(found.in_corners, cases=True)
        print_table([["", "before", "after", "still wished", "", ""], *rows], left=(0, 4, 5))
    if found.guarded:
        print("\nloops that no wish is about, to keep 90 % of their margins:")
        rows = wish_rows(found.guarded)
        print_table([["", "before", "after", "kept", ""], *rows], left=(0, 4))
    print()
    print_table([["", "before", "after", ""], *gain_rows(found)], left=(0, 3))
    if found.proof and found.proof.values:
        print("\nflown on the full diagram:")
        print_table([["", "flown", "wished", "", ""], *proof_rows(found)], left=(0, 3, 4))


def conclusion(found: "Tuning") -> list[str]:
    """Return why there are no gains, a sentence each."""
    if found.conflicts:
        return [str(conflict) for conflict in found.conflicts]
    short = min(found.results, key=lambda result: result.reserve)
    from workbench.design.metrics import shown

    value = shown(short.required.wish.metric, short.after)
    nearest = f"no gains that meet all wishes were found: {short.required} is nearest with {value}"
    if found.stopped:
        return [f"ended early; so far {nearest}"]
    return [f"{nearest}; look at more candidates with --evaluations"]


def tuning_json(found: "Tuning", files: "Sequence[Path]") -> dict[str, Any]:
    """Return everything as JSON has it, in SI units."""
    return {
        "vehicle": found.vehicle,
        "met": found.met,
        "stopped": found.stopped,
        "evaluations": found.evaluations,
        "wishes": [_result(result) for result in found.results if result not in found.guarded],
        "guarded": [_result(result) for result in found.guarded],
        "gains": {
            name: {"before": found.before[name], "after": value}
            for name, value in found.gains.items()
        },
        "proof": [
            {
                "wish": required.wish.name,
                "case": required.case,
                "bound": required.bound,
                "flown": value,
                "met": required.met(value),
            }
            for required, value in (found.proof.values if found.proof else ())
        ],
        "conflicts": [
            {
                "wish": conflict.wish.name,
                "against": [wish.name for wish in conflict.against],
                "bound": conflict.required.bound,
                "nearest": conflict.nearest,
                "sentence": str(conflict),
            }
            for conflict in found.conflicts
        ],
        "shortfalls": found.shortfalls,
        "remarks": found.remarks,
        "files": files,
    }


def _result(result: "Result") -> dict[str, Any]:
    required = result.required
    return {
        "wish": required.wish.name,
        "origin": required.wish.origin,
        "case": required.case,
        "unit": required.wish.metric.unit,
        "at_least": required.wish.at_least,
        "bound": required.bound,
        "widened_from": required.widened,
        "before": result.before if math.isfinite(result.before) else None,
        "after": result.after,
        "met": result.met,
    }
