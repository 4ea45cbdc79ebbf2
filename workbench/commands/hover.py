"""`workbench hover`: how well a vehicle hovers."""

import argparse
import math
from typing import TYPE_CHECKING, Any

from workbench.commands import ExitCode
from workbench.commands.chosen_vehicle import chosen_setup
from workbench.commands.options import (
    Subcommands,
    add_command,
    add_flier_options,
    add_flight_options,
)
from workbench.commands.outputs import Outputs
from workbench.commands.printing import (
    autopilot_json,
    lost_replies,
    pick,
    print_message,
    print_result,
    print_table,
    report_unmet,
)
from workbench.commands.progress import progress_bar

if TYPE_CHECKING:
    from workbench.control.controller import Controller
    from workbench.design.hover_check import HoverReport
    from workbench.design.metrics import Demand
    from workbench.gains.gain_choice import Gain


_ORIGINS = {"rule": "the rule for any vehicle"}
"""Other names for the origin of a gain."""


def add_hover(commands: Subcommands) -> None:
    """Add the command."""
    parser = add_command(
        commands,
        "check",
        "Fly ten seconds of hover and a step on every axis, and report how well they went.",
        "workbench check --model my_drone.urdf --output out",
        run_hover,
        other_name="hover",
    )
    add_flight_options(parser)
    add_flier_options(parser)


def run_hover(args: argparse.Namespace) -> int:
    """Fly, print the table, write plot and log; return 1 if a demand is not met."""
    from workbench.design.hover_check import check_hover
    from workbench.gains.gain_choice import choose_gains
    from workbench.plant.plausible import implausible_values

    setup = chosen_setup(args)
    with Outputs() as outputs:
        log = outputs.add(args.output / "hover-check.csv")
        plot = outputs.picture(args, "hover-check.png")
        with progress_bar("flying hover and four steps") as progress:
            report = check_hover(setup, progress=progress)
        report.hover.write_csv(log)
        if plot:
            from workbench.design.plots import write_png
            from workbench.design.plots_step import plot_hover

            write_png(plot_hover(report), plot)
    law, own = setup.controller, setup.scenario.vehicle.gains
    gains = choose_gains(setup.vehicle, own, setup.settings, law)
    unlikely = implausible_values(report.hover.vehicle)
    result = _hover_result(report, gains) | {"warnings": unlikely}
    result |= autopilot_json(report.exchange, report.ended)
    print_result(args, result, _print_hover, report, law, gains, unlikely, files=outputs.files)
    if report.ended:
        print_message(report.ended)
    missed = [_sentence(demand) for demand in report.demands if not demand.met]
    code = report_unmet(missed)
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
                **step.metrics.to_json(),
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
    origins = dict.fromkeys(gain.origin for gain in gains.values())
    for origin in origins:
        if origin == "default":
            continue
        print(f"\ngains from {_ORIGINS.get(origin, origin)}:")
        rows = [
            (f"  {name}", f"{gain.value:g}", law.table.find(name).unit)
            for name, gain in gains.items()
            if gain.origin == origin
        ]
        print_table(rows, left=(0, 2))


def _line(demand: "Demand") -> list[str]:
    """Return one line of the table; angles in degrees."""
    from workbench.common.quantity import number_or_dash

    scale, unit = (math.degrees(1.0), "deg") if demand.unit == "rad" else (1.0, demand.unit)
    return [
        f"{demand.criterion}{_size(demand.criterion)}: {demand.quantity}",
        number_or_dash(scale * demand.value, ".3f"),
        f"{scale * demand.limit:g}",
        unit,
        "ok" if demand.met else "not ok",
    ]


def _size(flight: str) -> str:
    """Return the amplitude of a step, as text after its name."""
    from workbench.design.step_response import USUAL_STEPS
    from workbench.scenario.axes import find_axis

    sizes = {f"{axis} step": f" {size:g} {find_axis(axis).unit}" for axis, size in USUAL_STEPS}
    return sizes.get(flight, "")


def _sentence(demand: "Demand") -> str:
    """Return a sentence on a demand that is not met."""
    _, value, limit, unit, _ = _line(demand)
    quantity = demand.quantity.replace("_", "-", 1).replace("_", " ")
    if demand.withheld:
        return f"{quantity} of the {demand.criterion} is not known, as {demand.withheld}"
    return f"{quantity} of the {demand.criterion} is {value} {unit} (at most {limit} {unit})"
