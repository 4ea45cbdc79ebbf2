"""Control laws and live parameters: `workbench controllers` and `params`."""

import argparse
import ast
import dataclasses
import textwrap
from functools import partial
from typing import TYPE_CHECKING, Any

from workbench.commands import ExitCode
from workbench.commands.chosen_vehicle import chosen_setup
from workbench.commands.options import (
    Subcommands,
    add_command,
    add_json_option,
    add_vehicle_options,
)
from workbench.commands.printing import pick, print_result, print_table

if TYPE_CHECKING:
    from workbench.control.controller import Controller

_PARAMETER_COLUMNS = ("name", "value", "unit", "min", "max", "default", "help")


def add_parser(commands: Subcommands) -> None:
    """Add the command."""
    parser = add_command(
        commands,
        "controllers",
        "List the shipped control laws; or show one, or a file of your own: its parameters, "
        "memory, loops and loop points.",
        "workbench controllers pid\n  workbench controllers my_law.py",
        run,
    )
    parser.add_argument(
        "controller", nargs="?", metavar="NAME|FILE", help="to show (default: list all)"
    )
    add_json_option(parser)


def run(args: argparse.Namespace) -> int:
    """Print the list, or one controller."""
    from workbench.control.controller_file import load_controller
    from workbench.control.installed_laws import known_laws

    if args.controller:
        law = load_controller(args.controller)
        print_result(args, _stated(law), _show, law)
        return ExitCode.DONE
    laws = [load_controller(name) for name in known_laws()]
    rows = [("name", "parameters", "memory", "loops", "what it is")]
    rows += [
        (law.name, str(_own(law)), str(len(law.memory)), str(len(law.loops)), _sentence(law))
        for law in laws
    ]
    result = {"controllers": [_stated(law) for law in laws]}
    print_result(args, result, partial(print_table, rows, left=(0, 4)))
    return ExitCode.DONE


def _own(law: "Controller") -> int:
    """Return the number of its own parameters."""
    from workbench.control.controller import COMMON_PARAMETERS

    return len(law.parameters) - len(COMMON_PARAMETERS)


def _sentence(law: "Controller") -> str:
    """Return the first line of its docstring."""
    text = ast.get_docstring(ast.parse(law.text)) or ""
    return text.partition("\n")[0]


def _attitudes(law: "Controller") -> str:
    """Return what its docstring says of the attitudes that it recovers from, "" for nothing."""
    text = ast.get_docstring(ast.parse(law.text)) or ""
    found = (each for each in text.split("\n\n") if each.startswith("Attitudes: "))
    return " ".join(next(found, "").removeprefix("Attitudes: ").split())


def _stated(law: "Controller") -> dict[str, Any]:
    """Return its statements for JSON."""
    return {
        "name": law.name,
        "file": law.file,
        "sha256": law.digest,
        "what": _sentence(law),
        "attitudes": _attitudes(law),
        "parameters": [
            pick(row, "name unit default group help") | {"min": row.minimum, "max": row.maximum}
            for row in law.parameters
        ],
        "designed": law.designed,
        "memory": law.memory,
        "loops": [
            {**dataclasses.asdict(loop), "actuator": loop.point("actuator")} for loop in law.loops
        ],
        "points": dict(law.points),
        "has_rule": law.rule is not None,
    }


def _show(law: "Controller") -> None:
    """Print all its statements."""
    print(f"{law.name}: {_sentence(law) or '(no docstring)'}\n{law.file}\n")
    if attitudes := _attitudes(law):
        print(textwrap.fill(f"attitudes: {attitudes}", 100) + "\n")
    rows = [("parameter", "unit", "min", "max", "default", "help")]
    rows += [
        (row.name, row.unit, f"{row.minimum:g}", f"{row.maximum:g}", f"{row.default:g}", row.help)
        for row in law.parameters
    ]
    print_table(rows, left=(0, 1, 5))
    if law.program:
        print("a separate program: not compiled, no linear model, and no two equal flights")
    elif not law.compiles:
        how = (
            "exactly"
            if law.derivatives == "AutoDiff"
            else "by differences, because it has no AutoDiff"
        )
        print(f"a Drake system: it is not compiled, and linear models differentiate it {how}")
    if law.rule is None:
        print("no rule: every vehicle without a gain file flies with these defaults")
    if law.designed:
        print(f"designed from them: {', '.join(law.designed)}")
    _table(
        "memory",
        ("state", "unit", "initial"),
        [(state.name, state.unit, f"{state.initial:g}") for state in law.memory],
    )
    _table(
        "loops",
        ("loop", "error", "actuator", "closed", "step", "gains"),
        [
            (
                loop.name,
                loop.error,
                loop.point("actuator"),
                "while the position is held" if loop.hold else "always",
                loop.axis or "-",
                ", ".join(loop.gains) or "-",
            )
            for loop in law.loops
        ],
    )
    _table("loop points", ("point", "unit"), list(law.points.items()))


def _table(what: str, head: tuple[str, ...], rows: list[tuple[str, ...]]) -> None:
    """Print a table after an empty line, or that it is empty."""
    print()
    if not rows:
        print(f"no {what}")
        return
    print_table([head, *rows], left=range(len(head)))


def add_params(commands: Subcommands) -> None:
    """Add the command."""
    parser = add_command(
        commands,
        "params",
        "List every live parameter with its value for a model, its unit, its limits and its use.",
        "workbench params --model dh_drone",
        run_params,
    )
    add_vehicle_options(parser)
    add_json_option(parser)


def run_params(args: argparse.Namespace) -> int:
    """Print the table."""
    from workbench.parameters.parameter_table import vehicle_parameters

    setup = chosen_setup(args)
    values = setup.values
    rows = [
        (row.name, values[row.name], row.unit, row.minimum, row.maximum, row.default, row.help)
        for row in vehicle_parameters(setup.vehicle, setup.table)
    ]
    texts = [[f"{x:g}" if isinstance(x, float) else x for x in row] for row in rows]
    result = {"parameters": [dict(zip(_PARAMETER_COLUMNS, row, strict=True)) for row in rows]}
    print_result(args, result, partial(print_table, [_PARAMETER_COLUMNS, *texts], left=(0, 2, 6)))
    return ExitCode.DONE
