"""A log as identify takes it, from records that are made here."""

import dataclasses
from pathlib import Path

import numpy as np
import pytest

from workbench.common.errors import WorkbenchError
from workbench.common.flight import Flight
from workbench.common.series import make_series
from workbench.extras.flightdata.identify.measured import combined_cutoff, measured_flight
from workbench.logs.logged_signal import ACCELEROMETER_SIGNALS, GYRO_SIGNALS

TIME = np.arange(0.0, 20.0, 0.004)
MOTORS = tuple(f"motors.command_{i}" for i in (1, 2, 3, 4))


def record(motors=TIME, **more) -> Flight:
    """Return a flight whose command to motor i is i / 10 and rises, with signals that are given."""
    values = {name: (TIME, 0.0 * TIME) for name in (*GYRO_SIGNALS, *ACCELEROMETER_SIGNALS)} | {
        name: (motors, 0.1 * (i + 1) + 0.001 * motors) for i, name in enumerate(MOTORS)
    }
    values |= more
    signals = {name: make_series(name, "", *each, end=20.0) for name, each in values.items()}
    return Flight("made up", Path("made.up"), "made up", signals, end=20.0)


def bad(flight):
    """Return begin and end of the only time away from the ends at which a flight is not good."""
    rows = np.flatnonzero((flight.time > 2.0) & (flight.time < 18.0) & ~flight.good)
    np.testing.assert_array_equal(np.diff(rows), 1)
    return flight.time[rows[[0, -1]]]


def test_commands_hold_between_samples_and_are_not_known_in_gaps():
    """Motors at 125 Hz, of which those from 8.0 to 8.5 s are lost, and one at 12.008 s."""
    motors = 0.008 * np.arange(2500)
    lost = (np.arange(2500) > 1000) & (np.arange(2500) < 1062)
    lost[1501] = True
    flight = measured_flight(record(motors[~lost]), 4)
    assert bad(flight) == pytest.approx([8.004, 8.492])
    for when, last in ((5.004, 5.0), (5.008, 5.008), (8.4, 8.0), (12.012, 12.0)):
        row = np.argmin(np.abs(flight.time - when))
        expected = np.array([0.1, 0.2, 0.3, 0.4]) + 0.001 * last
        np.testing.assert_allclose(flight.commands[row], expected, atol=1e-12)


def test_an_impact_and_a_tumble_are_left_out_with_a_second_around_them(case):
    """One sample at 10 s, 18 rad/s about an axis or 31 m/s²; 16 rad/s and 29 m/s² are flight."""
    once = np.abs(TIME - 10.0) < 1e-6
    for names, size in ((GYRO_SIGNALS, 18.0), (ACCELEROMETER_SIGNALS, 31.0)):
        with case(names[1]):
            hit = measured_flight(record(**{names[1]: (TIME, size * once)}), 4)
            assert bad(hit) == pytest.approx([9.0, 11.0], abs=0.005)
            flight = measured_flight(record(**{names[1]: (TIME, (size - 2.0) * once)}), 4)
            assert flight.good[(flight.time > 2.0) & (flight.time < 18.0)].all()


def test_motors_are_in_the_order_that_is_given():
    flight = measured_flight(record(), 4, order=(3, 1, 4, 2))
    np.testing.assert_allclose(flight.commands[0], [0.3, 0.1, 0.4, 0.2], atol=1e-9)


def test_a_log_of_more_motors_than_rotors_is_refused():
    """The first four of a hexacopter's six would give any thrust and inertia."""
    six = record(**{f"motors.command_{i}": (TIME, 0.1 * i + 0.0 * TIME) for i in (5, 6)})
    with pytest.raises(WorkbenchError, match=r"6 motors, and the model has 4 .* --order 1,2,3,4"):
        measured_flight(six, 4)
    flight = measured_flight(six, 4, order=(4, 3, 2, 1))
    np.testing.assert_allclose(flight.commands[0], [0.4, 0.3, 0.2, 0.1], atol=1e-9)


def test_velocity_is_in_the_bodys_axes(case):
    """Flying east: to its right with the nose north, and with its top ahead if that is down."""
    half = np.sqrt(0.5)
    for name, q, expected in (
        ("north", (half, 0.0, 0.0, half), (0.0, -2.0, 0.0)),
        ("down", (half, 0.0, half, 0.0), (0.0, 0.0, 2.0)),
    ):
        with case(name):
            whose = dict(zip((f"estimate.q_{part}" for part in "wxyz"), q, strict=True))
            whose |= {"estimate.v_x": 2.0, "estimate.v_y": 0.0, "estimate.v_z": 0.0}
            flight = measured_flight(
                record(**{each: (TIME, value + 0.0 * TIME) for each, value in whose.items()}), 4
            )
            np.testing.assert_allclose(flight.velocity[1000], expected, atol=1e-12)


def test_a_gap_of_the_gyro_is_not_bridged(case):
    for name in (GYRO_SIGNALS[1], ACCELEROMETER_SIGNALS[2]):
        with case(name):
            lost = (TIME > 10.0) & (TIME < 10.5)
            flight = measured_flight(record(**{name: (TIME[~lost], 0.0 * TIME[~lost])}), 4)
            assert bad(flight) == pytest.approx([10.004, 10.496])


def test_without_an_attitude_a_velocity_is_not_known_in_the_bodys_axes(case):
    """Of gaps of 0.5 s, in the velocity and in the quaternion that turns it."""
    whose = {f"estimate.q_{part}": 0.5 + 0.0 * TIME for part in "wxyz"}
    whose |= {f"estimate.v_{axis}": 2.0 + 0.0 * TIME for axis in "xyz"}
    held = (TIME <= 10.0) | (TIME >= 10.5)
    for name in ("estimate.v_y", "estimate.q_z"):
        with case(name):
            signals = {each: (TIME, values) for each, values in whose.items()}
            signals[name] = (TIME[held], whose[name][held])
            assert bad(measured_flight(record(**signals), 4)) == pytest.approx([10.004, 10.496])


def test_low_passes_in_series_are_one_with_their_delays():
    """That of second order at f has the delay sqrt(2) / (2 pi f): delays add up."""
    assert combined_cutoff((30.0, 145.0)) == pytest.approx(1.0 / (1.0 / 30.0 + 1.0 / 145.0))
    assert combined_cutoff(()) == 0.0
    plain = record()
    crazyflie = dataclasses.replace(plain, firmware="Crazyflie 2025.02")
    for flight, force, gyro in (
        (plain, 0.0, 0.0),
        (crazyflie, combined_cutoff((30.0, 145.0)), 47.347),
    ):
        found = measured_flight(flight, 4)
        assert (found.force_lowpass, found.gyro_lowpass) == pytest.approx((force, gyro), rel=1e-4)
    assert measured_flight(crazyflie, 4, force_lowpass=0.0).force_lowpass == 0.0


def test_a_log_that_stays_on_the_ground_is_refused():
    """Its motors start at 2 s; 0.2 m is the least that counts as flight."""
    on = np.where(TIME < 2.0, 0.0, 0.5)
    motors = {name: (TIME, on) for name in MOTORS}
    for top, flies in ((0.15, False), (0.25, True)):
        height = (TIME, np.where(TIME < 2.0, 3.0, 3.0 + top * np.sin(np.minimum(TIME - 2.0, 1.5))))
        flight = record(**motors, **{"estimate.z": height})
        if flies:
            assert measured_flight(flight, 4).good.any()
        else:
            with pytest.raises(WorkbenchError, match="never leaves the ground"):
                measured_flight(flight, 4)
