"""`workbench hover`: ten seconds of hover and a step on every axis, and how well they went."""

import argparse
import dataclasses
import math
from typing import TYPE_CHECKING, Any

from workbench.commands import ExitCode
from workbench.commands.options import (
    add_command,
    add_json_option,
    add_output_options,
    add_vehicle_options,
    with_vehicle,
)
from workbench.commands.outputs import Outputs
from workbench.commands.printing import (
    lost_replies,
    not_as_demanded,
    print_result,
    print_table,
    say,
    told_of_autopilot,
)
from workbench.commands.progress import progress_bar

if TYPE_CHECKING:
    from pathlib import Path

    from workbench.control.controller import Controller
    from workbench.design.hover_check import Demand, HoverReport
    from workbench.gains.gains import Gain

_ORIGINS = {"rule": "the rule for any vehicle"}
"""What else a gain's origin is called."""


def add_parser(commands: Any) -> None:
    """Add the command."""
    parser = add_command(
        commands,
        "hover",
        "Fly ten seconds of hover and a step on every axis, and say how well they went.",
        "workbench hover --model my_drone.urdf --output out",
        run,
    )
    add_output_options(parser)
    add_vehicle_options(parser)
    add_json_option(parser)


def run(args: argparse.Namespace) -> int:
    """Fly, print the table, write plot and log; 1 if something is not as demanded."""
    from workbench.design.hover_check import check_hover
    from workbench.gains.gains import choose_gains
    from workbench.plant.plausible import doubts
    from workbench.scenario.scenario import Scenario, flown_controller

    scenario = with_vehicle(Scenario(), args)
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
    result = _result(report, gains, outputs.files) | {"warnings": unlikely}
    result |= told_of_autopilot(report.exchange, report.ended)
    print_result(args, result, _print, report, law, gains, unlikely, files=outputs.files)
    if report.ended:
        say(report.ended)
    missed = [_sentence(demand) for demand in report.demands if not demand.met]
    code = not_as_demanded(missed)
    return ExitCode.NOT_AS_DEMANDED if report.ended else code


def _result(report: "HoverReport", gains: "dict[str, Gain]", files: "list[Path]") -> dict[str, Any]:
    """Return everything as JSON has it; angles in rad."""
    vehicle = report.hover.vehicle
    return {
        "vehicle": vehicle.name,
        "source": vehicle.source,
        "mass": vehicle.mass,
        "gains": gains,
        "hover": {
            "duration": float(report.hover.time[-1]),
            "drift": float(report.drift.max()),
            "tilt": float(report.tilt.max()),
            "rotor_use": report.rotor_use,
        },
        "steps": [
            {
                "axis": step.axis,
                "amplitude": step.amplitude,
                **dataclasses.asdict(step.metrics),
                "peak_rotor_use": step.peak_rotor_use,
                "coupling": step.coupling,
            }
            for step in report.steps
        ],
        "demands": [{**dataclasses.asdict(demand), "met": demand.met} for demand in report.demands],
        "met": all(demand.met for demand in report.demands),
        "files": files,
    }


def _print(
    report: "HoverReport", law: "Controller", gains: "dict[str, Gain]", unlikely: list[str]
) -> None:
    """Print vehicle, gains, the table of what is demanded, and why all of it may mean nothing."""
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
        print(f"\n{'all ok, but' if met else 'besides,'} this is unlikely of a drone:")
        for doubt in unlikely:
            print(f"  {doubt}")


def _print_gains(law: "Controller", gains: "dict[str, Gain]") -> None:
    """Print the gains by where they come from, without the parameter table's defaults."""
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
        f"{demand.flight}{_size(demand.flight)}: {demand.quantity}",
        number(scale * demand.value, ".3f"),
        f"{scale * demand.limit:g}",
        unit,
        "ok" if demand.met else "not ok",
    ]


def _size(flight: str) -> str:
    """Return the amplitude of a step, as text behind its name."""
    from workbench.design.step_response import STEPS
    from workbench.scenario.axes import find_axis

    sizes = {f"{axis} step": f" {size:g} {find_axis(axis).unit}" for axis, size in STEPS}
    return sizes.get(flight, "")


def _sentence(demand: "Demand") -> str:
    """Return what is wrong with a demand that is not met."""
    _, value, limit, unit, _ = _line(demand)
    quantity = demand.quantity.replace("_", "-", 1).replace("_", " ")
    if demand.withheld:
        return f"{quantity} of the {demand.flight} is not known, as {demand.withheld}"
    return f"{quantity} of the {demand.flight} is {value} {unit} (at most {limit} {unit})"
