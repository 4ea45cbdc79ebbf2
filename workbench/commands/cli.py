"""The console command `workbench`: parse the command line, run one command, report errors.

Imports here are light, so that `--help` is fast; a command imports its dependencies when it runs.
"""

import argparse
import contextlib
import errno
import io
import os
import re
import signal
import sys
from collections.abc import Iterator, Sequence
from importlib import import_module
from types import FrameType
from typing import Any, NoReturn

from workbench.commands import ExitCode
from workbench.commands.printing import plain_output, print_message
from workbench.commands.remark_sentences import remarks_as_sentences
from workbench.common.errors import MAX_ECHO_CHARS, WorkbenchError, unknown_name
from workbench.common.extensions import (
    ExtensionGroup,
    complete_extensions,
    find_extensions,
    load_extension,
)

BAD_INPUT_EXIT = 2
INTERRUPTED_EXIT = 130
"""Exit code of a program ended by Ctrl-C (128 + SIGINT)."""
BROKEN_PIPE_EXIT = 141
"""Exit code for SIGPIPE, such as in `workbench params | head -1`."""
MAY_BE_EMPTY = ("--sensors",)
"""Options whose empty value means none."""
COMMAND_MODULES = {
    "new": "new",
    "inspect": "inspect",
    "frames": "frames",
    "check": "hover.add_hover",
    "reproduce": "paper",
    "lidar-trial": "lidar_trial.add_trial",
    "step": "step",
    "linearize": "linearize",
    "margins": "judge",
    "frequency-response": "linearize.add_frequency_response",
    "compare": "compare",
    "record": "regress.add_pin",
    "regress": "regress",
    "sweep": "sweep",
    "tune": "tune",
    "fly": "fly",
    "serve": "serve",
    "tokens": "serve.add_tokens",
    "log": "log",
    "replay": "log.add_replay",
    "plot": "log_plot.add_plot",
    "export": "log.add_export",
    "estimate": "estimate",
    "params": "controllers.add_params",
    "gains": "gains",
    "controllers": "controllers",
    "gui": "gui",
}
"""Location of each command of the core, in the order of the help: its module, and the function that
adds it unless that is `add_parser`. Extensions add others, `ExtensionGroup.COMMANDS`."""
OTHER_NAMES = {"hover": "check", "judge": "margins", "pin": "record"}
"""Names that commands had first, and keep."""
GONE_COMMANDS: dict[tuple[str, ...], str] = {
    ("gains", "translate"): "gains are translated while they are exported or imported: `workbench "
    "gains export FILE --for px4 --controller pd` writes those of pd, or of a gain file with "
    "--gains, as those of px4, and `workbench gains import FILE --controller pid --save GAINS` "
    "makes gains of pid from a gain file or the file of an autopilot",
}
"""What takes the place of a command that is gone."""
TERMINATION_SIGNALS = (signal.SIGTERM, signal.SIGHUP)
"""Other signals to end a program: a system shutdown, a closed terminal."""


class Terminated(KeyboardInterrupt):
    """A signal in `TERMINATION_SIGNALS`: the command ends as with Ctrl-C, without incomplete
    files.
    """

    def __init__(self, number: int) -> None:
        super().__init__(number)
        self.number = number


class Parser(argparse.ArgumentParser):
    """An argument parser with errors of one sentence, like those for all other bad input.

    What begins with a minus and a number is a value, as -1e-3 and -20cm; argparse knows only plain
    numbers.
    """

    def __init__(self, *args: Any, **options: Any) -> None:
        super().__init__(*args, **options)
        self._negative_number_matcher = re.compile(r"-\.?\d|-(inf|nan)$", re.IGNORECASE)

    def error(self, message: str) -> NoReturn:
        raise WorkbenchError(f"{message} (see `{self.prog} --help`)")

    def parse_known_args(self, args: Any = None, namespace: Any = None) -> Any:
        """Refuse what is unknown here: the program's own parser would name its help instead."""
        found, unknown = super().parse_known_args(args, namespace)
        if unknown:
            self.error(self._unknown(unknown[0].partition("=")[0]))
        return found, unknown

    def _unknown(self, word: str) -> str:
        """Return what is wrong with a word that no argument takes."""
        from difflib import get_close_matches

        shown = f"'{word:.{MAX_ECHO_CHARS}}'"
        if not word.startswith("-"):
            return f"{shown} is one argument too many"
        names = [name for action in self._actions for name in action.option_strings]
        near = get_close_matches(word, names, n=1)
        return f"unknown option {shown}" + (f": did you mean '{near[0]}'?" if near else "")

    def _check_value(self, action: argparse.Action, value: str) -> None:
        """Refuse what is not among the choices, with the nearest one."""
        if action.choices is not None and value not in action.choices:
            what = "command" if action.dest == "command" else (action.option_strings or [""])[0]
            raise unknown_name(
                what or str(action.metavar or action.dest).lower(), value, action.choices
            )

    def print_help(self, file: Any = None) -> None:
        """Print the help; unlike argparse's own, an error of the output is raised."""
        print(self.format_help(), end="", file=file, flush=True)


