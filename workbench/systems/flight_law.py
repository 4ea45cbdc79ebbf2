"""The whole law of a control update: cascade, mixer and rotor speeds, as pure functions.

They run as plain Python with lists (floats or AutoDiffXd) and compiled with arrays: one source.
"""

from typing import Any, NamedTuple

import numpy as np
from numba.extending import register_jitable

from workbench.plant.rotors import allocation_matrix
from workbench.plant.vehicle import Vehicle
from workbench.systems.cascade import wanted_specific_force, wanted_velocity, wanted_wrench
from workbench.systems.mixer import mix
from workbench.systems.rotor_response import rotor_period, step_rotor

Scalar = Any
Signal = Any
"""A sequence of scalars: a list in Python, an array in compiled code."""

IDLE_SPEED_SHARE = 0.1
"""Armed rotors turn at this share of their largest speed, and never slower while flying."""


class LawConstants(NamedTuple):
    """What the law knows of a vehicle: lists for Python, views of `packed` arrays for numba.

    Mass [kg]; inertia xx, xy, xz, yy, yz, zz [kg·m²]; allocation, n rows of 4; idle and largest
    thrusts [N] and motor constants [N·s²], n each; n rows for `step_rotor`.
    """

    mass: float
    inertia: Any
    allocation: Any
    idle_thrusts: Any
    max_thrusts: Any
    motor_constants: Any
    rotors: Any


def law_constants(vehicle: Vehicle, period: float) -> LawConstants:
    """Return the constants of a vehicle; `period` [s] is the control period, 0 for none."""
    inertia = vehicle.inertia
    max_thrusts = [rotor.max_thrust for rotor in vehicle.rotors]
    return LawConstants(
        mass=vehicle.mass,
        inertia=[*inertia[0].tolist(), *inertia[1, 1:].tolist(), float(inertia[2, 2])],
        allocation=allocation_matrix(vehicle.rotors, vehicle.p_BoBcm_B).tolist(),
        idle_thrusts=[IDLE_SPEED_SHARE**2 * thrust for thrust in max_thrusts],
        max_thrusts=max_thrusts,
        motor_constants=[rotor.motor_constant for rotor in vehicle.rotors],
        rotors=[rotor_period(rotor, period) for rotor in vehicle.rotors] if period else [],
    )


def packed(constants: LawConstants) -> tuple[np.ndarray, np.ndarray]:
    """Return constants as two arrays, (7) of the body and (n, 16) of the rotors.

    Each array handed to compiled code costs a quarter of a microsecond, hence so few.
    """
    columns = (constants.idle_thrusts, constants.max_thrusts, constants.motor_constants)
    body = np.array([constants.mass, *constants.inertia])
    rotors = np.column_stack([constants.allocation, *columns, constants.rotors])
    return body, rotors


@register_jitable
def unpacked(body: np.ndarray, rotors: np.ndarray) -> LawConstants:
    """Return the constants that `packed` made arrays of."""
    return LawConstants(
        body[0],
        body[1:7],
        rotors[:, 0:4],
        rotors[:, 4],
        rotors[:, 5],
        rotors[:, 6],
        rotors[:, 7:16],
    )


@register_jitable
def rotor_commands(
    state: Signal,
    acceleration: Signal,
    reference: Signal,
    guidance: Signal,
    gains: Signal,
    constants: LawConstants,
    commands: Signal,
) -> None:
    """Write the commanded rotor speeds (n) [rad/s] into `commands`.

    Args:
        state: of the plant (13): q_WB, p_WB [m], w_WB_W [rad/s], v_WB_W [m/s].
        acceleration: estimate in W (3) [m/s²].
        reference: see `cascade.Reference`.
        guidance: see `cascade.Guidance`.
        gains: see `cascade.Gains`.
        constants: of the vehicle.
        commands: n places.
    """
    n = len(constants.allocation)
    if guidance[1] > 0.0:
        wanted = wanted_velocity(state[4:7], reference, guidance, gains)
        f_W = wanted_specific_force(state[10:13], acceleration, wanted, gains)
        force, m_x, m_y, m_z = wanted_wrench(
            state[0:4], state[7:10], f_W, wanted[3], constants.mass, constants.inertia, gains
        )
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
            commands[i] = constants.idle_thrusts[i]
    for i in range(n):
        commands[i] = guidance[0] * (commands[i] / constants.motor_constants[i]) ** 0.5


@register_jitable
def control_update(
    state: Signal,
    reference: Signal,
    guidance: Signal,
    gains: Signal,
    constants: LawConstants,
    estimate: tuple[float, float],
    memory: Signal,
    thrusts: Signal,
    next_memory: Signal,
) -> None:
    """Do one sampled control update: estimate acceleration, run the law, step the rotors.

    What is remembered between updates is rotor speeds (n) and held commands (n) [rad/s], and the
    estimate's filtered velocity (3) [m/s].

    Args:
        state: as for `rotor_commands`, and so the next four.
        reference: see there.
        guidance: see there.
        gains: see there.
        constants: see there.
        estimate: share and rate of the acceleration estimate, see `acceleration_estimate`.
        memory: (2 n + 3).
        thrusts: n places for mean thrusts until the next update [N].
        next_memory: (2 n + 3) places.
    """
    n = len(thrusts)
    share, rate = estimate
    e_x = state[10] - memory[2 * n]
    e_y = state[11] - memory[2 * n + 1]
    e_z = state[12] - memory[2 * n + 2]
    acceleration = (rate * e_x, rate * e_y, rate * e_z)
    rotor_commands(state, acceleration, reference, guidance, gains, constants, thrusts)
    for i in range(n):
        command = thrusts[i]
        limit = constants.rotors[i][1]
        if command > limit:
            command = limit
        if command < 0.0:
            command = 0.0
        thrust, speed = step_rotor(command, memory[i], constants.rotors[i])
        thrusts[i] = thrust
        next_memory[i] = speed
        next_memory[n + i] = command
    next_memory[2 * n] = memory[2 * n] + share * e_x
    next_memory[2 * n + 1] = memory[2 * n + 1] + share * e_y
    next_memory[2 * n + 2] = memory[2 * n + 2] + share * e_z


def packed_update(
    state: np.ndarray,
    reference: np.ndarray,
    guidance: np.ndarray,
    gains: np.ndarray,
    body: np.ndarray,
    rotors: np.ndarray,
    estimate: tuple[float, float],
    memory: np.ndarray,
    thrusts: np.ndarray,
    next_memory: np.ndarray,
) -> None:
    """Do `control_update` with packed constants; this is what gets compiled."""
    constants = unpacked(body, rotors)
    control_update(
        state, reference, guidance, gains, constants, estimate, memory, thrusts, next_memory
    )
