"""MAVLink's messages: the signals that each has, in the workbench's names, axes and units.

MAVLink's axes are north, east, down and forward, right, down.

Source: mavlink.io/en/messages/common.html.
"""

from collections.abc import Callable

import numpy as np

from workbench.common.quantity import RPM_IN_RAD_S
from workbench.extras.flightdata.readers.axes import (
    enu,
    flu,
    quaternion_in_enu,
    quaternion_of_angles,
)
from workbench.extras.flightdata.readers.topic_log import (
    ColumnConversion,
    SignalRow,
    attitude_rows,
    scaled,
)
from workbench.extras.flightdata.readers.ulog_topics import east_of_north, item_names
from workbench.extras.flightdata.readers.units import STANDARD_GRAVITY
from workbench.logs.logged_signal import ACCELEROMETER_SIGNALS, GYRO_SIGNALS, component_names
from workbench.logs.readers.rotations import EULER_ANGLE_NAMES
from workbench.plant.geodesy import point_in_world
from workbench.plant.home import Home

MILLI_GRAVITY = 1e-3 * STANDARD_GRAVITY
"""Unit of the accelerations of SCALED_IMU [m/s^2]."""
UNKNOWN_VOLTAGE_MV = 65535.0
CELL_FIELDS, MORE_CELL_FIELDS = item_names("voltages", 10), item_names("voltages_ext", 4)
_ACC_FIELDS, _GYRO_FIELDS = ("xacc", "yacc", "zacc"), ("xgyro", "ygyro", "zgyro")
_RATE_FIELDS = ("rollspeed", "pitchspeed", "yawspeed")
_GLOBAL, _TARGET, _WANTED = "GLOBAL_POSITION_INT", "ATTITUDE_TARGET", "POSITION_TARGET_LOCAL_NED"


def _wanted(convert: ColumnConversion, *ignored: int) -> ColumnConversion:
    """Return a conversion of fields followed by a mask, whose bits say which ones to ignore."""

    def converted(values: np.ndarray) -> np.ndarray:
        mask = values[:, -1:].astype(np.int64) & np.array(ignored)
        return convert(np.where(mask != 0, np.nan, values[:, :-1]))

    return converted


def _point_east_north_up(values: np.ndarray) -> np.ndarray:
    """Return positions (n, 3) from the first one [m], of degrees north and east [1e-7], heights
    above home [mm] and altitudes [mm]; NaN before the first fix.
    """
    degrees, height, altitude = 1e-7 * values[:, :2], 1e-3 * values[:, 2], 1e-3 * values[:, 3]
    fixed = (degrees != 0.0).any(axis=1)
    found = np.full((len(values), 3), np.nan)
    if fixed.any():
        north, east = np.radians(degrees[fixed]).T
        home = Home(float(north[0]), float(east[0]), float((altitude - height)[fixed][0]))
        x, y, _ = point_in_world(north, east, altitude[fixed], home)
        found[fixed] = np.column_stack([x, y, height[fixed]])
    return found


def _pack_voltage(values: np.ndarray) -> np.ndarray:
    """Return the voltage of a battery [V] (n, 1) from those of its cells [mV]; NaN if unknown."""
    total = np.where(values == UNKNOWN_VOLTAGE_MV, 0.0, values).sum(axis=1, keepdims=True)
    return np.where(total > 0.0, 1e-3 * total, np.nan)


def _known(factor: float, is_known: Callable[[np.ndarray], np.ndarray]) -> ColumnConversion:
    return lambda values: np.where(is_known(values), factor * values, np.nan)


def _imu_rows(topic: str, acc: float, gyro: float) -> list[SignalRow]:
    """Return the rows of an IMU with its units."""
    return [
        SignalRow(topic, _ACC_FIELDS, ACCELEROMETER_SIGNALS, "m/s^2", lambda v: acc * flu(v)),
        SignalRow(topic, _GYRO_FIELDS, GYRO_SIGNALS, "rad/s", lambda v: gyro * flu(v)),
    ]


