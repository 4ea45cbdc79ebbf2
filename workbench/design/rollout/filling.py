"""Fill a block with candidates, their crafts and their commands."""

import math

import numpy as np

from workbench.common.jitable import register_jitable
from workbench.design.rollout.rows import (
    AIR_SIZE,
    ALLOCATION,
    BODY,
    BODY_SIZE,
    CHARGE,
    CLEARANCE,
    COMMAND,
    COMMAND_SIZE,
    COMMANDED,
    EFFECTS,
    FILTERED,
    GAINS,
    HALF,
    HELD,
    HOLD,
    IDLE,
    LANES,
    LOST,
    MOST,
    MOTOR,
    OPEN_CIRCUIT,
    PRESSURE,
    RIGID,
    RIGID_SIZE,
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
)
from workbench.dynamics.air.settings import AirSettings
from workbench.dynamics.vehicle_step import ROW, given

_AIR = AirSettings._fields
TURBULENCE, GUST, PUSH = _AIR.index("turbulence"), _AIR.index("gust_x"), _AIR.index("push_x")
AREA, DENSITY = _AIR.index("drag_area"), _AIR.index("air_density")
assert len(_AIR) == AIR_SIZE and _AIR.index("wind_x") == 0


@register_jitable
def fill(block, rotors, candidates, crafts):  # type: ignore[no-untyped-def]
    """Fill a block; where there are fewer than 16, the last one flies in the others' places."""
    many = len(candidates.gains)
    for i in range(LANES):
        c = min(i, many - 1)
        for k in range(STATE_SIZE):
            put(block, STATE + k, i, candidates.starts[c, k])
        for k in range(3):
            put(block, FILTERED + k, i, candidates.starts[c, 10 + k])
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
        # comparisons with NaN are false: a limit that is none would be no limit
        put(block, LOST, i, -1.0 if _is_whole(candidates, c) else 0.0)
        for number in range(len(rotors)):
            _fill_rotor(block, rotors[number], i, c, number, candidates, crafts)


@register_jitable
def _is_whole(candidates, c):  # type: ignore[no-untyped-def]
    """Return whether all that a candidate has is a number."""
    total = candidates.gains[c].sum() + candidates.shares[c].sum() + candidates.air[c].sum()
    total += candidates.commands[c].sum() + candidates.starts[c].sum()
    return not math.isnan(total)


@register_jitable
def _fill_rotor(block, rotor, i, c, number, candidates, crafts):  # type: ignore[no-untyped-def]
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
def give_commands(block, commands):  # type: ignore[no-untyped-def]
    """Let every candidate have its command."""
    for i in range(LANES):
        for k in range(COMMAND_SIZE):
            put(block, COMMAND + k, i, commands[min(i, len(commands) - 1), k])


@register_jitable
def is_lively(air):  # type: ignore[no-untyped-def]
    """Return for whom (m) the air does more than a steady wind."""
    found = np.zeros(len(air), dtype=np.bool_)
    for c in range(len(air)):
        found[c] = air[c, TURBULENCE] != 0.0
        for k in range(3):
            found[c] |= air[c, GUST + k] != 0.0 or air[c, PUSH + k] != 0.0
    return found
