"""Read PX4's ULog, with pyulog.

PX4's axes are north, east, down and forward, right, down. Its topics have changed since version
1.6; if two topics carry the same signal, the newer one counts (`actuator_motors` before
`actuator_outputs`, `vehicle_torque_setpoint` before `actuator_controls_0`). Times are
`timestamp_sample` where a topic has it. All subscriptions of an instance of a topic are one table.

The first instance of a topic gets the workbench's names, but of batteries the first connected one,
and of outputs the first one with outputs that move. Without `sensor_combined`, the gyro and
accelerometer are those of the topic with the most samples, and of the sensor that the estimator
uses.

Source: msg/ and src/lib/drivers/gyroscope of PX4-Autopilot, as facts;
docs.px4.io/main/en/dev_log/ulog_file_format.html.
"""

import io
import struct
from collections import defaultdict
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from workbench.common.errors import WorkbenchError
from workbench.logs.flight_record import FORCE, GYRO, FlightRecord, Remark, parts
from workbench.logs.readers.rotations import (
    ANGLES,
    continuous,
    enu,
    flu,
    from_ned_frd,
    quaternion,
)
from workbench.logs.readers.topic_log import (
    Convert,
    Row,
    Table,
    attitude_rows,
    scaled,
    share,
    topic_record,
)

FORMAT = "PX4 ULog"
MAGIC = b"ULog\x01\x12\x35"
NEEDS = "pyulog"
FILE_HEADER = 16
HEADER = 3
"""Number of bytes before the first message, and before each message."""
MOST_FIELDS = 20_000
MOST_MOTORS = 32
MOST_INSTANCES = 16
MOST_SAMPLES = 32
"""Largest number of samples in a message of `sensor_gyro_fifo`."""
LEAST_VOLTAGE = 1.0
"""Voltage above which a battery counts as connected if a log does not state it [V]."""
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
    except (WorkbenchError, MemoryError):
        raise
    except Exception as error:  # pyulog raises any exception on a damaged file
        raise WorkbenchError(f"{path}: cannot be read as a ULog: {error}") from error
    found = [each for each in log.data_list if len(each.data.get("timestamp", ())) > 0]
    if not found:
        raise WorkbenchError(f"{path}: has no data: it is empty or damaged")
    tables = _tables(path, found)
    if sum(len(table.fields) for table in tables.values()) > MOST_FIELDS:
        raise WorkbenchError(f"{path}: has more than {MOST_FIELDS} fields: it is damaged")
    remarks: list[str] = []
    rows = [
        *ROWS,
        *_imu(tables, log.initial_parameters, remarks),
        *_battery(tables, remarks),
        *_motors(tables, log.initial_parameters, remarks),
    ]
    if log.changed_parameters:
        names = list(dict.fromkeys(str(name) for _, name, _ in log.changed_parameters))
        first = 1e-6 * (log.changed_parameters[0][0] - log.start_timestamp)
        remarks.append(
            Remark(
                f"{len(names)} parameters changed in flight, the first one at {first:.3f} s; those "
                f"of the start count: {', '.join(names[:8])}{' ...' if len(names) > 8 else ''}",
                len(names),
                f"{first:.3f} s",
            )
        )
    if log.dropouts:
        lost = 1e-3 * sum(dropout.duration for dropout in log.dropouts)
        first = 1e-6 * (log.dropouts[0].timestamp - log.start_timestamp)
        text = f"the logger dropped data {len(log.dropouts)} times, {lost:.2f} s in all"
        remarks.append(
            Remark(f"{text}, first at {first:.3f} s", len(log.dropouts), f"{first:.3f} s")
        )
    if log.file_corruption:
        remarks.append("the file is damaged: parts of it were left out")
    info = log.msg_info_dict
    version = log.get_version_info_str() or str(info.get("ver_sw", ""))[:8]
    return topic_record(
        path,
        FORMAT,
        tables,
        rows,
        tick=1e-6,
        begin=float(log.start_timestamp),  # a topic that was never published has time 0
        firmware=f"PX4 {version}, {info.get('ver_hw', 'unknown board')}",
        parameters={
            str(name): float(value)
            for name, value in log.initial_parameters.items()
            if isinstance(value, int | float)
        },
        remarks=remarks,
    )


def _instance(topic: str, number: int) -> str:
    """Return the name of an instance of a topic."""
    return topic if number == 0 else f"{topic}_{number}"


def _instances(tables: Mapping[str, Table], topic: str) -> list[str]:
    """Return the names of the logged instances of a topic, in order."""
    return [name for i in range(MOST_INSTANCES) if (name := _instance(topic, i)) in tables]


