"""What is known of a multirotor before it is built: numbers of data sheets, and thrust curves."""

import csv
import math
from dataclasses import dataclass
from pathlib import Path

from workbench.common.errors import WorkbenchError

"""Two arms in front, one arm in front, or two arms in front with two rotors on each."""
COUNTS = {"x": (4, 6, 8, 10, 12), "plus": (4, 6, 8, 10, 12), "coaxial": (6, 8, 12)}
"""Numbers of rotors by layout."""
MOST_END_SHARE = 0.8
"""Of the mass; something has to hold the motors together."""
COLUMNS = {
    "rpm": 2.0 * math.pi / 60.0,
    "rad/s": 1.0,
    "thrust_N": 1.0,
    "thrust_g": 0.001 * 9.80665,
    "torque_Nm": 1.0,
}
"""What a column's head may be, and the factor to the SI unit."""
_SPEEDS, _THRUSTS, _TORQUES = ("rpm", "rad/s"), ("thrust_N", "thrust_g"), ("torque_Nm",)


@dataclass(frozen=True)
class Propeller:
    """A propeller as its name says it; lengths in m, pitch None where it is not known."""

    diameter: float
    pitch: float | None = None
    blades: int = 2

    @property
    def label(self) -> str:
        """Its name in inches, for people."""
        pitch = "" if self.pitch is None else f"x{self.pitch / 0.0254:.3g}"
        blades = "" if self.blades == 2 else f" with {self.blades} blades"
        return f"{self.diameter / 0.0254:.3g}{pitch} in{blades}"


@dataclass(frozen=True)
class Measured:
    """What was measured of one motor with its propeller.

    Attributes:
        motor_constant: thrust over squared speed [N s²].
        max_speed: largest speed [rad/s].
        moment_constant: torque over thrust [m]; None where no torque was measured.
        source: where it stands.
    """

    motor_constant: float
    max_speed: float
    moment_constant: float | None
    source: str


@dataclass(frozen=True)
class DataSheet:
    """What is known of a multirotor before it is built.

    Attributes:
        name: of the drone.
        mass: all-up, with battery [kg].
        arm: from the centre to a rotor's axis [m].
        propeller: of every rotor.
        rotors: how many.
        layout: one of `COUNTS`.
        measured: of one motor with this propeller, None where there is no thrust curve.
        max_thrust: of one motor with this propeller [N], None where it is not known.
        motor_kv: speed over voltage without load [RPM/V], None where it is not known.
        voltage: the battery's, nominal [V], None where it is not known.
        capacity: the battery's [A·h], None where it is not known.
        motor_mass: of one motor with its propeller and speed controller [kg]; None where it is not
            known.
    """

    name: str
    mass: float
    arm: float
    propeller: Propeller
    rotors: int = 4
    layout: str = "x"
    measured: Measured | None = None
    max_thrust: float | None = None
    motor_kv: float | None = None
    voltage: float | None = None
    capacity: float | None = None
    motor_mass: float | None = None

    @property
    def arms(self) -> int:
        """How many arms there are."""
        return self.rotors // 2 if self.layout == "coaxial" else self.rotors

    def check(self) -> None:
        """Refuse what cannot be built, or cannot fly.

        Raises:
            WorkbenchError: a sentence that says what does not go with what.
        """
        if self.rotors not in COUNTS[self.layout]:
            known = ", ".join(map(str, COUNTS[self.layout]))
            raise WorkbenchError(
                f"{self.rotors} rotors cannot be laid out as {self.layout}: it is for {known}"
            )
        gap = 2.0 * self.arm * math.sin(math.pi / self.arms)
        if self.propeller.diameter >= gap:
            raise WorkbenchError(
                f"propellers of {self.propeller.diameter:.3g} m touch each other: with arms of "
                f"{self.arm:.3g} m their axes are {gap:.3g} m apart; is the arm measured from the "
                "centre to a rotor, and the diagonal from rotor to rotor?"
            )
        if self.motor_mass and self.rotors * self.motor_mass > MOST_END_SHARE * self.mass:
            raise WorkbenchError(
                f"{self.rotors} motors of {self.motor_mass:.3g} kg leave too little of a mass of "
                f"{self.mass:.3g} kg: is the mass all-up, with the battery?"
            )
        if (
            self.measured is None
            and self.max_thrust is None
            and None in (self.motor_kv, self.voltage)
        ):
            raise WorkbenchError(
                "nothing says how strong the motors are: give the largest thrust of one "
                "(--max-thrust 850g), a thrust curve (--thrust-curve FILE), or KV and battery "
                "(--motor-kv 920KV --battery 4S)"
            )


def read_thrust_curve(path: Path) -> Measured:
    """Return the constants that fit a CSV file of one motor with its propeller.

    Its first line names the columns: `rpm` or `rad/s`, `thrust_g` or `thrust_N`, and `torque_Nm`
    where it was measured; others are not read. Thrust is fitted by k w², torque by a factor of
    thrust, both with least squares.

    Raises:
        WorkbenchError: with file and line, for what is missing or no number.
    """
    try:
        with path.open(encoding="utf-8-sig", newline="") as stream:
            rows = list(csv.DictReader(stream, skipinitialspace=True))
    except (OSError, UnicodeDecodeError, csv.Error) as error:
        raise WorkbenchError(f"{path}: cannot be read: {error}") from error
    speeds = _column(path, rows, _SPEEDS)
    thrusts = _column(path, rows, _THRUSTS)
    torques = _column(path, rows, _TORQUES) if rows and _head(rows[0], _TORQUES) else []
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
    return Measured(constant, max(speeds), moment, source)


def _head(row: dict[str, str], names: tuple[str, ...]) -> str | None:
    """Return which of some columns a table has."""
    return next((name for name in names if name in row), None)


def _column(path: Path, rows: list[dict[str, str]], names: tuple[str, ...]) -> list[float]:
    """Return a column [SI].

    Raises:
        WorkbenchError: if there is none, or one of its cells is no positive number.
    """
    head = _head(rows[0], names) if rows else None
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
            raise WorkbenchError(f"{path}:{line}: {head} '{row[head]}' is no positive number")
        values.append(COLUMNS[head] * value)
    return values
