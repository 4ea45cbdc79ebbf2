"""Output of commands: results on stdout, everything else on stderr."""

import argparse
import contextlib
import dataclasses
import io
import math
import sys
from collections.abc import Callable, Iterator, Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any, TextIO, cast

from workbench.commands import ExitCode
from workbench.common.plain_text import escaped_json, plain_name, plain_text, visible

if TYPE_CHECKING:
    from workbench.common.flight import Flight

MAX_PRINTED_CELL_CHARS = 10_000
"""Largest number of characters that are shown in a message or a cell of a table."""


class PlainOutput:
    """An output stream that shows control characters as escapes, whoever prints them.

    Args:
        stream: the stream itself.
    """

    def __init__(self, stream: TextIO) -> None:
        self.stream = stream

    def write(self, text: str) -> int:
        """Write a text."""
        return self.stream.write(visible(text))

    def __getattr__(self, name: str) -> Any:
        return getattr(self.stream, name)


@contextlib.contextmanager
def plain_output() -> Iterator[None]:
    """Let nothing that is printed control the terminal: names and messages come from outside."""
    for stream in (sys.stdout, sys.stderr):
        if isinstance(stream, io.TextIOWrapper):
            stream.reconfigure(errors="replace")  # m/s² on a terminal limited to ASCII
    out, err = (cast(TextIO, PlainOutput(stream)) for stream in (sys.stdout, sys.stderr))
    with contextlib.redirect_stdout(out), contextlib.redirect_stderr(err):
        yield


def terminal() -> TextIO:
    """Return stderr for what controls the terminal on purpose, as a progress bar does."""
    return sys.stderr.stream if isinstance(sys.stderr, PlainOutput) else sys.stderr


def print_message(sentence: str) -> None:
    """Print a message for the person at the terminal, unless that is closed or full."""
    with contextlib.suppress(OSError):
        print(f"workbench: {plain_text(sentence, MAX_PRINTED_CELL_CHARS)}", file=sys.stderr)


def print_written_files(files: Sequence[Path]) -> None:
    """Print the files written."""
    print_message(f"wrote {', '.join(map(str, files))}")


def print_remarks(flight: "Flight") -> None:
    """Print the remarks on samples of a log that were left out, moved or spread."""
    for remark in flight.remark_details():
        if remark["place"]:
            print_message(f"{flight.source}: {remark['text']}")


def remark_rows(flights: "Sequence[Flight]") -> list[dict[str, Any]]:
    """Return the remarks on logs, with number and place, for JSON."""
    return [
        {"log": flight.source, **remark} for flight in flights for remark in flight.remark_details()
    ]


def lost_replies(exchange: Mapping[str, float]) -> tuple[str, str]:
    """Return the numbers of late and of all packets exchanged with a program that ran the law.

    Args:
        exchange: see `LawProgram.report`.
    """
    return f"{exchange['lost']:.0f}", f"of {exchange['packets']:.0f} packets to the autopilot"


def autopilot_json(exchange: Mapping[str, float], ended: str) -> dict[str, Any]:
    """Return the statistics of a program that ran the law for JSON, or nothing.

    Args:
        exchange: see `LawProgram.report`.
        ended: why it ended in flight, else "".
    """
    return {"exchange": exchange, "autopilot_ended": ended} if exchange else {}


def print_result(
    args: argparse.Namespace,
    result: object,
    show: Callable[..., None] | None = None,
    *shown: Any,
    files: Sequence[Path] | None = None,
) -> None:
    """Print a result, as JSON with --json, and the files written.

    Args:
        args: of the command line.
        result: for JSON.
        show: prints it as text; None if there is nothing to print but the files.
        shown: arguments of `show`.
        files: the written ones, for JSON also if empty; None if the command writes none.
    """
    if args.json:
        print_json(result if files is None else {**_plain(result), "files": files})
    elif show:
        show(*shown)
    if files:
        print_written_files(files)


def report_unmet(missed: Sequence[str]) -> ExitCode:
    """Print the demands that are not met, if any, and return the exit code."""
    if not missed:
        return ExitCode.DONE
    print_message(f"requirements not met: {'; '.join(missed)}")
    return ExitCode.NOT_AS_DEMANDED


def pick(item: object, names: str) -> dict[str, Any]:
    """Return attributes of an object for JSON.

    Args:
        item: the object.
        names: of the attributes, separated by spaces.
    """
    return {name: getattr(item, name) for name in names.split()}


def print_json(data: object) -> None:
    """Print data as strict JSON: dataclasses become objects, and non-finite numbers null."""
    print(to_json(data))


def print_json_line(data: object) -> None:
    """Print data as JSON on one line, without buffering, for commands that continue to run."""
    print(to_json(data, indent=None), flush=True)


def to_json(data: object, indent: int | None = 2) -> str:
    """Return data as JSON text, see `print_json`."""
    import json

    text = json.dumps(_plain(data), indent=indent, allow_nan=False, ensure_ascii=False)
    return escaped_json(text)


def print_table(rows: Sequence[Sequence[str]], *, left: Sequence[int] = (0,)) -> None:
    """Print rows of texts as aligned columns.

    Args:
        rows: all of one length.
        left: columns to align left; the others align right.
    """
    rows = [[plain_name(text, MAX_PRINTED_CELL_CHARS) for text in row] for row in rows]
    widths = [max(map(len, column)) for column in zip(*rows, strict=True)]
    for row in rows:
        cells = [
            text.ljust(width) if index in left else text.rjust(width)
            for index, (text, width) in enumerate(zip(row, widths, strict=True))
        ]
        print("  ".join(cells).rstrip())


def _plain(data: object) -> Any:
    """Return data in JSON types only; a record that has `to_json` says itself what is in there."""
    if hasattr(data, "to_json"):
        return _plain(data.to_json())
    if dataclasses.is_dataclass(data) and not isinstance(data, type):
        return {f.name: _plain(getattr(data, f.name)) for f in dataclasses.fields(data)}
    if isinstance(data, Mapping):
        return {str(key): _plain(value) for key, value in data.items()}
    if isinstance(data, Path):
        return str(data)
    if hasattr(data, "tolist"):  # numpy's arrays and numbers; most commands do not load it
        return _plain(data.tolist())
    if isinstance(data, float):
        return float(data) if math.isfinite(data) else None
    if isinstance(data, Sequence) and not isinstance(data, str):
        return [_plain(item) for item in data]
    return data
