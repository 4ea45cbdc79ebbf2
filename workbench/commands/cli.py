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
from typing import TYPE_CHECKING, Any, NoReturn

from workbench.commands import ExitCode
from workbench.commands.printing import plain_output, say
from workbench.common.errors import LONGEST_ECHO, WorkbenchError, unknown_name

if TYPE_CHECKING:
    import logging

BAD_INPUT = 2
INTERRUPTED = 130
"""Exit code of a program ended by Ctrl-C (128 + SIGINT)."""
READER_GONE = 141
"""Exit code for SIGPIPE, such as in `workbench params | head -1`."""
MAY_BE_EMPTY = ("--sensors",)
"""Options whose empty value means none."""
AGAIN = 2.0
"""Time after which unchanged progress is reported again [s]."""
COMMANDS = {
    "new": "new",
    "inspect": "inspect",
    "frames": "frames",
    "hover": "step.add_hover",
    "reproduce": "paper",
    "lidar-trial": "paper.add_trial",
    "step": "step",
    "linearize": "linearize",
    "judge": "judge",
    "frequency-response": "linearize.add_frequency_response",
    "compare": "compare",
    "pin": "regress.add_pin",
    "regress": "regress",
    "sweep": "sweep",
    "tune": "tune",
    "fly": "fly",
    "serve": "serve",
    "sitl": "sitl",
    "monitor": "gateway.add_monitor",
    "gateway": "gateway",
    "tokens": "serve.add_tokens",
    "log": "log",
    "identify": "identify",
    "import": "log.add_import",
    "replay": "log.add_replay",
    "plot": "log.add_plot",
    "export": "log.add_export",
    "estimate": "estimate",
    "excite": "identify.add_excite",
    "predict": "predict",
    "what-if": "predict.add_what_if",
    "params": "controllers.add_params",
    "gains": "gains",
    "controllers": "controllers",
    "graph": "graph",
    "gui": "gui",
    "completion": "completion",
}
"""Location of each command, in the order of the help: its module, and the function that adds it
unless that is `add_parser`."""
ENDING = (signal.SIGTERM, signal.SIGHUP)
"""Other signals to end a program: a system shutdown, a closed terminal."""


class Terminated(KeyboardInterrupt):
    """A signal in `ENDING`: the command ends as with Ctrl-C, without incomplete files."""

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

        shown = f"'{word:.{LONGEST_ECHO}}'"
        if not word.startswith("-"):
            return f"{shown} is one argument too many"
        names = [name for action in self._actions for name in action.option_strings]
        near = get_close_matches(word, names, n=1)
        return f"unknown option {shown}" + (f": did you mean '{near[0]}'?" if near else "")

    def _check_value(self, action: argparse.Action, value: Any) -> None:
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
        return _end_in_sentences(argv)


def _end_in_sentences(argv: Sequence[str] | None) -> int:
    """Run one command, and return its exit code; errors become sentences."""
    try:
        with _endings_as_exceptions():
            code = _run(argv)
            sys.stdout.flush()  # so that a closed reader or a full device is noticed here
            return code
    except WorkbenchError as error:
        say(" ".join(str(error).split()))
        return BAD_INPUT
    except (KeyboardInterrupt, ImportError) as error:
        interrupt = _interrupt(error)
        if interrupt is None:
            raise
        return end_interrupted(interrupt)
    except BrokenPipeError:
        _discard_output()
        return READER_GONE
    except OSError:
        reason = _output_failure()
        if reason is None:
            raise
        _discard_output()
        say(f"standard output cannot be written: {reason}: redirect it to another place")
        return BAD_INPUT


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


def _run(argv: Sequence[str] | None) -> int:
    """Run one command and return its exit code."""
    words = sys.argv[1:] if argv is None else argv
    if "_ARGCOMPLETE" in os.environ:  # a shell asks for the candidates at its cursor
        from workbench.commands.completion import complete

        complete(_parser)
    _refuse_empty(words)
    parser = _parser(*words[:1])
    args = parser.parse_args(argv)
    if args.says_version:
        print(f"workbench {_version()}")
        return ExitCode.DONE
    if args.command is None:
        parser.print_help(sys.stderr)
        return BAD_INPUT
    with _remarks_as_sentences(getattr(args, "verbose", False)), _flying_on(args):
        return int(args.run(args))


