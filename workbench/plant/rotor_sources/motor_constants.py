"""The constants of Gazebo's motor model, and what holds where a description leaves them out."""

from dataclasses import asdict, dataclass, replace
from pathlib import Path

from workbench.plant.model import Joint, Link, Model
from workbench.plant.remarks import Remarks
from workbench.plant.rotor_sources.mount import Mount
from workbench.plant.rotor_sources.spin import spin_inertia
from workbench.plant.rotor_sources.tags import Tags
from workbench.plant.rotors import Rotor


@dataclass(frozen=True)
class MotorConstants:
    """What Gazebo has a default for; units as in `Rotor`."""

    moment_constant: float
    time_constant_up: float
    time_constant_down: float
    max_rot_velocity: float
    velocity_slowdown: float
    rotor_drag_coefficient: float = 0.0
    rolling_moment_coefficient: float = 0.0
    inertia: float | None = None
    """None where it is not stated, and that of the rotor's link counts."""
    inflow_coefficient: float = 0.0
    ground_effect_coefficient: float = 0.0
    propeller_radius: float = 0.0
    linear_motor_constant: float = 0.0


# kDefault... in rotors_gazebo_plugins' gazebo_motor_model.h and common.h (the slowdown), the same
# in PX4's gazebo_motor_model.h and as members in gz-sim's MulticopterMotorModel.cc.
GAZEBO = MotorConstants(
    moment_constant=0.016,
    time_constant_up=1.0 / 80.0,
    time_constant_down=1.0 / 40.0,
    max_rot_velocity=838.0,
    velocity_slowdown=10.0,
)


CONSTANTS = (
    "motorConstant",
    "momentConstant",
    "timeConstantUp",
    "timeConstantDown",
    "maxRotVelocity",
    "rotorVelocitySlowdownSim",
    "rotorDragCoefficient",
    "rollingMomentCoefficient",
    "rotorInertia",
    "inflowCoefficient",
    "groundEffectCoefficient",
    "propellerRadius",
    "linearMotorConstant",
)
"""Tags that are used."""


def read_constants(
    tags: Tags, otherwise: MotorConstants, source: str, element: str, remarks: Remarks
) -> MotorConstants:
    """Return the constants that a plugin gives, with others for those that it leaves out.

    Args:
        tags: of the plugin.
        otherwise: what to take for the missing ones.
        source: whose figures those are, for the remark.
        element: what the remark is about.
        remarks: where to note what was missing.

    Raises:
        WorkbenchError: for a constant that is no positive number, or a negative coefficient.
    """
    missing: list[str] = []

    def constant(tag: str, default: float) -> float:
        if tags.has(tag):
            return tags.positive(tag)
        missing.append(f"{tag} {default:g}")
        return default

    found = MotorConstants(
        moment_constant=constant("momentConstant", otherwise.moment_constant),
        time_constant_up=constant("timeConstantUp", otherwise.time_constant_up),
        time_constant_down=constant("timeConstantDown", otherwise.time_constant_down),
        max_rot_velocity=constant("maxRotVelocity", otherwise.max_rot_velocity),
        velocity_slowdown=tags.positive("rotorVelocitySlowdownSim")
        if tags.has("rotorVelocitySlowdownSim")
        else otherwise.velocity_slowdown,  # without a remark: it is for the picture only
        rotor_drag_coefficient=_or_none(tags, "rotorDragCoefficient"),
        rolling_moment_coefficient=_or_none(tags, "rollingMomentCoefficient"),
        inertia=tags.not_negative("rotorInertia") if tags.has("rotorInertia") else None,
        inflow_coefficient=_or_none(tags, "inflowCoefficient"),
        ground_effect_coefficient=_or_none(tags, "groundEffectCoefficient"),
        propeller_radius=_or_none(tags, "propellerRadius"),
        linear_motor_constant=_or_none(tags, "linearMotorConstant"),
    )
    note_assumed(missing, source, tags.file, element, remarks)
    return found


def _or_none(tags: Tags, tag: str) -> float:
    """Return a coefficient, 0 where it is left out: Gazebo's 1e-4 would hold a small drone fast."""
    return tags.not_negative(tag) if tags.has(tag) else 0.0


def note_assumed(
    missing: list[str], source: str, file: Path, element: str, remarks: Remarks
) -> None:
    """Note constants that a description leaves out, each as a name and the value taken."""
    if missing:
        remarks.add("assumed", file, element, f"{', '.join(missing)}: not given, {source}")


def make_rotor(
    model: Model,
    joint: Joint,
    link: Link,
    mount: Mount,
    direction: int,
    motor_constant: float,
    constants: MotorConstants,
    tags: Tags,
    remarks: Remarks,
) -> Rotor:
    """Return the rotor that a plugin turns, with the inertia of its link where none is stated.

    Args:
        model: which declares the plugin.
        joint: that turns.
        link: that turns with it.
        mount: where the hub is, and which way it pushes.
        direction: +1 turns counter-clockwise seen from the tip of the axis, -1 clockwise.
        motor_constant: thrust over squared speed [N·s²].
        constants: the others.
        tags: of the plugin.
        remarks: where to note what was assumed.
    """
    inertia = constants.inertia
    if inertia is None:
        inertia = spin_inertia(
            model,
            joint,
            motor_constant=motor_constant,
            slowdown=constants.velocity_slowdown,
            file=tags.file,
            remarks=remarks,
        )
    return Rotor(
        name=joint.name,
        joint=joint.name,
        link=link.name,
        p_BR=mount.p_BR,
        axis_B=mount.axis_B,
        direction=direction,
        motor_constant=motor_constant,
        **asdict(replace(constants, inertia=inertia)),
    )
