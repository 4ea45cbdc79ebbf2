"""What an estimate does to flights: noise, lost and broken sensors, and the paper's steps."""

import math
from functools import lru_cache

import numpy as np
import pytest

from workbench.design.estimation_errors import estimate_errors, judge_estimate
from workbench.design.flight_summary import summarise
from workbench.design.reproduce import PAPER_FIGURES, compare_with_paper, paper_checks
from workbench.design.step_response import fly_step
from workbench.scenario.scenario import Action, Scenario, SensorsConfig
from workbench.session.session import Session

FROZEN, NOISY, SILENT = 1.0, 2.0, 3.0
ONE_OR_MORE_SEEDS = pytest.mark.parametrize(
    "seeds", [range(1), pytest.param(range(1, 3), marks=pytest.mark.slow)], ids=["one", "more"]
)


def flown(script=(), *, estimator="ekf", duration=30.0, seed=0):
    scenario = Scenario(estimator=estimator, duration=duration, script=list(script))
    scenario.sensors.seed = seed
    session = Session(scenario)
    session.run()
    return session.recording()


def away(recording):
    """Return the distance from the place to hold over time [m]."""
    return np.linalg.norm(recording.p_WB - [0.0, 0.0, 1.5], axis=1)


@ONE_OR_MORE_SEEDS
@pytest.mark.parametrize(
    "estimator", ["ekf", pytest.param("complementary", marks=pytest.mark.slow)]
)
def test_with_all_noises_it_holds_its_place(estimator, seeds):
    """0.2 deg are asked for; the worst of 30 seeds had 0.09 deg, so a loss shows before that."""
    for seed in seeds:
        recording = flown(estimator=estimator, duration=6.0, seed=seed)
        assert away(recording).max() < 0.5, seed
        errors = estimate_errors(recording).attitude_B
        rms = math.sqrt(np.mean(np.sum(errors**2, axis=1)))
        assert math.degrees(rms) < 0.15, seed


@pytest.mark.slow
@ONE_OR_MORE_SEEDS
def test_without_gps_for_ten_seconds_it_drifts_no_more_than_it_says(seeds):
    """The drift is that of velocity and tilt that the estimate did not know when the GPS went.

    With 0.02 m/s, 0.05 deg of tilt and 0.005 m/s^2 of bias it is 0.5 m after 10 s; 1.5 m are three
    times as much. The deviations that the filter itself states grow as much.
    """
    lost = [Action(10.0, set={"gps_fault": SILENT}), Action(20.0, set={"gps_fault": 0.0})]
    drifts = []
    for seed in seeds:
        recording = flown(lost, seed=seed)
        drifts.append(away(recording.between(10.0, 21.0)).max())
        errors, sigma = estimate_errors(recording).position, recording.deviations[:, 3:6]
        assert np.all(np.abs(errors) < 4.0 * sigma + 0.01), seed
        before, longest = (sigma[round(128 * time), 0] for time in (9.9, 19.9))
        assert longest > 4.0 * before, seed
        assert sigma[-1, 0] < 1.2 * before, seed
        assert away(recording)[-1] < 0.2, seed
        assert recording.tilt.max() < math.radians(15.0), seed
    assert max(drifts) < 1.5
    assert max(drifts) > 0.05  # else the GPS was not missed


@pytest.mark.parametrize(
    ("seeds", "figures"),
    [(range(1), PAPER_FIGURES[1:2]), pytest.param(range(1), PAPER_FIGURES, marks=pytest.mark.slow)],
    ids=["one", "more"],
)
def test_the_papers_steps_stay_within_their_limits(seeds, figures):
    """But for the drift along y: the estimate begins with a velocity that is off by 0.01 m/s."""
    for seed in seeds:
        for figure in figures:
            scenario = Scenario(estimator="ekf")
            scenario.sensors.seed = seed
            row = compare_with_paper(
                figure, fly_step(figure.axis, figure.command, scenario=scenario)
            )
            for check in paper_checks(row):
                if check.quantity == "drift along y":
                    assert check.ours < 0.15, seed
                else:
                    assert check.met, (seed, figure.axis, check)


def test_samples_are_held_against_the_motion_of_their_own_time():
    """In a step at 10 m, without noise: the range finder's are up to 7 ms old, at 5 rad/s.

    Held against the present, they were worth 0.03 m/s and 0.0026 rad.
    """
    scenario = Scenario(estimator="ekf", sensors=SensorsConfig(noise=False))
    errors = estimate_errors(fly_step("x", 2.0, duration=1.5, scenario=scenario).recording)
    assert np.abs(errors.velocity).max() < 0.005
    assert np.abs(errors.attitude_B).max() < 2e-4


