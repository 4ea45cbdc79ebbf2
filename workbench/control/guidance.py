"""Guidance, the same for every control law: the reference, the flight mode, and the limits.

It gives the position error while a point is held or approached, and the commanded velocity and yaw
rate within limits. Pure functions, like the control laws, see `controllers.pd`.
"""

from typing import NamedTuple

from workbench.common.jitable import register_jitable
from workbench.common.vectors import Numbers, Quaternion, Vector3, Wrench
from workbench.control.obstacle_brake import braked
from workbench.plant.gravity import GRAVITY

CEILING_RATE = 1.0
"""The climb rate is limited to this times the distance to the largest height [1/s]."""
MIN_STEERING_SPEED_SQUARED = 1e-12
"""A pilot steers while the commanded velocity squared exceeds this: after a low-pass it decays, but
never to exactly zero [m²/s²]."""
BRAKING_SHARE = 0.5
"""Share of the largest horizontal acceleration that may be needed to stop before a wall."""


class Reference(NamedTuple):
    """The command of the pilot or a path, in W [m/s, rad/s, m]; `follow` 1 means go to p."""

    v_x: float
    v_y: float
    v_z: float
    yaw_rate: float
    p_x: float
    p_y: float
    p_z: float
    follow: float


class Guidance(NamedTuple):
    """What the flight mode allows and adds; weights are 0 or 1.

    `motors` 0 stops the rotors; `lift` 0 lets them idle; `authority` 0 ignores the reference;
    `climb` is the mode's own vertical velocity [m/s]; `hold_xy` and `hold_z` hold the point p [m]
    while the reference is zero.

    `brake` [1/s] and three walls limit the speed towards obstacles, see `obstacle_brake`; 0 sets no
    limit. A wall is the unit vector n towards it in W, and the offset n · p [m] of the point p at
    which to stop, all 0 without one.
    """

    motors: float
    lift: float
    authority: float
    climb: float
    hold_xy: float
    hold_z: float
    p_x: float
    p_y: float
    p_z: float
    brake: float = 0.0
    wall_1_x: float = 0.0
    wall_1_y: float = 0.0
    wall_1_z: float = 0.0
    wall_1_offset: float = 0.0
    wall_2_x: float = 0.0
    wall_2_y: float = 0.0
    wall_2_z: float = 0.0
    wall_2_offset: float = 0.0
    wall_3_x: float = 0.0
    wall_3_y: float = 0.0
    wall_3_z: float = 0.0
    wall_3_offset: float = 0.0


class MeasuredMotion(NamedTuple):
    """The motion as a law gets it; T is the frame of upright hover, see `plant.thrust_frame`.

    Attributes:
        p_WB: position [m].
        v_WBcm: velocity of the centre of mass in W [m/s].
        a_WBcm: its estimated acceleration in W [m/s²].
        q_WT: attitude, a quaternion w, x, y, z of any length but zero.
        w_WB: angular velocity in W [rad/s].
        drag: drag of still air over mass in W [m/s²], with the sign that compensates it.
        wrench: of the previous commands once the rotors have reached them: force along z of T [N]
            and moment in T [N·m].
        voltage: of the battery under load over that of the full battery without load; 1 without a
            battery.
        elapsed: for each part of the law that runs only in every n-th update, the time since it
            last ran [s], or 0 if it does not run in this update.
        joints: positions of the joints whose servos the law commands, in its order, then their
            velocities [rad, rad/s; m, m/s].
        time: of the flight [s]; 0 in linear models.
    """

    p_WB: Vector3
    v_WBcm: Vector3
    a_WBcm: Vector3
    q_WT: Quaternion
    w_WB: Vector3
    drag: Vector3
    wrench: Wrench
    voltage: float = 1.0
    elapsed: tuple[float, ...] = ()
    joints: tuple[float, ...] = ()
    time: float = 0.0


class KnownBody(NamedTuple):
    """The body as a law gets it.

    Attributes:
        mass: with the known payload [kg].
        inertia: xx, xy, xz, yy, yz, zz in T [kg·m²].
        yaw_drag: yaw deceleration by drag over the yaw rate [1/s].
        rotor_lag: time constant of the slowest rotor at hover [s].
        spin_up_time: lead of spin-up torque over drag torque in yaw [s].
        payload: known mass of the payload [kg].
    """

    mass: float
    inertia: Numbers
    yaw_drag: float
    rotor_lag: float
    spin_up_time: float
    payload: float = 0.0


class KnownRotor(NamedTuple):
    """A rotor as a law's `design` gets it.

    Force along z of T and moment about the centre of mass in T per thrust [1, m]; idle and largest
    thrust [N]; motor constant [N·s²] and linear speed [rad/s]: the thrust at a speed is
    motor_constant speed (speed + linear_speed).
    """

    force: float
    m_x: float
    m_y: float
    m_z: float
    idle_thrust: float
    max_thrust: float
    motor_constant: float
    linear_speed: float


class KnownVehicle(NamedTuple):
    """The vehicle as a law's `design` gets it: the fields of `KnownBody`, and the rotors."""

    mass: float
    inertia: Numbers
    yaw_drag: float
    rotor_lag: float
    spin_up_time: float
    payload: float
    rotors: tuple[KnownRotor, ...]


