"""Measurements of a motor, and the table that they are read from."""

import csv
import io
import math
from dataclasses import dataclass
from pathlib import Path

from workbench.common.errors import MAX_ECHO_CHARS, WorkbenchError
from workbench.common.plain_files import read_plain_text
from workbench.common.plain_text import plain_name

MAX_THRUST_TABLE_BYTES = 16_000_000
"""Size limit of a table."""
SI_FACTOR_BY_COLUMN = {
    "rpm": 2.0 * math.pi / 60.0,
    "rad/s": 1.0,
    "thrust_N": 1.0,
    "thrust_g": 0.001 * 9.80665,
    "torque_Nm": 1.0,
}
"""Allowed heads of columns, with the factor to the SI unit."""
_SPEED_COLUMNS, _THRUST_COLUMNS, _TORQUE_COLUMNS = (
    ("rpm", "rad/s"),
    ("thrust_N", "thrust_g"),
    ("torque_Nm",),
)


@dataclass(frozen=True)
class MotorMeasurement:
    """Measurements of one motor with its propeller.

    Attributes:
        motor_constant: thrust over squared speed [N s²].
        max_speed: largest speed [rad/s].
        moment_constant: torque over thrust [m]; None if no torque was measured.
        source: of the numbers.
    """

    motor_constant: float
    max_speed: float
    moment_constant: float | None
    source: str


def read_thrust_curve(path: Path) -> MotorMeasurement:
    """Return the constants fitted to a CSV file of one motor with its propeller.

    Its first line names the columns: `rpm` or `rad/s`, `thrust_g` or `thrust_N`, and `torque_Nm` if
    measured; others are ignored. Thrust is fitted by k w², torque by a multiple of thrust, both
    with least squares.

    Raises:
        WorkbenchError: with file and line, if something is missing or not a number.
    """
    try:
        text = read_plain_text(path, MAX_THRUST_TABLE_BYTES, "utf-8-sig")
        rows = list(csv.DictReader(io.StringIO(text), skipinitialspace=True))
    except csv.Error as error:
        raise WorkbenchError(f"{path}: cannot be read: {error}") from error
    speeds = _column_in_si(path, rows, _SPEED_COLUMNS)
    thrusts = _column_in_si(path, rows, _THRUST_COLUMNS)
    torques = (
        _column_in_si(path, rows, _TORQUE_COLUMNS)
        if rows and _column_heading(rows[0], _TORQUE_COLUMNS)
        else []
    )
    squares = [speed**2 for speed in speeds]
    constant = sum(t * s for t, s in zip(thrusts, squares, strict=True)) / sum(
        s * s for s in squares
    )
    moment = (
        sum(q * t for q, t in zip(torques, thrusts, strict=True)) / sum(t * t for t in thrusts)
        if torques
        else None
    )
    source = f"least squares of the {len(rows)} points in {path.name}"
    return MotorMeasurement(constant, max(speeds), moment, source)


def _column_heading(row: dict[str, str], names: tuple[str, ...]) -> str | None:
    """Return the one of several columns that a table has."""
    return next((name for name in names if name in row), None)


def _column_in_si(path: Path, rows: list[dict[str, str]], names: tuple[str, ...]) -> list[float]:
    """Return a column [SI].

    Raises:
        WorkbenchError: if it is missing, or one of its cells is not a positive number.
    """
    head = _column_heading(rows[0], names) if rows else None
    if head is None:
        raise WorkbenchError(
            f"{path}: has no column {' or '.join(names)}: its first line names them"
        )
    values = []
    for line, row in enumerate(rows, start=2):
        try:
            value = float(row[head] or "")
        except ValueError:
            value = math.nan
        if not 0.0 < value < 1e6:
            shown = plain_name(str(row[head]), MAX_ECHO_CHARS)
            raise WorkbenchError(f"{path}:{line}: {head} '{shown}' is not a positive number")
        values.append(SI_FACTOR_BY_COLUMN[head] * value)
    return values
