"""Flights that go on from call to call, in blocks: what `Batch` has compiled.

Between calls the tables have what their user reads and writes; all else stays in the blocks.
"""

import math
from collections.abc import Callable
from functools import lru_cache
from typing import NamedTuple

import numpy as np

from workbench.common.compiled import Compiled, compile_cached
from workbench.common.jitable import register_jitable, unique
from workbench.control.controller import Controller
from workbench.control.flight_mode import flying
from workbench.design.rollout.body_loops import note_lost
from workbench.design.rollout.engine import SOURCES, Crafts
from workbench.design.rollout.flight import (
    AREA,
    DENSITY,
    fill_lane,
    find_effects,
    is_lively,
    make_fly_period,
    steps_of,
)
from workbench.design.rollout.gyro_loops import KNOW_TRUTH
from workbench.design.rollout.law_loops import allocate, make_update
from workbench.design.rollout.rows import (
    COMMAND,
    COMMANDED,
    COUNT,
    EFFORT,
    GAINS,
    HOLD,
    HOLDING,
    LANES,
    LOST,
    MODE,
    PRESSURE,
    PUSH,
    ROTOR_ROWS,
    SHARE,
    SPEED,
    STATE,
    STATE_SIZE,
    STOPPED,
    WIND,
    put,
    put3,
    put6,
    take,
    take3,
    take8,
)
from workbench.dynamics.vehicle_step import given


class Tables(NamedTuple):
    """What the user of a batch reads and writes: N flights with n rotors.

    Attributes:
        states: (N, 13) of the plant, see `rigid_body.State`.
        speeds: (N, n) of the rotors [rad/s].
        setpoints: (N, 8) see `guidance.Reference`; none where no law flies.
        efforts: (N, 4) force [N] and moment [N·m] in T; none but where these are asked for.
        commands: (N, n) speeds that the rotors are to reach [rad/s]; likewise.
        gains: (N, g) of the controller, and what it designs of them; none where no law flies.
        air: (N, 22) see `AirSettings`.
        shares: (N, n) of their thrust that rotors give.
        seeds: (N) what the turbulence starts from.
        lost: (N) whether a flight is lost; it stands still then.
    """

    states: np.ndarray
    speeds: np.ndarray
    setpoints: np.ndarray
    efforts: np.ndarray
    commands: np.ndarray
    gains: np.ndarray
    air: np.ndarray
    shares: np.ndarray
    seeds: np.ndarray
    lost: np.ndarray


class Kept(NamedTuple):
    """What flights remember between calls, in K blocks; m is for the law.

    Attributes:
        blocks: (K, (rows + m) 16) see `rows`.
        wheels: (K, n, rows 16) of the rotors.
        seen: (K, age, 13 16) states on their way to the law.
        asked: (K, age, n, 16) commands on their way to the rotors.
        eddies: (N, 6) what the turbulence remembers.
    """

    blocks: np.ndarray
    wheels: np.ndarray
    seen: np.ndarray
    asked: np.ndarray
    eddies: np.ndarray


@lru_cache(maxsize=64)
def compiled_steps(controller: Controller | None, actions: str) -> Compiled:
    """Return the steps of a batch, compiled at their first call.

    Args:
        controller: whose law flies; None where none does.
        actions: that are asked for, see `batch.ACTIONS`.
    """
    whose = f" with {controller.name}" if controller and not controller.shipped else ""
    key = controller.key if controller else actions
    return compile_cached(
        make_step_blocks(_make_act(controller, actions), key),
        SOURCES,
        f"batches of flights{whose}",
        parts=170,
        text=f"{actions} {controller.digest if controller else ''}",
        file=str(controller.file) if controller else "",
        nogil=True,
        error_model="numpy",  # divisions that might raise make no vector instructions
        fastmath={"contract"},  # as flights by the thousand have it
    )


def _make_act(controller: Controller | None, actions: str) -> Callable[..., None]:
    """Return what commands the rotors in each control period, see `law_loops.make_update`."""
    if controller:
        return _make_steered(controller)
    return allocate_efforts if actions == "wrench" else hand_over


