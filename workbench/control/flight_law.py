"""A whole control update: the law, allocation and rotor speeds, as pure functions.

They run as plain Python with lists (floats or AutoDiffXd) and compiled with arrays: one source.
"""

import math
from typing import Any, NamedTuple

import numpy as np
from numba.extending import register_jitable

from workbench.control.flight_state import mass_velocity, still_air_drag, thrust_attitude
from workbench.control.guidance import LIFT, MOTORS
from workbench.control.loop_points import COUNT, SIGNALS
from workbench.control.mixer import mix
from workbench.control.pd import Body, Gains, specific_force, wrench
from workbench.control.stopped_rotors import any_stopped, mix_without
from workbench.dynamics.rotor_response import speed_command
from workbench.plant.drag import drag_area, drag_rates
from workbench.plant.payload import NO_PAYLOAD, Payload, believed
from workbench.plant.rotors import wrench_matrix
from workbench.plant.thrust_frame import thrust_frame
from workbench.plant.vehicle import Vehicle

Scalar = Any
Signal = Any
"""A sequence of scalars: a list in Python, an array in compiled code."""

SOURCES = ("control", "dynamics", "plant/gravity.py")
"""What the compiled law stands in, below `workbench/`."""
SPIN_UP = Gains._fields.index("spin_up_feedforward")
BODY, ROTOR = 18, 12
"""Numbers that the law knows of the body, and of each rotor, see `packed`."""
NEAR = 1e-3
"""A centre of mass this near the base link's origin counts as being there [m]."""


class LawConstants(NamedTuple):
    """What the law knows of a vehicle: lists for Python, views of `packed` arrays for numba.

    Mass [kg]; inertia xx, xy, xz, yy, yz, zz [kg·m²]; orientation w, x, y, z of the frame T that
    the vehicle hovers upright in, and place of the centre of mass in B [m]; drag as in
    `plant.drag.DragRates`; allocation from a wrench to thrusts and effects of thrusts on the
    wrench, n rows of 4 each; idle and largest thrusts [N], motor constants [N·s²] and halves of
    the rotors' `linear_speed` [rad/s], n each; and by how much spin-up torque leads drag torque in
    yaw [s].
    Inertia, allocation and effects are for T, see `plant.thrust_frame`.
    """

    mass: float
    inertia: Any
    q_BT: Any
    p_BoBcm_B: Any
    drag: Any
    allocation: Any
    effects: Any
    idle_thrusts: Any
    max_thrusts: Any
    motor_constants: Any
    half_linear_speeds: Any
    spin_up_time: float


def law_constants(vehicle: Vehicle, payload: Payload = NO_PAYLOAD) -> LawConstants:
    """Return the constants of a vehicle, as the law knows it.

    Args:
        vehicle: without a payload.
        payload: of which the law believes that it has the known mass.

    Raises:
        WorkbenchError: if no rotor speeds would hold the two in hover.
    """
    area = drag_area(vehicle.mass)
    vehicle = believed(vehicle, payload)
    frame = thrust_frame(vehicle)
    inertia = frame.inertia_T
    lever = vehicle.p_BoBcm_B if math.hypot(*vehicle.p_BoBcm_B) > NEAR else (0.0, 0.0, 0.0)
    max_thrusts = [rotor.max_thrust for rotor in vehicle.rotors]
    lifting = np.array([rotor.lifts for rotor in frame.rotors])
    effects = wrench_matrix(frame.rotors, frame.p_ToTcm_T)[2:] * lifting
    return LawConstants(
        mass=vehicle.mass,
        inertia=[*inertia[0].tolist(), *inertia[1, 1:].tolist(), float(inertia[2, 2])],
        q_BT=frame.q_BT,
        p_BoBcm_B=list(lever),
        drag=list(drag_rates(vehicle, area)),
        allocation=frame.allocation.tolist(),
        effects=effects.T.tolist(),
        idle_thrusts=frame.idle_thrusts.tolist(),
        max_thrusts=max_thrusts,
        motor_constants=[rotor.motor_constant for rotor in vehicle.rotors],
        half_linear_speeds=[0.5 * rotor.linear_speed for rotor in vehicle.rotors],
        spin_up_time=frame.spin_up_time,
    )


