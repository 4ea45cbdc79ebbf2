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
from workbench.design.predict.flown import SOURCES, begun, fly_period, make_update, seen, times
from workbench.dynamics.rigid_body import into_body, rotation

CLOSES = 0.05
"""Time in which a difference of position or attitude is closed [s]."""
TRIALS = 3
"""Of a control period, to find its push."""


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
def compiled_refly(controller: Controller) -> Callable[..., Any]:
    """Return `refly` of a controller, see `make_refly`, compiled at its first call."""
    whose = "" if controller.shipped else f" with {controller.name}"
    return compile_cached(
        make_refly(controller),
        (*SOURCES, "design/predict/disturbed.py"),
        f"flights along a log{whose}",
        parts=80,
        text=controller.digest,
        file=str(controller.file),
        error_model="numpy",
    )


def make_refly(controller: Controller) -> Callable[..., Any]:
    """Return a function that flies along a log with pushes, or finds them."""
    update = make_update(controller)

    def refly(  # type: ignore[no-untyped-def]
        targets,
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
        share,
        craft,
        trials,
    ):
        """Return states (K+1, 13) of a flight with pushes, which trials correct in place.

        Args:
            targets: states of the log at each update and at the end (K+1, 13); the first one is
                where the flight begins.
            speeds: of the rotors at the start (n) [rad/s].
            memory: of the law at the start (k).
            count: of its updates before.
            errors: of the estimate, see `flown.ERROR` (K, 11).
            references: (K, 8).
            voltages: see `guidance.Measured` (K).
            shares: of their thrust that rotors give (n).
            pushes: of each control period, see `flown.PUSH` (K, 9).
            pressure: see `flown.fly_period`.
            estimate: see `acceleration_estimate.sampled_estimate`.
            share: 1 / `CLOSES` [1/s].
            craft: see `flown.Craft`.
            trials: of each control period. The last one counts; after each one before, the push is
                corrected for what its end lacked. With 1 the pushes stay.
        """
        updates, n = len(references), len(craft.rotors)
        states, asked, room = np.empty((updates + 1, 13)), np.empty(6), np.empty((3, n))
        state, last = targets[0].copy(), np.zeros(6)
        turning, before = speeds.copy(), speeds.copy()
        computer = begun(memory, speeds, state[10:13])
        commands = computer.commands
        for k in range(updates):
            states[k] = state
            seen(state, errors[k], computer.measured)
            update(computer, voltages[k : k + 1], references[k], estimate, craft, count + k)
            wanted(state, targets[k + 1], share, craft.steps[0] * craft.steps[1], asked)
            for trial in range(trials):
                tried, end, spun = state.copy(), last.copy(), turning.copy()
                fly_period(
                    tried, end, spun, before, commands, shares, pushes[k], pressure, craft, room
                )
                if trial + 1 < trials:
                    correct(pushes[k], tried, asked, craft)
            state[:], last[:], turning[:], before[:] = tried, end, spun, commands
        states[updates] = state
        return states

    return unique(refly, controller.key)
