"""`workbench new`: from a data sheet, with its units, to a flyable description."""

import argparse
import re
import shlex
import sys
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any, TypeVar

from workbench.commands import ExitCode
from workbench.commands.options import NO_SENSORS, add_command, add_json_option, add_option
from workbench.commands.outputs import Outputs
from workbench.commands.printing import print_result, print_table, say
from workbench.common.errors import LONGEST_ECHO, WorkbenchError
from workbench.common.resources import existing
from workbench.plant import ranges

if TYPE_CHECKING:
    from workbench.plant.data_sheet import DataSheet, Figure
    from workbench.plant.vehicle import Vehicle

_INCH = 0.0254
_GRAVITY = 9.80665
"""Standard gravity, which defines the kilogram-force [m/s²]."""
_POUND = 0.45359237
_CELL = 3.7
"""Nominal voltage of a lithium-polymer cell [V]."""
_NUMBER = r"([0-9]+\.?[0-9]*|\.[0-9]+)(?:e([+-]?[0-9]{1,2}))?"
_PROPELLER = re.compile(
    rf"{_NUMBER}\s*[x×]\s*{_NUMBER}(?:\s*[x×]\s*([0-9]))?\s*(in|inch|\")?", re.I
)
Value = TypeVar("Value")
_SUFFIX = ".urdf.xacro"
_LAYOUTS = ("x", "plus", "coaxial")
_WEAK = 1.5
"""Thrust-to-weight below which there is little reserve for a climb or a gust."""


@dataclass(frozen=True)
class Quantity:
    """A quantity with a unit.

    Attributes:
        name: its name, at the begin of a sentence.
        units: factors to the SI unit by unit; the first is the SI unit, which is optional.
        minimum: smallest possible value, in the SI unit.
        maximum: largest possible value.
        example: of the text.
        usual: its plausible range.
    """

    name: str
    units: Mapping[str, float]
    minimum: float
    maximum: float
    example: str
    usual: ranges.Range

    def read(self, text: str) -> float:
        """Return a value in the SI unit.

        Raises:
            WorkbenchError: if it is not such a quantity, or not possible.
        """
        found = re.fullmatch(rf"{_NUMBER}\s*([a-z/\"]*)", text.strip(), re.IGNORECASE)
        if found is None:
            raise self._refused(text, "is not a number with a unit")
        number = float(found[1] + (f"e{found[2]}" if found[2] else ""))
        unit = found[3].casefold() or next(iter(self.units)).casefold()
        factors = {name.casefold(): factor for name, factor in self.units.items()}
        if unit not in factors:
            raise self._refused(text, f"has no known unit (these are {', '.join(self.units)})")
        value = number * factors[unit]
        if not self.minimum <= value <= self.maximum:
            si = next(iter(self.units))
            asked = self.usual.meant(number)
            raise self._refused(
                text,
                f"is {value:g} {si}, but a multirotor has {self.minimum:g} to {self.maximum:g} "
                f"{si}{f' ({asked})' if asked else ''}",
            )
        return value

    def _refused(self, text: str, reason: str) -> WorkbenchError:
        return WorkbenchError(
            f"{self.name} '{text[:LONGEST_ECHO]}' {reason}: write it as {self.example}"
        )


