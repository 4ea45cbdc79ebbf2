"""The flight of one candidate, as functions that compile.

The order of things is that of the workbench's diagram, where all that is due at one time reads the
state before it: law and air see the state at a control instant, while the physics step that begins
there still has the thrusts and the air's wrench of the period before. The new ones act from the
next physics step on, until one step after the next control instant.
"""

import math
from typing import Any

import numpy as np
from numba.extending import register_jitable
from numba.np.unsafe.ndarray import to_fixed_tuple

from workbench.design.rollout.rigid_body import fly_on
from workbench.systems.air.drag import drag_wrench
from workbench.systems.air.normals import COUNT, draw_normals
from workbench.systems.air.settings import AirSettings
from workbench.systems.air.update import EDDIES, air_update
from workbench.systems.cascade import Gains, Reference
from workbench.systems.flight_law import LawConstants, control_update, unpacked
from workbench.systems.loop_points import CLOSED, SIGNALS
from workbench.systems.loop_points import COUNT as LOOP_POINTS

as_tuple: Any = to_fixed_tuple
"""From an array; tuples are values, of which compiled code need not count the holders."""

TUMBLING_RATE = 10.0
TUMBLING_SPEED = 20.0
"""A drone on its back that turns or moves faster than this is lost [rad/s, m/s]."""
STILL_PERIODS = 8
STILL = 1e-10
"""A hover in which nothing moves faster than this after so many control periods needs not be
flown up to the command [m/s, rad/s]."""

STATE, REFERENCE, GAINS = 13, len(Reference._fields), len(Gains._fields)
"""Sizes."""
_AIR = AirSettings._fields
WIND, TURBULENCE, GUST = _AIR.index("wind_x"), _AIR.index("turbulence"), _AIR.index("gust_x")
PUSH, AREA, DENSITY = _AIR.index("push_x"), _AIR.index("drag_area"), _AIR.index("air_density")


