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

STEP = np.uint64(0x9E3779B97F4A7C15)
FIRST, SECOND = np.uint64(0xBF58476D1CE4E5B9), np.uint64(0x94D049BB133111EB)
SHIFTS = (np.uint64(30), np.uint64(27), np.uint64(31), np.uint64(11))
FRACTION = 2.0**-53
COUNT = 6
"""Number of numbers of a sample: three pairs."""
with np.errstate(over="ignore"):  # the integers wrap around
    PLACES = np.arange(1, COUNT + 1, dtype=np.uint64) * STEP
    STRIDE = np.uint64(COUNT) * STEP
"""Places of a sample's numbers in the generator's sequence, and from one sample to the next."""
Normals = tuple[float, float, float, float, float, float]


@register_jitable
def mixed(z: Any) -> Any:
    """Return 64 bits, each of which depends on all of z."""
    z = (z ^ (z >> SHIFTS[0])) * FIRST
    z = (z ^ (z >> SHIFTS[1])) * SECOND
    return z ^ (z >> SHIFTS[2])


@register_jitable
def drawn_normals(seed: float, number: int) -> Normals:
    """Return a sample's independent standard normal numbers, by Box and Muller (1958).

    Args:
        seed: a whole number.
        number: of the sample, from 0.
    """
    first = mixed(np.uint64(seed) + STEP) + np.uint64(number) * np.uint64(COUNT) * STEP
    second = first + STEP + STEP
    return _pair(first) + _pair(second) + _pair(second + STEP + STEP)


@register_jitable
def _pair(state: np.uint64) -> tuple[float, float]:
    """Return the pair of numbers behind a state of the generator."""
    state = state + STEP
    radius = (float(mixed(state) >> SHIFTS[3]) + 1.0) * FRACTION  # above 0, up to 1
    state = state + STEP
    turn = float(mixed(state) >> SHIFTS[3]) * FRACTION
    length = math.sqrt(-2.0 * math.log(radius))
    return length * math.cos(2.0 * math.pi * turn), length * math.sin(2.0 * math.pi * turn)


def normal_rows(seed: float, numbers: np.ndarray) -> np.ndarray:
    """Return what `drawn_normals` returns for each of some samples (K, `COUNT`), quicker in Python.

    Args:
        seed: a whole number.
        numbers: of the samples (K), from 0.
    """
    with np.errstate(over="ignore"):  # the integers wrap around
        first = mixed(np.uint64(seed) + STEP)
        states = first + (numbers.astype(np.uint64) * STRIDE)[:, None] + PLACES
        shares = (mixed(states) >> SHIFTS[3]).astype(float)
    length = np.sqrt(-2.0 * np.log((shares[:, 0::2] + 1.0) * FRACTION))
    turn = 2.0 * math.pi * FRACTION * shares[:, 1::2]
    drawn = np.empty((len(numbers), COUNT))
    drawn[:, 0::2], drawn[:, 1::2] = length * np.cos(turn), length * np.sin(turn)
    return drawn


@register_jitable
def draw_normals(seed: float, number: int, normals: np.ndarray) -> None:
    """Write what `drawn_normals` returns to `COUNT` places."""
    drawn = drawn_normals(seed, number)
    for place in range(COUNT):
        normals[place] = drawn[place]


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
