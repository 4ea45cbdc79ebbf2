"""Gains: gain files with their history, and the values for a flight.

Values come from the defaults, the rule, gain files and settings; each replaces those before.
"""

import dataclasses
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from datetime import UTC, datetime
from pathlib import Path
from typing import Any

from workbench.common.errors import WorkbenchError, unknown_name
from workbench.common.parameter import Parameter
from workbench.common.plain_files import read_plain_text, write_atomically
from workbench.common.resources import find_file
from workbench.common.yaml_files import MAX_YAML_BYTES, read_yaml
from workbench.control.controller import Controller
from workbench.control.controller_file import load_controller
from workbench.control.installed_laws import DEFAULT_CONTROLLER, is_shipped
from workbench.control.schedule import split_label, with_label
from workbench.gains.gain_history import Save, next_save, read_history, values_at, write_history

MAX_HISTORY_SAVES = 200
"""Largest number of saves in the history; the oldest are dropped."""
_GAIN_FILE_KEYS = ("vehicle", "controller", "origin", "gains", "history")
_POWER_CHARACTERS = str.maketrans({"²": "^2", "³": "^3"})


@dataclass(frozen=True)
class GainFile:
    """A set of parameter values, with their vehicle and their origin.

    Attributes:
        vehicle: its name.
        origin: a sentence.
        gains: value by name.
        history: the saved states, oldest first; the last one is the present.
        controller: name of the one that has these parameters.
    """

    vehicle: str
    origin: str
    gains: Mapping[str, float]
    history: tuple[Save, ...] = ()
    controller: str = DEFAULT_CONTROLLER


def owner_of(path: Path) -> str:
    """Return the name of the controller of a gain file.

    Raises:
        WorkbenchError: if the file cannot be read.
    """
    return str(read_yaml(path).data.get("controller") or DEFAULT_CONTROLLER)


def flown_by(controller: str, gains: str) -> str:
    """Return a controller with the gain schedule of a gain file, if it has one.

    Args:
        controller: as read by `load_controller`.
        gains: path of a gain file, or "" for none.

    Raises:
        WorkbenchError: if one of them cannot be read.
    """
    if not gains:
        return controller
    owner, label = split_label(owner_of(find_file(gains)))
    law = load_controller(controller)
    return with_label(controller, label if law.name == owner else "")


def load_gains(path: Path | str, controller: Controller | None = None) -> GainFile:
    """Read and check a gain file.

    Args:
        path: the file.
        controller: the one to fly with it; None for the shipped one that the file names.

    Raises:
        WorkbenchError: with file and line of the error.
    """
    file = read_yaml(Path(path))
    for key in file.data:
        if key not in _GAIN_FILE_KEYS:
            raise WorkbenchError(
                f"{file.where(key)}{unknown_name('key', str(key), _GAIN_FILE_KEYS)}"
            )
    owner = str(file.data.get("controller") or DEFAULT_CONTROLLER)
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
            f"{controller.name} flies: give it its own gains, or let {owner} fly (--controller)"
        )
    gains = file.data.get("gains")
    if not isinstance(gains, dict):
        raise WorkbenchError(
            f"{file.where('gains')}a gain file has 'gains:' with NAME: VALUE lines"
        )
    values = {}
    for name, value in gains.items():
        where = file.where("gains", str(name))
        rows = controller.table.sets(str(name), where)
        for row, one in zip(rows, _of_sets(rows, value, where), strict=True):
            values[row.name] = row.check(_without_unit(row, one, where), where)
    return GainFile(
        vehicle=str(file.data.get("vehicle") or ""),
        origin=str(file.data.get("origin") or ""),
        gains=values,
        history=read_history(file),
        controller=owner,
    )