@contextlib.contextmanager
def _flying_on(args: argparse.Namespace) -> Iterator[None]:
    """Let this command, and processes that it starts, fly on what is asked for."""
    from workbench.design.flier import VARIABLE

    before = os.environ.get(VARIABLE)
    if chosen := getattr(args, "fly_on", None):
        os.environ[VARIABLE] = chosen
    try:
        yield
    finally:
        if chosen and before is not None:
            os.environ[VARIABLE] = before
        elif chosen:
            del os.environ[VARIABLE]


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
    """Report that the command was ended, and return its exit code."""
    what = "terminated" if isinstance(interrupt, Terminated) else "interrupted"
    say(f"{what}; nothing was written")
    return 128 + interrupt.number if isinstance(interrupt, Terminated) else INTERRUPTED


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
    heard = [each for each in ENDING if signal.getsignal(each) is signal.SIG_DFL]
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
        epilog="example:\n  workbench fly hover\n\nAll commands but gui and completion print JSON "
        "with --json; serve, monitor and gateway print one object a line.\nexit codes: 0 "
        "success, 1 a requirement is not met or the flight was lost, 2 bad input",
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    parser.add_argument(
        "--version", action="store_true", dest="says_version", help="print the version and stop"
    )
    commands = parser.add_subparsers(dest="command", title="commands", metavar="COMMAND")
    for name in [name for name in COMMANDS if name in only] or COMMANDS:
        module, _, add = COMMANDS[name].partition(".")
        getattr(import_module(f"workbench.commands.{module}"), add or "add_parser")(commands)
    return parser


@contextlib.contextmanager
def _remarks_as_sentences(verbose: bool = False) -> Iterator[None]:
    """Print log messages of the workbench in the same form as other output on stderr.

    Args:
        verbose: whether to print those for the curious, too.
    """
    import logging

    from workbench.commands.progress import above_bars

    class Handler(logging.StreamHandler):
        """Prints a sentence above a progress bar, not into it."""

        def emit(self, record: logging.LogRecord) -> None:
            with above_bars():
                super().emit(record)

    logger = logging.getLogger("workbench")
    handler = Handler()
    handler.setFormatter(logging.Formatter("workbench: %(message)s"))
    said: dict[str, tuple[float, float]] = {}
    handler.addFilter(lambda record: _is_new(record, said, sys.stderr.isatty()))
    logger.setLevel(logging.DEBUG if verbose else logging.INFO)
    logger.addHandler(handler)
    logger.propagate = False
    try:
        yield
    finally:
        logger.removeHandler(handler)
        logger.propagate = True
        logger.setLevel(logging.NOTSET)


def _is_new(
    record: "logging.LogRecord", said: dict[str, tuple[float, float]], terminal: bool
) -> bool:
    """Return whether to print a message: a remark only once, as a command may fly several times.

    Progress is reported again even if unchanged, as silence looks like a program that hangs, but
    only once for all processes that wait at a time, and ever less often in a file or a pipe.

    Args:
        record: of the message.
        said: time of the next message that may be printed, and time until that, of each [s].
        terminal: whether it is printed on one.
    """
    from workbench.commands.progress import longer
    from workbench.common.cache import PROGRESS_LOGGER

    message, now = record.getMessage(), record.created
    if getattr(record, "repeated", False) and not terminal:
        message = message.partition(":")[0]
        due, pause = said.get(message, (now, AGAIN))
        pause = longer(pause)
    else:
        due, pause = said.get(message, (now, 0.0))
        pause = AGAIN if record.name == PROGRESS_LOGGER else float("inf")
    if now < due:
        return False
    said[message] = now + pause, pause
    return True


def _version() -> str:
    """Return the version; the module with it is slow to load."""
    from importlib import metadata

    try:
        return metadata.version("drake-drone-workbench")
    except metadata.PackageNotFoundError:
        return "(not installed: run from its sources)"