class LawSetpoint(NamedTuple):
    """The command: `Reference`, `Guidance`, and acceleration along a path in W (3) [m/s²]."""

    reference: Numbers
    guidance: Numbers
    a_WBcm: Vector3


class Gains(tuple[float, ...]):
    """The gains of a law: a named tuple of its own parameters, the common ones, and its designed
    numbers. Its file names them, so this class has them for type checkers alone.
    """

    _fields: tuple[str, ...]

    def __getattr__(self, name: str) -> float: ...
    def _replace(self, **numbers: float) -> "Gains": ...


class Memory(tuple[float, ...]):
    """The memory of a law: a named tuple of its states, see `Gains`."""

    def __getattr__(self, name: str) -> float: ...


LawResult = tuple[Wrench, tuple[float, ...]]
"""What a law returns: the wrench in T, followed by setpoints of servos if it commands any, and its
next memory."""


MOTORS_FIELD, LIFT_FIELD = (Guidance._fields.index(name) for name in ("motors", "lift"))
BRAKE_FIELD = Guidance._fields.index("brake")
FIRST_WALL_FIELD = BRAKE_FIELD + 1


@register_jitable(forceinline=True)
def place_weights(setpoint: LawSetpoint) -> tuple[float, float, float]:
    """Return weights, 0 or 1: going to a point, holding a horizontal position, holding a height.

    Args:
        setpoint: see `LawSetpoint`.
    """
    v_x, v_y, v_z, _, _, _, _, follow = setpoint.reference
    _, _, authority, _, hold_xy, hold_z = setpoint.guidance[0:6]
    if authority * (v_x * v_x + v_y * v_y + v_z * v_z + follow) > MIN_STEERING_SPEED_SQUARED:
        # no pull back to the held point until the flight mode notices that the pilot steers
        hold_xy = 0.0
        hold_z = 0.0
    return authority * follow, hold_xy, hold_z


@register_jitable(forceinline=True)
def position_error(measured: MeasuredMotion, setpoint: LawSetpoint) -> Vector3:
    """Return the vector to the point that is held or approached, in W [m]; 0 without one.

    Args:
        measured: see `MeasuredMotion`.
        setpoint: see `LawSetpoint`.
    """
    x, y, z = measured.p_WB
    _, _, _, _, p_x, p_y, p_z, _ = setpoint.reference
    hold_x, hold_y, hold_height = setpoint.guidance[6:BRAKE_FIELD]
    follow, hold_xy, hold_z = place_weights(setpoint)
    return (
        follow * (p_x - x) + hold_xy * (hold_x - x),
        follow * (p_y - y) + hold_xy * (hold_y - y),
        follow * (p_z - z) + hold_z * (hold_height - z),
    )


@register_jitable(forceinline=True)
def velocity_setpoint(
    correction: Vector3, measured: MeasuredMotion, setpoint: LawSetpoint, limits: Gains
) -> tuple[float, float, float, float]:
    """Return the commanded velocity (x, y, z) in W [m/s] and yaw rate [rad/s], within limits.

    Args:
        correction: velocity that the law adds for the position error, in W [m/s].
        measured: see `MeasuredMotion`.
        setpoint: see `LawSetpoint`.
        limits: a record with max_speed, max_climb_rate, max_height, max_tilt and max_yaw_rate.
    """
    reference, guidance, p_WB = setpoint.reference, setpoint.guidance, measured.p_WB
    authority, climb = guidance[2], guidance[3]
    v_x = authority * reference[0] + correction[0]
    v_y = authority * reference[1] + correction[1]
    v_z = authority * reference[2] + correction[2] + climb
    yaw_rate = authority * reference[3]

    speed_squared = v_x * v_x + v_y * v_y
    if speed_squared > limits.max_speed * limits.max_speed:
        shrink = limits.max_speed / speed_squared**0.5
        v_x = v_x * shrink
        v_y = v_y * shrink
    ceiling = CEILING_RATE * (limits.max_height - p_WB[2])
    if v_z > ceiling:
        v_z = ceiling
    if v_z > limits.max_climb_rate:
        v_z = limits.max_climb_rate
    if v_z < -limits.max_climb_rate:
        v_z = -limits.max_climb_rate
    if yaw_rate > limits.max_yaw_rate:
        yaw_rate = limits.max_yaw_rate
    if yaw_rate < -limits.max_yaw_rate:
        yaw_rate = -limits.max_yaw_rate
    if guidance[BRAKE_FIELD] > 0.0:
        slowing = BRAKING_SHARE * GRAVITY * tangent(limits.max_tilt)
        walls = guidance[FIRST_WALL_FIELD:]
        v_x, v_y, v_z = braked(v_x, v_y, v_z, p_WB, guidance[BRAKE_FIELD], walls, slowing)
    return v_x, v_y, v_z, yaw_rate


@register_jitable(forceinline=True)
def tangent(angle: float) -> float:
    """Return tan(angle) within 1e-8 for |angle| <= 1.2 rad, by Lambert's continued fraction."""
    s = angle * angle
    return angle / (1.0 - s / (3.0 - s / (5.0 - s / (7.0 - s / (9.0 - s / (11.0 - s / 13.0))))))
