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
from workbench.control.flight_law import SETPOINT
from workbench.control.flight_mode import HOVERING
from workbench.design.rollout.body_loops import (
    blow,
    discharge,
    hold_commands,
    move,
    note_lost,
    weaken,
)
from workbench.design.rollout.estimate_loops import make_knowing
from workbench.design.rollout.gyro_loops import KNOW_TRUTH, Knowing, fill_gyro
from workbench.design.rollout.law_loops import make_update
from workbench.design.rollout.rows import (
    AIR_SIZE,
    ALLOCATION,
    BODY,
    BODY_SIZE,
    CHARGE,
    CLEARANCE,
    COMMAND,
    COMMAND_SIZE,
    COMMAND_STEPS,
    COMMANDED,
    COUNT,
    EFFECTS,
    FILTERED,
    GAINS,
    HALF,
    HELD,
    HOLD,
    HOLDING,
    IDLE,
    KNOWN,
    LANES,
    LOST,
    MODE,
    MOST,
    MOTOR,
    OPEN_CIRCUIT,
    PEAK,
    PRESSURE,
    RIGID,
    RIGID_SIZE,
    ROTOR_ROWS,
    SECTIONS,
    SHARE,
    SPEED,
    STATE,
    STATE_SIZE,
    STOPPED,
    THRUST,
    TURN,
    VOLTAGE,
    WIND,
    put,
    take,
)
from workbench.dynamics.air.settings import AirSettings
from workbench.dynamics.air.update import EDDIES
from workbench.dynamics.vehicle_step import INFLOW, LAG, ROW, given
from workbench.estimation.estimators import Estimator
from workbench.estimation.filters import lowpass

_AIR = AirSettings._fields
TURBULENCE, GUST = _AIR.index("turbulence"), _AIR.index("gust_x")
PUSH, PUSH_TORQUE = _AIR.index("push_x"), _AIR.index("push_torque_x")
AREA, DENSITY = _AIR.index("drag_area"), _AIR.index("air_density")
assert len(_AIR) == AIR_SIZE and _AIR.index("wind_x") == 0
STILL_PERIODS = 8
STILL = 1e-10
"""A hover in which nothing moves faster than this after so many control periods needs not be
flown up to the command [m/s, rad/s]."""
STATES = STATE_SIZE * LANES


@register_jitable
def fill(block, rotors, candidates, crafts, schedule):
    """Fill a block; where there are fewer than 16, the last one flies in the others' places."""
    many = len(candidates.gains)
    for i in range(LANES):
        fill_lane(block, rotors, i, min(i, many - 1), candidates, crafts, schedule)


@register_jitable
def fill_lane(block, rotors, i, c, candidates, crafts, schedule):
    """Let a candidate begin in a lane whose numbers are zeros, but for what its law remembers."""
    for k in range(STATE_SIZE):
        put(block, STATE + k, i, candidates.starts[c, k])
    for k in range(3):
        put(block, FILTERED + k, i, candidates.starts[c, 10 + k])
        put(block, FILTERED + SETPOINT + k, i, candidates.starts[c, 10 + k])
        put(block, HOLD + k, i, candidates.starts[c, 4 + k])
        put(block, WIND + k, i, candidates.air[c, k])
    for k in range(candidates.gains.shape[1]):
        put(block, GAINS + k, i, candidates.gains[c, k])
    for k in range(BODY_SIZE):
        put(block, BODY + k, i, crafts.body[c, k])
    for k in range(RIGID_SIZE):
        put(block, RIGID + k, i, crafts.rigid[c, k])
    put(block, PRESSURE, i, 0.5 * candidates.air[c, DENSITY] * candidates.air[c, AREA])
    put(block, CLEARANCE, i, crafts.clearances[c])
    put(block, CHARGE, i, 1.0)
    put(block, OPEN_CIRCUIT, i, 1.0)
    put(block, VOLTAGE, i, 1.0)
    put(block, MODE, i, HOVERING)
    put(block, HOLDING, i, 1.0)
    setpoint, derivative, steps = candidates.computers[c]
    sections = lowpass(setpoint, 1.0, schedule.period) + lowpass(derivative, 1.0, schedule.period)
    for k in range(len(sections)):
        put(block, SECTIONS + k, i, sections[k])
    put(block, COMMAND_STEPS, i, steps)
    fill_gyro(block, i, candidates.gyros[c], schedule)
    # comparisons with NaN are false: a limit that is NaN would limit nothing
    put(block, LOST, i, -1.0 if _is_whole(candidates, c) else 0.0)
    for number in range(len(rotors)):
        _fill_rotor(block, rotors[number], i, c, number, candidates, crafts)


