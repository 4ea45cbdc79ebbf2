"""Gain files: the values of live parameters that belong to a vehicle, as YAML with a history."""

import dataclasses
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from datetime import UTC, datetime
from pathlib import Path
from typing import Any

from workbench.common.atomic_write import write_atomically
from workbench.common.errors import WorkbenchError, unknown_name
from workbench.common.resources import find_file
from workbench.common.yaml_files import read_yaml
from workbench.control.controller import DEFAULT, Controller, is_shipped, load_controller
from workbench.control.schedule import split_label, with_label
from workbench.gains.history import Save, next_save, read_history, values_at, write_history
from workbench.scenario.parameters import Parameter, ParameterTable, parameter_table

MOST_SAVES = 200
"""The history keeps so many; then the oldest go."""
_KEYS = ("vehicle", "controller", "origin", "gains", "history")
_POWERS = str.maketrans({"²": "^2", "³": "^3"})


@dataclass(frozen=True)
class GainFile:
    """A set of parameter values with the vehicle they are for and where they come from.

    Attributes:
        vehicle: its name.
        origin: a sentence.
        gains: value by name.
        history: the states that were saved, oldest first; the last one is the present.
        controller: name of the one whose parameters they are.
    """

    vehicle: str
    origin: str
    gains: Mapping[str, float]
    history: tuple[Save, ...] = ()
    controller: str = DEFAULT


def owner_of(path: Path) -> str:
    """Return the name of the controller that a gain file is for.

    Raises:
        WorkbenchError: if the file cannot be read.
    """
    return str(read_yaml(path).data.get("controller") or DEFAULT)


def flown_by(controller: str, gains: str) -> str:
    """Return a controller with the schedule of a gain file that has sets of its gains.

    Args:
        controller: as `load_controller` reads it.
        gains: a gain file's path, or "" for none.

    Raises:
        WorkbenchError: if one of them cannot be read.
    """
    if not gains:
        return controller
    owner, label = split_label(owner_of(find_file(gains)))
    law = load_controller(controller)
    return with_label(controller, label if law.name == owner else "")


def load_gains(path: Path, controller: Controller | None = None) -> GainFile:
    """Read and check a gain file.

    Args:
        path: the file.
        controller: that is to fly with it; without one, the shipped one that the file names.

    Raises:
        WorkbenchError: naming file and line of what is wrong.
    """
    file = read_yaml(path)
    for key in file.data:
        if key not in _KEYS:
            raise WorkbenchError(f"{file.where(key)}{unknown_name('key', str(key), _KEYS)}")
    owner = str(file.data.get("controller") or DEFAULT)
    if controller is None:
        if not is_shipped(owner):
            raise WorkbenchError(
                f"{file.where('controller')}the gains are of the controller {owner}: name its "
                "file, as --controller"
            )
        controller = load_controller(owner)
    elif owner not in (controller.name, controller.unscheduled):
        raise WorkbenchError(
            f"{file.where('controller')}the gains are of the controller {owner}, and "
            f"{controller.name} flies: give it gains of its own, or let {owner} fly (--controller)"
        )
    gains = file.data.get("gains")
    if not isinstance(gains, dict):
        raise WorkbenchError(
            f"{file.where('gains')}a gain file has 'gains:' with NAME: VALUE lines"
        )
    values = {}
    for name, value in gains.items():
        where = file.where("gains", str(name))
        rows = parameter_table(controller).sets(str(name), where)
        for row, one in zip(rows, _of_sets(rows, value, where), strict=True):
            values[row.name] = row.check(_without_unit(row, one, where), where)
    return GainFile(
        vehicle=str(file.data.get("vehicle") or ""),
        origin=str(file.data.get("origin") or ""),
        gains=values,
        history=read_history(file),
        controller=owner,
    )


def save_gains(path: Path, gains: GainFile, controller: Controller | None = None) -> GainFile:
    """Write a gain file, at once or not at all, and add to the history of one that is there.

    What is written over becomes the state before in the history; the history of `gains` itself is
    not written. The comment at the head of a file is kept, other comments are not. If nothing
    differs from the file, its history stays as it is.

    Args:
        path: the file.
        gains: vehicle, origin and values.
        controller: whose; without one, the shipped one that they name.

    Returns:
        What the file has now.

    Raises:
        WorkbenchError: if a value is out of range, the file cannot be written, or what is there is
            no gain file, or one of another vehicle.
    """
    table = parameter_table(controller or load_controller(gains.controller))
    values = table.checked(gains.gains)
    ordered = {row.name: values[row.name] for row in table if row.name in values}
    now = datetime.now(UTC).isoformat(timespec="seconds").replace("+00:00", "Z")
    history: tuple[Save, ...] = (Save(now, gains.origin, {}),)
    comment = ""
    if path.exists():
        old = load_gains(path, table.controller)
        if old.vehicle and gains.vehicle and old.vehicle != gains.vehicle:
            raise WorkbenchError(
                f"{path}: has the gains of '{old.vehicle}', and these are of '{gains.vehicle}': "
                "give them a file of their own"
            )
        comment = _leading_comment(path.read_text(encoding="utf-8"))
        save = next_save(now, gains.origin, old.gains, ordered)
        if save.changed or (old.vehicle, old.origin) != (gains.vehicle, gains.origin):
            history = (*(old.history or (Save("", old.origin, {}),)), save)
        else:
            history = old.history
    written = dataclasses.replace(gains, gains=ordered, history=history[-MOST_SAVES:])
    write_atomically(path, comment + _to_yaml(written, table))
    return written