def battery_rows(topic: str) -> list[SignalRow]:
    """Return the rows of a battery, a message BATTERY_STATUS or SYS_STATUS."""
    voltage, current = ("battery.voltage",), ("battery.current",)
    in_ampere = _known(1e-2, lambda v: v >= 0.0)
    return [
        SignalRow(topic, (*CELL_FIELDS, *MORE_CELL_FIELDS), voltage, "V", _pack_voltage),
        SignalRow(topic, CELL_FIELDS, voltage, "V", _pack_voltage),
        SignalRow(topic, ("voltage_battery",), voltage, "V", _pack_voltage),
        SignalRow(topic, ("current_battery",), current, "A", in_ampere),
    ]


MAVLINK_SIGNAL_ROWS = (
    *attitude_rows("ATTITUDE_QUATERNION", ("q1", "q2", "q3", "q4"), "estimate", quaternion_in_enu),
    *attitude_rows("ATTITUDE", EULER_ANGLE_NAMES, "estimate", quaternion_of_angles),
    SignalRow("ATTITUDE_QUATERNION", _RATE_FIELDS, component_names("estimate.w_"), "rad/s", flu),
    SignalRow("ATTITUDE", _RATE_FIELDS, component_names("estimate.w_"), "rad/s", flu),
    SignalRow("LOCAL_POSITION_NED", tuple("xyz"), component_names("estimate."), "m", enu),
    SignalRow("LOCAL_POSITION_NED", ("vx", "vy", "vz"), component_names("estimate.v_"), "m/s", enu),
    SignalRow(
        _GLOBAL,
        ("lat", "lon", "relative_alt", "alt"),
        component_names("estimate."),
        "m",
        _point_east_north_up,
    ),
    SignalRow(
        _GLOBAL,
        ("vx", "vy", "vz"),
        component_names("estimate.v_"),
        "m/s",
        lambda v: 1e-2 * enu(v),
    ),
    *_imu_rows("HIGHRES_IMU", 1.0, 1.0),
    *_imu_rows("SCALED_IMU", MILLI_GRAVITY, 1e-3),
    *attitude_rows(
        _TARGET,
        (*item_names("q", 4), "type_mask"),
        "attitude_setpoint",
        _wanted(quaternion_in_enu, 128, 128, 128, 128),
    ),
    SignalRow(
        _TARGET,
        ("body_roll_rate", "body_pitch_rate", "body_yaw_rate", "type_mask"),
        component_names("rate_setpoint.w_"),
        "rad/s",
        _wanted(flu, 1, 2, 4),
    ),
    SignalRow(
        _TARGET, ("thrust", "type_mask"), ("attitude_setpoint.thrust",), "1", _wanted(scaled(1), 64)
    ),
    SignalRow(
        _WANTED, (*"xyz", "type_mask"), component_names("setpoint."), "m", _wanted(enu, 1, 2, 4)
    ),
    SignalRow(
        _WANTED,
        ("vx", "vy", "vz", "type_mask"),
        component_names("setpoint.v_"),
        "m/s",
        _wanted(enu, 8, 16, 32),
    ),
    SignalRow(
        _WANTED, ("yaw", "type_mask"), ("setpoint.yaw",), "rad", _wanted(east_of_north, 1024)
    ),
    *(
        SignalRow(
            f"ESC_TELEMETRY_{first}_TO_{first + 3}",
            (f"rpm[{i}]",),
            (f"rotors.speed.{first - 1 + i}",),
            "rad/s",
            scaled(RPM_IN_RAD_S),
        )
        for first in (1, 5, 9)
        for i in range(4)
    ),
)
"""Signals of MAVLink's messages, the best ones first."""
RAW_IMU_ROWS = _imu_rows("RAW_IMU", MILLI_GRAVITY, 1e-3)
"""Signals of RAW_IMU as ArduPilot sends it; MAVLink leaves its units open."""