_LENGTHS = {"m": 1.0, "cm": 0.01, "mm": 0.001, "in": _INCH, "inch": _INCH, '"': _INCH}
_MASSES = {"kg": 1.0, "g": 0.001, "lb": _POUND, "oz": _POUND / 16.0}
_FORCES = {
    "N": 1.0,
    "g": 0.001 * _GRAVITY,
    "gf": 0.001 * _GRAVITY,
    "kg": _GRAVITY,
    "kgf": _GRAVITY,
    "lb": _POUND * _GRAVITY,
    "lbf": _POUND * _GRAVITY,
    "oz": _POUND * _GRAVITY / 16.0,
}
MASS = Quantity("the mass", _MASSES, 0.005, 500.0, "1.2kg or 1200g", ranges.MASS)
MOTOR_MASS = Quantity("the mass of a motor", _MASSES, 1e-4, 50.0, "80g", ranges.MOTOR_MASS)
ARM = Quantity("the arm", _LENGTHS, 0.01, 5.0, "225mm or 0.225m", ranges.ARM)
DIAGONAL = Quantity("the diagonal", _LENGTHS, 0.02, 10.0, "450mm or 0.45m", ranges.DIAGONAL)
DIAMETER = Quantity(
    "the propeller's diameter", _LENGTHS, 0.01, 3.0, "10in, 254mm or 10x4.5", ranges.DIAMETER
)
MAX_THRUST = Quantity(
    "the largest thrust", _FORCES, 0.01, 2000.0, "850g or 8.3N", ranges.MAX_THRUST
)
MOTOR_KV = Quantity(
    "the motor's KV", {"KV": 1.0, "rpm/V": 1.0}, 10.0, 50_000.0, "920KV", ranges.MOTOR_KV
)
_VOLTAGE = Quantity("the battery's voltage", {"V": 1.0}, 1.0, 1000.0, "4S or 14.8V", ranges.VOLTAGE)
_CELLS = Quantity("the battery", {"S": _CELL}, _CELL, 60.0 * _CELL, "4S or 14.8V", ranges.VOLTAGE)
_CAPACITY = Quantity(
    "the battery's capacity",
    {"Ah": 1.0, "mAh": 0.001},
    0.01,
    1000.0,
    "5000mAh or 5Ah",
    ranges.CAPACITY,
)


def read_propeller(text: str) -> tuple[float, float | None, int]:
    """Return diameter [m], pitch [m] if given, and the number of blades.

    `10x4.5` is in inches, as on every propeller; a third number counts blades. A diameter alone
    has a unit.

    Raises:
        WorkbenchError: if it is neither.
    """
    found = _PROPELLER.fullmatch(text.strip())
    if found is None:
        return DIAMETER.read(text), None, 2
    diameter, pitch = (float(found[group]) * _INCH for group in (1, 3))
    blades = int(found[5] or 2)
    if not 0.1 * diameter <= pitch <= 1.5 * diameter or not 2 <= blades <= 8:
        raise WorkbenchError(
            f"'{text}' is not a propeller: write diameter x pitch in inches as 10x4.5, and "
            "blades where they are more than two, as 5x4.3x3"
        )
    return DIAMETER.read(f"{diameter}m"), pitch, blades


def read_battery(text: str) -> tuple[float, float | None]:
    """Return nominal voltage [V] and, if given, capacity [A·h] from `4S` or `4S 5000mAh`.

    Raises:
        WorkbenchError: if it is none.
    """
    voltage, *capacity = re.split(r"[\s,]+", text.strip())
    if len(capacity) > 1:
        raise WorkbenchError(f"'{text[:LONGEST_ECHO]}' is not a battery: write it as '4S 5000mAh'")
    kind = _CELLS if voltage[-1:] in ("s", "S") else _VOLTAGE
    return kind.read(voltage), _CAPACITY.read(capacity[0]) if capacity else None


