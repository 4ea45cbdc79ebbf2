"""ArduPilot's DataFlash logs (.bin), by pymavlink.

ArduPilot's axes are north, east, down and forward, right, down, its angles in degrees. The motors'
outputs are RCOU's channels whose SERVOn_FUNCTION is a motor's; of an older log without such
parameters, of a Copter, the first four.

Source: ardupilot.org/copter/docs/logmessages.html.
"""

from collections import defaultdict
from collections.abc import Mapping, Sequence
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

FORMAT = "ArduPilot DataFlash log"
MAGIC = b"\xa3\x95"
NEEDS = "pymavlink"
MOST_MESSAGES = 20_000_000
MOTOR_1, MOTORS = 33, 8
"""SERVOn_FUNCTION of the first motor, and how many of these follow each other."""
_RPM = np.pi / 30.0
_UNWANTED = ("FMT", "FMTU", "UNIT", "MULT", "PARM", "MSG", "FILE", "VER", "ISBD", "ISBH")
"""Messages that describe the log, or are texts."""
Table = Mapping[str, np.ndarray]


def read_dataflash(path: Path) -> FlightRecord:
    """Read a log of ArduPilot.

    Raises:
        WorkbenchError: if it cannot be read, or is none.
    """
    from pymavlink.DFReader import DFReader_binary

    rows: dict[str, list[tuple[Any, ...]]] = defaultdict(list)
    columns: dict[str, list[str]] = {}
    parameters: dict[str, float | str] = {}
    firmware, damage = "", ""
    try:
        log = DFReader_binary(str(path))
        for _ in range(MOST_MESSAGES):
            message = log.recv_msg()
            if message is None:
                break
            name = message.get_type()
            if name == "PARM":
                parameters[str(message.Name)] = float(message.Value)
            elif name == "MSG" and not firmware and str(message.Message).startswith("Ardu"):
                firmware = str(message.Message)
            elif name not in _UNWANTED and "TimeUS" in message.fmt.columns:
                whose = _whose(message)
                fields = list(message.fmt.columns)
                if columns.setdefault(whose, fields) != fields:
                    raise ValueError(f"message {whose} is defined anew")
                # a damaged definition may name fields that are not there: then nothing is kept
                row = tuple(getattr(message, each) for each in fields)
                rows[whose].append(row)
    except Exception as error:  # it raises whatever its parsing meets in a damaged file
        if not rows:
            raise WorkbenchError(f"{path}: cannot be read as a DataFlash log: {error}") from error
        damage = f"the file is damaged, and was read up to there: {error}"
    tables = {name: _table(columns[name], found) for name, found in rows.items()}
    tables = {name: table for name, table in tables.items() if len(table.get("TimeUS", ())) > 0}
    if not tables:
        raise WorkbenchError(f"{path}: has no data: it is empty or damaged")
    begin = min(float(np.min(table["TimeUS"])) for table in tables.values())
    end = (max(float(np.max(table["TimeUS"])) for table in tables.values()) - begin) * 1e-6
    signals: dict[str, Signal] = {}

    def add(name: str, unit: str, table: Table, values: np.ndarray) -> None:
        if name not in signals and np.isfinite(values).any():
            time = (table["TimeUS"] - begin) * 1e-6
            signals[name] = make_signal(name, unit, time, values, end=end)

    remarks = _add_all(tables, parameters, firmware, add)
    for whose, table in tables.items():
        for field, values in table.items():
            if field != "TimeUS":
                add(own_name(whose, field), "", table, values)
    return FlightRecord(
        name=stem(path),
        source=path,
        format=FORMAT,
        firmware=firmware,
        parameters=parameters,
        remarks=tuple(filter(None, (damage, *remarks))),
        signals=signals,
        end=end,
    )


def _whose(message: Any) -> str:
    """Return a message's name, with its instance behind it where that is not the first one."""
    name: str = message.get_type()
    field = getattr(message.fmt, "instance_field", None)
    instance = getattr(message, field) if field else 0
    return name if not isinstance(instance, int) or instance == 0 else f"{name}_{instance}"


def _table(columns: Sequence[str], rows: Sequence[tuple[Any, ...]]) -> dict[str, np.ndarray]:
    """Return the columns that are numbers, by name."""
    table = {}
    for name, values in zip(columns, zip(*rows, strict=True), strict=True):
        if all(isinstance(value, int | float) for value in values):
            table[name] = np.array(values, dtype=float)
    return table


def _vector(table: Table, fields: Sequence[str]) -> np.ndarray | None:
    if not all(field in table for field in fields):
        return None
    return np.column_stack([table[field] for field in fields])


