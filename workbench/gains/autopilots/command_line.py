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
from collections.abc import Callable, Iterable, Iterator, Mapping
from dataclasses import dataclass, field, replace
from pathlib import Path

from workbench.common.errors import WorkbenchError
from workbench.gains.autopilots.parameter_file import (
    Command,
    Entry,
    ParameterFile,
    Remark,
    joined,
    lines_of,
    number_in,
    read_text,
    single,
)
from workbench.gains.autopilots.table import Release, Setting, load_table

SET_LINE = re.compile(r"[ \t]*set[ \t]+(\w+)[ \t]*=[ \t]*([^\r\n#]*[^\s#])[ \t]*(?:#.*)?", re.I)
HEAD = re.compile(r"#[ \t]*([A-Za-z]\w*)[ \t]*/[ \t]*\S.*?[ \t]v?(\d+\.\d+\.\d+\S*)")
"""Firmware and version in the line that the command `version` prints."""
_VERSION = re.compile(
    r"#[ \t]*(?:Betaflight|BTFL)\b(?:.*?[ \t])??v?(\d+\.\d+(?:\.\d+)?[^\s,;)]*)", re.I
)
_PROFILE = re.compile(r"[ \t]*(profile|rateprofile)[ \t]+(\d{1,3})[ \t]*(?:#.*)?", re.I)
_FIELD = re.compile(r"[ \t]*#\$[ \t]*([A-Z_]+)(?:[ \t]+(BEGIN|END))?(.*)")
_INCLUDED = re.compile(r"presets/[\w ./+-]+\.txt")
_APPLY, _DISABLE = "simplified_tuning apply", "simplified_tuning disable"
_MOST_INCLUDES = 50
_MOST_ABOVE = 6
_AIR_MODE = re.compile(r"feature (-?)AIRMODE", re.I)
_AIR_MODE_SWITCH = re.compile(r"aux \d+ 28 \d+ (\d+) (?!\1\b)\d+.*", re.I)
"""A range of a switch for the mode 28; one that begins where it ends is none."""
_COMMANDS = frozenset(
    "acc_calibration adjrange aux batch beacon beeper bind_rx board_id board_name color defaults "  # noqa: SIM905
    "diff dma dump exit feature get gyroregisters hardware help led manufacturer_id map mcu_id "
    "mixer mmix mode_color motor name osd_info play_sound profile rateprofile resource "
    "rx_spi_info rxfail rxrange save serial servo set signature simplified_tuning smix status "
    "tasks timer version vtx vtx_info vtxtable".split()
)
"""Words that begin a command line of some version."""
_BETWEEN = ", "
_UNCHECKED = "of an option that is not checked"
_AXES = ("roll", "pitch", "yaw")
_MODES = {"OFF": 0, "RP": 2, "RPY": 3}
"""Number of axes that the sliders set."""


