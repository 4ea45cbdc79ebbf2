"""Read ArduPilot's DataFlash logs (.bin), with pymavlink.

ArduPilot's axes are north, east, down and forward, right, down, with angles in degrees. The motor
outputs are the channels of RCOU whose SERVOn_FUNCTION is that of a motor. If an older log of a
Copter has no such parameters, they are the first four channels.

Source: ardupilot.org/copter/docs/logmessages.html.
"""

from collections import defaultdict
from collections.abc import Mapping, Sequence
from contextlib import closing
from pathlib import Path
from typing import Any

import numpy as np

from workbench.common.errors import WorkbenchError
from workbench.logs.flight_record import FORCE, GYRO, FlightRecord, Remark, parts
from workbench.logs.readers.rotations import continuous, enu, flu, from_ned_frd, quaternion
from workbench.logs.readers.topic_log import (
    Row,
    Table,
    attitude_rows,
    scaled,
    share,
    topic_record,
)

FORMAT = "ArduPilot DataFlash log"
MAGIC = b"\xa3\x95"
NEEDS = "pymavlink"
MOST_MESSAGES = 20_000_000
INSTANCES = ("I", "C", "Instance")
"""Names of the second column of a message that has instances, in logs that do not mark it."""
BATTERIES = 16
LEAST_VOLTAGE = 1.0
"""Voltage above which a battery is connected [V]."""
MOTOR_1 = 33
MOTORS = 8
"""SERVOn_FUNCTION of the first motor, and the number of consecutive functions of motors."""
_RPM = np.pi / 30.0
_UNWANTED = ("FMT", "FMTU", "UNIT", "MULT", "PARM", "MSG", "FILE", "VER", "ISBD", "ISBH")
"""Messages that describe the log, or are texts."""


def read_dataflash(path: Path) -> FlightRecord:
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
    firmware, damage = "", ""
    try:
        with closing(DFReader_binary(str(path))) as log:
            for place in range(MOST_MESSAGES):
                message = log.recv_msg()
                if message is None:
                    break
                name = message.get_type()
                if name == "PARM":
                    name, value = str(message.Name), float(message.Value)
                    if parameters.get(name, value) != value:
                        changed[name] = None
                    parameters[name] = value
                elif name == "MSG" and not firmware and str(message.Message).startswith("Ardu"):
                    firmware = str(message.Message)
                elif name not in _UNWANTED and "TimeUS" in message.fmt.columns:
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
        damage = Remark(text, count, f"message {count}")
    found = {topic: _columns(columns[topic], each) for topic, each in rows.items()}
    found = {topic: table for topic, table in found.items() if len(table.get("TimeUS", ())) > 0}
    if not found:
        raise WorkbenchError(f"{path}: has no data: it is empty or damaged")
    tables = {
        topic: Table(table.pop("TimeUS"), table, np.array(places[topic]))
        for topic, table in found.items()
    }
    motors, remark = _motors(tables, parameters, firmware)
    battery, several = _battery(tables)
    return topic_record(
        path,
        FORMAT,
        tables,
        [*ROWS, *battery, *motors],
        tick=1e-6,
        firmware=firmware,
        parameters=parameters,
        remarks=(damage, several, remark, _changed(list(changed))),
    )


def _changed(names: Sequence[str]) -> str:
    """Return the remark on parameters that changed."""
    if not names:
        return ""
    listed = f"{', '.join(names[:8])}{' ...' if len(names) > 8 else ''}"
    text = f"{len(names)} parameters changed in the log; the last values count: {listed}"
    return Remark(text, len(names), names[0])


def _topic(message: Any) -> str:
    """Return the name of a message, followed by its instance if that is not the first one."""
    name: str = message.get_type()
    second = message.fmt.columns[1:2]
    field = getattr(message.fmt, "instance_field", None) or next(
        (each for each in second if each in INSTANCES), None
    )
    instance = getattr(message, field) if field else 0
    return name if not isinstance(instance, int) or instance == 0 else f"{name}_{instance}"


def _columns(names: Sequence[str], rows: Sequence[tuple[Any, ...]]) -> dict[str, np.ndarray]:
    """Return the numeric columns by name."""
    return {
        name: np.array(values, dtype=float)
        for name, values in zip(names, zip(*rows, strict=True), strict=True)
        if all(isinstance(value, int | float) for value in values)
    }


def _turned(degrees: np.ndarray) -> np.ndarray:
    return continuous(from_ned_frd(quaternion(*np.radians(degrees).T)))


def _flu_radians(degrees: np.ndarray) -> np.ndarray:
    return flu(np.radians(degrees))


