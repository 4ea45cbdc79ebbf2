"""What a model cannot explain of a flight, as a force and a moment over time, and flights with it.

Along a log, closed loop: in each control period the law commands on what the flight computer knew,
and the force in W and the moment in B are found which bring the model to where the log has it at
the period's end. Velocities answer a held push linearly, so a trial without a push and one with it
are enough, and another one for what turning in the period changes:

    f = m (v_log - v) / T,   m = J (w_log - w) / T

Position and attitude are held by asking for velocities that close what is left of their difference
within `CLOSES`. Flown again with these pushes, the same law makes the same flight.
"""

from collections.abc import Callable
from functools import lru_cache
from typing import Any

import numpy as np

from workbench.common.compiled import compile_cached
from workbench.common.jitable import register_jitable, unique
from workbench.control.controller import Controller
from workbench.control.flight_law import FILTERED, flight_law
from workbench.design.predict.flown import GO_TO, PUSH, SOURCES, fly_period, seen, times
from workbench.dynamics.rigid_body import into_body, rotation

CLOSES = 0.05
"""Time in which a difference of position or attitude is closed [s]."""
TRIALS = 3
"""Of a control period, the last of which counts."""


@register_jitable
def wanted(state, target, share, period, found):  # type: ignore[no-untyped-def]
    """Write angular velocity and velocity (6) in W which a period is to end with.

    Args:
        state: of the model at its begin (13).
        target: of the log at its end (13).
        share: 1 / `CLOSES` [1/s].
        period: its length [s].
        found: places (6).
    """
    back = (state[0], -state[1], -state[2], -state[3])
    between = times(target[0:4], back)
    sign, half = 2.0 if between[0] >= 0.0 else -2.0, 0.5 * period
    for i in range(3):
        turned = half * (state[7 + i] + target[7 + i])
        moved = half * (state[10 + i] + target[10 + i])
        found[i] = target[7 + i] + share * (sign * between[1 + i] - turned)
        found[3 + i] = target[10 + i] + share * (target[4 + i] - state[4 + i] - moved)


@register_jitable
def correct(push, state, asked, craft):  # type: ignore[no-untyped-def]
    """Add to a push, in place, what a period's end lacked of the velocities asked for."""
    steps, step = craft.steps
    rate = 1.0 / (steps * step)
    mass, inertia = craft.body[0], craft.body[1:7]
    R = rotation(state[0:4])
    lacks = (asked[0] - state[7], asked[1] - state[8], asked[2] - state[9])
    x, y, z = into_body(R, lacks)
    for i in range(3):
        push[i] += rate * mass * (asked[3 + i] - state[10 + i])
    push[6] += rate * (inertia[0] * x + inertia[1] * y + inertia[2] * z)
    push[7] += rate * (inertia[1] * x + inertia[3] * y + inertia[4] * z)
    push[8] += rate * (inertia[2] * x + inertia[4] * y + inertia[5] * z)


@lru_cache(maxsize=16)
def compiled_disturbed(controller: Controller) -> tuple[Callable[..., Any], Callable[..., Any]]:
    """Return `follow` and `refly` of a controller, compiled at their first call."""
    whose = "" if controller.shipped else f" with {controller.name}"
    follow, refly = (
        compile_cached(
            function,
            (*SOURCES, "design/predict/disturbed.py"),
            f"{what}{whose}",
            parts=80,
            text=controller.digest,
            file=str(controller.file),
            error_model="numpy",
        )
        for function, what in (
            (make_follow(controller), "flights along a log"),
            (make_refly(controller), "flights with another law"),
        )
    )
    return follow, refly


def make_follow(controller: Controller) -> Callable[..., Any]:
    """Return a function that finds the pushes along a log."""
    update = register_jitable(flight_law(controller).packed_update)

    def follow(  # type: ignore[no-untyped-def]
        targets,
        speeds,
        memory,
        count,
        errors,
        references,
        voltages,
        shares,
        pressure,
        estimate,
        share,
        craft,
    ):
        """Return states (K+1, 13) along a log, and the pushes (K, 9) of each control period.

        Args:
            targets: states of the log at each update and at the end (K+1, 13).
            speeds: of the rotors at the start (n) [rad/s].
            memory: of the law at the start (k).
            count: of its updates before.
            errors: of the estimate, see `flown.ERROR` (K, 11).
            references: (K, 8).
            voltages: see `guidance.Measured` (K).
            shares: of their thrust that rotors give (n).
            pressure: see `flown.fly_period`.
            estimate: see `acceleration_estimate.sampled_estimate`.
            share: 1 / `CLOSES` [1/s].
            craft: see `flown.Craft`.
        """
        updates, n = len(references), len(craft.rotors)
        states, pushes = np.empty((updates + 1, 13)), np.zeros((updates, PUSH))
        state, turning, kept = targets[0].copy(), speeds.copy(), memory.copy()
        before, commands = speeds.copy(), speeds.copy()
        filtered, last, measured = np.zeros(FILTERED), np.zeros(6), np.zeros(13)
        filtered[0:3] = state[10:13]
        whole, still, plain = np.ones(n), np.zeros(3), np.zeros(3)
        room, asked = np.empty((3, n)), np.empty(6)
        for k in range(updates):
            states[k] = state
            seen(state, errors[k], measured)
            update(
                measured,
                voltages[k : k + 1],
                references[k],
                GO_TO,
                still,
                craft.gains,
                whole,
                craft.known,
                craft.probes,
                estimate,
                plain,
                filtered,
                kept,
                commands,
                count + k,
            )
            wanted(state, targets[k + 1], share, craft.steps[0] * craft.steps[1], asked)
            for trial in range(TRIALS):
                tried, end, spun = state.copy(), last.copy(), turning.copy()
                fly_period(
                    tried, end, spun, before, commands, shares, pushes[k], pressure, craft, room
                )
                if trial + 1 < TRIALS:
                    correct(pushes[k], tried, asked, craft)
            state[:], last[:], turning[:], before[:] = tried, end, spun, commands
        states[updates] = state
        return states, pushes

    return unique(follow, controller.key)


def make_refly(controller: Controller) -> Callable[..., Any]:
    """Return a function that flies with pushes over time."""
    update = register_jitable(flight_law(controller).packed_update)

    def refly(  # type: ignore[no-untyped-def]
        start,
        speeds,
        memory,
        count,
        errors,
        references,
        voltages,
        shares,
        pushes,
        pressure,
        estimate,
        craft,
    ):
        """Return states (K+1, 13); arguments are those of `follow`, and pushes (K, 9)."""
        updates, n = len(references), len(craft.rotors)
        states = np.empty((updates + 1, 13))
        state, turning, kept = start.copy(), speeds.copy(), memory.copy()
        before, commands = speeds.copy(), speeds.copy()
        filtered, last, measured = np.zeros(FILTERED), np.zeros(6), np.zeros(13)
        filtered[0:3] = state[10:13]
        whole, still, plain = np.ones(n), np.zeros(3), np.zeros(3)
        room = np.empty((3, n))
        for k in range(updates):
            states[k] = state
            seen(state, errors[k], measured)
            update(
                measured,
                voltages[k : k + 1],
                references[k],
                GO_TO,
                still,
                craft.gains,
                whole,
                craft.known,
                craft.probes,
                estimate,
                plain,
                filtered,
                kept,
                commands,
                count + k,
            )
            fly_period(
                state, last, turning, before, commands, shares, pushes[k], pressure, craft, room
            )
            before[:] = commands
        states[updates] = state
        return states

    return unique(refly, controller.key)
