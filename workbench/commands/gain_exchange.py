"""`workbench gains import` and `export`: exchange gains with the files and logs of autopilots."""

import argparse
import re
from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING

from workbench.commands import ExitCode
from workbench.commands.chosen_vehicle import chosen_setup
from workbench.commands.exchange_report import print_exchange
from workbench.commands.named_gains import check_gain_file_name, holds_gains
from workbench.commands.options import (
    Subcommands,
    add_command,
    add_json_option,
    add_log_number_option,
    add_vehicle_options,
)
from workbench.commands.outputs import check_writable
from workbench.commands.printing import print_message, print_result, print_written_files
from workbench.commands.progress import progress_bar
from workbench.commands.translated_gains import save_gain_values, translated_gains
from workbench.common.errors import WorkbenchError
from workbench.common.extensions import ExtensionGroup, find_extensions

if TYPE_CHECKING:
    from workbench.control.controller import Controller
    from workbench.design.judge.margins import LoopMargins
    from workbench.gains.formats import GainFormat, ImportedGains
    from workbench.plant.vehicle import Vehicle
    from workbench.scenario.scenario import Scenario


def add_exchange(actions: Subcommands) -> None:
    """Add the two commands."""
    firmwares = tuple(find_extensions(ExtensionGroup.GAIN_FORMATS))
    read = add_command(
        actions,
        "import",
        "Show what the gains in an autopilot's file change, with margins; --save keeps them. "
        "For another law they are translated, as are those of a gain file.",
        "workbench gains import vehicle.params --model f450.urdf.xacro --save px4.yaml",
        _import,
    )
    read.add_argument("file", type=Path, metavar="FILE", help="of parameters, or gain file (.yaml)")
    read.add_argument(
        "--for",
        dest="firmware",
        choices=firmwares,
        default="",
        help="autopilot that the file is of (default: what its text says)",
    )
    add_log_number_option(read)
    _add_common(read)
    read.add_argument("--save", type=Path, metavar="GAINS", help="gain file to write (.yaml)")
    write = add_command(
        actions,
        "export",
        "Write gains to an autopilot's file, translated if they are those of another law; in an "
        "existing file only the values of the gains change.",
        "workbench gains export vehicle.params --for px4 --model f450.urdf.xacro --gains px4.yaml",
        _export,
    )
    write.add_argument("file", type=Path, metavar="FILE", help="file of parameters to write")
    write.add_argument(
        "--for",
        dest="firmware",
        choices=firmwares,
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
    from workbench.control.controller_file import load_controller
    from workbench.gains.formats import VERSION_ROW, joined_names
    from workbench.gains.gain_change import diff_gains

    check_gain_file_name(args.save)
    law = load_controller(args.controller) if args.controller else None
    if not args.firmware and holds_gains(args.file):
        return _import_gain_file(args, law)
    found = _from_log(args, law) or _from_file(args, law)
    target = None if law is found.law else law
    later = _settings_of(args, found.law, target)
    scenario, vehicle, present = _flown(args, found.law)
    flown = found.flown(present)
    changes = diff_gains({name: present[name] for name in flown}, flown, present, found.law)
    shown = found.values.keys() & {row.name for row in found.firmware.rows(found.law)}
    changes = [row for row in changes if row.name in shown or row.a != row.b]
    changes = [row for row in changes if row.name != VERSION_ROW]
    after = {**present, **flown}
    margins = _margins(args, scenario, present, after)
    remarks = [*found.remarks, *found.remarks_on(vehicle)]
    about = {
        "file": args.file,
        "firmware": found.firmware.name,
        "version": found.version,
        "controller": found.law.name,
        "vehicle": vehicle.name,
    }
    if found.unsafe:
        print_exchange(args, about, changes, margins, remarks, found, None)
        wrong = [f"{found.firmware.file_name(n)} {why}" for n, why in found.unsafe.items()]
        raise WorkbenchError(f"{args.file}: {joined_names(wrong, 4)}; nothing is imported")
    origin = f"{args.file.name}, {found.source}"
    translated = translated_gains(scenario, after, target, later) if target else None
    if args.save and translated:
        translated.save(args.save, origin)
    elif args.save:
        save_gain_values(args.save, vehicle, after, origin, found.law)
    print_exchange(args, about, changes, margins, remarks, found, translated)
    return ExitCode.DONE


def _import_gain_file(args: argparse.Namespace, target: "Controller | None") -> int:
    """Translate the gains of a gain file to another law, and save them if requested."""
    from workbench.control.controller_file import load_controller
    from workbench.gains.gains import owner_of

    if args.gains:
        raise WorkbenchError(f"the gains are those in {args.file}: leave --gains out")
    if args.version or args.profile is not None or args.log_number is not None:
        left_out = "--firmware, --profile and --log-number"
        raise WorkbenchError(f"{args.file}: is a gain file: leave {left_out} out")
    args.gains = str(args.file)
    law = load_controller(owner_of(args.file))
    if target is None or target.name == law.name:
        raise WorkbenchError(
            f"{args.file}: is a gain file of {law.name} already: name the law to translate it to, "
            "as --controller px4"
        )
    later = _settings_of(args, law, target)
    scenario, vehicle, values = _flown(args, law)
    translated = translated_gains(scenario, values, target, later)
    if args.save:
        translated.save(args.save)
    result = {"file": args.file, "controller": target.name, "vehicle": vehicle.name}
    result |= {"translation": translated.result()}
    print_result(args, result, translated.show, files=[args.save] if args.save else [])
    return ExitCode.DONE


def _from_file(args: argparse.Namespace, law: "Controller | None") -> "ImportedGains":
    """Return the gains in a file of an autopilot, of a law only if that is its firmware's."""
    from workbench.gains.formats import find_firmware, recognised_format

    named = bool(args.firmware)
    firmware = find_firmware(args.firmware) if named else recognised_format(args.file)
    own = _law_of(firmware, law)
    return firmware.read(args.file, args.version, args.profile, own, named=named)


def _law_of(firmware: "GainFormat", law: "Controller | None") -> "Controller | None":
    """Return a law if it is one of a firmware."""
    return law if law and law.unscheduled in firmware.laws else None


def _from_log(args: argparse.Namespace, law: "Controller | None") -> "ImportedGains | None":
    """Return the gains in the parameters of a firmware's log; None for any other file."""
    from workbench.gains.formats import gain_formats
    from workbench.logs.flight_reader import read_flight
    from workbench.logs.readers.log_reader import LOG_HEAD_BYTES, reader_of
    from workbench.logs.readers.packed import read_head

    head = read_head(args.file, LOG_HEAD_BYTES)
    reader = reader_of(args.file, head)
    named = reader.firmware.split() if reader else []
    known = [each for each in gain_formats() if each.name in named]
    if not known:
        if reader is None or reader.takes_mapping:
            if args.log_number is not None:
                raise WorkbenchError(f"{args.file}: is no log: leave --log-number out")
            return None
        raise WorkbenchError(
            f"{args.file}: is a log ({reader.format}), and such logs have no gains: import the "
            "autopilot's file of parameters"
        )
    if args.profile is not None or args.firmware not in ("", *(each.name for each in known)):
        names = " or ".join(each.name for each in known)
        raise WorkbenchError(f"{args.file}: is a log of {names}: leave out --for and --profile")
    with progress_bar(f"reading {args.file.name}") as progress:
        flight = read_flight(args.file, None, progress, args.log_number)
    values = {
        key: float(value)
        for key, value in flight.parameters.items()
        if isinstance(value, int | float)
    }
    firmware = next((each for each in known if each.wrote(flight.firmware)), known[0])
    if args.firmware not in ("", firmware.name):
        raise WorkbenchError(f"{args.file}: is a log of {firmware.name}: leave out --for")
    if not values and firmware.wrote(flight.firmware):
        raise WorkbenchError(
            f"{args.file}: has no parameters: import the autopilot's file of parameters instead"
        )
    stated = re.search(r"\d+\.\d+(\.\d+)?", flight.firmware)
    version = args.version or (stated[0] if stated else "")
    found = firmware.read_log(args.file, flight.firmware, values, version, _law_of(firmware, law))
    for remark in flight.remarks:
        if "parameters changed" in remark or "in the file" in remark:
            print_message(f"{args.file}: {remark}")
    return found


def _export(args: argparse.Namespace) -> int:
    """Compare with the existing file, or the defaults of the firmware, and write."""
    from workbench.common.plain_files import write_in_folder
    from workbench.common.resources import existing_path
    from workbench.gains.formats import export_gains, find_firmware, import_gains
    from workbench.gains.gain_change import diff_gains
    from workbench.gains.parameter_line import ParameterFileRemark

    firmware = find_firmware(args.firmware)
    source, law = _laws_of_export(args, firmware)
    target = law if law is not source else None
    later = _settings_of(args, source, target)
    present = None
    if not args.preview:
        check_writable(args.file)
    if existing_path(str(args.file)):
        present = import_gains(args.file, firmware.name, args.version, args.profile, law)
    scenario, vehicle, values = _flown(args, source)
    translated = translated_gains(scenario, values, target, later) if target else None
    if translated:
        args.controller, scenario, values = law.reference, translated.scenario, translated.values
    made = export_gains(values, law, firmware, args.version, present)
    before = {row.name: made.defaults.get(row.name, row.default) for row in firmware.rows(law)}
    if present:
        before = {name: value for name, value in present.values.items() if firmware.has(name)}
    gains = {name: values[name] for name in before}
    changes = diff_gains(before, gains, values, law)
    margins = _margins(args, scenario, {**values, **before}, values)
    about = {
        "file": args.file,
        "firmware": firmware.name,
        "version": args.version or (present.version if present else made.version),
        "controller": law.name,
        "vehicle": vehicle.name,
    }
    grounded = [ParameterFileRemark(f"would not fly: {each}") for each in made.grounded]
    remarks = [*grounded, *made.remarks]
    print_exchange(args, about, changes, margins, remarks, present, translated, exports=True)
    if made.refusal and not args.force and not args.preview:
        raise WorkbenchError(
            f"{args.file}: {made.refusal}: set them with --set, or insist with --force"
        )
    if not args.preview:
        write_in_folder(args.file, made.data)
        print_written_files([args.file])
    return ExitCode.DONE


def _laws_of_export(
    args: argparse.Namespace, firmware: "GainFormat"
) -> "tuple[Controller, Controller]":
    """Return the law of the gains to export, and that of a firmware to write them for."""
    from workbench.control.controller_file import load_controller
    from workbench.gains.gains import load_gains

    named = load_controller(args.controller) if args.controller else None
    own = _law_of(firmware, named)
    source = named or load_controller(firmware.laws[0])
    if args.gains and (own or not named):
        source = load_controller(load_gains(Path(args.gains)).controller)
        if own and own.unscheduled == source.unscheduled:
            source = own
    return source, own or _law_of(firmware, source) or load_controller(firmware.laws[0])


def _settings_of(
    args: argparse.Namespace, law: "Controller", target: "Controller | None"
) -> dict[str, float]:
    """Take values out of --set that only the law has to which gains are translated."""
    from workbench.design.translate.forms import form_of

    if target is None:
        return {}
    for each in (law, target):  # before any wait
        form_of(each)
    rows = law.table
    later = {name: value for name, value in args.set if name not in rows}
    args.set = [each for each in args.set if each[0] not in later]
    return later


def _flown(
    args: argparse.Namespace, law: "Controller"
) -> tuple["Scenario", "Vehicle", dict[str, float]]:
    """Return scenario, vehicle and all values that the command line names, with a law."""
    args.controller = law.reference
    setup = chosen_setup(args)
    return setup.scenario, setup.vehicle, dict(setup.values)


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
    from workbench.design.linear.operating_point import HOLDING_POINT
    from workbench.design.linear.study import LinearStudy

    with progress_bar("judging the loops before and after") as progress:
        study = LinearStudy(scenario)
        progress(0.5)
        try:
            return [hover_margins(study.sampled(HOLDING_POINT, gains)) for gains in (before, after)]
        except WorkbenchError as error:
            print_message(f"no margins: {error}")
            return []
