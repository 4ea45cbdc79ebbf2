"""Read the CSV of a simulated flight that `workbench fly --csv` writes: states and commands.

It has the true motion. Gyro and accelerometer are those of an ideal IMU at the origin of the base
link.
"""

import csv
import math
from array import array
from collections.abc import Callable, Iterable, Sequence
from pathlib import Path

import numpy as np

from workbench.common.errors import WorkbenchError
from workbench.common.flight import Flight, LogRemark
from workbench.common.series import Series, make_series
from workbench.extras.flightdata.readers.clock import SampleClock, read_clock, stamps_of
from workbench.extras.flightdata.readers.mapped_csv import is_described
from workbench.logs.logged_signal import ACCELEROMETER_SIGNALS, GYRO_SIGNALS, component_names
from workbench.logs.readers.log_reader import LogReader
from workbench.logs.readers.packed import PackedFile, log_stem
from workbench.logs.readers.rotations import QUATERNION_NAMES, continuous, vectors_in_world
from workbench.plant.gravity import GRAVITY

STATES_CSV_FORMAT = "states of a simulated flight"
STATES_CSV_HEAD = b"t [s],p_W.x [m],"
_SIGNAL_BY_COMMAND_COLUMN = {
    "command.v_x": ("command_velocity.v_x", "m/s"),
    "command.v_y": ("command_velocity.v_y", "m/s"),
    "command.v_z": ("command_velocity.v_z", "m/s"),
    "command.yaw_rate": ("command_velocity.yaw_rate", "rad/s"),
    **{f"setpoint.{axis}": (f"setpoint.{axis}", "m") for axis in "xyz"},
}
"""Columns of commands and setpoints, with their signals and units."""


def read_states(path: Path) -> Flight:
    """Read the states of a flight without damaged rows.

    Raises:
        WorkbenchError: if it cannot be read, or lacks columns.
    """
    file = PackedFile(path)
    lines = file.lines()
    names = [name.split(" [")[0] for name in next(csv.reader([next(lines)]))]
    columns, clock, damage = clocked_columns(file, lines, names, _finite_time_row)
    try:
        time = columns["t"]
        q = continuous(_three_columns(columns, "q_WB", "wxyz"))
        back = q * [1.0, -1.0, -1.0, -1.0]
        gyro = vectors_in_world(back, _three_columns(columns, "w_W"))
        force = vectors_in_world(back, _three_columns(columns, "vdot_W") + [0.0, 0.0, GRAVITY])
        groups = [
            (component_names("position_data."), "m", _three_columns(columns, "p_W")),
            (component_names("velocity_data.v_"), "m/s", _three_columns(columns, "v_W")),
            (component_names("velocity_data.w_"), "rad/s", _three_columns(columns, "w_W")),
            (component_names("attitude.", QUATERNION_NAMES), "1", q),
            (component_names("attitude.w_"), "rad/s", gyro),
            (GYRO_SIGNALS, "rad/s", gyro),
            (ACCELEROMETER_SIGNALS, "m/s^2", force),
        ]
    except (KeyError, ValueError) as error:
        raise WorkbenchError(
            f"{path}: is not a complete CSV of states as `workbench fly --csv` writes it: {error}"
        ) from error
    signals: dict[str, Series] = {}

    def add(name: str, unit: str, values: np.ndarray) -> None:
        signals[name] = make_series(
            name, unit, time, values, end=clock.end, delay=0.0, breaks=clock.breaks
        )

    for names, unit, table in groups:
        for name, values in zip(names, table.T, strict=True):
            add(name, unit, values)
    for column, (name, unit) in _SIGNAL_BY_COMMAND_COLUMN.items():
        if column in columns:
            add(name, unit, _from_then_on(columns[column]))
    number = 1
    while f"speed_command.{number}" in columns:
        for source, name in (("speed_command", "speed_command"), ("speed", "speed")):
            values = columns[f"{source}.{number}"]
            values = _from_then_on(values) if source == "speed_command" else values
            add(f"rotors.{name}.{number - 1}", "rad/s", values)
        number += 1
    return Flight(
        name=log_stem(path),
        source=path,
        format=STATES_CSV_FORMAT,
        firmware="workbench",
        remarks=(*filter(None, (file.remark, damage)), *clock.remarks),
        signals=signals,
        end=clock.end,
        clock_start=clock.begin,
    )


def _finite_time_row(line: str) -> list[float]:
    row = [float(cell) for cell in line.split(",")]
    return row if math.isfinite(row[0]) else []


def clocked_columns(
    file: PackedFile,
    lines: Iterable[str],
    names: Sequence[str],
    parse: Callable[[str], list[float]],
) -> tuple[dict[str, np.ndarray], SampleClock, str]:
    """Return the complete rows of a table by column, their clock, and a remark on damaged rows.

    Args:
        file: the table, for messages.
        lines: its rows.
        names: of its columns, that of the time [s] first; its times are those of the clock.
        parse: returns the numbers of a line; none, or a ValueError, for one that is damaged.

    Raises:
        WorkbenchError: if fewer than three rows are complete.
    """
    rows, numbers, damaged = array("d"), array("q"), array("q")
    for number, line in enumerate(lines, start=2):
        try:
            row = parse(line)
        except (ValueError, OverflowError):
            row = []
        if len(row) == len(names):
            rows.extend(row)
            numbers.append(number)
        else:
            damaged.append(number)
    table = np.array(rows).reshape(-1, len(names))
    stamps = stamps_of(table[:, 0], table.T[1:])
    clock = read_clock({"rows": stamps}, 1.0, noun="line", numbers=np.array(numbers))
    table[:, 0] = clock.times["rows"]
    table = table[np.isfinite(table[:, 0])]
    if len(table) < 3:
        raise WorkbenchError(
            f"{file.path}: has fewer than three complete rows: it is empty or damaged"
        )
    remark = ""
    if damaged:
        lost, place = len(damaged), f"line {damaged[0]}"
        text = f"{lost} damaged rows were left out, the first one is {place}"
        remark = LogRemark(text, lost, place)
    return dict(zip(names, table.T, strict=True)), clock, remark


def _from_then_on(values: np.ndarray) -> np.ndarray:
    """Return the command from each row on (n), from the command up to each row."""
    return np.append(values[1:], values[-1:])


def _three_columns(columns: dict[str, np.ndarray], name: str, axes: str = "xyz") -> np.ndarray:
    return np.column_stack([columns[f"{name}.{axis}"] for axis in axes])


LOG_READER = LogReader(
    STATES_CSV_FORMAT,
    "the CSV of a simulated flight",
    lambda path, head: head.startswith(STATES_CSV_HEAD) and not is_described(path),
    lambda file: read_states(file.path),
    place=60,
)
