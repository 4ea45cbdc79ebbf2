"""Flights on an estimate whose sensors fail: what follows, what is said, and how they end."""

import math

import numpy as np
import pytest

from workbench.control.mode import FlightMode, Reason
from workbench.design.flight_summary import summarise
from workbench.plant.home import DEFAULT_HOME
from workbench.plant.magnetic_field import earth_magnetic_field
from workbench.scenario.scenario import (
    Action,
    Scenario,
    ScenarioStart,
    SensorsConfig,
    VehicleConfig,
)
from workbench.session.session import Session

AT = 2.0
"""When something fails [s]."""
SIGMAS = 4.0
"""No error is larger than so many of its deviations, in a handful of flights."""


def flown(
    duration: float,
    *script: Action,
    estimator: str = "ekf",
    height: float = 3.0,
    on_ground: bool = False,
    noise: bool = True,
    args: dict[str, str] | None = None,
    settings: dict[str, float] | None = None,
) -> Session:
    start = ScenarioStart(mode="off") if on_ground else ScenarioStart(position=[0.0, 0.0, height])
    scenario = Scenario(
        estimator=estimator,
        duration=duration,
        start=start,
        script=list(script),
        sensors=SensorsConfig(noise=noise, seed=3),
        vehicle=VehicleConfig(args=args or {}),
    )
    session = Session(scenario, settings)
    session.run()
    return session


def failing(at: float = AT, **values: float) -> Action:
    return Action(at=at, set=values)


def heading(q: np.ndarray) -> np.ndarray:
    """Return the heading of quaternions (N, 4) [rad]."""
    w, x, y, z = q.T
    return np.arctan2(2.0 * (w * z + x * y), 1.0 - 2.0 * (y * y + z * z))


@pytest.mark.slow
def test_without_gps_for_ten_seconds_the_place_is_held_as_well_as_the_filter_says(case):
    """The filter's own deviation of the place, once without GPS, bounds how far the drone is off.

    It holds its estimate, so that it is off by the estimate's error and by the hold's own, a few
    centimetres. The complementary filter knows no deviation: its bound is that of an attitude that
    is off by the accelerometer's bias over g, 0.02 / 9.81, for ten seconds: g a t² / 2 = 1 m.
    """
    for estimator in ("ekf", "complementary"):
        with case(estimator):
            back = failing(at=AT + 10.0, gps_fault=0.0)
            settings = {"gps_timeout": 60.0}
            session = flown(
                AT + 12.0,
                failing(gps_fault=3.0),
                back,
                estimator=estimator,
                settings=settings,
            )
            flight = session.recording()
            off = np.linalg.norm(flight.p_WB[:, :2], axis=1)
            bound = 1.0
            if estimator == "ekf":
                bound = SIGMAS * float(np.linalg.norm(flight.deviations[:, 3:5], axis=1).max())
            assert off.max() < bound + 0.1 < 8.0
            assert set(flight.mode) <= {
                *(FlightMode.HOVERING, FlightMode.CRUISING),
                *(FlightMode.ASCENDING, FlightMode.DESCENDING),
            }
            blind = flight.between(AT + 1.3, AT + 9.9)
            assert set(blind.reason) == {Reason.DEAD_RECKONING}
            assert session.snapshot().reason is Reason.NONE


@pytest.mark.slow
def test_a_position_that_is_lost_for_good_ends_in_a_landing_that_says_so(case):
    """From a height of 1 m: the landing takes the longest of it."""
    limits = {"ekf": {"position_deviation_limit": 0.3}, "complementary": {"gps_timeout": 2.0}}
    for estimator, settings in limits.items():
        with case(estimator):
            session = flown(
                14.0, failing(gps_fault=3.0), estimator=estimator, height=1.0, settings=settings
            )
            flight, now = session.recording(), session.snapshot()
            summary = summarise(flight)
            assert (now.mode, now.reason) == (FlightMode.OFF, Reason.POSITION_LOST)
            reasons = [(each.reason, each.mode) for each in summary.failsafes]
            assert reasons == [
                (Reason.DEAD_RECKONING.label, "hovering"),
                (Reason.POSITION_LOST.label, "landing"),
            ]
            begun = summary.failsafes[1].time
            if estimator == "ekf":
                deviation = np.linalg.norm(flight.deviations[:, 3:5], axis=1)
                first = flight.time[np.argmax(deviation > 0.3)]
            else:
                first = AT + 2.0
            assert first <= begun <= first + 0.35  # a period of the GPS, and one of the mode
            assert summary.touch_down_speed is not None
            assert summary.touch_down_speed < 1.0
            assert not flight.reference.any()


@pytest.mark.slow
@pytest.mark.parametrize(
    "estimator", ["ekf", pytest.param("complementary", marks=pytest.mark.slow)]
)
def test_a_frozen_gps_is_flown_as_a_silent_one_and_comes_back_as_one(estimator):
    """What repeats is left out: the flight is that without GPS to the bit, held and then landed."""
    limits = {"ekf": {"position_deviation_limit": 0.15}, "complementary": {"gps_timeout": 2.0}}
    frozen, silent = (
        flown(
            8.0,
            failing(gps_fault=fault),
            failing(at=AT + 1.5, gps_fault=0.0),
            failing(at=AT + 2.5, gps_fault=fault),
            estimator=estimator,
            settings=limits[estimator],
        ).recording()
        for fault in (1.0, 3.0)
    )
    reasons = [each.reason for each in summarise(silent).failsafes]
    held = Reason.DEAD_RECKONING.label
    assert reasons == [held, held, Reason.POSITION_LOST.label]
    assert np.array_equal(frozen.p_WB, silent.p_WB)
    assert np.array_equal(frozen.estimate, silent.estimate)
    assert summarise(frozen).failsafes == summarise(silent).failsafes


