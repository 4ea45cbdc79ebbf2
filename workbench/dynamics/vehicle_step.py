"""Forces on a vehicle in the air, and one physics step of it: pure functions of scalars.

The same source runs with floats and AutoDiffXd, and compiles with numba. A rotor at p_BR with the
unit axis n has the speed w and the moment of inertia J about n; d is +1 if it turns
counter-clockwise. With T = motor_constant w² + linear_motor_constant w, it acts on the body with

    thrust            (T (1 + g) - inflow_coefficient w u) n, at p_BR
    drag torque       -d moment_constant T n
    spin-up torque    -d J (dw/dt) n
    gyroscopic moment -w_WB x h, with its angular momentum h = d J w n

(Mahony, Kumar and Corke, "Multirotor Aerial Vehicles", IEEE Robotics & Automation Magazine, 2012,
equations 4 to 8; the inertia of the body includes the rotors), and with drag, see `air.drag`.

Inflow: u is the hub's air velocity along n. The loss of thrust over w u is `k_z` of
RotorPy (Folk, Paulos and Kumar, "RotorPy", 2023) and `drag_coeff_z` of gym-pybullet-drones, after
Forster, "System Identification of the Crazyflie 2.0 Nano Quadrocopter", ETH Zurich, 2015.

Ground effect: g = c (r / 4h)² at the height h of the hub above the ground, if n points upwards.
This is the first-order term of Cheeseman and Bennett, "The Effect of the Ground on a Helicopter
Rotor in Forward Flight", ARC R&M 3021, 1955, with a factor c for several rotors over a body (Shi et
al., "Neural Lander", ICRA 2019). As in gym-pybullet-drones, g is at most 4/15. Neither effect
changes the drag torque, as in both simulators.

Battery: a rotor with the commanded speed w goes to s w, where s is the battery voltage under load
over that of the full battery without load; its largest speed is scaled likewise. The reason is that
speed controllers of hobby motors set a share of the voltage, not a speed: thrust at a command is
proportional to s² in ArduPilot's simulator (SIM_Motor.cpp, `voltage_scale`). Flight controllers
compensate by dividing their outputs by the voltage (Betaflight's `vbat_sag_compensation`): with a
compensation of c, the command is w / (1 + c (s - 1)), limited to the largest speed.
"""

from collections.abc import Sequence

import numpy as np

from workbench.common.jitable import Scalar, Vector, register_jitable, taking
from workbench.dynamics.air.drag import Wrench, body_drag, with_rotor_drag
from workbench.dynamics.rigid_body import (
    Six,
    State,
    accelerations,
    cross,
    into_body,
    middle,
    moved,
)
from workbench.dynamics.rotor_response import CONSTANTS, rotor_constants, step_rotor, within
from workbench.dynamics.rotors import LEAST_VOLTAGE, MOST_GROUND_EFFECT, TINY
from workbench.plant.rotors import Rotor

THRUST = 8
"""Place in a rotor's row of force and moment over squared speed (6)."""
MOMENTUM = 14
"""Place of angular momentum over speed."""
LINEAR, CONSTANT, INFLOW, GROUND = range(15, 19)
"""Places of the linear speed, see `plant.rotors.Rotor`, and of the factors of `thrust_change`."""
LAG = 19
"""Place of `rotor_response.rotor_constants` (7)."""
ROW = LAG + CONSTANTS
"""Size of a rotor's row, 26."""
take_row = taking(ROW)
FULL = (1.0, 0.0, 0.0, 1.0)
"""A supply with the constant voltage of a full battery, see `voltage_share`."""

Load = tuple[Scalar, ...]
"""The load on a body, in B (9): force [N], moment about its origin [N·m], and the rotors' angular
momentum [N·m·s]; the moment does not yet include their gyroscopic moment."""


def rotor_rows(rotors: Sequence[Rotor], step: float) -> np.ndarray:
    """Return a row of 26 for each rotor, all vectors in B.

    Hub [m] and axis (6); drag and rolling-moment coefficient (2); force and moment about the
    origin over squared speed (6) [N·s², N·m·s²]; angular momentum along the axis over speed
    [kg·m²]; linear speed [rad/s], motor constant [N·s²], inflow coefficient, and share of ground
    effect times squared height [m²]; and the constants of its lag, see
    `rotor_response.rotor_constants` (7).
    """
    return np.array([_row(rotor, step) for rotor in rotors])


