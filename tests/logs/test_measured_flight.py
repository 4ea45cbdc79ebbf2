"""A log as identify takes it, from records that are made here."""

import dataclasses
from pathlib import Path

import numpy as np
import pytest

from workbench.common.errors import WorkbenchError
from workbench.logs.flight_record import FORCE, GYRO, FlightRecord, make_signal
from workbench.logs.measured_flight import in_series, measured_flight

TIME = np.arange(0.0, 20.0, 0.004)
MOTORS = tuple(f"motors.command_{i}" for i in (1, 2, 3, 4))


def record(motors=TIME, **more) -> FlightRecord:
    """Return a flight whose command to motor i is i / 10 and rises, with signals that are given."""
    values = {name: (TIME, 0.0 * TIME) for name in (*GYRO, *FORCE)} | {
        name: (motors, 0.1 * (i + 1) + 0.001 * motors) for i, name in enumerate(MOTORS)
    }
    values |= more
    signals = {name: make_signal(name, "", *each, end=20.0) for name, each in values.items()}
    return FlightRecord("made up", Path("made.up"), "made up", signals, end=20.0)


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


def test_motors_are_in_the_order_that_is_given():
    flight = measured_flight(record(), 4, order=(3, 1, 4, 2))
    np.testing.assert_allclose(flight.commands[0], [0.3, 0.1, 0.4, 0.2], atol=1e-9)


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
    for name in (GYRO[1], FORCE[2]):
        with case(name):
            lost = (TIME > 10.0) & (TIME < 10.5)
            flight = measured_flight(record(**{name: (TIME[~lost], 0.0 * TIME[~lost])}), 4)
            assert bad(flight) == pytest.approx([10.004, 10.496])


def test_low_passes_in_series_are_one_with_their_delays():
    """That of second order at f has the delay sqrt(2) / (2 pi f): delays add up."""
    assert in_series((30.0, 145.0)) == pytest.approx(1.0 / (1.0 / 30.0 + 1.0 / 145.0))
    assert in_series(()) == 0.0
    plain = record()
    crazyflie = dataclasses.replace(plain, firmware="Crazyflie 2025.02")
    for flight, force, gyro in ((plain, 0.0, 0.0), (crazyflie, in_series((30.0, 145.0)), 47.347)):
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
