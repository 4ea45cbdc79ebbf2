"""What gains do to a step against steps with another gain, flown on the full diagram."""

import pytest

from workbench.analysis.queries import RequestedStep, Sensitivities
from workbench.analysis.subject import AnalysedVehicle
from workbench.common.errors import WorkbenchError
from workbench.design.step_response import fly_step
from workbench.scenario.scenario import Scenario, VehicleConfig

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


def test_a_dropped_load_counts_no_longer(answer):
    """`slung_load` is `dh_drone` with a load."""
    dropped, bare = (
        answer(
            Sensitivities({}, STEP),
            AnalysedVehicle(Scenario(vehicle=VehicleConfig(model=model)), settings),
        )["rise_time"]["kp_velocity_x"]
        for model, settings in (("slung_load", {"open_hooks": 1.0}), ("dh_drone", {}))
    )
    assert dropped == pytest.approx(bare, rel=1e-9)


@pytest.mark.parametrize(
    ("model", "settings", "said"),
    [
        ("dh_drone", {"payload_mass": 0.5}, "set known_payload_mass to payload_mass, 0.5 kg"),
        ("manipulator", {"servo_elbow": -1.8}, "servos at their start: leave servo_elbow there"),
    ],
)
def test_what_does_not_begin_in_a_known_hover_is_refused(answer, model, settings, said):
    about = AnalysedVehicle(Scenario(vehicle=VehicleConfig(model=model)), settings)
    with pytest.raises(WorkbenchError, match=said):
        answer(Sensitivities({}, STEP), about)


def test_a_stop_ends_it(answer, caller):
    caller.stopped = 1
    with pytest.raises(WorkbenchError, match="stopped"):
        answer(Sensitivities({}, STEP))