def packed(constants: LawConstants) -> tuple[np.ndarray, np.ndarray]:
    """Return constants as two arrays, (18) of the body and (n, 12) of the rotors."""
    columns = (
        constants.idle_thrusts,
        constants.max_thrusts,
        constants.motor_constants,
        constants.half_linear_speeds,
    )
    place = (*constants.q_BT, *constants.p_BoBcm_B)
    body = np.array(
        [constants.mass, *constants.inertia, *place, *constants.drag, constants.spin_up_time]
    )
    rotors = np.column_stack([constants.allocation, constants.effects, *columns])
    return body, rotors


@register_jitable
def unpacked(body: np.ndarray, rotors: np.ndarray) -> LawConstants:
    """Return the constants that `packed` made arrays of."""
    return LawConstants(
        body[0],
        body[1:7],
        body[7:11],
        body[11:14],
        body[14:17],
        rotors[:, 0:4],
        rotors[:, 4:8],
        rotors[:, 8],
        rotors[:, 9],
        rotors[:, 10],
        rotors[:, 11],
        body[17],
    )


@register_jitable(forceinline=True)
def estimated(velocity: Signal, filtered: Signal, estimate: tuple[float, float]) -> tuple[Any, Any]:
    """Return the acceleration (3) [m/s²] and the filtered velocity (3) [m/s] after an update.

    Args:
        velocity: in W (3) [m/s].
        filtered: the same, filtered (3).
        estimate: share and rate, see `acceleration_estimate`.
    """
    share, rate = estimate
    f_x, f_y, f_z = filtered
    e_x = velocity[0] - f_x
    e_y = velocity[1] - f_y
    e_z = velocity[2] - f_z
    after = (f_x + share * e_x, f_y + share * e_y, f_z + share * e_z)
    return (rate * e_x, rate * e_y, rate * e_z), after


@register_jitable(forceinline=True)
def flight_wrench(
    state: Signal,
    acceleration: Signal,
    reference: Signal,
    guidance: Signal,
    gains: Signal,
    constants: LawConstants,
    loops: Signal,
) -> tuple[Scalar, Scalar, Scalar, Scalar]:
    """Return the force [N] and moment [N·m] in T that the law asks of a vehicle whose rotors lift.

    Args: as for `rotor_commands`; of the constants those of the body.
    """
    g = named_gains(gains)
    q_WT = thrust_attitude(state[0:4], constants.q_BT)
    v_WBcm = mass_velocity(state, constants.p_BoBcm_B)
    drag = still_air_drag(q_WT, v_WBcm, constants.drag)
    f_x, f_y, f_z, yaw_rate = specific_force(
        state[4:7], v_WBcm, acceleration, drag, reference, guidance, g, loops
    )
    body = Body(constants.mass, constants.inertia, constants.drag[2])
    return wrench((f_x, f_y, f_z), yaw_rate, q_WT, state[7:10], g, body, loops)


@register_jitable(forceinline=True)
def named_gains(g: Signal) -> Gains:
    """Return gains by name of a sequence in their order."""
    return Gains(
        g[0],
        g[1],
        g[2],
        g[3],
        g[4],
        g[5],
        g[6],
        g[7],
        g[8],
        g[9],
        g[10],
        g[11],
        g[12],
        g[13],
        g[14],
        g[15],
        g[16],
        g[17],
        g[18],
    )


@register_jitable(forceinline=True)
def kept_share(gains: Signal, spin_up_time: Scalar, period: Scalar) -> Scalar:
    """Return how much of the yaw moment of one update the next one keeps.

    Rotors make the moment m that is asked for by drag, and spin_up_time dm/dt by spinning up. So
    that both together make the wanted one, wanted = m + lead dm/dt, with the difference between
    updates for dm/dt; lead is the share `spin_up_feedforward` of spin_up_time.

    Args:
        gains: see `pd.Gains`.
        spin_up_time: see `LawConstants` [s].
        period: between updates [s].
    """
    lead = gains[SPIN_UP] * spin_up_time
    return lead / (lead + period)


@register_jitable(forceinline=True)
def yaw_moment(commands: Signal, constants: LawConstants) -> Scalar:
    """Return the yaw moment that commanded speeds (n) make by drag, once reached [N·m]."""
    moment = 0.0
    for i in range(len(constants.effects)):
        linear_speed = 2.0 * constants.half_linear_speeds[i]
        thrust = constants.motor_constants[i] * commands[i] * (commands[i] + linear_speed)
        moment = moment + constants.effects[i][3] * thrust
    return moment


