"""Find the joints that tilt the rotors of a vehicle."""

from dataclasses import replace

import numpy as np

from workbench.common.vectors import float_triple
from workbench.plant.model import Model
from workbench.plant.remarks import Remarks
from workbench.plant.rotor_sources.mount import body_pose
from workbench.plant.rotors import Rotor, rotor_rank
from workbench.plant.servo import Servo
from workbench.plant.tilt import Tilt, TiltedRotor

MIN_TILT_SINE = 0.5
"""Sine of the angle between a rotor's axis and that of a joint below which it does not tilt it."""
TILT_DAMPING_RATIO = 0.7
"""Of a rate servo that takes angles."""


def with_tilts(
    model: Model, base_link: str, rotors: tuple[Rotor, ...], remarks: Remarks
) -> tuple[Model, tuple[Tilt, ...]]:
    """Return the joints that the law tilts, and the model with servos that take angles there.

    They are needed, and used, where the rotors alone cannot control thrust, roll, pitch and yaw.

    Args:
        model: with its servos.
        base_link: its frame is B.
        rotors: of the vehicle.
        remarks: receives a remark on each rate servo that takes angles instead.
    """
    if not rotors or rotor_rank(rotors) == 4:
        return model, ()
    turns: dict[str, list[TiltedRotor]] = {}
    for index, rotor in enumerate(rotors):
        above = model.moving_joints_above(rotor.link)
        if len(above) != 1 or len(above[0].freedoms) != 1:
            continue
        (joint,) = above
        leader = model.joint(joint.mimic.joint) if joint.mimic else joint
        if leader is None or len(leader.freedoms) != 1:
            continue
        freedom, scale = joint.freedoms[0], joint.mimic.multiplier if joint.mimic else 1.0
        servo = leader.freedoms[0].servo
        X_BJ = body_pose(model, base_link) @ joint.X_MJ
        axis = X_BJ.rotation().multiply(np.array(freedom.axis_J))
        sine = float(np.linalg.norm(np.cross(axis, rotor.axis_B)))
        if not servo or servo.kind == "effort" or freedom.kind != "revolute":
            continue
        if sine >= MIN_TILT_SINE:
            point = float_triple(X_BJ.multiply(np.array(freedom.p_J)))
            turns.setdefault(leader.name, []).append(
                TiltedRotor(index, point, float_triple(scale * axis))
            )
    joints = {joint.name: joint for joint in model.joints}
    tilts = []
    for name, turned in turns.items():
        joint = joints[name]
        (freedom,) = joint.freedoms
        servo = freedom.servo
        assert servo
        if servo.kind == "velocity":
            servo = _angle_servo(servo)
            text = "it tilts a rotor: its rate servo takes angles"
            remarks.add("assumed", model.source, f"servo of joint '{name}'", text)
        servo = replace(
            servo,
            lower=max(servo.lower, freedom.lower),
            upper=min(servo.upper, freedom.upper),
        )
        joints[name] = replace(joint, freedoms=(replace(freedom, servo=servo),))
        lower, upper = max(servo.lower, -0.5 * np.pi), min(servo.upper, 0.5 * np.pi)
        tilts.append(Tilt(joint.freedom_names[0], lower, upper, tuple(turned)))
    return replace(model, joints=tuple(joints.values())), tuple(tilts)


def _angle_servo(servo: Servo) -> Servo:
    """Return a rate servo as one of position: its rate is proportional to the angle that is left.

    The stiffness, which needs the inertia, is that of the damping ratio `TILT_DAMPING_RATIO`.
    """
    return replace(
        servo,
        kind="position",
        stiffness=None,
        damping_ratio=TILT_DAMPING_RATIO,
        lower=-np.inf,
        upper=np.inf,
        max_rate=min(servo.max_rate, max(abs(servo.lower), abs(servo.upper))),
        start=0.0,
    )
