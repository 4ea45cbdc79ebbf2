"""Standard normal numbers by seed and sample number, for compiled code.

Drake's random source has its generator as abstract state, so the whole diagram's state is copied at
every sample, which took a tenth of a flight's time. SplitMix64 needs no state: its n-th number is a
hash of seed + n times a constant (Steele, Lea and Flood, "Fast Splittable Pseudorandom Number
Generators", OOPSLA 2014; with Stafford's variant 13 of the mixer).
"""

import math
from typing import Any

import numpy as np

from workbench.common.jitable import register_jitable

SPLITMIX_STEP = np.uint64(0x9E3779B97F4A7C15)
SPLITMIX_FACTOR_1, SPLITMIX_FACTOR_2 = np.uint64(0xBF58476D1CE4E5B9), np.uint64(0x94D049BB133111EB)
SPLITMIX_SHIFTS = (np.uint64(30), np.uint64(27), np.uint64(31), np.uint64(11))
SPLITMIX_FRACTION = 2.0**-53
NORMALS_PER_SAMPLE = 6
"""Number of numbers of a sample: three pairs."""
with np.errstate(over="ignore"):  # the integers wrap around
    NORMALS_OFFSETS = np.arange(1, NORMALS_PER_SAMPLE + 1, dtype=np.uint64) * SPLITMIX_STEP
    NORMALS_STRIDE = np.uint64(NORMALS_PER_SAMPLE) * SPLITMIX_STEP
"""Places of a sample's numbers in the generator's sequence, and from one sample to the next."""
Normals = tuple[float, float, float, float, float, float]


@register_jitable
def splitmix_mixed(z: Any) -> Any:
    """Return 64 bits, each of which depends on all of z."""
    z = (z ^ (z >> SPLITMIX_SHIFTS[0])) * SPLITMIX_FACTOR_1
    z = (z ^ (z >> SPLITMIX_SHIFTS[1])) * SPLITMIX_FACTOR_2
    return z ^ (z >> SPLITMIX_SHIFTS[2])


@register_jitable
def drawn_normals(seed: float, number: int) -> Normals:
    """Return a sample's independent standard normal numbers, by Box and Muller (1958).

    Args:
        seed: a whole number.
        number: of the sample, from 0.
    """
    first = (
        splitmix_mixed(np.uint64(seed) + SPLITMIX_STEP)
        + np.uint64(number) * np.uint64(NORMALS_PER_SAMPLE) * SPLITMIX_STEP
    )
    second = first + SPLITMIX_STEP + SPLITMIX_STEP
    return _pair(first) + _pair(second) + _pair(second + SPLITMIX_STEP + SPLITMIX_STEP)


@register_jitable
def _pair(state: np.uint64) -> tuple[float, float]:
    """Return the pair of numbers behind a state of the generator."""
    state = state + SPLITMIX_STEP
    radius = (
        float(splitmix_mixed(state) >> SPLITMIX_SHIFTS[3]) + 1.0
    ) * SPLITMIX_FRACTION  # above 0, up to 1
    state = state + SPLITMIX_STEP
    turn = float(splitmix_mixed(state) >> SPLITMIX_SHIFTS[3]) * SPLITMIX_FRACTION
    length = math.sqrt(-2.0 * math.log(radius))
    return length * math.cos(2.0 * math.pi * turn), length * math.sin(2.0 * math.pi * turn)


def normal_rows(seed: float, numbers: np.ndarray) -> np.ndarray:
    """Return what `drawn_normals` returns for each of some samples (K, `NORMALS_PER_SAMPLE`),
    quicker in Python.

    Args:
        seed: a whole number.
        numbers: of the samples (K), from 0.
    """
    with np.errstate(over="ignore"):  # the integers wrap around
        first = splitmix_mixed(np.uint64(seed) + SPLITMIX_STEP)
        states = first + (numbers.astype(np.uint64) * NORMALS_STRIDE)[:, None] + NORMALS_OFFSETS
        shares = (splitmix_mixed(states) >> SPLITMIX_SHIFTS[3]).astype(float)
    length = np.sqrt(-2.0 * np.log((shares[:, 0::2] + 1.0) * SPLITMIX_FRACTION))
    turn = 2.0 * math.pi * SPLITMIX_FRACTION * shares[:, 1::2]
    drawn = np.empty((len(numbers), NORMALS_PER_SAMPLE))
    drawn[:, 0::2], drawn[:, 1::2] = length * np.cos(turn), length * np.sin(turn)
    return drawn


@register_jitable
def draw_normals(seed: float, number: int, normals: np.ndarray) -> None:
    """Write what `drawn_normals` returns to `NORMALS_PER_SAMPLE` places."""
    drawn = drawn_normals(seed, number)
    for place in range(NORMALS_PER_SAMPLE):
        normals[place] = drawn[place]


@register_jitable
def counted_draws(seed: float, number: int, draws: np.ndarray) -> None:
    """Write the standard normal numbers of a sample, any number of them.

    Args:
        seed: a whole number.
        number: of the sample, from 0.
        draws: places for them.
    """
    blocks = -(-len(draws) // NORMALS_PER_SAMPLE)
    block = np.empty(NORMALS_PER_SAMPLE)
    for place in range(len(draws)):
        if place % NORMALS_PER_SAMPLE == 0:
            draw_normals(seed, number * blocks + place // NORMALS_PER_SAMPLE, block)
        draws[place] = block[place % NORMALS_PER_SAMPLE]
