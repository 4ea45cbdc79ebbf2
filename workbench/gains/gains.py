"""Gains: gain files with their history, and the values for a flight.

Values come from the defaults, the rule, gain files and settings; each replaces those before.
"""

import dataclasses
import logging
import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from datetime import UTC, datetime
from numbers import Real
from pathlib import Path
from typing import Any, NamedTuple

from workbench.common.errors import WorkbenchError, unknown_name
from workbench.common.own_file import own_errors
from workbench.common.plain_files import read_plain_text, write_atomically
from workbench.common.resources import find_file
from workbench.common.yaml_files import MOST_BYTES, YamlFile, read_yaml
from workbench.control.controller import DEFAULT, Controller, is_shipped, load_controller
from workbench.control.schedule import split_label, with_label
from workbench.plant.drag import drag_area
from workbench.plant.vehicle import Vehicle
from workbench.scenario.parameters import Parameter, ParameterTable, check_settings, parameter_table

MOST_SAVES = 200
"""Largest number of saves in the history; the oldest are dropped."""
_KEYS = ("vehicle", "controller", "origin", "gains", "history")
_POWERS = str.maketrans({"²": "^2", "³": "^3"})
_SAVE_KEYS = ("saved", "origin", "changed")
DIGITS = 3
"""Number of significant digits of a value from a rule."""
_OF_BATTERY = {"battery_duration": "hover_duration", "sag_compensation": "sag_compensation"}
"""Attribute of a battery that gives a parameter."""


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
    controller: str = DEFAULT


def owner_of(path: Path) -> str:
    """Return the name of the controller of a gain file.

    Raises:
        WorkbenchError: if the file cannot be read.
    """
    return str(read_yaml(path).data.get("controller") or DEFAULT)


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
                "save them in another file"
            )
        comment = _leading_comment(read_plain_text(path, MOST_BYTES))
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
    """Return the number of a value that may have a unit."""
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
    """Return the text of a gain file."""
    import yaml  # slow to load, and rarely needed

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
    """Return values as written: those of all sets of a scheduled gain in one line."""
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
    """Return a value as written, with its unit if it has one."""
    return value if row.unit == "1" else f"{value!r} {row.unit}"


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


def _read_save(file: YamlFile, index: int, entry: Any) -> Save:
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


def _is_value(value: Any) -> bool:
    """Return whether this is a number or None."""
    return value is None or (isinstance(value, Real) and not isinstance(value, bool))


class GainChange(NamedTuple):
    """A gain in two sets.

    Attributes:
        name: of the parameter.
        unit: of both values.
        a: value in the first set.
        b: value in the second.
        percent: difference of b from a, relative to the size of a; NaN if a is 0.
    """

    name: str
    unit: str
    a: float
    b: float
    percent: float


def diff_gains(
    a: Mapping[str, float],
    b: Mapping[str, float],
    missing: Mapping[str, float],
    controller: Controller | None = None,
) -> tuple[GainChange, ...]:
    """Compare the gains of two files.

    Args:
        a: value by name.
        b: value by name.
        missing: value by name for gains that only one of them has, from `gains.rule_values`.
        controller: of the gains; None for the default one.

    Returns:
        A row for every name in either, equal ones too, in the order of the parameter table.
    """
    all_a, all_b = {**missing, **a}, {**missing, **b}
    return tuple(
        _change(row.name, row.unit, all_a[row.name], all_b[row.name])
        for row in parameter_table(controller)
        if row.name in a or row.name in b
    )


def _change(name: str, unit: str, a: float, b: float) -> GainChange:
    if a == b:
        return GainChange(name, unit, a, b, 0.0)
    return GainChange(name, unit, a, b, 100.0 * (b - a) / abs(a) if a else math.nan)


@dataclass(frozen=True)
class Gain:
    """The value of a parameter, and its origin: default, rule, a file, or --set."""

    value: float
    origin: str