def add_parser(commands: Any) -> None:
    """Add the command."""
    parser = add_command(
        commands,
        "new",
        "Write the description of a multirotor from its data sheet, with estimates of what a data "
        "sheet does not say; on a terminal it asks for what is not given.",
        "workbench new my_quad --mass 1.4kg --diagonal 450mm --propeller 10x4.5 "
        '--motor-kv 920KV --battery "4S 5000mAh"',
        run,
    )
    parser.add_argument(
        "file", metavar="FILE", help=f"to be written; {_SUFFIX} is added to a plain name"
    )
    sheet = parser.add_argument_group("data sheet")
    sheet.add_argument("--mass", type=MASS.read, help="all-up, with the battery: 1.4kg")
    size = sheet.add_mutually_exclusive_group()
    size.add_argument(
        "--arm", type=ARM.read, metavar="LENGTH", help="from the centre to a rotor's axis: 225mm"
    )
    size.add_argument(
        "--diagonal", type=DIAGONAL.read, metavar="LENGTH", help="twice the arm: 450mm"
    )
    sheet.add_argument(
        "--propeller",
        type=read_propeller,
        metavar="SIZE",
        help="diameter x pitch in inches, and blades where they are not two: 10x4.5, 5x4.3x3; or a "
        "diameter: 10in",
    )
    sheet.add_argument(
        "--max-thrust",
        type=MAX_THRUST.read,
        metavar="FORCE",
        help="largest thrust of one motor with this propeller: 850g",
    )
    sheet.add_argument(
        "--thrust-curve",
        type=Path,
        metavar="FILE",
        help="table (CSV) of rpm and thrust_g or thrust_N of one motor, and torque_Nm if measured",
    )
    sheet.add_argument(
        "--motor-kv", type=MOTOR_KV.read, metavar="KV", help="speed over voltage: 920KV"
    )
    sheet.add_argument(
        "--motor-mass",
        type=MOTOR_MASS.read,
        metavar="MASS",
        help="of one motor with propeller and speed controller: 90g",
    )
    sheet.add_argument(
        "--battery",
        type=read_battery,
        metavar="SIZE",
        help='cells or voltage, and capacity: 4S, "4S 5000mAh", "14.8V 5Ah"',
    )
    add_option(sheet, "--rotors", "N", "how many", 4)
    sheet.add_argument(
        "--layout",
        choices=_LAYOUTS,
        default="x",
        help="two arms in front, one arm in front, or two rotors on each arm (default: x)",
    )
    sheet.add_argument(
        "--sensors",
        default="",
        metavar="KIND[,KIND]",
        help="with usual numbers: imu, gps, barometer, magnetometer, range_finder, lidar, "
        f"depth_camera, all, or {NO_SENSORS} (default: {NO_SENSORS})",
    )
    parser.add_argument("--force", action="store_true", help="replace an existing file")
    add_json_option(parser)


def run(args: argparse.Namespace) -> int:
    """Ask for missing numbers, write the description, and report estimates."""
    target = _target(args.file, replace=args.force)
    asks = sys.stdin.isatty() and not args.json
    _complete(args, _ask if asks else _missing)
    sheet = _sheet(args, target)

    from workbench.plant.data_sheet import check_lift, figures, write_xacro
    from workbench.plant.loading import load_vehicle
    from workbench.plant.plausible import doubts

    found = figures(sheet)
    check_lift(sheet, found)
    with Outputs() as outputs:
        draft = outputs.add(target)
        draft.write_text(write_xacro(sheet, found), encoding="utf-8")
        vehicle = load_vehicle(draft)  # verify that the written description flies
    made = (target, sheet, found, vehicle)
    unlikely = [*_slips(sheet), *doubts(vehicle)]
    if sheet.voltage is not None and not sheet.has_battery:
        unlikely.append(
            'no battery is described without its capacity: give both, as --battery "4S 5000mAh"'
        )
    result = _result(*made) | {"warnings": unlikely}
    print_result(args, result, _print, *made, files=[target])
    for each in unlikely:
        say(each)
    if vehicle.thrust_to_weight < _WEAK:
        say(
            f"a thrust-to-weight of {vehicle.thrust_to_weight:.2g} leaves little for a climb or a "
            "gust: multirotors have 1.8 to 3, racers more"
        )
    return ExitCode.DONE


def _target(file: str, *, replace: bool) -> Path:
    """Return the path to write.

    Raises:
        WorkbenchError: if its name is invalid, or the path exists.
    """
    target = Path(file)
    if not target.suffix:
        target = target.with_name(f"{target.name}{_SUFFIX}")
    stem = target.name.removesuffix(".xacro").removesuffix(".urdf")
    if target.suffix != ".xacro" or not re.fullmatch(r"[A-Za-z0-9][\w.-]*", stem):
        raise WorkbenchError(
            f"{file}: the description is written as xacro: name it as my_quad{_SUFFIX}"
        )
    if existing(str(target)) and not replace:
        raise WorkbenchError(f"{target}: exists already: name another file, or give --force")
    return target


