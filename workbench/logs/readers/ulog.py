"""PX4's ULog, by pyulog.

PX4's axes are north, east, down and forward, right, down. Topics are of the versions since 1.6: of
two that carry one signal the newer is taken (`actuator_motors` before `actuator_outputs`,
`vehicle_torque_setpoint` before `actuator_controls_0`). Times are `timestamp_sample` where there is
one. Only the first instance of a topic has the workbench's names.

Source: msg/ of PX4-Autopilot, as facts; docs.px4.io/main/en/dev_log/ulog_file_format.html.
"""

import io
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from workbench.common.errors import WorkbenchError
from workbench.logs.flight_record import FORCE, GYRO, FlightRecord, Signal, make_signal, parts
from workbench.logs.readers.names import own_name
from workbench.logs.readers.packed import stem
from workbench.logs.readers.rotations import (
    ANGLES,
    QUATERNION,
    angles,
    continuous,
    enu,
    flu,
    from_ned_frd,
    quaternion,
)

FORMAT = "PX4 ULog"
MAGIC = b"ULog\x01\x12\x35"
NEEDS = "pyulog"
HEADER = 3
"""Bytes before each message."""
MOST_FIELDS = 20_000
MOST_MOTORS = 32
PWM_LOW, PWM_FULL = 1000.0, 2000.0
"""Default limits of a motor output without parameters [us]."""
_RPM = np.pi / 30.0
Data = Mapping[str, np.ndarray]


class _Forward(io.BufferedReader):
    """A log that pyulog cannot read in circles.

    After an unknown message in the head it goes back by the size that the message claims. Where
    that is more than the file has, it would come to earlier messages, and so on for ever.
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
                f"{self._path}: is damaged: at byte {self.tell()} a message ends behind the file"
            )
        return super().seek(offset, whence)


def read_ulog(path: Path) -> FlightRecord:
    """Read a log of PX4.

    Raises:
        WorkbenchError: if it cannot be read, or is none.
    """
    from pyulog import ULog

    try:
        with _Forward(path) as file:
            log = ULog(file)
    except WorkbenchError:
        raise
    except Exception as error:  # it raises whatever its parsing meets in a damaged file
        raise WorkbenchError(f"{path}: cannot be read as a ULog: {error}") from error
    found = [each for each in log.data_list if len(each.data.get("timestamp", ())) > 0]
    if not found:
        raise WorkbenchError(f"{path}: has no data: it is empty or damaged")
    begin = min(int(each.data["timestamp"].min()) for each in found)
    if 0 < log.start_timestamp < max(int(each.data["timestamp"].max()) for each in found):
        begin = max(begin, int(log.start_timestamp))  # a topic that nobody published says 0
    end = (max(int(each.data["timestamp"].max()) for each in found) - begin) * 1e-6
    firsts = {each.name: each.data for each in found if each.multi_id == 0}
    signals: dict[str, Signal] = {}

    def add(name: str, unit: str, data: Data, values: np.ndarray) -> None:
        if name not in signals and np.isfinite(values).any():
            time = _time(data, begin)
            values = np.where(time >= 0.0, values, np.nan)
            signals[name] = make_signal(name, unit, time, values, end=end)

    parameters = dict(log.initial_parameters)
    remarks = _add_all(firsts, parameters, add)
    known = set(signals)
    count = 0
    for each in found:
        topic = each.name if each.multi_id == 0 else f"{each.name}_{each.multi_id}"
        for field, values in each.data.items():
            if "timestamp" in field or field.startswith("_padding"):
                continue
            count += 1
            if count > MOST_FIELDS:
                raise WorkbenchError(f"{path}: has more than {MOST_FIELDS} fields: it is damaged")
            name = own_name(topic, field)
            if name not in known and np.asarray(values).dtype.kind in "fiub":
                add(name, "", each.data, np.asarray(values, dtype=float))
    if log.dropouts:
        lost = 1e-3 * sum(dropout.duration for dropout in log.dropouts)
        remarks.append(f"the logger dropped data {len(log.dropouts)} times, {lost:.2f} s in all")
    if log.file_corruption:
        remarks.append("the file is damaged: parts of it were left out")
    info = log.msg_info_dict
    version = log.get_version_info_str() or str(info.get("ver_sw", ""))[:8]
    return FlightRecord(
        name=stem(path),
        source=path,
        format=FORMAT,
        firmware=f"PX4 {version}, {info.get('ver_hw', 'unknown board')}",
        parameters={
            str(name): float(value)
            for name, value in parameters.items()
            if isinstance(value, int | float)
        },
        remarks=tuple(remarks),
        signals=signals,
        end=end,
    )


def _time(data: Data, begin: int) -> np.ndarray:
    """Return the times of a topic's messages [s]."""
    stamp = data["timestamp"].astype(np.int64)
    sampled = data.get("timestamp_sample")
    if sampled is not None and (sampled > 0).all():
        stamp = sampled.astype(np.int64)
    return np.asarray((stamp - begin) * 1e-6)


