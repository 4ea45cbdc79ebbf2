"""Telemetry logs of MAVLink, from files that `tlog_writer` writes after the published definitions.

The truth of signs and units is worked out by hand: north, east, down to east, north, up, and
forward, right, down to forward, left, up.
"""

import struct
from collections.abc import Sequence

import numpy as np
import pytest

from tests.extras.flightdata import tlog_writer as wire
from tests.extras.flightdata.foreign_files import read_here
from tests.extras.flightdata.tlog_writer import frame, tlog
from workbench.common.errors import WorkbenchError
from workbench.extras.flightdata.readers.tlog_topics import MAVLINK_SIGNAL_ROWS
from workbench.logs.flight_reader import read_flight

mavlink = pytest.importorskip("pymavlink.dialects.v20.common")
pytestmark = pytest.mark.usefixtures("unheld")

UNIX_US = 1_700_000_000_000_000
PX4, ARDUPILOT, QUADROTOR, STATION = 12, 3, 2, 6
CELLS_MV = (4100, 4000, 3900, *[65535] * 7)


def heartbeat(autopilot: int, kind: int = QUADROTOR, armed: bool = True) -> Sequence[wire.Value]:
    return (5, kind, autopilot, 128 * armed + 1, 4, 3)


def parameter(name: str, value: float, kind: int = 9) -> Sequence[wire.Value]:
    return (value, 100, 0, name, kind)


