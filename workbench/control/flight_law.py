"""One control update: the control law, allocation and rotor speeds, as pure functions.

The steps of an update, in `update` of `flight_law`:

1. estimate the acceleration from the velocity, and low-pass it and the setpoint
   (`estimated_acceleration`, `lowpassed_vector`, `smoothed_setpoint`);
2. run the controller's `update`: setpoint and measured state -> wrench F, m and next memory;
3. compensate spin-up torque in the yaw moment (`yaw_moment_weight`);
4. allocate the wrench to thrusts within limits (`mixer`), and convert thrusts to rotor speeds
   (`allocate`).

The same source runs as plain Python with lists (floats or AutoDiffXd) and as machine code with
arrays. The diagram, linear models and compiled flights all use it.
"""

from collections.abc import Callable, Sequence
from functools import lru_cache
from typing import Any, NamedTuple

import numpy as np

from workbench.common.jitable import give_unique_name, register_jitable
from workbench.common.own_file import user_record_type
from workbench.common.vectors import MutableNumbers, Numbers, Vector3, Wrench
from workbench.control.controller import Controller
from workbench.control.flight_state import mass_velocity, still_air_drag, thrust_attitude
from workbench.control.guidance import (
    LIFT_FIELD,
    MOTORS_FIELD,
    Gains,
    LawResult,
    LawSetpoint,
    MeasuredMotion,
    Memory,
)
from workbench.control.law_constants import LawConstants, known_body
from workbench.control.law_signals import (
    estimated_acceleration,
    filter_states,
    lowpassed_vector,
    smoothed_setpoint,
)
from workbench.control.loop_points import Probes
from workbench.control.mixer import mix
from workbench.dynamics.rotor_response import speed_command
from workbench.estimation.filters import lowpass

LAW_SOURCES = (
    "common/bounded_loops.py",
    "control",
    "dynamics",
    "estimation/filters.py",
    "plant/gravity.py",
)
"""Sources of the compiled update below `workbench/`, besides its controller."""
ALL_PARTS = -1.0
"""As the number of previous updates: every part of the law runs, as in linear models."""


class ComputerSettings(NamedTuple):
    """Live parameters of the filters before a law and of the commands; see `workbench params`."""

    setpoint_lowpass: float = 0.0
    derivative_lowpass: float = 0.0
    command_steps: float = 0.0


UNFILTERED_COMPUTER = ComputerSettings()
"""No filters, and exact commands."""


@register_jitable(forceinline=True)
def yaw_moment_weight(g: Gains, spin_up_time: float, period: float) -> float:
    """Return the weight of the previous yaw moment in the next one.

    For a commanded yaw moment m, drag torque gives m and spin-up torque spin_up_time dm/dt. Their
    sum should be the wanted moment:

        wanted = m + lead dm/dt,  lead = spin_up_feedforward spin_up_time

    with the difference between updates for dm/dt.

    Args:
        g: gains by name.
        spin_up_time: see `LawConstants` [s].
        period: between updates [s].
    """
    lead = g.spin_up_feedforward * spin_up_time
    return lead / (lead + period)


@register_jitable(forceinline=True)
def commanded_wrench(commands: Numbers, constants: LawConstants) -> Wrench:
    """Return force [N] and moment [N·m] in T at commanded speeds (n) and tilts (m)."""
    force, m_x, m_y, m_z = 0.0, 0.0, 0.0, 0.0
    n = len(constants.motor_constants)
    for i in range(n):
        linear_speed = 2.0 * constants.half_linear_speeds[i]
        thrust = constants.motor_constants[i] * commands[i] * (commands[i] + linear_speed)
        effect = constants.effects[i]
        force = force + effect[0] * thrust
        m_x = m_x + effect[1] * thrust
        m_y = m_y + effect[2] * thrust
        m_z = m_z + effect[3] * thrust
    for i in range(n, len(constants.effects)):
        effect = constants.effects[i]
        force = force + effect[0] * commands[i]
        m_x = m_x + effect[1] * commands[i]
        m_y = m_y + effect[2] * commands[i]
        m_z = m_z + effect[3] * commands[i]
    return force, m_x, m_y, m_z


@register_jitable(forceinline=True)
def allocate(
    wrench: Wrench,
    lift: float,
    motors: float,
    constants: LawConstants,
    commands: MutableNumbers,
) -> None:
    """Write the rotor speeds (n) [rad/s] for a wrench, or for the nearest possible one.

    The angles (m) [rad] of tilts come after them.

    Args:
        wrench: force along z [N] and moment [N·m] in T.
        lift: 0 lets the rotors idle.
        motors: 0 stops them.
        constants: see `LawConstants`.
        commands: n + m places to write to.
    """
    n = len(constants.motor_constants)
    if lift > 0.0:
        force, m_x, m_y, m_z = wrench
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
        for i in range(n, len(constants.allocation)):
            commands[i] = 0.0
    for i in range(n):
        commands[i] = speed_command(
            commands[i], constants.motor_constants[i], constants.half_linear_speeds[i], motors
        )


