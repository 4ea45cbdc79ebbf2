"""Read telemetry logs (.tlog) of ground stations: MAVLink's messages as they came over the radio.

Each vehicle in a log counts as a log of its own, on the clock of its autopilot. Messages of the
autopilot have their names; those of the vehicle's other components, as a gimbal, end with its
number, and those of a second instance, as of a battery, with that of the instance.

Source: mavlink.io/en/messages/common.html.
"""

from collections import defaultdict
from collections.abc import Mapping
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from workbench.common.errors import WorkbenchError
from workbench.common.flight import Flight
from workbench.common.plain_files import read_plain
from workbench.extras.flightdata.readers.dataflash import (
    ardupilot_version,
    motor_channels,
    output_range,
)
from workbench.extras.flightdata.readers.several_logs import one_of_logs
from workbench.extras.flightdata.readers.tlog_clock import (
    BOOT_FIELD,
    SAMPLE_FIELD,
    message_times,
)
from workbench.extras.flightdata.readers.tlog_frames import (
    FrameKey,
    Frames,
    begins_with_frame,
    read_payloads,
    read_tlog_frames,
)
from workbench.extras.flightdata.readers.tlog_topics import (
    MAVLINK_SIGNAL_ROWS,
    RAW_IMU_ROWS,
    battery_rows,
)
from workbench.extras.flightdata.readers.topic_log import (
    MessageTable,
    SignalRow,
    changed_parameters_remark,
    motor_share,
    several_batteries_remark,
    topic_record,
)
from workbench.extras.flightdata.readers.ulog import moving_output_rows
from workbench.logs.readers.log_reader import LogReader

TLOG_FORMAT = "MAVLink telemetry log"
TLOG_READER_PACKAGE = "pymavlink"
MAX_TLOG_FIELDS = 20_000
ARDUPILOT_NUMBER = 3
"""MAV_AUTOPILOT_ARDUPILOTMEGA in HEARTBEAT."""
PX4_NUMBER = 12
"""MAV_AUTOPILOT_PX4 in HEARTBEAT."""
NO_AUTOPILOT = 8
"""MAV_AUTOPILOT_INVALID in HEARTBEAT: a ground station or a gimbal."""
GROUND_STATION_TYPE = 6
"""MAV_TYPE_GCS in HEARTBEAT."""
MULTIROTOR_TYPES = (2, 3, 13, 14, 15, 29, 35, 43)
"""Numbers of the types of vehicles in HEARTBEAT that ArduCopter flies."""
REAL_TYPES = (9, 10)
"""Numbers of the types of parameters that are real; PX4 sends the bits of the others."""
MIN_TLOG_BATTERY_V = 1.0
"""Voltage above which a battery is connected [V]."""
SERVO_FIELDS = tuple(f"servo{i}_raw" for i in range(1, 17))
ACTUATOR_FIELDS = tuple(f"actuator[{i}]" for i in range(16))


class _Vehicle(NamedTuple):
    """A vehicle in a log.

    Attributes:
        system: its number.
        component: that of its autopilot.
        autopilot: number of the kind of its autopilot.
        kind: number of the type of the vehicle.
    """

    system: int
    component: int
    autopilot: int
    kind: int

    @property
    def label(self) -> str:
        """Name of its firmware."""
        if self.autopilot == ARDUPILOT_NUMBER:
            return "ArduCopter" if self.kind in MULTIROTOR_TYPES else "ArduPilot"
        return "PX4" if self.autopilot == PX4_NUMBER else "autopilot not known"


def read_tlog(path: Path, number: int | None = None) -> Flight:
    """Read a telemetry log.

    Args:
        path: the file.
        number: of the vehicle, from 1 in the order of their system numbers; None for that with the
            longest record.

    Raises:
        WorkbenchError: if it cannot be read, is not such a log, or has no such vehicle.
    """
    from pymavlink.dialects.v20 import ardupilotmega

    messages: Mapping[int, Any] = ardupilotmega.mavlink_map
    frames, damage = read_tlog_frames(read_plain(path), messages)
    by_name = {messages[key.message].msgname: key.message for key in frames}
    vehicles = _vehicles(frames, messages, by_name.get("HEARTBEAT", -1))
    if not vehicles:
        raise WorkbenchError(
            f"{path}: has no message of a vehicle: it is damaged, empty, or no telemetry log"
        )

    def read(each: int) -> Flight:
        return _record_of_vehicle(path, vehicles[each - 1], frames, messages, damage)

    return one_of_logs(path, len(vehicles), number, read, "messages")


