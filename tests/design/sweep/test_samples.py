"""Oracle: itertools' product, and what the methods promise."""

import itertools

import numpy as np
import pytest

from workbench.common.errors import WorkbenchError
from workbench.design.sweep.ranges import parse_range
from workbench.design.sweep.sweep import sample_candidates

RANGES = [parse_range("kp_roll=100..400:4"), parse_range("kd_roll=1..100:3:log")]


def test_a_grid_has_all_combinations():
    expected = list(itertools.product([100.0, 200.0, 300.0, 400.0], [1.0, 10.0, 100.0]))
    np.testing.assert_allclose(sample_candidates(RANGES, "grid", 5, 0), expected)


def test_so_many_candidates_are_drawn_within_their_ranges(case):
    for count in [1, 2, 64, 100]:
        for method in ["random", "sobol"]:
            with case(count, method):
                drawn = sample_candidates(RANGES, method, count, 1)
                assert drawn.shape == (count, 2)
                assert (drawn >= [100.0, 1.0]).all()
                assert (drawn <= [400.0, 100.0]).all()


@pytest.mark.parametrize("method", ["random", "sobol"])
def test_the_seed_decides(method):
    first = sample_candidates(RANGES, method, 8, 1)
    assert (sample_candidates(RANGES, method, 8, 1) == first).all()
    assert (sample_candidates(RANGES, method, 8, 2) != first).all()


def test_sobol_leaves_no_hole_in_any_range():
    """Of 64 points, each 64th of a range has one; over the logarithm where it is one."""
    a, b = sample_candidates(RANGES, "sobol", 64, 3).T
    assert sorted((64 * (a - 100.0) / 300.0).astype(int)) == list(range(64))
    assert sorted((64 * np.log(b) / np.log(100.0)).astype(int)) == list(range(64))


def test_what_cannot_be_sampled_is_a_sentence(case):
    for ranges, method, count, seed, said in [
        (RANGES, "gird", 8, 0, "did you mean 'grid'"),
        (RANGES[:1] * 2, "grid", 8, 0, "kp_roll is swept twice"),
        ([], "grid", 8, 0, "nothing is swept"),
        (RANGES, "sobol", 0, 0, "0 candidates"),
        (RANGES, "random", -1, 0, "-1 candidates"),
        (RANGES, "random", 100_001, 0, "100001 candidates"),
        (
            [parse_range(f"{n}=1..2:100") for n in ("kp_roll", "kp_pitch", "kd_roll")],
            "grid",
            8,
            0,
            "1000000 candidates cannot be swept: give 1 to 100000",
        ),
        (RANGES, "random", 8, -1, "seed is -1"),
    ]:
        with case(ranges, method, count, seed, said):
            with pytest.raises(WorkbenchError) as caught:
                sample_candidates(ranges, method, count, seed)
            assert said in str(caught.value)
