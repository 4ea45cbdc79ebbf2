"""Profiles of gains: files, texts of the clipboard, and what one would change."""

import math
import tempfile
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path

import yaml

from workbench.common.errors import WorkbenchError
from workbench.gains.difference import GainChange, diff_gains
from workbench.gains.profiles import GainFile, load_gains
from workbench.scenario.parameters import find_parameter

OWN = "gains.yaml"
"""A model's own gains stand beside its description, under this name."""
CLIPBOARD = "clipboard"


@dataclass(frozen=True)
class Offer:
    """Values that may be taken over, line by line, before anything of them flies.

    Attributes:
        name: of the profile.
        said: where its values come from, and what of it cannot be taken over.
        values: all that the flight can have of it.
        changes: those that differ from the present.
    """

    name: str
    said: str
    values: Mapping[str, float]
    changes: tuple[GainChange, ...]


def make_offer(name: str, file: GainFile, vehicle: str, present: Mapping[str, float]) -> Offer:
    """Return what of a profile a flight may take over.

    Args:
        name: of the profile.
        file: what it says.
        vehicle: name of the one that flies.
        present: all values that the flight has.
    """
    values = {name: value for name, value in file.gains.items() if name in present}
    compared = diff_gains({each: present[each] for each in values}, values, present)
    said = [file.origin] if file.origin else []
    if file.vehicle and vehicle and file.vehicle != vehicle:
        said.append(f"these are gains of '{file.vehicle}', and '{vehicle}' flies")
    if missing := [each for each in file.gains if each not in present]:
        said.append(f"this flight has no {', '.join(missing)}")
    changes = tuple(each for each in compared if each.a != each.b)
    return Offer(name, "; ".join(said), values, changes)


def read_own(source: Path, start: GainFile) -> GainFile:
    """Return a model's own gains; those of the flight's start where it brings none.

    Args:
        source: of the vehicle's description.
        start: what the flight began with.

    Raises:
        WorkbenchError: if the file is wrong.
    """
    own = source.parent / OWN
    return load_gains(own) if own.is_file() else start


def read_text(text: str) -> GainFile:
    """Return a profile from text: a whole gain file, or its NAME: VALUE lines alone.

    Raises:
        WorkbenchError: naming the line of what is wrong.
    """
    if not text.strip():
        raise WorkbenchError("the clipboard has no text: copy a gain file's first")
    lines = text.splitlines()
    if not any(line.startswith("gains:") for line in lines):
        text = "\n".join(["gains:", *(f"  {line.strip()}" for line in lines)])
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / CLIPBOARD
        path.write_text(text, encoding="utf-8")
        try:
            return load_gains(path)
        except WorkbenchError as error:
            raise WorkbenchError(str(error).replace(str(path), f"the {CLIPBOARD}")) from None


def write_text(profile: GainFile) -> str:
    """Return a profile as a gain file's text, without a history."""
    gains = {name: _with_unit(name, value) for name, value in profile.gains.items()}
    said = {"vehicle": profile.vehicle, "origin": profile.origin, "gains": gains}
    text: str = yaml.safe_dump(said, sort_keys=False, allow_unicode=True, width=100)
    return text


def percent_text(change: GainChange) -> str:
    """Return by how much a value is larger, as +12.5 %; a dash where that says nothing."""
    return "–" if math.isnan(change.percent) else f"{change.percent:+.1f} %".replace("-", "−")


def _with_unit(name: str, value: float) -> float | str:
    unit = find_parameter(name).unit
    return value if unit == "1" else f"{value!r} {unit}"
