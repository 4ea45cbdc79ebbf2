"""Betaflight's command line as a file: what `diff` and `dump` print, presets, and typed lines.

A file is a list of commands, run in order. `set NAME = VALUE` is for the profile or rate profile
that a line `profile N` or `rateprofile N` above it chose, if one of these has the parameter; a dump
ends by choosing again those in use, and these count. `simplified_tuning apply` computes gains and
filters from the sliders (`simplified_tuning.c`), in single precision and cut to whole numbers. A
`diff` has what differs from the defaults of its own version.

A preset of the Configurator begins with fields after `#$`. An option is run if it is CHECKED; an
included file is looked for in the folders above the preset, as the path counts from the folder of
all presets.

Source: Betaflight, cli.c, config/simplified_tuning.c; firmware-presets, README.md.
"""

import re
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from pathlib import Path

from workbench.common.errors import WorkbenchError
from workbench.extras.autopilots.gain_files.parameter_file import (
    FileCommand,
    ParameterEntry,
    ParameterFile,
    lines_of,
    number_in,
    read_parameter_text,
)
from workbench.extras.autopilots.gain_files.simplified_tuning import (
    APPLY_TUNING,
    DISABLE_TUNING,
    SCOPE_SEPARATOR,
)
from workbench.extras.autopilots.gain_files.table import load_table
from workbench.gains.formats import joined_names
from workbench.gains.parameter_line import ParameterFileRemark

SET_LINE_PATTERN = re.compile(
    r"[ \t]*set[ \t]+(\w+)[ \t]*=[ \t]*([^\r\n#]*[^\s#])[ \t]*(?:#.*)?", re.I
)
VERSION_LINE_PATTERN = re.compile(
    r"#[ \t]*([A-Za-z]\w*)[ \t]*/[ \t]*\S.*?[ \t]v?(\d+\.\d+\.\d+\S*)"
)
"""Firmware and version in the line that the command `version` prints."""
_BETAFLIGHT_VERSION_PATTERN = re.compile(
    r"#[ \t]*(?:Betaflight|BTFL)\b(?:.*?[ \t])??v?(\d+\.\d+(?:\.\d+)?[^\s,;)]*)", re.I
)
_PROFILE_LINE_PATTERN = re.compile(
    r"[ \t]*(profile|rateprofile)[ \t]+(\d{1,3})[ \t]*(?:#.*)?", re.I
)
_PRESET_FIELD_PATTERN = re.compile(r"[ \t]*#\$[ \t]*([A-Z_]+)(?:[ \t]+(BEGIN|END))?(.*)")
_INCLUDED_PATH_PATTERN = re.compile(r"presets/[\w ./+-]+\.txt")
_MAX_PRESET_INCLUDES = 50
_MAX_PARENT_FOLDERS = 6
_AIR_MODE_PATTERN = re.compile(r"feature (-?)AIRMODE", re.I)
_AIR_MODE_SWITCH_PATTERN = re.compile(r"aux \d+ 28 \d+ (\d+) (?!\1\b)\d+.*", re.I)
"""A range of a switch for the mode 28; one that begins where it ends is none."""
_CLI_COMMANDS = frozenset(
    "acc_calibration adjrange aux batch beacon beeper bind_rx board_id board_name color defaults "  # noqa: SIM905
    "diff dma dump exit feature get gyroregisters hardware help led manufacturer_id map mcu_id "
    "mixer mmix mode_color motor name osd_info play_sound profile rateprofile resource "
    "rx_spi_info rxfail rxrange save serial servo set signature simplified_tuning smix status "
    "tasks timer version vtx vtx_info vtxtable".split()
)
"""Words that begin a command line of some version."""
_UNCHECKED_OPTION = "of an option that is not checked"