@dataclass
class _Reader:
    """What was read so far of a file and of those that it includes."""

    path: Path
    entries: list[Entry] = field(default_factory=list)
    remarks: list[Remark] = field(default_factory=list)
    commands: list[Command] = field(default_factory=list)
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
            if not line and each.strip().casefold() == _APPLY:
                self._ends(start + len(each))

    def _line(self, line: str, number: int, start: int) -> None:
        bare = line.lstrip("\ufeff \t")
        if bare.startswith("#$"):
            self._field(bare, number, start)
        elif not bare or bare.startswith("#"):
            self._comment(bare)
        elif self.option:
            self.commands.append(Command(number, " ".join(bare.split()), _UNCHECKED))
        elif match := _PROFILE.fullmatch(line):
            kind = match[1].casefold()
            self.chosen[kind] = f"{kind} {int(match[2])}"
            self.commands.append(Command(number, self.chosen[kind], ""))
        elif match := SET_LINE.fullmatch(line):
            name, value = match.groups()
            at = start + match.start(2) if start >= 0 else -1
            scope = _BETWEEN.join(self.chosen.values())
            self.entries.append(
                Entry(name.casefold(), number_in(value), value, at, number, scope, True)
            )
        else:
            command = " ".join(bare.split())
            if command.casefold() in (_APPLY, _DISABLE):
                self.entries.append(Entry(command.casefold(), None, "", -1, number))
                self.commands.append(Command(number, command, ""))
            elif match := _AIR_MODE.fullmatch(command):
                self.switches["airmode"] = 0.0 if match[1] else 1.0
                self.commands.append(Command(number, command, ""))
            elif _word(command) in _COMMANDS:
                self.commands.append(Command(number, command))
            else:
                self.commands.append(Command(number, command, "is no command", False))

    def _comment(self, bare: str) -> None:
        if found := _VERSION.match(bare):
            self.heads.append(found[1])

    def _field(self, bare: str, number: int, start: int) -> None:
        """Read a field of a preset."""
        self.preset = True
        match = _FIELD.match(bare)
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
        if self.includes > _MOST_INCLUDES:
            raise WorkbenchError(
                f"{self.path}:{number}: includes more than {_MOST_INCLUDES} files: paste the "
                "commands that it is to have"
            )
        found = _beside(self.path, name)
        if found is None:
            raise WorkbenchError(
                f"{self.path}:{number}: includes {name}, which is not there: keep the preset "
                "inside the folder of all presets, or paste the commands that the Configurator "
                "shows"
            )
        self.read(read_text(found), number)


def _beside(path: Path, name: str) -> Path | None:
    """Return an included file, looked for in the folders above the preset."""
    if not _INCLUDED.fullmatch(name) or ".." in name:
        return None
    for folder in list(path.resolve().parents)[:_MOST_ABOVE]:
        found = folder / name
        if found.is_file() and found.resolve().is_relative_to(folder):
            return found
    return None


def read_command_line(path: Path, text: str, profile: int | None = None) -> ParameterFile:
    """Read the file; `settled` then runs the commands that compute values.

    Args:
        path: the file.
        text: of it.
        profile: the one with the gains; by default the one selected last.

    Raises:
        WorkbenchError: if it includes a file that is not there.
    """
    reader = _Reader(path)
    reader.read(text)
    if profile is not None:
        reader.chosen["profile"] = f"profile {profile}"
    remarks = [*reader.remarks, *_of_options(reader), *_of_lines(reader)]
    versions = reader.heads[:1] or sorted(
        (each for each in reader.versions if each), key=load_table("betaflight").place
    )
    if len(versions) > 1:
        listed = ", ".join(versions)
        remarks.append(Remark(f"is for {listed}: read as for {versions[-1]}, --firmware decides"))
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


def _of_profiles(file: ParameterFile) -> Iterator[Remark]:
    """Yield remarks on profiles that do not count."""
    entries = [each for each in file.entries if each.scope.startswith("profile")]
    profiles = list(dict.fromkeys(each.scope for each in entries))
    counted = next((each for each in file.scopes if each.startswith("profile")), "")
    if len(profiles) > 1:
        others = [each for each in entries if each.scope != counted]
        yield Remark(
            f"has {', '.join(profiles)}: {counted} counts, --profile takes another",
            others[0].line,
            len(others),
        )
    if counted and profiles and counted not in profiles:
        yield Remark(
            f"sets nothing in {counted}, but does in {', '.join(profiles)}",
            entries[0].line,
            len(entries),
        )


def _of_options(reader: _Reader) -> Iterator[Remark]:
    """Yield remarks on the options of a preset."""
    if reader.preset:
        yield Remark("is a preset: what it does not set stays as the model has it")
    if reader.taken:
        yield Remark(f"options that are checked: {'; '.join(reader.taken)}", 0, len(reader.taken))
    if reader.left:
        yield Remark(
            f"options that are not checked, and not taken: "
            f"{'; '.join(dict.fromkeys(reader.left))}; to take one, write (CHECKED) in its line",
            0,
            sum(each.left == _UNCHECKED for each in reader.commands),
        )


