"""Ranges against the margins' own judgement of what is stable."""

import pytest

from workbench.analysis.questions import FindRanges, Judge
from workbench.common.errors import WorkbenchError
from workbench.scenario.parameters import parameter_table

HARD = {"kp_velocity_x": 12.0, "kp_roll": 300.0}


@pytest.fixture(scope="module")
def found(subject):
    from workbench.analysis.ranges import find_ranges

    class Unstopped:
        def check(self):
            pass

    return {
        name: list(find_ranges(subject, FindRanges(gains), Unstopped()))[-1]
        for name, gains in (("own", {}), ("hard", HARD))
    }


@pytest.mark.parametrize("which", ["own", "hard"])
def test_a_percent_inside_is_stable_and_a_percent_outside_is_not(answer, found, which):
    ranges = found[which]
    ends = 0
    for name, (low, high) in ranges.stable.items():
        row = parameter_table().find(name)
        for value, outward in ((low, 0.99), (high, 1.01)):
            assert answer(Judge({**ranges.gains, name: value / outward ** (value > 0)})).stable, (
                name
            )
            if value in (row.minimum, row.maximum):
                continue
            ends += 1
            assert not answer(Judge({**ranges.gains, name: value * outward})).stable, name
    assert ends >= 6


def test_every_gain_has_a_range_that_holds_its_value(subject, found):
    ranges = found["hard"]
    assert len(ranges.stable) == 13
    for name, (low, high) in ranges.stable.items():
        assert low <= {**subject.own, **HARD}[name] <= high, name


def test_the_answer_of_an_unstable_value_is_the_nearest_range_that_is_stable(answer):
    ranges = answer(FindRanges({"kp_roll": 2000.0})).stable
    low, high = ranges["kp_roll"]
    assert 100.0 < low + 100.0 < high < 2000.0
    assert answer(Judge({"kp_roll": 0.98 * high})).stable
    # with such a roll nothing that pitch has makes the drone stable
    assert "kp_pitch" not in ranges


def test_it_rests_often_enough_for_margins_to_come_between(subject, work):
    """Between two rests lie two eigenvalue problems, not a whole gain."""
    from workbench.analysis.ranges import find_ranges

    rests = list(find_ranges(subject, FindRanges({}), work))
    assert len(rests) > 200


def test_a_stop_ends_it(answer, caller):
    caller.stopped = 1
    with pytest.raises(WorkbenchError, match="stopped"):
        answer(FindRanges({}))
