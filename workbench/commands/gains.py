"""`workbench gains`: show, compare, save, restore and translate gains, and exchange them."""

import argparse
import dataclasses
import math
import re
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

from workbench.commands import ExitCode
from workbench.commands.options import (
    add_command,
    add_controller_option,
    add_json_option,
    add_model_options,
    add_vehicle_options,
    chosen_scenario,
    flown_with,
)
from workbench.commands.outputs import check_writable
from workbench.commands.printing import pick, print_result, print_table, say, say_written
from workbench.commands.progress import progress_bar
from workbench.common.errors import WorkbenchError
from workbench.scenario.parameters import parameter_table

if TYPE_CHECKING:
    from workbench.control.controller import Controller
    from workbench.design.judge.margins import LoopMargins
    from workbench.design.translate.translation import Difference, Translation
    from workbench.gains.autopilots.exchange import Imported
    from workbench.gains.autopilots.file_lines import Line
    from workbench.gains.autopilots.parameter_file import Remark
    from workbench.gains.gains import GainChange, GainFile, Save
    from workbench.plant.vehicle import Vehicle
    from workbench.scenario.scenario import Scenario


_MOST_CHANGES = 3
"""Largest number of changes printed for a state; --json has all."""

_SUFFIXES = (".yaml", ".yml")
"""Endings of gain files, which distinguish them from descriptions."""
_RULE, _DEFAULT = "rule", "default"
FIRMWARES = ("px4", "ardupilot", "betaflight", "crazyflie")


def add_parser(commands: Any) -> None:
    """Add the command and its own commands."""
    parser = add_command(
        commands,
        "gains",
        "Show, compare, save and restore gains; a gain file keeps every state that was saved.",
        "workbench gains diff dh_drone rule",
        _ask,
    )
    actions = parser.add_subparsers(title="commands", metavar="COMMAND")
    show = add_command(
        actions,
        "show",
        "Print a gain file, or the gains that a model flies with, with units and origin.",
        "workbench gains show my_gains.yaml",
        _show,
    )
    show.add_argument("file", nargs="?", type=Path, metavar="FILE", help="gain file")
    _add_model_options(show)
    add_json_option(show)
    diff = add_command(
        actions,
        "diff",
        "Print the differences between two sets of gains; a gain that one of them lacks comes "
        "from the rule.",
        "workbench gains diff dh_drone my_gains.yaml",
        _diff,
    )
    help = f"gain file (.yaml), model, '{_RULE}' (gains that follow from the vehicle) or "
    for side in ("a", "b"):
        diff.add_argument(side, metavar=side.upper(), help=f"{help}'{_DEFAULT}'")
    _add_model_options(diff)
    add_json_option(diff)
    save = add_command(
        actions,
        "save",
        "Write the gains that a model flies with to a file; an existing file gets one more state.",
        "workbench gains save my_gains.yaml --set kp_velocity_z=3 --origin 'softer climb'",
        _save,
    )
    save.add_argument("file", type=Path, metavar="FILE", help="gain file to write (.yaml)")
    save.add_argument("--origin", metavar="TEXT", help="where the values come from, for the file")
    add_vehicle_options(save)
    add_json_option(save)
    history = add_command(
        actions,
        "history",
        "List the states that were saved in a gain file.",
        "workbench gains history my_gains.yaml",
        _history,
    )
    history.add_argument("file", type=Path, metavar="FILE", help="gain file")
    add_controller_option(history, "file")
    add_json_option(history)
    restore = add_command(
        actions,
        "restore",
        "Restore an earlier state of a gain file, as one more state.",
        "workbench gains restore my_gains.yaml 0",
        _restore,
    )
    restore.add_argument("file", type=Path, metavar="FILE", help="gain file")
    restore.add_argument(
        "state", type=int, metavar="N", help="its number in `workbench gains history`"
    )
    add_controller_option(restore, "file")
    add_json_option(restore)
    add_exchange(actions)
    add_translate(actions)


def _ask(args: argparse.Namespace) -> int:
    """Print the available commands, as none was given."""
    raise WorkbenchError(
        "say what to do: workbench gains show, diff, save, history or restore, and with "
        "autopilots import, export or translate"
    )


