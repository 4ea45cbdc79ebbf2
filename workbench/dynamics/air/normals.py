"""Standard normal numbers by seed and sample number, for compiled code.

Drake's random source has its generator as abstract state, so the whole diagram's state is copied at
every sample, which took a tenth of a flight's time. SplitMix64 needs no state: its n-th number is a
hash of seed + n times a constant (Steele, Lea and Flood, "Fast Splittable Pseudorandom Number
Generators", OOPSLA 2014; with Stafford's variant 13 of the mixer).
"""

import math

import numpy as np

from workbench.common.jitable import register_jitable

STEP = np.uint64(0x9E3779B97F4A7C15)
FIRST, SECOND = np.uint64(0xBF58476D1CE4E5B9), np.uint64(0x94D049BB133111EB)
SHIFTS = (np.uint64(30), np.uint64(27), np.uint64(31), np.uint64(11))
FRACTION = 2.0**-53
PAIRS = 3
COUNT = 2 * PAIRS
"""Number of numbers of a sample."""


@register_jitable
def mixed(z: np.uint64) -> np.uint64:
    """Return 64 bits, each of which depends on all of z."""
    z = (z ^ (z >> SHIFTS[0])) * FIRST
    z = (z ^ (z >> SHIFTS[1])) * SECOND
    return z ^ (z >> SHIFTS[2])


@register_jitable
def draw_normals(seed: float, number: int, normals: np.ndarray) -> None:
    """Write a sample's independent standard normal numbers, by Box and Muller (1958).

    Args:
        seed: a whole number.
        number: of the sample, from 0.
        normals: places for `COUNT` of them.
    """
    state = mixed(np.uint64(seed) + STEP) + np.uint64(number) * np.uint64(COUNT) * STEP
    for pair in range(PAIRS):
        state = state + STEP
        radius = (float(mixed(state) >> SHIFTS[3]) + 1.0) * FRACTION  # above 0, up to 1
        state = state + STEP
        turn = float(mixed(state) >> SHIFTS[3]) * FRACTION
        length = math.sqrt(-2.0 * math.log(radius))
        normals[2 * pair] = length * math.cos(2.0 * math.pi * turn)
        normals[2 * pair + 1] = length * math.sin(2.0 * math.pi * turn)


@register_jitable
def counted_draws(seed: float, number: int, draws: np.ndarray) -> None:
    """Write the standard normal numbers of a sample, any number of them.

    Args:
        seed: a whole number.
        number: of the sample, from 0.
        draws: places for them.
    """
    blocks = -(-len(draws) // COUNT)
    block = np.empty(COUNT)
    for place in range(len(draws)):
        if place % COUNT == 0:
            draw_normals(seed, number * blocks + place // COUNT, block)
        draws[place] = block[place % COUNT]