@dataclass
class _CommandLineReader:
    """What was read so far of a file and of those that it includes."""

    path: Path
    entries: list[ParameterEntry] = field(default_factory=list)
    remarks: list[ParameterFileRemark] = field(default_factory=list)
    commands: list[FileCommand] = field(default_factory=list)
    taken: list[str] = field(default_factory=list)
    left: list[str] = field(default_factory=list)
    """Names of options that are not checked."""
    versions: list[str] = field(default_factory=list)
    heads: list[str] = field(default_factory=list)
    chosen: dict[str, str] = field(default_factory=dict)
    """Selected profile and rate profile, by their kind."""
    switches: dict[str, float] = field(default_factory=dict)
    preset: bool = False
    end: int = 0
    at_end: str = ""
    """Profile that is selected there."""
    includes: int = 0
    option: str = ""
    """Name of the option that is not taken around the line."""

    def read(self, text: str, line: int = 0) -> None:
        """Read a text; `line` is that of the including line, 0 for the file itself."""
        for number, start, each in lines_of(text):
            self._line(each, line or number, -1 if line else start)
            if not line and each.strip().casefold() == APPLY_TUNING:
                self._ends(start + len(each))

    def _line(self, line: str, number: int, start: int) -> None:
        bare = line.lstrip("\ufeff \t")
        if bare.startswith("#$"):
            self._field(bare, number, start)
        elif not bare or bare.startswith("#"):
            self._comment(bare)
        elif self.option:
            self.commands.append(FileCommand(number, " ".join(bare.split()), _UNCHECKED_OPTION))
        elif match := _PROFILE_LINE_PATTERN.fullmatch(line):
            kind = match[1].casefold()
            self.chosen[kind] = f"{kind} {int(match[2])}"
            self.commands.append(FileCommand(number, self.chosen[kind], ""))
        elif match := SET_LINE_PATTERN.fullmatch(line):
            name, value = match.groups()
            at = start + match.start(2) if start >= 0 else -1
            scope = SCOPE_SEPARATOR.join(self.chosen.values())
            self.entries.append(
                ParameterEntry(name.casefold(), number_in(value), value, at, number, scope, True)
            )
        else:
            command = " ".join(bare.split())
            if command.casefold() in (APPLY_TUNING, DISABLE_TUNING):
                self.entries.append(ParameterEntry(command.casefold(), None, "", -1, number))
                self.commands.append(FileCommand(number, command, ""))
            elif match := _AIR_MODE_PATTERN.fullmatch(command):
                self.switches["airmode"] = 0.0 if match[1] else 1.0
                self.commands.append(FileCommand(number, command, ""))
            elif command.partition(" ")[0].casefold() in _CLI_COMMANDS:
                self.commands.append(FileCommand(number, command))
            else:
                self.commands.append(FileCommand(number, command, "is no command", False))

    def _comment(self, bare: str) -> None:
        if found := _BETAFLIGHT_VERSION_PATTERN.match(bare):
            self.heads.append(found[1])

    def _field(self, bare: str, number: int, start: int) -> None:
        """Read a field of a preset."""
        self.preset = True
        match = _PRESET_FIELD_PATTERN.match(bare)
        if match is None:
            return
        name, part, rest = match[1], match[2], match[3].strip(" \t:")
        if name == "FIRMWARE_VERSION" and start >= 0:
            self.versions.append(rest)
        elif name == "OPTION" and part == "BEGIN":
            title = rest.partition(":")[2].strip() or rest
            if re.match(r"\(\s*CHECKED\s*\)", rest):
                self.taken.append(title)
            else:
                self.option = title
                self.left.append(title)
        elif name == "OPTION" and part == "END":
            self.option = ""
        elif name == "INCLUDE" and not self.option:
            self._include(rest, number)
            if start >= 0:
                self._ends(start + len(bare))

    def _ends(self, position: int) -> None:
        """Keep the position behind a command that computes or includes values."""
        self.end, self.at_end = position, self.chosen.get("profile", "")

    def _include(self, name: str, number: int) -> None:
        self.includes += 1
        if self.includes > _MAX_PRESET_INCLUDES:
            raise WorkbenchError(
                f"{self.path}:{number}: includes more than {_MAX_PRESET_INCLUDES} files: paste the "
                "commands that it is to have"
            )
        found = _beside(self.path, name)
        if found is None:
            raise WorkbenchError(
                f"{self.path}:{number}: includes {name}, which is not there: keep the preset "
                "inside the folder of all presets, or paste the commands that the Configurator "
                "shows"
            )
        self.read(read_parameter_text(found), number)


def _beside(path: Path, name: str) -> Path | None:
    """Return an included file, looked for in the folders above the preset."""
    if not _INCLUDED_PATH_PATTERN.fullmatch(name) or ".." in name:
        return None
    for folder in list(path.resolve().parents)[:_MAX_PARENT_FOLDERS]:
        found = folder / name
        if found.is_file() and found.resolve().is_relative_to(folder):
            return found
    return None


