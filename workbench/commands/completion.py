"""`workbench completion`: completion of commands, options and names with the Tab key in a shell.

The script for a shell is short: it calls `workbench completion words` for the candidates at the
cursor, so it need not change when a command changes. Without candidates the shell offers files.
"""

import argparse
from collections.abc import Callable, Iterable, Sequence
from typing import Any

from workbench.commands import ExitCode
from workbench.commands.options import NO_SENSORS, add_command

_SCRIPTS = {
    "bash": r"""
_workbench() {
    local line=${COMP_LINE:0:COMP_POINT} IFS=$' \t\n'
    local -a words
    read -ra words <<< "$line"
    [[ $line == *[[:space:]] ]] && words+=("")
    IFS=$'\n'
    COMPREPLY=($("${words[0]}" completion words "${words[@]:1}" 2>/dev/null))
    [[ ${#COMPREPLY[@]} == 1 && ${COMPREPLY[0]} == *= ]] && compopt -o nospace 2>/dev/null
    return 0
}
complete -o bashdefault -o default -F _workbench workbench
""",
    "zsh": r"""
#compdef workbench
_workbench() {
    local -a found
    found=("${(@f)$("${words[1]}" completion words "${(@)words[2,CURRENT]}" 2>/dev/null)}")
    if [[ -z "${found[*]}" ]]; then
        _files
    elif [[ "${found[1]}" == *= ]]; then
        compadd -S '' -- "${found[@]}"
    else
        compadd -- "${found[@]}"
    fi
}
compdef _workbench workbench
""",
    "fish": r"""
function __workbench_words
    set -l words (commandline -opc) (commandline -ct)
    $words[1] completion words $words[2..-1] 2>/dev/null
end
complete -c workbench -a '(__workbench_words)'
""",
}
_WORDS = "words"


def add_parser(commands: Any) -> None:
    """Add the command."""
    parser = add_command(
        commands,
        "completion",
        "Print a script with which a shell completes commands, options and names by Tab.",
        "source <(workbench completion bash)",
        run,
    )
    parser.add_argument(
        "shell", choices=(*_SCRIPTS, _WORDS), metavar="SHELL", help=", ".join(_SCRIPTS)
    )
    parser.add_argument("words", nargs=argparse.REMAINDER, help=argparse.SUPPRESS)
    parser.set_defaults(whole=commands)


def run(args: argparse.Namespace) -> int:
    """Print a script, or the candidates at the cursor."""
    if args.shell in _SCRIPTS:
        print(_SCRIPTS[args.shell].strip())
        return ExitCode.DONE
    for word in offered(args.whole, args.words or [""]):
        print(word)
    return ExitCode.DONE


def offered(commands: Any, words: Sequence[str]) -> list[str]:
    """Return the candidates for the last word.

    Args:
        commands: argparse's action that has all commands as its choices.
        words: the command line up to the cursor, without the program; the last one is incomplete,
            or "".
    """
    *before, begun = words
    actions: Sequence[argparse.Action] = [commands]
    while True:
        places = [action for action in actions if not action.option_strings]
        awaited = None
        for number, word in enumerate(before):
            if awaited:
                awaited = None
            elif word.startswith("-"):
                awaited = _awaiting(actions, word)
            elif places and isinstance(places[0].choices, dict):
                parser = places[0].choices.get(word)
                if parser is None:
                    return []
                actions, before = parser._actions, before[number + 1 :]
                break
            elif places and places[0].nargs not in ("*", "+"):
                places = places[1:]
        else:
            break
    if awaited:
        found = _values(awaited, begun)
    elif begun.startswith("-"):
        found = [
            name
            for each in actions
            if each.help is not argparse.SUPPRESS
            for name in each.option_strings
        ]
    else:
        found = _values(places[0], begun) if places else []
    return sorted(word for word in found if word.startswith(begun))


def _awaiting(actions: Iterable[argparse.Action], option: str) -> argparse.Action | None:
    """Return the action of an option that takes the next word."""
    return next(
        (each for each in actions if option in each.option_strings and each.nargs != 0), None
    )


def _values(action: argparse.Action, begun: str) -> Iterable[str]:
    """Return the values of an action, if they are names."""
    if action.choices is not None:
        return [str(choice) for choice in action.choices if choice != _WORDS]
    names = _NAMES.get(action.dest)
    if names is None:
        return []
    if action.dest == "sensors":
        given = begun.rpartition(",")[0]
        return [f"{given},{name}" if given else name for name in names()]
    return names()


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