def _show(args: argparse.Namespace) -> int:
    """Print a file, or the gains that a model flies with."""
    from workbench.gains.gains import choose_gains, load_gains, make_profile

    law = _law(args, args.file)
    if args.file is None:
        vehicle = _read_vehicle(args)
        chosen = choose_gains(vehicle, controller=law)
        all_values = {name: gain.value for name, gain in chosen.items()}
        values = make_profile(vehicle, all_values, "", law).gains
        origins = {name: chosen[name].origin for name in values}
        about = {"vehicle": vehicle.name, "controller": law.name}
    else:
        file = load_gains(args.file, law)
        values = file.gains
        origins = dict.fromkeys(values, "")
        about = {"vehicle": file.vehicle, "controller": law.name, "origin": file.origin}
    _print_values(args, about, values, origins, law)
    return ExitCode.DONE


def _diff(args: argparse.Namespace) -> int:
    """Print the differences of two sets."""
    from workbench.common.resources import find_file
    from workbench.gains.gains import diff_gains, rule_values

    law = _law(args, *(find_file(side) for side in (args.a, args.b) if _is_file(side)))
    vehicle = _read_vehicle_of_sides(args, law)
    a, b = _side(args.a, vehicle, law), _side(args.b, vehicle, law)
    changes = diff_gains(a, b, rule_values(vehicle, law), law)
    _print_changes(args, args.a, args.b, vehicle.name, changes)
    return ExitCode.DONE


def _save(args: argparse.Namespace) -> int:
    """Write the gains that a model flies with."""
    from workbench.gains.gains import flight_gains, make_profile, save_gains

    _check_suffix(args.file)
    law = _law(args)
    vehicle = _read_vehicle(args)
    values = flight_gains(vehicle, args.gains or "", dict(args.set), law)
    origin = f"{vehicle.name} {flown_with(args)}" if args.origin is None else args.origin
    file = make_profile(vehicle, values, origin, law)
    for name, _ in args.set:
        if name not in file.gains:
            raise WorkbenchError(f"{name} is not a gain, so a gain file cannot hold it")
    saved = save_gains(args.file, file, law)
    result = {"file": args.file, "state": len(saved.history) - 1}
    result |= pick(saved, "vehicle controller origin gains")
    print_result(args, result, files=[args.file])
    return ExitCode.DONE


def _history(args: argparse.Namespace) -> int:
    """List the states of a file."""
    from workbench.gains.gains import load_gains

    _print_history(args, load_gains(args.file, _law(args, args.file)))
    return ExitCode.DONE


def _restore(args: argparse.Namespace) -> int:
    """Save an earlier state of a file again."""
    from workbench.gains.gains import diff_gains, gains_at, load_gains, save_gains
    from workbench.scenario.parameters import parameter_table

    law = _law(args, args.file)
    before = load_gains(args.file, law)
    after = save_gains(args.file, gains_at(before, args.state, law), law)
    changes = diff_gains(before.gains, after.gains, parameter_table(law).defaults(), law)
    sides = ("before", f"state {args.state}")
    _print_changes(args, *sides, after.vehicle, changes, files=[args.file])
    return ExitCode.DONE


def _add_model_options(parser: argparse.ArgumentParser) -> None:
    """Add options for a model, without values of its parameters."""
    group = parser.add_argument_group("vehicle")
    add_model_options(group, "shipped model or description (default: dh_drone)")
    add_controller_option(group, "gain file")
    parser.set_defaults(world="", gains="", estimator="", set=[], vary=[])


def _law(args: argparse.Namespace, *files: Path | None) -> "Controller":
    """Return the controller named by --controller, else that of the first gain file.

    Raises:
        WorkbenchError: if that is not a shipped one, as a gain file does not state the path of its
            file.
    """
    from workbench.control.controller import DEFAULT, load_controller
    from workbench.gains.gains import load_gains

    named = [load_gains(file).controller for file in files if file and not args.controller]
    return load_controller(args.controller or (named[0] if named else DEFAULT))


def _check_suffix(file: Path | None) -> None:
    """Check the name of a gain file to write, if any."""
    if file and file.suffix not in _SUFFIXES:
        raise WorkbenchError(f"{file}: a gain file's name ends in .yaml")