def _row(rotor: Rotor, step: float) -> list[float]:
    axis, hub = np.array(rotor.axis_B), np.array(rotor.p_BR)
    moment = np.cross(hub, axis) - rotor.direction * rotor.moment_constant * axis
    return [
        *rotor.p_BR,
        *rotor.axis_B,
        rotor.rotor_drag_coefficient,
        rotor.rolling_moment_coefficient,
        *(rotor.motor_constant * axis),
        *(rotor.motor_constant * moment),
        rotor.direction * rotor.inertia,
        rotor.linear_speed,
        rotor.motor_constant,
        rotor.inflow_coefficient,
        rotor.ground_effect_coefficient * (rotor.propeller_radius / 4.0) ** 2,
        *rotor_constants(rotor, step),
    ]


@register_jitable(forceinline=True)
def given(share: Scalar) -> Scalar:
    """Return the share of a rotor's thrust while it turns.

    A stopped rotor, with a share of 0, has its full thrust while it runs down.
    """
    return share if share > 0.0 else 1.0


@register_jitable(forceinline=True)
def with_thrust(load: Load, speed: Scalar, slope: Scalar, share: Scalar, rotor: Vector) -> Load:
    """Return a load plus thrust, drag torque, spin-up torque and angular momentum of a rotor.

    The thrust is that in still air far from the ground, see `thrust_change`.

    Args:
        load: see `Load`.
        speed: of the rotor [rad/s].
        slope: of its speed [rad/s²].
        share: of its thrust that it gives.
        rotor: its row, see `rotor_rows`.
    """
    f_x, f_y, f_z, m_x, m_y, m_z, h_x, h_y, h_z = load
    n_x, n_y, n_z = rotor[3:6]
    e_x, e_y, e_z, t_x, t_y, t_z = rotor[THRUST:MOMENTUM]
    square = share * speed * (speed + rotor[LINEAR])
    spin_up = rotor[MOMENTUM] * slope
    momentum = rotor[MOMENTUM] * speed
    return (
        f_x + square * e_x,
        f_y + square * e_y,
        f_z + square * e_z,
        m_x + square * t_x - spin_up * n_x,
        m_y + square * t_y - spin_up * n_y,
        m_z + square * t_z - spin_up * n_z,
        h_x + momentum * n_x,
        h_y + momentum * n_y,
        h_z + momentum * n_z,
    )


@register_jitable(forceinline=True)
def static_thrust(speed: Scalar, share: Scalar, rotor: Vector) -> Scalar:
    """Return a rotor's thrust at rest far from the ground [N]; see `with_thrust`."""
    return share * rotor[CONSTANT] * (speed * (speed + rotor[LINEAR]))


@register_jitable(forceinline=True)
def thrust_change(
    v_B: Vector,
    w_B: Vector,
    up_B: Vector,
    height: Scalar,
    speed: Scalar,
    share: Scalar,
    rotor: Vector,
) -> Scalar:
    """Return the change of a rotor's thrust by inflow and ground effect [N].

    Args:
        v_B: velocity of the origin relative to the air, in B (3) [m/s].
        w_B: angular velocity in B (3) [rad/s].
        up_B: upwards in B (3).
        height: of the origin above the ground [m].
        speed: of the rotor [rad/s].
        share: of its thrust that it gives.
        rotor: its row, see `rotor_rows`.
    """
    p_x, p_y, p_z = rotor[0:3]
    n_x, n_y, n_z = rotor[3:6]
    linear, constant, inflow, ground = rotor[LINEAR:LAG]
    u_x, u_y, u_z = up_B
    s_x, s_y, s_z = cross(w_B, (p_x, p_y, p_z))
    along = (s_x + v_B[0]) * n_x + (s_y + v_B[1]) * n_y + (s_z + v_B[2]) * n_z
    hub = height + u_x * p_x + u_y * p_y + u_z * p_z
    square = hub * hub
    least = ground / MOST_GROUND_EFFECT + TINY
    if square < least:
        square = least
    near = ground / square
    if u_x * n_x + u_y * n_y + u_z * n_z <= 0.0:
        near = 0.0
    return share * speed * (near * constant * (speed + linear) - inflow * along)


