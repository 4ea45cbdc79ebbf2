"""`workbench gains`: show, compare, save and restore gains, and exchange them with autopilots."""

import argparse
from pathlib import Path
from typing import TYPE_CHECKING

from workbench.commands import ExitCode
from workbench.commands.chosen_vehicle import chosen_scenario, flown_with
from workbench.commands.gain_exchange import add_exchange
from workbench.commands.gain_tables import print_gain_changes, print_gain_history, print_gain_values
from workbench.commands.named_gains import (
    DEFAULT_SIDE,
    RULE_SIDE,
    check_gain_file_name,
    gains_of_side,
    names_gain_file,
    names_gain_model,
)
from workbench.commands.options import (
    Subcommands,
    add_command,
    add_controller_option,
    add_json_option,
    add_model_options,
    add_vehicle_options,
)
from workbench.commands.printing import (
    pick,
    print_result,
)
from workbench.common.errors import WorkbenchError

if TYPE_CHECKING:
    from workbench.control.controller import Controller
    from workbench.plant.vehicle import Vehicle


def add_parser(commands: Subcommands) -> None:
    """Add the command and its own commands."""
    parser = add_command(
        commands,
        "gains",
        "Show, compare, save and restore gains; a gain file keeps every state that was saved.",
        "workbench gains diff dh_drone rule",
        _require_action,
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
    help = f"gain file (.yaml), model, '{RULE_SIDE}' (gains that follow from the vehicle) or "
    for side in ("a", "b"):
        diff.add_argument(side, metavar=side.upper(), help=f"{help}'{DEFAULT_SIDE}'")
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


def _require_action(args: argparse.Namespace) -> int:
    """Print the available commands, as none was given."""
    raise WorkbenchError(
        "say what to do: workbench gains show, diff, save, history or restore, and with "
        "autopilots import or export"
    )


def _show(args: argparse.Namespace) -> int:
    """Print a file, or the gains that a model flies with."""
    from workbench.gains.gain_choice import choose_gains, make_profile
    from workbench.gains.gains import load_gains

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
    print_gain_values(args, about, values, origins, law)
    return ExitCode.DONE


def _diff(args: argparse.Namespace) -> int:
    """Print the differences of two sets."""
    from workbench.common.resources import find_file
    from workbench.gains.gain_change import diff_gains
    from workbench.gains.gain_choice import rule_values

    law = _law(args, *(find_file(side) for side in (args.a, args.b) if names_gain_file(side)))
    vehicle = _read_vehicle_of_sides(args, law)
    a, b = gains_of_side(args.a, vehicle, law), gains_of_side(args.b, vehicle, law)
    changes = diff_gains(a, b, rule_values(vehicle, law), law)
    print_gain_changes(args, args.a, args.b, vehicle.name, changes)
    return ExitCode.DONE


def _save(args: argparse.Namespace) -> int:
    """Write the gains that a model flies with."""
    from workbench.gains.gain_choice import flight_gains, make_profile
    from workbench.gains.gains import save_gains

    check_gain_file_name(args.file)
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

    print_gain_history(args, load_gains(args.file, _law(args, args.file)))
    return ExitCode.DONE


def _restore(args: argparse.Namespace) -> int:
    """Save an earlier state of a file again."""
    from workbench.gains.gain_change import diff_gains
    from workbench.gains.gains import gains_at, load_gains, save_gains

    law = _law(args, args.file)
    before = load_gains(args.file, law)
    after = save_gains(args.file, gains_at(before, args.state, law), law)
    changes = diff_gains(before.gains, after.gains, law.table.defaults(), law)
    sides = ("before", f"state {args.state}")
    print_gain_changes(args, *sides, after.vehicle, changes, files=[args.file])
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
    from workbench.control.controller_file import load_controller
    from workbench.control.installed_laws import DEFAULT_CONTROLLER
    from workbench.gains.gains import load_gains

    named = [load_gains(file).controller for file in files if file and not args.controller]
    return load_controller(args.controller or (named[0] if named else DEFAULT_CONTROLLER))


def _read_vehicle(args: argparse.Namespace) -> "Vehicle":
    """Return the vehicle that the command line names."""
    from workbench.scenario.configured import configured_vehicle

    return configured_vehicle(chosen_scenario(args).vehicle)


def _read_vehicle_of_sides(args: argparse.Namespace, law: "Controller") -> "Vehicle":
    """Return the vehicle for the rule in a comparison: that of --model, else that of a side."""
    from workbench.common.resources import find_file, list_models
    from workbench.gains.gains import load_gains

    models = [side for side in (args.a, args.b) if names_gain_model(side)]
    files = [find_file(side) for side in (args.a, args.b) if names_gain_file(side)]
    named = [load_gains(file, law).vehicle for file in files]
    models += [name for name in named if name in list_models()]
    args.model = args.model or (models[0] if models else None)
    return _read_vehicle(args)
