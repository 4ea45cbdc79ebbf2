"""`workbench gains import` and `export`: gains out of an autopilot's file, and into it."""

import argparse
import math
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

from workbench.commands import ExitCode
from workbench.commands.options import (
    add_command,
    add_json_option,
    add_vehicle_options,
    with_vehicle,
)
from workbench.commands.printing import print_json, print_table, say, say_written
from workbench.common.errors import WorkbenchError

if TYPE_CHECKING:
    from workbench.control.controller import Controller
    from workbench.design.judge.loop_judgement import LiveMargins
    from workbench.gains.autopilots.exchange import Imported
    from workbench.gains.profiles import GainChange
    from workbench.plant.vehicle import Vehicle
    from workbench.scenario.scenario import Scenario

FIRMWARES = ("px4", "ardupilot", "betaflight", "crazyflie")


def add_parsers(actions: Any) -> None:
    """Add the two commands."""
    read = add_command(
        actions,
        "import",
        "Show what the gains in an autopilot's file change, with margins; --save keeps them.",
        "workbench gains import vehicle.params --model f450.urdf.xacro --save px4.yaml",
        _import,
    )
    read.add_argument("file", type=Path, metavar="FILE", help="of parameters, see docs/autopilots")
    read.add_argument(
        "--for", dest="firmware", choices=FIRMWARES, default="", help="(default: the text tells)"
    )
    _add_common(read)
    read.add_argument("--save", type=Path, metavar="GAINS", help="gain file to write (.yaml)")
    write = add_command(
        actions,
        "export",
        "Write gains to an autopilot's file; of one that is there only the gains' values change.",
        "workbench gains export vehicle.params --for px4 --model f450.urdf.xacro --gains px4.yaml",
        _export,
    )
    write.add_argument("file", type=Path, metavar="FILE", help="file of parameters to write")
    write.add_argument(
        "--for", dest="firmware", choices=FIRMWARES, required=True, help="who is to fly them"
    )
    _add_common(write)
    write.add_argument(
        "--preview", action="store_true", help="show what would change, and write nothing"
    )


def _add_common(parser: argparse.ArgumentParser) -> None:
    parser.add_argument(
        "--firmware",
        dest="version",
        default="",
        metavar="VERSION",
        help="of the autopilot, as 4.6 (default: what the file says, else that of the law)",
    )
    parser.add_argument(
        "--profile", type=int, metavar="N", help="of Betaflight's file (default: that in use)"
    )
    parser.add_argument("--no-margins", action="store_true", help="leave the loops' margins out")
    add_vehicle_options(parser)
    add_json_option(parser)


def _import(args: argparse.Namespace) -> int:
    """Compare the file with what flies, and keep its gains if that is asked for."""
    from workbench.control.controller import load_controller
    from workbench.gains.autopilots.exchange import import_gains
    from workbench.gains.autopilots.parameter_file import joined
    from workbench.gains.gains import make_profile, save_gains
    from workbench.gains.profiles import diff_gains

    if args.save and args.save.suffix not in (".yaml", ".yml"):
        raise WorkbenchError(f"{args.save}: a gain file's name ends in .yaml")
    law = load_controller(args.controller) if args.controller else None
    found = import_gains(args.file, args.firmware, args.version, args.profile, law)
    scenario, vehicle, present = _flown(args, found.law)
    changes = diff_gains(
        {name: present[name] for name in found.values}, found.values, present, found.law
    )
    after = {**present, **found.values}
    margins = _margins(args, scenario, present, after)
    remarks = [*found.remarks, *_hover(found, vehicle)]
    about = {
        "file": args.file,
        "firmware": found.firmware.name,
        "version": found.version,
        "controller": found.law.name,
        "vehicle": vehicle.name,
    }
    written: list[Path] = []
    if found.unsafe:
        _print(args, about, changes, margins, remarks, found, written)
        wrong = [f"{found.firmware.file_name(n)} {why}" for n, why in found.unsafe.items()]
        raise WorkbenchError(f"{args.file}: {joined(wrong, 4)}; nothing is taken over")
    if args.save:
        origin = f"{args.file.name}, {found.firmware.name} {found.version}"
        save_gains(args.save, make_profile(vehicle, after, origin, found.law), found.law)
        written.append(args.save)
    _print(args, about, changes, margins, remarks, found, written)
    return ExitCode.DONE


def _export(args: argparse.Namespace) -> int:
    """Compare with the file that is there, or the firmware's defaults, and write."""
    from workbench.common.plain_files import write_atomically
    from workbench.control.controller import load_controller
    from workbench.gains.autopilots.exchange import export_gains, import_gains
    from workbench.gains.autopilots.firmware import find_firmware
    from workbench.gains.autopilots.parameter_file import encoded
    from workbench.gains.gains import load_gains
    from workbench.gains.profiles import diff_gains

    firmware = find_firmware(args.firmware)
    if not args.controller:
        owner = load_gains(Path(args.gains)).controller if args.gains else firmware.laws[0]
        args.controller = owner
    law = load_controller(args.controller)
    present = None
    if args.file.exists():
        present = import_gains(args.file, firmware.name, args.version, args.profile, law)
    scenario, vehicle, values = _flown(args, law)
    made = export_gains(values, law, firmware, args.version, present)
    before = {row.name: row.default for row in firmware.rows(law)}
    if present:
        before = dict(present.values)
    gains = {name: values[name] for name in before}
    changes = diff_gains(before, gains, values, law)
    margins = _margins(args, scenario, {**values, **before}, values)
    about = {
        "file": args.file,
        "firmware": firmware.name,
        "version": args.version or (present.version if present else firmware.version),
        "controller": law.name,
        "vehicle": vehicle.name,
    }
    _print(args, about, changes, margins, made.remarks, present, written=None)
    if not args.preview:
        write_atomically(args.file, encoded(made.text))
        say_written([args.file])
    return ExitCode.DONE


