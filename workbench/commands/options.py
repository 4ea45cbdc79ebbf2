"""Options common to several commands, and their effects on a scenario."""

import argparse
import dataclasses
from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING, Any

from workbench.commands.progress import progress_bar
from workbench.common.errors import WorkbenchError, unknown_name
from workbench.control.installed_laws import DEFAULT_CONTROLLER, installed_laws, known_laws
from workbench.design.flier import FLY_ON_CHOICES, FLY_ON_VARIABLE
from workbench.estimation.settings import ESTIMATORS, TRUTH
from workbench.parameters.parameter_table import split_setting
from workbench.plant.sensors import sensor_kinds

if TYPE_CHECKING:
    from workbench.common.flight import Flight
    from workbench.logs.readers.log_reader import LogFile

    Subcommands = argparse._SubParsersAction[argparse.ArgumentParser]
else:  # it takes no parameters when it runs
    Subcommands = argparse._SubParsersAction
"""What `add_parser` of a command adds itself to."""

MODEL_HELP = (
    "shipped model, or a .xacro, .urdf, .sdf or MuJoCo .xml file, or a Gazebo model's folder"
)
LOG_HELP = (
    "log of a flight: .mcap, PX4's .ulg, ArduPilot's .bin, Betaflight's .bbl, MAVLink's .tlog, a "
    "Crazyflie's usd log, NanoBench's .csv, or a .csv with a mapping"
)
LAW_NAMES, PROGRAM_TOO, KIND_NAMES = "{laws}", "{laws and programs}", "{sensors}"
"""In the help of an option, these stand for the names of installed laws and of the kinds of
sensors, see `HelpFormatter`."""
NO_SENSORS = "none"
"""The name for no sensors."""


class HelpFormatter(argparse.RawDescriptionHelpFormatter):
    """Formats a help in which names are looked up when it is printed, not in each run."""

    def _get_help_string(self, action: argparse.Action) -> str:
        text = action.help or ""
        for place, names in (
            (LAW_NAMES, installed_laws),
            (PROGRAM_TOO, known_laws),
            (KIND_NAMES, sensor_kinds),
        ):
            if place in text:
                text = text.replace(place, ", ".join(names()))
        return text


def add_command(
    commands: Subcommands,
    name: str,
    summary: str,
    example: str,
    run: Callable[[argparse.Namespace], int],
    other_name: str = "",
) -> argparse.ArgumentParser:
    """Add a subcommand, by one name or two, with a sentence and an example in its help."""
    parser: argparse.ArgumentParser = commands.add_parser(
        name,
        aliases=[other_name] if other_name else [],
        help=summary,
        description=summary,
        epilog=f"example:\n  {example}",
        formatter_class=HelpFormatter,
    )
    parser.set_defaults(run=run)
    return parser


def add_option(
    parser: "argparse._ActionsContainer",
    option: str,
    metavar: str,
    help: str,
    default: str | float | Path,
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
        help=f"control law: {PROGRAM_TOO}, or a .py "
        "file of your own, which runs; @speed=0,4,8 behind it schedules its gains; see "
        f"docs/controllers.md (default: the {instead}'s, or {DEFAULT_CONTROLLER})",
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
        help=f"sensors that measure, by name or kind ({KIND_NAMES}), all, or "
        f"{NO_SENSORS} (default: the scenario's)",
    )
    group.add_argument("--seed", type=int, metavar="N", help="of noise and turbulence")
    group.add_argument("--no-noise", action="store_true", help="let sensors be exact")


def add_json_option(
    parser: argparse.ArgumentParser, what: str = "print JSON instead of text"
) -> None:
    """Add --json."""
    parser.add_argument("--json", action="store_true", help=what)


def add_log_options(parser: "argparse._ActionsContainer") -> None:
    """Add --mapping and --log-number."""
    parser.add_argument(
        "--mapping",
        type=Path,
        metavar="MAPPING.yaml",
        help="what the columns of a CSV log are (default: LOG.mapping.yaml beside LOG.csv, if any)",
    )
    add_log_number_option(parser)


def add_log_number_option(parser: "argparse._ActionsContainer") -> None:
    """Add --log-number."""
    parser.add_argument(
        "--log-number",
        type=int,
        metavar="N",
        help="which log of a file with several, from 1; `workbench log` lists them (default: the "
        "longest one)",
    )


def asked_log(args: argparse.Namespace) -> "LogFile":
    """Return the log that the arguments name, see `add_log_options`."""
    from workbench.logs.readers.log_reader import LogFile

    return LogFile(args.log, args.mapping, args.log_number)


def read_asked_flight(args: argparse.Namespace) -> "Flight":
    """Return the flight in the log that the arguments name, and show progress.

    Raises:
        WorkbenchError: if it cannot be read.
    """
    from workbench.logs.flight_reader import read_flight

    with progress_bar(f"reading {args.log.name}") as progress:
        return read_flight(args.log, args.mapping, progress, args.log_number)


def add_order_option(parser: "argparse._ActionsContainer") -> None:
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
        choices=FLY_ON_CHOICES,
        help="let the diagram fly, or compiled code where there is such; both give the same "
        f"numbers (default: that of {FLY_ON_VARIABLE} in the environment, or auto, the quicker "
        "one)",
    )
    parser.add_argument("--verbose", action="store_true", help="tell who flies, and why")


def add_flight_options(parser: argparse.ArgumentParser) -> None:
    """Add options for the files of a command that flies or judges, for its vehicle, and --json."""
    add_output_options(parser)
    add_vehicle_options(parser)
    add_json_option(parser)


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
