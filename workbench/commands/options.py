"""Options common to several commands, and their effects on a scenario."""

import argparse
import dataclasses
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Any

from workbench.commands.printing import say
from workbench.common.errors import WorkbenchError, unknown_name
from workbench.control.controller import DEFAULT, PROGRAMS, SHIPPED
from workbench.design.flier import CHOICES, VARIABLE
from workbench.estimation.settings import ESTIMATORS, TRUTH
from workbench.scenario.parameters import split_setting

if TYPE_CHECKING:
    from workbench.design.executor.executor import Executor
    from workbench.scenario.scenario import Scenario, VehicleConfig


MODEL_HELP = (
    "shipped model, or a .xacro, .urdf, .sdf or MuJoCo .xml file, or a Gazebo model's folder"
)
LOG_HELP = (
    "log of a flight: .mcap, PX4's .ulg, ArduPilot's .bin, Betaflight's .bbl, a Crazyflie's usd "
    "log, NanoBench's .csv, or a .csv with a mapping"
)
NO_SENSORS = "none"
"""The name for no sensors."""


def add_command(
    commands: Any, name: str, summary: str, example: str, run: Callable[[argparse.Namespace], int]
) -> argparse.ArgumentParser:
    """Add a subcommand with a sentence and an example in its help."""
    parser: argparse.ArgumentParser = commands.add_parser(
        name,
        help=summary,
        description=summary,
        epilog=f"example:\n  {example}",
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    parser.set_defaults(run=run)
    return parser


def add_option(
    parser: "argparse._ActionsContainer", option: str, metavar: str, help: str, default: Any
) -> None:
    """Add an option with a value of its default's type; its help ends with the default."""
    shown = f"{default:g}" if isinstance(default, float) else default
    parser.add_argument(
        option,
        type=type(default),
        default=default,
        metavar=metavar,
        help=f"{help} (default: {shown})",
    )


def add_repeated(
    parser: "argparse._ActionsContainer",
    option: str,
    metavar: str,
    parse: Callable[[str], Any],
    help: str,
) -> None:
    """Add an option that may be repeated, with a list of values."""
    parser.add_argument(option, action="append", type=parse, default=[], metavar=metavar, help=help)


def add_model_options(parser: "argparse._ActionsContainer", help: str = "", **more: Any) -> None:
    """Add options for a model, and to read its description.

    Args:
        parser: or a group of it.
        help: of --model.
        more: arguments of argparse for --model.
    """
    help = help or f"{MODEL_HELP} (default: dh_drone)"
    parser.add_argument("--model", metavar="NAME|PATH", help=help, **more)
    add_description_options(parser)
    add_rotors_option(parser)


def add_vehicle_options(parser: argparse.ArgumentParser) -> None:
    """Add options for a vehicle, its world, and the values of its live parameters."""
    group = parser.add_argument_group("vehicle")
    add_model_options(group)
    group.add_argument(
        "--world",
        metavar="NAME|PATH",
        help="shipped world (`workbench fly --list` lists them), or a .yaml, .sdf or .world file "
        "(default: the scenario's, or empty)",
    )
    add_controller_option(group)
    add_estimator_option(group)
    group.add_argument("--gains", metavar="FILE", help="gain file (YAML) on top of the model's own")
    add_repeated(
        group,
        "--set",
        "NAME=VALUE",
        split_setting,
        "value of a live parameter, as kp_velocity_z=6; `workbench params` lists them; may be "
        "repeated",
    )
    add_repeated(
        group,
        "--vary",
        "NAME=VALUE",
        parse_variation,
        "let what flies differ from what the controller knows: factors on mass, inertia, "
        "rotor_lag, control_delay in control periods, and sensing_delay and command_delay in "
        "seconds, as mass=1.05; may be repeated",
    )


def add_controller_option(parser: "argparse._ActionsContainer", instead: str = "scenario") -> None:
    """Add --controller.

    Args:
        parser: or a group of it.
        instead: the kind of file that may name another one.
    """
    parser.add_argument(
        "--controller",
        metavar="NAME|FILE",
        default="",
        help=f"control law: {', '.join((*SHIPPED, *PROGRAMS))}, or a .py file of your own, which "
        "runs; @speed=0,4,8 behind it schedules its gains; see docs/controllers.md (default: the "
        f"{instead}'s, or {DEFAULT})",
    )


def add_estimator_option(parser: "argparse._ActionsContainer", instead: str = "scenario") -> None:
    """Add --estimator; arguments are those of `add_controller_option`."""
    parser.add_argument(
        "--estimator",
        metavar="NAME|FILE",
        default="",
        help=f"what the controller knows of the motion: {', '.join(ESTIMATORS)}, or a .py file of "
        f"your own, which runs; see docs/estimation.md (default: the {instead}'s, or {TRUTH})",
    )


def add_description_options(parser: "argparse._ActionsContainer") -> None:
    """Add options to read a description."""
    add_repeated(
        parser,
        "--arg",
        "NAME:=VALUE",
        parse_argument,
        "argument of the xacro file, as mass:=2.1; may be repeated",
    )
    add_repeated(
        parser,
        "--package",
        "NAME=DIR",
        parse_package,
        "folder of a ROS package or Gazebo model, where it is not found above or beside the "
        "file or through the environment; may be repeated",
    )


def add_rotors_option(parser: "argparse._ActionsContainer") -> None:
    """Add --rotors."""
    parser.add_argument(
        "--rotors",
        metavar="FILE",
        default="",
        help="sidecar: YAML with the rotors of a description that has none; without it, "
        "STEM.rotors.yaml beside the description",
    )


def add_sensor_options(parser: argparse.ArgumentParser) -> None:
    """Add options for the sensors in use."""
    group = parser.add_argument_group("sensors")
    group.add_argument(
        "--sensors",
        metavar="NAME[,NAME]",
        help="sensors that measure, by name or kind (imu, gps, lidar, range_finder, barometer, "
        f"depth_camera, magnetometer), all, or {NO_SENSORS} (default: the scenario's)",
    )
    group.add_argument("--seed", type=int, metavar="N", help="of noise and turbulence")
    group.add_argument("--no-noise", action="store_true", help="let sensors be exact")


def add_json_option(
    parser: argparse.ArgumentParser, what: str = "print JSON instead of text"
) -> None:
    """Add --json."""
    parser.add_argument("--json", action="store_true", help=what)


def add_log_options(parser: Any) -> None:
    """Add --mapping and --log-number."""
    parser.add_argument(
        "--mapping",
        type=Path,
        metavar="MAPPING.yaml",
        help="what the columns of a CSV log are (default: LOG.mapping.yaml beside LOG.csv, if any)",
    )
    parser.add_argument(
        "--log-number",
        type=int,
        metavar="N",
        help="which log of a file with several, from 1; `workbench log` lists them (default: the "
        "longest one)",
    )


def add_order_option(parser: Any) -> None:
    """Add --order."""
    parser.add_argument(
        "--order",
        type=_numbers,
        default=[],
        metavar="N,N,..",
        help="for each rotor of the description the number of its motor in the log, from 1 "
        "(default: the same order)",
    )


def _numbers(text: str) -> list[int]:
    """Return integers from a text such as `1,2,3`."""
    try:
        return [int(each) for each in text.split(",")]
    except ValueError:
        raise WorkbenchError(
            f"'{text}' is not an order of motors: write their numbers, as 1,2,3,4"
        ) from None


def add_scheduler_option(parser: argparse.ArgumentParser) -> None:
    """Add --scheduler."""
    parser.add_argument(
        "--scheduler",
        default="",
        metavar="ADDRESS",
        help="fly on the workers of this Dask scheduler, as tcp://localhost:8786, instead of in "
        "processes here",
    )


def add_output_options(parser: argparse.ArgumentParser) -> None:
    """Add --output for a folder, and --no-plots."""
    add_option(parser, "--output", "DIR", "folder for plots and logs", Path("out"))
    parser.add_argument("--no-plots", action="store_true", help="write the logs only")


def add_flier_options(parser: argparse.ArgumentParser) -> None:
    """Add --fly-on and --verbose, see `cli.main`."""
    parser.add_argument(
        "--fly-on",
        choices=CHOICES,
        help="let the diagram fly, or compiled code where there is such; both give the same "
        f"numbers (default: that of {VARIABLE} in the environment, or auto, the quicker one)",
    )
    parser.add_argument("--verbose", action="store_true", help="tell who flies, and why")


def add_flight_options(parser: argparse.ArgumentParser) -> None:
    """Add options for the files of a command that flies or judges, for its vehicle, and --json."""
    add_output_options(parser)
    add_vehicle_options(parser)
    add_json_option(parser)


def flown_with(args: argparse.Namespace) -> str:
    """Return the values of a flight, for its title."""
    parts = [args.gains] if args.gains else []
    parts += [f"{name}={value:g}" for name, value in args.set]
    parts += [f"--vary {name}={value:g}" for name, value in args.vary]
    if not parts:
        return "with its own gains"
    return f"with {', '.join(parts[:-1])} and {parts[-1]}" if len(parts) > 1 else f"with {parts[0]}"


def parse_argument(text: str) -> tuple[str, str]:
    """Return name and value of a `NAME:=VALUE` text.

    Raises:
        WorkbenchError: if it is not of that form.
    """
    name, sign, value = text.partition(":=")
    if not sign or not name.strip():
        raise WorkbenchError(f"'{text}' is not a xacro argument: write NAME:=VALUE, as mass:=2.1")
    return name.strip(), value.strip()


def parse_package(text: str) -> tuple[str, str]:
    """Return name and folder of a `NAME=DIR` text.

    Raises:
        WorkbenchError: if it is not of that form.
    """
    name, sign, folder = text.partition("=")
    if not sign or not name.strip() or not folder.strip():
        raise WorkbenchError(f"'{text}' is not a package: write NAME=DIR, as my_drone=../my_drone")
    return name.strip(), folder.strip()


def parse_variation(text: str) -> tuple[str, float]:
    """Return name and value of a variation written NAME=VALUE.

    Raises:
        WorkbenchError: if it is not of that form, or unknown.
    """
    from workbench.plant.variation import Variation

    name, equals, value = text.partition("=")
    names = [field.name for field in dataclasses.fields(Variation)]
    if not equals:
        raise WorkbenchError(f"'{text}' is not a variation: write NAME=VALUE, as mass=1.05")
    if name.strip() not in names:
        raise unknown_name("variation", name.strip(), names)
    try:
        return name.strip(), int(value) if name.strip() == "control_delay" else float(value)
    except ValueError:
        raise WorkbenchError(f"the variation of {name} is '{value}': give it a number") from None


def with_model(scenario: "Scenario", args: argparse.Namespace) -> "Scenario":
    """Set the model from the command line in a scenario, and return it.

    A different model drops the arguments and gains of the scenario, which were for its own model.

    Raises:
        WorkbenchError: if there is no such model or file.
    """
    from workbench.common.resources import find_file, find_model
    from workbench.scenario.scenario import VehicleConfig

    if args.model:
        scenario.vehicle = VehicleConfig(model=args.model)
    scenario.vehicle.args |= dict(args.arg)
    scenario.vehicle.packages |= dict(args.package)
    scenario.vehicle.rotors = args.rotors or scenario.vehicle.rotors
    find_model(scenario.vehicle.model)
    if scenario.vehicle.rotors:
        find_file(scenario.vehicle.rotors)
    return scenario


def chosen_model(args: argparse.Namespace) -> "VehicleConfig":
    """Return the model that the command line names, and how to read it."""
    from workbench.scenario.scenario import VehicleConfig

    return VehicleConfig(args.model, dict(args.arg), dict(args.package), args.rotors)


def chosen_scenario(args: argparse.Namespace) -> "Scenario":
    """Return the default scenario with the vehicle and the world from the command line."""
    from workbench.scenario.scenario import Scenario

    return with_vehicle(Scenario(), args)


def with_vehicle(scenario: "Scenario", args: argparse.Namespace) -> "Scenario":
    """Set the vehicle and the world from the command line in a scenario, and return it."""
    from workbench.common.resources import find_file, find_world
    from workbench.gains.gains import flown_by
    from workbench.scenario.parameters import parameter_table
    from workbench.scenario.scenario import at_own_period, flown_controller

    with_model(scenario, args)  # names are checked before the second spent on loading Drake
    if args.gains:
        scenario.vehicle.gains = args.gains
    variation = dataclasses.replace(scenario.vehicle.variation, **dict(args.vary))
    variation.check()
    scenario.vehicle.variation = variation
    scenario.world = args.world or scenario.world
    scenario.controller = flown_by(args.controller or scenario.controller, scenario.vehicle.gains)
    scenario.estimator = args.estimator or scenario.estimator
    parameter_table(flown_controller(scenario)).checked(dict(args.set))
    if scenario.vehicle.gains:
        find_file(scenario.vehicle.gains)
    find_world(scenario.world)
    _say_unused(scenario.estimator, [name for name, _ in args.set])
    return at_own_period(scenario)


def _say_unused(estimator: str, names: list[str]) -> None:
    """Report values set for estimators that are not in use."""
    from workbench.scenario.parameters import parameter_table

    for other in ESTIMATORS:
        rows = {row.name for row in parameter_table().of(other)}
        unused = [name for name in dict.fromkeys(names) if name in rows]
        if other != estimator and unused:
            flown = "the truth" if estimator == TRUTH else f"what {estimator} estimates"
            say(
                f"nothing uses {' and '.join(unused)}, because the controller gets {flown}: "
                f"add `--estimator {other}`"
            )


def with_sensors(scenario: "Scenario", args: argparse.Namespace) -> "Scenario":
    """Set the sensors from the command line in a scenario, and return it.

    A log of a flight with an estimator also has the IMU, so that `workbench estimate` can use it:
    the estimator reads the IMU within the update of the vehicle, and other sensors as they measure.
    """
    if args.sensors is not None:
        names = [name.strip() for name in args.sensors.split(",")]
        scenario.sensors.use = [name for name in names if name not in ("", NO_SENSORS)]
    if args.seed is not None:
        scenario.sensors.seed = args.seed
    if args.no_noise:
        scenario.sensors.noise = False
    logged = getattr(args, "log", None) is not None
    if logged and scenario.estimator != TRUTH and not {"imu", "all"} & {*scenario.sensors.use}:
        scenario.sensors.use = [*scenario.sensors.use, "imu"]
    return scenario


@contextmanager
def chosen_executor(scheduler: str, here: "Executor") -> Iterator["Executor"]:
    """Yield the executor: the cluster of a scheduler, with a message on its size, or the local one.

    Raises:
        WorkbenchError: if the scheduler cannot be reached, or flights by its workers would differ
            from local ones.
    """
    if not scheduler:
        yield here
        return
    from workbench.design.executor.cluster import DaskCluster

    with DaskCluster(scheduler) as cluster:
        say(f"flying on {cluster.workers} workers of {scheduler}")
        yield cluster
