"""The estimator in the diagram: when it counts, and what it takes its errors to be."""

import dataclasses

import numpy as np
import pytest

from workbench.common.resources import find_model
from workbench.control.controller_file import load_controller
from workbench.control.mode import FlightMode
from workbench.diagram.mounting import deviations_at_start, find_imu, mounting_of
from workbench.estimation.ekf import InitialDeviations
from workbench.estimation.ekf_state import ERRORS
from workbench.estimation.estimators import COVARIANCE_TRIANGLE, find_estimator
from workbench.estimation.settings import AIDING_SENSORS
from workbench.plant.home import DEFAULT_HOME
from workbench.plant.loading import load_vehicle
from workbench.plant.sensors import NO_NOISE
from workbench.systems import navigation as systems_navigation
from workbench.systems.navigation import AIDING_SAMPLE_SIZES, Navigation

PERIOD = 1 / 128
STRAIGHT = np.eye(3)


@pytest.fixture(scope="module")
def imu():
    return find_imu(load_vehicle(find_model("dh_drone")), True)


def navigation(imu, name="ekf", *, gps_repeats=False, turn_BM=STRAIGHT):
    return Navigation(
        estimator=find_estimator(name),
        settings=load_controller().table.defaults(),
        mounting=mounting_of(imu, (), DEFAULT_HOME),
        turn_BM=turn_BM,
        known=deviations_at_start(imu),
        home=DEFAULT_HOME,
        period=PERIOD,
        gps_repeats=gps_repeats,
    )


def begun(system, imu_reading):
    """Return a context that had its update at time 0, with samples of an IMU that stand."""
    context = system.CreateDefaultContext()
    system.GetInputPort("imu").FixValue(context, imu_reading)
    for name in AIDING_SENSORS:
        port = system.GetInputPort(name)
        port.FixValue(context, np.full(port.size(), np.nan))
    system.begin(context, np.array([1.0, *[0.0] * 12]), seed=3)
    later = context.Clone()
    after = system.EvalUniquePeriodicDiscreteUpdate(context)
    later.get_mutable_discrete_state().SetFrom(after)
    return later


def test_covariance_and_deviations_agree(imu):
    system = navigation(imu)
    context = begun(system, np.array([0.3, -0.2, 0.1, 0.5, 0.1, 9.8, 0.3, -0.2, 0.1]))
    context.SetTime(PERIOD)
    P = np.zeros((9, 9))
    P[COVARIANCE_TRIANGLE] = system.GetOutputPort("covariance").Eval(context)
    deviations = system.GetOutputPort("deviations").Eval(context)
    assert np.sqrt(np.diag(P)) == pytest.approx(deviations[:9])
    P = P + P.T - np.diag(np.diag(P))
    assert np.linalg.eigvalsh(P).min() > 0.0
    other = navigation(imu, "complementary")
    context = begun(other, np.zeros(9))
    for name, size in (("covariance", 45), ("deviations", ERRORS), ("innovations", 20)):
        assert np.isnan(other.GetOutputPort(name).Eval(context)).tolist() == [True] * size


def test_biases_at_the_start_are_those_of_the_description(imu):
    least = InitialDeviations()
    assert deviations_at_start(imu) == least  # the shipped one states none
    noise = dataclasses.replace(NO_NOISE, bias_mean=0.03, bias_stddev=0.04)
    stated = dataclasses.replace(
        imu,
        angular_velocity=(NO_NOISE, noise, NO_NOISE),
        linear_acceleration=(noise, NO_NOISE, NO_NOISE),
    )
    found = deviations_at_start(stated)
    assert found.gyro_bias == pytest.approx((least.gyro_bias**2 + 0.05**2) ** 0.5)
    assert found.accel_bias == pytest.approx((least.accel_bias**2 + 0.05**2) ** 0.5)
    assert found[:3] == least[:3]


