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

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from workbench.common.errors import WorkbenchError
from workbench.common.flight import Flight, LogRemark
from workbench.common.quantity import RPM_IN_RAD_S
from workbench.extras.flightdata.readers.topic_log import (
    ColumnConversion,
    MessageTable,
    SignalRow,
    first_names,
    motor_share,
    scaled,
    topic_record,
)
from workbench.extras.flightdata.readers.ulog_imu import ulog_imu_rows
from workbench.extras.flightdata.readers.ulog_tables import UlogReader, ulog_instances, ulog_tables
from workbench.extras.flightdata.readers.ulog_topics import PX4_SIGNAL_ROWS
from workbench.logs.readers.log_reader import LogReader, begins_with

ULOG_FORMAT = "PX4 ULog"
ULOG_MAGIC = b"ULog\x01\x12\x35"
ULOG_READER_PACKAGE = "pyulog"
MAX_ULOG_FIELDS = 20_000
MAX_ULOG_MOTORS = 32
MIN_ULOG_BATTERY_V = 1.0
"""Voltage above which a battery counts as connected if a log does not state it [V]."""
FIRST_MOTOR_FUNCTION = 101
"""Function of an output to the first motor."""
PWM_LOW_US, PWM_FULL_US = 1000.0, 2000.0
"""Limits of a motor output if no parameter states them [us]."""


