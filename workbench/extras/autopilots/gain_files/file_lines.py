"""The lines of a parameter file, by what its version of the firmware makes of them."""

import math
from collections.abc import Collection, Iterator, Mapping

from workbench.control.controller import Controller
from workbench.extras.autopilots.gain_files.firmware import Firmware
from workbench.extras.autopilots.gain_files.parameter_file import (
    ParameterEntry,
    ParameterFile,
    tidy_single,
)
from workbench.extras.autopilots.gain_files.table import Release, Setting
from workbench.gains.formats import joined_names
from workbench.gains.parameter_line import (
    LINE_FLOWN,
    LINE_NOT_FLOWN,
    LINE_UNKNOWN,
    ParameterFileRemark,
    ParameterLine,
    UnusedParameter,
)


class FileLines:
    """The lines of a file that count, each by what its version makes of it.

    Args:
        firmware: of the file.
        release: its version.
        file: the parameters, after all commands have run.

    Attributes:
        entries: by name.
        lines: their numbers in the file.
        settings: rows of the table, of names that it has.
        unknown: line numbers of other names.
        numbers: values in the firmware's unit, NaN for what is no number.
        refused: lines that the firmware refuses, as `p_roll 300 (0 .. 250)`.
    """

    def __init__(self, firmware: Firmware, release: Release, file: ParameterFile) -> None:
        self.firmware, self.release, self.file = firmware, release, file
        self.entries: Mapping[str, ParameterEntry] = {
            name: entry
            for name, entry in file.counted.items()
            if not name.startswith("simplified_tuning ")
        }
        self.lines = {name: entry.line for name, entry in self.entries.items()}
        self.settings: dict[str, Setting] = {}
        self.unknown: dict[str, int] = {}
        self.numbers: dict[str, float] = {}
        for name, entry in self.entries.items():
            setting = firmware.setting(name, release)
            if setting is None:
                self.unknown[name] = entry.line
                continue
            self.settings[name] = setting
            number = setting.number(entry.text) if setting.words else entry.value
            self.numbers[name] = math.nan if number is None else tidy_single(number)
        told = {name: self._refusal(name) for name in self.settings}
        self.refused = {name: said for name, said in told.items() if said}

    def _refusal(self, name: str) -> str:
        """Return why the firmware refuses a line, as `p_roll 300 (0 .. 250)`; "" if it does not."""
        setting, number = self.settings[name], self.numbers[name]
        if not self.firmware.strict or (math.isnan(number) and not setting.words):
            return ""
        wanted = ", ".join(setting.words) if math.isnan(number) else setting.taken(number)
        return f"{name} {self.entries[name].text[:20]} ({wanted})" if wanted else ""

    def flown_values(self, flown: Mapping[str, float]) -> Iterator[tuple[str, float, Setting]]:
        """Yield name, value in the firmware's unit, and row of the lines that a law flies."""
        for name, setting in self.settings.items():
            if setting.law in flown:
                yield name, self.numbers[name], setting

    def left(self, law: Controller) -> Iterator[UnusedParameter]:
        """Yield parameters of flight control that the law does not have."""
        flown = {row.name for row in law.parameters}
        for name, setting in self.settings.items():
            if setting.law in flown:
                continue
            number = self.numbers[name]
            value = None if math.isnan(number) else number
            acts = bool(setting.law) or not setting.is_off(value)
            yield UnusedParameter(name, self.entries[name].text, self.lines[name], acts)

    def account(self, law: Controller, wrong: Mapping[str, str]) -> Iterator[ParameterLine]:
        """Yield every line of the file, comments left out, and what becomes of it.

        Args:
            law: the one that flies.
            wrong: why values of the law must not fly, by its names.
        """
        left = {each.name: each for each in self.left(law)}
        for entry in self.file.entries:
            if entry.name.startswith("simplified_tuning "):
                continue
            part, why = self._part(entry, left, wrong)
            yield ParameterLine(entry.line, entry.name, entry.text, part, why)
        for command in self.file.commands:
            part = (
                LINE_UNKNOWN
                if not command.known
                else LINE_NOT_FLOWN
                if command.left
                else LINE_FLOWN
            )
            yield ParameterLine(command.line, "", command.text, part, command.left)

    def _part(
        self, entry: ParameterEntry, left: Mapping[str, UnusedParameter], wrong: Mapping[str, str]
    ) -> tuple[str, str]:
        """Return what becomes of a value, and why."""
        name, version = entry.name, f"{self.firmware.name} {self.release.version}"
        table, counted = self.firmware.table, self.entries.get(name)
        if self.firmware.setting(name, self.release) is None:
            if not table.others:
                near = table.is_near(name)
                return LINE_UNKNOWN, "of flight control" if near else "of other parts, or unknown"
            if table.knows(name, self.release):
                return LINE_NOT_FLOWN, "of other parts"
            return LINE_UNKNOWN, f"{version} refuses it"
        if entry.scope not in ("", *self.file.scopes):
            kind = entry.scope.split()[0]
            chosen = next(each for each in self.file.scopes if each.startswith(f"{kind} "))
            return LINE_NOT_FLOWN, f"of {entry.scope}, and {chosen} counts"
        if counted is not None and entry is not counted:
            return LINE_NOT_FLOWN, f"set again in line {counted.line}"
        if name in self.refused:
            return LINE_NOT_FLOWN, f"{version} refuses it: {self.refused[name]}"
        if name in left:
            return LINE_NOT_FLOWN, "not simulated" if left[name].acts else "without effect here"
        if why := wrong.get(self.settings[name].law):
            return LINE_NOT_FLOWN, why
        return LINE_FLOWN, ""

    def standing(self, law: Controller) -> Iterator[UnusedParameter]:
        """Yield parameters that the law does not have, and the version has on by default."""
        flown = {row.name for row in law.parameters}
        for name, setting in self.firmware.table.names(self.release).items():
            told = name in self.settings or setting.law in flown or bool(setting.law)
            if told or setting.default is None or setting.is_off(setting.default):
                continue
            if setting.off:  # a row without values that are off needs another parameter to act
                yield UnusedParameter(name, setting.text(setting.default), 0, True)

    def old_names(self) -> Iterator[ParameterFileRemark]:
        """Yield remarks on names that the version does not have, and on names with a scale."""
        own, version = self.firmware.table.names(self.release), self.release.version
        foreign = [name for name in self.settings if name not in own]
        renamed = {
            name: f"{name} is {self.firmware.file_name(setting.law)}"
            + (f" times {1.0 / setting.scale:g}" if setting.scale != 1.0 else "")
            for name, setting in self.settings.items()
            if setting.law and self.firmware.file_name(setting.law) != name and not setting.pair
        }
        pairs = [name for name, setting in self.settings.items() if setting.pair]
        yield from self._remarks(
            (
                foreign,
                f"{len(foreign)} names are not of {version}, and each is read as in its own "
                f"version: {joined_names(foreign)}",
            ),
            (renamed, f"names of earlier versions: {joined_names(list(renamed.values()))}"),
            (pairs, f"d and d_min of {version} are read as d_max and d"),
        )

    def _remarks(self, *rows: tuple[Collection[str], str]) -> Iterator[ParameterFileRemark]:
        """Yield a remark on the names of each row that has some, at the first of their lines."""
        for names, said in rows:
            if names:
                line = min(self.lines[name] for name in names)
                yield ParameterFileRemark(said, line, len(names))

    def _listed(self, names: Collection[str], *most: int) -> str:
        return joined_names([f"{name} {self.entries[name].text[:20]}" for name in names], *most)

    def strangers(self) -> Iterator[ParameterFileRemark]:
        """Yield remarks on names that the table does not have."""
        table, whose = self.firmware.table, f"{self.firmware.name} {self.release.version}"
        refused = [
            name for name in self.unknown if table.others and not table.knows(name, self.release)
        ]
        near = [] if table.others else [name for name in self.unknown if table.is_near(name)]
        others = [name for name in self.unknown if name not in (*refused, *near)]
        unsure = "" if table.others else ", or unknown"
        yield from self._remarks(
            (
                self.refused,
                f"beyond what {whose} takes, which refuses the line: "
                f"{', '.join(self.refused.values())}",
            ),
            (refused, f"unknown to {whose}, which refuses the line: {self._listed(refused)}"),
            (
                near,
                f"of flight control, but not known to {whose}, and not flown: {self._listed(near)}",
            ),
            (others, f"of other parts{unsure}: {self._listed(others, 3)}"),
        )
