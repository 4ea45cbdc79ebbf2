"""Rotor commands from a table, held between its rows: flight without a controller."""

import csv
import io
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from pydrake.systems.primitives import TrajectorySource
from pydrake.trajectories import PiecewisePolynomial

from workbench.common.errors import MAX_ECHO_CHARS, WorkbenchError
from workbench.common.plain_files import read_plain_text
from workbench.common.plain_text import plain_name
from workbench.dynamics.rotor_response import speed_command
from workbench.plant.vehicle import Vehicle

MAX_COMMAND_TABLE_BYTES = 500_000_000
MIN_ROW_PERIOD_S = 1e-6
MAX_ROW_TIME_S = 1e6
"""Shortest time between rows, and latest time of a row [s]."""


@dataclass(frozen=True)
class RotorCommands:
    """A table of M rows for n rotors.

    Attributes:
        time: (M) start of each row, increasing from 0 [s].
        speeds: (M, n) rotor speeds for the table's thrusts at rest, far from the ground and with a
            full battery without load [rad/s].
    """

    time: np.ndarray
    speeds: np.ndarray


def load_rotor_commands(path: Path, vehicle: Vehicle) -> RotorCommands:
    """Read a CSV file of t [s] and one thrust [N] a rotor; a first line may name the columns.

    Raises:
        WorkbenchError: with file and line of an invalid row.
    """
    try:
        reader = csv.reader(
            io.StringIO(read_plain_text(path, MAX_COMMAND_TABLE_BYTES, "utf-8-sig"))
        )
        lines = [(reader.line_num, cells) for cells in reader if any(map(str.strip, cells))]
    except csv.Error as error:
        raise WorkbenchError(f"{path}: cannot be read as CSV: {error}") from error
    if lines and not any(_is_number(cell) for cell in lines[0][1]):
        lines = lines[1:]
    if not lines:
        raise WorkbenchError(f"{path}: has no rows: write t and a thrust in N for each rotor")
    table = np.array([_row(f"{path}:{line}: ", cells, vehicle) for line, cells in lines])
    time = table[:, 0]
    if time[0] != 0.0:
        raise WorkbenchError(f"{path}:{lines[0][0]}: the table begins at {time[0]:g} s, not at 0")
    for (line, _), before, now in zip(lines[1:], time, time[1:], strict=False):
        if not now - before >= MIN_ROW_PERIOD_S or now > MAX_ROW_TIME_S:
            raise WorkbenchError(
                f"{path}:{line}: time goes from {before:g} s to {now:g} s: let it rise by "
                f"{MIN_ROW_PERIOD_S:g} s or more, up to {MAX_ROW_TIME_S:g} s"
            )
    constants: Any = np.array([rotor.motor_constant for rotor in vehicle.rotors])
    half: Any = 0.5 * np.array([rotor.linear_speed for rotor in vehicle.rotors])
    thrusts: Any = table[:, 1:]
    speeds = speed_command(thrusts, constants, half, 1.0)
    return RotorCommands(time=time, speeds=np.asarray(speeds))


def make_rotor_playback(commands: RotorCommands) -> TrajectorySource:
    """Return a source of rotor speeds (n) [rad/s]; the last row is held."""
    # the last sample of a zero-order hold only ends the previous one
    time = np.append(commands.time, commands.time[-1] + 1.0)
    speeds = np.vstack([commands.speeds, commands.speeds[-1]])
    return TrajectorySource(PiecewisePolynomial.ZeroOrderHold(time, speeds.T))


def _row(where: str, cells: list[str], vehicle: Vehicle) -> list[float]:
    """Return a row's numbers, or refuse it."""
    rotors = vehicle.rotors
    if len(cells) != 1 + len(rotors):
        raise WorkbenchError(
            f"{where}{len(cells)} columns: {vehicle.name} takes {1 + len(rotors)}, t and the "
            f"thrusts of {len(rotors)} rotors"
        )
    for cell in cells:
        if not _is_number(cell) or not np.isfinite(float(cell)):
            shown = plain_name(cell.strip(), MAX_ECHO_CHARS)
            raise WorkbenchError(f"{where}'{shown}' is not a finite number")
    numbers = [float(cell) for cell in cells]
    for index, (thrust, rotor) in enumerate(zip(numbers[1:], rotors, strict=True), start=1):
        if not 0.0 <= thrust <= rotor.max_thrust:
            raise WorkbenchError(
                f"{where}the thrust of rotor {index} is {thrust:g} N: keep it within "
                f"0 .. {rotor.max_thrust:.4g} N"
            )
    return numbers


def _is_number(text: str) -> bool:
    try:
        float(text)
    except ValueError:
        return False
    return True