@lru_cache
def turned_climb(sensor, fault, end=20.0):
    """Return a climb of 1.5 m with a turn after the fault, without the range finder.

    Args:
        sensor: what has the fault.
        fault: which.
        end: of the flight [s].

    Returns:
        Largest errors from 8 s on: level, of height [m] and of heading [rad]; deviations at the
        end, of x, z [m] and heading [rad]; shares of innovations within their bounds by channel.
    """
    recording = flown(
        [
            Action(0.0, set={"range_finder_fault": SILENT}),
            Action(5.0, set={f"{sensor}_fault": fault}),
            Action(6.0, velocity=[0.0, 0.0, 0.5], yaw_rate=0.3),
            Action(9.0, velocity=[0.0, 0.0, 0.0], yaw_rate=0.0),
        ],
        duration=end,
    ).between(8.0, end)
    errors = estimate_errors(recording)
    within = {each.channel: each.within for each in judge_estimate(recording).innovations}
    level = float(np.linalg.norm(errors.position[:, :2], axis=1).max())
    height = float(np.abs(errors.position[:, 2]).max())
    heading = float(np.abs(errors.attitude_B[:, 2]).max())
    sigma = recording.deviations[-1]
    return level, height, heading, sigma[3], sigma[5], sigma[2], within


@pytest.mark.slow
def test_each_fault_has_its_consequence():
    level, height, heading, sigma_x, sigma_z, sigma_yaw, within = turned_climb("gps", 0.0)
    assert level < 0.2 and height < 0.2 and math.degrees(heading) < 0.3
    assert min(within.values()) > 0.9

    frozen, noisy, silent = (turned_climb("gps", fault) for fault in (FROZEN, NOISY, SILENT))
    assert noisy[0] > 1.0 and noisy[-1]["gps_x"] < 0.3
    assert silent[3] > 5.0 * sigma_x and "gps_x" not in silent[-1]
    assert frozen == silent  # to the bit: what repeats is left out

    frozen, noisy, silent = (turned_climb("barometer", fault) for fault in (FROZEN, NOISY, SILENT))
    assert frozen[1] > 1.0 and frozen[-1]["gps_z"] < 0.5  # the GPS contradicts
    assert noisy[1] > 2.0 * height and noisy[-1]["barometer"] < 0.5
    assert silent[4] > 3.0 * sigma_z and "barometer" not in silent[-1]

    frozen, noisy, silent = (
        turned_climb("magnetometer", fault) for fault in (FROZEN, NOISY, SILENT)
    )
    assert frozen[-1]["magnetometer"] < 0.1  # beyond the gate, and left out
    assert frozen[2] > 2.0 * heading
    assert noisy[-1]["magnetometer"] < 0.5
    assert silent[5] > 1.3 * sigma_yaw and "magnetometer" not in silent[-1]


@pytest.mark.slow
@pytest.mark.parametrize(
    "estimator", ["ekf", pytest.param("complementary", marks=pytest.mark.slow)]
)
def test_a_frozen_gyro_ends_the_flight_upside_down_and_not_in_a_traceback(estimator):
    recording = flown([Action(5.0, set={"imu_fault": FROZEN})], estimator=estimator, duration=8.0)
    summary = summarise(recording)
    assert recording.time[-1] == 8.0
    assert 5.0 < summary.turned_over < 8.0
    assert np.isfinite(recording.estimate).all()
    off = np.linalg.norm(estimate_errors(recording).attitude_B, axis=1)
    assert off.max() > math.radians(45.0)


@pytest.mark.slow
def test_the_complementary_filter_follows_a_frozen_compass():
    """It has no gate: a compass that stands turns the heading away."""
    turn = [Action(6.0, yaw_rate=0.3), Action(9.0, yaw_rate=0.0)]
    fault = Action(5.0, set={"magnetometer_fault": FROZEN})
    recording = flown([fault, *turn], estimator="complementary", duration=13.0)
    errors = estimate_errors(recording)
    off = np.hstack([errors.attitude_B, errors.position])
    assert np.abs(off[:640]).max() < 0.1
    assert np.abs(off[:, 2]).max() > math.radians(10.0)
