"""Parameter files of autopilots, as texts with replaceable values.

- QGroundControl's .params files, of PX4 and of ArduPilot: a line has vehicle, component, name,
  value and type, between tabs; reals have single precision, written with all their digits. Of
  several components the autopilot's own counts, 1. The head states firmware and version.
- PX4: `param set-default` of airframe scripts, too.
- ArduPilot: .param and .parm files, a name and a value a line, between them a comma or space;
  comments begin with #, at a line's end, too; numbers may be hexadecimal. Lines that begin with @
  tell the program that reads the file something, as @include, and are kept. The file has neither
  types nor, but for a comment at its head, a version: names tell which one it is.
- Betaflight: see `command_line.py`.
- Crazyflie: YAML or JSON, `group.name: value`, and the firmware's version, as the firmware has no
  text file of its own. Read are names with a dot at the top, below `params`, or as groups, and of
  a mapping its `stored_value` or `value`, as the client writes them.
"""

import json
import math
import re
import struct
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from decimal import Decimal
from pathlib import Path
from typing import Any

import yaml

from workbench.common.errors import WorkbenchError
from workbench.common.plain_files import read_plain
from workbench.common.yaml_files import fast_loader, refuse_bombs
from workbench.gains.autopilots.table import load_table

MOST_BYTES = 1_000_000
ENCODING, ERRORS = "utf-8", "surrogateescape"
"""Encoding and error handler; bytes that are not UTF-8 are preserved."""
_LINE_END = re.compile(r"\r\n|\r|\n")
_DECIMAL = re.compile(r"[-+]?(\d+\.?\d*|\.\d+)([eE][-+]?\d+)?|[-+]?(nan|inf(inity)?)", re.I)
_HEX = re.compile(r"0[xX][0-9a-fA-F]+")
_LONGEST = 60
"""Largest number of characters of a number."""
_LEAST, _MOST = 1e-6, 1e9
"""Limits between which numbers are written without an exponent."""
_SINGLE_DIGITS = 9
"""Digits that distinguish every number in single precision from its neighbours."""
INT32, REAL32 = "6", "9"
"""MAV_PARAM_TYPE of the two types in PX4."""
PX4_LINE = re.compile(r"[ \t]*(\d+)[ \t]+(\d+)[ \t]+(\S+)[ \t]+(\S+)[ \t]+(\d+)[ \t]*")
PX4_SCRIPT_LINE = re.compile(
    r"[ \t]*param[ \t]+set(?:-default)?(?:[ \t]+-[a-z])*[ \t]+(\w+)[ \t]+([^\s#;]+)"
)
_QGC_VERSION = re.compile(r"#[ \t]*(?:Version|PX4 Version)[ \t]*:[ \t]*v?(\S+)")
AUTOPILOT = "1"
_PX4_HEAD = """# Onboard parameters for Vehicle 1
#
# Stack: PX4 Pro
# Vehicle: Multi-Rotor
# Version: {version}
#
# Vehicle-Id Component-Id Name Value Type
"""
ARDUPILOT_LINE = re.compile(
    r"[ \t]*([A-Z]\w{0,31})(?:[ \t]*,[ \t]*|[ \t]+)([^\s,#@]+)[ \t]*(?:[#@].*)?"
)
_ARDUPILOT_VERSION = re.compile(
    r"#.*?\b(?:Ardu)?Copter[ \t]*-?v?(\d+\.\d+(?:\.\d+)?[^\s,;)]*)", re.I
)
_NO_PARAMETER = "sets no parameter that is read"
_VERSION_KEYS = ("firmware", "firmware_version")
_VALUE_KEYS = ("stored_value", "value")


@dataclass(frozen=True)
class Remark:
    """One thing that the reader of a file should know.

    Attributes:
        text: a sentence.
        line: the first one concerned, counted from 1; 0 for the whole file.
        count: of lines or parameters concerned.
    """

    text: str
    line: int = 0
    count: int = 1

    def __str__(self) -> str:
        return f"line {self.line}: {self.text}" if self.line else self.text


