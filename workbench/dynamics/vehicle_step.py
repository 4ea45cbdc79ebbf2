"""What moves a vehicle in the air, and one physics step of it: pure functions of scalars.

One source runs with floats, converts to AutoDiffXd, and compiles with numba. A rotor at p_BR with
the unit axis n turns with the speed w; J is the moment of inertia of what turns about n, and d is
+1 where it turns counter-clockwise. It acts on the body with

    thrust            motor_constant w² n, at p_BR
    drag torque       -d moment_constant motor_constant w² n
    spin-up torque    -d J (dw/dt) n
    gyroscopic moment -w_WB x h, with its angular momentum h = d J w n

(Mahony, Kumar and Corke, "Multirotor Aerial Vehicles", IEEE Robotics & Automation Magazine, 2012,
equations 4 to 8; the inertia of the body has the rotors in it), and with the air's drag, see
`air.drag`.
"""

from collections.abc import Sequence
from typing import Any

import numpy as np
from numba.extending import register_jitable

from workbench.dynamics.air.drag import Wrench, body_drag, cross, with_rotor_drag
from workbench.dynamics.rigid_body import Six, State, accelerations, into_body, middle, moved
from workbench.dynamics.rotor_response import CONSTANTS, rotor_constants, step_rotor, within
from workbench.plant.rotors import Rotor

Scalar = Any
Signal = Any
"""A sequence of scalars: a list or tuple in Python, an array in compiled code."""

THRUST = 8
"""Place in a rotor's row of force and moment over squared speed (6)."""
MOMENTUM = 14
"""Place of angular momentum over speed."""
ANSWER = 15
"""Place of what `rotor_response.rotor_constants` has (7)."""
ROW = ANSWER + CONSTANTS
"""Size of a rotor's row, 22."""

Load = tuple[Scalar, ...]
"""What acts on a body, in B (9): force [N], moment about its origin [N·m], and the rotors' angular
momentum [N·m·s], whose gyroscopic moment is not in the moment yet."""


def rotor_rows(rotors: Sequence[Rotor], step: float) -> np.ndarray:
    """Return a row of 22 for each rotor, all vectors in B.

    Hub [m] and axis (6); drag and rolling-moment coefficient (2); force and moment about the
    origin over squared speed (6) [N·s², N·m·s²]; angular momentum along the axis over speed
    [kg·m²]; and its answer over a step [s], see `rotor_response.rotor_constants` (7).
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
        *rotor_constants(rotor, step),
    ]


@register_jitable(forceinline=True)
def given(share: Scalar) -> Scalar:
    """Return the share of its thrust that a rotor gives while it turns.

    One that has stopped, with a share of 0, gives all of it while it runs down.
    """
    return share if share > 0.0 else 1.0


@register_jitable(forceinline=True)
def with_thrust(load: Load, speed: Scalar, slope: Scalar, share: Scalar, rotor: Signal) -> Load:
    """Return a load with thrust, drag torque, spin-up torque and angular momentum of a rotor.

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
    square = share * speed * speed
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
def whole_wrench(load: Load, w_B: Signal) -> Wrench:
    """Return the wrench of a load (6), with the gyroscopic moment of the rotors.

    Args:
        load: see `Load`.
        w_B: angular velocity of the body in B (3) [rad/s].
    """
    f_x, f_y, f_z, m_x, m_y, m_z, h_x, h_y, h_z = load
    g_x, g_y, g_z = cross(w_B, (h_x, h_y, h_z))
    return f_x, f_y, f_z, m_x - g_x, m_y - g_y, m_z - g_z


@register_jitable
def vehicle_wrench(
    R_WB: Signal,
    w_WB_W: Signal,
    v_WB_W: Signal,
    speeds: Signal,
    slopes: Signal,
    shares: Signal,
    wind_W: Signal,
    pressure: Scalar,
    p_BoBcm_B: Signal,
    rotors: Signal,
) -> Wrench:
    """Return force [N] and moment about the origin [N·m] of rotors and drag, in B.

    Args:
        R_WB: orientation, row by row (9).
        w_WB_W: angular velocity in W (3) [rad/s].
        v_WB_W: velocity of the origin in W (3) [m/s].
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
        row = rotors[i]
        load = with_thrust(load, speeds[i], slopes[i], given(shares[i]), row)
        load = with_rotor_drag(load[0:6], v_B, w_B, speeds[i], row) + load[6:9]
    return whole_wrench(load, w_B)


@register_jitable
def step_vehicle(
    state: Signal,
    last: Signal,
    speeds: Signal,
    commands: Signal,
    shares: Signal,
    wind_W: Signal,
    push_W: Signal,
    pressure: Scalar,
    body: Signal,
    rotors: Signal,
    step: float,
    middles: Signal,
    slopes: Signal,
    next_speeds: Signal,
) -> tuple[State, Six]:
    """Return the state at the end of a physics step (13), and the acceleration in its middle (6).

    Args:
        state: at its beginning (13), see `rigid_body.State`.
        last: acceleration in the middle of the step before (6), see `rigid_body.middle`.
        speeds: of the rotors at its beginning (n) [rad/s].
        commands: speeds that they are to reach (n) [rad/s].
        shares: see `vehicle_wrench` (n).
        wind_W: velocity of the air in W (3) [m/s].
        push_W: a further force in W and moment about the origin in W (6) [N, N·m].
        pressure: see `vehicle_wrench`.
        body: see `rigid_body.RigidBody` (16).
        rotors: n rows, see `rotor_rows`.
        step: its length [s].
        middles: n places for speeds in its middle [rad/s].
        slopes: n places for their slopes [rad/s²].
        next_speeds: n places for speeds at its end [rad/s].
    """
    for i in range(len(rotors)):
        constants = rotors[i][ANSWER:ROW]
        command = within(commands[i], constants[0])
        middles[i], slopes[i], next_speeds[i] = step_rotor(command, speeds[i], constants)
    R_WB, w_W, v_W = middle(state, last, step)
    p_BoBcm_B = body[13:16]
    wrench = vehicle_wrench(
        R_WB, w_W, v_W, middles, slopes, shares, wind_W, pressure, p_BoBcm_B, rotors
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
