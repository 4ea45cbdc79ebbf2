"""What is said of a sensor."""

import math
from dataclasses import replace

import pytest

from workbench.gui.home.sensor_state import SensorHealth, sensor_state
from workbench.plant.faults import Fault


def stated(view, kind="gps", **changes):
    """Return the state of a sensor whose status differs by some values."""
    statuses = tuple(
        replace(each, **changes) if each.kind == kind else each for each in view.snapshot.sensors
    )
    snapshot = replace(view.snapshot, sensors=statuses)
    return sensor_state(replace(view, snapshot=snapshot), snapshot, kind)


@pytest.fixture(scope="module")
def view(canned):
    return canned.views[-1]


def test_a_sensor_that_measures_is_good_and_has_a_calm_age(view):
    state = stated(view, age=0.032)
    assert state.health is SensorHealth.GOOD
    assert state.note == "under 50\N{NO-BREAK SPACE}ms old"
    assert state.advice == ""


def test_a_reading_older_than_three_periods_is_old_and_says_how_old(view):
    # 10 a second: three periods are 0.3 s, and 0.02 s more are allowed.
    assert stated(view, age=0.31, rate=10.0).health is SensorHealth.GOOD
    state = stated(view, age=1.25, rate=10.0)
    assert state.health is SensorHealth.OLD
    assert state.note == "old: 1.2\N{NO-BREAK SPACE}s"


def test_periods_are_those_that_come_and_before_any_those_that_are_asked_for(view):
    """A sensor that gives less than is asked for is slow, which is told elsewhere, not old."""
    for rate, asked, health in (
        (2.0, 10.0, SensorHealth.GOOD),
        (10.0, 2.0, SensorHealth.OLD),
        (0.0, 2.0, SensorHealth.GOOD),
        (0.0, 10.0, SensorHealth.OLD),
    ):
        assert stated(view, age=1.25, rate=rate, asked_rate=asked).health is health


def test_a_known_latency_makes_no_reading_old(view):
    scenario = replace(view.scenario, sensors=replace(view.scenario.sensors, latency={"gps": 1.0}))
    assert stated(replace(view, scenario=scenario), age=1.25, rate=10.0).health is SensorHealth.GOOD


def test_the_latency_of_a_sensor_of_that_name_counts_before_that_of_its_kind(view):
    for latency, health in (
        ({"gps": 0.0, "front_gps": 1.0}, SensorHealth.GOOD),
        ({"gps": 1.0, "front_gps": 0.0}, SensorHealth.OLD),
    ):
        sensors = replace(view.scenario.sensors, latency=latency)
        named = replace(view, scenario=replace(view.scenario, sensors=sensors))
        assert stated(named, name="front_gps", age=1.25, rate=10.0).health is health


def test_an_ordered_fault_is_named_with_its_cure(view):
    state = stated(view, fault=Fault.FROZEN, age=0.05)
    assert state.health is SensorHealth.FAULTY
    assert state.note == "frozen, 50\N{NO-BREAK SPACE}ms old"
    assert "gps_fault" in state.advice
    assert state.measures


def test_a_sensor_without_a_reading_waits(view):
    state = stated(view, age=math.inf)
    assert state.health is SensorHealth.WAITING
    assert not state.measures


def test_a_sensor_that_is_off_says_how_to_switch_it_on(view):
    snapshot = replace(view.snapshot, sensors=())
    state = sensor_state(replace(view, snapshot=snapshot), snapshot, "lidar")
    assert state.health is SensorHealth.OFF
    assert state.note == "off"
    assert "Settings" in state.advice


def test_the_imu_of_an_estimator_is_not_called_off(view):
    """It can be switched on all the same, to see its readings."""
    snapshot = replace(view.snapshot, sensors=())
    for estimator, kind, health, note in (
        ("ekf", "imu", SensorHealth.IN_USE, "read by the estimator"),
        ("truth", "imu", SensorHealth.OFF, "off"),
        ("ekf", "lidar", SensorHealth.OFF, "off"),
    ):
        scenario = replace(view.scenario, estimator=estimator)
        flown = replace(view, snapshot=snapshot, scenario=scenario)
        state = sensor_state(flown, snapshot, kind)
        assert (state.health, state.note) == (health, note)
        assert "Settings" in state.advice


def test_a_drone_without_such_a_sensor_says_so(view):
    vehicle = replace(view.vehicle, sensors=())
    snapshot = replace(view.snapshot, sensors=())
    state = sensor_state(replace(view, snapshot=snapshot, vehicle=vehicle), snapshot, "lidar")
    assert state.health is SensorHealth.ABSENT
    assert "no lidar" in state.advice
    absent = sensor_state(replace(view, snapshot=snapshot, vehicle=vehicle), snapshot, "gps")
    assert "no GPS in" in absent.advice
