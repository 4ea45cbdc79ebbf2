"""Measured flights: `workbench step` for one step, and `hover` to check all axes."""

import argparse
import dataclasses
import math
from contextlib import ExitStack
from typing import TYPE_CHECKING, Any

from workbench.commands import ExitCode
from workbench.commands.options import (
    add_command,
    add_flier_options,
    add_flight_options,
    add_option,
    chosen_scenario,
    flown_with,
)
from workbench.commands.outputs import Outputs
from workbench.commands.printing import (
    lost_replies,
    not_as_demanded,
    pick,
    print_result,
    print_table,
    say,
    told_of_autopilot,
)
from workbench.commands.progress import progress_bar
from workbench.common.errors import WorkbenchError

if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence

    from workbench.control.controller import Controller
    from workbench.design.hover_check import HoverReport
    from workbench.design.load_step import LoadResponse
    from workbench.design.metrics import Demand
    from workbench.design.step_response import StepResponse
    from workbench.gains.gains import Gain
    from workbench.scenario.scenario import Scenario


_PICTURES = "workbench.design.plots_step"
"""The module that draws the figure."""
AXIS = "z"
"""Default axis of a step."""
LOADS = (
    *("force_x", "force_y", "force_z", "torque_roll", "torque_pitch", "torque_yaw"),
    *("gust_x", "gust_y", "gust_z"),
)
"""As in `scenario.loads`, which takes a tenth of a second to load."""
_ORIGINS = {"rule": "the rule for any vehicle"}
"""Other names for the origin of a gain."""


def add_parser(commands: Any) -> None:
    """Add the command."""
    parser = add_command(
        commands,
        "step",
        "Fly one step of velocity, yaw rate or a load from hover, with the metrics of "
        "python-control.",
        "workbench step --axis z --amplitude 1 --set kp_velocity_z=6\n"
        "  workbench step --load force_x --amplitude 2",
        run,
    )
    what = parser.add_mutually_exclusive_group()
    what.add_argument("--axis", choices=("x", "y", "z", "yaw"), help="(default: z)")
    what.add_argument(
        "--load",
        choices=LOADS,
        help="a force at the centre of mass, a torque, or a gust, while the drone should stay",
    )
    parser.add_argument(
        "--amplitude",
        type=float,
        metavar="A",
        help="of the command in m/s, or rad/s for yaw (default: the paper's: 2, 2, 1, 0.2); of the "
        "load in N or N·m (default: a tenth of the weight), of a gust in m/s (default: 5)",
    )
    parser.add_argument(
        "--duration",
        type=float,
        metavar="T",
        help="flown after the command's edge, in s (default: until the response has settled by the "
        "linear model, at least 5; for a load 5)",
    )
    parser.add_argument(
        "--acts",
        type=float,
        metavar="T",
        help="for how long the load acts, in s (default: to the end, a gust for 1)",
    )
    add_option(parser, "--at", "POINT", "steady flight before it, hover or as vx=5,vz=-1", "hover")
    add_flight_options(parser)
    add_flier_options(parser)


def run(args: argparse.Namespace) -> int:
    """Fly the step, print its metrics, write plot and log; return 1 if the flight is lost."""
    from workbench.commands.drawer import Drawer
    from workbench.design.linear.operating_point import steady_velocity

    velocity = steady_velocity(args.at)
    if args.load and any(velocity):
        raise WorkbenchError("a load acts on a drone that hovers: leave --at out")
    if args.acts is not None and not args.load:
        raise WorkbenchError("a command lasts to the end: give --acts with a --load only")
    name = args.load or args.axis or AXIS
    what, kind = (f"of {name}", "load") if args.load else (f"along {name}", "step")
    with ExitStack() as stack:
        outputs = stack.enter_context(Outputs())
        log = outputs.add(args.output / f"step-{name}.csv")
        picture = outputs.picture(args, f"step-{name}.png")
        drawer = stack.enter_context(Drawer(_PICTURES)) if picture else None
        scenario = chosen_scenario(args)  # loads numpy, while the other process loads matplotlib
        with progress_bar(f"flying a step {what}") as progress:
            flown = _fly(args, name, scenario, velocity, progress)
        if drawer and picture:
            drawer.begin(picture, _PICTURES, f"plot_{kind}", flown)
        flown.recording.write_csv(log)
        if drawer:
            drawer.finish()
    trouble = flown.ended or (flown.loss.sentence if flown.loss else "")
    result = _result(flown, args) | {"trouble": trouble}
    result |= told_of_autopilot(flown.exchange, flown.ended)
    print_result(args, result, _print, flown, args, trouble, files=outputs.files)
    return ExitCode.NOT_AS_DEMANDED if trouble else ExitCode.DONE


def _fly(
    args: argparse.Namespace,
    axis: str,
    scenario: "Scenario",
    velocity: "Sequence[float]",
    progress: Any,
) -> "LoadResponse | StepResponse":
    """Fly the step of a load, or of a command along an axis."""
    common: Any = {
        "scenario": scenario,
        "settings": dict(args.set),
        "progress": progress,
    }
    if args.load:
        from workbench.design.load_step import fly_load_step

        if args.duration is not None:
            common["duration"] = args.duration
        return fly_load_step(args.load, args.amplitude, acts=args.acts, **common)
    from workbench.design.step_response import fly_step

    amplitude = _usual(axis) if args.amplitude is None else args.amplitude
    return fly_step(axis, amplitude, duration=args.duration, velocity=velocity, **common)


