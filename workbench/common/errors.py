"""The exceptions with messages for users."""

from collections.abc import Iterable, Iterator
from contextlib import contextmanager
from typing import Protocol, TypeVar

from workbench.common.plain_text import plain_name

MAX_ECHO_CHARS = 60
"""Largest number of characters of the user's input repeated in a message."""
MAX_NAME_LIST_CHARS = 800
"""Longest list of known names in a message [characters]."""
MAX_ERROR_CHARS = 4000
"""Longest message [characters]."""


class WorkbenchError(Exception):
    """Bad input, described in one sentence: what, where, and what to do about it.

    Where a message echoes text of a file that is too long to be read, its middle is left out.
    """

    def __init__(self, said: object = "") -> None:
        text = str(said)
        if len(text) > MAX_ERROR_CHARS:
            text = f"{text[: MAX_ERROR_CHARS // 2]} … {text[-MAX_ERROR_CHARS // 4 :]}"
        super().__init__(text)


class FlightBrokenError(WorkbenchError):
    """A flight that could not continue; its recording up to then remains."""


def unknown_name(kind: str, name: str, known: Iterable[str]) -> WorkbenchError:
    """Return the error for a `name` that is not one of the `known` ones, with the nearest one."""
    from difflib import get_close_matches

    names = sorted(plain_name(str(each)) for each in known)
    asked = plain_name(str(name), MAX_ECHO_CHARS)
    plain = {each.casefold(): each for each in reversed(names)}
    near = [plain[each] for each in get_close_matches(asked.casefold(), plain, n=1)]
    hint = f"did you mean '{near[0]}'? " if near else ""
    listed = ", ".join(names)
    if len(listed) > MAX_NAME_LIST_CHARS:
        shown = listed[:MAX_NAME_LIST_CHARS].rpartition(", ")[0]
        listed = f"{shown} and {len(names) - shown.count(', ') - 1} others"
    listed = f"known are {listed}" if listed else "there are none"
    return WorkbenchError(f"unknown {kind} '{asked}': {hint}{listed}")


class NamedRow(Protocol):
    """A row of a table."""

    @property
    def name(self) -> str:
        """Its unique name."""


Row = TypeVar("Row", bound=NamedRow)


def find_named_row(kind: str, name: str, rows: Iterable[Row]) -> Row:
    """Return the row with a name.

    Args:
        kind: of the rows, for the message.
        name: of the row.
        rows: to search.

    Raises:
        WorkbenchError: if there is none; it suggests a similar name.
    """
    known = tuple(rows)
    for row in known:
        if row.name == name:
            return row
    raise unknown_name(kind, name, [row.name for row in known])


@contextmanager
def drake_error_sentences(what: str) -> Iterator[None]:
    """Turn Drake's failures into a sentence; its failed assertions arrive as SystemExit."""
    try:
        yield
    except (RuntimeError, SystemExit) as error:
        raise WorkbenchError(f"{what}: {' '.join(str(error).split())}") from error
