"""What judges gains judges a drone with a load: sensitivities, searches, sweeps, an estimator."""

import numpy as np
import pytest

from tests.jointed import drone, joint, link
from workbench.design.judge.sensitivity import SENSITIVITY_STEP_S, step_sensitivity
from workbench.design.step_response import fly_step
from workbench.design.sweep.sweep import sweep
from workbench.design.tune.tuner import tune
from workbench.design.tune.wish import wishes_for
from workbench.scenario.scenario import Scenario, ScenarioStart, SensorsConfig, VehicleConfig
from workbench.session.session import Session

LOAD = link("load", 0.25, (0.0, 0.0, -0.8)) + joint(
    "swing", "universal", "base", "load", (0.0, 0.0, -0.05)
)


@pytest.fixture(scope="module")
def slung(tmp_path_factory):
    """Return a scenario of a quadrotor with a load that swings."""
    model = drone(tmp_path_factory.mktemp("slung"), LOAD)
    return Scenario(vehicle=VehicleConfig(model=model))


def test_sensitivities_are_those_of_the_step_with_the_load(slung):
    found = {each.metric: each for each in step_sensitivity("x", 1.0, scenario=slung)}
    flown = fly_step("x", 1.0, duration=3.0, scenario=slung)
    after = flown.response[flown.time >= 0.0]
    rise = found["rise_time"]
    assert found["peak"].value == pytest.approx(after.max(), rel=5e-3)
    assert rise.elasticities["kp_velocity_x"] < -0.5
    steady = found["steady_state_value"].value
    crossed = [flown.time[np.flatnonzero(after >= share * steady)[0]] for share in (0.1, 0.9)]
    assert rise.value == pytest.approx(crossed[1] - crossed[0], abs=3 * SENSITIVITY_STEP_S)


def test_gains_are_tuned_with_the_load(slung):
    """By the margins of its linear model, in which the load swings."""
    wishes = wishes_for("velocity_x.phase_margin >= 80deg", defaults=False)
    found = tune(wishes, slung, evaluations=30)
    assert found.met
    assert found.gains["kp_velocity_x"] < found.before["kp_velocity_x"]


@pytest.mark.slow
def test_a_sweep_flies_the_load_in_processes(slung):
    table = sweep(["kp_velocity_x=1..3:2"], scenario=slung, axis="x", amplitude=1.0, duration=2.0)
    alone = [
        fly_step("x", 1.0, duration=2.0, scenario=slung, settings={"kp_velocity_x": gain})
        for gain in (1.0, 3.0)
    ]
    peaks = [each.metrics.peak for each in alone]
    assert table.column("peak").tolist() == pytest.approx(peaks, rel=1e-9)


def test_an_estimate_is_that_of_the_frame_not_of_the_load(tmp_path):
    """An IMU on the frame and one on the load: the first is read while the load swings."""
    imus = "".join(
        f'<gazebo reference="{name}"><sensor type="imu" name="imu_{name}"><update_rate>200'
        "</update_rate></sensor></gazebo>"
        for name in ("load", "base")
    )
    sensors = imus + (
        '<gazebo reference="base"><sensor type="navsat" name="gps"><update_rate>10</update_rate>'
        "</sensor></gazebo>"
    )
    session = Session(
        Scenario(
            vehicle=VehicleConfig(model=drone(tmp_path, LOAD + sensors)),
            estimator="ekf",
            start=ScenarioStart(position=[0.0, 0.0, 10.0]),
            sensors=SensorsConfig(noise=False),
        )
    )
    session.command([1.0, 0.0, 0.0])
    session.tick(2.0)
    recording = session.recording()
    assert np.ptp(recording.joints[:, 1]) > 0.1
    error = recording.estimate[:, 4:7] - recording.p_WB
    assert np.abs(error).max() < 0.1
