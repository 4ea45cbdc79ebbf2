"""The sidecar of a description: a YAML file beside it, with rotors, servos, body and battery."""

import math
from collections.abc import Sequence
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np

from workbench.common.errors import WorkbenchError
from workbench.common.vectors import Vector3, float_triple
from workbench.common.yaml_files import (
    Keys,
    YamlFile,
    as_record,
    check_schema,
    dotted,
    read_yaml,
    with_numbers,
)
from workbench.plant.model import Joint, Link, Model
from workbench.plant.remarks import Remarks
from workbench.plant.rotor_sources.motor_constants import OPTIONAL_ROTOR_FIELDS, spin_inertia
from workbench.plant.rotor_sources.mount import (
    Mount,
    body_pose,
    mount_on_joint,
)
from workbench.plant.rotor_sources.names import find_joint, find_link
from workbench.plant.rotor_sources.tags import (
    MAX_MOTOR_CONSTANT,
    MIN_MOTOR_CONSTANT,
    ROTOR_DIRECTIONS,
    refuse_too_many_rotors,
)
from workbench.plant.rotors import Rotor

_DESCRIPTION_SUFFIXES = (".xacro", ".urdf", ".sdf", ".xml", ".world")
_REQUIRED_CONSTANTS = (
    "motor_constant",
    "moment_constant",
    "time_constant_up",
    "time_constant_down",
    "max_rot_velocity",
)
"""Constants of a rotor that the file must state."""


@dataclass
class SharedConstants:
    """The constants that several rotors may share; units as in `Rotor`.

    `axis` is the axis of thrust in the frame of the link, and `direction` (cw or ccw) is seen from
    its tip. If `inertia` is None, it is that of the turning link.
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
class RotorEntry(SharedConstants):
    """One rotor: at a position in the frame of its link [m], or on a joint, which has an axis.

    On a joint, `direction` is about the joint's axis, as in a motor-model plugin.
    """

    name: str | None = None
    joint: str | None = None
    position: list[float] | None = None


@dataclass
class ServoEntry:
    """What drives a joint; see `Servo`, in the units of the joint.

    `kind` is position, velocity or effort; `axis` counts the freedoms of the joint from 0.
    """

    joint: str = ""
    axis: int = 0
    kind: str = "position"
    stiffness: float | None = None
    damping: float | None = None
    damping_ratio: float = 1.0
    lower: float | None = None
    upper: float | None = None
    start: float = 0.0
    max_effort: float = 0.0
    max_rate: float = 0.0
    time_constant: float = 0.0
    delay: float = 0.0


@dataclass
class BatteryRows:
    """The battery; units as in `BatteryPack`."""

    capacity: float = 0.0
    resistance: float = 0.0
    open_circuit_voltage: list[list[float]] = field(default_factory=list)
    hover_duration: float | None = None
    sag_compensation: float | None = None


@dataclass
class BodyRows:
    """The whole drone with rotors at rest: mass [kg], centre of mass in the base link's frame [m].

    `inertia` is about the centre of mass along the base link's axes: xx, yy, zz, xy, xz, yz
    [kg·m²].
    """

    mass: float = 0.0
    center_of_mass: list[float] = field(default_factory=list)
    inertia: list[float] = field(default_factory=list)


@dataclass
class IdentifiedRow:
    """An identified number with its 95 % interval."""

    name: str = ""
    unit: str = ""
    value: float = 0.0
    low: float = 0.0
    high: float = 0.0


@dataclass
class Sidecar:
    """The schema of a sidecar."""

    body: BodyRows | None = None
    identified: list[IdentifiedRow] = field(default_factory=list)
    battery: BatteryRows | None = None
    defaults: SharedConstants = field(default_factory=SharedConstants)
    rotors: list[RotorEntry] = field(default_factory=list)
    servos: list[ServoEntry] = field(default_factory=list)


@dataclass(frozen=True)
class RotorLocation:
    """The place of a rotor in the file, for messages."""

    file: YamlFile
    index: int

    def where(self, key: str = "") -> str:
        """Return file and line of a rotor's key, or of the same key in the defaults."""
        keys: Keys = ("rotors", self.index, key)
        if keys not in self.file.lines and ("defaults", key) in self.file.lines:
            keys = ("defaults", key)
        return self.file.where(*keys).removesuffix(": ")

    def fault(self, key: str, reason: str) -> WorkbenchError:
        """Return the error for a key."""
        name = dotted(("rotors", self.index, key))
        return WorkbenchError(f"{self.where(key)}: {name} {reason}")


