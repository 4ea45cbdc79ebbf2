"""`workbench new`: from a data sheet to a description that flies."""

import argparse
import re
import sys
from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING, Any, TypeVar

from workbench.commands import ExitCode
from workbench.commands.options import add_command, add_json_option
from workbench.commands.outputs import Outputs
from workbench.commands.printing import print_json, print_table, say, say_written
from workbench.commands.quantities import (
    ARM,
    DIAGONAL,
    MASS,
    MAX_THRUST,
    MOTOR_KV,
    MOTOR_MASS,
    read_battery,
    read_propeller,
)
from workbench.common.errors import WorkbenchError

if TYPE_CHECKING:
    from workbench.plant.data_sheet import DataSheet
    from workbench.plant.estimates import Figure
    from workbench.plant.vehicle import Vehicle

Value = TypeVar("Value")
_SUFFIX = ".urdf.xacro"
_LAYOUTS = ("x", "plus", "coaxial")
_WEAK = 1.5
"""Thrust-to-weight under which little is left for a climb or a gust."""


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
    sheet.add_argument("--rotors", type=int, default=4, metavar="N", help="how many (default: 4)")
    sheet.add_argument(
        "--layout",
        choices=_LAYOUTS,
        default="x",
        help="two arms in front, one arm in front, or two rotors on each arm (default: x)",
    )
    parser.add_argument("--force", action="store_true", help="replace a file that is there")
    add_json_option(parser)


def run(args: argparse.Namespace) -> int:
    """Ask for what is missing, write the description, and say what was estimated."""
    target = _target(args.file, replace=args.force)
    asks = sys.stdin.isatty() and not args.json
    _complete(args, _ask if asks else _missing)
    sheet = _sheet(args, target)

    from workbench.plant.estimates import check_lift, figures
    from workbench.plant.formats.xacro_writer import write_xacro
    from workbench.plant.loading import load_vehicle

    found = figures(sheet)
    check_lift(sheet, found)
    with Outputs() as outputs:
        draft = outputs.add(target)
        draft.write_text(write_xacro(sheet, found), encoding="utf-8")
        vehicle = load_vehicle(draft)  # what is written is what flies
    if args.json:
        print_json(_result(target, sheet, found, vehicle))
    else:
        _print(target, sheet, found, vehicle)
    say_written([target])
    if vehicle.thrust_to_weight < _WEAK:
        say(
            f"a thrust-to-weight of {vehicle.thrust_to_weight:.2g} leaves little for a climb or a "
            "gust: multirotors have 1.8 to 3, racers more"
        )
    return ExitCode.DONE


def _target(file: str, *, replace: bool) -> Path:
    """Return what to write.

    Raises:
        WorkbenchError: if its name will not do, or something stands there.
    """
    target = Path(file)
    if not target.suffix:
        target = target.with_name(f"{target.name}{_SUFFIX}")
    stem = target.name.removesuffix(".xacro").removesuffix(".urdf")
    if target.suffix != ".xacro" or not re.fullmatch(r"[A-Za-z0-9][\w.-]*", stem):
        raise WorkbenchError(
            f"{file}: the description is written as xacro: name it as my_quad{_SUFFIX}"
        )
    if target.exists() and not replace:
        raise WorkbenchError(f"{target}: is there already: name another file, or give --force")
    return target


def _complete(args: argparse.Namespace, ask: Callable[[str, Callable[[str], Any]], Any]) -> None:
    """Fill in what a description cannot do without, and what makes it better."""
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
    """Ask on the terminal until the answer is one."""
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
    """Refuse, as nobody can be asked."""
    option, _, example = what.partition(": ")
    raise WorkbenchError(f"{option} is missing: give the {example}")


def _or_none(read: Callable[[str], Value]) -> Callable[[str], Value | None]:
    """Return a reader to which an empty answer is none."""
    return lambda text: read(text) if text else None


def _sheet(args: argparse.Namespace, target: Path) -> "DataSheet":
    """Return the data sheet that the command line and the answers make."""
    from workbench.plant.data_sheet import DataSheet, Propeller
    from workbench.plant.thrust_curve import read_thrust_curve

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
    )
    sheet.check()
    return sheet


def _hover(vehicle: "Vehicle") -> tuple[float, float, float]:
    """Return shares of speed and thrust that a hover takes, and the power of all rotors [W]."""
    rotors = list(zip(vehicle.rotors, vehicle.hover_speeds.tolist(), strict=True))
    speed = max(speed / rotor.max_rot_velocity for rotor, speed in rotors)
    power = sum(rotor.moment_constant * rotor.motor_constant * speed**3 for rotor, speed in rotors)
    return speed, speed**2, power


def _next(target: Path) -> str:
    return f"workbench hover --model {target}"


def _result(
    target: Path, sheet: "DataSheet", found: "list[Figure]", vehicle: "Vehicle"
) -> dict[str, Any]:
    """Return what is written, as JSON has it; SI units."""
    from workbench.plant.estimates import hover_time

    speed, thrust, power = _hover(vehicle)
    return {
        "file": target,
        "name": vehicle.name,
        "figures": found,
        "thrust_to_weight": vehicle.thrust_to_weight,
        "hover_speed_share": speed,
        "hover_thrust_share": thrust,
        "hover_power": power,
        "hover_time": hover_time(sheet, power),
        "next": _next(target),
    }


def _print(target: Path, sheet: "DataSheet", found: "list[Figure]", vehicle: "Vehicle") -> None:
    """Print the estimates with their sources, and what follows for the hover."""
    from workbench.plant.estimates import GIVEN, HOVER_TIME_SOURCE, hover_time

    print(
        f"{vehicle.name}: {vehicle.mass:.4g} kg, {sheet.rotors} rotors ({sheet.layout}) "
        f"{sheet.arm:.4g} m from the centre, propellers {sheet.propeller.label}"
    )
    print("\nestimated; each stands in the file, to be replaced by what you measure")
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
    speed, thrust, power = _hover(vehicle)
    print(f"\nthrust to weight  {vehicle.thrust_to_weight:.2f}")
    print(
        f"hover throttle    {100 * speed:.0f} % of the largest speed, "
        f"{100 * thrust:.0f} % of the largest thrust"
    )
    seconds = hover_time(sheet, power)
    if seconds is not None:
        print(f"hover time        about {seconds / 60.0:.0f} min ({HOVER_TIME_SOURCE});")
        print(f"                  fly with it by --set battery_duration={seconds:.0f}")
    print(f"\nnext: {_next(target)}")
