"""The YAML file beside a description that gives its rotors: its name, its schema, its lines."""

import dataclasses
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from workbench.common.errors import WorkbenchError
from workbench.common.yaml_files import Keys, YamlFile, check_schema, dotted, read_yaml
from workbench.plant.rotor_sources.tags import refuse_crowd

_SUFFIXES = (".xacro", ".urdf", ".sdf", ".xml", ".world")


@dataclass
class Shared:
    """What several rotors may share; units as in `Rotor`.

    `axis` is thrust's in the link's frame, and `direction` (cw or ccw) is seen from its tip.
    `inertia` None stands for that of the link that turns.
    """

    link: str | None = None
    axis: list[float] | None = None
    direction: str | None = None
    motor_constant: float | None = None
    moment_constant: float | None = None
    time_constant_up: float | None = None
    time_constant_down: float | None = None
    max_rot_velocity: float | None = None
    rotor_drag_coefficient: float = 0.0
    rolling_moment_coefficient: float = 0.0
    inertia: float | None = None
    inflow_coefficient: float = 0.0
    ground_effect_coefficient: float = 0.0
    propeller_radius: float = 0.0
    linear_motor_constant: float = 0.0


@dataclass
class Entry(Shared):
    """One rotor: at a position in its link's frame [m], or on a joint, which gives its axis too.

    On a joint, `direction` is about the joint's axis, as in a motor-model plugin.
    """

    name: str | None = None
    joint: str | None = None
    position: list[float] | None = None


@dataclass
class BatteryRows:
    """The battery; units as in `BatteryPack`."""

    capacity: float = 0.0
    resistance: float = 0.0
    open_circuit_voltage: list[list[float]] = field(default_factory=list)


@dataclass
class BodyRows:
    """The whole drone, rotors at standstill: mass [kg], its centre in the base link's frame [m].

    `inertia` is about the centre, along the base link's axes: xx, yy, zz, xy, xz, yz [kg·m²].
    """

    mass: float = 0.0
    center_of_mass: list[float] = field(default_factory=list)
    inertia: list[float] = field(default_factory=list)


@dataclass
class IdentifiedRow:
    """A number that was identified, and between which it is in 95 of 100 cases."""

    name: str = ""
    unit: str = ""
    value: float = 0.0
    low: float = 0.0
    high: float = 0.0


@dataclass
class Sidecar:
    """The schema of the file."""

    body: BodyRows | None = None
    identified: list[IdentifiedRow] = field(default_factory=list)
    battery: BatteryRows | None = None
    defaults: Shared = field(default_factory=Shared)
    rotors: list[Entry] = field(default_factory=list)


@dataclass(frozen=True)
class Place:
    """A rotor's place in the file, for messages."""

    file: YamlFile
    index: int

    def where(self, key: str = "") -> str:
        """Return file and line of a rotor's key, or of that in the defaults."""
        keys: Keys = ("rotors", self.index, key)
        if keys not in self.file.lines and ("defaults", key) in self.file.lines:
            keys = ("defaults", key)
        return self.file.where(*keys).removesuffix(": ")

    def fault(self, key: str, reason: str) -> WorkbenchError:
        """Return the error for a key."""
        name = dotted(("rotors", self.index, key))
        return WorkbenchError(f"{self.where(key)}: {name} {reason}")


def sidecar_name(description: Path) -> str:
    """Return the name that a description's own sidecar has: `drone.urdf.xacro` asks for `drone`."""
    stem = description.name
    while (suffix := Path(stem).suffix) in _SUFFIXES:
        stem = stem.removesuffix(suffix)
    return f"{stem}.rotors.yaml"


def find_sidecar(description: Path) -> Path | None:
    """Return a description's own sidecar, or `rotors.yaml` beside it, if there is one."""
    for name in (sidecar_name(description), "rotors.yaml"):
        path = description.parent / name
        try:
            if path.is_file():
                return path
        except OSError:  # the name is too long to be one
            continue
    return None


def load_body(path: Path) -> tuple[YamlFile, BodyRows] | None:
    """Return the body of a sidecar, with the file for messages; None where there is none.

    Raises:
        WorkbenchError: with file and line, for what is unknown or of another type.
    """
    file = _with_numbers(read_yaml(path))
    check_schema(file, Sidecar)
    rows = file.data.get("body")
    return (file, BodyRows(**rows)) if rows else None


def load_identified(path: Path) -> list[IdentifiedRow]:
    """Return what a sidecar says was identified, with intervals.

    Raises:
        WorkbenchError: with file and line, for what is unknown or of another type.
    """
    file = _with_numbers(read_yaml(path))
    check_schema(file, Sidecar)
    return [IdentifiedRow(**row) for row in file.data.get("identified", [])]


def load_battery(path: Path) -> tuple[YamlFile, BatteryRows] | None:
    """Return the battery of a sidecar, with the file for messages; None where there is none.

    Raises:
        WorkbenchError: with file and line, for what is unknown or of another type.
    """
    file = _with_numbers(read_yaml(path))
    check_schema(file, Sidecar)
    rows = file.data.get("battery")
    return (file, BatteryRows(**rows)) if rows else None


def load_sidecar(path: Path) -> list[tuple[Place, Entry]]:
    """Return the rotors that a sidecar lists, with what they share filled in.

    Raises:
        WorkbenchError: with file and line, for what is unknown or of another type.
    """
    file = _with_numbers(read_yaml(path))
    check_schema(file, Sidecar)
    rotors = file.data.get("rotors")
    if not rotors:
        raise WorkbenchError(f"{file.where('rotors')}list the rotors under 'rotors:'")
    refuse_crowd(path, len(rotors))
    shared = file.data.get("defaults", {})
    return [(Place(file, index), Entry(**{**shared, **own})) for index, own in enumerate(rotors)]


def _with_numbers(file: YamlFile) -> YamlFile:
    """Return a file with 1e-5, which to YAML is a text, and its like as the numbers they are."""
    data = {
        key: [_numbered(item) for item in value] if isinstance(value, list) else _numbered(value)
        for key, value in file.data.items()
    }
    return dataclasses.replace(file, data=data)


def _numbered(block: Any) -> Any:
    """Return a rotor, or what rotors share, with numbers for all texts that look like one."""
    if not isinstance(block, dict):
        return block
    texts = ("name", "joint", "link", "direction", "unit")
    plain = {key: value if key in texts else _number(value) for key, value in block.items()}
    if plain.get("direction") in (1, -1):  # as `workbench inspect --json` has it
        plain["direction"] = "ccw" if plain["direction"] == 1 else "cw"
    return plain


def _number(value: Any) -> Any:
    if isinstance(value, list):
        return [_number(item) for item in value]
    try:
        return float(value) if isinstance(value, str) else value
    except ValueError:
        return value
