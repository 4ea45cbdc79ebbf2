"""`workbench completion`: completion of commands, options and names with the Tab key in a shell.

argcomplete does it: the script that it makes for a shell starts `workbench` with the command line
in the environment, and shows the candidates that come back. Without candidates the shell offers
files.
"""

import argparse
import os
from collections.abc import Callable, Iterator
from typing import Any

from workbench.commands import ExitCode
from workbench.commands.options import NO_SENSORS, add_command

SHELLS = ("bash", "zsh", "fish")


def add_parser(commands: Any) -> None:
    """Add the command."""
    parser = add_command(
        commands,
        "completion",
        "Print a script with which a shell completes commands, options and names by Tab.",
        "source <(workbench completion bash)",
        run,
    )
    parser.add_argument("shell", choices=SHELLS, metavar="SHELL", help=", ".join(SHELLS))


def run(args: argparse.Namespace) -> int:
    """Print a script."""
    import argcomplete

    print(argcomplete.shellcode(["workbench"], shell=args.shell).strip())
    return ExitCode.DONE


def complete(make_parser: Callable[..., argparse.ArgumentParser]) -> None:
    """Print the candidates at the cursor of a shell that asks for them, and end.

    Args:
        make_parser: returns the parser of all commands, or only of those that are named.
    """
    import argcomplete

    words = os.environ.get("COMP_LINE", "").split(" ")[1:]
    parser = make_parser(*words[:-1][:1])  # the last word is incomplete
    add_names(parser)
    argcomplete.autocomplete(parser, always_complete_options=False)


def add_names(parser: argparse.ArgumentParser) -> None:
    """Add the candidates for values of arguments that are names."""
    for action in _actions_below(parser):
        if names := _NAMES.get(action.dest):
            setattr(action, "completer", _completer(names))  # noqa: B010


def _actions_below(parser: argparse.ArgumentParser) -> Iterator[argparse.Action]:
    """Yield the actions of a parser and of its commands."""
    for action in parser._actions:
        yield action
        if isinstance(action, argparse._SubParsersAction):
            for below in action.choices.values():
                yield from _actions_below(below)


def _completer(names: Callable[[], list[str]]) -> Callable[..., list[str]]:
    """Return what argcomplete calls for the values of an argument: `names`, also in a list."""

    def candidates(prefix: str, **others: object) -> list[str]:
        given = prefix.rpartition(",")[0]
        return [f"{given},{name}" if given else name for name in names()]

    return candidates


def _models() -> list[str]:
    from workbench.common.resources import list_models

    return list_models()


def _controllers() -> list[str]:
    from workbench.control.controller import PROGRAMS, SHIPPED

    return [*SHIPPED, *PROGRAMS]


def _estimators() -> list[str]:
    from workbench.estimation.settings import ESTIMATORS

    return list(ESTIMATORS)


def _sides() -> list[str]:
    return [*_models(), "rule", "default"]


def _scenarios() -> list[str]:
    from workbench.common.resources import list_scenarios

    return list_scenarios()


def _worlds() -> list[str]:
    from workbench.common.resources import list_worlds

    return list_worlds()


def _specs() -> list[str]:
    from workbench.common.resources import list_specs

    return list_specs()


def _parameters() -> list[str]:
    from workbench.scenario.parameters import parameter_table

    return [f"{row.name}=" for row in parameter_table()]


def _variations() -> list[str]:
    import dataclasses

    from workbench.plant.variation import Variation

    return [f"{field.name}=" for field in dataclasses.fields(Variation)]


def _ranges() -> list[str]:
    return [*_parameters(), *(f"vary.{name}" for name in _variations())]


def _sensors() -> list[str]:
    from workbench.scenario.parameters import SENSOR_KINDS

    return [*SENSOR_KINDS, "all", NO_SENSORS]


_NAMES: dict[str, Callable[[], list[str]]] = {
    "a": _sides,
    "b": _sides,
    "controller": _controllers,
    "controllers": _controllers,
    "estimator": _estimators,
    "model": _models,
    "ranges": _ranges,
    "scenario": _scenarios,
    "sensors": _sensors,
    "set": _parameters,
    "specs": _specs,
    "vary": _variations,
    "world": _worlds,
}
"""Names for the values of an argument, by its name in argparse."""