def main(argv: Sequence[str] | None = None) -> int:
    """Run one command.

    Args:
        argv: the command line without the program name; None for that of the process.

    Returns:
        0 done, 1 demands not met, 2 bad input, 130 interrupted, 143 terminated (128 plus the number
        of the signal).
    """
    _open_closed_streams()
    with plain_output():
        try:
            with _endings_as_exceptions():
                args = _parsed(argv)
                with remarks_as_sentences(getattr(args, "verbose", False)), _flying_on(args):
                    code = int(args.run(args))
                sys.stdout.flush()  # so that a closed reader or a full device is noticed here
                return code
        except WorkbenchError as error:
            print_message(" ".join(str(error).split()))
            return BAD_INPUT_EXIT
        except (KeyboardInterrupt, ImportError) as error:
            interrupt = _interrupt(error)
            if interrupt is None:
                raise
            return end_interrupted(interrupt)
        except BrokenPipeError:
            _discard_output()
            return BROKEN_PIPE_EXIT
        except OSError:
            reason = _output_failure()
            if reason is None:
                raise
            _discard_output()
            print_message(
                f"standard output cannot be written: {reason}: redirect it to another place"
            )
            return BAD_INPUT_EXIT


def _open_closed_streams() -> None:
    """Open what the caller closed, as with `<&-`: another file would get its number."""
    sys.stdin = sys.stdin or open(os.devnull, encoding="utf-8")  # noqa: SIM115, PTH123
    sys.stdout = sys.stdout or _Closed()
    sys.stderr = sys.stderr or open(os.devnull, "w", encoding="utf-8")  # noqa: SIM115, PTH123


class _Closed(io.StringIO):
    """Stands for a closed standard output: nothing is lost in silence."""

    def write(self, text: str) -> int:
        raise OSError(errno.EBADF, "it is closed")


def _output_failure() -> str | None:
    """Return why standard output cannot be written, None if it can."""
    try:
        print(flush=True)
    except OSError as error:
        return error.strerror
    return None


def _discard_output() -> None:
    """Let the interpreter, which flushes standard output at its end, discard what is left."""
    with contextlib.suppress(io.UnsupportedOperation):  # it was closed from the beginning
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())


def _parsed(argv: Sequence[str] | None) -> argparse.Namespace:
    """Return the arguments of a command line; its `run` carries out the command."""
    words = sys.argv[1:] if argv is None else argv
    if "_ARGCOMPLETE" in os.environ:  # a shell asks for the candidates at its cursor
        import argcomplete

        argcomplete.autocomplete(_parser(), always_complete_options=False)
    _refuse_empty(words)
    if instead := GONE_COMMANDS.get(tuple(words[:2])):
        raise WorkbenchError(instead)
    parser = _parser(*words[:1])
    args = parser.parse_args(argv)
    if args.says_version:
        args.run = _print_version
    elif args.command is None:
        parser.print_help(sys.stderr)
        args.run = lambda _: BAD_INPUT_EXIT
    return args


@contextlib.contextmanager
def _flying_on(args: argparse.Namespace) -> Iterator[None]:
    """Let this command, and processes that it starts, fly on what is asked for."""
    from workbench.design.flier import FLY_ON_VARIABLE

    before = os.environ.get(FLY_ON_VARIABLE)
    if chosen := getattr(args, "fly_on", None):
        os.environ[FLY_ON_VARIABLE] = chosen
    try:
        yield
    finally:
        if chosen and before is not None:
            os.environ[FLY_ON_VARIABLE] = before
        elif chosen:
            del os.environ[FLY_ON_VARIABLE]