class FlightLaw(NamedTuple):
    """The functions of an update with one controller; see `flight_law`.

    Attributes:
        gains: from a sequence of numbers to gains by name.
        memory: from a sequence of numbers to the law's states by name.
        wrench: from the plant's state to the wrench that the law commands.
        update: one update.
    """

    gains: Callable[[Numbers], Gains]
    memory: Callable[[Numbers], Memory]
    wrench: Callable[..., LawResult]
    update: Callable[..., tuple[tuple[float, ...], tuple[float, ...]]]


@lru_cache(maxsize=64)
def flight_law(controller: Controller) -> FlightLaw:
    """Return the functions of a control update with a controller."""
    law = controller.update
    read_gains = _reader("Gains", controller.gain_names, controller.key)
    read_memory = _reader("Memory", [state.name for state in controller.memory], controller.key)
    initial = tuple(controller.initial_memory)
    elapsed = _elapsed(controller.dividers, controller.key)
    servos = len(controller.servos)
    joints = _last_numbers(13, 2 * servos, controller.key)
    write_setpoints = _setpoint_writer(servos, controller.key)
    at_rest = (0.0,) * (4 + servos)

    @register_jitable(forceinline=True)
    def wrench(
        state: Numbers,
        acceleration: Vector3,
        voltage: float,
        setpoint: LawSetpoint,
        g: Gains,
        memory: Memory,
        commanded: Wrench,
        dt: float,
        constants: LawConstants,
        loops: Probes,
        count: float = ALL_PARTS,
    ) -> LawResult:
        """Return the wrench (4) that the law commands while the rotors lift, and its memory.

        Args:
            state: of the plant (13): q_WB, p_WB [m], w_WB_W [rad/s], v_WB_W [m/s]; then positions
                and velocities of the joints that the law commands.
            acceleration: estimate in W (3) [m/s²].
            voltage: of the battery, see `guidance.MeasuredMotion`.
            setpoint: see `guidance.LawSetpoint`.
            g: gains by name.
            memory: by name.
            commanded: see `commanded_wrench`.
            dt: since the update before [s].
            constants: of the vehicle; those of the body are used.
            loops: see `loop_points`.
            count: number of previous updates, see `ALL_PARTS`.
        """
        q_WT = thrust_attitude(state[0:4], constants.q_BT)
        v_WBcm = mass_velocity(state, constants.p_BoBcm_B)
        drag = still_air_drag(q_WT, v_WBcm, constants.drag)
        p_WB, w_WB = (state[4], state[5], state[6]), (state[7], state[8], state[9])
        measured = MeasuredMotion(
            p_WB,
            v_WBcm,
            acceleration,
            q_WT,
            w_WB,
            drag,
            commanded,
            voltage,
            elapsed(count, dt),
            joints(state),
            max(count, 0.0) * dt,
        )
        wanted, after = law(measured, setpoint, g, known_body(constants), memory, dt, loops)
        return wanted, after[0:]  # a plain tuple

    @register_jitable(forceinline=True)
    def update(
        state: Numbers,
        voltage: float,
        setpoint: LawSetpoint,
        gains: Numbers,
        constants: LawConstants,
        loops: Probes,
        estimate: tuple[float, float],
        settings: Numbers,
        filtered: Numbers,
        memory: Numbers,
        speeds: MutableNumbers,
        count: float = ALL_PARTS,
    ) -> tuple[tuple[float, ...], tuple[float, ...]]:
        """Do one sampled update: estimate acceleration, run the law, and command the rotors.

        Args:
            state: of the plant (13), as measured, and of joints, see `wrench`.
            voltage: of the battery, see `guidance.MeasuredMotion`.
            setpoint: see `guidance.LawSetpoint`.
            gains: in the controller's order.
            constants: of the vehicle.
            loops: see `loop_points`.
            estimate: share and rate of the acceleration estimate, see `acceleration_estimate`.
            settings: see `ComputerSettings`.
            filtered: states of the filters (10), see `FilterStates`.
            memory: of the law, in its order.
            speeds: previous commands (n) [rad/s], angles of tilts, and setpoints of the servos that
                the law commands, overwritten by the new ones.
            count: number of previous updates, see `ALL_PARTS`.

        Returns:
            Next filter states, and the next memory of the law; compiled code gives `gains`,
            `filtered` and `memory` as tuples.
        """
        states = filter_states(filtered)
        acceleration, velocity = estimated_acceleration(state[10:13], states.velocity, estimate)
        share, rate = estimate
        dt = share / rate
        # a low-pass that is off passes its input
        section = lowpass(settings[1], 1.0, dt)
        acceleration, derivative = lowpassed_vector(section, states.acceleration, acceleration)
        section = lowpass(settings[0], 1.0, dt)
        setpoint, asked = smoothed_setpoint(section, states.setpoint, setpoint)

        g = read_gains(gains)
        commanded = commanded_wrench(speeds, constants)
        guidance = setpoint.guidance
        wanted, remembered = at_rest, initial
        if guidance[LIFT_FIELD] > 0.0:
            wanted, remembered = wrench(
                state,
                acceleration,
                voltage,
                setpoint,
                g,
                read_memory(memory),
                commanded,
                dt,
                constants,
                loops,
                count,
            )
        force, m_x, m_y, m_z = wanted[0], wanted[1], wanted[2], wanted[3]
        m_z = m_z + yaw_moment_weight(g, constants.spin_up_time, dt) * (commanded[3] - m_z)
        allocate(
            (force, m_x, m_y, m_z), guidance[LIFT_FIELD], guidance[MOTORS_FIELD], constants, speeds
        )
        write_setpoints(wanted, speeds, len(constants.allocation))
        return velocity + derivative + asked, remembered

    for function in (wrench, update):
        give_unique_name(function, controller.key)
    return FlightLaw(read_gains, read_memory, wrench, update)


