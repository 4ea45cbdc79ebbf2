"""Read the CSV of a simulated flight that `workbench fly --csv` writes: states and commands.

It has the true motion. Gyro and accelerometer are those of an ideal IMU at the origin of the base
link.
"""

import csv
import math
from array import array
from collections.abc import Iterable, Sequence
from pathlib import Path

import numpy as np

from workbench.common.errors import WorkbenchError
from workbench.logs.flight_record import (
    FORCE,
    GYRO,
    FlightRecord,
    Remark,
    Signal,
    make_signal,
    parts,
)
from workbench.logs.readers.clock import read_clock, stamps_of
from workbench.logs.readers.packed import PackedFile, stem
from workbench.logs.readers.rotations import QUATERNION, continuous, in_world
from workbench.plant.gravity import GRAVITY

FORMAT = "states of a simulated flight"
HEAD = b"t [s],p_W.x [m],"
_COMMANDS = {
    "command.v_x": ("command_velocity.v_x", "m/s"),
    "command.v_y": ("command_velocity.v_y", "m/s"),
    "command.v_z": ("command_velocity.v_z", "m/s"),
    "command.yaw_rate": ("command_velocity.yaw_rate", "rad/s"),
    **{f"setpoint.{axis}": (f"setpoint.{axis}", "m") for axis in "xyz"},
}
"""Columns of commands and setpoints, with their signals and units."""


def read_states(path: Path) -> FlightRecord:
    """Read the states of a flight without damaged rows.

    Raises:
        WorkbenchError: if it cannot be read, or lacks columns.
    """
    file = PackedFile(path)
    lines = file.lines()
    head = next(csv.reader([next(lines)]))
    table, numbers, damaged = _table(lines, len(head))
    clock = read_clock(
        {"rows": stamps_of(table[:, 0], table.T[1:])},
        1.0,
        noun="line",
        numbers=numbers,
    )
    table[:, 0] = clock.times["rows"]
    table = table[np.isfinite(table[:, 0])]
    if len(table) < 3:
        raise WorkbenchError(f"{path}: has fewer than three complete rows: it is empty or damaged")
    remarks: list[str] = [file.remark] if file.remark else []
    if damaged:
        place = f"line {damaged[0]}"
        text = f"{len(damaged)} damaged rows were left out, the first one is {place}"
        remarks.append(Remark(text, len(damaged), place))
    try:
        columns = dict(zip((name.split(" [")[0] for name in head), table.T, strict=True))
        time = columns["t"]
        q = continuous(_three(columns, "q_WB", "wxyz"))
        back = q * [1.0, -1.0, -1.0, -1.0]
        gyro = in_world(back, _three(columns, "w_W"))
        force = in_world(back, _three(columns, "vdot_W") + [0.0, 0.0, GRAVITY])
        groups = [
            (parts("position_data."), "m", _three(columns, "p_W")),
            (parts("velocity_data.v_"), "m/s", _three(columns, "v_W")),
            (parts("velocity_data.w_"), "rad/s", _three(columns, "w_W")),
            (parts("attitude.", QUATERNION), "1", q),
            (parts("attitude.w_"), "rad/s", gyro),
            (GYRO, "rad/s", gyro),
            (FORCE, "m/s^2", force),
        ]
    except (KeyError, ValueError) as error:
        raise WorkbenchError(
            f"{path}: is not a complete CSV of states as `workbench fly --csv` writes it: {error}"
        ) from error
    signals: dict[str, Signal] = {}

    def add(name: str, unit: str, values: np.ndarray) -> None:
        signals[name] = make_signal(
            name, unit, time, values, end=clock.end, delay=0.0, breaks=clock.breaks
        )

    for names, unit, table in groups:
        for name, values in zip(names, table.T, strict=True):
            add(name, unit, values)
    for column, (name, unit) in _COMMANDS.items():
        if column in columns:
            add(name, unit, _from_then_on(columns[column]))
    number = 1
    while f"speed_command.{number}" in columns:
        for source, name in (("speed_command", "speed_command"), ("speed", "speed")):
            values = columns[f"{source}.{number}"]
            values = _from_then_on(values) if source == "speed_command" else values
            add(f"rotors.{name}.{number - 1}", "rad/s", values)
        number += 1
    return FlightRecord(
        name=stem(path),
        source=path,
        format=FORMAT,
        firmware="workbench",
        remarks=(*remarks, *clock.remarks),
        signals=signals,
        end=clock.end,
    )


def _table(lines: Iterable[str], width: int) -> tuple[np.ndarray, np.ndarray, Sequence[int]]:
    """Return the complete rows of numbers (n, width), their lines, and those that are not."""
    rows, numbers, damaged = array("d"), array("q"), array("q")
    for number, line in enumerate(lines, start=2):
        try:
            row = [float(cell) for cell in line.split(",")]
        except ValueError:
            row = []
        if len(row) == width and math.isfinite(row[0]):
            rows.extend(row)
            numbers.append(number)
        else:
            damaged.append(number)
    return np.array(rows).reshape(-1, width), np.array(numbers), damaged


def _from_then_on(values: np.ndarray) -> np.ndarray:
    """Return the command from each row on (n), from the command up to each row."""
    return np.append(values[1:], values[-1:])


def _three(columns: dict[str, np.ndarray], name: str, axes: str = "xyz") -> np.ndarray:
    return np.column_stack([columns[f"{name}.{axis}"] for axis in axes])