def _make_steered(controller: Controller) -> Callable[..., None]:
    """Return a control update behind which the flight mode has its own, as in the diagram."""
    fly = make_update(controller)

    @register_jitable
    def steered(block, rotors, shares, law_rotors, schedule, estimate, noted, coarse):  # type: ignore[no-untyped-def]
        fly(block, rotors, shares, law_rotors, schedule, estimate, noted, coarse)
        for i in range(LANES):
            if int(take(block, COUNT, i)) % schedule.modes == 0:
                mode, holding, x, y, z = flying(
                    take(block, HOLDING, i),
                    take3(block, HOLD, i),
                    take3(block, STATE + 4, i),
                    take3(block, STATE + 10, i),
                    take8(block, COMMAND, i),
                )
                put(block, MODE, i, mode)
                put(block, HOLDING, i, holding)
                put3(block, HOLD, i, (x, y, z))

    return unique(steered, controller.key)


@register_jitable
def allocate_efforts(block, rotors, shares, law_rotors, schedule, estimate, noted, coarse):  # type: ignore[no-untyped-def]
    """Let the rotors make the efforts that are asked for."""
    allocate(block, rotors, shares, law_rotors, noted, coarse)


@register_jitable
def hand_over(block, rotors, shares, law_rotors, schedule, estimate, noted, coarse):  # type: ignore[no-untyped-def]
    """Do nothing: the rotors' speeds are what is asked for."""


def make_step_blocks(act: Callable[..., None], key: str) -> Callable[..., None]:
    """Return the steps of some blocks.

    Args:
        act: what commands the rotors in each control period.
        key: see `jitable.unique`.
    """
    fly_period = make_fly_period(act, KNOW_TRUTH, f"batch_{key}")
    begin = KNOW_TRUTH.begin

    def step_blocks(first, last, periods, updates, schedule, tables, crafts, kept, coarse):  # type: ignore[no-untyped-def]
        """Fly blocks on; this is what gets compiled.

        Args:
            first: of the blocks.
            last: the one before which it ends.
            periods: of control to fly.
            updates: how many of them there were before, in all.
            schedule: see `Schedule`.
            tables: see `Tables`.
            crafts: one for each flight, see `Crafts`.
            kept: see `Kept`.
            coarse: whether anybody's commands come in steps.
        """
        effects = find_effects(crafts)
        looks = steps_of(crafts.seen, schedule.steps)
        acts = steps_of(crafts.acting, schedule.steps)
        for number in range(first, last):
            since = number * LANES
            to = min(since + LANES, len(tables.states))
            block, rotors = kept.blocks[number], kept.wheels[number]
            _load(block, rotors, since, to, tables)
            some = Crafts(
                crafts.body[since:to],
                crafts.rotors[since:to],
                crafts.rigid[since:to],
                crafts.turning[since:to],
                crafts.speeds[since:to],
                crafts.seen[since:to],
                crafts.acting[since:to],
                crafts.clearances[since:to],
                crafts.estimate,
                crafts.supply,
            )
            air = tables.air[since:to]
            around = (air, tables.seeds[since:to], is_lively(air), kept.eddies[since:to])
            rings = (kept.seen[number], kept.asked[number], looks, acts)
            hears = begin(block, None, None, schedule)
            before = 0
            for i in range(LANES):
                before += take(block, LOST, i) >= 0.0
            for period in range(periods):
                fly_period(
                    block,
                    rotors,
                    tables.shares[since:to],
                    some,
                    around,
                    rings,
                    hears,
                    effects,
                    schedule,
                    (0, updates + period),
                    False,
                    coarse,
                )
                lost = note_lost(block)
                if lost > before:
                    _store(block, rotors, since, to, tables, True)
                    before = lost
            _store(block, rotors, since, to, tables, False)

    return unique(step_blocks, key)