def sidecar_name(description: Path) -> str:
    """Return the name of the sidecar of one description, such as drone.rotors.yaml."""
    stem = description.name
    while (suffix := Path(stem).suffix) in _DESCRIPTION_SUFFIXES:
        stem = stem.removesuffix(suffix)
    return f"{stem}.rotors.yaml"


def find_sidecar(description: Path) -> Path | None:
    """Return the sidecar of a description, or else `rotors.yaml` beside it, or None."""
    for name in (sidecar_name(description), "rotors.yaml"):
        path = description.parent / name
        try:
            if path.is_file():
                return path
        except OSError:  # the name is too long for a file
            continue
    return None


def load_sidecar(path: Path) -> tuple[YamlFile, Sidecar]:
    """Return the content of a sidecar, with the file for messages.

    Raises:
        WorkbenchError: with file and line, for an unknown key or a value of the wrong type.
    """
    file = with_numbers(read_yaml(path), Sidecar)
    rotors = file.data.get("rotors")
    for block in (file.data.get("defaults"), *(rotors if isinstance(rotors, list) else ())):
        if isinstance(block, dict) and block.get("direction") in (1, -1):
            # as `workbench inspect --json` has it
            block["direction"] = "ccw" if block["direction"] == 1 else "cw"
    check_schema(file, Sidecar)
    return file, as_record(file.data, Sidecar)


def states_rotors(path: Path) -> bool:
    """Return whether a sidecar is the source of the rotors: with servos alone it is not."""
    _, sidecar = load_sidecar(path)
    return bool(sidecar.rotors) or not sidecar.servos


def _entries(path: Path) -> list[tuple[RotorLocation, RotorEntry]]:
    """Return the rotors in a sidecar, completed by what they share."""
    file, _ = load_sidecar(path)
    rotors = file.data.get("rotors")
    if not rotors:
        raise WorkbenchError(f"{file.where('rotors')}list the rotors under 'rotors:'")
    refuse_too_many_rotors(path, len(rotors))
    shared = file.data.get("defaults", {})
    return [
        (RotorLocation(file, index), RotorEntry(**{**shared, **own}))
        for index, own in enumerate(rotors)
    ]


def read_sidecar(path: Path, model: Model, base_link: str, remarks: Remarks) -> tuple[Rotor, ...]:
    """Return the rotors of a sidecar, in its order.

    Args:
        path: the YAML file; `Sidecar` is its schema.
        model: has the links and joints that it names.
        base_link: its frame is the body frame; it carries rotors without a link.
        remarks: receives remarks on repairs.

    Raises:
        WorkbenchError: with file and line, for a missing, unknown or invalid value.
    """
    rotors: list[Rotor] = []
    for place, entry in _entries(path):
        rotor = _sidecar_rotor(place, entry, model, base_link, remarks)
        if any(rotor.name == other.name for other in rotors):
            raise WorkbenchError(f"{place.where()}: two rotors are '{rotor.name}': rename one")
        rotors.append(rotor)
    return tuple(rotors)


