"""PX4's topics: the signals that each has, in the workbench's names, axes and units."""

import numpy as np

from workbench.extras.flightdata.readers.axes import (
    enu,
    flu,
    quaternion_in_enu,
    quaternion_of_angles,
)
from workbench.extras.flightdata.readers.topic_log import SignalRow, attitude_rows
from workbench.logs.logged_signal import ACCELEROMETER_SIGNALS, GYRO_SIGNALS, component_names
from workbench.logs.readers.rotations import EULER_ANGLE_NAMES


def east_of_north(yaw: np.ndarray) -> np.ndarray:
    """Return yaws counter-clockwise from east of headings clockwise from north [rad]."""
    east = 0.5 * np.pi - yaw
    return np.asarray(np.arctan2(np.sin(east), np.cos(east)))


def item_names(field: str, count: int = 3) -> list[str]:
    """Return the names of the items of an array."""
    return [f"{field}[{i}]" for i in range(count)]


def _rows_of_motion(source: str, place: str, speed: str, turn: str) -> list[SignalRow]:
    """Return the rows of the estimated or, with the suffix of such topics, the true motion."""
    local = f"vehicle_local_position{source}"
    own = (
        [SignalRow(local, ("ax", "ay", "az"), component_names(f"{place}.a_"), "m/s^2", enu)]
        if not source
        else []
    )
    rates = f"vehicle_angular_velocity{source}"
    return [
        SignalRow(
            local,
            ("x", "y", "z"),
            component_names(f"{place}."),
            "m",
            enu,
            ("xy_valid", "xy_valid", "z_valid"),
        ),
        SignalRow(
            local,
            ("vx", "vy", "vz"),
            component_names(f"{speed}.v_"),
            "m/s",
            enu,
            ("v_xy_valid", "v_xy_valid", "v_z_valid"),
        ),
        *own,
        *attitude_rows(
            f"vehicle_attitude{source}", item_names("q", 4), place, quaternion_in_enu, turn
        ),
        SignalRow(rates, item_names("xyz"), component_names(f"{turn}.w_"), "rad/s", flu),
    ]


_ATTITUDE_TOPIC, _RATES_TOPIC = "vehicle_attitude_setpoint", "vehicle_rates_setpoint"
_TRAJECTORY_TOPIC, _GOAL_TOPIC = "trajectory_setpoint", "vehicle_local_position_setpoint"
_THRUST_SIGNALS, _TORQUE_SIGNALS = (
    ("attitude_setpoint.thrust",),
    component_names("torque_setpoint."),
)
PX4_SIGNAL_ROWS = (
    *_rows_of_motion("", "estimate", "estimate", "estimate"),
    *_rows_of_motion("_groundtruth", "position_data", "velocity_data", "attitude"),
    SignalRow(
        "vehicle_attitude",
        ("rollspeed", "pitchspeed", "yawspeed"),
        component_names("estimate.w_"),
        "rad/s",
        flu,
    ),
    SignalRow(
        "sensor_combined", item_names("accelerometer_m_s2"), ACCELEROMETER_SIGNALS, "m/s^2", flu
    ),
    SignalRow("sensor_combined", item_names("gyro_rad"), GYRO_SIGNALS, "rad/s", flu),
    SignalRow(_RATES_TOPIC, EULER_ANGLE_NAMES, component_names("rate_setpoint.w_"), "rad/s", flu),
    SignalRow("vehicle_torque_setpoint", item_names("xyz"), _TORQUE_SIGNALS, "1", flu),
    SignalRow("actuator_controls_0", item_names("control"), _TORQUE_SIGNALS, "1", flu),
    *attitude_rows(_ATTITUDE_TOPIC, item_names("q_d", 4), "attitude_setpoint", quaternion_in_enu),
    attitude_rows(
        _ATTITUDE_TOPIC,
        [f"{angle}_body" for angle in EULER_ANGLE_NAMES],
        "attitude_setpoint",
        quaternion_of_angles,
    )[0],
    SignalRow(_ATTITUDE_TOPIC, ("thrust_body[2]",), _THRUST_SIGNALS, "1", np.negative),
    SignalRow(_ATTITUDE_TOPIC, ("thrust",), _THRUST_SIGNALS, "1"),
    SignalRow(_RATES_TOPIC, ("thrust_body[2]",), _THRUST_SIGNALS, "1", np.negative),
    SignalRow(_RATES_TOPIC, ("thrust",), _THRUST_SIGNALS, "1"),
    SignalRow(_TRAJECTORY_TOPIC, item_names("position"), component_names("setpoint."), "m", enu),
    SignalRow(
        _TRAJECTORY_TOPIC, item_names("velocity"), component_names("setpoint.v_"), "m/s", enu
    ),
    SignalRow(_GOAL_TOPIC, ("x", "y", "z"), component_names("setpoint."), "m", enu),
    SignalRow(_GOAL_TOPIC, ("vx", "vy", "vz"), component_names("setpoint.v_"), "m/s", enu),
    SignalRow(_TRAJECTORY_TOPIC, ("yaw",), ("setpoint.yaw",), "rad", east_of_north),
    SignalRow(_GOAL_TOPIC, ("yaw",), ("setpoint.yaw",), "rad", east_of_north),
)
"""Signals of PX4's topics, the newest topics first."""