def read_command_line(path: Path, text: str, profile: int | None = None) -> ParameterFile:
    """Read the file; `with_computed_values` then runs the commands that compute values.

    Args:
        path: the file.
        text: of it.
        profile: the one with the gains; by default the one selected last.

    Raises:
        WorkbenchError: if it includes a file that is not there.
    """
    reader = _CommandLineReader(path)
    reader.read(text)
    if profile is not None:
        reader.chosen["profile"] = f"profile {profile}"
    remarks = [*reader.remarks, *_of_options(reader), *_of_lines(reader)]
    versions = reader.heads[:1] or sorted(
        (each for each in reader.versions if each), key=load_table("betaflight").place
    )
    if len(versions) > 1:
        listed = ", ".join(versions)
        remarks.append(
            ParameterFileRemark(f"is for {listed}: read as for {versions[-1]}, --firmware decides")
        )
    return ParameterFile(
        path,
        text,
        tuple(reader.entries),
        versions[-1] if versions else "",
        tuple(reader.chosen.values()),
        tuple(remarks),
        reader.preset,
        tuple(reader.commands),
        reader.switches,
        reader.end,
        reader.at_end,
    )


def _of_options(reader: _CommandLineReader) -> Iterator[ParameterFileRemark]:
    """Yield remarks on the options of a preset."""
    if reader.preset:
        yield ParameterFileRemark("is a preset: what it does not set stays as the model has it")
    if reader.taken:
        yield ParameterFileRemark(
            f"options that are checked: {'; '.join(reader.taken)}", 0, len(reader.taken)
        )
    if reader.left:
        yield ParameterFileRemark(
            f"options that are not checked, and not taken: "
            f"{'; '.join(dict.fromkeys(reader.left))}; to take one, write (CHECKED) in its line",
            0,
            sum(each.left == _UNCHECKED_OPTION for each in reader.commands),
        )


def _of_lines(reader: _CommandLineReader) -> Iterator[ParameterFileRemark]:
    """Yield remarks on lines that are no commands, and on those that change the law."""
    strange = [each for each in reader.commands if not each.known]
    if strange:
        listed = joined_names([f"'{each.text[:40]}'" for each in strange], 3)
        yield ParameterFileRemark(
            f"lines that are no commands: {listed}", strange[0].line, len(strange)
        )
    for each in reader.commands:
        number, command = each.line, each.text
        if each.left == _UNCHECKED_OPTION:
            continue
        word, _, rest = command.partition(" ")
        mixes = word.casefold() == "mmix" and rest != "reset"
        if mixes or (word.casefold() == "mixer" and rest not in _STANDARD_MIXERS):
            yield ParameterFileRemark(
                f"'{command[:40]}' is not flown: the mixer follows from the model's rotors", number
            )
        if not reader.switches.get("airmode", 1.0) and _AIR_MODE_SWITCH_PATTERN.fullmatch(command):
            yield ParameterFileRemark(
                "air mode is on a switch: flown without, --set airmode=1 for with", number
            )


_STANDARD_MIXERS = ("QUADX", "HEX6X", "OCTOFLATX", "HEX6", "OCTOFLATP", "QUADP", "list")


def betaflight_value(entry: ParameterEntry, value: float) -> str:
    """Return the text of a value in its line."""
    return str(round(value))


def set_lines(file: ParameterFile, texts: Mapping[str, str]) -> str:
    """Return lines for a file in which a command computes these values otherwise."""
    lines = [DISABLE_TUNING, *(f"set {name} = {text}" for name, text in sorted(texts.items()))]
    counted = next((each for each in file.scopes if each.startswith("profile")), "")
    if counted != file.at_end:
        lines = [counted, *lines, file.at_end or "profile 0"]
    end = "\r\n" if "\r\n" in file.text else "\n"
    return "".join(f"{end}{line}" for line in lines)


def new_betaflight_file(values: Mapping[str, float], version: str) -> str:
    """Return lines to paste into the command line."""
    table = load_table("betaflight")
    names = table.names(table.release(version)[0])
    lines = [f"# Betaflight {version}\n", "\n", "batch start\n", "\n", "profile 0\n", "\n"]
    lines += [f"set {name} = {names[name].text(values[name])}\n" for name in sorted(values)]
    return "".join([*lines, "\n", "save\n"])
