"""Read PX4's ULog, with pyulog.

PX4's axes are north, east, down and forward, right, down. Its topics have changed since version
1.6; if two topics carry the same signal, the newer one counts (`actuator_motors` before
`actuator_outputs`, `vehicle_torque_setpoint` before `actuator_controls_0`). Times are
`timestamp_sample` where a topic has it. Only the first instance of a topic gets the workbench's
names.

Source: msg/ of PX4-Autopilot, as facts; docs.px4.io/main/en/dev_log/ulog_file_format.html.
"""

import io
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np

from workbench.common.errors import WorkbenchError
from workbench.logs.flight_record import FORCE, GYRO, FlightRecord, parts
from workbench.logs.readers.rotations import (
    ANGLES,
    continuous,
    enu,
    flu,
    from_ned_frd,
    quaternion,
)
from workbench.logs.readers.topic_log import Row, Table, attitude_rows, scaled, share, topic_record

FORMAT = "PX4 ULog"
MAGIC = b"ULog\x01\x12\x35"
NEEDS = "pyulog"
HEADER = 3
"""Number of bytes before each message."""
MOST_FIELDS = 20_000
MOST_MOTORS = 32
PWM_LOW, PWM_FULL = 1000.0, 2000.0
"""Limits of a motor output if no parameter states them [us]."""
_RPM = np.pi / 30.0


class _Forward(io.BufferedReader):
    """A log in which pyulog cannot go back far enough to read it for ever.

    After an unknown message in the header, pyulog seeks back by the size that the message states.
    If the file ends before that size, pyulog would come to earlier messages, again and again.
    """

    def __init__(self, path: Path) -> None:
        super().__init__(io.FileIO(path))
        self._path = path
        self._last = 0

    def read(self, size: int | None = -1, /) -> bytes:
        data = super().read(size)
        self._last = len(data)
        return data

    def seek(self, offset: int, whence: int = io.SEEK_SET, /) -> int:
        if whence == io.SEEK_CUR and -offset > self._last + HEADER:
            raise WorkbenchError(
                f"{self._path}: is damaged: at byte {self.tell()} a message ends beyond the end of "
                "the file"
            )
        return super().seek(offset, whence)


def read_ulog(path: Path) -> FlightRecord:
    """Read a log of PX4.

    Raises:
        WorkbenchError: if it cannot be read, or is not such a log.
    """
    from pyulog import ULog

    try:
        with _Forward(path) as file:
            log = ULog(file)
    except WorkbenchError:
        raise
    except Exception as error:  # pyulog raises any exception on a damaged file
        raise WorkbenchError(f"{path}: cannot be read as a ULog: {error}") from error
    found = [each for each in log.data_list if len(each.data.get("timestamp", ())) > 0]
    if not found:
        raise WorkbenchError(f"{path}: has no data: it is empty or damaged")
    begin = min(int(each.data["timestamp"].min()) for each in found)
    last = max(int(each.data["timestamp"].max()) for each in found)
    if 0 < log.start_timestamp < last:
        begin = max(begin, int(log.start_timestamp))  # a topic that was never published has time 0
    tables: dict[str, Table] = {}
    for each in found:
        topic = each.name if each.multi_id == 0 else f"{each.name}_{each.multi_id}"
        tables[topic] = Table(_time(each.data, begin), _fields(each.data))
    if sum(len(table.fields) for table in tables.values()) > MOST_FIELDS:
        raise WorkbenchError(f"{path}: has more than {MOST_FIELDS} fields: it is damaged")
    motors, remarks = _motors(tables, log.initial_parameters)
    if log.dropouts:
        lost = 1e-3 * sum(dropout.duration for dropout in log.dropouts)
        remarks.append(f"the logger dropped data {len(log.dropouts)} times, {lost:.2f} s in all")
    if log.file_corruption:
        remarks.append("the file is damaged: parts of it were left out")
    info = log.msg_info_dict
    version = log.get_version_info_str() or str(info.get("ver_sw", ""))[:8]
    return topic_record(
        path,
        FORMAT,
        tables,
        [*ROWS, *motors],
        end=(last - begin) * 1e-6,
        firmware=f"PX4 {version}, {info.get('ver_hw', 'unknown board')}",
        parameters={
            str(name): float(value)
            for name, value in log.initial_parameters.items()
            if isinstance(value, int | float)
        },
        remarks=remarks,
    )


def _time(data: Mapping[str, np.ndarray], begin: int) -> np.ndarray:
    """Return the times of the messages of a topic [s]."""
    stamp = data["timestamp"].astype(np.int64)
    sampled = data.get("timestamp_sample")
    if sampled is not None and (sampled > 0).all():
        stamp = sampled.astype(np.int64)
    return np.asarray((stamp - begin) * 1e-6)


def _fields(data: Mapping[str, np.ndarray]) -> dict[str, np.ndarray]:
    """Return the numeric fields of a topic, without times and padding."""
    return {
        field: np.asarray(values, dtype=float)
        for field, values in data.items()
        if "timestamp" not in field
        and not field.startswith("_padding")
        and np.asarray(values).dtype.kind in "fiub"
    }


def _turned(q: np.ndarray) -> np.ndarray:
    return continuous(from_ned_frd(q))


def _east(yaw: np.ndarray) -> np.ndarray:
    """Return yaws counter-clockwise from east of headings clockwise from north [rad]."""
    east = 0.5 * np.pi - yaw
    return np.asarray(np.arctan2(np.sin(east), np.cos(east)))


def _items(field: str, count: int = 3) -> list[str]:
    return [f"{field}[{i}]" for i in range(count)]