@register_jitable
def _is_whole(candidates, c):
    """Return whether all that a candidate has is a number."""
    total = candidates.gains[c].sum() + candidates.shares[c].sum() + candidates.air[c].sum()
    total += candidates.commands[c].sum() + candidates.starts[c].sum()
    total += candidates.gyros[c].sum() + candidates.computers[c].sum()
    return not math.isnan(total)


@register_jitable
def _fill_rotor(block, rotor, i, c, number, candidates, crafts):
    """Fill a rotor's rows of a candidate."""
    speed, share = crafts.speeds[c, number], candidates.shares[c, number]
    row = crafts.rotors[c, number]
    put(rotor, SPEED, i, speed)
    put(rotor, COMMANDED, i, speed)
    put(rotor, HELD, i, speed)
    put(rotor, SHARE, i, given(share))
    if share == 0.0:
        put(block, STOPPED, i, 1.0)
    for k in range(4):
        put(rotor, ALLOCATION + k, i, row[k])
        put(rotor, EFFECTS + k, i, row[4 + k])
    put(rotor, THRUST, i, row[10] * speed * (speed + 2.0 * row[11]))
    put(rotor, IDLE, i, row[8])
    put(rotor, MOST, i, row[9])
    put(rotor, MOTOR, i, row[10])
    put(rotor, HALF, i, row[11])
    for k in range(ROW):
        put(rotor, TURN + k, i, crafts.turning[c, number, k])


@register_jitable
def give_commands(block, commands):
    """Let every candidate have its command."""
    for i in range(LANES):
        for k in range(COMMAND_SIZE):
            put(block, COMMAND + k, i, commands[min(i, len(commands) - 1), k])


@register_jitable
def is_lively(air):
    """Return for whom (m) the air does more than a steady wind."""
    found = np.zeros(len(air), dtype=np.bool_)
    for c in range(len(air)):
        found[c] = air[c, TURBULENCE] != 0.0
        for k in range(3):
            found[c] |= air[c, GUST + k] != 0.0 or air[c, PUSH + k] != 0.0
            found[c] |= air[c, PUSH_TORQUE + k] != 0.0
    return found


