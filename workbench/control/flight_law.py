"""One control update: the control law, allocation and rotor speeds, as pure functions.

The steps of an update, in `update` of `flight_law`:

1. estimate the acceleration from the velocity, and low-pass it and the setpoint (`estimated`,
   `smoothed`, `smoothed_setpoint`);
2. run the controller's `update`: setpoint and measured state -> wrench F, m and next memory;
3. compensate spin-up torque in the yaw moment (`kept_share`);
4. allocate the wrench to thrusts within limits (`mixer`, or `stopped_rotors`), and convert
   thrusts to rotor speeds (`allocate`).

The same source runs as plain Python with lists (floats or AutoDiffXd) and as machine code with
arrays. The diagram, linear models and compiled flights all use it.
"""

import math
from collections.abc import Callable, Sequence
from functools import lru_cache
from typing import Any, NamedTuple

import numpy as np

from workbench.common.jitable import Scalar, Vector, register_jitable, unique
from workbench.common.own_file import record
from workbench.control.controller import Controller
from workbench.control.flight_state import mass_velocity, still_air_drag, thrust_attitude
from workbench.control.guidance import (
    LIFT,
    MOTORS,
    Body,
    KnownRotor,
    KnownVehicle,
    Measured,
    Setpoint,
)
from workbench.control.mixer import mix
from workbench.control.stopped_rotors import any_stopped, mix_without
from workbench.dynamics.rotor_response import speed_command
from workbench.estimation.filters import after as section_after
from workbench.estimation.filters import lowpass, output
from workbench.plant.drag import drag_area, drag_rates
from workbench.plant.payload import NO_PAYLOAD, Payload, believed
from workbench.plant.rotors import wrench_matrix
from workbench.plant.thrust_frame import thrust_frame
from workbench.plant.vehicle import Vehicle

SOURCES = (
    "common/bounded_loops.py",
    "control",
    "dynamics",
    "estimation/filters.py",
    "plant/gravity.py",
)
"""Sources of the compiled update below `workbench/`, besides its controller."""
ALL_PARTS = -1.0
"""As the number of previous updates: every part of the law runs, as in linear models."""
NEAR = 1e-3
"""A centre of mass this near the base link's origin counts as being there [m]."""

FILTERED = 10
"""Number of the filters' states, see `FilterStates`."""


class FilterStates(NamedTuple):
    """States of the filters before a law.

    Attributes:
        velocity: of the estimate of the acceleration, in W (3) [m/s].
        acceleration: of the low-pass after it (3) [m/s²].
        setpoint: of the low-pass on velocity and yaw rate (4) [m/s, rad/s].
    """

    velocity: Vector
    acceleration: Vector
    setpoint: Vector


@register_jitable(forceinline=True)
def filter_states(numbers: Vector) -> FilterStates:
    """Return states from a vector of all of them (10)."""
    return FilterStates(numbers[0:3], numbers[3:6], numbers[6:10])


def steady_filters(velocity: Any) -> list[Any]:
    """Return all states (10) in steady flight at a velocity in W (3) [m/s], without turning."""
    return [*velocity, 0.0, 0.0, 0.0, *velocity, 0.0]


class ComputerSettings(NamedTuple):
    """Live parameters of the filters before a law and of the commands; see `workbench params`."""

    setpoint_lowpass: float = 0.0
    derivative_lowpass: float = 0.0
    command_steps: float = 0.0


PLAIN = ComputerSettings()
"""No filters, and exact commands."""


class LawConstants(NamedTuple):
    """The vehicle as the law knows it: lists for Python; compiled flights have a record like it.

    Inertia, allocation and effects are for T, the frame of upright hover, see `plant.thrust_frame`.

    Attributes:
        mass: of vehicle and known payload [kg].
        inertia: xx, xy, xz, yy, yz, zz [kg·m²].
        q_BT: orientation of T in B, w x y z.
        p_BoBcm_B: position of the centre of mass in B [m].
        drag: see `plant.drag.DragRates`.
        allocation: n rows of 4, from a wrench to thrusts.
        effects: n rows of 4, wrench per thrust.
        idle_thrusts: n [N].
        max_thrusts: n [N].
        motor_constants: n [N·s²].
        half_linear_speeds: n halves of the rotors' `linear_speed` [rad/s].
        spin_up_time: lead of spin-up torque over drag torque in yaw [s].
        rotor_lag: time constant of the slowest rotor at hover [s].
        payload: known mass of the payload, included in the mass [kg].
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
    rotor_lag: float
    payload: float


def law_constants(vehicle: Vehicle, payload: Payload = NO_PAYLOAD) -> LawConstants:
    """Return a vehicle's constants, as the law knows them.

    Args:
        vehicle: without a payload.
        payload: that the law assumes, with its known mass.

    Raises:
        WorkbenchError: if no rotor speeds can hold both in hover.
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
        rotor_lag=vehicle.rotor_lag,
        payload=payload.known_payload_mass,
    )


