"""Read ArduPilot's DataFlash logs (.bin), with pymavlink.

ArduPilot's axes are north, east, down and forward, right, down, with angles in degrees. The motor
outputs are the channels of RCOU whose SERVOn_FUNCTION is that of a motor. If an older log of a
Copter has no such parameters, they are the first four channels.

Source: ardupilot.org/copter/docs/logmessages.html.
"""

import re
from collections import defaultdict
from collections.abc import Iterable, Mapping, Sequence
from contextlib import closing
from pathlib import Path
from typing import Any

import numpy as np

from workbench.common.errors import WorkbenchError
from workbench.common.flight import Flight, LogRemark
from workbench.common.quantity import RPM_IN_RAD_S
from workbench.extras.flightdata.readers.axes import (
    enu,
    flu,
    quaternion_of_angles,
)
from workbench.extras.flightdata.readers.topic_log import (
    MessageTable,
    SignalRow,
    attitude_rows,
    changed_parameters_remark,
    motor_share,
    parameter_number,
    scaled,
    several_batteries_remark,
    topic_record,
)
from workbench.logs.logged_signal import ACCELEROMETER_SIGNALS, GYRO_SIGNALS, component_names
from workbench.logs.readers.log_reader import LogReader, begins_with

DATAFLASH_FORMAT = "ArduPilot DataFlash log"
DATAFLASH_MAGIC = b"\xa3\x95"
DATAFLASH_READER_PACKAGE = "pymavlink"
MAX_DATAFLASH_MESSAGES = 20_000_000
INSTANCE_COLUMNS = ("I", "C", "Instance")
"""Names of the second column of a message that has instances, in logs that do not mark it."""
MAX_DATAFLASH_BATTERIES = 16
MIN_DATAFLASH_BATTERY_V = 1.0
"""Voltage above which a battery is connected [V]."""
MOTOR_FUNCTIONS = (*range(33, 41), *range(82, 86))
"""SERVOn_FUNCTION of the motors, in order."""
SERVOS_BY_FRAME_CLASS = {7.0: (7,), 8.0: (1, 2, 3, 4), 9.0: (1, 2, 3, 4)}
"""Numbers of motors that are servos, by FRAME_CLASS: the tail of a tricopter, and the flaps below
one or two coaxial rotors."""
DSHOT_OUTPUT_TYPES = (4.0, 5.0, 6.0, 7.0)
"""Values of MOT_PWM_TYPE for digital outputs."""
OUTPUT_MESSAGES = ("RCOU", "RCO2", "RCO3")
"""Messages with the outputs of the channels."""
ARDUPILOT_VERSION_TEXT = re.compile(r"(Ardu|APM:)\w+ V\d")
"""Beginning of the text with name and version; versions 3.3 to 3.5 wrote "APM:Copter V3.5.7"."""
_SKIPPED_MESSAGES = ("FMT", "FMTU", "UNIT", "MULT", "PARM", "MSG", "FILE", "VER", "ISBD", "ISBH")
"""Messages that describe the log, or are texts."""


def read_dataflash(path: Path) -> Flight:
    """Read a log of ArduPilot.

    Raises:
        WorkbenchError: if it cannot be read, or is not such a log.
    """
    from pymavlink.DFReader import DFReader_binary

    rows: dict[str, list[tuple[Any, ...]]] = defaultdict(list)
    places: dict[str, list[int]] = defaultdict(list)
    columns: dict[str, list[str]] = {}
    parameters: dict[str, float | str] = {}
    changed: dict[str, None] = {}
    texts: list[str] = []
    damage = ""
    try:
        with closing(DFReader_binary(str(path))) as log:
            for place in range(MAX_DATAFLASH_MESSAGES):
                message = log.recv_msg()
                if message is None:
                    break
                name = message.get_type()
                if name == "PARM":
                    name, value = str(message.Name), float(message.Value)
                    if parameters.get(name, value) != value:
                        changed[name] = None
                    parameters[name] = value
                elif name == "MSG":
                    texts.append(str(message.Message))
                elif name not in _SKIPPED_MESSAGES and "TimeUS" in message.fmt.columns:
                    topic = _topic(message)
                    fields = list(message.fmt.columns)
                    if columns.setdefault(topic, fields) != fields:
                        raise ValueError(f"message {topic} is defined twice")
                    # If a damaged definition names fields that do not exist, nothing is kept.
                    row = tuple(getattr(message, each) for each in fields)
                    rows[topic].append(row)
                    places[topic].append(place)
    except MemoryError:
        raise
    except Exception as error:  # pymavlink raises any exception on a damaged file
        if not rows:
            raise WorkbenchError(f"{path}: cannot be read as a DataFlash log: {error}") from error
        count = sum(map(len, rows.values()))
        text = f"the file is damaged, and was read up to there, {count} messages: {error}"
        damage = LogRemark(text, count, f"message {count}")
    found = {topic: _columns_of_messages(columns[topic], each) for topic, each in rows.items()}
    found = {topic: table for topic, table in found.items() if len(table.get("TimeUS", ())) > 0}
    if not found:
        raise WorkbenchError(f"{path}: has no data: it is empty or damaged")
    tables = {
        topic: MessageTable(table.pop("TimeUS"), table, np.array(places[topic]))
        for topic, table in found.items()
    }
    firmware = ardupilot_version(texts)
    motors, remark = _dataflash_motor_rows(tables, parameters, firmware)
    battery, several = _dataflash_battery_rows(tables)
    return topic_record(
        path,
        DATAFLASH_FORMAT,
        tables,
        [*_primary_core_rows(tables), *ARDUPILOT_SIGNAL_ROWS, *battery, *motors],
        tick=1e-6,
        firmware=firmware,
        parameters=parameters,
        remarks=(damage, several, remark, changed_parameters_remark(list(changed))),
    )