def _add_all(  # type: ignore[no-untyped-def]
    tables: Mapping[str, Table], parameters: Mapping[str, float | str], firmware: str, add
) -> list[str]:
    """Add the signals that have a name of ours, and return remarks."""

    def three(message: str, fields: Sequence[str], names: Sequence[str], unit: str, turned) -> None:  # type: ignore[no-untyped-def]
        table = tables.get(message, {})
        found = _vector(table, fields)
        if found is not None:
            for name, values in zip(names, turned(found).T, strict=True):
                add(name, unit, table, values)

    def turn(message: str, fields: Sequence[str], wanted: str) -> None:
        table = tables.get(message, {})
        degrees = _vector(table, fields)
        if degrees is not None:
            q = continuous(from_ned_frd(quaternion(*np.radians(degrees).T)))
            for name, values in zip(ANGLES, angles(q).T, strict=True):
                add(f"{wanted}.{name}", "rad", table, values)
            for name, values in zip(QUATERNION, q.T, strict=True):
                add(f"{wanted}.{name}", "1", table, values)

    def radians(degrees: np.ndarray) -> np.ndarray:
        return flu(np.radians(degrees))

    turn("ATT", ("Roll", "Pitch", "Yaw"), "estimate")
    turn("ATT", ("DesRoll", "DesPitch", "DesYaw"), "attitude_setpoint")
    turn("SIM", ("Roll", "Pitch", "Yaw"), "position_data")
    for filter_ in ("XKF1", "NKF1"):
        three(filter_, ("PN", "PE", "PD"), parts("estimate."), "m", enu)
        three(filter_, ("VN", "VE", "VD"), parts("estimate.v_"), "m/s", enu)
    three("IMU", ("GyrX", "GyrY", "GyrZ"), GYRO, "rad/s", flu)
    three("IMU", ("AccX", "AccY", "AccZ"), FORCE, "m/s^2", flu)
    three("RATE", ("R", "P", "Y"), parts("estimate.w_"), "rad/s", radians)
    three("RATE", ("RDes", "PDes", "YDes"), parts("rate_setpoint.w_"), "rad/s", radians)
    three("RATE", ("ROut", "POut", "YOut"), parts("torque_setpoint."), "1", flu)
    for message, place, speed in (("PSCN", "PN", "VN"), ("PSCE", "PE", "VE"), ("PSCD", "PD", "VD")):
        table = tables.get(message, {})
        axis = {"PSCN": "y", "PSCE": "x", "PSCD": "z"}[message]
        sign = -1.0 if axis == "z" else 1.0
        for before in ("TP", "DP"):  # wanted places; earlier versions wrote D
            if f"{before}{place[1]}" in table:
                add(f"setpoint.{axis}", "m", table, sign * table[f"{before}{place[1]}"])
        for before in ("TV", "DV"):
            if f"{before}{speed[1]}" in table:
                add(f"setpoint.v_{axis}", "m/s", table, sign * table[f"{before}{speed[1]}"])
    table = tables.get("CTUN", {})
    if "ThO" in table:
        add("attitude_setpoint.thrust", "1", table, table["ThO"])
    table = tables.get("BAT", {})
    for field, name, unit in (("Volt", "voltage", "V"), ("Curr", "current", "A")):
        if field in table:
            add(f"battery.{name}", unit, table, table[field])
    for i in range(MOTORS):
        table = tables.get("ESC" if i == 0 else f"ESC_{i}", {})
        if "RPM" in table:
            add(f"rotors.speed.{i}", "rad/s", table, _RPM * table["RPM"])
    return _add_motors(tables, parameters, firmware, add)


def _add_motors(  # type: ignore[no-untyped-def]
    tables: Mapping[str, Table], parameters: Mapping[str, float | str], firmware: str, add
) -> list[str]:
    """Add the motors' commands, and return remarks."""
    table = tables.get("RCOU", {})
    channels = {}
    for channel in range(1, 33):
        function = parameters.get(
            f"SERVO{channel}_FUNCTION", parameters.get(f"RC{channel}_FUNCTION")
        )
        if isinstance(function, float) and MOTOR_1 <= function < MOTOR_1 + MOTORS:
            channels[int(function) - MOTOR_1 + 1] = channel
    if not channels and "Copter" in firmware:
        channels = {motor: motor for motor in (1, 2, 3, 4)}
    if not table or not channels:
        return ["the log names no motors: what the outputs are is not known"]
    low = float(parameters.get("MOT_PWM_MIN", 0.0)) or 1000.0
    full = float(parameters.get("MOT_PWM_MAX", 0.0)) or 2000.0
    if not full > low:
        low, full = 1000.0, 2000.0
    for motor, channel in sorted(channels.items()):
        if f"C{channel}" in table:
            share = np.clip((table[f"C{channel}"] - low) / (full - low), 0.0, 1.0)
            add(f"motors.command_{motor}", "1", table, share)
    return [f"the motors' commands are RCOU's channels, {low:g} to {full:g} us"]