def _tables(path: Path, found: Sequence[Any]) -> dict[str, Table]:
    """Return the tables of all instances of topics, the subscriptions of each one joined."""
    grouped: dict[str, list[Any]] = defaultdict(list)
    for each in found:
        grouped[_instance(each.name, each.multi_id)].append(each)
    stamps = {topic: [_stamps(each.data) for each in group] for topic, group in grouped.items()}
    plain = all(
        len(group) == 1 and bool((np.diff(group[0]) > 0).all()) for group in stamps.values()
    )
    # The places in the file matter only if a clock steps back, or to join subscriptions.
    places = {} if plain else _places(path)
    tables = {}
    for topic, group in grouped.items():
        counts = [len(each) for each in stamps[topic]]
        found_places = [places.get(each.msg_id, np.empty(0)) for each in group]
        order = np.concatenate(
            [
                place if len(place) == count else np.arange(count)
                for place, count in zip(found_places, counts, strict=True)
            ]
        )
        rows = np.argsort(order, kind="stable")
        fields = [_fields(each.data) for each in group]
        tables[topic] = Table(
            np.concatenate(stamps[topic]).astype(float)[rows],
            {
                name: np.concatenate(
                    [
                        each.get(name, np.full(count, np.nan))
                        for each, count in zip(fields, counts, strict=True)
                    ]
                )[rows]
                for name in dict.fromkeys(name for each in fields for name in each)
            },
            order[rows],
        )
    return tables


def _stamps(data: Mapping[str, np.ndarray]) -> np.ndarray:
    """Return the time stamps of the messages of a subscription [us]."""
    sampled = data.get("timestamp_sample")
    used = data["timestamp"] if sampled is None or not (sampled > 0).all() else sampled
    return np.asarray(used.astype(np.int64))


def _places(path: Path) -> dict[int, np.ndarray]:
    """Return where the messages of each subscription are in the file, by its number.

    pyulog keeps the order of the messages of a subscription, but not that of all.
    """
    data = path.read_bytes()
    places: dict[int, list[int]] = defaultdict(list)
    at = FILE_HEADER
    while at + HEADER + 2 <= len(data):
        size, kind, number = struct.unpack_from("<HBH", data, at)
        if kind == ord("D"):
            places[number].append(at)
        at += HEADER + size
    return {number: np.array(each) for number, each in places.items()}


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
)
"""Signals of PX4's topics, the newest topics first."""


def _imu(tables: dict[str, Table], parameters: Mapping[str, Any], remarks: list[str]) -> list[Row]:
    """Return the rows of gyro and accelerometer of a log without `sensor_combined`.

    The samples in messages of the topics sensor_*_fifo become tables of their own.
    """
    if "sensor_combined" in tables:
        return []
    selection = tables.get("sensor_selection")
    rotation = parameters.get("SENS_BOARD_ROT", 0)
    rows = []
    for sensor, names, integral in (("gyro", GYRO, "angle"), ("accel", FORCE, "velocity")):
        found: list[str] = []
        used = selection.fields.get(f"{sensor}_device_id") if selection else None
        for topic in (f"sensor_{sensor}_fifo", f"sensor_{sensor}"):
            several = _instances(tables, topic)
            devices = {name: tables[name].fields.get("device_id") for name in several}
            known = [
                name
                for name, device in devices.items()
                if used is not None and device is not None and np.isin(device, used).any()
            ]
            for name in (known or several)[:1]:
                found.append(_samples(tables, name) if "fifo" in name else name)
        found = [name for name in (*found, "vehicle_imu") if name in tables]
        if not found:
            continue
        best = max(found, key=lambda name: len(tables[name].ticks))
        unit = "rad/s" if sensor == "gyro" else "m/s^2"
        if best == "vehicle_imu":
            fields = (*_items(f"delta_{integral}"), f"delta_{integral}_dt")
            rows.append(Row(best, fields, names, unit, _over_time))
        elif rotation in range(len(_BOARD_YAW)):
            rows.append(Row(best, ("x", "y", "z"), names, unit, _turned_board(int(rotation))))
            remarks.append(f"{names[0][:-2]} is {best}'s: without the autopilot's calibration")
        else:
            remarks.append(
                f"{best} keeps its name: the board is mounted with SENS_BOARD_ROT {rotation:g}, "
                "and only turns about its vertical axis (0 to 7) are known here"
            )
    return rows


_BOARD_YAW = tuple(np.radians(45.0 * i) for i in range(8))
"""Angles of the first values of SENS_BOARD_ROT, about the axis down [rad]."""


def _turned_board(rotation: int) -> Convert:
    """Return a conversion from the axes of a turned board to forward, left, up."""
    cos, sin = np.cos(_BOARD_YAW[rotation]), np.sin(_BOARD_YAW[rotation])
    turn = np.array([[cos, -sin, 0.0], [sin, cos, 0.0], [0.0, 0.0, 1.0]])
    return lambda board: flu(board @ turn.T)


def _over_time(values: np.ndarray) -> np.ndarray:
    """Return the means (n, 3), forward, left, up, of integrals with their durations [us] (n, 4)."""
    duration = np.where(values[:, 3:] > 0.0, values[:, 3:], np.nan)
    return flu(values[:, :3] / (1e-6 * duration))