@register_jitable
def _load(block, rotors, since, to, tables):  # type: ignore[no-untyped-def]
    """Let flights have what their tables say, but those that are lost; the last fills the block.

    One that has a number that is none is lost: a limit that is none would be no limit.
    """
    for i in range(LANES):
        c = min(since + i, to - 1)
        if tables.lost[c]:
            continue
        total = 0.0
        for k in range(tables.setpoints.shape[1]):
            total += tables.setpoints[c, k]
            put(block, COMMAND + k, i, tables.setpoints[c, k])
        for k in range(tables.efforts.shape[1]):
            total += tables.efforts[c, k]
            put(block, EFFORT + k, i, tables.efforts[c, k])
        for k in range(tables.gains.shape[1]):
            total += tables.gains[c, k]
            put(block, GAINS + k, i, tables.gains[c, k])
        for k in range(tables.air.shape[1]):
            total += tables.air[c, k]
        for number in range(tables.commands.shape[1]):
            total += tables.commands[c, number]
            put(rotors[number], COMMANDED, i, tables.commands[c, number])
        stopped = 0.0
        for number in range(len(rotors)):
            rotor, share = rotors[number], tables.shares[c, number]
            total += share
            put(rotor, SPEED, i, tables.speeds[c, number])
            put(rotor, SHARE, i, given(share))
            if share == 0.0:
                stopped = 1.0
        put(block, STOPPED, i, stopped)
        if math.isnan(total):
            tables.lost[c] = True
            put(block, LOST, i, take(block, COUNT, i))
            continue
        for k in range(STATE_SIZE):
            put(block, STATE + k, i, tables.states[c, k])
        put3(block, WIND, i, (tables.air[c, 0], tables.air[c, 1], tables.air[c, 2]))
        put6(block, PUSH, i, (0.0, 0.0, 0.0, 0.0, 0.0, 0.0))
        put(block, PRESSURE, i, 0.5 * tables.air[c, DENSITY] * tables.air[c, AREA])


@register_jitable
def _store(block, rotors, since, to, tables, lost):  # type: ignore[no-untyped-def]
    """Write the flights into their tables that were lost just now, or those that were not."""
    for i in range(to - since):
        c = since + i
        if tables.lost[c] or lost != (take(block, LOST, i) >= 0.0):
            continue
        tables.lost[c] = lost
        for k in range(STATE_SIZE):
            tables.states[c, k] = take(block, STATE + k, i)
        for number in range(len(rotors)):
            tables.speeds[c, number] = take(rotors[number], SPEED, i)


def reset_lanes(which, candidates, crafts, schedule, memory, tables, kept):  # type: ignore[no-untyped-def]
    """Let flights begin anew; this is compiled, too.

    Args:
        which: numbers of them.
        candidates: what they begin with, one for each flight; its gains, air and shares are those
            of the tables.
        crafts: one for each flight.
        schedule: see `Schedule`.
        memory: of the law at the start (m).
        tables: see `Tables`.
        kept: see `Kept`.
    """
    many = len(tables.states)
    for c in which:
        block, rotors = kept.blocks[c // LANES], kept.wheels[c // LANES]
        seen, asked = kept.seen[c // LANES], kept.asked[c // LANES]
        # the last flight stands in for those that its block has no flights for
        for i in range(c % LANES, LANES if c == many - 1 else c % LANES + 1):
            rows = len(block) // LANES - len(memory)
            for row in range(rows):
                put(block, row, i, 0.0)
            for k in range(len(memory)):
                put(block, rows + k, i, memory[k])
            for number in range(len(rotors)):
                for row in range(ROTOR_ROWS):
                    put(rotors[number], row, i, 0.0)
            fill_lane(block, rotors, i, c, candidates, crafts, schedule)
            for age in range(len(seen)):
                for k in range(STATE_SIZE):
                    put(seen[age], k, i, take(block, STATE + k, i))
            for age in range(len(asked)):
                for number in range(len(rotors)):
                    asked[age, number, i] = take(rotors[number], COMMANDED, i)
        kept.eddies[c] = 0.0
        tables.lost[c] = take(block, LOST, c % LANES) >= 0.0
        tables.states[c] = candidates.starts[c]
        tables.speeds[c] = crafts.speeds[c]


compiled_reset = compile_cached(
    reset_lanes,
    SOURCES,
    "how batches of flights begin",
    nogil=True,
    error_model="numpy",
    fastmath={"contract"},
)