@register_jitable
def fly_candidate(  # type: ignore[no-untyped-def]
    gains, shares, air, asked, guidance, start, craft, schedule, velocity, spin
):
    """Fly one candidate; return its largest use of a rotor, and when it was lost, or -1."""
    n = len(shares)
    values = as_tuple(gains, GAINS)
    state = as_tuple(start, STATE)
    command = as_tuple(np.zeros(len(asked)), REFERENCE)
    constants = _constants(craft)
    loops = np.zeros(SIGNALS + LOOP_POINTS)
    for point in range(SIGNALS):
        loops[point] = CLOSED[point]
    memory = np.concatenate((craft.speeds, craft.speeds, start[10:13]))
    next_memory = np.empty(2 * n + 3)
    thrusts = constants.motor_constants * craft.speeds**2
    eddies, next_eddies = np.zeros(EDDIES), np.zeros(EDDIES)
    drag, wind, noise = np.zeros(6), np.zeros(3), np.empty(COUNT)
    wrench = _wrench(thrusts, (0.0, 0.0, 0.0, 0.0, 0.0, 0.0), craft.effects)
    steady = not _lively(air)
    mean_wind = as_tuple(air[WIND : WIND + 3], 3)
    pressure = 0.5 * air[DENSITY] * air[AREA]
    seen = np.empty((schedule.delay + 1, STATE))
    seen[:] = start
    newest = 0
    use = 0.0
    instant = 0
    while True:
        if instant >= schedule.edge:
            since = instant - schedule.edge
            if since == 0:
                command = as_tuple(asked, REFERENCE)
            if since % schedule.stride == 0:
                for i in range(3):
                    velocity[since // schedule.stride, i] = state[10 + i]
                    spin[since // schedule.stride, i] = state[7 + i]
            for i in range(n):
                use = max(use, memory[i] / constants.rotors[i, 1])
        if instant == schedule.end:
            return use, -1
        known = state
        if schedule.delay:
            for i in range(STATE):
                seen[newest, i] = state[i]
            newest = (newest + 1) % (schedule.delay + 1)
            known = as_tuple(seen[newest], STATE)
        control_update(
            known,
            command,
            guidance,
            values,
            shares,
            constants,
            loops,
            craft.estimate,
            memory,
            thrusts,
            next_memory,
        )
        if steady:
            pull = drag_wrench(
                state, memory, mean_wind, pressure, craft.rigid.p_BoBcm_B, craft.blades
            )
        else:
            draw_normals(craft.seed, instant, noise)
            air_update(
                instant * schedule.period,
                state,
                memory,
                noise,
                air,
                craft.rigid.p_BoBcm_B,
                craft.blades,
                schedule.period,
                eddies,
                drag,
                wind,
                next_eddies,
            )
            eddies, next_eddies = next_eddies, eddies
            pull = as_tuple(drag, 6)
        memory, next_memory = next_memory, memory
        state = fly_on(state, wrench, craft.rigid, schedule.step, 1)
        wrench = _wrench(thrusts, pull, craft.effects)
        state = fly_on(state, wrench, craft.rigid, schedule.step, schedule.steps - 1)
        instant += 1
        if _lost(state, craft.clearance):
            return use, instant
        if steady and instant == STILL_PERIODS and _fastest(state) < STILL:
            instant = max(instant, schedule.edge)


@register_jitable
def _constants(craft):  # type: ignore[no-untyped-def]
    """Return the law's constants; what is as long for every vehicle as tuples, which is faster."""
    views = unpacked(craft.body, craft.rotors)
    return LawConstants(
        views.mass,
        as_tuple(views.inertia, 6),
        as_tuple(views.q_BT, 4),
        as_tuple(views.p_BoBcm_B, 3),
        as_tuple(views.drag, 3),
        np.ascontiguousarray(views.allocation),
        np.ascontiguousarray(views.effects),
        np.ascontiguousarray(views.idle_thrusts),
        np.ascontiguousarray(views.max_thrusts),
        np.ascontiguousarray(views.motor_constants),
        np.ascontiguousarray(views.rotors),
    )


@register_jitable
def _wrench(thrusts, drag, effects):  # type: ignore[no-untyped-def]
    """Return what acts on the body (6): rotors and air."""
    f_x, f_y, f_z, t_x, t_y, t_z = drag
    for i in range(len(thrusts)):
        f_x += effects[i, 0] * thrusts[i]
        f_y += effects[i, 1] * thrusts[i]
        f_z += effects[i, 2] * thrusts[i]
        t_x += effects[i, 3] * thrusts[i]
        t_y += effects[i, 4] * thrusts[i]
        t_z += effects[i, 5] * thrusts[i]
    return f_x, f_y, f_z, t_x, t_y, t_z


@register_jitable
def _lively(air):  # type: ignore[no-untyped-def]
    """Return whether the air does more than a steady wind."""
    lively = air[TURBULENCE] != 0.0
    for i in range(3):
        lively = lively or air[GUST + i] != 0.0 or air[PUSH + i] != 0.0
    return lively


@register_jitable
def _lost(state, clearance):  # type: ignore[no-untyped-def]
    """Return whether nothing that follows is of interest; see `Rollouts.diverged_at`."""
    size = 0.0
    for value in state:
        size += abs(value)
    if not size < math.inf:
        return True
    if state[6] < clearance:
        return True
    w, x, y, z, _, _, _, w_x, w_y, w_z, v_x, v_y, v_z = state
    if w * w + z * z > x * x + y * y:
        return False
    turns = w_x * w_x + w_y * w_y + w_z * w_z > TUMBLING_RATE**2
    return turns or v_x * v_x + v_y * v_y + v_z * v_z > TUMBLING_SPEED**2


@register_jitable
def _fastest(state):  # type: ignore[no-untyped-def]
    """Return the largest of the velocities [m/s, rad/s]."""
    most = 0.0
    for i in range(7, 13):
        most = max(most, abs(state[i]))
    return most