def save_gains(path: Path | str, gains: GainFile, controller: Controller | None = None) -> GainFile:
    """Write a gain file atomically, and add to the history of an existing one.

    The values replaced become the previous state in the history; the history of `gains` itself is
    not written. The comment at the head of a file is kept, other comments are not. If nothing
    differs from the file, its history does not change.

    Args:
        path: the file.
        gains: vehicle, origin and values.
        controller: of the gains; None for the shipped one that they name.

    Returns:
        The content of the file.

    Raises:
        WorkbenchError: if a value is out of range, the file cannot be written, or an existing file
            is not a gain file or is for another vehicle.
    """
    path = Path(path)
    law = controller or load_controller(gains.controller)
    values = law.table.checked(gains.gains)
    ordered = {row.name: values[row.name] for row in law.table if row.name in values}
    now = datetime.now(UTC).isoformat(timespec="seconds").replace("+00:00", "Z")
    history: tuple[Save, ...] = (Save(now, gains.origin, {}),)
    comment = ""
    if path.exists():
        old = load_gains(path, law)
        if old.vehicle and gains.vehicle and old.vehicle != gains.vehicle:
            raise WorkbenchError(
                f"{path}: has the gains of '{old.vehicle}', and these are of '{gains.vehicle}': "
                "save them in another file"
            )
        comment = _leading_comment(read_plain_text(path, MAX_YAML_BYTES))
        save = next_save(now, gains.origin, old.gains, ordered)
        if save.changed or (old.vehicle, old.origin) != (gains.vehicle, gains.origin):
            history = (*(old.history or (Save("", old.origin, {}),)), save)
        else:
            history = old.history
    written = dataclasses.replace(gains, gains=ordered, history=history[-MAX_HISTORY_SAVES:])
    write_atomically(path, comment + gain_file_text(written, law))
    return written


def gains_at(gains: GainFile, index: int, controller: Controller | None = None) -> GainFile:
    """Return an earlier state of a gain file.

    Args:
        gains: the present state, with its history.
        index: of the state, 0 for the oldest.
        controller: of the gains; None for the shipped one that they name.

    Raises:
        WorkbenchError: if there is no such state, or its values are no longer valid.
    """
    last = len(gains.history) - 1
    if not 0 <= index <= last:
        known = f"has states 0 to {last}" if last >= 0 else "has no history yet"
        raise WorkbenchError(f"there is no state {index}: the gain file {known}")
    values = values_at(gains.gains, gains.history[index + 1 :])
    law = controller or load_controller(gains.controller)
    origin = gains.history[index].origin
    return GainFile(gains.vehicle, origin, law.table.checked(values), controller=gains.controller)


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
    """Return the number of a value that may have a unit."""
    if not isinstance(value, str):
        return value
    number, _, unit = value.strip().partition(" ")
    unit = unit.strip().translate(_POWER_CHARACTERS)
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


def gain_file_text(gains: GainFile, law: Controller) -> str:
    """Return the text of a gain file."""
    import yaml  # slow to load, and rarely needed

    whose = {} if gains.controller == DEFAULT_CONTROLLER else {"controller": gains.controller}
    head = {
        "vehicle": gains.vehicle,
        **whose,
        "origin": gains.origin,
        "gains": _written_values(gains.gains, law),
    }
    style: dict[str, Any] = {"sort_keys": False, "allow_unicode": True, "width": 100}
    text: str = yaml.safe_dump(head, default_flow_style=False, **style)
    if gains.history:
        history = {"history": write_history(gains.history)}
        text += yaml.safe_dump(history, default_flow_style=None, **style)
    return text


def _written_values(gains: Mapping[str, float], law: Controller) -> dict[str, float | str]:
    """Return values as written: those of all sets of a scheduled gain in one line."""
    found, table, schedule = {}, law.table, law.schedule
    for name, value in gains.items():
        number = schedule.number_of(name) if schedule else None
        if schedule is None or number is None:
            found[name] = _with_unit(table.find(name), value)
            continue
        gain = law.gain_of(name)
        sets = [gains[each] for each in schedule.names(gain) if each in gains]
        if len(sets) < len(schedule.values):
            found[name] = _with_unit(table.find(name), value)
        else:
            first = ", ".join(repr(each) for each in sets[:-1])
            found[gain] = f"{first}, {_with_unit(table.find(name), sets[-1])}"
    return found


def _with_unit(row: Parameter, value: float) -> float | str:
    """Return a value as written, with its unit if it has one."""
    return value if row.unit == "1" else f"{value!r} {row.unit}"