def _complete(args: argparse.Namespace, ask: Callable[[str, Callable[[str], Any]], Any]) -> None:
    """Ask for required numbers of a description, and for useful ones."""
    asked = ask is _ask
    if args.mass is None:
        args.mass = ask("--mass: all-up mass with battery, as 1.4kg", MASS.read)
    if args.arm is None and args.diagonal is None:
        args.diagonal = ask("--diagonal: from rotor to opposite rotor, as 450mm", DIAGONAL.read)
    if args.propeller is None:
        args.propeller = ask("--propeller: diameter x pitch in inches, as 10x4.5", read_propeller)
    strong = args.max_thrust is not None or args.thrust_curve is not None
    if not asked:
        return
    if not strong and args.motor_kv is None:
        args.max_thrust = ask(
            "--max-thrust: of one motor with this propeller, as 850g (empty if unknown)",
            _or_none(MAX_THRUST.read),
        )
        if args.max_thrust is None:
            args.motor_kv = ask("--motor-kv: of the motors, as 920KV", MOTOR_KV.read)
    if args.battery is None:
        needed = args.max_thrust is None and args.thrust_curve is None
        args.battery = ask(
            "--battery: cells and capacity, as 4S 5000mAh" + ("" if needed else " (may be empty)"),
            read_battery if needed else _or_none(read_battery),
        )


def _ask(what: str, read: Callable[[str], Value]) -> Value:
    """Ask on the terminal until the answer is valid."""
    option, _, question = what.partition(": ")
    while True:
        print(f"{option.removeprefix('--')}, {question}: ", end="", file=sys.stderr, flush=True)
        line = sys.stdin.readline()
        if not line:
            raise WorkbenchError(f"{option} is missing: the input ended")
        try:
            return read(line.strip())
        except WorkbenchError as error:
            say(str(error))


def _missing(what: str, read: Callable[[str], Value]) -> Value:
    """Raise an error, as there is no terminal to ask on."""
    option, _, example = what.partition(": ")
    raise WorkbenchError(f"{option} is missing: give the {example}")


def _or_none(read: Callable[[str], Value]) -> Callable[[str], Value | None]:
    """Return a reader that accepts an empty answer as None."""
    return lambda text: read(text) if text else None


def _sheet(args: argparse.Namespace, target: Path) -> "DataSheet":
    """Return the data sheet from the command line and the answers."""
    from workbench.plant.data_sheet import DataSheet, Propeller, read_thrust_curve
    from workbench.plant.sensor_blocks import sensor_blocks

    voltage, capacity = args.battery or (None, None)
    sheet = DataSheet(
        name=target.name.removesuffix(".xacro").removesuffix(".urdf"),
        mass=args.mass,
        arm=args.diagonal / 2.0 if args.arm is None else args.arm,
        propeller=Propeller(*args.propeller),
        rotors=args.rotors,
        layout=args.layout,
        measured=read_thrust_curve(args.thrust_curve) if args.thrust_curve else None,
        max_thrust=args.max_thrust,
        motor_kv=args.motor_kv,
        voltage=voltage,
        capacity=capacity,
        motor_mass=args.motor_mass,
        sensors=sensor_blocks([each.strip() for each in args.sensors.split(",") if each.strip()]),
    )
    sheet.check()
    return sheet