def _read_vehicle(args: argparse.Namespace) -> "Vehicle":
    """Return the vehicle that the command line names."""
    from workbench.scenario.configured import configured_vehicle

    return configured_vehicle(chosen_scenario(args).vehicle)


def _read_vehicle_of_sides(args: argparse.Namespace, law: "Controller") -> "Vehicle":
    """Return the vehicle for the rule in a comparison: that of --model, else that of a side."""
    from workbench.common.resources import find_file, list_models
    from workbench.gains.gains import load_gains

    models = [side for side in (args.a, args.b) if _is_model(side)]
    files = [find_file(side) for side in (args.a, args.b) if _is_file(side)]
    named = [load_gains(file, law).vehicle for file in files]
    models += [name for name in named if name in list_models()]
    args.model = args.model or (models[0] if models else None)
    return _read_vehicle(args)


def _side(side: str, vehicle: "Vehicle", law: "Controller") -> Mapping[str, float]:
    """Return the gains of one side of a comparison."""
    from workbench.common.resources import find_file, find_model
    from workbench.gains.gains import flight_gains, load_gains, make_profile, rule_values
    from workbench.plant.loading import load_vehicle
    from workbench.scenario.parameters import parameter_table

    if _is_file(side):
        return load_gains(find_file(side), law).gains
    if side == _RULE:
        values = rule_values(vehicle, law)
    elif side == _DEFAULT:
        values = parameter_table(law).defaults()
    else:
        values = flight_gains(load_vehicle(find_model(side)), controller=law)
    return make_profile(vehicle, values, "", law).gains


def _is_file(side: str) -> bool:
    return Path(side).suffix in _SUFFIXES


def _is_model(side: str) -> bool:
    return not _is_file(side) and side not in (_RULE, _DEFAULT)


def _print_values(
    args: argparse.Namespace,
    about: Mapping[str, str],
    values: Mapping[str, float],
    origins: Mapping[str, str],
    controller: "Controller",
) -> None:
    """Print gains with their units.

    Args:
        args: of the command line.
        about: heading lines by their labels.
        values: by name.
        origins: of each value, by name.
        controller: of the gains.
    """
    table = parameter_table(controller)
    gains = [
        {"name": name, "value": value, "unit": table.find(name).unit, "origin": origins[name]}
        for name, value in values.items()
    ]

    def show() -> None:
        for what, text in about.items():
            print(f"{what}: {text or '(not said)'}")
        rows = [
            (name, f"{value:g}", table.find(name).unit, origins[name])
            for name, value in values.items()
        ]
        print_table(rows, left=(0, 2, 3))

    print_result(args, {**about, "gains": gains}, show)


def _print_changes(
    args: argparse.Namespace,
    a: str,
    b: str,
    vehicle: str,
    changes: "Sequence[GainChange]",
    files: Sequence[Path] = (),
) -> None:
    """Print the differences between two sets.

    Args:
        args: of the command line.
        a: name of the first.
        b: name of the second.
        vehicle: the one with the rule for gains that one of them lacks.
        changes: all rows, including equal ones, which only JSON has.
        files: the written ones.
    """
    result = {"a": a, "b": b, "vehicle": vehicle, "rows": [row._asdict() for row in changes]}
    print_result(args, result, _show_changes, a, b, changes, files=files)


def _show_changes(a: str, b: str, changes: "Sequence[GainChange]") -> None:
    differing = [row for row in changes if row.a != row.b]
    equal = len(changes) - len(differing)
    if not differing:
        print(f"no difference in {equal} gains")
        return
    rows = [
        (row.name, f"{row.a:g}", f"{row.b:g}", row.unit, _percent(row.percent)) for row in differing
    ]
    print_table([("", a, b, "", "change"), *rows], left=(0, 3))
    if equal:
        print(f"{equal} others are equal")


def _print_history(args: argparse.Namespace, gains: "GainFile") -> None:
    """Print the states of a gain file, oldest first."""
    states = [
        {"state": index, "saved": save.saved or None, **pick(save, "origin changed")}
        for index, save in enumerate(gains.history)
    ]
    print_result(args, {"vehicle": gains.vehicle, "states": states}, _show_history, gains)


