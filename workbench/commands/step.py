"""Measured flights: `workbench step` for one step, and `hover` to check all axes."""

import argparse
import dataclasses
from contextlib import ExitStack
from typing import TYPE_CHECKING, Any

from workbench.commands import ExitCode
from workbench.commands.chosen_vehicle import chosen_scenario, flown_with
from workbench.commands.options import (
    Subcommands,
    add_command,
    add_flier_options,
    add_flight_options,
    add_option,
)
from workbench.commands.outputs import Outputs
from workbench.commands.printing import (
    autopilot_json,
    lost_replies,
    pick,
    print_message,
    print_result,
    print_table,
)
from workbench.commands.progress import progress_bar
from workbench.common.errors import WorkbenchError

if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence

    from workbench.design.attitude_step import AttitudeResponse
    from workbench.design.load_step import LoadResponse
    from workbench.design.step_response import StepResponse


_STEP_PLOT_MODULE = "workbench.design.plots_step"
"""The module that draws the figure."""
DEFAULT_STEP_AXIS = "z"
"""Default axis of a step."""
LOAD_CHOICES = (
    *("force_x", "force_y", "force_z", "torque_roll", "torque_pitch", "torque_yaw"),
    *("gust_x", "gust_y", "gust_z"),
)
ATTITUDE_CHOICES = ("roll", "pitch", "roll_rate", "pitch_rate")
"""As in `scenario.loads` and `scenario.attitude_axes`, which take a tenth of a second to load."""


def add_parser(commands: Subcommands) -> None:
    """Add the command."""
    parser = add_command(
        commands,
        "step",
        "Fly one step of velocity, yaw rate, attitude, rate or a load from hover, with the metrics "
        "of python-control.",
        "workbench step --axis z --amplitude 1 --set kp_velocity_z=6\n"
        "  workbench step --axis roll --amplitude 0.1\n"
        "  workbench step --load force_x --amplitude 2",
        run,
    )
    what = parser.add_mutually_exclusive_group()
    what.add_argument(
        "--axis",
        choices=("x", "y", "z", "yaw", *ATTITUDE_CHOICES),
        help="of velocity, yaw rate, attitude or rate; for the last two the loops outside are open "
        "(default: z)",
    )
    what.add_argument(
        "--load",
        choices=LOAD_CHOICES,
        help="a force at the centre of mass, a torque, or a gust, while the drone should stay",
    )
    parser.add_argument(
        "--amplitude",
        type=float,
        metavar="A",
        help="of the command [m/s], for yaw [rad/s] (default: the paper's: 2, 2, 1, 0.2); of an "
        "attitude [rad] (default: 0.1), of a rate [rad/s] (default: 0.3); of the load [N] or "
        "[N·m] (default: a tenth of the weight), of a gust [m/s] (default: 5)",
    )
    parser.add_argument(
        "--duration",
        type=float,
        metavar="T",
        help="flown after the command's edge [s] (default: until the response has settled by the "
        "linear model, at least 5; for a load 5, an attitude 1.5, a rate 0.75)",
    )
    parser.add_argument(
        "--acts",
        type=float,
        metavar="T",
        help="for how long the load acts [s] (default: to the end, a gust for 1)",
    )
    add_option(parser, "--at", "POINT", "steady flight before it, hover or as vx=5,vz=-1", "hover")
    add_flight_options(parser)
    add_flier_options(parser)


def run(args: argparse.Namespace) -> int:
    """Fly the step, print its metrics, write plot and log; return 1 if the flight is lost."""
    from workbench.commands.drawer import Drawer
    from workbench.design.flown_step import STEP_EDGE_S
    from workbench.design.linear.operating_point import steady_velocity
    from workbench.session.drift import MAX_HOVER_S

    velocity = steady_velocity(args.at)
    attitude = args.axis in ATTITUDE_CHOICES
    if (args.load or attitude) and any(velocity):
        what = "a load acts on" if args.load else f"a step of {args.axis} begins with"
        raise WorkbenchError(f"{what} a drone that hovers: leave --at out")
    if args.acts is not None and not args.load:
        raise WorkbenchError("a command lasts to the end: give --acts with a --load only")
    name = args.load or args.axis or DEFAULT_STEP_AXIS
    what, kind = (f"of {name}", "load") if args.load else (f"along {name}", "step")
    if attitude:
        what, kind = f"of {name}", "attitude_step"
    settings = dict(args.set)
    with ExitStack() as stack:
        outputs = stack.enter_context(Outputs())
        log = outputs.add(args.output / f"step-{name}.csv")
        picture = outputs.picture(args, f"step-{name}.png")
        drawer = stack.enter_context(Drawer(_STEP_PLOT_MODULE)) if picture else None
        scenario = chosen_scenario(args)  # loads numpy, while the other process loads matplotlib
        with progress_bar(f"flying a step {what}") as progress:
            how: Any = {"scenario": scenario, "settings": settings, "progress": progress}
            if args.duration is not None:
                how["duration"] = args.duration
            flown: LoadResponse | AttitudeResponse | StepResponse
            if args.load:
                from workbench.design.load_step import fly_load_step

                flown = fly_load_step(name, args.amplitude, acts=args.acts, **how)
            elif attitude:
                from workbench.design.attitude_step import fly_attitude_step

                flown = fly_attitude_step(name, args.amplitude, **how)
            else:
                from workbench.design.step_response import fly_step

                amplitude = _usual(name) if args.amplitude is None else args.amplitude
                how["longest_hover"] = MAX_HOVER_S
                flown = fly_step(name, amplitude, velocity=velocity, **how)
        if drawer and picture:
            drawer.begin(picture, _STEP_PLOT_MODULE, f"plot_{kind}", flown)
        flown.recording.write_csv(log)
        if drawer:
            drawer.finish()
    if flown.edge > STEP_EDGE_S and flown.diverged_at != 0.0:
        print_message(
            f"it hovers tilted: at {flown.edge:g} s the setpoint steps from that of the hover"
            if attitude
            else f"it drifts at first: at {flown.edge:g} s it is steady, at "
            f"{getattr(flown, 'before', 0.0):.3g} {'rad/s' if name == 'yaw' else 'm/s'}, and the "
            "response is relative to that"
        )
    trouble = flown.ended or (flown.loss.sentence if flown.loss else "")
    result = _result(flown, args) | {"trouble": trouble}
    result |= autopilot_json(flown.exchange, flown.ended)
    show: Any = _print_load if args.load else _print_command
    print_result(args, result, show, flown, args, trouble, files=outputs.files)
    return ExitCode.NOT_AS_DEMANDED if trouble else ExitCode.DONE