def _sidecar_rotor(
    place: RotorLocation, entry: RotorEntry, model: Model, base_link: str, remarks: Remarks
) -> Rotor:
    """Return one rotor."""
    joint, link = _joint_and_link(place, entry, model, base_link)
    turn = ROTOR_DIRECTIONS.get(entry.direction or "")
    if turn is None:
        raise place.fault("direction", "must be cw or ccw")
    if joint:
        mount = mount_on_joint(model, base_link, joint, link, place.file.path, remarks)
    else:
        mount = _free_mount(place, entry, model, base_link, link)
    constants = {
        name: _positive_constant(place, name, getattr(entry, name)) for name in _REQUIRED_CONSTANTS
    }
    given = entry.inertia is not None
    for name in OPTIONAL_ROTOR_FIELDS:
        if name != "inertia" or given:
            constants[name] = _not_negative(place, name, getattr(entry, name))
    if joint and not given:
        constants["inertia"] = spin_inertia(
            model,
            joint,
            motor_constant=constants["motor_constant"],
            slowdown=1.0,
            file=place.file.path,
            remarks=remarks,
        )
    return Rotor(
        name=entry.name or (joint.name if joint else f"rotor_{place.index}"),
        joint=joint.name if joint else "",
        link=link.name,
        p_BR=mount.p_BR,
        axis_B=mount.axis_B,
        direction=turn * mount.sense,
        **constants,
    )


def _joint_and_link(
    place: RotorLocation, entry: RotorEntry, model: Model, base_link: str
) -> tuple[Joint | None, Link]:
    """Return the joint of a rotor, if it names one, and its link."""
    if entry.joint is None:
        name = base_link if entry.link is None else entry.link
        return None, find_link(model, name, place.where("link"))
    joint = find_joint(model, entry.joint, place.where("joint"))
    for key, value in (("position", entry.position), ("axis", entry.axis)):
        if value is not None:
            raise place.fault(
                key, f"is given together with the joint '{joint.name}': leave one out"
            )
    link = find_link(model, joint.child, place.where("joint"))
    if entry.link is not None and entry.link != link.name:
        raise place.fault("link", f"should be '{link.name}', which '{joint.name}' turns")
    return joint, link


def _free_mount(
    place: RotorLocation, entry: RotorEntry, model: Model, base_link: str, link: Link
) -> Mount:
    """Return the mount of a rotor given by position and axis in the frame of a link."""
    X_BL = body_pose(model, base_link) @ link.X_ML
    p_LR = _sidecar_vector(place, "position", entry.position)
    axis_L = _sidecar_vector(place, "axis", (0.0, 0.0, 1.0) if entry.axis is None else entry.axis)
    length = math.hypot(*axis_L)
    if length < 1e-9:
        raise place.fault("axis", "has no length: give it a direction")
    axis_B = X_BL.rotation().multiply(np.array(axis_L) / length)
    return Mount(float_triple(X_BL.multiply(np.array(p_LR))), float_triple(axis_B), 1)


def _sidecar_vector(place: RotorLocation, key: str, value: Sequence[float] | None) -> Vector3:
    if value is None:
        raise place.fault(key, "is missing: give it, or a joint")
    if len(value) != 3 or not all(abs(number) <= MAX_MOTOR_CONSTANT for number in value):
        raise place.fault(key, "should be three numbers: x, y, z")
    x, y, z = (float(number) for number in value)
    return (x, y, z)


def _positive_constant(place: RotorLocation, key: str, value: float | None) -> float:
    if value is None:
        raise place.fault(key, "is missing: give it here or under 'defaults:'")
    if key == "moment_constant" and value == 0.0:  # tilts make the yaw moment
        return 0.0
    if not MIN_MOTOR_CONSTANT <= value <= MAX_MOTOR_CONSTANT:
        raise place.fault(key, "should be a positive number")
    return float(value)


def _not_negative(place: RotorLocation, key: str, value: float) -> float:
    if not 0.0 <= value <= MAX_MOTOR_CONSTANT:
        raise place.fault(key, "should be a positive number, or 0")
    return float(value)
