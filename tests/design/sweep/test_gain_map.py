"""Oracle: flights of the engine, one grid point at a time."""

import numpy as np
import pytest

from workbench.common.errors import WorkbenchError
from workbench.design.rollout.engine import RolloutEngine
from workbench.design.sweep.ranges import parse_range
from workbench.design.sweep.sweep import gain_map
from workbench.scenario.configured import configured_vehicle
from workbench.scenario.scenario import VehicleConfig

X, Y = parse_range("kp_pitch=100..400:3"), parse_range("kd_pitch=0..30:2")


@pytest.fixture(scope="module")
def engine():
    return RolloutEngine(configured_vehicle(VehicleConfig()))


def test_every_place_is_the_flight_with_its_gains(engine):
    gains = {"kp_velocity_x": 3.5, "gyro_lowpass": 40.0}
    found = gain_map(engine, gains, X, Y, metric="overshoot", axis="x", amplitude=2.0)
    assert found.values.shape == found.lost.shape == (2, 3)
    for row, kd in enumerate(Y.grid):
        for column, kp in enumerate(X.grid):
            sets = [{**gains, "kp_pitch": kp, "kd_pitch": kd}]
            alone = engine.measure(sets, "x", 2.0, duration=2.0)
            lost = np.isfinite(alone.diverged_at[0])
            assert found.lost[row, column] == lost
            wanted = np.nan if lost else alone.metrics.overshoot[0]
            np.testing.assert_array_equal(found.values[row, column], wanted)


def test_rotor_use_is_a_metric_too(engine):
    found = gain_map(engine, {}, X, Y, metric="peak_rotor_use", axis="z", amplitude=3.0)
    assert (found.values[~found.lost] > 0.5).all()


def test_a_map_that_nobody_waits_for_is_given_up(engine):
    assert gain_map(engine, {}, X, parse_range("kd_pitch=0..30:32"), stop=lambda: True) is None


def test_what_is_no_gain_is_not_passed_over(engine):
    with pytest.raises(WorkbenchError, match="unknown parameter of pd 'wind_x'"):
        gain_map(engine, {"wind_x": 4.0}, X, Y)


@pytest.mark.parametrize(
    ("asked", "said"),
    [
        ({"x": parse_range("wind_x=0..1")}, "unknown parameter of pd 'wind_x'"),
        ({"y": X}, "both axes of the map are kp_pitch"),
        ({"metric": "phase_margin"}, "unknown metric of a flight 'phase_margin'"),
        ({"metric": "overshot"}, "did you mean 'overshoot'"),
        ({"axis": "roll"}, "unknown axis 'roll'"),
    ],
)
def test_what_makes_no_map_is_said(engine, asked, said):
    with pytest.raises(WorkbenchError, match=said):
        gain_map(engine, {}, **{"x": X, "y": Y, **asked})