def ardupilot_version(texts: Iterable[str]) -> str:
    """Return the first text that is name and version of the firmware; "" if there is none.

    Each start ends with "ArduPilot Ready", which is neither.
    """
    return next((text for text in texts if ARDUPILOT_VERSION_TEXT.match(text)), "")


def _topic(message: Any) -> str:
    """Return the name of a message, followed by its instance if that is not the first one."""
    name: str = message.get_type()
    second = message.fmt.columns[1:2]
    field = getattr(message.fmt, "instance_field", None) or next(
        (each for each in second if each in INSTANCE_COLUMNS), None
    )
    instance = getattr(message, field) if field else 0
    return name if not isinstance(instance, int) or instance == 0 else f"{name}_{instance}"


def _columns_of_messages(
    names: Sequence[str], rows: Sequence[tuple[Any, ...]]
) -> dict[str, np.ndarray]:
    """Return the numeric columns by name."""
    return {
        name: np.array(values, dtype=float)
        for name, values in zip(names, zip(*rows, strict=True), strict=True)
        if all(isinstance(value, int | float) for value in values)
    }


def _quaternion_from_degrees(degrees: np.ndarray) -> np.ndarray:
    return quaternion_of_angles(np.radians(degrees))


def _flu_radians(degrees: np.ndarray) -> np.ndarray:
    return flu(np.radians(degrees))


def _setpoints() -> list[SignalRow]:
    """Return the rows of the setpoints of position and velocity; earlier versions wrote D for T."""
    return [
        SignalRow(topic, (f"{kind}{field}",), (f"setpoint.{before}{axis}",), unit, scaled(sign))
        for topic, letter, axis, sign in (
            ("PSCN", "N", "y", 1.0),
            ("PSCE", "E", "x", 1.0),
            ("PSCD", "D", "z", -1.0),
        )
        for field, before, unit in ((f"P{letter}", "", "m"), (f"V{letter}", "v_", "m/s"))
        for kind in ("T", "D")
    ]


ARDUPILOT_SIGNAL_ROWS = (
    *attitude_rows("ATT", ("Roll", "Pitch", "Yaw"), "estimate", _quaternion_from_degrees),
    *attitude_rows(
        "ATT", ("DesRoll", "DesPitch", "DesYaw"), "attitude_setpoint", _quaternion_from_degrees
    ),
    *attitude_rows(
        "SIM", ("Roll", "Pitch", "Yaw"), "position_data", _quaternion_from_degrees, "attitude"
    ),
    SignalRow("XKF1", ("PN", "PE", "PD"), component_names("estimate."), "m", enu),
    SignalRow("XKF1", ("VN", "VE", "VD"), component_names("estimate.v_"), "m/s", enu),
    SignalRow("NKF1", ("PN", "PE", "PD"), component_names("estimate."), "m", enu),
    SignalRow("NKF1", ("VN", "VE", "VD"), component_names("estimate.v_"), "m/s", enu),
    SignalRow("IMU", ("GyrX", "GyrY", "GyrZ"), GYRO_SIGNALS, "rad/s", flu),
    SignalRow("IMU", ("AccX", "AccY", "AccZ"), ACCELEROMETER_SIGNALS, "m/s^2", flu),
    SignalRow("RATE", ("R", "P", "Y"), component_names("estimate.w_"), "rad/s", _flu_radians),
    SignalRow(
        "RATE", ("RDes", "PDes", "YDes"), component_names("rate_setpoint.w_"), "rad/s", _flu_radians
    ),
    SignalRow("RATE", ("ROut", "POut", "YOut"), component_names("torque_setpoint."), "1", flu),
    *_setpoints(),
    SignalRow("CTUN", ("ThO",), ("attitude_setpoint.thrust",), "1"),
    *(
        SignalRow(
            f"ESC_{i}" if i else "ESC",
            ("RPM",),
            (f"rotors.speed.{i}",),
            "rad/s",
            scaled(RPM_IN_RAD_S),
        )
        for i in range(len(MOTOR_FUNCTIONS))
    ),
)
"""Signals of ArduPilot's messages."""


