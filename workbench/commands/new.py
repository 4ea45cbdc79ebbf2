"""`workbench new`: from a data sheet, with its units, to a flyable description."""

import argparse
import shlex
import sys
from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING, Any, TypeVar

from workbench.commands import ExitCode
from workbench.commands.options import (
    NO_SENSORS,
    Subcommands,
    add_command,
    add_json_option,
    add_option,
)
from workbench.commands.outputs import Outputs
from workbench.commands.printing import print_message, print_result, print_table
from workbench.common.errors import WorkbenchError
from workbench.common.resources import existing_path
from workbench.plant import ranges
from workbench.plant.quantity_input import (
    ARM_INPUT,
    DIAGONAL_INPUT,
    DRONE_FILE_ENDING,
    KILOGRAM_FORCE_N,
    LIPO_CELL_V,
    MASS_INPUT,
    MAX_THRUST_INPUT,
    MOTOR_KV_INPUT,
    MOTOR_MASS_INPUT,
    is_drone_name,
    parse_battery,
    parse_propeller,
)

if TYPE_CHECKING:
    from workbench.plant.data_sheet import DataSheet
    from workbench.plant.sheet_figures import SheetFigure
    from workbench.plant.vehicle import Vehicle

Value = TypeVar("Value")
_ROTOR_LAYOUTS = ("x", "plus", "coaxial")
_MIN_THRUST_TO_WEIGHT = 1.5
"""Thrust-to-weight below which there is little reserve for a climb or a gust."""


