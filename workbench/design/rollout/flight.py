"""The flight of a block of candidates, as a function that compiles.

The order of things is that of the workbench's diagram, where all that is due at one time reads the
state before it: law and air see the state at a control instant, while the physics step that begins
there still has the thrusts and the air's wrench of the period before. The new ones act from the
next physics step on, until one step after the next control instant.

No candidate knows who flies beside it: all of them give the same numbers in any company.
"""

import math

import numpy as np
from numba.extending import register_jitable

from workbench.design.rollout.body_loops import (
    blow,
    hold_load,
    move,
    note_lost,
    pull,
)
from workbench.design.rollout.filling import fill, give_commands, is_lively
from workbench.design.rollout.law_loops import drive, mix_hard, mix_plainly, want
from workbench.design.rollout.rows import (
    ANSWER,
    KNOWN,
    LANES,
    LOST,
    PEAK,
    ROTOR_ROWS,
    ROWS,
    SPEED,
    STATE,
    STATE_SIZE,
    put,
    take,
)
from workbench.systems.air.update import EDDIES

STILL_PERIODS = 8
STILL = 1e-10
"""A hover in which nothing moves faster than this after so many control periods needs not be
flown up to the command [m/s, rad/s]."""
STATES = STATE_SIZE * LANES


def fly_block(candidates, crafts, schedule, kept, samples, use, lost):  # type: ignore[no-untyped-def]
    """Fly up to 16 candidates side by side; this is what gets compiled.

    Args:
        candidates: m of them, see `Candidates`.
        crafts: one for each.
        schedule: when things happen, see `Schedule`.
        kept: (k) which of the state's numbers to keep, see `rigid_body.State`.
        samples: (M, k, 16) places for them from the edge on; NaN once a candidate is lost.
        use: (m) places for the largest share of its speed limit at which a rotor ran.
        lost: (m) places for the instant at which a candidate was lost, -1 if it was not.
    """
    many, n = candidates.shares.shape
    block, rotors = np.zeros(ROWS * LANES), np.zeros((n, ROTOR_ROWS * LANES))
    fill(block, rotors, candidates, crafts, schedule.step)
    blades = crafts.blades[:, :, 6:].any()
    lively = is_lively(candidates.air)
    eddies, next_eddies = np.zeros((many, EDDIES)), np.zeros((many, EDDIES))
    seen = np.empty((crafts.delays.max() + 1, STATES))
    seen[:] = block[:STATES]
    calm, hold = block, rotors  # as they were when some hovered without moving
    still = np.zeros(LANES, dtype=np.bool_)
    updates = 0
    instant = 0
    while True:
        if instant == schedule.edge:
            _restore(block, rotors, seen, still, calm, hold)
            give_commands(block, candidates.commands)
        if instant >= schedule.edge:
            since = instant - schedule.edge
            if since % schedule.stride == 0:
                _keep(block, kept, samples[since // schedule.stride])
        if instant == schedule.end:
            break
        _see(block, seen, crafts.delays, updates)
        want(block, crafts.estimate)
        mix_plainly(block, rotors)
        mix_hard(block, rotors, candidates.shares, crafts.rotors)
        pull(block, rotors, blades)
        if lively.any():
            blow(
                block,
                rotors,
                lively,
                candidates.air,
                candidates.seeds,
                crafts,
                instant,
                schedule.period,
                eddies,
                next_eddies,
            )
        drive(block, rotors, instant >= schedule.edge)
        move(block, schedule.step, 1)
        hold_load(block, schedule.step)
        move(block, schedule.step, schedule.steps - 1)
        updates += 1
        instant += 1
        if note_lost(block, instant) == LANES:
            _keep_nothing(samples, instant, schedule)
            break
        if instant == STILL_PERIODS and instant < schedule.edge:
            calm, hold = block.copy(), rotors.copy()
            if _find_still(block, lively, still):
                instant = schedule.edge
    for i in range(many):
        lost[i] = int(take(block, LOST, i))
        use[i] = _use(rotors, i, lost[i] < 0)


@register_jitable
def _use(rotors, i, flies):  # type: ignore[no-untyped-def]
    """Return the largest share of its speed limit at which a rotor of a candidate ran."""
    use = 0.0
    for number in range(len(rotors)):
        rotor = rotors[number]
        peak = take(rotor, PEAK, i)
        if flies:  # the last speed came after the last update
            peak = max(peak, take(rotor, SPEED, i))
        use = max(use, peak / take(rotor, ANSWER + 1, i))
    return use


@register_jitable
def _see(block, seen, delays, updates):  # type: ignore[no-untyped-def]
    """Let the law see the state, or an older one where its craft is late."""
    ring = len(seen)
    if ring == 1:
        block[KNOWN * LANES : KNOWN * LANES + STATES] = block[:STATES]
        return
    seen[updates % ring] = block[:STATES]
    for i in range(LANES):
        late = delays[min(i, len(delays) - 1)]
        for k in range(STATE_SIZE):
            put(block, KNOWN + k, i, take(seen[(updates - late) % ring], k, i))


@register_jitable
def _keep(block, kept, places):  # type: ignore[no-untyped-def]
    """Write what is asked for of the state."""
    for k in range(len(kept)):
        row = kept[k] * LANES
        for i in range(LANES):
            places[k, i] = block[row + i] if take(block, LOST, i) < 0.0 else math.nan


@register_jitable
def _keep_nothing(samples, instant, schedule):  # type: ignore[no-untyped-def]
    """Write that there is nothing from an instant on."""
    since = max(0, instant - schedule.edge)
    samples[-(-since // schedule.stride) :] = math.nan


@register_jitable
def _find_still(block, lively, still):  # type: ignore[no-untyped-def]
    """Write who hovers without moving; return whether all do who are not lost."""
    waiting = True
    for i in range(LANES):
        most = 0.0
        for k in range(7, STATE_SIZE):
            most = max(most, abs(take(block, STATE + k, i)))
        flies = take(block, LOST, i) < 0.0
        still[i] = flies and most < STILL and not lively[min(i, len(lively) - 1)]
        waiting = waiting and (still[i] or not flies)
    return waiting


@register_jitable
def _restore(block, rotors, seen, still, calm, hold):  # type: ignore[no-untyped-def]
    """Put back those that hovered without moving, whether or not others had to fly on."""
    for i in range(LANES):
        if still[i]:
            for row in range(ROWS):
                put(block, row, i, take(calm, row, i))
            for number in range(len(rotors)):
                for row in range(ROTOR_ROWS):
                    put(rotors[number], row, i, take(hold[number], row, i))
            for k in range(STATE_SIZE):
                for old in range(len(seen)):
                    put(seen[old], k, i, take(calm, STATE + k, i))