@register_jitable(forceinline=True)
def with_thrust_change(wrench: Wrench, change: Scalar, rotor: Vector) -> Wrench:
    """Return a wrench about the origin in B (6) with a change of a rotor's thrust [N]."""
    f_x, f_y, f_z, m_x, m_y, m_z = wrench
    n_x, n_y, n_z = rotor[3:6]
    c_x = change * n_x
    c_y = change * n_y
    c_z = change * n_z
    t_x, t_y, t_z = cross(rotor[0:3], (c_x, c_y, c_z))
    return f_x + c_x, f_y + c_y, f_z + c_z, m_x + t_x, m_y + t_y, m_z + t_z


@register_jitable(forceinline=True)
def changes_thrust(rotor: Vector) -> bool:
    """Return whether inflow or ground effect change the thrust of a rotor, given its row."""
    return bool(rotor[INFLOW] != 0.0 or rotor[GROUND] != 0.0)


@register_jitable(forceinline=True)
def power_share(thrust: Scalar) -> Scalar:
    """Return a thrust [N] to the 3/2, proportional to a rotor's power, see `battery.Battery`."""
    return thrust * (thrust + TINY) ** 0.5


@register_jitable(forceinline=True)
def loaded(supply: Vector, power: Scalar) -> Scalar:
    """Return the voltage under load over that of the full battery without load.

    Args:
        supply: voltage without load, and its drop per power, both over that of the full battery
            without load [1, N^-3/2]; the share of sag that is compensated; and the voltage without
            load that the compensation assumes.
        power: sum of the rotors' `power_share` [N^3/2].
    """
    share = supply[0] - supply[1] * power
    if share < 0.0:
        share = 0.0
    return share


@register_jitable(forceinline=True)
def supplied(
    command: Scalar, most: float, voltage: Scalar, known: Scalar, compensation: Scalar
) -> Scalar:
    """Return the speed that a rotor approaches at a command [rad/s].

    Args:
        command: speed [rad/s].
        most: largest speed with a full battery [rad/s].
        voltage: see `loaded`.
        known: the same, as the compensation assumes it.
        compensation: share of the sag by which the command is raised.
    """
    share = 1.0 + compensation * (known - 1.0)
    if share < LEAST_VOLTAGE:
        share = LEAST_VOLTAGE
    return voltage * within(command / share, most)


@register_jitable(forceinline=True)
def voltage_share(speeds: Vector, shares: Vector, supply: Vector, rotors: Vector) -> Scalar:
    """Return `loaded` at the power of rotors with speeds (n) [rad/s].

    The arguments are those of `vehicle_wrench` and `loaded`.
    """
    power = 0.0
    if supply[1] > 0.0:
        for i in range(len(rotors)):
            thrust = static_thrust(speeds[i], given(shares[i]), rotors[i])
            power = power + power_share(thrust)
    return loaded(supply, power)


@register_jitable(forceinline=True)
def whole_wrench(load: Load, w_B: Vector) -> Wrench:
    """Return the wrench of a load (6), with the gyroscopic moment of the rotors.

    Args:
        load: see `Load`.
        w_B: angular velocity of the body in B (3) [rad/s].
    """
    f_x, f_y, f_z, m_x, m_y, m_z, h_x, h_y, h_z = load
    g_x, g_y, g_z = cross(w_B, (h_x, h_y, h_z))
    return f_x, f_y, f_z, m_x - g_x, m_y - g_y, m_z - g_z


