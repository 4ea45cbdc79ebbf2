"""Tables of gains, their differences, and the states of a gain file."""

import argparse
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING

from workbench.commands.printing import pick, print_result, print_table

if TYPE_CHECKING:
    from workbench.control.controller import Controller
    from workbench.gains.gain_change import GainChange
    from workbench.gains.gain_history import Save
    from workbench.gains.gains import GainFile


_MAX_PRINTED_CHANGES = 3
"""Largest number of changes printed for a state; --json has all."""


def print_gain_values(
    args: argparse.Namespace,
    about: Mapping[str, str],
    values: Mapping[str, float],
    origins: Mapping[str, str],
    controller: "Controller",
) -> None:
    """Print gains with their units.

    Args:
        args: of the command line.
        about: heading lines by their labels.
        values: by name.
        origins: of each value, by name.
        controller: of the gains.
    """
    table = controller.table
    gains = [
        {"name": name, "value": value, "unit": table.find(name).unit, "origin": origins[name]}
        for name, value in values.items()
    ]

    def show() -> None:
        for what, text in about.items():
            print(f"{what}: {text or '(not said)'}")
        rows = [
            (name, f"{value:g}", table.find(name).unit, origins[name])
            for name, value in values.items()
        ]
        print_table(rows, left=(0, 2, 3))

    print_result(args, {**about, "gains": gains}, show)


def print_gain_changes(
    args: argparse.Namespace,
    a: str,
    b: str,
    vehicle: str,
    changes: "Sequence[GainChange]",
    files: Sequence[Path] = (),
) -> None:
    """Print the differences between two sets.

    Args:
        args: of the command line.
        a: name of the first.
        b: name of the second.
        vehicle: the one with the rule for gains that one of them lacks.
        changes: all rows, including equal ones, which only JSON has.
        files: the written ones.
    """
    result = {"a": a, "b": b, "vehicle": vehicle, "rows": [row._asdict() for row in changes]}
    print_result(args, result, _show_changes, a, b, changes, files=files)


def _show_changes(a: str, b: str, changes: "Sequence[GainChange]") -> None:
    differing = [row for row in changes if row.a != row.b]
    equal = len(changes) - len(differing)
    if not differing:
        print(f"no difference in {equal} gains")
        return
    rows = [
        (row.name, f"{row.a:g}", f"{row.b:g}", row.unit, percent_change(row.percent))
        for row in differing
    ]
    print_table([("", a, b, "", "change"), *rows], left=(0, 3))
    if equal:
        print(f"{equal} others are equal")


def print_gain_history(args: argparse.Namespace, gains: "GainFile") -> None:
    """Print the states of a gain file, oldest first."""
    states = [
        {"state": index, "saved": save.saved or None, **pick(save, "origin changed")}
        for index, save in enumerate(gains.history)
    ]
    print_result(args, {"vehicle": gains.vehicle, "states": states}, _show_history, gains)


def _show_history(gains: "GainFile") -> None:
    if not gains.history:
        print("no state was saved yet: the file is as it was written by hand")
        return
    rows = [
        (str(index), save.saved or "-", _changes(save), save.origin)
        for index, save in enumerate(gains.history)
    ]
    print_table([("state", "saved (UTC)", "changed", "origin"), *rows], left=(1, 2, 3))


def _changes(save: "Save") -> str:
    """Return the changes of a save, in short."""
    parts = [
        f"{name} {_value(before)} to {_value(after)}"
        for name, (before, after) in save.changed.items()
    ]
    more = len(parts) - _MAX_PRINTED_CHANGES
    return ", ".join(parts[:_MAX_PRINTED_CHANGES]) + (f", {more} more" if more > 0 else "") or "-"


def _value(value: float | None) -> str:
    return "none" if value is None else f"{value:g}"


def percent_change(percent: float) -> str:
    """Return a change in percent; "" for one without a number."""
    return "" if percent != percent else f"{percent:+.1f} %"