@register_jitable(forceinline=True)
def known_body(constants: LawConstants) -> Body:
    """Return the body as a law's `update` gets it."""
    return Body(
        constants.mass,
        constants.inertia,
        constants.drag[2],
        constants.rotor_lag,
        constants.spin_up_time,
        constants.payload,
    )


def known_vehicle(constants: LawConstants) -> KnownVehicle:
    """Return the vehicle as a law's `design` gets it."""
    numbers = zip(
        constants.effects,
        constants.idle_thrusts,
        constants.max_thrusts,
        constants.motor_constants,
        constants.half_linear_speeds,
        strict=True,
    )
    rotors = tuple(
        KnownRotor(f, m_x, m_y, m_z, idle, most, constant, 2.0 * half)
        for (f, m_x, m_y, m_z), idle, most, constant, half in numbers
    )
    return KnownVehicle(*known_body(constants), rotors)


@register_jitable(forceinline=True)
def estimated(velocity: Vector, filtered: Vector, estimate: tuple[float, float]) -> tuple[Any, Any]:
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
def smoothed(section: Any, x: Vector, u: Vector) -> tuple[Any, Any]:
    """Return the outputs (3) and next states (3) of first-order low-passes for inputs (3)."""
    x_x, x_y, x_z = x
    u_x, u_y, u_z = u
    out = (
        output(section, 0.0, x_x, u_x),
        output(section, 0.0, x_y, u_y),
        output(section, 0.0, x_z, u_z),
    )
    after = (
        section_after(section, 0.0, x_x, u_x)[1],
        section_after(section, 0.0, x_y, u_y)[1],
        section_after(section, 0.0, x_z, u_z)[1],
    )
    return out, after


@register_jitable(forceinline=True)
def smoothed_setpoint(section: Any, x: Vector, setpoint: Any) -> tuple[Any, Any]:
    """Return a setpoint with low-passed velocity and yaw rate, and the filters' next states (4).

    Args:
        section: of the low-pass.
        x: its states (4).
        setpoint: see `guidance.Setpoint`.
    """
    v_x, v_y, v_z, yaw_rate, p_x, p_y, p_z, follow = setpoint.reference
    (v_x, v_y, v_z), after = smoothed(section, (x[0], x[1], x[2]), (v_x, v_y, v_z))
    turned = section_after(section, 0.0, x[3], yaw_rate)[1]
    yaw_rate = output(section, 0.0, x[3], yaw_rate)
    reference = (v_x, v_y, v_z, yaw_rate, p_x, p_y, p_z, follow)
    return Setpoint(reference, setpoint.guidance, setpoint.a_WBcm), after + (turned,)


@register_jitable(forceinline=True)
def resolved(speed: Scalar, full: Scalar, steps: Scalar) -> Scalar:
    """Return a commanded speed, rounded to the resolution of commands [rad/s].

    Args:
        speed: to be rounded.
        full: largest speed.
        steps: number of steps from 0 to the largest speed.
    """
    return full / steps * math.floor(steps * speed / full + 0.5)


@register_jitable(forceinline=True)
def kept_share(g: Any, spin_up_time: Scalar, period: Scalar) -> Scalar:
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
def commanded_wrench(commands: Vector, constants: LawConstants) -> tuple[Any, Any, Any, Any]:
    """Return force [N] and moment [N·m] in T of the rotors at the commanded speeds (n)."""
    force, m_x, m_y, m_z = 0.0, 0.0, 0.0, 0.0
    for i in range(len(constants.effects)):
        linear_speed = 2.0 * constants.half_linear_speeds[i]
        thrust = constants.motor_constants[i] * commands[i] * (commands[i] + linear_speed)
        effect = constants.effects[i]
        force = force + effect[0] * thrust
        m_x = m_x + effect[1] * thrust
        m_y = m_y + effect[2] * thrust
        m_z = m_z + effect[3] * thrust
    return force, m_x, m_y, m_z


@register_jitable
def allocate(
    wrench: Vector, lift: Scalar, motors: Scalar, shares: Vector, constants: Any, commands: Vector
) -> None:
    """Write the rotor speeds (n) [rad/s] for a wrench, or for the nearest possible one.

    Args:
        wrench: force along z [N] and moment [N·m] in T.
        lift: 0 lets the rotors idle.
        motors: 0 stops them.
        shares: remaining share of each rotor's thrust (n). The law knows stopped rotors (0), as
            motors report them, but not weak ones.
        constants: see `LawConstants`.
        commands: n places to write to.
    """
    n = len(constants.allocation)
    if lift > 0.0:
        force, m_x, m_y, m_z = wrench
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

    gains: Callable[..., Any]
    memory: Callable[..., Any]
    wrench: Callable[..., Any]
    update: Callable[..., Any]