@register_jitable(forceinline=True)
def vehicle_wrench(
    R_WB: Vector,
    w_WB_W: Vector,
    v_WB_W: Vector,
    height: Scalar,
    speeds: Vector,
    slopes: Vector,
    shares: Vector,
    wind_W: Vector,
    pressure: Scalar,
    p_BoBcm_B: Vector,
    rotors: Vector,
) -> Wrench:
    """Return force [N] and moment about the origin [N·m] of rotors and drag, in B.

    Args:
        R_WB: orientation, row by row (9).
        w_WB_W: angular velocity in W (3) [rad/s].
        v_WB_W: velocity of the origin in W (3) [m/s].
        height: of the origin above the ground [m].
        speeds: of the rotors (n) [rad/s].
        slopes: of their speeds (n) [rad/s²].
        shares: of their thrust that rotors give, see `given` (n).
        wind_W: velocity of the air in W (3) [m/s].
        pressure: half the air's density times the body's drag area [kg/m].
        p_BoBcm_B: the centre of mass (3) [m].
        rotors: n rows, see `rotor_rows`.
    """
    w_B = into_body(R_WB, w_WB_W)
    v_B = into_body(R_WB, (v_WB_W[0] - wind_W[0], v_WB_W[1] - wind_W[1], v_WB_W[2] - wind_W[2]))
    load = body_drag(v_B, w_B, pressure, p_BoBcm_B) + (0.0, 0.0, 0.0)
    for i in range(len(rotors)):
        row = take_row(rotors[i])
        load = with_thrust(load, speeds[i], slopes[i], given(shares[i]), row)
        wrench = with_rotor_drag(load[0:6], v_B, w_B, speeds[i], row)
        if changes_thrust(row):
            share = given(shares[i])
            change = thrust_change(v_B, w_B, R_WB[6:9], height, speeds[i], share, row)
            wrench = with_thrust_change(wrench, change, row)
        load = wrench + load[6:9]
    return whole_wrench(load, w_B)


@register_jitable(forceinline=True)
def middle_height(height: Scalar, climb: Scalar, acceleration: Scalar, step: float) -> Scalar:
    """Return the height at the middle of a step [m], from height, climb rate and its slope."""
    return height + 0.5 * step * (climb + 0.25 * step * acceleration)


@register_jitable(forceinline=True)
def step_vehicle(
    state: Vector,
    last: Vector,
    speeds: Vector,
    commands: Vector,
    shares: Vector,
    wind_W: Vector,
    push_W: Vector,
    pressure: Scalar,
    supply: Vector,
    body: Vector,
    rotors: Vector,
    step: float,
    middles: Vector,
    slopes: Vector,
    next_speeds: Vector,
) -> tuple[State, Six]:
    """Return the state at the end of a physics step (13), and the acceleration in its middle (6).

    Args:
        state: at its beginning (13), see `rigid_body.State`.
        last: acceleration in the middle of the step before (6), see `rigid_body.middle`.
        speeds: of the rotors at its beginning (n) [rad/s].
        commands: commanded speeds (n) [rad/s].
        shares: see `vehicle_wrench` (n).
        wind_W: velocity of the air in W (3) [m/s].
        push_W: a further force in W and moment about the origin in W (6) [N, N·m].
        pressure: see `vehicle_wrench`.
        supply: of the battery, see `loaded`.
        body: see `rigid_body.RigidBody` (16).
        rotors: n rows, see `rotor_rows`.
        step: its length [s].
        middles: n places for speeds in its middle [rad/s].
        slopes: n places for their slopes [rad/s²].
        next_speeds: n places for speeds at its end [rad/s].
    """
    voltage = voltage_share(speeds, shares, supply, rotors)
    known = voltage + (supply[3] - supply[0])
    for i in range(len(rotors)):
        constants = take_row(rotors[i])[LAG:ROW]
        command = supplied(commands[i], constants[0], voltage, known, supply[2])
        middles[i], slopes[i], next_speeds[i] = step_rotor(command, speeds[i], constants)
    R_WB, w_W, v_W = middle(state, last, step)
    p_BoBcm_B = body[13:16]
    height = middle_height(state[6], state[12], last[5], step)
    wrench = vehicle_wrench(
        R_WB, w_W, v_W, height, middles, slopes, shares, wind_W, pressure, p_BoBcm_B, rotors
    )
    f_x, f_y, f_z, m_x, m_y, m_z = wrench
    p_x, p_y, p_z = into_body(R_WB, push_W[0:3])
    t_x, t_y, t_z = into_body(R_WB, push_W[3:6])
    wrench = (f_x + p_x, f_y + p_y, f_z + p_z, m_x + t_x, m_y + t_y, m_z + t_z)
    w_B = into_body(R_WB, w_W)
    acceleration = accelerations(
        R_WB, w_B, last, step, wrench, body[0], body[1:7], body[7:13], p_BoBcm_B
    )
    return moved(state, acceleration, step), acceleration
