"""What a log has, from records whose streams are late by known times."""

from pathlib import Path

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from workbench.common.flight import Flight
from workbench.common.series import make_series
from workbench.logs.flight_contents import contents_of_flight
from workbench.logs.logged_signal import ACCELEROMETER_SIGNALS, GYRO_SIGNALS, component_names

TIME = np.arange(0.0, 20.0, 0.004)
RATES, PHASES = np.random.default_rng(1).uniform(2.0, 12.0, (2, 3, 4))


def waves(time):
    """Return three smooth motions over time (N, 3)."""
    return np.sin(time[:, None, None] * RATES + PHASES).sum(axis=2)


def record(columns, time=TIME) -> Flight:
    """Return a record of signals by name, each with its own time or with that of all."""
    signals = {}
    for name, values in columns.items():
        when, what = values if isinstance(values, tuple) else (time, values)
        signals[name] = make_series(name, "", when, what, end=time[-1])
    return Flight("made up", Path("made.up"), "made up", signals, end=time[-1])


def test_an_offset_is_positive_where_the_second_stream_is_late(case):
    for first, second, later in (
        (component_names("attitude.w_"), GYRO_SIGNALS, "gyro"),
        (GYRO_SIGNALS, component_names("estimate.w_"), "estimated rate"),
        (component_names("position_data."), component_names("estimate."), "estimated position"),
        (component_names("velocity_data.v_"), component_names("estimate.v_"), "estimated velocity"),
    ):
        for late in (0.037, -0.021):
            with case(later, late):
                found = contents_of_flight(
                    record(
                        dict(zip(first, waves(TIME).T, strict=True))
                        | dict(zip(second, waves(TIME - late).T, strict=True))
                    )
                )
                (offset,) = found.offsets
                assert offset.later == later
                assert offset.offset == pytest.approx(late, abs=5e-4)
                assert offset.correlation > 0.99


@pytest.mark.parametrize("late", [0.03, -0.014])
def test_the_offset_of_an_attitude_is_that_of_its_rate(late):
    """The gyro tells the turn from one sample to the next, and the attitude comes late."""
    turn = Rotation.from_rotvec(0.3 * waves(TIME))
    gyro = (turn[:-1].inv() * turn[1:]).as_rotvec() / 0.004
    known = Rotation.from_rotvec(0.3 * waves(TIME - late)).as_quat(scalar_first=True)
    found = contents_of_flight(
        record(
            {
                name: (TIME[:-1] + 0.002, each)
                for name, each in zip(GYRO_SIGNALS, gyro.T, strict=True)
            }
            | dict(zip(component_names("estimate.q_", "wxyz"), known.T, strict=True))
        )
    )
    (offset,) = found.offsets
    assert offset.later == "rate of the estimated attitude"
    assert offset.offset == pytest.approx(late, abs=5e-4)


def test_motors_turn_for_as_long_as_they_were_measured():
    """On from 4 to 14 s, at full for the last second, and not logged from 6 to 8 s."""
    time = np.arange(0.0, 20.0, 0.01)
    on = (time >= 4.0) & (time < 14.0)
    command = np.where(on, np.where(time >= 13.0, 1.0, 0.5), 0.0)
    kept = (time <= 6.0) | (time >= 8.0)
    motors = {f"motors.command_{i}": (time[kept], command[kept]) for i in (1, 2, 3, 4)}
    found = contents_of_flight(
        record(motors | dict.fromkeys((*GYRO_SIGNALS, *ACCELEROMETER_SIGNALS), 0.0 * time), time)
    )
    assert found.turning == pytest.approx(8.0, abs=0.06)
    assert found.saturated == pytest.approx(1.0 / found.turning, rel=0.02)
    assert found.known_until == time[-1]