@pytest.mark.slow
@pytest.mark.parametrize(
    ("estimator", "noise"),
    [
        ("ekf", True),
        pytest.param("complementary", False, marks=pytest.mark.slow),
        pytest.param("ekf", False, marks=pytest.mark.slow),
        pytest.param("complementary", True, marks=pytest.mark.slow),
    ],
)
def test_an_exact_gps_that_stands_is_not_taken_for_frozen(estimator, noise):
    """The shipped GPS has no noise: on the ground it repeats itself, and so may a flight at rest.

    With `noise: false` the IMU is exact, too. Before it takes off, the drone stands for four times
    what the complementary filter waits for a GPS.
    """
    session = flown(
        11.5,
        Action(at=1.0, request="arm"),
        Action(at=4.0, request="take_off", height=1.0),
        Action(at=7.5, request="land"),
        estimator=estimator,
        on_ground=True,
        noise=noise,
        settings={"gps_timeout": 1.0} if estimator == "complementary" else {},
    )
    flight = session.recording()
    assert not flight.reason.any()
    assert np.linalg.norm(flight.estimate[:, 4:6] - flight.p_WB[:, :2], axis=1).max() < 0.2
    assert flight.p_WB[:, 2].max() > 0.9
    assert session.snapshot().mode is FlightMode.OFF


@pytest.mark.slow
def test_a_gyro_that_stands_still_stops_the_rotors_within_half_a_second(case):
    for estimator in ("ekf", "complementary"):
        for fault in (1.0, 3.0):
            with case(f"{estimator} {fault}"):
                session = flown(2.7, failing(at=1.0, imu_fault=fault), estimator=estimator)
                flight, now = session.recording(), session.snapshot()
                (failsafe,) = summarise(flight).failsafes
                assert (failsafe.reason, failsafe.mode) == (Reason.IMU_FAILED.label, "off")
                assert 0.1 <= failsafe.time - 1.0 <= 0.5
                assert (now.mode, now.reason) == (FlightMode.OFF, Reason.IMU_FAILED)
                assert now.p_WB[2] < 0.3
                assert np.isfinite(flight.estimate).all()


@pytest.mark.slow
def test_a_noisy_gyro_flies_on_and_one_without_noise_is_not_taken_for_failed(case):
    for name, script, noise in (
        ("noisy", [failing(imu_fault=2.0)], True),
        ("exact", [], False),
    ):
        with case(name):
            session = flown(5.0, *script, noise=noise)
            flight = session.recording()
            assert not flight.reason.any()
            assert np.abs(flight.p_WB[:, 2] - 3.0).max() < 0.2


def test_an_exact_imu_at_rest_whose_readings_repeat_has_not_failed():
    arm = Action(at=1.0, request="arm")
    now = flown(4.5, arm, on_ground=True, noise=False).snapshot()  # they repeat from 3 s on
    assert (now.mode, now.reason) == (FlightMode.ARMED, Reason.NONE)


def test_the_ground_effect_lowers_the_estimated_height_at_take_off_by_its_share():
    """Where the barometer alone tells the height, it is off by what the pressure is, 12 Pa a metre.

    The share of the effect is that at the barometer's height on the ground. The filter follows it
    within a second or two, while the drone climbs out of it.
    """
    effect = 24.0
    take_off = Action(at=1.0, request="take_off", height=2.0)
    lowest = {}
    for added in (0.0, effect):
        session = flown(
            2.2,
            take_off,
            estimator="complementary",
            on_ground=True,
            settings={"barometer_ground_effect": added},
        )
        flight = session.recording()
        lowest[added] = float((flight.estimate[:, 6] - flight.p_WB[:, 2]).min())
    height = session.vehicle.ground_clearance
    metres = effect * math.exp(-height / 0.5) / (1.225 * 9.81)
    assert abs(lowest[0.0]) < 0.15
    assert -1.3 * metres < lowest[effect] < -0.4 * metres  # less as the filter follows, and climbs


@pytest.mark.slow
def test_a_disturbed_magnetometer_turns_the_heading_and_one_far_off_is_left_out(case):
    """A field across the earth's turns it by the angle of closed form; beyond the gate by none."""
    east, north, _ = earth_magnetic_field(DEFAULT_HOME)
    # a settled estimate gives way slowly: its gyro is good
    eager = {"ekf_magnetometer": 5e-6, "ekf_gyro_noise": 5e-3}
    for estimator, settings in (("ekf", eager), ("complementary", {"complementary_kp": 2.0})):
        with case(estimator):
            added = 1.5e-6
            session = flown(
                AT + 12.0,
                failing(magnetometer_disturbance_x=added),
                estimator=estimator,
                settings=settings,
            )
            flight = session.recording()
            off = heading(flight.estimate[:, :4]) - heading(flight.q_WB)
            wanted = math.atan2(north, east) - math.atan2(north, east + added)
            assert off[-1] == pytest.approx(wanted, abs=0.3 * abs(wanted))
    with case("far off"):
        session = flown(AT + 8.0, failing(magnetometer_disturbance_x=4e-5))
        flight = session.recording()
        off = heading(flight.estimate[:, :4]) - heading(flight.q_WB)
        assert np.abs(off).max() < 0.02
        assert session.snapshot().reason is Reason.HEADING_DRIFTS
        first = flight.time[np.argmax(flight.reason == Reason.HEADING_DRIFTS)]
        assert 2.0 <= first - AT <= 2.3