def _of_lines(reader: _Reader) -> Iterator[Remark]:
    """Yield remarks on lines that are no commands, and on those that change the law."""
    strange = [each for each in reader.commands if not each.known]
    if strange:
        listed = joined([f"'{each.text[:40]}'" for each in strange], 3)
        yield Remark(f"lines that are no commands: {listed}", strange[0].line, len(strange))
    for each in reader.commands:
        number, command = each.line, each.text
        if each.left == _UNCHECKED:
            continue
        word, _, rest = command.partition(" ")
        mixes = word.casefold() == "mmix" and rest != "reset"
        if mixes or (word.casefold() == "mixer" and rest not in _X):
            yield Remark(
                f"'{command[:40]}' is not flown: the mixer follows from the model's rotors", number
            )
        if not reader.switches.get("airmode", 1.0) and _AIR_MODE_SWITCH.fullmatch(command):
            yield Remark("air mode is on a switch: flown without, --set airmode=1 for with", number)


_X = ("QUADX", "HEX6X", "OCTOFLATX", "HEX6", "OCTOFLATP", "QUADP", "list")


def _word(command: str) -> str:
    return command.partition(" ")[0].casefold()


def settled(file: ParameterFile, release: Release) -> ParameterFile:
    """Return a file in which commands that compute values have run, as in a version.

    Their values are entries behind the line of the command, with a negative `start`.
    """
    table = load_table("betaflight")
    names = table.names(release)
    entries: list[Entry] = []
    file = replace(file, entries=tuple(_scoped(each, names) for each in file.entries))
    remarks, commands = [*file.remarks, *_of_profiles(file)], list(file.commands)
    for entry in file.entries:
        if entry.name not in (_APPLY, _DISABLE):
            entries.append(entry)
            continue
        if "simplified_pids_mode" not in names:
            said = f"is no command of {release.version}"
            remarks.append(Remark(f"'{entry.name}' {said}", entry.line))
            commands = [
                replace(each, left=said, known=False) if each.line == entry.line else each
                for each in commands
            ]
            continue
        present = replace(file, entries=tuple(entries)).counted
        run = _disabled() if entry.name == _DISABLE else _applied(present, names)
        entries += [
            Entry(name, number_in(text), text, -1, entry.line, "", True)
            for name, text in run.items()
        ]
        if entry.name == _APPLY:
            said = f"'{_APPLY}' computes {len(run)} values from the sliders"
            remarks.append(Remark(said, entry.line, len(run)))
    return replace(file, entries=tuple(entries), remarks=tuple(remarks), commands=tuple(commands))


def _scoped(entry: Entry, names: Mapping[str, Setting]) -> Entry:
    """Return an entry that applies to the profile selected at its line, if that has the name."""
    setting = names.get(entry.name)
    kind = f"{setting.scope} " if setting and setting.scope else "?"
    chosen = [each for each in entry.scope.split(_BETWEEN) if each.startswith(kind)]
    return replace(entry, scope=chosen[0] if chosen else "")


def _disabled() -> dict[str, str]:
    return {
        "simplified_pids_mode": "OFF",
        "simplified_dterm_filter": "OFF",
        "simplified_gyro_filter": "OFF",
    }


def _applied(present: Mapping[str, Entry], names: Mapping[str, Setting]) -> dict[str, str]:
    """Return the values, as texts, that the sliders compute.

    Args:
        present: what the file has set so far; other values are the defaults.
        names: of the version.
    """

    def text(name: str) -> str:
        if name in present:
            return present[name].text
        return names[name].text(names[name].default or 0.0)

    def value(name: str) -> float:
        return number_in(text(name)) or 0.0

    mode = text("simplified_pids_mode").upper()
    found = dict(_gains(value, names, _AXES[: _MODES.get(mode, 3)]))
    if text("simplified_dterm_filter").upper() != "OFF":
        found |= _filters(value, names, "dterm", int(value("simplified_dterm_filter_multiplier")))
    if text("simplified_gyro_filter").upper() != "OFF":
        found |= _filters(value, names, "gyro", int(value("simplified_gyro_filter_multiplier")))
    return {name: str(number) for name, number in found.items()}