def _vehicles(
    frames: Mapping[FrameKey, Frames], messages: Mapping[int, Any], heartbeat: int
) -> list[_Vehicle]:
    """Return the vehicles whose autopilot sent heartbeats, by number; else the busiest system."""
    found: dict[int, _Vehicle] = {}
    for key in sorted(key for key in frames if key.message == heartbeat):
        fields = read_payloads(frames[key], messages[heartbeat])
        autopilot, kind = int(fields["autopilot"][-1]), int(fields["type"][-1])
        if autopilot != NO_AUTOPILOT and kind != GROUND_STATION_TYPE:
            found.setdefault(key.system, _Vehicle(key.system, key.component, autopilot, kind))
    if not found and frames:
        busiest = max(frames, key=lambda key: len(frames[key].stamps))
        return [_Vehicle(busiest.system, busiest.component, NO_AUTOPILOT, 0)]
    return list(found.values())


def _record_of_vehicle(
    path: Path,
    vehicle: _Vehicle,
    frames: Mapping[FrameKey, Frames],
    messages: Mapping[int, Any],
    damage: str,
) -> Flight:
    """Return the flight of a vehicle."""
    fields = {
        key: read_payloads(each, messages[key.message])
        for key, each in frames.items()
        if key.system == vehicle.system
    }
    own = {
        messages[key.message].msgname: each
        for key, each in fields.items()
        if key.component == vehicle.component
    }
    parameters, changed = _parameters(own.get("PARAM_VALUE", {}), vehicle)
    tables = _tables(path, vehicle, frames, fields, messages)
    remarks = [damage, changed_parameters_remark(changed)]
    rows = [
        *MAVLINK_SIGNAL_ROWS,
        *(RAW_IMU_ROWS if vehicle.autopilot == ARDUPILOT_NUMBER else ()),
        *_first_battery_rows(tables, remarks),
        *_motor_rows(tables, vehicle, parameters, remarks),
    ]
    if "LOCAL_POSITION_NED" not in tables and "GLOBAL_POSITION_INT" in tables:
        remarks.append(
            "estimate.x and .y are distances from the first position of GLOBAL_POSITION_INT, .z "
            "the height above home"
        )
    return topic_record(
        path,
        TLOG_FORMAT,
        tables,
        rows,
        tick=1e-6,
        noun="message",
        firmware=_firmware(vehicle, own),
        parameters=parameters,
        remarks=remarks,
    )


def _tables(
    path: Path,
    vehicle: _Vehicle,
    frames: Mapping[FrameKey, Frames],
    fields: Mapping[FrameKey, Mapping[str, np.ndarray]],
    messages: Mapping[int, Any],
) -> dict[str, MessageTable]:
    """Return the numbers of a vehicle's messages, by name, component and instance."""
    by_component: dict[int, list[FrameKey]] = defaultdict(list)
    for key in sorted(fields, key=lambda key: (key.component != vehicle.component, *key)):
        by_component[key.component].append(key)
    tables: dict[str, MessageTable] = {}
    for component, keys in by_component.items():
        stamps = [np.array(frames[key].stamps, dtype=float) for key in keys]
        places = [np.array(frames[key].places) for key in keys]
        times = message_times(stamps, places, [fields[key] for key in keys])
        end = "" if component == vehicle.component else f"_{component}"
        for key, ticks, place in zip(keys, times, places, strict=True):
            message = messages[key.message]
            numbers = {
                name: values.astype(float)
                for name, values in fields[key].items()
                if values.dtype.kind in "iuf" and name not in (BOOT_FIELD, SAMPLE_FIELD)
            }
            name = f"{message.msgname}{end}"
            tables |= _by_instance(
                name, MessageTable(ticks, numbers, place), message.instance_field or ""
            )
        if sum(len(table.fields) for table in tables.values()) > MAX_TLOG_FIELDS:
            raise WorkbenchError(f"{path}: has more than {MAX_TLOG_FIELDS} fields: it is damaged")
    return {
        name: table
        for name, table in tables.items()
        if table.fields and not name.startswith(("PARAM_VALUE", "STATUSTEXT"))
    }


def _by_instance(name: str, table: MessageTable, field: str) -> dict[str, MessageTable]:
    """Return the tables of all instances of a message; the first one has its plain name."""
    if field not in table.fields:
        return {name: table}
    numbers = table.fields[field]
    return {
        name if place == 0 else f"{name}_{number:.0f}": MessageTable(
            table.ticks[rows],
            {field: values[rows] for field, values in table.fields.items()},
            None if table.places is None else table.places[rows],
        )
        for place, number in enumerate(np.unique(numbers))
        for rows in (numbers == number,)
    }