def rule_gains(vehicle: Vehicle, controller: Controller | None = None) -> dict[str, float]:
    """Return the values of the live parameters that follow from the vehicle, by name.

    They are within the limits of the parameter table. The formulas are part of the controller.

    Raises:
        WorkbenchError: if the controller's rule fails.
    """
    table = parameter_table(controller)
    law = table.controller
    values: dict[str, float] = {}
    if law.rule is not None:
        with own_errors(law.file, "rule"):
            values = dict(law.rule(vehicle))
    values["drag_area"] = drag_area(vehicle.mass)
    if vehicle.battery:
        stated = {name: getattr(vehicle.battery, of) for name, of in _OF_BATTERY.items()}
        values |= {name: value for name, value in stated.items() if value is not None}
    found = {}
    for name, value in values.items():
        row = table.find(name, f"{law.file}: rule: ")
        found[name] = min(row.maximum, max(row.minimum, float(f"{value:.{DIGITS}g}")))
    return found


def rule_values(vehicle: Vehicle, controller: Controller | None = None) -> dict[str, float]:
    """Return all values for a vehicle without a gain file: defaults, and those of the rule."""
    return {**parameter_table(controller).defaults(), **rule_gains(vehicle, controller)}


def flight_gains(
    vehicle: Vehicle,
    gains: str = "",
    settings: Mapping[str, float] | None = None,
    controller: Controller | None = None,
) -> dict[str, float]:
    """Return all parameter values of a flight: of the vehicle, then a gain file, then settings.

    Args:
        vehicle: what flies.
        gains: path of a gain file, or "" for none.
        settings: values by name.
        controller: of the parameters; None for the default one.

    Raises:
        WorkbenchError: for an unknown name or a value out of range, with file and line for a file.
    """
    chosen = choose_gains(vehicle, gains, settings, controller)
    return {name: choice.value for name, choice in chosen.items()}


def make_profile(
    vehicle: Vehicle,
    values: Mapping[str, float],
    origin: str,
    controller: Controller | None = None,
) -> GainFile:
    """Return the gain file of a vehicle: its controller's parameters, and other values of its rule.

    Args:
        vehicle: its name goes into the file.
        values: parameter values by name; others are left out.
        origin: of the values, as a sentence.
        controller: of the parameters; None for the default one.
    """
    table, ruled = parameter_table(controller), rule_gains(vehicle, controller)
    names = ruled.keys() - _OF_BATTERY.keys()  # the description has those
    rows = [row.name for row in table if row.system == "controller" or row.name in names]
    kept = {name: values[name] for name in rows if name in values}
    return GainFile(vehicle.name, origin, kept, controller=table.controller.name)


def choose_gains(
    vehicle: Vehicle,
    gains: str = "",
    settings: Mapping[str, float] | None = None,
    controller: Controller | None = None,
) -> dict[str, Gain]:
    """Return the values of `flight_gains`, each with its origin.

    Arguments and exceptions are the same as for `flight_gains`.
    """
    table = parameter_table(controller)
    layers: list[tuple[str, Mapping[str, float]]] = [
        ("default", table.defaults()),
        ("rule", rule_gains(vehicle, controller)),
    ]
    beside = vehicle.source.parent / "gains.yaml"
    # they are for one controller; another one begins with its rule
    law = table.controller
    if beside.is_file() and owner_of(beside) in (law.name, law.unscheduled):
        layers.append((str(beside), load_gains(beside, table.controller).gains))
    if gains:
        layers.append((gains, load_gains(find_file(gains), table.controller).gains))
    layers.append(("--set", table.checked(settings or {})))
    check_settings(vehicle, settings or {}, table)
    return {name: Gain(value, origin) for origin, layer in layers for name, value in layer.items()}


def remark_on_owner(path: str, vehicle: str, controller: Controller | None = None) -> None:
    """Remark on a gain file for another vehicle; as gains are normalised, it may still work."""
    owner = load_gains(find_file(path), controller).vehicle if path else ""
    if owner and owner != vehicle:
        logging.getLogger("workbench").warning(
            "the gains in %s are for '%s', but '%s' flies with them", path, owner, vehicle
        )