def add_parser(commands: Subcommands) -> None:
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
        "file", metavar="FILE", help=f"to be written; {DRONE_FILE_ENDING} is added to a plain name"
    )
    sheet = parser.add_argument_group("data sheet")
    sheet.add_argument("--mass", type=MASS_INPUT.read, help="all-up, with the battery: 1.4kg")
    size = sheet.add_mutually_exclusive_group()
    size.add_argument(
        "--arm",
        type=ARM_INPUT.read,
        metavar="LENGTH",
        help="from the centre to a rotor's axis: 225mm",
    )
    size.add_argument(
        "--diagonal", type=DIAGONAL_INPUT.read, metavar="LENGTH", help="twice the arm: 450mm"
    )
    sheet.add_argument(
        "--propeller",
        type=parse_propeller,
        metavar="SIZE",
        help="diameter x pitch in inches, and blades where they are not two: 10x4.5, 5x4.3x3; or a "
        "diameter: 10in",
    )
    sheet.add_argument(
        "--max-thrust",
        type=MAX_THRUST_INPUT.read,
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
        "--motor-kv", type=MOTOR_KV_INPUT.read, metavar="KV", help="speed over voltage: 920KV"
    )
    sheet.add_argument(
        "--motor-mass",
        type=MOTOR_MASS_INPUT.read,
        metavar="MASS",
        help="of one motor with propeller and speed controller: 90g",
    )
    sheet.add_argument(
        "--battery",
        type=parse_battery,
        metavar="SIZE",
        help='cells or voltage, and capacity: 4S, "4S 5000mAh", "14.8V 5Ah"',
    )
    add_option(sheet, "--rotor-count", "N", "how many rotors", 4)
    sheet.add_argument(
        "--layout",
        choices=_ROTOR_LAYOUTS,
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
    _complete(args, _prompt_for if asks else _fail_without_terminal)
    sheet = _sheet(args, target)

    from workbench.plant.loading import load_vehicle
    from workbench.plant.plausible import implausible_values
    from workbench.plant.sheet_figures import check_lift, sheet_figures
    from workbench.plant.sheet_xacro import write_xacro

    found = sheet_figures(sheet)
    check_lift(sheet, found)
    with Outputs() as outputs:
        draft = outputs.add(target)
        draft.write_text(write_xacro(sheet, found), encoding="utf-8")
        vehicle = load_vehicle(draft)  # verify that the written description flies
    made = (target, sheet, found, vehicle)
    unlikely = [*_implausible_numbers(sheet), *implausible_values(vehicle)]
    if sheet.voltage is not None and not sheet.has_battery:
        unlikely.append(
            'no battery is described without its capacity: give both, as --battery "4S 5000mAh"'
        )
    result = _result(*made) | {"warnings": unlikely}
    print_result(args, result, _print, *made, files=[target])
    for each in unlikely:
        print_message(each)
    if vehicle.thrust_to_weight < _MIN_THRUST_TO_WEIGHT:
        print_message(
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
        target = target.with_name(f"{target.name}{DRONE_FILE_ENDING}")
    stem = target.name.removesuffix(".xacro").removesuffix(".urdf")
    if target.suffix != ".xacro" or not is_drone_name(stem):
        raise WorkbenchError(
            f"{file}: the description is written as xacro: name it as my_quad{DRONE_FILE_ENDING}"
        )
    if existing_path(str(target)) and not replace:
        raise WorkbenchError(f"{target}: exists already: name another file, or give --force")
    return target


def _complete(args: argparse.Namespace, ask: Callable[[str, Callable[[str], Any]], Any]) -> None:
    """Ask for required numbers of a description, and for useful ones."""
    asked = ask is _prompt_for
    if args.mass is None:
        args.mass = ask("--mass: all-up mass with battery, as 1.4kg", MASS_INPUT.read)
    if args.arm is None and args.diagonal is None:
        args.diagonal = ask(
            "--diagonal: from rotor to opposite rotor, as 450mm", DIAGONAL_INPUT.read
        )
    if args.propeller is None:
        args.propeller = ask("--propeller: diameter x pitch in inches, as 10x4.5", parse_propeller)
    strong = args.max_thrust is not None or args.thrust_curve is not None
    if not asked:
        return
    if not strong and args.motor_kv is None:
        args.max_thrust = ask(
            "--max-thrust: of one motor with this propeller, as 850g (empty if unknown)",
            _or_none(MAX_THRUST_INPUT.read),
        )
        if args.max_thrust is None:
            args.motor_kv = ask("--motor-kv: of the motors, as 920KV", MOTOR_KV_INPUT.read)
    if args.battery is None:
        needed = args.max_thrust is None and args.thrust_curve is None
        args.battery = ask(
            "--battery: cells and capacity, as 4S 5000mAh" + ("" if needed else " (may be empty)"),
            parse_battery if needed else _or_none(parse_battery),
        )


def _prompt_for(what: str, read: Callable[[str], Value]) -> Value:
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
            print_message(str(error))


def _fail_without_terminal(what: str, read: Callable[[str], Value]) -> Value:
    """Raise an error, as there is no terminal to ask on."""
    option, _, example = what.partition(": ")
    raise WorkbenchError(f"{option} is missing: give the {example}")


def _or_none(read: Callable[[str], Value]) -> Callable[[str], Value | None]:
    """Return a reader that accepts an empty answer as None."""
    return lambda text: read(text) if text else None


def _sheet(args: argparse.Namespace, target: Path) -> "DataSheet":
    """Return the data sheet from the command line and the answers."""
    from workbench.plant.data_sheet import DataSheet, Propeller
    from workbench.plant.sensor_blocks import sensor_blocks
    from workbench.plant.thrust_curve import read_thrust_curve

    voltage, capacity = args.battery or (None, None)
    sheet = DataSheet(
        name=target.name.removesuffix(".xacro").removesuffix(".urdf"),
        mass=args.mass,
        arm=args.diagonal / 2.0 if args.arm is None else args.arm,
        propeller=Propeller(*args.propeller),
        rotors=args.rotor_count,
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


def _implausible_numbers(sheet: "DataSheet") -> list[str]:
    """Return a clause for each number of a data sheet that is implausible."""
    cells = None if sheet.voltage is None else sheet.voltage / LIPO_CELL_V
    given = [
        (ranges.MASS_RANGE, sheet.mass),
        (ranges.MOTOR_MASS_RANGE, sheet.motor_mass),
        (ranges.ARM_RANGE, sheet.arm),
        (ranges.DIAMETER_RANGE, sheet.propeller.diameter),
        (ranges.MOTOR_KV_RANGE, sheet.motor_kv),
        (ranges.VOLTAGE_RANGE, sheet.voltage),
        (ranges.CAPACITY_RANGE, sheet.capacity),
    ]
    found = [limit.clause(value) for limit, value in given if value is not None]
    if (
        cells
        and ranges.VOLTAGE_RANGE.holds(sheet.voltage or 0.0)
        and not ranges.CELL_COUNT_RANGE.holds(cells)
    ):
        found.append(
            f"a battery of {sheet.voltage:g} V has {cells:.0f} cells in series, and multirotors "
            f"have {ranges.CELL_COUNT_RANGE.least:g} to {ranges.CELL_COUNT_RANGE.most:g}: did you "
            f"mean {cells / 10:.0f}S?"
        )
    if sheet.max_thrust is not None:
        usual = 2.0 * sheet.mass * KILOGRAM_FORCE_N / sheet.rotors
        share = sheet.max_thrust / usual
        if not ranges.THRUST_TO_WEIGHT_RANGE.holds(2.0 * share):
            units = [
                unit
                for unit, factor in ranges.MAX_THRUST_RANGE.others.items()
                if ranges.THRUST_TO_WEIGHT_RANGE.holds(2.0 * share * factor)
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


def _hover_time(found: "list[SheetFigure]") -> float | None:
    """Return the hover time with a full battery [s], None if the battery is unknown."""
    return next((each.value for each in found if each.name == "hover_duration"), None)


def _next(target: Path) -> str:
    return f"workbench check --model {shlex.quote(str(target))}"


def _result(
    target: Path, sheet: "DataSheet", found: "list[SheetFigure]", vehicle: "Vehicle"
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


def _print(
    target: Path, sheet: "DataSheet", found: "list[SheetFigure]", vehicle: "Vehicle"
) -> None:
    """Print the estimates with their sources, and the numbers of hover."""
    from workbench.plant.sheet_figures import GIVEN_SOURCE

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
            if each.source != GIVEN_SOURCE
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