@dataclass(frozen=True)
class Entry:
    """One value in a file.

    Attributes:
        name: of the parameter, as in the file.
        value: its number; None if it is not a number.
        text: as in the file.
        start: position of the text in the file [characters]; negative if a command of the file
            computes the value, or includes another file that has it.
        line: counted from 1.
        scope: where it applies, if a file has several with a name: "profile 1", "component 1 of
            vehicle 1"; "" for all.
        whole: whether the file states that it is a whole number.
    """

    name: str
    value: float | None
    text: str
    start: int
    line: int
    scope: str = ""
    whole: bool = False


@dataclass(frozen=True)
class Command:
    """A line of a file that is neither a value nor a comment.

    Attributes:
        line: counted from 1.
        text: of the line, with single spaces.
        left: why it is not carried out, a clause; "" if it is.
        known: whether it is a command of some version.
    """

    line: int
    text: str
    left: str = "a command of other parts"
    known: bool = True


@dataclass(frozen=True)
class ParameterFile:
    """The content of a parameter file of an autopilot.

    Attributes:
        path: the file.
        text: all of it.
        entries: its values, in order.
        version: of the firmware, "" if not stated.
        scopes: the selected profiles or component, with entries that count in addition to those for
            all.
        remarks: on the file.
        partial: whether it says itself that it leaves other parameters as they are.
        commands: lines that are neither values nor comments, in order.
        switches: parameters of the law that commands set, by its names.
        end: position behind the last command that computes or includes values [characters].
        at_end: profile that is selected there.
    """

    path: Path
    text: str = field(repr=False)
    entries: tuple[Entry, ...] = field(repr=False)
    version: str = ""
    scopes: tuple[str, ...] = ()
    remarks: tuple[Remark, ...] = ()
    partial: bool = False
    commands: tuple[Command, ...] = field(default=(), repr=False)
    switches: Mapping[str, float] = field(default_factory=dict)
    end: int = 0
    at_end: str = ""

    @property
    def counted(self) -> dict[str, Entry]:
        """Entries that count, by name; the last one of duplicates."""
        return {each.name: each for each in self.entries if each.scope in ("", *self.scopes)}

    def replaced(self, texts: Mapping[str, str], added: str = "") -> str:
        """Return the text of the file with other values; the rest stays the same to the byte.

        Args:
            texts: of values by name; the last line of each in the selected scopes changes.
            added: text behind the last command that computes values.
        """
        counted = self.counted
        found = {
            counted[name].start: (counted[name].start + len(counted[name].text), text)
            for name, text in texts.items()
            if name in counted
        }
        if added:
            found[self.end] = (self.end, added)
        parts, end = [], 0
        for start in sorted(found):
            after, text = found[start]
            parts += [self.text[end:start], text]
            end = after
        return "".join([*parts, self.text[end:]])


def read_text(path: Path) -> str:
    """Return the text of a file; `encoded` restores the same bytes.

    Raises:
        WorkbenchError: if the file does not exist, or is too large.
    """
    return read_plain(path, MOST_BYTES).decode(ENCODING, ERRORS)


def encoded(text: str) -> bytes:
    """Return the bytes of a text that `read_text` returned."""
    return text.encode(ENCODING, ERRORS)


def lines_of(text: str) -> Iterator[tuple[int, int, str]]:
    """Yield number, position and text of each line, for any line ending."""
    start = 0
    number = 1
    for end in _LINE_END.finditer(text):
        yield number, start, text[start : end.start()]
        start, number = end.end(), number + 1
    if start < len(text):
        yield number, start, text[start:]


def joined(names: Sequence[str], most: int = 8) -> str:
    """Return some names, and the number of others."""
    more = f" and {len(names) - most} others" if len(names) > most else ""
    return ", ".join(names[:most]) + more


def number_in(text: str) -> float | None:
    """Return the number in a text, decimal or hexadecimal; None if it is not a number."""
    if len(text) > _LONGEST:
        return None
    if _HEX.fullmatch(text):
        return float(int(text, 16))
    return float(text) if _DECIMAL.fullmatch(text) else None