def _count(data: Data, field: str) -> int:
    """Return the largest value of a field that counts, of a damaged log no more than can be."""
    return int(np.clip(np.max(data.get(field, [0]), initial=0), 0, MOST_MOTORS))


def _vector(data: Data, fields: Sequence[str]) -> np.ndarray | None:
    """Return fields of a topic (n, k); None where it has not all of them."""
    if not all(field in data for field in fields):
        return None
    return np.column_stack([np.asarray(data[field], dtype=float) for field in fields])


def _add_all(
    topics: Mapping[str, Data],
    parameters: Mapping[str, Any],
    add: Callable[[str, str, Data, np.ndarray], None],
) -> list[str]:
    """Add the signals that have a name of ours, and return remarks."""

    def three(
        topic: str,
        fields: Sequence[str],
        names: Sequence[str],
        unit: str,
        turned: Callable[[np.ndarray], np.ndarray],
    ) -> None:
        data = topics.get(topic, {})
        found = _vector(data, fields)
        if found is not None:
            for name, values in zip(names, turned(found).T, strict=True):
                add(name, unit, data, values)

    def attitude(topic: str, fields: Sequence[str], wanted: str, turn: str = "") -> None:
        data = topics.get(topic, {})
        q = _vector(data, fields)
        if q is not None:
            turned = continuous(from_ned_frd(q))
            for name, values in zip(ANGLES, angles(turned).T, strict=True):
                add(f"{wanted}.{name}", "rad", data, values)
            for name, values in zip(QUATERNION, turned.T, strict=True):
                add(f"{turn or wanted}.{name}", "1", data, values)

    def places(field: str, count: int = 3) -> list[str]:
        return [f"{field}[{i}]" for i in range(count)]

    for source, place, speed, turn in (
        ("", "estimate", "estimate", "estimate"),
        ("_groundtruth", "position_data", "velocity_data", "attitude"),
    ):
        local = f"vehicle_local_position{source}"
        three(local, ("x", "y", "z"), parts(f"{place}."), "m", enu)
        three(local, ("vx", "vy", "vz"), parts(f"{speed}.v_"), "m/s", enu)
        if not source:
            three(local, ("ax", "ay", "az"), parts(f"{place}.a_"), "m/s^2", enu)
        attitude(f"vehicle_attitude{source}", places("q", 4), place, turn)
        rates = f"vehicle_angular_velocity{source}"
        three(rates, places("xyz"), parts(f"{turn}.w_"), "rad/s", flu)
    speeds = ("rollspeed", "pitchspeed", "yawspeed")
    three("vehicle_attitude", speeds, parts("estimate.w_"), "rad/s", flu)
    imu = "sensor_combined"
    three(imu, places("accelerometer_m_s2"), FORCE, "m/s^2", flu)
    three(imu, places("gyro_rad"), GYRO, "rad/s", flu)
    wanted = parts("rate_setpoint.w_")
    three("vehicle_rates_setpoint", ANGLES, wanted, "rad/s", flu)
    torque = parts("torque_setpoint.")
    three("vehicle_torque_setpoint", places("xyz"), torque, "1", flu)
    three("actuator_controls_0", places("control"), torque, "1", flu)
    attitude("vehicle_attitude_setpoint", places("q_d", 4), "attitude_setpoint")
    data = topics.get("vehicle_attitude_setpoint", {})
    wanted_angles = _vector(data, [f"{angle}_body" for angle in ANGLES])
    if wanted_angles is not None:
        q = continuous(from_ned_frd(quaternion(*wanted_angles.T)))
        for name, values in zip(ANGLES, angles(q).T, strict=True):
            add(f"attitude_setpoint.{name}", "rad", data, values)
    for topic in ("vehicle_attitude_setpoint", "vehicle_rates_setpoint"):
        data = topics.get(topic, {})
        if "thrust_body[2]" in data:
            add("attitude_setpoint.thrust", "1", data, -np.asarray(data["thrust_body[2]"]))
        elif "thrust" in data:
            add("attitude_setpoint.thrust", "1", data, np.asarray(data["thrust"], dtype=float))
    three("trajectory_setpoint", places("position"), parts("setpoint."), "m", enu)
    three("trajectory_setpoint", places("velocity"), parts("setpoint.v_"), "m/s", enu)
    goal = "vehicle_local_position_setpoint"
    three(goal, ("x", "y", "z"), parts("setpoint."), "m", enu)
    three(goal, ("vx", "vy", "vz"), parts("setpoint.v_"), "m/s", enu)
    for topic in ("trajectory_setpoint", goal):
        data = topics.get(topic, {})
        if "yaw" in data:
            east = 0.5 * np.pi - np.asarray(data["yaw"], dtype=float)
            add("setpoint.yaw", "rad", data, np.arctan2(np.sin(east), np.cos(east)))
    data = topics.get("battery_status", {})
    for field, name, unit in (("voltage_v", "voltage", "V"), ("current_a", "current", "A")):
        if field in data:
            add(f"battery.{name}", unit, data, np.asarray(data[field], dtype=float))
    data = topics.get("esc_status", {})
    for i in range(_count(data, "esc_count")):
        turns = data.get(f"esc[{i}].esc_rpm")
        if turns is not None:
            add(f"rotors.speed.{i}", "rad/s", data, _RPM * np.asarray(turns, dtype=float))
    return _add_motors(topics, parameters, add)


