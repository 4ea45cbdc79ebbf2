"""The control update of a block: loops over its candidates around the law's own functions."""

from collections.abc import Callable
from typing import Any

import numpy as np

from workbench.common.errors import WorkbenchError
from workbench.common.jitable import register_jitable, unique
from workbench.control.controller import Controller
from workbench.control.flight_law import (
    DERIVATIVE,
    SETPOINT,
    LawConstants,
    estimated,
    flight_law,
    gains_reader,
    kept_share,
    memory_reader,
    resolved,
    smoothed,
    smoothed_setpoint,
    writer,
)
from workbench.control.guidance import Setpoint
from workbench.control.mixer import mix, plain_thrust
from workbench.control.stopped_rotors import mix_without
from workbench.design.rollout.rows import (
    ALLOCATION,
    BEFORE,
    BODY,
    COMMAND,
    COMMAND_STEPS,
    COMMANDED,
    COUNT,
    EFFECTS,
    EFFORT,
    FILTERED,
    GAINS,
    HALF,
    HARD,
    HOLD,
    HOLDING,
    IDLE,
    KNOWN,
    LANES,
    LOST,
    MOST,
    MOTOR,
    PEAK,
    SECTIONS,
    SPEED,
    STOPPED,
    THRUST,
    VOLTAGE,
    put,
    put3,
    put4,
    take,
    take3,
    take4,
    take6,
    take8,
    take9,
    take13,
)
from workbench.dynamics.rotor_response import speed_command

NO_BRAKE = (0.0,) * 13
"""There are no obstacles here: what `Guidance` has behind the point to hold."""


def make_want(controller: Controller) -> Callable[..., None]:
    """Return the loop that runs a controller's law.

    Raises:
        WorkbenchError: if it cannot be compiled.
    """
    if not controller.compiles:
        raise WorkbenchError(
            f"{controller.name} is a system of Drake's, which cannot be compiled: fly it on the "
            "full diagram"
        )
    law_wrench = flight_law(controller).wrench
    rows = len(controller.parameters) + len(controller.designed)
    place = f"b[({{}} + {GAINS}) * {LANES} + i]"
    remembered = f"b[({{}} + {GAINS + rows}) * {LANES} + i]"
    gains_at = gains_reader(controller, place, "b, i")
    memory_at = memory_reader(controller, remembered, "b, i")
    put_memory = writer(len(controller.memory), controller.key, remembered, "b, i")

    @register_jitable
    def want(block, rotors, estimate):
        """Write the wanted efforts, and step the estimates of acceleration and the memories."""
        share, rate = estimate
        for i in range(LANES):
            put4(block, BEFORE, i, (0.0, 0.0, 0.0, 0.0))
        for number in range(len(rotors)):
            rotor = rotors[number]
            for i in range(LANES):
                thrust = take(rotor, THRUST, i)
                force, m_x, m_y, m_z = take4(block, BEFORE, i)
                e_f, e_x, e_y, e_z = take4(rotor, EFFECTS, i)
                put4(
                    block,
                    BEFORE,
                    i,
                    (
                        force + e_f * thrust,
                        m_x + e_x * thrust,
                        m_y + e_y * thrust,
                        m_z + e_z * thrust,
                    ),
                )
        for i in range(LANES):
            known = take13(block, KNOWN, i)
            acceleration, filtered = estimated(known[10:13], take3(block, FILTERED, i), estimate)
            section, states = take9(block, SECTIONS + 9, i), take3(block, FILTERED + DERIVATIVE, i)
            acceleration, derivative = smoothed(section, states, acceleration)
            constants = LawConstants(
                take(block, BODY, i),
                take6(block, BODY + 1, i),
                take4(block, BODY + 7, i),
                take3(block, BODY + 11, i),
                take3(block, BODY + 14, i),
                (),
                (),
                (),
                (),
                (),
                (),
                take(block, BODY + 17, i),
                take(block, BODY + 18, i),
                take(block, BODY + 19, i),
            )
            hold = take(block, HOLDING, i)
            guidance = (1.0, 1.0, 1.0, 0.0, hold, hold) + take3(block, HOLD, i) + NO_BRAKE
            setpoint = Setpoint(take8(block, COMMAND, i), guidance, (0.0, 0.0, 0.0))
            section, states = take9(block, SECTIONS, i), take4(block, FILTERED + SETPOINT, i)
            setpoint, asked = smoothed_setpoint(section, states, setpoint)
            g = gains_at(block, i)
            dt = share / rate
            before = take4(block, BEFORE, i)
            wanted, after = law_wrench(
                known,
                acceleration,
                take(block, VOLTAGE, i),
                setpoint,
                g,
                memory_at(block, i),
                before,
                dt,
                constants,
                None,
                take(block, COUNT, i),
            )
            force, m_x, m_y, m_z = wanted
            kept = kept_share(g, constants.spin_up_time, dt)
            m_z = m_z + kept * (before[3] - m_z)
            put4(block, EFFORT, i, (force, m_x, m_y, m_z))
            put3(block, FILTERED, i, filtered)
            put3(block, FILTERED + DERIVATIVE, i, derivative)
            put4(block, FILTERED + SETPOINT, i, asked)
            put_memory(block, i, after)

    return unique(want, controller.key)


