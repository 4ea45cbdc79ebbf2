"""Linear models of flights on an estimate: against the Riccati equation, and against flights."""

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from workbench.common.errors import WorkbenchError
from workbench.design.linear import estimation as module
from workbench.design.linear.estimation import perfect_samples, settled_gain
from workbench.design.linear.operating_point import parse_point
from workbench.design.linear.study import LinearStudy
from workbench.estimation import ekf, ekf_measurements, ekf_propagation, ekf_state
from workbench.estimation.samples import BAROMETER, GPS, MAGNETOMETER, RANGE_FINDER, Mounting
from workbench.estimation.settings import EkfSettings
from workbench.plant.gravity import GRAVITY
from workbench.scenario.scenario import Scenario, SensorsConfig
from workbench.session.session import Session

PERIOD = 1 / 128
HOVER = np.array([1.0, 0, 0, 0, 0, 0, 10.0, 0, 0, 0, 0, 0, 0])
PLACES = Mounting(p_BI=(0.01, 0.02, 0.0), p_BG=(0.0, 0.05, 0.1)).packed()
SETTINGS = np.array(EkfSettings(ekf_gyro_bias_walk=1e-3, ekf_accel_bias_walk=1e-2))
DUTIES = {"gps": 0.08, "barometer": 0.4, "magnetometer": 0.4}


def test_the_settled_gain_is_that_of_the_riccati_equation(monkeypatch):
    """Step by step; in hover tilt and bias of the accelerometer look alike, so it never settles."""
    monkeypatch.setattr(module, "COVARIANCE_DOUBLINGS", 10)
    x = ekf.initial_ekf(HOVER, PLACES[:3], ekf.InitialDeviations())[: ekf_state.NOMINAL]
    z = perfect_samples(HOVER, np.array([0, 0, 0, 0, 0, GRAVITY]), PLACES)
    K, P = settled_gain(SETTINGS, PLACES, DUTIES, PERIOD, x, z)
    F, Q = (
        ekf_propagation.transition(x, z[:6], PERIOD),
        ekf_propagation.process_noise(SETTINGS, PERIOD),
    )
    H, gaps = ekf_measurements.measurement_rows(x, z, PLACES, SETTINGS)
    duty = np.repeat([DUTIES["gps"], DUTIES["barometer"]], [6, 2])
    R = np.diag(gaps[:8, 1] / duty)
    wanted = np.zeros((15, 15))
    for _ in range(2**10):
        gain = wanted @ H[:8].T @ np.linalg.inv(H[:8] @ wanted @ H[:8].T + R)
        wanted = F @ (wanted - gain @ H[:8] @ wanted) @ F.T + Q
    assert pytest.approx(wanted, rel=1e-6, abs=1e-9 * np.abs(wanted).max()) == P
    gain = wanted @ H[:8].T @ np.linalg.inv(H[:8] @ wanted @ H[:8].T + R)
    assert K[:, :8] == pytest.approx(gain, rel=1e-6, abs=1e-9)
    assert not K[:, 8:].any()


def test_perfect_samples_are_those_of_a_rigid_body_that_moves_and_turns():
    """By scipy's rotations: the place of each sensor, its velocity, the field and the beam."""
    turn = Rotation.from_euler("ZYX", [0.7, -0.2, 0.4])
    p_WB, w_WB, v_WB = (
        np.array([1.0, -2.0, 3.0]),
        np.array([0.3, -0.5, 0.8]),
        np.array([2.0, 1, -1]),
    )
    state = np.concatenate([turn.as_quat(scalar_first=True), p_WB, w_WB, v_WB])
    places = Mounting(
        p_BG=(0.1, 0.2, 0.3),
        p_BP=(-0.1, 0.05, 0.2),
        p_BR=(0.05, -0.1, -0.2),
        n_BR=(0.6, 0.0, -0.8),
    )
    imu = np.arange(6.0)
    z = perfect_samples(state, imu, places.packed())
    assert list(z[:6]) == list(imu)
    arm = turn.apply(places.p_BG)
    assert z[GPS + 2 : GPS + 8] == pytest.approx([*(p_WB + arm), *(v_WB + np.cross(w_WB, arm))])
    assert z[BAROMETER + 1] == pytest.approx(3.0 + turn.apply(places.p_BP)[2])
    field = turn.inv().apply(places.m_W)
    assert z[MAGNETOMETER + 1 : MAGNETOMETER + 4] == pytest.approx(field, abs=1e-12)
    height, fall = 3.0 + turn.apply(places.p_BR)[2], -turn.apply(places.n_BR)[2]
    assert z[RANGE_FINDER + 1] == pytest.approx(height / fall)


def flown(scenario, axis, amplitude, duration=3.0):
    """Return the truth's answer to a step: the difference of two flights, steered in both."""
    found = []
    for asked in (0.02, 0.02 + amplitude):
        session = Session(scenario)
        session.tick(4.0)
        if axis == "yaw":
            session.command(yaw_rate=asked)
        else:
            session.command([asked * (each == axis) for each in "xyz"])
        session.tick(duration)
        recording = session.recording().between(4.0, np.inf)
        shown = recording.w_WB[:, 2] if axis == "yaw" else recording.v_WB[:, "xyz".index(axis)]
        found.append(shown)
    return found[1] - found[0]


@pytest.mark.slow
@pytest.mark.parametrize(
    ("estimator", "axis", "near"),
    [
        ("ekf", "x", 0.02),
        pytest.param("ekf", "yaw", 0.01, marks=pytest.mark.slow),
        ("complementary", "x", 0.08),
    ],
)
def test_small_steps_flown_on_an_estimate_are_the_linear_ones(estimator, axis, near):
    """But for samples that come one by one, where the model spreads them over the updates."""
    scenario = Scenario(estimator=estimator, sensors=SensorsConfig(noise=False), duration=100.0)
    model = LinearStudy(scenario).sampled()
    asked = "reference_yaw_rate" if axis == "yaw" else f"reference_v_{axis}"
    shown = "w_z" if axis == "yaw" else f"v_{axis}"
    step = flown(scenario, axis, 0.05)
    b, c = model.B([asked])[:, 0], model.C([shown])[0]
    x, linear = np.zeros(len(b)), []
    for _ in step:
        linear.append(c @ x)
        x = model.A @ x + b
    assert np.abs(step - 0.05 * np.array(linear)).max() < near * 0.05


def test_an_estimator_has_states_and_margins_of_its_own():
    truth = LinearStudy(Scenario()).sampled()
    found = LinearStudy(Scenario(estimator="complementary")).sampled()
    assert {"estimated_angle_x", "estimated_v_z", "estimated_gyro_bias_y"} <= set(found.state_names)
    assert len(found.states) > len(truth.states) + 20
    poles = np.linalg.eigvals(found.A)
    assert np.abs(poles).max() < 1.0 + 1e-6


def test_what_has_no_model_says_so():
    study = LinearStudy(Scenario(estimator="ekf"))
    with pytest.raises(WorkbenchError, match="estimator ekf"):
        study.sampled(parse_point("yaw_rate=0.3"))
    with pytest.raises(WorkbenchError, match="--estimator truth"):
        study.continuous()