def _show_history(gains: "GainFile") -> None:
    if not gains.history:
        print("no state was saved yet: the file is as it was written by hand")
        return
    rows = [
        (str(index), save.saved or "-", _changes(save), save.origin)
        for index, save in enumerate(gains.history)
    ]
    print_table([("state", "saved (UTC)", "changed", "origin"), *rows], left=(1, 2, 3))


def _changes(save: "Save") -> str:
    """Return the changes of a save, in short."""
    parts = [
        f"{name} {_value(before)} to {_value(after)}"
        for name, (before, after) in save.changed.items()
    ]
    more = len(parts) - _MOST_CHANGES
    return ", ".join(parts[:_MOST_CHANGES]) + (f", {more} more" if more > 0 else "") or "-"


def _value(value: float | None) -> str:
    return "none" if value is None else f"{value:g}"


def _percent(percent: float) -> str:
    return "" if percent != percent else f"{percent:+.1f} %"


def add_translate(actions: Any) -> None:
    """Add the command."""
    parser = add_command(
        actions,
        "translate",
        "Translate the gains of one law to gains of another that make the same loops, and say "
        "what is not exact.",
        "workbench gains translate pd --to px4 --model f450.urdf.xacro --save px4.yaml",
        _translate,
    )
    parser.add_argument(
        "source", metavar="FROM", help="law whose gains the model flies with, or a gain file"
    )
    parser.add_argument("--to", required=True, metavar="LAW", help="law to translate them to")
    parser.add_argument("--save", type=Path, metavar="GAINS", help="gain file to write (.yaml)")
    add_vehicle_options(parser)
    add_json_option(parser)


def _translate(args: argparse.Namespace) -> int:
    """Translate, compare the loops, and save the gains if requested."""
    from workbench.control.controller import load_controller
    from workbench.design.linear.study import LinearStudy
    from workbench.design.translate.forms import form_of
    from workbench.design.translate.translation import differences, gains_alone, translate
    from workbench.gains.gains import flight_gains, make_profile, owner_of, save_gains

    _check_suffix(args.save)
    if args.controller:
        raise WorkbenchError("the laws are FROM and --to: leave --controller out")
    if _is_file(args.source):
        if args.gains:
            raise WorkbenchError(f"the gains are those in {args.source}: leave --gains out")
        args.gains, args.source = args.source, owner_of(Path(args.source))
    laws = load_controller(args.source), load_controller(args.to)
    for law in laws:
        form_of(law)
    if laws[0].name == laws[1].name:
        raise WorkbenchError(f"the gains are already those of {laws[0].name}: name another law")
    args.controller = laws[0].reference
    old = LinearStudy(chosen_scenario(args))
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
        file = make_profile(old.vehicle, found.values, origin, laws[1])
        save_gains(args.save, file, laws[1])
    loops = {"flown": flown, "gains_alone": alone}
    result = {**about, **pick(found, "gains lost remarks"), "loops": loops}
    title = f"{old.vehicle.name}: gains of {laws[0].name}, translated to {laws[1].name}"
    shown = (title, found, flown, alone)
    print_result(args, result, _print_translation, *shown, files=[args.save] if args.save else [])
    return ExitCode.DONE


def _print_translation(
    title: str,
    found: "Translation",
    flown: "tuple[Difference, ...]",
    alone: "tuple[Difference, ...]",
) -> None:
    """Print the gains, the loops and inexact parts."""
    print(title)
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