def _reader(name: str, fields: Sequence[str], key: str) -> Callable[..., Any]:
    """Return a function from numbers to a named tuple; to an empty one without fields."""
    if not fields:
        return _no_numbers
    kind = user_record_type(
        f"{name}_{key}", fields
    )  # machine code knows a record by its type's name

    @register_jitable(forceinline=True)
    def read(numbers: Numbers) -> tuple[float, ...]:
        return kind(*numbers)

    return give_unique_name(read, f"{name}_{key}")


@register_jitable(forceinline=True)
def _no_numbers(numbers: Numbers) -> tuple[float, ...]:
    return ()


def _elapsed(dividers: Sequence[int], key: str) -> Callable[[float, float], tuple[float, ...]]:
    """Return a function that returns `elapsed` of `guidance.MeasuredMotion`."""
    if not dividers:
        return _no_parts
    earlier, divider = _elapsed(dividers[:-1], key), float(dividers[-1])

    @register_jitable(forceinline=True)
    def elapsed(count: float, dt: float) -> tuple[float, ...]:
        return earlier(count, dt) + (_part_elapsed(count, dt, divider),)

    return give_unique_name(elapsed, f"{len(dividers)}_{key}")


def _last_numbers(first: int, count: int, key: str) -> Callable[[Numbers], tuple[float, ...]]:
    """Return a function that returns some numbers of a sequence, from one on, as a tuple."""
    if not count:
        return _no_numbers
    earlier, place = _last_numbers(first, count - 1, key), first + count - 1

    @register_jitable(forceinline=True)
    def last(numbers: Numbers) -> tuple[float, ...]:
        return earlier(numbers) + (numbers[place],)

    return give_unique_name(last, f"{first}_{count}_{key}")


def _setpoint_writer(count: int, key: str) -> Callable[[Numbers, MutableNumbers, int], None]:
    """Return a function that writes what follows a wrench to commands, from a place on."""
    if not count:
        return _write_nothing
    earlier, last = _setpoint_writer(count - 1, key), count - 1

    @register_jitable(forceinline=True)
    def write(wanted: Numbers, commands: MutableNumbers, place: int) -> None:
        earlier(wanted, commands, place)
        commands[place + last] = wanted[4 + last]

    return give_unique_name(write, f"{count}_{key}")


@register_jitable(forceinline=True)
def _write_nothing(wanted: Numbers, commands: MutableNumbers, place: int) -> None:
    return None


@register_jitable(forceinline=True)
def _no_parts(count: float, dt: float) -> tuple[float, ...]:
    return ()


@register_jitable(forceinline=True)
def _part_elapsed(count: float, dt: float, divider: float) -> float:
    """Return the time since a part of a law last ran [s], 0 if it does not run now."""
    if count < 0.0:  # `ALL_PARTS`
        return dt
    return divider * dt if np.floor(count / divider) * divider == count else 0.0


@register_jitable(forceinline=True)
def full_speed(constants: LawConstants, i: int) -> float:
    """Return the largest speed of a rotor that the law commands [rad/s]."""
    return speed_command(
        constants.max_thrusts[i], constants.motor_constants[i], constants.half_linear_speeds[i], 1.0
    )
