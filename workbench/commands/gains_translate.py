"""`workbench gains translate`: gains of one law as those of another, on a vehicle."""

import argparse
import dataclasses
from pathlib import Path
from typing import TYPE_CHECKING, Any

from workbench.commands import ExitCode
from workbench.commands.options import (
    add_command,
    add_json_option,
    add_vehicle_options,
    with_vehicle,
)
from workbench.commands.printing import print_json, print_table, say_written
from workbench.common.errors import WorkbenchError

if TYPE_CHECKING:
    from workbench.design.translate.translation import Difference, Translation


def add_parser(actions: Any) -> None:
    """Add the command."""
    parser = add_command(
        actions,
        "translate",
        "Turn gains of one law into those of another that make the same loops, and say what of it "
        "is not exact.",
        "workbench gains translate pd --to px4 --model f450.urdf.xacro --save px4.yaml",
        _translate,
    )
    parser.add_argument(
        "source", metavar="FROM", help="law whose gains the model flies with, or a gain file"
    )
    parser.add_argument("--to", required=True, metavar="LAW", help="law that is to fly them")
    parser.add_argument("--save", type=Path, metavar="GAINS", help="gain file to write (.yaml)")
    add_vehicle_options(parser)
    add_json_option(parser)


def _translate(args: argparse.Namespace) -> int:
    """Translate, compare the loops, and keep the gains if that is asked for."""
    from workbench.control.controller import load_controller
    from workbench.design.linear.study import LinearStudy
    from workbench.design.translate.forms import form_of
    from workbench.design.translate.translation import differences, gains_alone, translate
    from workbench.gains.gains import flight_gains, make_profile, save_gains
    from workbench.gains.profiles import owner_of
    from workbench.scenario.scenario import Scenario

    if args.save and args.save.suffix not in (".yaml", ".yml"):
        raise WorkbenchError(f"{args.save}: a gain file's name ends in .yaml")
    if args.controller:
        raise WorkbenchError("the laws are FROM and --to: leave --controller out")
    if Path(args.source).suffix in (".yaml", ".yml"):
        if args.gains:
            raise WorkbenchError(f"the gains are those in {args.source}: leave --gains out")
        args.gains, args.source = args.source, owner_of(Path(args.source))
    laws = load_controller(args.source), load_controller(args.to)
    for law in laws:
        form_of(law)
    if laws[0].name == laws[1].name:
        raise WorkbenchError(f"the gains are those of {laws[0].name} already: name another law")
    args.controller = laws[0].reference
    old = LinearStudy(with_vehicle(Scenario(), args))
    scenario = dataclasses.replace(old.scenario, controller=laws[1].reference)
    bare = dataclasses.replace(scenario.vehicle, gains="")
    new = old.like(dataclasses.replace(scenario, vehicle=bare))
    values = flight_gains(old.vehicle, args.gains or "", dict(args.set), laws[0])
    found = translate(old, new, values, dict(new.gains))
    flown = differences(old, new, values, found.values)
    alone = gains_alone(old, new, values, found.values)
    about = {"vehicle": old.vehicle.name, "from": laws[0].name, "to": laws[1].name}
    if args.save:
        origin = f"translated from {laws[0].name} for {old.vehicle.name}"
        profile = make_profile(old.vehicle, found.values, origin, laws[1])
        save_gains(args.save, profile, laws[1])
    if args.json:
        print_json(
            {
                **about,
                "gains": found.gains,
                "lost": found.lost,
                "remarks": found.remarks,
                "loops": {"flown": flown, "gains_alone": alone},
                "files": [args.save] if args.save else [],
            }
        )
    else:
        print(f"{old.vehicle.name}: gains of {laws[0].name} as those of {laws[1].name}")
        _print(found, flown, alone)
    if args.save:
        say_written([args.save])
    return ExitCode.DONE


def _print(
    found: "Translation", flown: "tuple[Difference, ...]", alone: "tuple[Difference, ...]"
) -> None:
    """Print the gains, the loops and what is not exact."""
    rows = [(each.name, f"{each.value:.5g}", each.unit, each.said) for each in found.gains]
    print_table([("gain", "value", "", ""), *rows], left=(0, 2, 3))
    print("\nloops at the plant's input, difference up to the crossover:")
    lines = [("loop", "crossover [rad/s]", "new", "as flown", "gains alone", "")]
    for one, other in zip(flown, alone, strict=True):
        lost = found.lost_in(one.channel)
        why = "" if not lost and found.exact else lost[0] if lost else "see the notes"
        lines.append(
            (
                one.channel,
                f"{one.crossover:.3g}",
                f"{one.other:.3g}",
                f"{100.0 * one.largest:.2g} %",
                f"{100.0 * other.largest:.2g} %",
                why,
            )
        )
    print_table(lines, left=(0, 5))
    print("gains alone: both at the same control period, without the laws' own filters")
    for each in dict.fromkeys(found.lost):
        print(f"left out: {each.axis}: {each.said}")
    for remark in found.remarks:
        print(f"note: {remark}")