@register_jitable
def rotor_commands(
    state: Signal,
    acceleration: Signal,
    reference: Signal,
    guidance: Signal,
    gains: Signal,
    shares: Signal,
    constants: LawConstants,
    loops: Signal,
    kept: Scalar,
    before: Scalar,
    commands: Signal,
) -> Scalar:
    """Write the commanded rotor speeds (n) [rad/s] into `commands`.

    Args:
        state: of the plant (13): q_WB, p_WB [m], w_WB_W [rad/s], v_WB_W [m/s].
        acceleration: estimate in W (3) [m/s²].
        reference: see `guidance.Reference`.
        guidance: see `guidance.Guidance`.
        gains: see `pd.Gains`.
        shares: of their thrust that rotors give (n). The law knows which have stopped, with a
            share of 0, as motors report that; of weak ones it knows nothing.
        constants: of the vehicle.
        loops: see `loop_points`.
        kept: how much of the yaw moment before is kept, see `kept_share`.
        before: the yaw moment asked for before [N·m].
        commands: n places.

    Returns:
        The yaw moment that is wanted [N·m].
    """
    n = len(constants.allocation)
    wanted = 0.0
    if guidance[LIFT] > 0.0:
        force, m_x, m_y, wanted = flight_wrench(
            state, acceleration, reference, guidance, gains, constants, loops
        )
        m_z = wanted + kept * (before - wanted)
        if any_stopped(shares):
            most = [constants.max_thrusts[i] if shares[i] > 0.0 else 0.0 for i in range(n)]
            mix_without(force, m_x, m_y, m_z, constants.effects, most, commands)
        else:
            mix(
                force,
                m_x,
                m_y,
                m_z,
                constants.allocation,
                constants.idle_thrusts,
                constants.max_thrusts,
                commands,
            )
    else:
        for i in range(n):
            commands[i] = constants.idle_thrusts[i] if shares[i] > 0.0 else 0.0
    for i in range(n):
        commands[i] = speed_command(
            commands[i],
            constants.motor_constants[i],
            constants.half_linear_speeds[i],
            guidance[MOTORS],
        )
    return wanted


@register_jitable
def control_update(
    state: Signal,
    reference: Signal,
    guidance: Signal,
    gains: Signal,
    shares: Signal,
    constants: LawConstants,
    loops: Signal,
    estimate: tuple[float, float],
    filtered: Signal,
    commands: Signal,
) -> tuple[Scalar, Scalar, Scalar]:
    """Do one sampled control update: estimate acceleration, and run the law.

    Args:
        state: as for `rotor_commands`, and so the next five.
        reference: see there.
        guidance: see there.
        gains: see there.
        shares: see there.
        constants: see there.
        loops: see there.
        estimate: share and rate of the acceleration estimate, see `acceleration_estimate`.
        filtered: velocity that the estimate remembers (3) [m/s].
        commands: rotor speeds commanded before (n) [rad/s], and places for those from now on.

    Returns:
        The filtered velocity to remember (3) [m/s].
    """
    acceleration, after = estimated(state[10:13], filtered, estimate)
    share, rate = estimate
    kept = kept_share(gains, constants.spin_up_time, share / rate)
    before = yaw_moment(commands, constants)
    rotor_commands(
        state,
        acceleration,
        reference,
        guidance,
        gains,
        shares,
        constants,
        loops,
        kept,
        before,
        commands,
    )
    return after


def packed_update(
    state: np.ndarray,
    reference: np.ndarray,
    guidance: np.ndarray,
    gains: np.ndarray,
    shares: np.ndarray,
    known: np.ndarray,
    probes: np.ndarray,
    estimate: tuple[float, float],
    filtered: np.ndarray,
    commands: np.ndarray,
) -> None:
    """Do `control_update` with packed constants, in place; this is what gets compiled.

    `known` are the constants of the body, and those of the rotors row by row, see `packed`: each
    array handed to compiled code costs a quarter of a microsecond, hence so few. `probes` are gates
    and injections of the loop points (30).
    """
    constants = unpacked(known[:BODY], known[BODY:].reshape(-1, ROTOR))
    loops = np.empty(SIGNALS + COUNT)
    loops[:SIGNALS] = probes
    after = control_update(
        state,
        reference,
        guidance,
        gains,
        shares,
        constants,
        loops,
        estimate,
        filtered,
        commands,
    )
    filtered[0], filtered[1], filtered[2] = after