def gains_at(gains: GainFile, index: int, controller: Controller | None = None) -> GainFile:
    """Return an earlier state of a gain file.

    Args:
        gains: the present, with its history.
        index: of the state, 0 the oldest.
        controller: whose; without one, the shipped one that they name.

    Raises:
        WorkbenchError: if there is no such state, or it has values that can no longer be.
    """
    last = len(gains.history) - 1
    if not 0 <= index <= last:
        known = f"has states 0 to {last}" if last >= 0 else "has no history yet"
        raise WorkbenchError(f"there is no state {index}: the gain file {known}")
    values = values_at(gains.gains, gains.history[index + 1 :])
    table = parameter_table(controller or load_controller(gains.controller))
    origin = gains.history[index].origin
    return GainFile(gains.vehicle, origin, table.checked(values), controller=gains.controller)


def _of_sets(rows: Sequence[Parameter], value: Any, where: str) -> Sequence[Any]:
    """Return the values of a gain in each of its sets: one for all, or as many as there are."""
    found = value.split(",") if isinstance(value, str) else value
    if len(rows) == 1 or not isinstance(found, list):
        return [value] * len(rows)
    if len(found) == 1:
        return found * len(rows)
    if len(found) != len(rows):
        raise WorkbenchError(
            f"{where}there are {len(found)} values: give one, or {len(rows)}, one for each set"
        )
    return found


def _without_unit(row: Parameter, value: Any, where: str) -> Any:
    """Return the number of a value that may have its unit behind it."""
    if not isinstance(value, str):
        return value
    number, _, unit = value.strip().partition(" ")
    unit = unit.strip().translate(_POWERS)
    try:
        found = float(number)
    except ValueError:
        return value
    if unit not in ("", row.unit):
        right = "has no unit" if row.unit == "1" else f"is in {row.unit}"
        raise WorkbenchError(f"{where}{row.name} is '{value}': it {right}")
    return found


def _leading_comment(text: str) -> str:
    """Return the lines of comment at the head of a file."""
    lines = text.splitlines(keepends=True)
    count = next(
        (i for i, line in enumerate(lines) if line.strip() and not line.startswith("#")), 0
    )
    return "".join(lines[:count])


def _to_yaml(gains: GainFile, table: ParameterTable) -> str:
    """Return a gain file's text."""
    import yaml  # slow to load, and most who look for gains write none

    whose = {} if gains.controller == DEFAULT else {"controller": gains.controller}
    head = {
        "vehicle": gains.vehicle,
        **whose,
        "origin": gains.origin,
        "gains": _written(gains.gains, table),
    }
    style: dict[str, Any] = {"sort_keys": False, "allow_unicode": True, "width": 100}
    text: str = yaml.safe_dump(head, default_flow_style=False, **style)
    if gains.history:
        history = {"history": write_history(gains.history)}
        text += yaml.safe_dump(history, default_flow_style=None, **style)
    return text


def _written(gains: Mapping[str, float], table: ParameterTable) -> dict[str, float | str]:
    """Return values as they are written: those of all sets of a scheduled gain in one line."""
    found, schedule = {}, table.controller.schedule
    for name, value in gains.items():
        number = schedule.number_of(name) if schedule else None
        if schedule is None or number is None:
            found[name] = _with_unit(table.find(name), value)
            continue
        gain = table.controller.gain_of(name)
        sets = [gains[each] for each in schedule.names(gain) if each in gains]
        if len(sets) < len(schedule.values):
            found[name] = _with_unit(table.find(name), value)
        else:
            first = ", ".join(repr(each) for each in sets[:-1])
            found[gain] = f"{first}, {_with_unit(table.find(name), sets[-1])}"
    return found


def _with_unit(row: Parameter, value: float) -> float | str:
    """Return a value as it is written: with its unit, where it has one."""
    return value if row.unit == "1" else f"{value!r} {row.unit}"