def _add_motors(
    topics: Mapping[str, Data],
    parameters: Mapping[str, Any],
    add: Callable[[str, str, Data, np.ndarray], None],
) -> list[str]:
    """Add the motors' commands, and return remarks."""
    data = topics.get("actuator_motors", {})
    if data:
        for i in range(12):
            control = data.get(f"control[{i}]")
            if control is not None:  # those without a motor are NaN, and are left out
                add(f"motors.command_{i + 1}", "1", data, np.asarray(control, dtype=float))
        return []
    data = topics.get("actuator_outputs", {})
    if not data:
        return ["the motors' commands were not logged"]
    low = parameters.get("PWM_MAIN_MIN", parameters.get("PWM_MIN", PWM_LOW))
    full = parameters.get("PWM_MAIN_MAX", parameters.get("PWM_MAX", PWM_FULL))
    if not (isinstance(low, int | float) and isinstance(full, int | float) and full > low):
        low, full = PWM_LOW, PWM_FULL
    for i in range(_count(data, "noutputs")):
        output = data.get(f"output[{i}]")
        if output is not None and np.ptp(output) > 0.0:
            share = np.clip((np.asarray(output, dtype=float) - low) / (full - low), 0.0, 1.0)
            add(f"motors.command_{i + 1}", "1", data, share)
    return [
        f"the motors' commands are outputs of {low:g} to {full:g} us; outputs that never move "
        "were left out, and one that moves may be no motor"
    ]