def every_10_ms(
    messages: Sequence[tuple[wire.Definition, Sequence[wire.Value]]], count: int = 20
) -> list[tuple[int, bytes]]:
    """Return frames of messages; their first value is the time since boot, 5 s at the first."""
    found = []
    for i in range(count):
        for what, (unit, *values) in messages:
            own = [] if unit is None else [5 * unit + i * unit // 100]
            found.append((UNIX_US + 10_000 * i, frame(what, [*own, *values])))
    return found


NO_MOTORS = ("the motors' commands were not logged",)
MS, US = 1000, 1_000_000
QUATERNION = (np.cos(0.1), np.sin(0.1), 0.0, 0.0)
"""A roll of 0.2 rad, heading north."""
MOTION = (
    # message; unit of its time and values; values of signals, by hand
    (
        wire.ATTITUDE,
        (MS, 0.2, 0.1, 0.5, 1.0, 2.0, 3.0),
        {
            "estimate.roll": 0.2,
            "estimate.pitch": -0.1,
            "estimate.yaw": 0.5 * np.pi - 0.5,
            "estimate.w_x": 1.0,
            "estimate.w_y": -2.0,
            "estimate.w_z": -3.0,
        },
    ),
    (
        wire.ATTITUDE_QUATERNION,
        (MS, *QUATERNION, 1.0, 2.0, 3.0),
        {"estimate.roll": 0.2, "estimate.pitch": 0.0, "estimate.yaw": 0.5 * np.pi},
    ),
    (
        wire.LOCAL_POSITION_NED,
        (MS, 1.0, 2.0, -3.0, 4.0, 5.0, 6.0),
        {
            "estimate.x": 2.0,
            "estimate.y": 1.0,
            "estimate.z": 3.0,
            "estimate.v_x": 5.0,
            "estimate.v_y": 4.0,
            "estimate.v_z": -6.0,
        },
    ),
    (
        wire.GLOBAL_POSITION_INT,
        (MS, 473977420, 85455940, 500_000, 12_000, 100, 200, -300, 9000),
        {"estimate.z": 12.0, "estimate.v_x": 2.0, "estimate.v_y": 1.0, "estimate.v_z": 3.0},
    ),
    (
        wire.HIGHRES_IMU,
        (US, 1.0, 2.0, -9.8, 0.1, 0.2, 0.3, *[0.0] * 7, 63),
        {
            "imu.linear_acceleration.x": 1.0,
            "imu.linear_acceleration.y": -2.0,
            "imu.linear_acceleration.z": 9.8,
            "imu.angular_velocity.y": -0.2,
        },
    ),
    (
        wire.SCALED_IMU,
        (MS, 100, 200, -1000, 10, 20, 30, 0, 0, 0),
        {"imu.linear_acceleration.z": 9.80665, "imu.angular_velocity.z": -0.03},
    ),
    (
        wire.ATTITUDE_TARGET,
        (MS, *QUATERNION, 1.0, 2.0, 3.0, 0.6, 2),
        {
            "attitude_setpoint.roll": 0.2,
            "attitude_setpoint.thrust": 0.6,
            "rate_setpoint.w_x": 1.0,
            "rate_setpoint.w_y": None,  # the mask says to ignore it
            "rate_setpoint.w_z": -3.0,
        },
    ),
    (
        wire.POSITION_TARGET_LOCAL_NED,
        (MS, 1.0, 2.0, -3.0, 4.0, 5.0, 6.0, 0.0, 0.0, 0.0, 0.5, 0.0, 8 + 1024, 1),
        {
            "setpoint.x": 2.0,
            "setpoint.y": 1.0,
            "setpoint.z": 3.0,
            "setpoint.v_x": 5.0,
            "setpoint.v_y": None,
            "setpoint.v_z": -6.0,
            "setpoint.yaw": None,
        },
    ),
    (
        wire.BATTERY_STATUS,
        (None, 0, 0, 0, *CELLS_MV, 1234, 0, 0, 0, 50),
        {"battery.voltage": 12.0, "battery.current": 12.34},
    ),
    (
        wire.SYS_STATUS,
        (None, 0, 0, 0, 0, 11_100, -1, 0, 0, 0, 0, 0, 0, 80),
        {"battery.voltage": 11.1, "battery.current": None},
    ),
    *(
        (
            what,
            (*[0] * 12, 3000, 6000, 9000, 12_000, *[0] * 8),
            {f"rotors.speed.{first + i}": (i + 1) * 100.0 * np.pi for i in range(4)},
        )
        for what, first in ((wire.ESC_TELEMETRY_1_TO_4, 0), (wire.ESC_TELEMETRY_5_TO_8, 4))
    ),
)


def test_messages_become_signals_with_our_axes_and_units(tmp_path, case):
    path = tmp_path / "a.tlog"
    for what, values, signals in MOTION:
        with case(what):
            beats = every_10_ms([(wire.HEARTBEAT, (None, *heartbeat(PX4)))], 1)
            path.write_bytes(tlog([*beats, *every_10_ms([(what, values)])]))
            flight = read_here(path)
            for name, value in signals.items():
                if value is None:
                    assert name not in flight
                else:
                    np.testing.assert_allclose(flight[name].values, value, rtol=2e-5, atol=1e-6)
                    assert len(flight[name].time) == 20
                    assert flight[name].rate == pytest.approx(100.0)


def test_positions_on_the_earth_are_from_the_first_fix_on(tmp_path):
    """One degree of latitude at 47.4° is 111,181 m on WGS84, one of longitude 75,499 m."""
    found = []
    for i, (north, east) in enumerate([(0, 0), (474000000, 85000000), (474010000, 85020000)]):
        values = (1000 + 10 * i, north, east, 500_000, 7000, 0, 0, 0, 0)
        found.append((UNIX_US + 10_000 * i, frame(wire.GLOBAL_POSITION_INT, values)))
    path = tmp_path / "a.tlog"
    path.write_bytes(tlog(found))
    flight = read_here(path)
    east, north = (flight[f"estimate.{axis}"].values for axis in "xy")
    np.testing.assert_allclose(east, [0.0, 151.0], atol=0.05)
    np.testing.assert_allclose(north, [0.0, 111.18], atol=0.01)


def test_motors_are_channels_by_function_of_ardupilot_and_moving_outputs_of_px4(tmp_path):
    """Motor 1 is on channel 3; PX4's second output never moves."""
    parameters = {"SERVO3_FUNCTION": 33.0, "SERVO1_FUNCTION": 34.0, "MOT_PWM_MIN": 1100.0}
    parameters["MOT_PWM_MAX"] = 1900.0
    frames = [(UNIX_US, frame(wire.HEARTBEAT, heartbeat(ARDUPILOT)))]
    frames += [(UNIX_US, frame(wire.PARAM_VALUE, parameter(*each))) for each in parameters.items()]
    outputs = (US, 1300, 0, 1700, 0, 0, 0, 0, 0, 0)
    imu = (US, 0, 0, -1000, 500, 0, 0, 0, 0, 0)
    path = tmp_path / "a.tlog"
    both = [(wire.SERVO_OUTPUT_RAW, outputs), (wire.RAW_IMU, imu)]
    path.write_bytes(tlog([*frames, *every_10_ms(both)]))
    flight = read_here(path)
    np.testing.assert_allclose(flight["motors.command_1"].values, 0.75)
    np.testing.assert_allclose(flight["motors.command_2"].values, 0.25)
    np.testing.assert_allclose(flight["imu.angular_velocity.x"].values, 0.5)
    assert flight.firmware == "ArduCopter" and flight.parameters["MOT_PWM_MAX"] == 1900.0
    frames = [(UNIX_US, frame(wire.HEARTBEAT, heartbeat(PX4)))]
    for i in range(20):
        values = [5 * US + 10_000 * i, 3, 1200 + 10 * i, 1500, 1900 - 10 * i, *[0.0] * 29]
        frames.append((UNIX_US + 10_000 * i, frame(wire.ACTUATOR_OUTPUT_STATUS, values)))
    path.write_bytes(tlog(frames))
    flight = read_here(path)
    assert flight.motors("motors.command_") == ["motors.command_1", "motors.command_3"]
    np.testing.assert_allclose(flight["motors.command_3"].values, 0.9 - 0.01 * np.arange(20))


def test_the_clock_is_that_of_the_vehicle(tmp_path, case):
    """Late arrivals do not move samples; counters overflow; a restart leaves the true pause."""
    late = np.array([0, 900_000, 800_000, 100_000, 5000] * 20)

    def times(boot_ms: np.ndarray, arrival_us: np.ndarray) -> np.ndarray:
        frames = [
            (UNIX_US + int(at), frame(wire.ATTITUDE, (ms % 2**32, 0.001 * i, 0, 0, 0, 0, 0)))
            for i, (ms, at) in enumerate(zip(boot_ms.tolist(), arrival_us.tolist(), strict=True))
        ]
        path = tmp_path / "a.tlog"
        path.write_bytes(tlog(frames))
        flight = read_here(path)
        assert flight.remarks == NO_MOTORS
        return flight["estimate.roll"].time

    even = 100 * np.arange(100)
    behind = 1000 * even + 900_000 * (even > 5000)
    restarted = np.concatenate([50_000 + even[:50], 700 + even[:50]])
    arrival = np.concatenate([1000 * even[:50], 1000 * even[:50] + 9_000_000])
    for name, boot, arrived, expected in (
        ("late", 5000 + even, 1000 * even + late, 0.1 * np.arange(100)),
        ("overflow", 2**32 - 5030 + even, 1000 * even + late, 0.1 * np.arange(100)),
        ("overflow, late from there on", 2**32 - 5030 + even, behind, 0.1 * np.arange(100)),
        ("restart", restarted, arrival, 1e-6 * arrival),
        ("restart, late before it", restarted, arrival + late * (arrival < 9e6), 1e-6 * arrival),
        ("ground clock set back", 5000 + even, 1000 * even - 10**9 * (even > 5000), None),
    ):
        with case(name):
            found = times(boot, arrived)
            if expected is None:
                np.testing.assert_allclose(np.diff(found), 0.1, atol=1e-6)
            else:
                np.testing.assert_allclose(found, expected, atol=1e-3)


def test_a_copter_says_what_it_is_after_its_start_and_has_one_first_battery(tmp_path):
    """The first battery measures no current, so the flight has none; -1 says so."""
    said = [(6, "ArduPilot Ready"), (6, "ArduCopter V4.5.7 (2a3dc4b7)")]
    frames = [(UNIX_US, frame(wire.HEARTBEAT, heartbeat(ARDUPILOT)))]
    frames += [(UNIX_US, frame(wire.STATUSTEXT, each)) for each in said]
    first, second = (0, 0, 0, *CELLS_MV, -1, 0, 0, 0, 50), (0, 0, 0, *CELLS_MV, 990, 1, 0, 0, 50)
    both = [(wire.BATTERY_STATUS, (None, *each)) for each in (first, second)]
    path = tmp_path / "a.tlog"
    path.write_bytes(tlog([*frames, *every_10_ms(both)]))
    flight = read_here(path)
    assert flight.firmware == "ArduCopter V4.5.7 (2a3dc4b7)"
    np.testing.assert_allclose(flight["battery.voltage"].values, 12.0)
    assert "battery.current" not in flight
    assert any("battery.current are those of BATTERY_STATUS;" in each for each in flight.remarks)


def test_other_times_of_a_message_are_on_the_same_clock(tmp_path):
    """Microseconds of 32 bits that overflow, of 64 bits, since 1970, and no time at all."""
    frames = []
    for i in range(50):
        at, us = UNIX_US + 20_000 * i, 2**32 - 500_000 + 20_000 * i
        attitude = (us // 1000, 0.001 * i, *[0.0] * 5)
        outputs = ((us + 3000) % 2**32, 1000 + i, *[0] * 8)
        imu = (us + 4000, 0.01 * i, *[0.0] * 12, 63)
        status = (0, 0, 0, 0, 11_000 + i, 100, *[0] * 7)
        frames += [
            (at, frame(wire.ATTITUDE, attitude)),
            (at + 1000, frame(wire.SERVO_OUTPUT_RAW, outputs)),
            (at + 2000, frame(wire.HIGHRES_IMU, imu)),
            (at + 5000, frame(wire.SYS_STATUS, status)),
            (at + 6000, frame(wire.RAW_IMU, (at, i, *[0] * 8))),
        ]
    path = tmp_path / "a.tlog"
    path.write_bytes(tlog(frames))
    flight = read_here(path)
    period = 0.02 * np.arange(50)
    for name, begin in (
        ("estimate.roll", 0.0),
        ("servo_output_raw.servo1_raw", 0.003),
        ("imu.linear_acceleration.x", 0.004),
        ("battery.voltage", 0.005),
        ("raw_imu.xacc", 0.006),
    ):
        np.testing.assert_allclose(flight[name].time, begin + period, atol=1.1e-3, err_msg=name)


def test_each_vehicle_is_a_log_and_ground_stations_are_none(tmp_path):
    frames = []
    for i in range(100):
        at, ms = UNIX_US + 20_000 * i, 5000 + 20 * i
        frames.append((at, frame(wire.HEARTBEAT, heartbeat(8, STATION), system=255)))
        for system, roll in ((1, 0.1), (7, 0.7)):
            if system == 7 and i >= 50:
                continue
            body = (ms, roll, 0, 0, 0, 0, 0)
            frames.append((at, frame(wire.HEARTBEAT, heartbeat(PX4), system=system)))
            frames.append((at, frame(wire.ATTITUDE, body, system=system)))
            gimbal = (40_000 + 20 * i, -roll, 0, 0, 0, 0, 0)
            frames.append((at, frame(wire.ATTITUDE, gimbal, system=system, component=154)))
    path = tmp_path / "a.tlog"
    path.write_bytes(tlog(frames))
    flight = read_flight(path)
    assert flight["estimate.roll"].values.max() == pytest.approx(0.1)
    assert flight["attitude_154.roll"].values.max() == pytest.approx(-0.1)
    np.testing.assert_allclose(flight.logs, [1.98, 0.98], atol=1e-3)
    other = read_flight(path, log_number=2)
    assert other["estimate.roll"].values.max() == pytest.approx(0.7)
    with pytest.raises(WorkbenchError, match="has 2 logs: --log-number 3"):
        read_flight(path, log_number=3)


def test_versions_signatures_and_damage(tmp_path):
    """A log without the usual ending of its name; frames of version 1, signed, unknown, cut."""
    frames = [
        (
            UNIX_US + 10_000 * i,
            frame(
                wire.ATTITUDE,
                (1000 + 10 * i, 0.001 * i, 0, 0, 0, 0, 0),
                version=1 + i % 2,
                signed=i % 4 == 1,
            ),
        )
        for i in range(40)
    ]
    unknown = wire.Definition(59_999, 0, "f")
    frames.insert(20, (UNIX_US, frame(unknown, (1.0,))))
    path = tmp_path / "flight"
    path.write_bytes(tlog(frames))
    flight = read_flight(path)
    assert len(flight["estimate.roll"].time) == 40 and flight.remarks == NO_MOTORS
    parts = [tlog([each]) for each in frames]
    wrong = bytearray(parts[10])
    wrong[20] ^= 1
    parts[10] = bytes(wrong)
    parts[30] = b"\xfd\xfe noise \xfd" + parts[30]
    path.write_bytes(b"".join(parts)[:-3])
    flight = read_flight(path)
    assert len(flight["estimate.roll"].time) == 38
    lost = len(wrong) + 10 + len(parts[-1]) - 3
    assert [each for each in flight.remarks if "damaged" in each] == [
        f"the file is damaged: {lost} bytes are no messages, the first one is byte "
        f"{sum(map(len, parts[:10]))}"
    ]
    path = tmp_path / "a.tlog"
    path.write_bytes(struct.pack(">Q", UNIX_US) + b"\xfd" + bytes(500))
    with pytest.raises(WorkbenchError, match="has no message of a vehicle"):
        read_flight(path)


def test_what_a_mask_leaves_out_is_unknown_and_nothing_else(case):
    """A bit of north leaves out our y, one of east our x."""
    masks = {
        ("ATTITUDE_TARGET", "rate_setpoint.w_x"): "ATTITUDE_TARGET_TYPEMASK_BODY_ROLL_RATE_IGNORE",
        ("ATTITUDE_TARGET", "rate_setpoint.w_y"): "ATTITUDE_TARGET_TYPEMASK_BODY_PITCH_RATE_IGNORE",
        ("ATTITUDE_TARGET", "rate_setpoint.w_z"): "ATTITUDE_TARGET_TYPEMASK_BODY_YAW_RATE_IGNORE",
        ("ATTITUDE_TARGET", "attitude_setpoint.thrust"): "ATTITUDE_TARGET_TYPEMASK_THROTTLE_IGNORE",
        ("POSITION_TARGET_LOCAL_NED", "setpoint.x"): "POSITION_TARGET_TYPEMASK_Y_IGNORE",
        ("POSITION_TARGET_LOCAL_NED", "setpoint.y"): "POSITION_TARGET_TYPEMASK_X_IGNORE",
        ("POSITION_TARGET_LOCAL_NED", "setpoint.z"): "POSITION_TARGET_TYPEMASK_Z_IGNORE",
        ("POSITION_TARGET_LOCAL_NED", "setpoint.v_x"): "POSITION_TARGET_TYPEMASK_VY_IGNORE",
        ("POSITION_TARGET_LOCAL_NED", "setpoint.v_y"): "POSITION_TARGET_TYPEMASK_VX_IGNORE",
        ("POSITION_TARGET_LOCAL_NED", "setpoint.v_z"): "POSITION_TARGET_TYPEMASK_VZ_IGNORE",
        ("POSITION_TARGET_LOCAL_NED", "setpoint.yaw"): "POSITION_TARGET_TYPEMASK_YAW_IGNORE",
    }
    for (topic, name), bit in masks.items():
        (row,) = [r for r in MAVLINK_SIGNAL_ROWS if r.topic == topic and name in r.names]
        bits = [getattr(mavlink, each) for (of, _), each in masks.items() if of == topic]
        table = np.array([[*np.ones(len(row.fields) - 1), each] for each in bits])
        unknown = np.isnan(row.convert(table)[:, row.names.index(name)])
        with case(name):
            assert unknown.tolist() == [each == getattr(mavlink, bit) for each in bits]