def _setpoints() -> list[Row]:
    """Return the rows of the setpoints of position and velocity; earlier versions wrote D for T."""
    return [
        Row(topic, (f"{kind}{field}",), (f"setpoint.{before}{axis}",), unit, scaled(sign))
        for topic, letter, axis, sign in (
            ("PSCN", "N", "y", 1.0),
            ("PSCE", "E", "x", 1.0),
            ("PSCD", "D", "z", -1.0),
        )
        for field, before, unit in ((f"P{letter}", "", "m"), (f"V{letter}", "v_", "m/s"))
        for kind in ("T", "D")
    ]


ROWS = (
    *attitude_rows("ATT", ("Roll", "Pitch", "Yaw"), "estimate", _turned),
    *attitude_rows("ATT", ("DesRoll", "DesPitch", "DesYaw"), "attitude_setpoint", _turned),
    *attitude_rows("SIM", ("Roll", "Pitch", "Yaw"), "position_data", _turned, "attitude"),
    Row("XKF1", ("PN", "PE", "PD"), parts("estimate."), "m", enu),
    Row("XKF1", ("VN", "VE", "VD"), parts("estimate.v_"), "m/s", enu),
    Row("NKF1", ("PN", "PE", "PD"), parts("estimate."), "m", enu),
    Row("NKF1", ("VN", "VE", "VD"), parts("estimate.v_"), "m/s", enu),
    Row("IMU", ("GyrX", "GyrY", "GyrZ"), GYRO, "rad/s", flu),
    Row("IMU", ("AccX", "AccY", "AccZ"), FORCE, "m/s^2", flu),
    Row("RATE", ("R", "P", "Y"), parts("estimate.w_"), "rad/s", _flu_radians),
    Row("RATE", ("RDes", "PDes", "YDes"), parts("rate_setpoint.w_"), "rad/s", _flu_radians),
    Row("RATE", ("ROut", "POut", "YOut"), parts("torque_setpoint."), "1", flu),
    *_setpoints(),
    Row("CTUN", ("ThO",), ("attitude_setpoint.thrust",), "1"),
    *(
        Row(f"ESC_{i}" if i else "ESC", ("RPM",), (f"rotors.speed.{i}",), "rad/s", scaled(_RPM))
        for i in range(MOTORS)
    ),
)
"""Signals of ArduPilot's messages."""


def _battery(tables: Mapping[str, Table]) -> tuple[list[Row], str]:
    """Return the rows of the first battery with a voltage, and a remark if there are several."""
    names = [name for name in ("BAT", *(f"BAT_{i}" for i in range(1, BATTERIES))) if name in tables]
    used = [
        name
        for name in names
        if "Volt" in tables[name].fields and np.median(tables[name].fields["Volt"]) > LEAST_VOLTAGE
    ]
    rows = [
        Row(name, (field,), (f"battery.{what}",), unit)
        for name in (used or names)[:1]
        for field, what, unit in (("Volt", "voltage", "V"), ("Curr", "current", "A"))
    ]
    if len(used) < 2:
        return rows, ""
    text = (
        f"{len(used)} batteries have a voltage: battery.voltage and battery.current are those of "
        f"{used[0]}; {', '.join(used[1:])} keep their names"
    )
    return rows, Remark(text, len(used), used[0])


def _motors(
    tables: Mapping[str, Table], parameters: Mapping[str, float | str], firmware: str
) -> tuple[list[Row], str]:
    """Return the rows of the motor commands, and a remark."""
    channels = {}
    for channel in range(1, 33):
        function = parameters.get(
            f"SERVO{channel}_FUNCTION", parameters.get(f"RC{channel}_FUNCTION")
        )
        if isinstance(function, float) and MOTOR_1 <= function < MOTOR_1 + MOTORS:
            channels[int(function) - MOTOR_1 + 1] = channel
    if not channels and "Copter" in firmware:
        channels = {motor: motor for motor in (1, 2, 3, 4)}
    if "RCOU" not in tables or not channels:
        return [], "the log names no motors: the purpose of the outputs is not known"
    low = float(parameters.get("MOT_PWM_MIN", 0.0)) or 1000.0
    full = float(parameters.get("MOT_PWM_MAX", 0.0)) or 2000.0
    if not full > low:
        low, full = 1000.0, 2000.0
    rows = [
        Row("RCOU", (f"C{channel}",), (f"motors.command_{motor}",), "1", share(low, full))
        for motor, channel in sorted(channels.items())
    ]
    return rows, f"the motors' commands are RCOU's channels, {low:g} to {full:g} us"