def _samples(tables: dict[str, Table], topic: str) -> str:
    """Add a table of the single samples in the messages of a topic; return its name, or "".

    A message has up to `MOST_SAMPLES` samples; its time is that of the last one.
    """
    table = tables[topic]
    axes = [[f"{axis}[{i}]" for i in range(MOST_SAMPLES)] for axis in "xyz"]
    needed = ["dt", "scale", "samples", *(name for each in axes for name in each)]
    if not all(name in table.fields for name in needed):
        return ""
    count = np.clip(np.nan_to_num(table.fields["samples"]), 0, MOST_SAMPLES).astype(int)
    message = np.repeat(np.arange(len(count)), count)
    number = np.arange(len(message)) - np.repeat(np.cumsum(count) - count, count)
    after = count[message] - 1 - number
    places = np.arange(len(count)) if table.places is None else table.places
    name = f"{topic}_samples"
    tables[name] = Table(
        table.ticks[message] - after * table.fields["dt"][message],
        {
            axis: np.column_stack([table.fields[field] for field in each])[message, number]
            * table.fields["scale"][message]
            for axis, each in zip("xyz", axes, strict=True)
        },
        places[message] + number / MOST_SAMPLES,
    )
    return name


def _battery(tables: Mapping[str, Table], remarks: list[str]) -> list[Row]:
    """Return the rows of the first connected battery."""

    def is_connected(name: str) -> bool:
        fields = tables[name].fields
        voltage = fields.get("voltage_v", np.zeros(1))
        return bool(np.median(fields.get("connected", voltage > LEAST_VOLTAGE)) > 0.0)

    names = _instances(tables, "battery_status")
    connected = [name for name in names if is_connected(name)]
    if len(connected) > 1:
        remarks.append(
            Remark(
                f"{len(connected)} batteries are connected: battery.voltage and battery.current "
                f"are those of {connected[0]}; {', '.join(connected[1:])} keep their names",
                len(connected),
                connected[0],
            )
        )
    return [
        Row(name, (field,), (f"battery.{what}",), unit, _known(unknown))
        for name in (connected or names)[:1]
        for field, what, unit, unknown in (
            ("voltage_v", "voltage", "V", 0.0),
            ("current_a", "current", "A", -1.0),
        )
    ]


def _known(unknown: float) -> Convert:
    """Return a conversion that leaves out the value by which PX4 says that it does not know."""
    return lambda values: np.where(values == unknown, np.nan, values)


def _first(tables: Mapping[str, Table], topic: str, count: str, field: str) -> list[str]:
    """Return the first fields of a topic, as many as its field `count` states."""
    table = tables[topic]
    # The count may be any number in a damaged log.
    stated = np.clip(np.max(table.fields.get(count, [0]), initial=0), 0, MOST_MOTORS)
    names = [field.format(i) for i in range(int(stated))]
    return [name for name in names if name in table.fields]


def _motors(
    tables: Mapping[str, Table], parameters: Mapping[str, Any], remarks: list[str]
) -> list[Row]:
    """Return the rows of rotor speeds and motor commands."""
    rows = []
    if "esc_status" in tables:
        rows = [
            Row("esc_status", (field,), (f"rotors.speed.{i}",), "rad/s", scaled(_RPM))
            for i, field in enumerate(_first(tables, "esc_status", "esc_count", "esc[{}].esc_rpm"))
        ]
    if "actuator_motors" in tables:  # controls without a motor are NaN, and are left out
        return rows + [
            Row("actuator_motors", (f"control[{i}]",), (f"motors.command_{i + 1}",), "1")
            for i in range(12)
        ]
    outputs = _instances(tables, "actuator_outputs")
    if not outputs:
        remarks.append("the motors' commands were not logged")
        return rows
    moving: list[tuple[str, int, str]] = []
    for name in outputs:
        fields = tables[name].fields
        moving = [
            (name, i, field)
            for i, field in enumerate(_first(tables, name, "noutputs", "output[{}]"))
            if np.ptp(fields[field]) > 0.0
        ]
        if moving:
            break
    if not moving:
        remarks.append("no output of actuator_outputs moves: there are no motor commands")
        return rows
    name = moving[0][0]
    low, full = _limits(parameters, "MAIN" if name == outputs[0] else "AUX")
    values = np.concatenate([tables[name].fields[field] for _, _, field in moving])
    if np.mean(np.abs(values - 0.5 * (low + full)) <= full - low) < 0.5:
        remarks.append(
            f"{name} keeps its name: its outputs go from {np.min(values):g} to {np.max(values):g}, "
            f"and are not pulses of {low:g} to {full:g} us"
        )
        return rows
    remarks.append(
        f"the motors' commands are outputs of {name}, {low:g} to {full:g} us; outputs that never "
        "move were left out, and one that moves may not be a motor"
    )
    return rows + [
        Row(name, (field,), (f"motors.command_{i + 1}",), "1", share(low, full))
        for name, i, field in moving
    ]


def _limits(parameters: Mapping[str, Any], group: str) -> tuple[float, float]:
    """Return the limits of the outputs of a group [us]."""
    low = parameters.get(f"PWM_{group}_MIN", parameters.get("PWM_MIN", PWM_LOW))
    full = parameters.get(f"PWM_{group}_MAX", parameters.get("PWM_MAX", PWM_FULL))
    if isinstance(low, int | float) and isinstance(full, int | float) and full > low:
        return float(low), float(full)
    return PWM_LOW, PWM_FULL