def _usual(axis: str) -> float:
    """Return the amplitude of the paper's step, or 1."""
    from workbench.design.reproduce import COMMANDS

    return COMMANDS.get(axis, 1.0)


def _result(flown: "LoadResponse | StepResponse", args: argparse.Namespace) -> dict[str, Any]:
    """Return the response for JSON."""
    return {
        "vehicle": flown.recording.vehicle.name,
        "gains": args.gains or "",
        "set": dict(args.set),
        "vary": dict(args.vary),
        **dataclasses.asdict(flown.metrics),
        **pick(flown, "load" if args.load else "axis coupling diverged_at"),
        **pick(flown, "amplitude peak_rotor_use"),
    }


def _print(flown: "LoadResponse | StepResponse", args: argparse.Namespace, trouble: str) -> None:
    """Print the metrics, and doubts about them."""
    print_metrics: Any = _print_load if args.load else _print_command
    print_metrics(flown, args)
    if trouble:
        print(trouble)
    elif flown.metrics.withheld:
        say(f"numbers shown as — are withheld: {flown.metrics.withheld}")


def _print_load(flown: "LoadResponse", args: argparse.Namespace) -> None:
    """Print the metrics of a load with their units."""
    from workbench.design.response_metrics import number
    from workbench.scenario.loads import find_load

    load, metrics = find_load(flown.load), flown.metrics
    print(
        f"step of {flown.amplitude:.4g} {load.unit}, {load.label}, "
        f"{flown.recording.vehicle.name} {flown_with(args)}"
    )
    band = "until it stays within 5 % of the peak of its steady state"
    rows = [
        ("peak", number(metrics.peak, ".4g"), load.response_unit, f"of the {load.response}"),
        ("peak_time", number(metrics.peak_time, ".3f"), "s", ""),
        ("settling_time", number(metrics.settling_time, ".3f"), "s", band),
        ("steady_state_error", number(metrics.steady_state_error, ".3f"), "%", "of the peak"),
        ("peak_rotor_use", f"{100 * flown.peak_rotor_use:.1f}", "%", "of the speed limit"),
        *_autopilot_rows(flown.exchange),
    ]
    print_table(rows, left=(0, 2, 3))


def _print_command(response: "StepResponse", args: argparse.Namespace) -> None:
    """Print the metrics with their units."""
    from workbench.design.response_metrics import number
    from workbench.scenario.axes import find_axis

    unit = find_axis(response.axis).unit
    metrics, coupling = response.metrics, response.coupling
    print(
        f"step of {response.amplitude:g} {unit} along {response.axis}, "
        f"{response.recording.vehicle.name} {flown_with(args)}"
    )
    rows = [
        ("rise_time", number(metrics.rise_time, ".3f"), "s", "10 % to 90 % of the steady state"),
        ("settling_time", number(metrics.settling_time, ".3f"), "s", "until it stays within 2 %"),
        ("overshoot", number(metrics.overshoot, ".2f"), "%", ""),
        ("undershoot", number(metrics.undershoot, ".2f"), "%", ""),
        ("peak", number(metrics.peak, ".4f"), unit, ""),
        ("peak_time", number(metrics.peak_time, ".3f"), "s", ""),
        ("steady_state_value", number(metrics.steady_state_value, ".4f"), unit, ""),
        ("steady_state_error", number(metrics.steady_state_error, ".3f"), "%", "of the command"),
        ("peak_rotor_use", f"{100 * response.peak_rotor_use:.1f}", "%", "of the speed limit"),
    ]
    rows += [
        (f"coupling {axis}", f"{value:.4f}", "rad" if axis == "yaw" else "m", "largest excursion")
        for axis, value in dataclasses.asdict(coupling).items()
        if axis != response.axis
    ]
    rows += _autopilot_rows(response.exchange)
    print_table(rows, left=(0, 2, 3))


def _autopilot_rows(exchange: "Mapping[str, float]") -> list[tuple[str, str, str, str]]:
    """Return the row of a program that ran the law, if any."""
    if not exchange:
        return []
    lost, packets = lost_replies(exchange)
    return [("lost replies", lost, "", packets)]


def add_hover(commands: Any) -> None:
    """Add the command."""
    parser = add_command(
        commands,
        "hover",
        "Fly ten seconds of hover and a step on every axis, and report how well they went.",
        "workbench hover --model my_drone.urdf --output out",
        run_hover,
    )
    add_flight_options(parser)
    add_flier_options(parser)