def _rows_of_motion(source: str, place: str, speed: str, turn: str) -> list[Row]:
    """Return the rows of the estimated or, with the suffix of such topics, the true motion."""
    local = f"vehicle_local_position{source}"
    own = [Row(local, ("ax", "ay", "az"), parts(f"{place}.a_"), "m/s^2", enu)] if not source else []
    rates = f"vehicle_angular_velocity{source}"
    return [
        Row(local, ("x", "y", "z"), parts(f"{place}."), "m", enu),
        Row(local, ("vx", "vy", "vz"), parts(f"{speed}.v_"), "m/s", enu),
        *own,
        *attitude_rows(f"vehicle_attitude{source}", _items("q", 4), place, _turned, turn),
        Row(rates, _items("xyz"), parts(f"{turn}.w_"), "rad/s", flu),
    ]


_ATTITUDE, _RATES = "vehicle_attitude_setpoint", "vehicle_rates_setpoint"
_TRAJECTORY, _GOAL = "trajectory_setpoint", "vehicle_local_position_setpoint"
_THRUST, _TORQUE = ("attitude_setpoint.thrust",), parts("torque_setpoint.")
ROWS = (
    *_rows_of_motion("", "estimate", "estimate", "estimate"),
    *_rows_of_motion("_groundtruth", "position_data", "velocity_data", "attitude"),
    Row(
        "vehicle_attitude",
        ("rollspeed", "pitchspeed", "yawspeed"),
        parts("estimate.w_"),
        "rad/s",
        flu,
    ),
    Row("sensor_combined", _items("accelerometer_m_s2"), FORCE, "m/s^2", flu),
    Row("sensor_combined", _items("gyro_rad"), GYRO, "rad/s", flu),
    Row(_RATES, ANGLES, parts("rate_setpoint.w_"), "rad/s", flu),
    Row("vehicle_torque_setpoint", _items("xyz"), _TORQUE, "1", flu),
    Row("actuator_controls_0", _items("control"), _TORQUE, "1", flu),
    *attitude_rows(_ATTITUDE, _items("q_d", 4), "attitude_setpoint", _turned),
    attitude_rows(
        _ATTITUDE,
        [f"{angle}_body" for angle in ANGLES],
        "attitude_setpoint",
        lambda turn: _turned(quaternion(*turn.T)),
    )[0],
    Row(_ATTITUDE, ("thrust_body[2]",), _THRUST, "1", np.negative),
    Row(_ATTITUDE, ("thrust",), _THRUST, "1"),
    Row(_RATES, ("thrust_body[2]",), _THRUST, "1", np.negative),
    Row(_RATES, ("thrust",), _THRUST, "1"),
    Row(_TRAJECTORY, _items("position"), parts("setpoint."), "m", enu),
    Row(_TRAJECTORY, _items("velocity"), parts("setpoint.v_"), "m/s", enu),
    Row(_GOAL, ("x", "y", "z"), parts("setpoint."), "m", enu),
    Row(_GOAL, ("vx", "vy", "vz"), parts("setpoint.v_"), "m/s", enu),
    Row(_TRAJECTORY, ("yaw",), ("setpoint.yaw",), "rad", _east),
    Row(_GOAL, ("yaw",), ("setpoint.yaw",), "rad", _east),
    Row("battery_status", ("voltage_v",), ("battery.voltage",), "V"),
    Row("battery_status", ("current_a",), ("battery.current",), "A"),
)
"""Signals of PX4's topics, the newest topics first."""


def _motors(
    tables: Mapping[str, Table], parameters: Mapping[str, Any]
) -> tuple[list[Row], list[str]]:
    """Return the rows of rotor speeds and motor commands, and remarks."""

    def fields(topic: str, count: str, name: str) -> list[str]:
        """Return the first fields of a topic, as many as its field `count` states."""
        table = tables.get(topic)
        if table is None:
            return []
        # The count may be any number in a damaged log.
        stated = np.clip(np.max(table.fields.get(count, [0]), initial=0), 0, MOST_MOTORS)
        return [name.format(i) for i in range(int(stated))]

    rows = [
        Row("esc_status", (field,), (f"rotors.speed.{i}",), "rad/s", scaled(_RPM))
        for i, field in enumerate(fields("esc_status", "esc_count", "esc[{}].esc_rpm"))
    ]
    if "actuator_motors" in tables:  # controls without a motor are NaN, and are left out
        rows += [
            Row("actuator_motors", (f"control[{i}]",), (f"motors.command_{i + 1}",), "1")
            for i in range(12)
        ]
        return rows, []
    outputs = tables.get("actuator_outputs")
    if outputs is None:
        return rows, ["the motors' commands were not logged"]
    low = parameters.get("PWM_MAIN_MIN", parameters.get("PWM_MIN", PWM_LOW))
    full = parameters.get("PWM_MAIN_MAX", parameters.get("PWM_MAX", PWM_FULL))
    if not (isinstance(low, int | float) and isinstance(full, int | float) and full > low):
        low, full = PWM_LOW, PWM_FULL
    for i, field in enumerate(fields("actuator_outputs", "noutputs", "output[{}]")):
        if field in outputs.fields and np.ptp(outputs.fields[field]) > 0.0:
            name = f"motors.command_{i + 1}"
            rows.append(Row("actuator_outputs", (field,), (name,), "1", share(low, full)))
    return rows, [
        f"the motors' commands are outputs of {low:g} to {full:g} us; outputs that never move "
        "were left out, and one that moves may not be a motor"
    ]