def make_update(controller: Controller) -> Callable[..., None]:
    """Return a control update with a controller's law.

    Raises:
        WorkbenchError: if it cannot be compiled.
    """
    want = make_want(controller)

    @register_jitable
    def update(block, rotors, shares, law_rotors, schedule, estimate, noted, coarse):
        """Write the commands of the rotors.

        Args:
            block: of the candidates.
            rotors: blocks of the rotors.
            shares: of their thrust that these give (m, n).
            law_rotors: see `engine.Crafts` (m, n, 12).
            schedule: see `Schedule`.
            estimate: see `acceleration_estimate.sampled_estimate`.
            noted: whether peaks of the speeds are.
            coarse: whether anybody's commands come in steps.
        """
        want(block, rotors, estimate)
        allocate(block, rotors, shares, law_rotors, noted, coarse)

    return unique(update, controller.key)


@register_jitable
def allocate(block, rotors, shares, law_rotors, noted, coarse):
    """Write the commands that make the wanted efforts, see `make_update`."""
    mix_plainly(block, rotors)
    mix_hard(block, rotors, shares, law_rotors)
    command(block, rotors, noted)
    if coarse:
        resolve(block, rotors)


@register_jitable
def mix_plainly(block, rotors):
    """Write wanted thrusts, and for whom they are beyond what rotors can give."""
    for i in range(LANES):
        put(block, HARD, i, take(block, STOPPED, i))
    for number in range(len(rotors)):
        rotor = rotors[number]
        for i in range(LANES):
            force, m_x, m_y, m_z = take4(block, EFFORT, i)
            thrust = plain_thrust(force, m_x, m_y, m_z, take4(rotor, ALLOCATION, i))
            hard = take(block, HARD, i)
            if thrust > take(rotor, MOST, i):
                hard = 1.0
            if thrust < take(rotor, IDLE, i):
                hard = 1.0
            put(rotor, THRUST, i, thrust)
            put(block, HARD, i, hard)


@register_jitable
def mix_hard(block, rotors, shares, law_rotors):
    """Write the wanted thrusts of those that saturate, or have lost rotors, one by one."""
    n = len(rotors)
    hard = 0.0
    for i in range(LANES):
        hard += take(block, HARD, i)
    if hard == 0.0:
        return
    thrusts: Any = np.empty(n)
    for i in range(len(shares)):
        if take(block, HARD, i) == 0.0:
            continue
        force, m_x, m_y, m_z = take4(block, EFFORT, i)
        rows = law_rotors[i]
        idle, most = rows[:, 8].copy(), rows[:, 9].copy()
        if take(block, STOPPED, i) > 0.0:
            for number in range(n):
                most[number] = most[number] if shares[i, number] > 0.0 else 0.0
            mix_without(force, m_x, m_y, m_z, rows[:, 4:8].copy(), most, thrusts)
        else:
            mix(force, m_x, m_y, m_z, rows[:, 0:4].copy(), idle, most, thrusts)
        for number in range(n):
            put(rotors[number], THRUST, i, thrusts[number])


@register_jitable
def command(block, rotors, noted):
    """Write the commanded speeds; note peaks of the present ones, if they are to be noted."""
    for number in range(len(rotors)):
        rotor = rotors[number]
        for i in range(LANES):
            speed, peak = take(rotor, SPEED, i), take(rotor, PEAK, i)
            flies = take(block, LOST, i) < 0.0
            put(rotor, PEAK, i, speed if noted and flies and speed > peak else peak)
            thrust, half = take(rotor, THRUST, i), take(rotor, HALF, i)
            wanted = speed_command(thrust, take(rotor, MOTOR, i), half, 1.0)
            put(rotor, COMMANDED, i, wanted)


@register_jitable
def resolve(block, rotors):
    """Let commands have the steps that they come in, of those for whom they do."""
    for number in range(len(rotors)):
        rotor = rotors[number]
        for i in range(LANES):
            steps, wanted = take(block, COMMAND_STEPS, i), take(rotor, COMMANDED, i)
            if steps > 0.0:
                most, motor = take(rotor, MOST, i), take(rotor, MOTOR, i)
                half = take(rotor, HALF, i)
                speed = resolved(wanted, speed_command(most, motor, half, 1.0), steps)
                put(rotor, COMMANDED, i, speed)
                put(rotor, THRUST, i, motor * speed * (speed + 2.0 * half))