def _gains(
    value: Callable[[str], float], names: Mapping[str, Setting], axes: Iterable[str]
) -> Iterator[tuple[str, int]]:
    """Yield the gains of some axes, as `calculateNewPidValues` does."""

    def default(name: str) -> float:
        return names[name].default or 0.0

    def product(*factors: float) -> float:
        found = factors[0]
        for factor in factors[1:]:
            found = single(found * factor)
        return found

    def cut(name: str, *factors: float) -> tuple[str, int]:
        most = names[name].most
        return name, int(min(max(product(*factors), 0.0), most))

    def slider(name: str) -> float:
        return single(value(f"simplified_{name}") / 100.0)

    before = "d_min_roll" in names
    whole, pi, d, i = map(slider, ("master_multiplier", "pi_gain", "d_gain", "i_gain"))
    feed, peak = slider("feedforward_gain"), slider("dmax_gain" if before else "d_max_gain")
    for axis in axes:
        of_pitch = axis == "pitch"
        more_d = slider("pitch_d_gain") if of_pitch else 1.0
        more_pi = slider("pitch_pi_gain") if of_pitch else 1.0
        yield cut(f"p_{axis}", default(f"p_{axis}"), whole, pi, more_pi)
        yield cut(f"i_{axis}", default(f"i_{axis}"), whole, pi, i, more_pi)
        yield cut(f"f_{axis}", default(f"f_{axis}"), whole, more_pi, feed)
        if before:
            least, most = default(f"d_min_{axis}"), default(f"d_{axis}")
            rise = single((most - least) / least) if least > 0.0 else 0.0
            ratio = single(1.0 + single(rise * peak))
            yield cut(f"d_{axis}", least, whole, d, more_d, ratio)
            yield cut(f"d_min_{axis}", least, whole, d, more_d)
        else:
            base, most = default(f"d_{axis}"), default(f"d_max_{axis}")
            ratio = 1.0
            if most > 0.0:
                ratio = single(peak + single(single(single(1.0 - peak) * base) / most))
            yield cut(f"d_{axis}", base, whole, d, more_d)
            yield cut(f"d_max_{axis}", most, whole, d, more_d, ratio)


def _filters(
    value: Callable[[str], float], names: Mapping[str, Setting], kind: str, percent: int
) -> dict[str, int]:
    """Return cut-offs of the low-passes that are on, as `calculateNewDTermFilterValues` does."""

    def scaled(name: str) -> int:
        setting = names[f"{kind}_{name}"]
        return min(int(setting.default or 0.0) * percent // 100, int(setting.most))

    found = {}
    if value(f"{kind}_lpf1_dyn_min_hz"):
        found[f"{kind}_lpf1_dyn_min_hz"] = scaled("lpf1_dyn_min_hz")
        found[f"{kind}_lpf1_dyn_max_hz"] = scaled("lpf1_dyn_max_hz")
    if value(f"{kind}_lpf1_static_hz"):
        found[f"{kind}_lpf1_static_hz"] = scaled("lpf1_dyn_min_hz")
    if value(f"{kind}_lpf2_static_hz"):
        found[f"{kind}_lpf2_static_hz"] = scaled("lpf2_static_hz")
    return found


def betaflight_value(entry: Entry, value: float) -> str:
    """Return the text of a value in its line."""
    return str(round(value))


def set_lines(file: ParameterFile, texts: Mapping[str, str]) -> str:
    """Return lines for a file in which a command computes these values otherwise."""
    lines = [_DISABLE, *(f"set {name} = {text}" for name, text in sorted(texts.items()))]
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