def add_exchange(actions: Any) -> None:
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
        "--for",
        dest="firmware",
        choices=FIRMWARES,
        default="",
        help="(default: found from the text)",
    )
    _add_common(read)
    read.add_argument("--save", type=Path, metavar="GAINS", help="gain file to write (.yaml)")
    write = add_command(
        actions,
        "export",
        "Write gains to an autopilot's file; in an existing file only the values of the gains "
        "change.",
        "workbench gains export vehicle.params --for px4 --model f450.urdf.xacro --gains px4.yaml",
        _export,
    )
    write.add_argument("file", type=Path, metavar="FILE", help="file of parameters to write")
    write.add_argument(
        "--for",
        dest="firmware",
        choices=FIRMWARES,
        required=True,
        help="autopilot that the file is for",
    )
    _add_common(write)
    write.add_argument(
        "--preview", action="store_true", help="show what would change, and write nothing"
    )
    write.add_argument(
        "--force", action="store_true", help="write gains that would not fly, such as P gains of 0"
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
    parser.add_argument(
        "--no-margins", action="store_true", help="leave out the margins of the loops"
    )
    add_vehicle_options(parser)
    add_json_option(parser)


def _import(args: argparse.Namespace) -> int:
    """Compare the file with the present gains, and save its gains if requested."""
    from workbench.control.controller import load_controller
    from workbench.gains.autopilots.exchange import VERSION_ROW, import_gains
    from workbench.gains.autopilots.parameter_file import joined
    from workbench.gains.gains import diff_gains, make_profile, save_gains

    _check_suffix(args.save)
    law = load_controller(args.controller) if args.controller else None
    found = _from_log(args, law) or import_gains(
        args.file, args.firmware, args.version, args.profile, law
    )
    scenario, vehicle, present = _flown(args, found.law)
    flown = found.flown(present)
    changes = diff_gains({name: present[name] for name in flown}, flown, present, found.law)
    shown = found.values.keys() & {row.name for row in found.firmware.rows(found.law)}
    changes = [row for row in changes if row.name in shown or row.a != row.b]
    changes = [row for row in changes if row.name != VERSION_ROW]
    after = {**present, **flown}
    margins = _margins(args, scenario, present, after)
    remarks = [*found.remarks, *_hover_remarks(found, vehicle)]
    about = {
        "file": args.file,
        "firmware": found.firmware.name,
        "version": found.version,
        "controller": found.law.name,
        "vehicle": vehicle.name,
    }
    written: list[Path] = []
    if found.unsafe:
        _print_exchange(args, about, changes, margins, remarks, found, written)
        wrong = [f"{found.firmware.file_name(n)} {why}" for n, why in found.unsafe.items()]
        raise WorkbenchError(f"{args.file}: {joined(wrong, 4)}; nothing is imported")
    if args.save:
        origin = f"{args.file.name}, {found.firmware.name} {found.version}"
        save_gains(args.save, make_profile(vehicle, after, origin, found.law), found.law)
        written.append(args.save)
    _print_exchange(args, about, changes, margins, remarks, found, written)
    return ExitCode.DONE


def _from_log(args: argparse.Namespace, law: "Controller | None") -> "Imported | None":
    """Return the gains in the parameters of a log of PX4 or ArduPilot; None for any other file."""
    from workbench.gains.autopilots.exchange import imported
    from workbench.gains.autopilots.firmware import file_of, find_firmware
    from workbench.logs.flight_reader import read_flight
    from workbench.logs.readers import dataflash, ulog
    from workbench.logs.readers.packed import read_head

    firmwares = {ulog.MAGIC: "px4", dataflash.MAGIC: "ardupilot"}
    head = read_head(args.file, len(ulog.MAGIC))
    name = next((each for magic, each in firmwares.items() if head.startswith(magic)), "")
    if not name:
        return None
    if args.firmware not in ("", name) or args.profile is not None:
        raise WorkbenchError(f"{args.file}: is a log of {name}: leave out --for and --profile")
    with progress_bar(f"reading {args.file.name}") as progress:
        flight = read_flight(args.file, None, progress)
    if name == "ardupilot" and not flight.firmware.startswith(("ArduCopter", "APM:Copter")):
        raise WorkbenchError(f"{args.file}: is a log of {flight.firmware or name}, not of a copter")
    for remark in flight.remarks:
        if "parameters changed" in remark:
            say(f"{args.file}: {remark}")
    values = {key: value for key, value in flight.parameters.items() if isinstance(value, float)}
    stated = re.search(r"\d+\.\d+(\.\d+)?", flight.firmware)
    version = args.version or (stated[0] if stated else "")
    return imported(file_of(args.file, values, version), find_firmware(name), version, law)


def _export(args: argparse.Namespace) -> int:
    """Compare with the existing file, or the defaults of the firmware, and write."""
    from workbench.common.plain_files import write_atomically
    from workbench.common.resources import existing
    from workbench.control.controller import load_controller
    from workbench.gains.autopilots.exchange import export_gains, import_gains
    from workbench.gains.autopilots.firmware import find_firmware
    from workbench.gains.autopilots.parameter_file import Remark, encoded
    from workbench.gains.gains import diff_gains, load_gains

    firmware = find_firmware(args.firmware)
    if not args.controller:
        owner = load_gains(Path(args.gains)).controller if args.gains else firmware.laws[0]
        args.controller = owner
    law = load_controller(args.controller)
    present = None
    if not args.preview:
        check_writable(args.file)
    if existing(str(args.file)):
        present = import_gains(args.file, firmware.name, args.version, args.profile, law)
    scenario, vehicle, values = _flown(args, law)
    made = export_gains(values, law, firmware, args.version, present)
    before = firmware.defaults(made.release)
    before = {row.name: before.get(row.name, row.default) for row in firmware.rows(law)}
    if present:
        before = {name: value for name, value in present.values.items() if firmware.has(name)}
    gains = {name: values[name] for name in before}
    changes = diff_gains(before, gains, values, law)
    margins = _margins(args, scenario, {**values, **before}, values)
    about = {
        "file": args.file,
        "firmware": firmware.name,
        "version": args.version or (present.version if present else made.release.version),
        "controller": law.name,
        "vehicle": vehicle.name,
    }
    grounded = [Remark(f"would not fly: {each}") for each in made.grounded]
    remarks = [*grounded, *made.remarks]
    _print_exchange(args, about, changes, margins, remarks, present, written=None)
    if made.refusal and not args.force and not args.preview:
        raise WorkbenchError(
            f"{args.file}: {made.refusal}: set them with --set, or insist with --force"
        )
    if not args.preview:
        write_atomically(args.file, encoded(made.text))
        say_written([args.file])
    return ExitCode.DONE


def _flown(
    args: argparse.Namespace, law: "Controller"
) -> tuple["Scenario", "Vehicle", dict[str, float]]:
    """Return scenario, vehicle and all values that the command line names, with a law."""
    from workbench.gains.gains import flight_gains
    from workbench.scenario.configured import configured_vehicle

    args.controller = law.reference
    scenario = chosen_scenario(args)
    vehicle = configured_vehicle(scenario.vehicle)
    return scenario, vehicle, flight_gains(vehicle, args.gains or "", dict(args.set), law)


def _hover_remarks(found: "Imported", vehicle: "Vehicle") -> "list[Remark]":
    """Return remarks on a hover thrust that differs from that of the vehicle."""
    from workbench.gains.autopilots.parameter_file import Remark
    from workbench.gains.gains import rule_gains

    said = []
    ruled = rule_gains(vehicle, found.law)
    for name in ("MPC_THR_HOVER", "MOT_THST_HOVER"):
        if name in found.values and name in ruled:
            value, own = found.values[name], ruled[name]
            if abs(value - own) > 0.05 * own:
                text = (
                    f"{name} is {value:.3g} in the file, and {vehicle.name} hovers at {own:.3g}: "
                    "vertical gains are scaled by the ratio"
                )
                said.append(Remark(text, found.file.counted[name].line))
    return said


def _margins(
    args: argparse.Namespace,
    scenario: "Scenario",
    before: Mapping[str, float],
    after: Mapping[str, float],
) -> "list[dict[str, LoopMargins]]":
    """Return margins of all loops by name, with two sets of gains; nothing if there are none."""
    if args.no_margins:
        return []
    from workbench.commands.progress import progress_bar
    from workbench.design.judge.loop_judgement import hover_margins
    from workbench.design.linear.operating_point import HOLDING
    from workbench.design.linear.study import LinearStudy

    with progress_bar("judging the loops before and after") as progress:
        study = LinearStudy(scenario)
        progress(0.5)
        try:
            return [hover_margins(study.sampled(HOLDING, gains)) for gains in (before, after)]
        except WorkbenchError as error:
            say(f"no margins: {error}")
            return []


def _print_exchange(
    args: argparse.Namespace,
    about: Mapping[str, Any],
    changes: "Sequence[GainChange]",
    margins: "Sequence[dict[str, LoopMargins]]",
    remarks: "Sequence[Remark]",
    found: "Imported | None",
    written: list[Path] | None,
) -> None:
    """Print differences, margins and remarks."""
    from workbench.control.controller import load_controller
    from workbench.gains.autopilots.firmware import find_firmware
    from workbench.scenario.parameters import parameter_table

    firmware = find_firmware(about["firmware"])
    table = parameter_table(load_controller(args.controller))
    wrong = found.unsafe if found else {}
    before, after = margins or ({}, {})
    result = {
        **about,
        "gains": [
            row._asdict()
            | {
                "file_name": firmware.file_name(row.name),
                "meaning": table.find(row.name).help,
                "origin": _origin(row.name, found),
            }
            for row in changes
        ],
        "unsafe": wrong,
        **_unflown(found),
        "margins": [
            {"loop": loop, "before": margins, "after": after[loop]}
            for loop, margins in before.items()
        ],
        "remarks": [str(each) for each in remarks],
        "remark_details": [
            {"text": each.text, "place": _place(about["file"], each), "count": each.count}
            for each in remarks
        ],
    }

    def show() -> None:
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
                    _percent(row.percent),
                    table.find(row.name).help
                    + (" (default)" if _origin(row.name, found) == "default" else ""),
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
        if found:
            _print_unflown(found)
        for remark in remarks:
            print(f"note: {remark}")

    print_result(args, result, show, files=written or [])


def _place(file: Path, remark: "Remark") -> str:
    return f"{file}:{remark.line}" if remark.line else str(file)


def _origin(name: str, found: "Imported | None") -> str:
    """Return where the value of a gain comes from: the file, or its version."""
    return "default" if found and name not in found.values else "file"


def _unflown(found: "Imported | None") -> dict[str, Any]:
    """Return what each line of a file is, and what the law does not have."""
    if found is None:
        return {"not_flown": (), "on_by_default": (), "account": {}, "lines": []}
    acting = [each for each in found.left if each.acts]
    return {
        "not_flown": [each.name for each in found.left],
        "acting": [{"name": each.name, "value": each.text, "line": each.line} for each in acting],
        "on_by_default": [str(each) for each in found.standing],
        "account": {
            part: {"count": len(lines), "names": sorted({each.name for each in lines} - {""})}
            for part, lines in _parts(found).items()
        },
        "lines": [
            {
                "line": each.number,
                "name": each.name,
                "value": each.text,
                "part": each.part,
                "why": each.why,
            }
            for each in found.lines
        ],
    }


def _parts(found: "Imported") -> "dict[str, list[Line]]":
    """Return the lines of a file by what becomes of them."""
    from workbench.gains.autopilots.file_lines import FLOWN, NOT_FLOWN, UNKNOWN

    parts = (FLOWN, NOT_FLOWN, UNKNOWN)
    return {part: [each for each in found.lines if each.part == part] for part in parts}


def _print_unflown(found: "Imported") -> None:
    """Print the parameters of flight control that the law does not have, with their values."""
    counts = {part: len(lines) for part, lines in _parts(found).items()}
    print(
        f"lines: {', '.join(f'{count} {part}' for part, count in counts.items())}; "
        "--json accounts for each"
    )
    acting = [str(each) for each in found.left if each.acts]
    others = [each.name for each in found.left if not each.acts]
    if acting:
        print(f"not simulated, and not imported: {', '.join(acting)}")
    if others:
        print(f"not imported, and without effect here: {', '.join(others)}")
    if found.standing:
        print(
            f"on by default in {found.release.version}, and not simulated: "
            f"{', '.join(map(str, found.standing))}"
        )


def print_margins(before: "dict[str, LoopMargins]", after: "dict[str, LoopMargins]") -> None:
    """Print margins of loops by name, before and after."""
    rows: list[tuple[str, ...]] = [
        ("loop", "phase margin [deg]", "", "gain margin", "", "crossover [rad/s]", ""),
        ("", "before", "after", "before", "after", "before", "after"),
    ]
    for loop in before:
        sides = before[loop], after[loop]
        phases = [_cell(each, math.degrees(each.phase_margin)) for each in sides]
        factors = [_cell(each, each.gain_margin) for each in sides]
        crossovers = [_cell(each, each.crossover) for each in sides]
        rows.append((loop, *phases, *factors, *crossovers))
    print_table(rows)


def _cell(margins: "LoopMargins", value: float) -> str:
    if not margins.stable:
        return "unstable"
    return "none" if not math.isfinite(value) else f"{value:.3g}"
