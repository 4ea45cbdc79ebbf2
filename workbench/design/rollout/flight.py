"""The flight of a block of candidates, as a function that compiles.

The order of things is that of the workbench's diagram, where all that is due at one time reads the
state before it: the law sees the state at a control instant, while the physics step that begins
there still has the commands of the period before.

No candidate knows who flies beside it: all of them give the same numbers in any company.
"""

import math
from collections.abc import Callable

import numpy as np

from workbench.common.jitable import register_jitable, unique
from workbench.control.controller import Controller
from workbench.design.rollout.body_loops import (
    blow,
    discharge,
    hold_commands,
    move,
    note_lost,
    weaken,
)
from workbench.design.rollout.filling import fill, give_commands, is_lively
from workbench.design.rollout.law_loops import command, make_want, mix_hard, mix_plainly
from workbench.design.rollout.rows import (
    COMMANDED,
    GAINS,
    KNOWN,
    LANES,
    LOST,
    PEAK,
    ROTOR_ROWS,
    SPEED,
    STATE,
    STATE_SIZE,
    TURN,
    put,
    take,
)
from workbench.dynamics.air.update import EDDIES
from workbench.dynamics.vehicle_step import ANSWER, INFLOW

STILL_PERIODS = 8
STILL = 1e-10
"""A hover in which nothing moves faster than this after so many control periods needs not be
flown up to the command [m/s, rad/s]."""
STATES = STATE_SIZE * LANES


def make_fly_block(controller: Controller) -> Callable[..., None]:
    """Return the flight of a block of candidates with a controller's law."""
    want = make_want(controller)
    memory = np.repeat(np.array(controller.initial_memory), LANES)

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
        fixed = (GAINS + candidates.gains.shape[1]) * LANES
        block, rotors = np.zeros(fixed + len(memory)), np.zeros((n, ROTOR_ROWS * LANES))
        block[fixed:] = memory
        fill(block, rotors, candidates, crafts)
        give_commands(block, candidates.before)
        blades = crafts.turning[:, :, 6:8].any()
        changes = crafts.turning[:, :, INFLOW:ANSWER].any()
        sags = len(crafts.supply.curve) > 0
        lively = is_lively(candidates.air)
        pushed = lively.any()
        eddies = np.zeros((many, EDDIES))
        seen = np.empty((crafts.seen[:, 0].max() + 1, STATES))
        seen[:] = block[:STATES]
        asked = np.empty((crafts.acting[:, 0].max() + 1, n, LANES))
        for age in range(len(asked)):
            _ask(rotors, asked[age])
        looks, acts = (
            _steps_of(crafts.seen, schedule.steps),
            _steps_of(crafts.acting, schedule.steps),
        )
        calm, hold = block, rotors  # as they were when some hovered without moving
        still = np.zeros(LANES, dtype=np.bool_)
        updates = 0
        instant = 0
        while True:
            if instant == schedule.edge:
                _restore(block, rotors, seen, asked, still, calm, hold)
                give_commands(block, candidates.commands)
            if instant >= schedule.edge:
                since = instant - schedule.edge
                if since % schedule.stride == 0:
                    _keep(block, kept, samples[since // schedule.stride])
            if instant == schedule.end:
                break
            _look(block, seen, crafts.seen, updates, 0)
            _see(block, seen, crafts.seen, updates)
            if sags:
                weaken(block, rotors, crafts.supply)
            want(block, rotors, crafts.estimate)
            mix_plainly(block, rotors)
            mix_hard(block, rotors, candidates.shares, crafts.rotors)
            command(block, rotors, instant >= schedule.edge)
            _ask(rotors, asked[updates % len(asked)])
            for step in range(schedule.steps):
                number = instant * schedule.steps + step
                if step > 0 and looks[step]:
                    _look(block, seen, crafts.seen, updates, step)
                if acts[step]:
                    hold_commands(rotors, asked, crafts.acting, updates, step)
                if pushed:
                    blow(
                        block,
                        lively,
                        candidates.air,
                        candidates.seeds,
                        number,
                        schedule.step,
                        eddies,
                    )
                if sags:
                    weaken(block, rotors, crafts.supply)
                    if number % crafts.supply.every == 0:
                        discharge(block, crafts.supply)
                move(block, rotors, blades, changes, sags, pushed, schedule.step)
            updates += 1
            instant += 1
            if note_lost(block, instant) == LANES:
                _keep_nothing(samples, instant, schedule)
                break
            if instant == STILL_PERIODS and instant < schedule.edge and not sags:
                calm, hold = block.copy(), rotors.copy()
                if _find_still(block, lively, still):
                    instant = schedule.edge
        for i in range(many):
            lost[i] = int(take(block, LOST, i))
            use[i] = _use(rotors, i, lost[i] < 0)

    return unique(fly_block, controller.key)


@register_jitable
def _use(rotors, i, flies):  # type: ignore[no-untyped-def]
    """Return the largest share of its speed limit at which a rotor of a candidate ran."""
    use = 0.0
    for number in range(len(rotors)):
        rotor = rotors[number]
        peak = take(rotor, PEAK, i)
        if flies:  # the last speed came after the last update
            peak = max(peak, take(rotor, SPEED, i))
        use = max(use, peak / take(rotor, TURN + ANSWER, i))
    return use


@register_jitable
def _steps_of(delays, steps):  # type: ignore[no-untyped-def]
    """Return at which steps of a period there is something to do for anybody's delay."""
    found = np.zeros(steps, dtype=np.bool_)
    for i in range(len(delays)):
        found[delays[i, 1]] = True
    return found


@register_jitable
def _ask(rotors, places):  # type: ignore[no-untyped-def]
    """Write what is commanded."""
    for number in range(len(rotors)):
        for i in range(LANES):
            places[number, i] = take(rotors[number], COMMANDED, i)


@register_jitable
def _look(block, seen, delays, updates, step):  # type: ignore[no-untyped-def]
    """Remember the states of those whose law is to see what they are before this step."""
    if len(seen) == 1:
        return
    places = seen[updates % len(seen)]
    for i in range(LANES):
        if delays[min(i, len(delays) - 1), 1] == step:
            for k in range(STATE_SIZE):
                put(places, k, i, take(block, STATE + k, i))


@register_jitable
def _see(block, seen, delays, updates):  # type: ignore[no-untyped-def]
    """Let the law see the state, or an older one where its craft is late."""
    ring = len(seen)
    if ring == 1:
        block[KNOWN * LANES : KNOWN * LANES + STATES] = block[:STATES]
        return
    for i in range(LANES):
        late = delays[min(i, len(delays) - 1), 0]
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
def _restore(block, rotors, seen, asked, still, calm, hold):  # type: ignore[no-untyped-def]
    """Put back those that hovered without moving, whether or not others had to fly on."""
    for i in range(LANES):
        if still[i]:
            for row in range(len(block) // LANES):
                put(block, row, i, take(calm, row, i))
            for number in range(len(rotors)):
                for row in range(ROTOR_ROWS):
                    put(rotors[number], row, i, take(hold[number], row, i))
                for age in range(len(asked)):
                    asked[age, number, i] = take(hold[number], COMMANDED, i)
            for k in range(STATE_SIZE):
                for old in range(len(seen)):
                    put(seen[old], k, i, take(calm, STATE + k, i))
