"""A filter whose answer is known: the velocity follows that of the GPS with one lag."""

import numpy as np

from workbench.estimators import (
    ERRORS,
    GPS,
    NOMINAL,
    State,
    cross,
    gain,
    into_world,
    nominal,
    propagated,
    rotation,
)

PARAMETERS = [gain("lag_share", "1", (0.0, 1.0), 0.8, "of a difference that a sample takes away")]
MEMORY = [State("samples", "1"), State("spread", "m", 0.2)]
SAMPLES, SPREAD = NOMINAL, NOMINAL + 1


def begin(state, mounting, drawn, known):
    return np.concatenate([nominal(state, mounting.p_BI), [0.0, 0.2]])


def covariance(memory):
    return memory[SPREAD] ** 2 * np.eye(ERRORS)


def update(memory, z, settings, mounting, dt):
    x = propagated(memory[:NOMINAL], z, dt)
    R = rotation((x[0], x[1], x[2], x[3]))
    arm = mounting[3:6] - mounting[0:3]
    by_turning = into_world(R, cross((z[0], z[1], z[2]), (arm[0], arm[1], arm[2])))
    by_place = into_world(R, (arm[0], arm[1], arm[2]))
    for i in range(4):
        memory[i] = x[i]
    if z[GPS] > 0.0:
        memory[SAMPLES] += 1.0
        for i in range(3):
            memory[4 + i] = z[GPS + 2 + i] - by_place[i]
            away = z[GPS + 5 + i] - by_turning[i] - memory[7 + i]
            memory[7 + i] += settings[0] * away