def run_hover(args: argparse.Namespace) -> int:
    """Fly, print the table, write plot and log; return 1 if a demand is not met."""
    from workbench.design.hover_check import check_hover
    from workbench.gains.gains import choose_gains
    from workbench.plant.plausible import doubts
    from workbench.scenario.scenario import flown_controller

    scenario = chosen_scenario(args)
    with Outputs() as outputs:
        log = outputs.add(args.output / "hover-check.csv")
        plot = outputs.picture(args, "hover-check.png")
        with progress_bar("flying hover and four steps") as progress:
            report = check_hover(scenario, dict(args.set), progress)
        report.hover.write_csv(log)
        if plot:
            from workbench.design.plots import write_png
            from workbench.design.plots_step import plot_hover

            write_png(plot_hover(report), plot)
    law = flown_controller(scenario)
    gains = choose_gains(report.hover.vehicle, scenario.vehicle.gains, dict(args.set), law)
    unlikely = doubts(report.hover.vehicle)
    result = _hover_result(report, gains) | {"warnings": unlikely}
    result |= told_of_autopilot(report.exchange, report.ended)
    print_result(args, result, _print_hover, report, law, gains, unlikely, files=outputs.files)
    if report.ended:
        say(report.ended)
    missed = [_sentence(demand) for demand in report.demands if not demand.met]
    code = not_as_demanded(missed)
    return ExitCode.NOT_AS_DEMANDED if report.ended else code


def _hover_result(report: "HoverReport", gains: "dict[str, Gain]") -> dict[str, Any]:
    """Return the results for JSON; angles in rad."""
    vehicle = report.hover.vehicle
    return {
        "vehicle": vehicle.name,
        **pick(vehicle, "source mass"),
        "gains": gains,
        "hover": {
            "duration": float(report.hover.time[-1]),
            "drift": float(report.drift.max()),
            "tilt": float(report.tilt.max()),
            "rotor_use": report.rotor_use,
        },
        "steps": [
            {
                **dataclasses.asdict(step.metrics),
                **pick(step, "axis amplitude peak_rotor_use coupling"),
            }
            for step in report.steps
        ],
        "demands": [
            {"flight": demand.criterion, **pick(demand, "quantity unit value limit withheld met")}
            for demand in report.demands
        ],
        "met": all(demand.met for demand in report.demands),
    }


def _print_hover(
    report: "HoverReport", law: "Controller", gains: "dict[str, Gain]", unlikely: list[str]
) -> None:
    """Print vehicle, gains, the table of demands, and why they may be meaningless."""
    vehicle = report.hover.vehicle
    print(f"{vehicle.name}, {vehicle.mass:.4g} kg, {len(vehicle.rotors)} rotors: {vehicle.source}")
    _print_gains(law, gains)
    print()
    table = [["", "flown", "limit", "", ""]]
    table += [_line(demand) for demand in report.demands]
    print_table(table, left=(0, 3, 4))
    uses = [("hover", report.rotor_use)]
    uses += [(f"{step.axis} step", step.peak_rotor_use) for step in report.steps]
    parts = ", ".join(f"{name} {100.0 * use:.0f} %" for name, use in uses)
    print(f"\nlargest rotor speed, of its limit: {parts}")
    if report.exchange:
        print(f"lost replies: {' '.join(lost_replies(report.exchange))}")
    if unlikely:
        met = all(demand.met for demand in report.demands)
        print(f"\n{'all ok, but' if met else 'besides,'} this is unusual for a drone:")
        for doubt in unlikely:
            print(f"  {doubt}")


def _print_gains(law: "Controller", gains: "dict[str, Gain]") -> None:
    """Print the gains by their origin, without defaults of the parameter table."""
    from workbench.scenario.parameters import parameter_table

    origins = dict.fromkeys(gain.origin for gain in gains.values())
    for origin in origins:
        if origin == "default":
            continue
        print(f"\ngains from {_ORIGINS.get(origin, origin)}:")
        rows = [
            (f"  {name}", f"{gain.value:g}", parameter_table(law).find(name).unit)
            for name, gain in gains.items()
            if gain.origin == origin
        ]
        print_table(rows, left=(0, 2))


def _line(demand: "Demand") -> list[str]:
    """Return one line of the table; angles in degrees."""
    from workbench.design.response_metrics import number

    scale, unit = (math.degrees(1.0), "deg") if demand.unit == "rad" else (1.0, demand.unit)
    return [
        f"{demand.criterion}{_size(demand.criterion)}: {demand.quantity}",
        number(scale * demand.value, ".3f"),
        f"{scale * demand.limit:g}",
        unit,
        "ok" if demand.met else "not ok",
    ]


def _size(flight: str) -> str:
    """Return the amplitude of a step, as text after its name."""
    from workbench.design.step_response import STEPS
    from workbench.scenario.axes import find_axis

    sizes = {f"{axis} step": f" {size:g} {find_axis(axis).unit}" for axis, size in STEPS}
    return sizes.get(flight, "")


def _sentence(demand: "Demand") -> str:
    """Return a sentence on a demand that is not met."""
    _, value, limit, unit, _ = _line(demand)
    quantity = demand.quantity.replace("_", "-", 1).replace("_", " ")
    if demand.withheld:
        return f"{quantity} of the {demand.criterion} is not known, as {demand.withheld}"
    return f"{quantity} of the {demand.criterion} is {value} {unit} (at most {limit} {unit})"