@lru_cache(maxsize=64)
def flight_law(controller: Controller) -> FlightLaw:
    """Return the functions of a control update with a controller."""
    law = controller.update
    read_gains = _reader("Gains", controller.gain_names, controller.key)
    read_memory = _reader("Memory", [state.name for state in controller.memory], controller.key)
    initial = tuple(controller.initial_memory)
    elapsed = _elapsed(controller.dividers, controller.key)

    @register_jitable(forceinline=True)
    def wrench(
        state,
        acceleration,
        voltage,
        setpoint,
        g,
        memory,
        commanded,
        dt,
        constants,
        loops,
        count=ALL_PARTS,
    ):
        """Return the wrench (4) that the law commands while the rotors lift, and its memory.

        Args:
            state: of the plant (13): q_WB, p_WB [m], w_WB_W [rad/s], v_WB_W [m/s].
            acceleration: estimate in W (3) [m/s²].
            voltage: of the battery, see `guidance.Measured`.
            setpoint: see `guidance.Setpoint`.
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
        measured = Measured(
            p_WB, v_WBcm, acceleration, q_WT, w_WB, drag, commanded, voltage, elapsed(count, dt)
        )
        wanted, after = law(measured, setpoint, g, known_body(constants), memory, dt, loops)
        return wanted, after[0:]  # a plain tuple

    @register_jitable
    def update(
        state,
        voltage,
        setpoint,
        gains,
        shares,
        constants,
        loops,
        estimate,
        settings,
        filtered,
        memory,
        speeds,
        count=ALL_PARTS,
    ):
        """Do one sampled update: estimate acceleration, run the law, and command the rotors.

        Args:
            state: of the plant (13), as measured.
            voltage: of the battery, see `guidance.Measured`.
            setpoint: see `guidance.Setpoint`.
            gains: in the controller's order.
            shares: see `allocate`.
            constants: of the vehicle.
            loops: see `loop_points`.
            estimate: share and rate of the acceleration estimate, see `acceleration_estimate`.
            settings: see `ComputerSettings`.
            filtered: states of the filters (10), see `FilterStates`.
            memory: of the law, in its order.
            speeds: previous commands (n) [rad/s], overwritten by the new ones.
            count: number of previous updates, see `ALL_PARTS`.

        Returns:
            Next filter states, and the next memory of the law; compiled code gives `gains`,
            `filtered` and `memory` as tuples.
        """
        states = filter_states(filtered)
        acceleration, velocity = estimated(state[10:13], states.velocity, estimate)
        share, rate = estimate
        dt = share / rate
        # a low-pass that is off passes its input
        section = lowpass(settings[1], 1.0, dt)
        acceleration, derivative = smoothed(section, states.acceleration, acceleration)
        section = lowpass(settings[0], 1.0, dt)
        setpoint, asked = smoothed_setpoint(section, states.setpoint, setpoint)

        g = read_gains(gains)
        commanded = commanded_wrench(speeds, constants)
        guidance = setpoint.guidance
        wanted, remembered = (0.0, 0.0, 0.0, 0.0), initial
        if guidance[LIFT] > 0.0:
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
        force, m_x, m_y, m_z = wanted
        m_z = m_z + kept_share(g, constants.spin_up_time, dt) * (commanded[3] - m_z)
        allocate(
            (force, m_x, m_y, m_z), guidance[LIFT], guidance[MOTORS], shares, constants, speeds
        )
        return velocity + derivative + asked, remembered

    for function in (wrench, update):
        unique(function, controller.key)
    return FlightLaw(read_gains, read_memory, wrench, update)


def _reader(name: str, fields: Sequence[str], key: str) -> Callable[..., Any]:
    """Return a function from numbers to a named tuple; to an empty one without fields."""
    if not fields:
        return _nothing
    kind = record(f"{name}_{key}", fields)  # machine code knows a record by its type's name

    @register_jitable(forceinline=True)
    def read(numbers):
        return kind(*numbers)

    return unique(read, f"{name}_{key}")


@register_jitable(forceinline=True)
def _nothing(numbers):
    return ()


def _elapsed(dividers: Sequence[int], key: str) -> Callable[..., Any]:
    """Return a function that returns `elapsed` of `guidance.Measured`."""
    if not dividers:
        return _no_parts
    earlier, divider = _elapsed(dividers[:-1], key), float(dividers[-1])

    @register_jitable(forceinline=True)
    def elapsed(count, dt):
        return earlier(count, dt) + (_part_elapsed(count, dt, divider),)

    return unique(elapsed, f"{len(dividers)}_{key}")


@register_jitable(forceinline=True)
def _no_parts(count, dt):
    return ()


@register_jitable(forceinline=True)
def _part_elapsed(count, dt, divider):
    """Return the time since a part of a law last ran [s], 0 if it does not run now."""
    if count < 0.0:  # `ALL_PARTS`
        return dt
    return divider * dt if np.floor(count / divider) * divider == count else 0.0


@register_jitable(forceinline=True)
def full_speed(constants: LawConstants, i: int) -> Scalar:
    """Return the largest speed of a rotor that the law commands [rad/s]."""
    return speed_command(
        constants.max_thrusts[i], constants.motor_constants[i], constants.half_linear_speeds[i], 1.0
    )
