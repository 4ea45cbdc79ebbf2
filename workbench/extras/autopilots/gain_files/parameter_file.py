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
- Crazyflie: see `crazyflie_file.py`.
"""

import math
import re
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from decimal import Decimal
from pathlib import Path

from workbench.common.errors import WorkbenchError
from workbench.common.plain_files import read_plain
from workbench.extras.autopilots.gain_files.table import load_table
from workbench.gains.formats import single
from workbench.gains.parameter_line import ParameterFileRemark

MAX_PARAMETER_FILE_BYTES = 1_000_000
PARAMETER_FILE_ENCODING, DECODE_ERROR_HANDLER = "utf-8", "surrogateescape"
"""Encoding and error handler; bytes that are not UTF-8 are preserved."""
_LINE_END_PATTERN = re.compile(r"\r\n|\r|\n")
_DECIMAL_OR_NAN_PATTERN = re.compile(
    r"[-+]?(\d+\.?\d*|\.\d+)([eE][-+]?\d+)?|[-+]?(nan|inf(inity)?)", re.I
)
_HEX_PATTERN = re.compile(r"0[xX][0-9a-fA-F]+")
_MAX_NUMBER_CHARS = 60
"""Largest number of characters of a number."""
_MIN_PLAIN_NUMBER, _MAX_PLAIN_NUMBER = 1e-6, 1e9
"""Limits between which numbers are written without an exponent."""
_SINGLE_DIGITS = 9
"""Digits that distinguish every number in single precision from its neighbours."""
MAV_TYPE_INT32, MAV_TYPE_REAL32 = "6", "9"
"""MAV_PARAM_TYPE of the two types in PX4."""
PX4_LINE_PATTERN = re.compile(r"[ \t]*(\d+)[ \t]+(\d+)[ \t]+(\S+)[ \t]+(\S+)[ \t]+(\d+)[ \t]*")
PX4_SCRIPT_LINE_PATTERN = re.compile(
    r"[ \t]*param[ \t]+set(?:-default)?(?:[ \t]+-[a-z])*[ \t]+(\w+)[ \t]+([^\s#;]+)"
)
_QGC_VERSION_PATTERN = re.compile(r"#[ \t]*(?:Version|PX4 Version)[ \t]*:[ \t]*v?(\S+)")
AUTOPILOT_COMPONENT = "1"
_PX4_HEAD = """# Onboard parameters for Vehicle 1
#
# Stack: PX4 Pro
# Vehicle: Multi-Rotor
# Version: {version}
#
# Vehicle-Id Component-Id Name Value Type
"""
ARDUPILOT_LINE_PATTERN = re.compile(
    r"[ \t]*([A-Z]\w{0,31})(?:[ \t]*,[ \t]*|[ \t]+)([^\s,#@]+)[ \t]*(?:[#@].*)?"
)
_ARDUPILOT_VERSION_PATTERN = re.compile(
    r"#.*?\b(?:Ardu)?Copter[ \t]*-?v?(\d+\.\d+(?:\.\d+)?[^\s,;)]*)", re.I
)
_NO_PARAMETER = "sets no parameter that is read"


@dataclass(frozen=True)
class ParameterEntry:
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
class FileCommand:
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
    entries: tuple[ParameterEntry, ...] = field(repr=False)
    version: str = ""
    scopes: tuple[str, ...] = ()
    remarks: tuple[ParameterFileRemark, ...] = ()
    partial: bool = False
    commands: tuple[FileCommand, ...] = field(default=(), repr=False)
    switches: Mapping[str, float] = field(default_factory=dict)
    end: int = 0
    at_end: str = ""

    @property
    def counted(self) -> dict[str, ParameterEntry]:
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


def read_parameter_text(path: Path) -> str:
    """Return the text of a file; `encoded` restores the same bytes.

    Raises:
        WorkbenchError: if the file does not exist, or is too large.
    """
    return read_plain(path, MAX_PARAMETER_FILE_BYTES).decode(
        PARAMETER_FILE_ENCODING, DECODE_ERROR_HANDLER
    )


def encoded(text: str) -> bytes:
    """Return the bytes of a text that `read_parameter_text` returned."""
    return text.encode(PARAMETER_FILE_ENCODING, DECODE_ERROR_HANDLER)


def lines_of(text: str) -> Iterator[tuple[int, int, str]]:
    """Yield number, position and text of each line, for any line ending."""
    start = 0
    number = 1
    for end in _LINE_END_PATTERN.finditer(text):
        yield number, start, text[start : end.start()]
        start, number = end.end(), number + 1
    if start < len(text):
        yield number, start, text[start:]


def number_in(text: str) -> float | None:
    """Return the number in a text, decimal or hexadecimal; None if it is not a number."""
    if len(text) > _MAX_NUMBER_CHARS:
        return None
    if _HEX_PATTERN.fullmatch(text):
        return float(int(text, 16))
    return float(text) if _DECIMAL_OR_NAN_PATTERN.fullmatch(text) else None


def shortest_single(value: float) -> str:
    """Return the shortest text for the same number in single precision."""
    for digits in range(1, _SINGLE_DIGITS):
        text = f"{value:.{digits}g}"
        if single(float(text)) == single(value):
            return _without_exponent(text)
    return _without_exponent(f"{single(value):.{_SINGLE_DIGITS}g}")


def _without_exponent(text: str) -> str:
    """Return a number without an exponent, if that is short enough to read."""
    return (
        f"{Decimal(text):f}" if _MIN_PLAIN_NUMBER <= abs(float(text)) < _MAX_PLAIN_NUMBER else text
    )


def long_single(value: float) -> str:
    """Return a number in single precision with all its digits, as QGroundControl writes it."""
    return f"{single(value):.18g}"


def tidy_single(value: float) -> float:
    """Return a number of single precision as typed, such as 0.15 for 0.150000005960464478."""
    return (
        float(shortest_single(value)) if math.isfinite(value) and single(value) == value else value
    )


def read_qgc_params(path: Path, text: str) -> ParameterFile:
    """Read a .params file of QGroundControl.

    Raises:
        WorkbenchError: with the invalid line.
    """
    entries, version = [], ""
    for number, start, line in lines_of(text):
        bare = line.lstrip("\ufeff \t")
        if not bare or bare.startswith("#"):
            found = _QGC_VERSION_PATTERN.match(bare)
            version = found[1] if found and not version else version
            continue
        match = PX4_LINE_PATTERN.fullmatch(line)
        if not match:
            raise WorkbenchError(
                f"{path}:{number}: is not a line of parameters: expected vehicle, component, name, "
                "value and type, between tabs"
            )
        vehicle, component, name, value, kind = match.groups()
        scope = f"component {component} of vehicle {vehicle}"
        at = start + match.start(4)
        entries.append(
            ParameterEntry(
                name, number_in(value), value, at, number, scope, kind != MAV_TYPE_REAL32
            )
        )
    scopes = list(dict.fromkeys(each.scope for each in entries))
    own = [scope for scope in scopes if scope.split()[1] == AUTOPILOT_COMPONENT] or scopes
    remarks = []
    if len(scopes) > 1:
        said = f"has parameters of {len(scopes)} components: those of {own[0]} count"
        others = [each for each in entries if each.scope != own[0]]
        remarks.append(ParameterFileRemark(said, others[0].line, len(others)))
    return ParameterFile(path, text, tuple(entries), version, tuple(own[:1]), tuple(remarks))


def read_px4_script(path: Path, text: str) -> ParameterFile:
    """Read the parameters set in an airframe script; the rest of it is ignored."""
    entries, commands = [], []
    for number, start, line in lines_of(text):
        match = PX4_SCRIPT_LINE_PATTERN.match(line)
        if match:
            name, value = match.groups()
            at, whole = start + match.start(2), name in integer_parameters()
            entries.append(ParameterEntry(name, number_in(value), value, at, number, whole=whole))
        elif line.strip() and not line.lstrip().startswith("#"):
            commands.append(FileCommand(number, " ".join(line.split()), _NO_PARAMETER))
    return ParameterFile(path, text, tuple(entries), commands=tuple(commands))


def integer_parameters() -> frozenset[str]:
    """Return the parameters that PX4 stores as whole numbers."""
    return frozenset(each.name for each in load_table("px4").settings if each.whole)


def px4_value(entry: ParameterEntry, value: float) -> str:
    """Return the text of a value in its line."""
    if entry.whole:
        return str(round(value))
    return long_single(value) if entry.scope else f"{value:.9g}"


def new_px4_file(values: Mapping[str, float], version: str) -> str:
    """Return the text of a .params file."""
    lines = [_PX4_HEAD.format(version=version)]
    for name in sorted(values):
        whole = name in integer_parameters()
        text = str(round(values[name])) if whole else long_single(values[name])
        kind = MAV_TYPE_INT32 if whole else MAV_TYPE_REAL32
        lines.append(f"1\t{AUTOPILOT_COMPONENT}\t{name}\t{text}\t{kind}\n")
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
            said = _ARDUPILOT_VERSION_PATTERN.match(bare)
            version = said[1] if said and not version and not entries else version
            continue
        if bare.startswith("@"):
            commands.append(FileCommand(number, " ".join(bare.split()), _NO_PARAMETER))
            if bare.startswith("@include"):
                remarks.append(
                    ParameterFileRemark(f"includes another file, which is not read: {bare}", number)
                )
            continue
        match = ARDUPILOT_LINE_PATTERN.fullmatch(line, len(line) - len(bare))
        if not match:
            raise WorkbenchError(
                f"{path}:{number}: is not a line of parameters: expected NAME,VALUE or NAME VALUE"
            )
        name, value = match.groups()
        entries.append(
            ParameterEntry(name, number_in(value), value, start + match.start(2), number)
        )
    said, done = tuple(remarks), tuple(commands)
    return ParameterFile(path, text, tuple(entries), version, remarks=said, commands=done)


def ardupilot_value(entry: ParameterEntry, value: float) -> str:
    """Return the text of a value in its line."""
    return px4_value(entry, value) if entry.scope else shortest_single(value)


def new_ardupilot_file(values: Mapping[str, float], version: str) -> str:
    """Return the text of a .param file."""
    lines = [f"# ArduCopter {version}\n"]
    return "".join(
        [*lines, *(f"{name},{shortest_single(values[name])}\n" for name in sorted(values))]
    )


def file_of(path: Path, values: Mapping[str, float], version: str = "") -> ParameterFile:
    """Return parameters from elsewhere, such as a log, as a file that `imported` takes.

    Args:
        path: where they come from, for messages.
        values: by the names of the firmware.
        version: of the firmware, "" if not known.
    """
    entries = tuple(
        ParameterEntry(name, float(value), f"{value:.9g}", -1, 0) for name, value in values.items()
    )
    return ParameterFile(path, "", entries, version)
