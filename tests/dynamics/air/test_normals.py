"""Oracles: SplitMix64 in whole numbers of Python, and the statistics of normal numbers."""

import math

import numba
import numpy as np
import pytest
from scipy.stats import kstest

from workbench.common.jitable import register_with_numba
from workbench.dynamics.air.normals import (
    NORMALS_PER_SAMPLE,
    SPLITMIX_STEP,
    draw_normals,
    normal_rows,
    splitmix_mixed,
)

BITS = 2**64 - 1

register_with_numba()


@numba.njit
def _first(seed, count):
    found = np.empty(count, np.uint64)
    state = np.uint64(seed)
    for index in range(count):
        state = state + SPLITMIX_STEP
        found[index] = splitmix_mixed(state)
    return found


@numba.njit
def _drawn(seed, count):
    found = np.empty((count, NORMALS_PER_SAMPLE))
    for number in range(count):
        draw_normals(seed, number, found[number])
    return found


def in_whole_numbers(z: int) -> int:
    z = (z ^ z >> 30) * 0xBF58476D1CE4E5B9 & BITS
    z = (z ^ z >> 27) * 0x94D049BB133111EB & BITS
    return z ^ z >> 31


def test_it_is_splitmix64():
    """Its well-known first numbers from the seed 1234567."""
    assert _first(1234567, 3).tolist() == [
        6457827717110365317,
        3203168211198807973,
        9817491932198370423,
    ]


@pytest.mark.parametrize("number", [0, 1, 12345])
def test_a_sample_is_three_pairs_of_the_sequence(number):
    step, seed = 0x9E3779B97F4A7C15, 2**32 - 1
    key = in_whole_numbers(seed + step & BITS)
    places = [key + (6 * number + index + 1) * step & BITS for index in range(6)]
    uniform = [(in_whole_numbers(place) >> 11) / 2**53 for place in places]
    wanted: list[float] = []
    for first, second in zip(uniform[::2], uniform[1::2], strict=True):
        length = math.sqrt(-2.0 * math.log(first + 2**-53))
        angle = 2.0 * math.pi * second
        wanted += [length * math.cos(angle), length * math.sin(angle)]
    assert _drawn(float(seed), number + 1)[number] == pytest.approx(wanted, rel=1e-12)


def test_numbers_are_normal_and_independent():
    found = _drawn(3.0, 50_000)
    assert kstest(found.ravel(), "norm").pvalue > 0.01
    both = np.hstack([found[:-1], found[1:]])  # of one sample, and of the next
    assert np.cov(both.T) == pytest.approx(np.eye(2 * NORMALS_PER_SAMPLE), abs=0.03)


def test_seeds_near_each_other_have_nothing_in_common():
    one, other = _drawn(1.0, 20_000), _drawn(2.0, 20_000)
    assert (
        np.abs(np.corrcoef(one.T, other.T)[:NORMALS_PER_SAMPLE, NORMALS_PER_SAMPLE:]).max() < 0.03
    )
    assert not set(one.ravel().tolist()) & set(other.ravel().tolist())


def test_rows_are_the_same_numbers():
    numbers = np.array([0, 3, 4, 1999])
    assert normal_rows(7.0, numbers) == pytest.approx(_drawn(7.0, 2000)[numbers], rel=1e-14)