def read_ulog(path: Path) -> Flight:
    """Read a log of PX4.

    Raises:
        WorkbenchError: if it cannot be read, or is not such a log.
    """
    from pyulog import ULog

    try:
        with UlogReader(path) as file:
            log = ULog(file)
    except (WorkbenchError, MemoryError):
        raise
    except Exception as error:  # pyulog raises any exception on a damaged file
        raise WorkbenchError(f"{path}: cannot be read as a ULog: {error}") from error
    found = [each for each in log.data_list if len(each.data.get("timestamp", ())) > 0]
    if not found:
        raise WorkbenchError(f"{path}: has no data: it is empty or damaged")
    tables = ulog_tables(path, found)
    if sum(len(table.fields) for table in tables.values()) > MAX_ULOG_FIELDS:
        raise WorkbenchError(f"{path}: has more than {MAX_ULOG_FIELDS} fields: it is damaged")
    remarks: list[str] = []
    rows = [
        *PX4_SIGNAL_ROWS,
        *ulog_imu_rows(tables, log.initial_parameters, remarks),
        *_ulog_battery_rows(tables, remarks),
        *_ulog_motor_rows(tables, log.initial_parameters, remarks),
    ]
    if log.changed_parameters:
        names = list(dict.fromkeys(str(name) for _, name, _ in log.changed_parameters))
        first = 1e-6 * (log.changed_parameters[0][0] - log.start_timestamp)
        remarks.append(
            LogRemark(
                f"{len(names)} parameters changed in flight, the first one at {first:.3f} s; those "
                f"of the start count: {first_names(names)}",
                len(names),
                f"{first:.3f} s",
            )
        )
    if log.dropouts:
        lost = 1e-3 * sum(dropout.duration for dropout in log.dropouts)
        first = 1e-6 * (log.dropouts[0].timestamp - log.start_timestamp)
        text = f"the logger dropped data {len(log.dropouts)} times, {lost:.2f} s in all"
        remarks.append(
            LogRemark(f"{text}, first at {first:.3f} s", len(log.dropouts), f"{first:.3f} s")
        )
    if log.file_corruption:
        remarks.append("the file is damaged: parts of it were left out")
    info = log.msg_info_dict
    version = log.get_version_info_str() or str(info.get("ver_sw", ""))[:8]
    return topic_record(
        path,
        ULOG_FORMAT,
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


def _ulog_battery_rows(tables: Mapping[str, MessageTable], remarks: list[str]) -> list[SignalRow]:
    """Return the rows of the first connected battery."""

    def is_connected(name: str) -> bool:
        fields = tables[name].fields
        voltage = fields.get("voltage_v", np.zeros(1))
        return bool(np.median(fields.get("connected", voltage > MIN_ULOG_BATTERY_V)) > 0.0)

    names = ulog_instances(tables, "battery_status")
    connected = [name for name in names if is_connected(name)]
    if len(connected) > 1:
        remarks.append(
            LogRemark(
                f"{len(connected)} batteries are connected: battery.voltage and battery.current "
                f"are those of {connected[0]}; {', '.join(connected[1:])} keep their names",
                len(connected),
                connected[0],
            )
        )
    return [
        SignalRow(name, (field,), (f"battery.{what}",), unit, _known_values(unknown))
        for name in (connected or names)[:1]
        for field, what, unit, unknown in (
            ("voltage_v", "voltage", "V", 0.0),
            ("current_a", "current", "A", -1.0),
        )
    ]


def _known_values(unknown: float) -> ColumnConversion:
    """Return a conversion that leaves out the value by which PX4 says that it does not know."""
    return lambda values: np.where(values == unknown, np.nan, values)


def _first_fields(
    tables: Mapping[str, MessageTable], topic: str, count: str, field: str
) -> list[str]:
    """Return the first fields of a topic, as many as its field `count` states."""
    fields = tables[topic].fields
    names = [field.format(i) for i in range(_largest(fields, count, MAX_ULOG_MOTORS))]
    return [name for name in names if name in fields]


def _largest(fields: Mapping[str, np.ndarray], name: str, limit: int) -> int:
    """Return the largest number of a field, from 0 to a limit; 0 without the field."""
    # It may be any number, and none, in a damaged log.
    largest = np.fmax.reduce(fields.get(name, np.zeros(1)), initial=0.0)
    return int(min(largest, limit))


def _speeds_by_motor(tables: Mapping[str, MessageTable]) -> list[tuple[int, str]]:
    """Return the fields of rotor speeds with the index of their motor.

    An ESC states its motor since version 1.13; else the ESCs are in the order of the motors.
    """
    if "esc_status" not in tables:
        return []
    speeds = _first_fields(tables, "esc_status", "esc_count", "esc[{}].esc_rpm")
    fields = tables["esc_status"].fields
    motors = [
        _largest(
            fields,
            name.replace("esc_rpm", "actuator_function"),
            FIRST_MOTOR_FUNCTION + MAX_ULOG_MOTORS,
        )
        - FIRST_MOTOR_FUNCTION
        for name in speeds
    ]
    if len(set(motors)) < len(motors) or not all(0 <= each < MAX_ULOG_MOTORS for each in motors):
        motors = list(range(len(speeds)))
    return list(zip(motors, speeds, strict=True))


def _ulog_motor_rows(
    tables: Mapping[str, MessageTable], parameters: Mapping[str, Any], remarks: list[str]
) -> list[SignalRow]:
    """Return the rows of rotor speeds and motor commands."""
    rows = [
        SignalRow("esc_status", (field,), (f"rotors.speed.{i}",), "rad/s", scaled(RPM_IN_RAD_S))
        for i, field in _speeds_by_motor(tables)
    ]
    if "actuator_motors" in tables:  # controls without a motor are NaN, and are left out
        return rows + [
            SignalRow("actuator_motors", (f"control[{i}]",), (f"motors.command_{i + 1}",), "1")
            for i in range(12)
        ]
    outputs = ulog_instances(tables, "actuator_outputs")
    fields = {name: _first_fields(tables, name, "noutputs", "output[{}]") for name in outputs}
    return rows + moving_output_rows(tables, fields, parameters, remarks)


def moving_output_rows(
    tables: Mapping[str, MessageTable],
    outputs: Mapping[str, Sequence[str]],
    parameters: Mapping[str, Any],
    remarks: list[str],
) -> list[SignalRow]:
    """Return the rows of the outputs of PX4 that move, if they are pulses.

    Args:
        tables: by topic.
        outputs: fields of the outputs by topic, the main ones first.
        parameters: of the firmware.
        remarks: to which one is added.
    """
    if not outputs:
        remarks.append("the motors' commands were not logged")
        return []
    name = main = next(iter(outputs))
    moving: list[tuple[int, str]] = []
    for name, fields in outputs.items():
        moving = [(i, f) for i, f in enumerate(fields) if np.ptp(tables[name].fields[f]) > 0.0]
        if moving:
            break
    if not moving:
        remarks.append(f"no output of {main} moves: there are no motor commands")
        return []
    low, full = _output_limits(parameters, "MAIN" if name == main else "AUX")
    values = np.concatenate([tables[name].fields[field] for _, field in moving])
    if np.mean(np.abs(values - 0.5 * (low + full)) <= full - low) < 0.5:
        remarks.append(
            f"{name} keeps its name: its outputs go from {np.min(values):g} to {np.max(values):g}, "
            f"and are not pulses of {low:g} to {full:g} us"
        )
        return []
    remarks.append(
        f"the motors' commands are outputs of {name}, {low:g} to {full:g} us; outputs that never "
        "move were left out, and one that moves may not be a motor"
    )
    return [
        SignalRow(name, (field,), (f"motors.command_{i + 1}",), "1", motor_share(low, full))
        for i, field in moving
    ]


def _output_limits(parameters: Mapping[str, Any], group: str) -> tuple[float, float]:
    """Return the limits of the outputs of a group [us]."""
    low = parameters.get(f"PWM_{group}_MIN", parameters.get("PWM_MIN", PWM_LOW_US))
    full = parameters.get(f"PWM_{group}_MAX", parameters.get("PWM_MAX", PWM_FULL_US))
    if isinstance(low, int | float) and isinstance(full, int | float) and full > low:
        return float(low), float(full)
    return PWM_LOW_US, PWM_FULL_US


LOG_READER = LogReader(
    ULOG_FORMAT,
    "PX4's .ulg",
    lambda _, head: begins_with(head, ULOG_MAGIC),
    lambda file: read_ulog(file.path),
    place=10,
    endings=(".ulg",),
    package=ULOG_READER_PACKAGE,
    needs_plain=True,
    firmware="px4",
)