def _flown(
    args: argparse.Namespace, law: "Controller"
) -> tuple["Scenario", "Vehicle", dict[str, float]]:
    """Return scenario, vehicle and all values that the command line names, with a law."""
    from workbench.gains.gains import flight_gains
    from workbench.plant.loading import make_vehicle
    from workbench.scenario.configured import read_configured
    from workbench.scenario.scenario import Scenario

    args.controller = law.reference
    scenario = with_vehicle(Scenario(), args)
    vehicle = make_vehicle(read_configured(scenario.vehicle))
    return scenario, vehicle, flight_gains(vehicle, args.gains or "", dict(args.set), law)


def _hover(found: "Imported", vehicle: "Vehicle") -> list[str]:
    """Return what to say of a thrust in hover that is not the vehicle's."""
    from workbench.gains.gains import rule_gains

    said = []
    ruled = rule_gains(vehicle, found.law)
    for name in ("MPC_THR_HOVER", "MOT_THST_HOVER"):
        if name in found.values and name in ruled:
            value, own = found.values[name], ruled[name]
            if abs(value - own) > 0.05 * own:
                said.append(
                    f"{name} is {value:.3g} in the file, and {vehicle.name} hovers at {own:.3g}: "
                    "gains of climbing count by their ratio"
                )
    return said


def _margins(
    args: argparse.Namespace,
    scenario: "Scenario",
    before: Mapping[str, float],
    after: Mapping[str, float],
) -> "tuple[tuple[LiveMargins, ...], tuple[LiveMargins, ...]] | None":
    """Return margins of all loops with two sets of gains."""
    if args.no_margins:
        return None
    from workbench.commands.progress import progress_bar
    from workbench.design.judge.loop_judgement import live_margins
    from workbench.design.linear.study import LinearStudy

    with progress_bar("judging the loops before and after") as progress:
        study = LinearStudy(scenario)
        progress(0.5)
        try:
            return live_margins(study, before), live_margins(study, after)
        except WorkbenchError as error:
            say(f"no margins: {error}")
            return None


def _print(
    args: argparse.Namespace,
    about: Mapping[str, Any],
    changes: "Sequence[GainChange]",
    margins: "tuple[tuple[LiveMargins, ...], tuple[LiveMargins, ...]] | None",
    remarks: Sequence[str],
    found: "Imported | None",
    written: list[Path] | None,
) -> None:
    """Print what differs, the margins and the remarks."""
    from workbench.control.controller import load_controller
    from workbench.gains.autopilots.firmware import find_firmware
    from workbench.gains.autopilots.parameter_file import joined
    from workbench.scenario.parameters import parameter_table

    firmware = find_firmware(about["firmware"])
    table = parameter_table(load_controller(args.controller))
    not_flown = found.not_flown if found else ()
    wrong = found.unsafe if found else {}
    if args.json:
        rows = [
            row._asdict()
            | {"file_name": firmware.file_name(row.name), "meaning": table.find(row.name).help}
            for row in changes
        ]
        before, after = margins or ((), ())
        loops = [
            {"loop": a.loop, "before": a.margins, "after": b.margins}
            for a, b in zip(before, after, strict=True)
        ]
        print_json(
            {
                **about,
                "gains": rows,
                "unsafe": wrong,
                "not_flown": not_flown,
                "margins": loops,
                "remarks": remarks,
                "files": written or [],
            }
        )
        return
    print(
        f"{about['file']}: {about['firmware']} {about['version']}, law {about['controller']}, "
        f"vehicle {about['vehicle']}"
    )
    differing = [row for row in changes if row.a != row.b]
    if differing:
        sides = ("now", "file") if written is not None else ("file", "new")
        lines = [
            (
                firmware.file_name(row.name),
                f"{row.a:.5g}",
                f"{row.b:.5g}",
                row.unit,
                "" if math.isnan(row.percent) else f"{row.percent:+.1f} %",
                table.find(row.name).help,
            )
            for row in differing
        ]
        print_table([("", *sides, "", "change", "meaning"), *lines], left=(0, 3, 5))
    print(f"{len(differing)} of {len(changes)} gains differ")
    for name, why in wrong.items():
        print(f"unsafe: {firmware.file_name(name)} {why}")
    if margins:
        print()
        print_margins(*margins)
    if not_flown:
        print(f"not flown here, and left alone: {joined(not_flown)}")
    for remark in remarks:
        print(f"note: {remark}")
    if written:
        say_written(written)


def print_margins(before: "Sequence[LiveMargins]", after: "Sequence[LiveMargins]") -> None:
    """Print margins of loops, before and after."""
    rows: list[tuple[str, ...]] = [
        ("loop", "phase margin [deg]", "", "gain margin", "", "crossover [rad/s]", ""),
        ("", "before", "after", "before", "after", "before", "after"),
    ]
    for a, b in zip(before, after, strict=True):
        pairs = (
            (math.degrees(a.margins.phase_margin), math.degrees(b.margins.phase_margin)),
            (a.margins.gain_margin, b.margins.gain_margin),
            (a.margins.crossover, b.margins.crossover),
        )
        cells = (
            "unstable" if not each.margins.stable else _cell(value)
            for pair in pairs
            for each, value in zip((a, b), pair, strict=True)
        )
        rows.append((a.loop, *cells))
    print_table(rows)


def _cell(value: float) -> str:
    return "none" if not math.isfinite(value) else f"{value:.3g}"
