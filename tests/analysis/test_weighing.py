"""What gains do to a step against steps with another gain, flown on the full diagram."""

import pytest

from workbench.analysis.queries import RequestedStep, Sensitivities
from workbench.common.errors import WorkbenchError
from workbench.design.step_response import fly_step

STEP = RequestedStep("x", 2.0, 1.5)


@pytest.fixture(scope="module")
def weighed(subject):
    from workbench.analysis.predicting import weigh

    class Unstopped:
        def check(self, _share):
            pass

    return next(weigh(subject, Sensitivities({}, STEP), Unstopped()))


def test_a_percent_more_does_what_it_says(subject, weighed):
    """Against a percent more and less on the sampled diagram, which differs by 7 %."""
    own = subject.own["kp_velocity_x"]
    less, more = (
        fly_step("x", 2.0, duration=1.5, settings={"kp_velocity_x": factor * own}).metrics
        for factor in (0.99, 1.01)
    )
    for metric in ("peak", "overshoot"):
        change = 0.5 * (getattr(more, metric) - getattr(less, metric))
        assert weighed[metric]["kp_velocity_x"] == pytest.approx(change, rel=0.1), metric


def test_the_strongest_come_first_and_what_does_nothing_is_left_out(weighed):
    for slopes in weighed.values():
        sizes = [abs(slope) for slope in slopes.values()]
        assert sizes == sorted(sizes, reverse=True)
        assert 0.0 not in sizes
    strongest, *others = weighed["rise_time"].items()
    assert strongest[0] == "kp_velocity_x"
    assert strongest[1] < 0.0
    assert "kp_yaw_rate" not in dict(others)


def test_a_stop_ends_it(answer, caller):
    caller.stopped = 1
    with pytest.raises(WorkbenchError, match="stopped"):
        answer(Sensitivities({}, STEP))
