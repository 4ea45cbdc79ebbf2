"""What noise does by the linear model, beside what it does in flights on the full diagram."""

import numpy as np
import pytest
from scipy import signal

from workbench.common.errors import WorkbenchError
from workbench.design.judge.noise import (
    input_deviations,
    noise_effects,
    noise_output_rows,
    noise_response,
)
from workbench.design.linear.operating_point import HOLDING_POINT, OperatingPoint
from workbench.design.linear.study import LinearStudy
from workbench.scenario.scenario import Scenario, VehicleConfig
from workbench.session.session import Session

NOISY_GPS = VehicleConfig(args={"gps_noise": "0.3"})
BEGUN = 20.0


def by_sensor(effects):
    return {each.sensor: each for each in effects}


def flown(scenario, settings):
    """Return RMS of roll and pitch [rad], and of the commands over their mean, in hover."""
    session = Session(scenario, settings)
    session.run()
    recording = session.recording().between(BEGUN, np.inf)
    tilt = 2.0 * recording.q_WB[:, 1:3].std(axis=0)
    commands = recording.commanded_speeds
    return tilt, commands.std(axis=0) / commands.mean(axis=0)


@pytest.mark.slow  # two minutes of flight, each
@pytest.mark.parametrize("settings", [{}, {"gyro_lowpass": 30.0, "derivative_lowpass": 5.0}])
def test_a_hover_on_the_ekf_shakes_as_the_model_says(settings):
    scenario = Scenario(estimator="ekf", vehicle=NOISY_GPS, duration=120.0)
    tilt, commands = flown(scenario, settings)
    found = by_sensor(noise_effects(LinearStudy(scenario), gains=settings))["all"]
    assert found.attitude[:2] == pytest.approx(tilt, rel=0.15)
    assert found.command == pytest.approx(commands, rel=0.1)


def test_a_low_pass_on_the_gyro_calms_the_rotors(case):
    study = LinearStudy(Scenario(estimator="ekf"))
    plain = by_sensor(noise_effects(study))
    for cutoff in (60.0, 20.0):
        with case(cutoff):
            calm = by_sensor(noise_effects(study, gains={"gyro_lowpass": cutoff}))
            assert calm["gyro"].worst_command < 0.7 * plain["gyro"].worst_command
            # its bias and drift come in through the estimator, which the filter is not before
            assert calm["accelerometer"].attitude == pytest.approx(
                plain["accelerometer"].attitude, rel=0.1
            )


def test_variances_of_sensors_add_up():
    effects = noise_effects(LinearStudy(Scenario(estimator="ekf", vehicle=NOISY_GPS)))
    *single, every = effects
    assert every.sensor == "all"
    assert {each.sensor for each in single} > {"gyro", "accelerometer", "gps", "magnetometer"}
    total = np.sum([np.square(each.command) for each in single], axis=0)
    assert np.sqrt(total) == pytest.approx(every.command)


def test_a_slow_sensor_counts_as_a_fast_one_with_as_much_noise_over_time():
    """GPS at 10 Hz, range finder at 50 Hz, updates at 128 Hz."""
    study = LinearStudy(Scenario(estimator="ekf", vehicle=NOISY_GPS))
    found = input_deviations(study, study.noisy(HOLDING_POINT))
    assert found["gps_p_x_noise"] == pytest.approx(0.3 * np.sqrt(128 / 10))
    assert found["gps_p_z_noise"] == pytest.approx(0.6 * np.sqrt(128 / 10))
    assert found["range_finder_distance_noise"] == pytest.approx(0.01 * np.sqrt(128 / 50))


def test_the_gyros_variance_is_that_of_a_long_run_of_scipys():
    """On the truth behind a filter, every sample with a number of its own, by scipy's dlsim."""
    settings = {"gyro_lowpass": 40.0}
    study = LinearStudy(Scenario())
    model = study.noisy(gains=settings)
    found = by_sensor(noise_effects(study, OperatingPoint(), settings))["gyro"]
    names = [s.name for s in model.inputs if s.name.startswith("gyro_noise_")]
    rows = noise_output_rows(model)[3:4]
    noise = 0.002 * np.sqrt(1024 / 200) * np.random.default_rng(4).normal(size=(30_000, len(names)))
    system = (model.A, model.B(names), rows, np.zeros((1, len(names))), model.period)
    _, out, _ = signal.dlsim(system, noise)
    assert out[2000:, 0].std() / model.trim.speeds[0] == pytest.approx(found.command[0], rel=0.03)


def test_the_response_at_low_frequencies_is_that_of_the_loop():
    """The yaw rate follows what the gyro says about z, but for what drag takes of it."""
    model = LinearStudy(Scenario()).noisy(gains={"gyro_lowpass": 40.0})
    frequency = np.array([0.01])
    yaw = noise_response(model, "gyro", frequency)[0, 2, 2]
    assert 0.85 < abs(yaw) * frequency[0] < 1.0
    with pytest.raises(WorkbenchError, match="gyro"):
        noise_response(model, "radar", frequency)
