"""The changes that a gain file would make, before any of them flies."""

import math
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path

from workbench.control.controller import Controller
from workbench.gains.gain_change import GainChange, diff_gains
from workbench.gains.gains import GainFile

GainFileValues = Mapping[str, float]


@dataclass(frozen=True)
class GainFileDiff:
    """The changes that a gain file would make, line by line, before any of them flies.

    Attributes:
        name: name of the gain file.
        origin: source of its values, and which of them cannot be used.
        values: all values that the flight can use.
        changes: values that differ from the present ones.
        target: an autopilot's file to write to, which has the first of each pair; None for the
            flight.
        refused: names of the changes that were not written, because the file would not fly.
    """

    name: str
    origin: str
    values: GainFileValues
    changes: tuple[GainChange, ...]
    target: Path | None = None
    refused: frozenset[str] | None = None

    def before(self, flown: GainFileValues) -> dict[str, float]:
        """Return the present values of the flight or the file, beside all other flown values."""
        return {**flown, **{each.name: each.a for each in self.changes}}

    def after(self, flown: GainFileValues) -> dict[str, float]:
        """Return the values after the change."""
        return {**flown, **{each.name: each.b for each in self.changes}}


def compare_gain_file(
    name: str, file: GainFile, vehicle: str, present: GainFileValues, controller: Controller
) -> GainFileDiff:
    """Return the changes that a gain file would make.

    Args:
        name: name of the gain file.
        file: content of its file.
        vehicle: name of the flying vehicle.
        present: all values of the flight.
        controller: the flying controller.
    """
    values = {name: value for name, value in file.gains.items() if name in present}
    compared = diff_gains({each: present[each] for each in values}, values, present, controller)
    said = [file.origin] if file.origin else []
    if file.vehicle and vehicle and file.vehicle != vehicle:
        said.append(f"these are gains of '{file.vehicle}', but '{vehicle}' flies")
    if missing := [each for each in file.gains if each not in present]:
        said.append(f"this flight has no {', '.join(missing)}")
    changes = tuple(each for each in compared if each.a != each.b)
    return GainFileDiff(name, "; ".join(said), values, changes)


def percent_text(change: GainChange) -> str:
    """Return a relative change, as +12.5 %; a dash if there is none."""
    return "–" if math.isnan(change.percent) else f"{change.percent:+.1f} %".replace("-", "−")