def make_fly_block(
    controller: Controller, estimator: Estimator | None = None
) -> Callable[..., None]:
    """Return the flight of a block of candidates with a controller's law.

    Args:
        controller: whose law flies.
        estimator: that tells it the motion; the truth is told without one.
    """
    knowing = make_knowing(estimator) if estimator else KNOW_TRUTH
    begin, rests = knowing.begin, knowing.rests
    whose = f"{controller.key}_{estimator.key}" if estimator else controller.key
    fly_period = make_fly_period(make_update(controller), knowing, whose)
    memory = np.repeat(np.array(controller.initial_memory), LANES)

    def fly_block(candidates, crafts, schedule, hearing, kept, samples, use, lost):
        """Fly up to 16 candidates side by side; this is what gets compiled.

        Args:
            candidates: m of them, see `Candidates`.
            crafts: one for each.
            schedule: when things happen, see `Schedule`.
            hearing: sensors of the estimator; None on the truth.
            kept: (k) which of the state's numbers to keep, see `rigid_body.State`.
            samples: (M, k, 16) places for them from the edge on; NaN once a candidate is lost.
            use: (m) places for the largest share of its speed limit at which a rotor ran.
            lost: (m) places for the instant at which a candidate was lost, -1 if it was not.
        """
        many, n = candidates.shares.shape
        fixed = (GAINS + candidates.gains.shape[1]) * LANES
        block, rotors = np.zeros(fixed + len(memory)), np.zeros((n, ROTOR_ROWS * LANES))
        block[fixed:] = memory
        fill(block, rotors, candidates, crafts, schedule)
        hears = begin(block, candidates, hearing, schedule)
        coarse = candidates.computers[:, 2].any()
        give_commands(block, candidates.before)
        effects = find_effects(crafts)
        sags = len(crafts.supply.curve) > 0
        lively = is_lively(candidates.air)
        eddies = np.zeros((many, EDDIES))
        rings = make_rings(block, rotors, crafts, schedule)
        seen, asked = rings[0], rings[1]
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
            count_from(block, instant)
            fly_period(
                block,
                rotors,
                candidates.shares,
                crafts,
                (candidates.air, candidates.seeds, lively, eddies),
                rings,
                hears,
                effects,
                schedule,
                (instant, updates),
                instant >= schedule.edge,
                coarse,
            )
            updates += 1
            instant += 1
            if note_lost(block) == LANES:
                _keep_nothing(samples, instant, schedule)
                break
            if rests and instant == STILL_PERIODS and instant < schedule.edge and not sags:
                calm, hold = block.copy(), rotors.copy()
                if _find_still(block, lively, still):
                    instant = schedule.edge
        for i in range(many):
            lost[i] = int(take(block, LOST, i))
            use[i] = _use(rotors, i, lost[i] < 0)

    return unique(fly_block, whose)


def make_fly_period(update: Callable[..., None], knowing: Knowing, key: str) -> Callable[..., None]:
    """Return a control period of a block.

    Args:
        update: what commands the rotors, see `law_loops.make_update`.
        knowing: how it knows the motion.
        key: see `jitable.unique`.
    """
    _, sample, know, sense, is_due, measure, _ = knowing

    @register_jitable(forceinline=True)
    def fly_period(
        block,
        rotors,
        shares,
        crafts,
        around,
        rings,
        hears,
        effects,
        schedule,
        numbers,
        noted,
        coarse,
    ):
        """Fly on for a control period.

        Args:
            block: of m candidates.
            rotors: blocks of the rotors.
            shares: of their thrust that they give (m, n).
            crafts: of the candidates.
            around: settings of the air and what its noise starts from, for whom it is not steady,
                and what the turbulence remembers.
            rings: see `make_rings`.
            hears: see `Knowing.begin`.
            effects: see `find_effects`.
            schedule: see `Schedule`.
            numbers: of the period, as sensors count it, and of updates before it.
            noted: whether peaks of the rotors' speeds are.
            coarse: whether anybody's commands come in steps.
        """
        air, seeds, lively, eddies = around
        seen, asked, looks, acts = rings
        samples_imus, imus, sensors, every, told = hears
        blades, changes = effects
        instant, updates = numbers
        supply, pushed = crafts.supply, lively.any()
        sags = len(supply.curve) > 0
        if samples_imus:
            sample(block, imus, instant * schedule.steps, 0)
        know(sensors, instant, schedule.period)
        _look(block, seen, crafts.seen, updates, 0, sense, told)
        _see(block, seen, crafts.seen, updates, sense, told)
        if sags:
            weaken(block, rotors, supply)
        update(block, rotors, shares, crafts.rotors, schedule, crafts.estimate, noted, coarse)
        _ask(rotors, asked[updates % len(asked)])
        for step in range(schedule.steps):
            number = instant * schedule.steps + step
            if samples_imus and step > 0:
                sample(block, imus, number, step)
            if step > 0 and looks[step]:
                _look(block, seen, crafts.seen, updates, step, sense, told)
            if is_due(every, number):
                measure(block, sensors, number, schedule.step)
            if acts[step]:
                hold_commands(rotors, asked, crafts.acting, updates, step)
            if pushed:
                blow(block, lively, air, seeds, schedule.steps, step, schedule.step, eddies)
            if sags:
                weaken(block, rotors, supply)
                discharge(block, supply, schedule.steps, step)
            move(block, rotors, blades, changes, sags, supply.compensation, pushed, schedule.step)
        for i in range(LANES):
            put(block, COUNT, i, take(block, COUNT, i) + 1.0)

    return unique(fly_period, key)