def _text(value: bytes) -> str:
    return value.decode("ascii", "replace").strip("\0 ")


def _parameters(
    fields: Mapping[str, np.ndarray], vehicle: _Vehicle
) -> tuple[dict[str, float | str], list[str]]:
    """Return the last values of parameters by name, and the names of those that changed."""
    found: dict[str, float | str] = {}
    changed: dict[str, None] = {}
    if not fields:
        return found, []
    values = fields["param_value"]
    bits = np.ascontiguousarray(values).view("<i4")
    is_bits = (vehicle.autopilot == PX4_NUMBER) & ~np.isin(fields["param_type"], REAL_TYPES)
    for raw, value in zip(fields["param_id"], np.where(is_bits, bits, values), strict=True):
        name = _text(raw)
        if found.get(name, value) != value:
            changed[name] = None
        found[name] = float(value)
    return found, list(changed)


def _firmware(vehicle: _Vehicle, own: Mapping[str, Mapping[str, np.ndarray]]) -> str:
    """Return name and version of the firmware, from what it says of itself."""
    banner = ardupilot_version(map(_text, own.get("STATUSTEXT", {}).get("text", ())))
    if banner:
        return banner
    version = int(own.get("AUTOPILOT_VERSION", {}).get("flight_sw_version", [0])[-1])
    if not version:
        return vehicle.label
    return f"{vehicle.label} {version >> 24}.{version >> 16 & 255}.{version >> 8 & 255}"


def _first_battery_rows(tables: Mapping[str, MessageTable], remarks: list[str]) -> list[SignalRow]:
    """Return the rows of the first battery with a voltage."""
    names = [name for name in tables if name.startswith(("BATTERY_STATUS", "SYS_STATUS"))]
    used = []
    for name in sorted(names):
        row = next(
            (each for each in battery_rows(name) if set(each.fields) <= set(tables[name].fields)),
            None,
        )
        volts = row.values_of(tables[name]) if row else np.empty(0)
        if np.isfinite(volts).any() and np.nanmedian(volts) > MIN_TLOG_BATTERY_V:
            used.append(name)
    several = [name for name in used if name.startswith("BATTERY_STATUS")]
    if len(several) > 1:
        remarks.append(several_batteries_remark(several))
    return [row for name in used if name not in several[1:] for row in battery_rows(name)]


def _motor_rows(
    tables: Mapping[str, MessageTable],
    vehicle: _Vehicle,
    parameters: Mapping[str, float | str],
    remarks: list[str],
) -> list[SignalRow]:
    """Return the rows of the motor commands."""
    if vehicle.autopilot == ARDUPILOT_NUMBER:
        channels = motor_channels(parameters, vehicle.label)
        low, full = output_range(parameters)
        ports = [name for name in sorted(tables) if name.startswith("SERVO_OUTPUT_RAW")]
        rows = [
            SignalRow(
                name,
                (SERVO_FIELDS[(channel - 1) % 16],),
                (f"motors.command_{motor}",),
                "1",
                motor_share(low, full),
            )
            for motor, channel in sorted(channels.items())
            for name in ports[(channel - 1) // 16 :][:1]
        ]
        remarks.append(
            f"the motors' commands are channels of SERVO_OUTPUT_RAW, {low:g} to {full:g} us"
            if rows
            else "the log names no motors: the purpose of the outputs is not known"
        )
        return rows
    outputs = {
        name: fields
        for name, fields in (
            ("ACTUATOR_OUTPUT_STATUS", ACTUATOR_FIELDS),
            ("SERVO_OUTPUT_RAW", SERVO_FIELDS),
            ("SERVO_OUTPUT_RAW_1", SERVO_FIELDS),
        )
        if name in tables
    }
    return moving_output_rows(tables, outputs, parameters, remarks)


LOG_READER = LogReader(
    TLOG_FORMAT,
    "MAVLink's .tlog",
    lambda path, head: (
        path.name.lower().removesuffix(".gz").endswith(".tlog") or begins_with_frame(head)
    ),
    lambda file: read_tlog(file.path, file.number),
    place=35,
    endings=(".tlog",),
    package=TLOG_READER_PACKAGE,
    needs_plain=True,
    has_several=True,
    firmware="px4 ardupilot",
)