def _slips(sheet: "DataSheet") -> list[str]:
    """Return a clause for each number of a data sheet that is implausible."""
    cells = None if sheet.voltage is None else sheet.voltage / _CELL
    given = [
        (ranges.MASS, sheet.mass),
        (ranges.MOTOR_MASS, sheet.motor_mass),
        (ranges.ARM, sheet.arm),
        (ranges.DIAMETER, sheet.propeller.diameter),
        (ranges.MOTOR_KV, sheet.motor_kv),
        (ranges.VOLTAGE, sheet.voltage),
        (ranges.CAPACITY, sheet.capacity),
    ]
    found = [limit.clause(value) for limit, value in given if value is not None]
    if cells and ranges.VOLTAGE.holds(sheet.voltage or 0.0) and not ranges.CELLS.holds(cells):
        found.append(
            f"a battery of {sheet.voltage:g} V has {cells:.0f} cells in series, and multirotors "
            f"have {ranges.CELLS.least:g} to {ranges.CELLS.most:g}: did you mean {cells / 10:.0f}S?"
        )
    if sheet.max_thrust is not None:
        usual = 2.0 * sheet.mass * _GRAVITY / sheet.rotors
        share = sheet.max_thrust / usual
        if not ranges.THRUST_TO_WEIGHT.holds(2.0 * share):
            units = [
                unit
                for unit, factor in ranges.MAX_THRUST.others.items()
                if ranges.THRUST_TO_WEIGHT.holds(2.0 * share * factor)
            ]
            asked = f"did you mean {sheet.max_thrust:.4g} {units[0]}?" if units else "is it in N?"
            found.append(
                f"{sheet.max_thrust:.4g} N a rotor is {share:.3g} times the usual {usual:.3g} N of "
                f"a drone of {sheet.mass:.4g} kg with {sheet.rotors} rotors: {asked}"
            )
    return [clause for clause in dict.fromkeys(found) if clause]


def _hover(vehicle: "Vehicle") -> tuple[float, float, float]:
    """Return shares of speed and thrust in hover, and the power of all rotors [W]."""
    rotors = list(zip(vehicle.rotors, vehicle.hover_speeds.tolist(), strict=True))
    speed = max(speed / rotor.max_rot_velocity for rotor, speed in rotors)
    power = sum(rotor.moment_constant * rotor.motor_constant * speed**3 for rotor, speed in rotors)
    return speed, speed**2, power


def _hover_time(found: "list[Figure]") -> float | None:
    """Return the hover time with a full battery [s], None if the battery is unknown."""
    return next((each.value for each in found if each.name == "hover_duration"), None)


def _next(target: Path) -> str:
    return f"workbench hover --model {shlex.quote(str(target))}"


def _result(
    target: Path, sheet: "DataSheet", found: "list[Figure]", vehicle: "Vehicle"
) -> dict[str, Any]:
    """Return the result for JSON, in SI units."""
    speed, thrust, power = _hover(vehicle)
    return {
        "file": target,
        "name": vehicle.name,
        "figures": found,
        "thrust_to_weight": vehicle.thrust_to_weight,
        "hover_speed_share": speed,
        "hover_thrust_share": thrust,
        "hover_power": power,
        "hover_time": _hover_time(found),
        "next": _next(target),
    }


def _print(target: Path, sheet: "DataSheet", found: "list[Figure]", vehicle: "Vehicle") -> None:
    """Print the estimates with their sources, and the numbers of hover."""
    from workbench.plant.data_sheet import GIVEN

    print(
        f"{vehicle.name}: {vehicle.mass:.4g} kg, {sheet.rotors} rotors ({sheet.layout}) "
        f"{sheet.arm:.4g} m from the centre, propellers {sheet.propeller.label}"
    )
    print("\nestimated; replace each in the file when you have measured it")
    print_table(
        [
            (
                f"  {each.name}",
                f"{each.value:.4g}",
                "" if each.unit == "1" else each.unit,
                each.source,
            )
            for each in found
            if each.source != GIVEN
        ],
        left=(0, 2, 3),
    )
    speed, thrust, _ = _hover(vehicle)
    print(f"\nthrust to weight  {vehicle.thrust_to_weight:.2f}")
    print(
        f"hover throttle    {100 * speed:.0f} % of the largest speed, "
        f"{100 * thrust:.0f} % of the largest thrust"
    )
    seconds = _hover_time(found)
    if seconds is not None:
        print(f"hover time        about {seconds / 60.0:.0f} min")
    print(f"\nnext: {_next(target)}")
