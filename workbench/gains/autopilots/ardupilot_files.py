"""ArduPilot's parameters: .param and .parm files, a name and a value a line.

Between them stands a comma or space; comments begin with #, at a line's end, too; numbers may be
hexadecimal. Lines that begin with @ tell the program that reads the file something, as @include,
and are kept. The file has neither types nor a version: names tell which one it is.
"""

import re
from collections.abc import Mapping
from pathlib import Path

from workbench.common.errors import WorkbenchError
from workbench.gains.autopilots.numbers import number_in, shortest
from workbench.gains.autopilots.parameter_file import Entry, ParameterFile, lines_of
from workbench.gains.autopilots.versions import ARDUPILOT

LINE = re.compile(r"[ \t]*([A-Z]\w{0,31})(?:[ \t]*,[ \t]*|[ \t]+)([^\s,#@]+)[ \t]*(?:[#@].*)?")
SI = {each.new for each in ARDUPILOT}
"""Names since 4.7."""
OLD = {each.old for each in ARDUPILOT}
"""Names up to 4.6."""


def read_param(path: Path, text: str) -> ParameterFile:
    """Read a .param file.

    Raises:
        WorkbenchError: naming the line that is none.
    """
    entries = []
    remarks = []
    for number, start, line in lines_of(text):
        bare = line.lstrip("\ufeff \t")
        if not bare or bare.startswith("#"):
            continue
        if bare.startswith("@"):
            if bare.startswith("@include"):
                remarks.append(f"line {number} includes another file, which is not read: {bare}")
            continue
        match = LINE.fullmatch(line, len(line) - len(bare))
        if not match:
            raise WorkbenchError(
                f"{path}:{number}: is no line of parameters: expected NAME,VALUE or NAME VALUE"
            )
        name, value = match.groups()
        entries.append(Entry(name, number_in(value), value, start + match.start(2), number))
    names = {each.name for each in entries}
    new, old = not names.isdisjoint(SI), not names.isdisjoint(OLD)
    if new and old:
        remarks.append("has names of 4.6 and of 4.7: each is read as its own version has it")
    version = "4.7" if new else "4.6" if old else ""
    return ParameterFile(path, text, tuple(entries), version, remarks=tuple(remarks))


def written_value(entry: Entry, value: float) -> str:
    """Return a value as its line has it."""
    return shortest(value)


def new_file(values: Mapping[str, float], version: str) -> str:
    """Return the text of a .param file."""
    lines = [f"# ArduCopter {version}\n"]
    return "".join([*lines, *(f"{name},{shortest(values[name])}\n" for name in sorted(values))])
