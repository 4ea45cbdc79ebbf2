"""What `workbench gains` prints: values with units, differences, states."""

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING

from workbench.commands.printing import print_json, print_table
from workbench.scenario.parameters import find_parameter

if TYPE_CHECKING:
    from workbench.gains.difference import GainChange
    from workbench.gains.history import Save
    from workbench.gains.profiles import GainFile

_MOST_CHANGES = 3
"""Of a state, so many are printed; --json has all."""


def print_values(
    about: Mapping[str, str],
    values: Mapping[str, float],
    origins: Mapping[str, str],
    *,
    as_json: bool,
) -> None:
    """Print gains with their units.

    Args:
        about: what stands above them, by what it is.
        values: by name.
        origins: where each comes from, by name.
        as_json: print JSON instead of a table.
    """
    rows = [
        (name, value, find_parameter(name).unit, origins[name]) for name, value in values.items()
    ]
    if as_json:
        columns = ("name", "value", "unit", "origin")
        gains = [dict(zip(columns, row, strict=True)) for row in rows]
        print_json({**about, "gains": gains})
        return
    for what, text in about.items():
        print(f"{what}: {text or '(not said)'}")
    print_table([(name, f"{value:g}", *rest) for name, value, *rest in rows], left=(0, 2, 3))


def print_changes(
    a: str, b: str, vehicle: str, changes: "Sequence[GainChange]", *, as_json: bool
) -> None:
    """Print what differs between two sets.

    Args:
        a: what the first is called.
        b: what the second is called.
        vehicle: whose rule gave what one of them lacked.
        changes: all rows, equal ones too.
        as_json: print JSON, with the equal ones, instead of a table.
    """
    if as_json:
        print_json({"a": a, "b": b, "vehicle": vehicle, "rows": [row._asdict() for row in changes]})
        return
    differing = [row for row in changes if row.a != row.b]
    equal = len(changes) - len(differing)
    if not differing:
        print(f"no difference in {equal} gains")
        return
    rows = [
        (row.name, f"{row.a:g}", f"{row.b:g}", row.unit, _percent(row.percent)) for row in differing
    ]
    print_table([("", a, b, "", "change"), *rows], left=(0, 3))
    if equal:
        print(f"{equal} others are equal")


def print_history(gains: "GainFile", *, as_json: bool) -> None:
    """Print the states of a gain file, oldest first."""
    if as_json:
        states = [
            {
                "state": index,
                "saved": save.saved or None,
                "origin": save.origin,
                "changed": save.changed,
            }
            for index, save in enumerate(gains.history)
        ]
        print_json({"vehicle": gains.vehicle, "states": states})
        return
    if not gains.history:
        print("no state was saved yet: the file is as it was written by hand")
        return
    rows = [
        (str(index), save.saved or "-", _changes(save), save.origin)
        for index, save in enumerate(gains.history)
    ]
    print_table([("state", "saved (UTC)", "changed", "origin"), *rows], left=(1, 2, 3))


def _changes(save: "Save") -> str:
    """Return what a save changed, in short."""
    parts = [
        f"{name} {_value(before)} to {_value(after)}"
        for name, (before, after) in save.changed.items()
    ]
    more = len(parts) - _MOST_CHANGES
    return ", ".join(parts[:_MOST_CHANGES]) + (f", {more} more" if more > 0 else "") or "-"


def _value(value: float | None) -> str:
    return "none" if value is None else f"{value:g}"


def _percent(percent: float) -> str:
    return "" if percent != percent else f"{percent:+.1f} %"
