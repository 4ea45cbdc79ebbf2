"""A file of parameters of an autopilot, as text in which single values can be replaced."""

import re
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path

from workbench.common.plain_files import read_plain

MOST_BYTES = 1_000_000
ENCODING, ERRORS = "utf-8", "surrogateescape"
"""Bytes that are no UTF-8 come through as they are."""
_LINE_END = re.compile(r"\r\n|\r|\n")


@dataclass(frozen=True)
class Entry:
    """One value in a file.

    Attributes:
        name: of the parameter, as the file has it.
        value: its number; None where it is none.
        text: as it stands there.
        start: place of the text in the file [characters].
        line: counted from 1.
        scope: what it is set for, where a file has several of a name: "profile 1", "1 1"; "" for
            all.
        whole: whether the file says that it is a whole number.
    """

    name: str
    value: float | None
    text: str
    start: int
    line: int
    scope: str = ""
    whole: bool = False


@dataclass(frozen=True)
class ParameterFile:
    """What an autopilot's file says.

    Attributes:
        path: the file.
        text: all of it.
        entries: its values, in their order.
        version: of the firmware, as far as the file tells; "" if it does not.
        scope: whose entries count besides those of all: the profile that is chosen, the component.
        remarks: sentences on what is special.
    """

    path: Path
    text: str = field(repr=False)
    entries: tuple[Entry, ...] = field(repr=False)
    version: str = ""
    scope: str = ""
    remarks: tuple[str, ...] = ()

    @property
    def counted(self) -> dict[str, Entry]:
        """Entries that count, by name; of a name that comes twice the last one."""
        return {each.name: each for each in self.entries if each.scope in ("", self.scope)}

    def where(self, entry: Entry) -> str:
        """Return "file:line: " of an entry, for the beginning of a message."""
        return f"{self.path}:{entry.line}: "

    def replaced(self, texts: Mapping[str, str]) -> str:
        """Return the file's text with other values; all else stays as it is, to the byte.

        Args:
            texts: of values by name; those of the scope that counts are replaced.
        """
        parts, end = [], 0
        for entry in self.entries:
            if entry.name in texts and entry.scope in ("", self.scope):
                parts += [self.text[end : entry.start], texts[entry.name]]
                end = entry.start + len(entry.text)
        return "".join([*parts, self.text[end:]])


def read_text(path: Path) -> str:
    """Return a file's text, from which `encoded` makes the same bytes.

    Raises:
        WorkbenchError: if there is no such file, or it is too large.
    """
    return read_plain(path, MOST_BYTES).decode(ENCODING, ERRORS)


def encoded(text: str) -> bytes:
    """Return the bytes of a text that `read_text` returned."""
    return text.encode(ENCODING, ERRORS)


def lines_of(text: str) -> Iterator[tuple[int, int, str]]:
    """Yield number, place and text of each line, whatever ends it."""
    start = 0
    number = 1
    for end in _LINE_END.finditer(text):
        yield number, start, text[start : end.start()]
        start, number = end.end(), number + 1
    if start < len(text):
        yield number, start, text[start:]


def joined(names: Sequence[str], most: int = 8) -> str:
    """Return some names, and how many more there are."""
    more = f" and {len(names) - most} others" if len(names) > most else ""
    return ", ".join(names[:most]) + more
