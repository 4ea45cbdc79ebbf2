"""The saves in the history of a gain file."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from numbers import Real
from typing import Any

from workbench.common.errors import WorkbenchError, unknown_name
from workbench.common.yaml_files import YamlFile

_SAVE_KEYS = ("saved", "origin", "changed")


@dataclass(frozen=True)
class Save:
    """One saved state of a gain file.

    Attributes:
        saved: date and time in UTC, in ISO 8601; "" for values written by hand.
        origin: of its values.
        changed: values before and after by name, for those that differ from the state before; None
            for a value that was not in the file.
    """

    saved: str
    origin: str
    changed: Mapping[str, tuple[float | None, float | None]]


def read_history(file: YamlFile) -> tuple[Save, ...]:
    """Return the history of a gain file, oldest first.

    Raises:
        WorkbenchError: with file and line of the error.
    """
    entries = file.data.get("history") or []
    if not isinstance(entries, list):
        raise WorkbenchError(f"{file.where('history')}history is a list of saves: leave it out")
    return tuple(_read_save(file, index, entry) for index, entry in enumerate(entries))


def write_history(history: Sequence[Save]) -> list[dict[str, Any]]:
    """Return a history in the form for YAML."""
    return [
        ({"saved": save.saved} if save.saved else {})
        | {"origin": save.origin, "changed": {n: list(pair) for n, pair in save.changed.items()}}
        for save in history
    ]


def next_save(
    saved: str, origin: str, before: Mapping[str, float], after: Mapping[str, float]
) -> Save:
    """Return the entry of a save.

    Args:
        saved: date and time in UTC, in ISO 8601.
        origin: of the new values.
        before: the values replaced.
        after: the new ones.
    """
    pairs = {name: (before.get(name), after.get(name)) for name in {**before, **after}}
    return Save(saved, origin, {name: pair for name, pair in pairs.items() if pair[0] != pair[1]})


def values_at(present: Mapping[str, float], later: Sequence[Save]) -> dict[str, float]:
    """Return the values of an earlier state.

    Args:
        present: the values now.
        later: every save after that state, oldest first.
    """
    values = dict(present)
    for save in reversed(later):
        for name, (before, _) in save.changed.items():
            values.pop(name, None)
            if before is not None:
                values[name] = before
    return values


def _read_save(file: YamlFile, index: int, entry: object) -> Save:
    """Return one entry of a history."""
    if not isinstance(entry, dict) or not isinstance(entry.get("changed", {}), dict):
        raise WorkbenchError(f"{file.where('history', index)}a save has {', '.join(_SAVE_KEYS)}")
    for key in entry:
        if key not in _SAVE_KEYS:
            where = file.where("history", index, key)
            raise WorkbenchError(f"{where}{unknown_name('key', str(key), _SAVE_KEYS)}")
    changed = {}
    for name, pair in entry.get("changed", {}).items():
        if not (isinstance(pair, list) and len(pair) == 2 and all(map(_is_value, pair))):
            where = file.where("history", index, "changed", name)
            raise WorkbenchError(f"{where}{name} is {pair!r}: write [value before, value after]")
        before, after = (None if value is None else float(value) for value in pair)
        changed[str(name)] = (before, after)
    return Save(str(entry.get("saved", "")), str(entry.get("origin", "")), changed)


def _is_value(value: object) -> bool:
    """Return whether this is a number or None."""
    return value is None or (isinstance(value, Real) and not isinstance(value, bool))