def single(value: float) -> float:
    """Return a number in single precision; one that is too large is infinite."""
    try:
        return float(struct.unpack("<f", struct.pack("<f", value))[0])
    except OverflowError:
        return math.copysign(math.inf, value)


def shortest(value: float) -> str:
    """Return the shortest text for the same number in single precision."""
    for digits in range(1, _SINGLE_DIGITS):
        text = f"{value:.{digits}g}"
        if single(float(text)) == single(value):
            return _plain(text)
    return _plain(f"{single(value):.{_SINGLE_DIGITS}g}")


def _plain(text: str) -> str:
    """Return a number without an exponent, if that is short enough to read."""
    return f"{Decimal(text):f}" if _LEAST <= abs(float(text)) < _MOST else text


def long_single(value: float) -> str:
    """Return a number in single precision with all its digits, as QGroundControl writes it."""
    return f"{single(value):.18g}"


def tidy(value: float) -> float:
    """Return a number of single precision as typed, such as 0.15 for 0.150000005960464478."""
    return float(shortest(value)) if math.isfinite(value) and single(value) == value else value


def read_qgc_params(path: Path, text: str) -> ParameterFile:
    """Read a .params file of QGroundControl.

    Raises:
        WorkbenchError: with the invalid line.
    """
    entries, version = [], ""
    for number, start, line in lines_of(text):
        bare = line.lstrip("\ufeff \t")
        if not bare or bare.startswith("#"):
            found = _QGC_VERSION.match(bare)
            version = found[1] if found and not version else version
            continue
        match = PX4_LINE.fullmatch(line)
        if not match:
            raise WorkbenchError(
                f"{path}:{number}: is not a line of parameters: expected vehicle, component, name, "
                "value and type, between tabs"
            )
        vehicle, component, name, value, kind = match.groups()
        scope = f"component {component} of vehicle {vehicle}"
        at = start + match.start(4)
        entries.append(Entry(name, number_in(value), value, at, number, scope, kind != REAL32))
    scopes = list(dict.fromkeys(each.scope for each in entries))
    own = [scope for scope in scopes if scope.split()[1] == AUTOPILOT] or scopes
    remarks = []
    if len(scopes) > 1:
        said = f"has parameters of {len(scopes)} components: those of {own[0]} count"
        others = [each for each in entries if each.scope != own[0]]
        remarks.append(Remark(said, others[0].line, len(others)))
    return ParameterFile(path, text, tuple(entries), version, tuple(own[:1]), tuple(remarks))


def read_px4_script(path: Path, text: str) -> ParameterFile:
    """Read the parameters set in an airframe script; the rest of it is ignored."""
    entries, commands = [], []
    for number, start, line in lines_of(text):
        match = PX4_SCRIPT_LINE.match(line)
        if match:
            name, value = match.groups()
            at, whole = start + match.start(2), name in whole_names()
            entries.append(Entry(name, number_in(value), value, at, number, whole=whole))
        elif line.strip() and not line.lstrip().startswith("#"):
            commands.append(Command(number, " ".join(line.split()), _NO_PARAMETER))
    return ParameterFile(path, text, tuple(entries), commands=tuple(commands))


def whole_names() -> frozenset[str]:
    """Return the parameters that PX4 stores as whole numbers."""
    return frozenset(each.name for each in load_table("px4").settings if each.whole)


def px4_value(entry: Entry, value: float) -> str:
    """Return the text of a value in its line."""
    if entry.whole:
        return str(round(value))
    return long_single(value) if entry.scope else f"{value:.9g}"


def new_px4_file(values: Mapping[str, float], version: str) -> str:
    """Return the text of a .params file."""
    lines = [_PX4_HEAD.format(version=version)]
    for name in sorted(values):
        whole = name in whole_names()
        text = str(round(values[name])) if whole else long_single(values[name])
        lines.append(f"1\t{AUTOPILOT}\t{name}\t{text}\t{INT32 if whole else REAL32}\n")
    return "".join(lines)