def _primary_core_rows(tables: Mapping[str, MessageTable]) -> list[SignalRow]:
    """Return the rows of position and velocity of the estimator's core that flew most of the log.

    XKF4 and NKF4 state it; the rows of all logs are those of the first core.
    """
    rows = []
    for kind in ("XKF", "NKF"):
        table = tables.get(f"{kind}4")
        cores = table.fields.get("PI", np.empty(0)) if table else np.empty(0)
        cores = cores[np.isfinite(cores)]
        core = round(float(np.median(cores))) if len(cores) else 0
        if core > 0:
            rows += [
                row._replace(topic=f"{row.topic}_{core}")
                for row in ARDUPILOT_SIGNAL_ROWS
                if row.topic == f"{kind}1"
            ]
    return rows


def _dataflash_battery_rows(tables: Mapping[str, MessageTable]) -> tuple[list[SignalRow], str]:
    """Return the rows of the first battery with a voltage, and a remark if there are several."""
    names = [
        name
        for name in ("BAT", *(f"BAT_{i}" for i in range(1, MAX_DATAFLASH_BATTERIES)))
        if name in tables
    ]
    used = [
        name
        for name in names
        if "Volt" in tables[name].fields
        and np.median(tables[name].fields["Volt"]) > MIN_DATAFLASH_BATTERY_V
    ]
    rows = [
        SignalRow(name, (field,), (f"battery.{what}",), unit)
        for name in (used or names)[:1]
        for field, what, unit in (("Volt", "voltage", "V"), ("Curr", "current", "A"))
    ]
    if len(used) < 2:
        return rows, ""
    return rows, several_batteries_remark(used)


def motor_channels(parameters: Mapping[str, float | str], firmware: str) -> dict[int, int]:
    """Return the channels of the motors, by the number of the motor.

    Without parameters they are the first four channels of a copter.
    """
    channels = {}
    servos = SERVOS_BY_FRAME_CLASS.get(parameter_number(parameters, "FRAME_CLASS"), ())
    for channel in range(1, 33):
        function = parameters.get(
            f"SERVO{channel}_FUNCTION", parameters.get(f"RC{channel}_FUNCTION")
        )
        if function in MOTOR_FUNCTIONS:
            motor = MOTOR_FUNCTIONS.index(int(function)) + 1
            if motor not in servos:
                channels[motor] = channel
    if not channels and "Copter" in firmware:
        channels = {motor: motor for motor in (1, 2, 3, 4)}
    return channels


def _dataflash_motor_rows(
    tables: Mapping[str, MessageTable], parameters: Mapping[str, float | str], firmware: str
) -> tuple[list[SignalRow], str]:
    """Return the rows of the motor commands, and a remark."""
    low, full = output_range(parameters)
    rows = [
        SignalRow(
            topic, (f"C{channel}",), (f"motors.command_{motor}",), "1", motor_share(low, full)
        )
        for motor, channel in sorted(motor_channels(parameters, firmware).items())
        for topic in OUTPUT_MESSAGES
        if topic in tables and f"C{channel}" in tables[topic].fields
    ]
    if not rows:
        return [], "the log names no motors: the purpose of the outputs is not known"
    return rows, f"the motors' commands are RCOU's channels, {low:g} to {full:g} us"


def output_range(parameters: Mapping[str, float | str]) -> tuple[float, float]:
    """Return the limits of the outputs to motors [us].

    Without limits of their own they are those of the throttle stick; digital ones have none.
    """
    if parameter_number(parameters, "MOT_PWM_TYPE") in DSHOT_OUTPUT_TYPES:
        return 1000.0, 2000.0
    throttle = int(parameter_number(parameters, "RCMAP_THROTTLE")) or 3
    for low, full in (("MOT_PWM_MIN", "MOT_PWM_MAX"), (f"RC{throttle}_MIN", f"RC{throttle}_MAX")):
        limits = parameter_number(parameters, low), parameter_number(parameters, full)
        if 0.0 < limits[0] < limits[1]:
            return limits
    return 1000.0, 2000.0


LOG_READER = LogReader(
    DATAFLASH_FORMAT,
    "ArduPilot's .bin",
    lambda _, head: begins_with(head, DATAFLASH_MAGIC),
    lambda file: read_dataflash(file.path),
    place=20,
    endings=(".bin",),
    package=DATAFLASH_READER_PACKAGE,
    needs_plain=True,
    firmware="ardupilot",
)