def _usual(axis: str) -> float:
    """Return the amplitude of the paper's step, or 1."""
    from workbench.design.reproduce import PAPER_COMMANDS

    return PAPER_COMMANDS.get(axis, 1.0)


def _result(
    flown: "LoadResponse | AttitudeResponse | StepResponse", args: argparse.Namespace
) -> dict[str, Any]:
    """Return the response for JSON."""
    return {
        "vehicle": flown.recording.vehicle.name,
        "gains": args.gains or "",
        "set": dict(args.set),
        "vary": dict(args.vary),
        **flown.metrics.to_json(),
        **pick(flown, "load" if args.load else "axis coupling diverged_at"),
        **pick(flown, "amplitude edge peak_rotor_use"),
    }


def _print_load(flown: "LoadResponse", args: argparse.Namespace, trouble: str) -> None:
    """Print the metrics of a load with their units, and doubts about them."""
    from workbench.common.quantity import number_or_dash
    from workbench.scenario.loads import find_load

    load, metrics = find_load(flown.load), flown.metrics
    print(
        f"step of {flown.amplitude:.4g} {load.unit}, {load.label}, "
        f"{flown.recording.vehicle.name} {flown_with(args)}"
    )
    band = "until it stays within 5 % of the peak of its steady state"
    rows = [
        (
            "peak",
            number_or_dash(metrics.peak, ".4g"),
            load.response_unit,
            f"of the {load.response}",
        ),
        ("peak_time", number_or_dash(metrics.peak_time, ".3f"), "s", ""),
        ("settling_time", number_or_dash(metrics.settling_time, ".3f"), "s", band),
        (
            "steady_state_error",
            number_or_dash(metrics.steady_state_error, ".3f"),
            "%",
            "of the peak",
        ),
        ("peak_rotor_use", f"{100 * flown.peak_rotor_use:.1f}", "%", "of the speed limit"),
        *_autopilot_rows(flown.exchange),
    ]
    _print_rows(rows, trouble, metrics.withheld)


def _print_command(
    response: "StepResponse | AttitudeResponse", args: argparse.Namespace, trouble: str
) -> None:
    """Print the metrics with their units, and doubts about them."""
    from workbench.common.quantity import number_or_dash
    from workbench.scenario.attitude_axes import find_step_axis

    unit = find_step_axis(response.axis).unit
    metrics, coupling = response.metrics, response.coupling
    along = "of" if response.axis in ATTITUDE_CHOICES else "along"
    print(
        f"step of {response.amplitude:g} {unit} {along} {response.axis}, "
        f"{response.recording.vehicle.name} {flown_with(args)}"
    )
    rows = [
        (
            "rise_time",
            number_or_dash(metrics.rise_time, ".3f"),
            "s",
            "10 % to 90 % of the steady state",
        ),
        (
            "settling_time",
            number_or_dash(metrics.settling_time, ".3f"),
            "s",
            "until it stays within 2 %",
        ),
        ("overshoot", number_or_dash(metrics.overshoot, ".2f"), "%", ""),
        ("undershoot", number_or_dash(metrics.undershoot, ".2f"), "%", ""),
        ("peak", number_or_dash(metrics.peak, ".4f"), unit, ""),
        ("peak_time", number_or_dash(metrics.peak_time, ".3f"), "s", ""),
        ("steady_state_value", number_or_dash(metrics.steady_state_value, ".4f"), unit, ""),
        (
            "steady_state_error",
            number_or_dash(metrics.steady_state_error, ".3f"),
            "%",
            "of the command",
        ),
        ("peak_rotor_use", f"{100 * response.peak_rotor_use:.1f}", "%", "of the speed limit"),
    ]
    rows += [
        (
            f"coupling {axis}",
            number_or_dash(value, ".4f"),
            "m" if axis in "xyz" else "rad",
            "largest excursion",
        )
        for axis, value in dataclasses.asdict(coupling).items()
        if axis != response.axis.removesuffix("_rate")
    ]
    rows += _autopilot_rows(response.exchange)
    _print_rows(rows, trouble, metrics.withheld)


def _print_rows(rows: "Sequence[tuple[str, str, str, str]]", trouble: str, withheld: str) -> None:
    print_table(rows, left=(0, 2, 3))
    if trouble:
        print(trouble)
    elif withheld:
        print_message(f"numbers shown as — are withheld: {withheld}")


def _autopilot_rows(exchange: "Mapping[str, float]") -> list[tuple[str, str, str, str]]:
    """Return the row of a program that ran the law, if any."""
    if not exchange:
        return []
    lost, packets = lost_replies(exchange)
    return [("lost replies", lost, "", packets)]