def read_ardupilot_param(path: Path, text: str) -> ParameterFile:
    """Read a .param file.

    Raises:
        WorkbenchError: with the invalid line.
    """
    entries, version = [], ""
    commands, remarks = [], []
    for number, start, line in lines_of(text):
        bare = line.lstrip("\ufeff \t")
        if not bare or bare.startswith("#"):
            said = _ARDUPILOT_VERSION.match(bare)
            version = said[1] if said and not version and not entries else version
            continue
        if bare.startswith("@"):
            commands.append(Command(number, " ".join(bare.split()), _NO_PARAMETER))
            if bare.startswith("@include"):
                remarks.append(Remark(f"includes another file, which is not read: {bare}", number))
            continue
        match = ARDUPILOT_LINE.fullmatch(line, len(line) - len(bare))
        if not match:
            raise WorkbenchError(
                f"{path}:{number}: is not a line of parameters: expected NAME,VALUE or NAME VALUE"
            )
        name, value = match.groups()
        entries.append(Entry(name, number_in(value), value, start + match.start(2), number))
    said, done = tuple(remarks), tuple(commands)
    return ParameterFile(path, text, tuple(entries), version, remarks=said, commands=done)


def ardupilot_value(entry: Entry, value: float) -> str:
    """Return the text of a value in its line."""
    return px4_value(entry, value) if entry.scope else shortest(value)


def new_ardupilot_file(values: Mapping[str, float], version: str) -> str:
    """Return the text of a .param file."""
    lines = [f"# ArduCopter {version}\n"]
    return "".join([*lines, *(f"{name},{shortest(values[name])}\n" for name in sorted(values))])


def read_crazyflie_parameters(path: Path, text: str) -> ParameterFile:
    """Read a YAML or JSON file of parameters.

    Raises:
        WorkbenchError: if it is neither.
    """
    try:
        refuse_bombs(path, text)
        root = yaml.compose(text, Loader=fast_loader())
    except (yaml.YAMLError, ValueError, UnicodeError) as error:
        mark = getattr(error, "problem_mark", None)
        where = f":{mark.line + 1}" if mark else ""
        said = getattr(error, "problem", None) or "it has characters that are not allowed"
        raise WorkbenchError(f"{path}{where}: is neither YAML nor JSON: {said}") from error
    if not isinstance(root, yaml.MappingNode):
        raise WorkbenchError(f"{path}: expected lines as 'pid_rate.roll_kp: 250'")
    version = ""
    entries = []
    for name, node in _values(root, ""):
        if name in _VERSION_KEYS:
            version = node.value
            continue
        quoted = 1 if node.style in ("'", '"') else 0
        start = node.start_mark.index + quoted
        end = node.end_mark.index - quoted
        written, line = text[start:end], node.start_mark.line + 1
        entries.append(Entry(name, number_in(written), written, start, line))
    return ParameterFile(path, text, tuple(entries), version)


def _values(node: Any, group: str) -> Iterator[tuple[str, Any]]:
    """Yield name and node of every value; groups stand before their names, with a dot."""
    for key, value in node.value:
        if not isinstance(key, yaml.ScalarNode):
            continue
        name = f"{group}.{key.value}" if group else key.value
        if isinstance(value, yaml.ScalarNode):
            yield name, value
        elif isinstance(value, yaml.MappingNode):
            inner = {k.value: v for k, v in value.value if isinstance(k, yaml.ScalarNode)}
            stored = [inner[each] for each in _VALUE_KEYS if each in inner]
            if "." in name and stored and isinstance(stored[0], yaml.ScalarNode):
                yield name, stored[0]
            elif "." not in name:
                yield from _values(value, "" if name in ("params", "parameters") else name)


def crazyflie_value(entry: Entry, value: float) -> str:
    """Return the text of a value in its line."""
    if "." not in entry.text and "e" not in entry.text.lower() and value.is_integer():
        return str(int(value))
    text = shortest(value)
    return text if "." in text or "e" in text else f"{text}.0"


def new_crazyflie_file(values: Mapping[str, float], version: str) -> str:
    """Return the text of a YAML file."""
    lines = [f"firmware: {json.dumps(version)}\n", "params:\n"]
    return "".join([*lines, *(f"  {name}: {shortest(values[name])}\n" for name in values)])