@register_jitable
def find_effects(crafts):
    """Return whether blades have drag, and whether inflow or ground change any thrust."""
    return crafts.turning[:, :, 6:8].any(), crafts.turning[:, :, INFLOW:LAG].any()


@register_jitable
def make_rings(block, rotors, crafts, schedule):
    """Return what is on its way where sensing or commands come late, as at the start of a flight.

    Returns:
        States of the last updates, and commands of these, each a ring; and at which steps of a
        period there is something to do for anybody's delay of either.
    """
    seen = np.empty((crafts.seen[:, 0].max() + 1, STATES))
    seen[:] = block[:STATES]
    asked = np.empty((crafts.acting[:, 0].max() + 1, len(rotors), LANES))
    for age in range(len(asked)):
        _ask(rotors, asked[age])
    looks = steps_of(crafts.seen, schedule.steps)
    return seen, asked, looks, steps_of(crafts.acting, schedule.steps)


@register_jitable
def count_from(block, instant):
    """Let it be a number of control periods since all of them began."""
    for i in range(LANES):
        put(block, COUNT, i, 1.0 * instant)


@register_jitable
def _use(rotors, i, flies):
    """Return the largest share of its speed limit at which a rotor of a candidate ran."""
    use = 0.0
    for number in range(len(rotors)):
        rotor = rotors[number]
        peak = take(rotor, PEAK, i)
        if flies:  # the last speed came after the last update
            peak = max(peak, take(rotor, SPEED, i))
        use = max(use, peak / take(rotor, TURN + LAG, i))
    return use


@register_jitable
def steps_of(delays, steps):
    """Return at which steps of a period there is something to do for anybody's delay."""
    found = np.zeros(steps, dtype=np.bool_)
    for i in range(len(delays)):
        found[delays[i, 1]] = True
    return found


@register_jitable
def _ask(rotors, places):
    """Write what is commanded."""
    for number in range(len(rotors)):
        for i in range(LANES):
            places[number, i] = take(rotors[number], COMMANDED, i)


@register_jitable
def _look(block, seen, delays, updates, step, sense, told):
    """Remember the states of those whose law is to see what they are before this step."""
    if len(seen) == 1:
        return
    places = seen[updates % len(seen)]
    for i in range(LANES):
        if delays[min(i, len(delays) - 1), 1] == step:
            for k in range(STATE_SIZE):
                put(places, k, i, take(block, STATE + k, i))
            sense(block, i, places, 0, told)


@register_jitable
def _see(block, seen, delays, updates, sense, told):
    """Let the law see the state, or an older one where its craft is late."""
    ring = len(seen)
    if ring == 1:
        block[KNOWN * LANES : KNOWN * LANES + STATES] = block[:STATES]
        for i in range(LANES):
            sense(block, i, block, KNOWN, told)
        return
    for i in range(LANES):
        late = delays[min(i, len(delays) - 1), 0]
        for k in range(STATE_SIZE):
            put(block, KNOWN + k, i, take(seen[(updates - late) % ring], k, i))


@register_jitable
def _keep(block, kept, places):
    """Write what is asked for of the state."""
    for k in range(len(kept)):
        row = kept[k] * LANES
        for i in range(LANES):
            places[k, i] = block[row + i] if take(block, LOST, i) < 0.0 else math.nan


@register_jitable
def _keep_nothing(samples, instant, schedule):
    """Write that there is nothing from an instant on."""
    since = max(0, instant - schedule.edge)
    samples[-(-since // schedule.stride) :] = math.nan


@register_jitable
def _find_still(block, lively, still):
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
def _restore(block, rotors, seen, asked, still, calm, hold):
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