def _refuse_empty(argv: Sequence[str]) -> None:
    """Reject empty words from unset shell variables, such as in `inspect "$MODEL"`.

    Raises:
        WorkbenchError: if a word is empty; as a path it would be the current folder.
    """
    for before, word in zip(("workbench", *argv), argv, strict=False):
        if before in MAY_BE_EMPTY:
            continue
        if not word.strip():
            raise WorkbenchError(f"the text after '{before}' is empty: give a name or a value")
        if word.startswith("--") and word.endswith("=") and word[:-1] not in MAY_BE_EMPTY:
            raise WorkbenchError(f"'{word}' has no value: give it one, or leave it out")


def end_interrupted(interrupt: KeyboardInterrupt) -> int:
    """Report that the command was ended, and return its exit code.

    The notes of the exception say what was written nevertheless.
    """
    what = "terminated" if isinstance(interrupt, Terminated) else "interrupted"
    written = "; ".join(getattr(interrupt, "__notes__", ())) or "nothing was written"
    print_message(f"{what}; {written}")
    return 128 + interrupt.number if isinstance(interrupt, Terminated) else INTERRUPTED_EXIT


def _interrupt(error: BaseException | None) -> KeyboardInterrupt | None:
    """Return the signal behind an error, as the import of a compiled module may wrap it."""
    if error is None or isinstance(error, KeyboardInterrupt):
        return error
    return _interrupt(error.__cause__ or error.__context__)


@contextlib.contextmanager
def _endings_as_exceptions() -> Iterator[None]:
    """Turn SIGTERM and SIGHUP into exceptions, as for Ctrl-C, unless `nohup` ignores them.

    Only the main thread receives signals.
    """
    import threading

    if threading.current_thread() is not threading.main_thread():
        yield
        return
    heard = [each for each in TERMINATION_SIGNALS if signal.getsignal(each) is signal.SIG_DFL]
    for each in heard:
        signal.signal(each, _terminate)
    try:
        yield
    finally:
        for each in heard:
            signal.signal(each, signal.SIG_DFL)


def _terminate(number: int, frame: FrameType | None) -> NoReturn:
    raise Terminated(number)


def _parser(*only: str) -> argparse.ArgumentParser:
    """Return the parser of all commands, or only of named ones if they exist.

    Loading all takes longer than the options of most single commands.
    """
    parser = Parser(
        prog="workbench",
        description="Design a multirotor and its controller on Drake.",
        epilog="example:\n  workbench fly hover\n\nAll commands but gui print JSON with "
        "--json; serve and gateway print one object a line.\nexit codes: 0 "
        "success, 1 a requirement is not met or the flight was lost, 2 bad input",
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    parser.add_argument(
        "--version", action="store_true", dest="says_version", help="print the version and stop"
    )
    commands = parser.add_subparsers(dest="command", title="commands", metavar="COMMAND")
    for name in _names(only):
        if name in COMMAND_MODULES:
            module, _, add = COMMAND_MODULES[name].partition(".")
            getattr(import_module(f"workbench.commands.{module}"), add or "add_parser")(commands)
            continue
        try:
            load_extension(ExtensionGroup.COMMANDS, name)(commands)
        except WorkbenchError as error:
            if name in only:
                raise
            print_message(str(error))  # the list has the others
    return parser


def _names(only: Sequence[str]) -> list[str]:
    """Return the commands of this name, or all that can be loaded if there is none of it."""
    only = [OTHER_NAMES.get(name, name) for name in only]
    if wanted := [name for name in COMMAND_MODULES if name in only]:
        return wanted
    extensions = find_extensions(ExtensionGroup.COMMANDS)  # no command of the core looks for them
    if wanted := [name for name in extensions if name in only]:
        return wanted
    complete = complete_extensions(ExtensionGroup.COMMANDS)
    return [*COMMAND_MODULES, *(name for name in complete if name not in COMMAND_MODULES)]


def _print_version(_: argparse.Namespace) -> int:
    """Print the version; the module with it is slow to load."""
    from importlib import metadata

    try:
        version = metadata.version("drake-drone-workbench")
    except metadata.PackageNotFoundError:
        version = "(not installed: run from its sources)"
    print(f"workbench {version}")
    return ExitCode.DONE