def test_equal_samples_of_the_gps_count_where_nothing_moves_and_as_none_in_the_air(imu, case):
    """Of two equal samples the second tells an innovation only where a sound GPS may repeat."""
    at_home = np.array([DEFAULT_HOME.latitude, DEFAULT_HOME.longitude, DEFAULT_HOME.altitude])
    for name, mode, turning, moved, rounds, wanted in (
        ("frozen", FlightMode.HOVERING, True, False, False, False),
        ("landing", FlightMode.LANDING, True, False, False, False),
        ("works", FlightMode.HOVERING, True, True, False, True),
        ("armed", FlightMode.ARMED, True, False, False, True),
        ("an exact flight without motion", FlightMode.HOVERING, False, False, False, True),
        ("one that rounds", FlightMode.HOVERING, True, False, True, True),
    ):
        with case(name):
            system = navigation(imu, gps_repeats=rounds)
            context = system.CreateDefaultContext()
            reading = np.array([0.0, 0.0, 0.0, 0.0, 0.0, 9.81, 0.0, 0.0, 0.0])
            for port in ("barometer", "magnetometer", "range_finder"):
                system.GetInputPort(port).FixValue(
                    context, np.full(AIDING_SAMPLE_SIZES[port], np.nan)
                )
            system.GetInputPort("mode").FixValue(context, [float(mode), *[0.0] * 9])
            system.begin(context, np.array([1.0, *[0.0] * 12]), seed=3)
            for update in range(3):
                context.SetTime(update * PERIOD)
                sample = np.array([update * PERIOD, *at_home, 0.0, 0.0, 0.0])
                sample[4] += 1e-12 * update * moved
                system.GetInputPort("gps").FixValue(context, sample)
                system.GetInputPort("imu").FixValue(context, reading + 1e-6 * update * turning)
                told = system.GetOutputPort("innovations").Eval(context)[:12]
                after = system.EvalUniquePeriodicDiscreteUpdate(context)
                assert np.isfinite(told).all() == (wanted or update == 0)
                context.get_mutable_discrete_state().SetFrom(after)
            age = system.GetOutputPort("health").Eval(context)[1]
            assert age == pytest.approx(0.0 if wanted else 2 * PERIOD)


def test_an_estimator_is_told_each_new_sample_once_with_its_age(imu, monkeypatch):
    """By hand, at half a second; the magnetometer's x is B's y, its y is B's -x."""
    told = []
    monkeypatch.setattr(
        systems_navigation,
        "checked_update",
        lambda estimator: lambda memory, samples, *rest: told.append((samples.copy(), rest[-1])),
    )
    system = navigation(imu, turn_BM=np.array([[0.0, -1.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, 1.0]]))
    context = system.CreateDefaultContext()
    home = (DEFAULT_HOME.latitude, DEFAULT_HOME.longitude, DEFAULT_HOME.altitude + 30.0)
    reading = np.arange(1.0, 10.0)
    for name, values in (
        ("imu", reading),
        ("gps", [0.4, *home, 1.0, 2.0, 3.0]),
        ("barometer", [0.45, 101325.0, 7.5]),
        ("magnetometer", [0.3, 1e-5, 2e-5, -4e-5]),
        ("range_finder", [0.48, 2.5]),
    ):
        system.GetInputPort(name).FixValue(context, values)
    system.begin(context, np.array([1.0, *[0.0] * 12]), seed=None)

    def update(time):
        context.SetTime(time)
        system.GetOutputPort("memory").Eval(context)
        after = system.EvalUniquePeriodicDiscreteUpdate(context)
        context.get_mutable_discrete_state().SetFrom(after)
        return told[-1]

    samples, dt = update(0.5)
    gps = [1.0, 0.1, 0.0, 0.0, 30.0, 1.0, 2.0, 3.0]
    others = [1.0, 7.5, 1.0, -2e-5, 1e-5, -4e-5, 1.0, 2.5]
    ages = [0.05, 0.2, 0.02]
    assert samples == pytest.approx([*reading[:6], *gps, *others, *ages], abs=1e-9)
    assert dt == PERIOD
    samples, _ = update(0.5 + PERIOD)
    assert samples == pytest.approx([*reading[:6], *[0.0] * 19]), "all are known"
    system.GetInputPort("range_finder").FixValue(context, [0.51, np.inf])
    samples, _ = update(0.5 + 2 * PERIOD)
    assert samples[6:] == pytest.approx([0.0] * 19), "nothing was in range"


def test_a_sample_beyond_the_gate_does_not_count(imu, case):
    """Of so many standard deviations to the north: its age then grows as if there were none."""
    gate = load_controller().table.defaults()["ekf_gate"]

    def told(turn):
        """Return the innovation to the north over its deviation, and the age of the GPS after."""
        system = navigation(imu)
        context = begun(system, np.array([0.0, 0.0, 0.0, 0.0, 0.0, 9.81, 0.0, 0.0, 0.0]))
        context.SetTime(PERIOD)
        place = (DEFAULT_HOME.latitude + turn, DEFAULT_HOME.longitude, DEFAULT_HOME.altitude)
        system.GetInputPort("gps").FixValue(context, [0.0, *place, 0.0, 0.0, 0.0])
        pairs = system.GetOutputPort("innovations").Eval(context).reshape(-1, 2)
        after = system.EvalUniquePeriodicDiscreteUpdate(context)
        context.get_mutable_discrete_state().SetFrom(after)
        age = system.GetOutputPort("health").Eval(context)[1]
        return pairs[1, 0] / np.sqrt(pairs[1, 1]), age

    begin, slope = told(0.0)[0], (told(1e-6)[0] - told(0.0)[0]) / 1e-6
    for deviations, age in ((0.9, 0.0), (-0.9, 0.0), (1.1, 2 * PERIOD), (-1.1, 2 * PERIOD)):
        with case(deviations):
            found = told((deviations * gate - begin) / slope)
            assert found == pytest.approx((deviations * gate, age), rel=1e-3)
