"""Firmwares with supported parameter files: which one a file is of, and values in its versions.

Names of parameters of a law are those of the firmware's newest version, with _ for the Crazyflie's
dot. Other parameters of laws, such as limits and motors of the workbench, are in no file. Names,
scales, defaults and ranges of each version are in the firmware's table, see `table.py`.
"""

import re
from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING

from workbench.common.errors import WorkbenchError, find_named_row
from workbench.control.controller import Controller
from workbench.extras.autopilots.gain_files import command_line, crazyflie_file
from workbench.extras.autopilots.gain_files import parameter_file as formats
from workbench.extras.autopilots.gain_files.parameter_file import (
    ParameterEntry,
    ParameterFile,
    file_of,
    lines_of,
    read_parameter_text,
)
from workbench.extras.autopilots.gain_files.table import (
    FirmwareTable,
    Release,
    Setting,
    load_table,
    value_of_pair,
)
from workbench.gains.formats import ExportedGains, GainFormat, ImportedGains, joined_names

if TYPE_CHECKING:
    from workbench.extras.autopilots.gain_files.imported_gains import ReadGains


@dataclass(frozen=True, kw_only=True)
class Firmware(GainFormat):
    """A firmware, and its files.

    Attributes:
        name: for the option --for.
        version: the one whose equations the laws have by default.
        laws: controllers of this firmware, the usual one first.
        suffixes: of its files, that of a new one first.
        written: returns the text of a value from an entry and a number.
        new: returns the text of a new file from texts of values and version.
        strict: whether it refuses values beyond its ranges and names that it does not know;
            otherwise its ranges are advice, as a ground station only warns.
        log_writers: how the name of the firmware begins in its logs of multirotors; () for any.
    """

    version: str
    written: Callable[[ParameterEntry, float], str]
    new: Callable[[Mapping[str, float], str], str]
    strict: bool = False
    log_writers: tuple[str, ...] = ()

    def count_lines(self, path: Path) -> int:
        """Return how many lines of a file are this firmware's, 0 if it is of another one."""
        chosen, count = _detected(path, read_parameter_text(path))
        return count if chosen is self else 0

    def read(
        self,
        path: Path,
        version: str,
        profile: int | None,
        law: Controller | None,
        *,
        named: bool,
    ) -> "ReadGains":
        """Read the gains in a parameter file."""
        from workbench.extras.autopilots.gain_files.imported_gains import imported_gains

        found, file = read_parameter_file(path, self.name if named else "", profile)
        return imported_gains(file, found, version, law)

    def wrote(self, writer: str) -> bool:
        """Return whether a log was written by the firmware."""
        return writer.startswith(self.log_writers) if self.log_writers else super().wrote(writer)

    def read_log(
        self,
        path: Path,
        writer: str,
        values: Mapping[str, float],
        version: str,
        law: Controller | None,
    ) -> "ReadGains":
        """Return the gains among the parameters in a log."""
        from workbench.extras.autopilots.gain_files.imported_gains import imported_gains

        if self.log_writers and not self.wrote(writer):
            what = "Betaflight" if self is BETAFLIGHT_FIRMWARE else "a copter"
            raise WorkbenchError(f"{path}: is a log of {writer or self.name}, not of {what}")
        if not self.strict:
            return imported_gains(file_of(path, values, version), self, version, law)
        names = self.table.names(self.table.release(version)[0])
        known = {name: value for name, value in values.items() if name in names}
        if not any(names[name].law for name in known):
            raise WorkbenchError(f"{path}: has no gains of {self.name} in its header")
        file = file_of(path, known, version)
        entries = [
            replace(each, text=names[each.name].text(known[each.name])) for each in file.entries
        ]
        return imported_gains(replace(file, entries=tuple(entries)), self, version, law)

    def write(
        self,
        values: Mapping[str, float],
        law: Controller,
        version: str,
        present: ImportedGains | None,
    ) -> ExportedGains:
        """Return a parameter file with the gains of a law."""
        from workbench.extras.autopilots.gain_files.exported_gains import exported_gains
        from workbench.extras.autopilots.gain_files.imported_gains import ReadGains

        assert present is None or isinstance(present, ReadGains)
        return exported_gains(values, law, self, version, present)

    @property
    def table(self) -> FirmwareTable:
        """Its parameters by version."""
        return load_table(self.name)

    @cached_property
    def _file_names(self) -> Mapping[str, str]:
        """Names in the usual version, else in the newest that has them, by those of the law."""
        newest = {each.law: each.name for each in self.table.settings if each.law and each.name}
        own = self.table.by_law(self.table.release(self.version)[0])
        return newest | {law: each.name for law, each in own.items() if each.name}

    def file_name(self, name: str) -> str:
        """Return the name of a parameter of the law in the firmware."""
        return self._file_names.get(name, name)

    def flown_by(self, law: Controller) -> str:
        """Return the version that a law computes."""
        return _LAW_VERSIONS.get(law.unscheduled, self.version)

    def has(self, name: str) -> bool:
        """Return whether the firmware has a parameter of a law, not only the workbench."""
        return name in self.table.laws

    def setting(self, name: str, release: Release) -> Setting | None:
        """Return the row for a name in a file: that of the version, else of the nearest other."""
        own = self.table.names(release).get(name)
        if own is not None or self.strict:
            return own
        others = [each for each in self.table.settings if each.name == name]
        return others[-1] if others else None

    def to_law(self, values: Mapping[str, float], release: Release) -> dict[str, float]:
        """Return the values of a file by the names and in the scales of the law.

        Args:
            values: by the names of the file; if it has a name twice, the version's own counts.
            release: the version of the file.
        """
        own = self.table.names(release)
        found: dict[str, float] = {}
        pairs: dict[str, float] = {}
        for name in sorted(values, key=lambda name: name in own):
            setting = self.setting(name, release)
            if setting is None or not setting.law:
                continue
            if setting.pair:
                pairs[setting.law] = values[name]
            else:
                found[setting.law] = values[name] * setting.scale
        return found | self._of_pairs(pairs, release)

    def _of_pairs(self, pairs: Mapping[str, float], release: Release) -> dict[str, float]:
        """Return d and d_max of the law from d_min and d of before 4.6; the other is a default."""
        by_law = self.table.by_law(release)
        found = {}
        for axis in {name.rpartition("_")[2] for name in pairs}:
            base, peak = f"d_{axis}", f"d_max_{axis}"
            least = pairs.get(base, by_law[base].default or 0.0)
            most = pairs.get(peak, by_law[peak].default or 0.0)
            rises = 0.0 < least < most
            found[base], found[peak] = (least, most) if rises else (most, 0.0)
        return found

    def defaults(self, release: Release) -> dict[str, float]:
        """Return the defaults of a version by the names and in the scales of the law."""
        found, pairs = {}, {}
        for law, setting in self.table.by_law(release).items():
            if setting.default is None:
                continue
            kept = pairs if setting.pair else found
            kept[law] = setting.default * setting.scale
        return found | self._of_pairs(pairs, release)

    def to_file(self, values: Mapping[str, float], release: Release) -> dict[str, float]:
        """Return the values of a law by the names and in the scales of a version.

        Those that the version lacks are left out.
        """
        found = {}
        for law, setting in self.table.by_law(release).items():
            if not setting.name:
                continue
            if setting.pair:
                value = value_of_pair(values, setting)
            else:
                value = values.get(law)
                value = None if value is None else value / setting.scale
            if value is not None:
                found[setting.name] = value
        return found


PX4_FIRMWARE = Firmware(
    name="px4",
    version="1.17",
    laws=("px4",),
    suffixes=(".params",),
    written=formats.px4_value,
    new=formats.new_px4_file,
)
ARDUPILOT_FIRMWARE = Firmware(
    name="ardupilot",
    version="4.7",
    laws=("ardupilot",),
    suffixes=(".param", ".parm"),
    written=formats.ardupilot_value,
    new=formats.new_ardupilot_file,
    log_writers=("ArduCopter", "APM:Copter"),
)
BETAFLIGHT_FIRMWARE = Firmware(
    name="betaflight",
    version="2025.12",
    laws=("betaflight", "betaflight-sitl"),
    suffixes=(".txt",),
    written=command_line.betaflight_value,
    new=command_line.new_betaflight_file,
    strict=True,
    log_writers=("Betaflight",),
)
CRAZYFLIE_FIRMWARE = Firmware(
    name="crazyflie",
    version="2025.12.1",
    laws=("crazyflie", "mellinger"),
    suffixes=(".yaml", ".json"),
    written=crazyflie_file.crazyflie_value,
    new=crazyflie_file.new_crazyflie_file,
)
SUPPORTED_FIRMWARES = (PX4_FIRMWARE, ARDUPILOT_FIRMWARE, BETAFLIGHT_FIRMWARE, CRAZYFLIE_FIRMWARE)
_LAW_VERSIONS = {"betaflight-sitl": "4.6"}
"""Versions of laws that are not the usual one of their firmware."""
_CRAZYFLIE_LINE_PATTERN = re.compile(r"[ \t{,]*[\"']?[A-Za-z]\w*\.\w+[\"']?[ \t]*:.*")
_STACK_LINE_PATTERN = re.compile(r"#[ \t]*Stack[ \t]*:[ \t]*(.*\S)", re.I)
_VEHICLE_LINE_PATTERN = re.compile(r"#[ \t]*Vehicle[ \t]*:[ \t]*(.*\S)", re.I)
_FIRMWARE_BY_STACK = {"px4": "px4", "px4 pro": "px4", "ardupilot": "ardupilot", "apm": "ardupilot"}
_NO_MULTIROTOR_PATTERN = re.compile(
    "fixed.?wing|plane|heli|rover|boat|sub|ship|balloon|rocket|tracker|kite|parafoil|flapping|"
    "glider|coaxial",
    re.I,
)
"""Words in QGroundControl's vehicles that are no multirotor; makers write their own names, too."""
_MAX_DETECTION_LINES = 5000
"""Largest number of lines used to detect the format of a file."""
_MAX_HEAD_LINES = 60
"""Largest number of lines in which a head is looked for."""


def find_firmware(name: str) -> Firmware:
    """Return the firmware with a name.

    Raises:
        WorkbenchError: if there is none.
    """
    return find_named_row("firmware", name, SUPPORTED_FIRMWARES)


def read_parameter_file(
    path: Path, firmware: str = "", profile: int | None = None
) -> tuple[Firmware, ParameterFile]:
    """Read the parameter file of an autopilot.

    Args:
        path: the file.
        firmware: its name; without it the file's head tells, else its lines.
        profile: of Betaflight's file, which one counts.

    Raises:
        WorkbenchError: if it is invalid, with the line, or of a firmware without a law here.
    """
    text = read_parameter_text(path)
    counts = _matching_lines(text)
    chosen = find_firmware(firmware) if firmware else _detected(path, text)[0]
    if profile is not None and chosen is not BETAFLIGHT_FIRMWARE:
        raise WorkbenchError("--profile is of Betaflight's files: leave it out")
    file = _read_by_format(chosen, path, text, profile, counts)
    for entry in () if firmware else file.entries:
        if owner := chosen.table.owner(entry.name):
            raise WorkbenchError(
                f"{path}:{entry.line}: sets {entry.name[:40]}, a parameter of {owner} alone, whose "
                f"laws are not here; --for {chosen.name} reads it as that firmware's"
            )
    return chosen, file


def _detected(path: Path, text: str) -> tuple[Firmware, int]:
    """Return the firmware of a text, by its head or else its lines, and the number of its lines.

    Raises:
        WorkbenchError: if it is of none.
    """
    counts = _matching_lines(text)
    if said := _head_firmware(path, text):
        return find_firmware(said), max(1, counts[said])
    if not any(counts.values()):
        raise WorkbenchError(
            f"{path}: is not a parameter file of "
            f"{joined_names([f.name for f in SUPPORTED_FIRMWARES])}: "
            "expected lines as '1 1 MC_ROLL_P 6.5 9', 'ATC_ANG_RLL_P,4.5', 'set p_roll = 45' "
            "or 'pid_rate.roll_kp: 250'"
        )
    chosen = max(SUPPORTED_FIRMWARES, key=lambda f: counts[f.name])
    return chosen, counts[chosen.name]


def _read_by_format(
    firmware: Firmware, path: Path, text: str, profile: int | None, counts: Mapping[str, int]
) -> ParameterFile:
    """Read a text of a firmware, by the number of lines of each format."""
    if firmware is BETAFLIGHT_FIRMWARE:
        return command_line.read_command_line(path, text, profile)
    if firmware is CRAZYFLIE_FIRMWARE:
        return crazyflie_file.read_crazyflie_parameters(path, text)
    if firmware is ARDUPILOT_FIRMWARE and counts["params"] <= counts["ardupilot"]:
        return formats.read_ardupilot_param(path, text)
    scripted = firmware is PX4_FIRMWARE and counts["script"] and not counts["params"]
    return (formats.read_px4_script if scripted else formats.read_qgc_params)(path, text)


def _head_firmware(path: Path, text: str) -> str:
    """Return the firmware that the head of a file names, "" if it names none.

    Raises:
        WorkbenchError: if no law here is of that firmware or vehicle.
    """
    said = ""
    for number, _, line in lines_of(text):
        bare = line.lstrip("\ufeff \t")
        if number > _MAX_HEAD_LINES:
            break
        if found := _STACK_LINE_PATTERN.match(bare):
            said = _FIRMWARE_BY_STACK.get(found[1].casefold(), "")
            if not said:
                raise _unsupported(path, number, found[1])
        elif found := command_line.VERSION_LINE_PATTERN.match(bare):
            if found[1].casefold() not in ("betaflight", "btfl"):
                raise _unsupported(path, number, found[1])
            said = "betaflight"
        elif (found := _VEHICLE_LINE_PATTERN.match(bare)) and _NO_MULTIROTOR_PATTERN.search(
            found[1]
        ):
            raise WorkbenchError(
                f"{path}:{number}: is of a '{found[1][:40]}', and the laws are those of "
                "multirotors; --for NAME reads it nevertheless"
            )
        elif bare.startswith("#$") and not said:
            said = "betaflight"
    return said


def _unsupported(path: Path, number: int, name: str) -> WorkbenchError:
    return WorkbenchError(
        f"{path}:{number}: is of {name[:40]}, whose laws are not here: gains of "
        f"{joined_names([f.name for f in SUPPORTED_FIRMWARES])} can be read; --for NAME reads it "
        "as that firmware's"
    )


def _matching_lines(text: str) -> dict[str, int]:
    """Return the number of lines of a text that match each firmware."""
    counts = dict.fromkeys([*(each.name for each in SUPPORTED_FIRMWARES), "script", "params"], 0)
    for number, _, line in lines_of(text):
        if number > _MAX_DETECTION_LINES:
            break
        counts["params"] += formats.PX4_LINE_PATTERN.fullmatch(line) is not None
        counts["script"] += formats.PX4_SCRIPT_LINE_PATTERN.match(line) is not None
        counts["betaflight"] += command_line.SET_LINE_PATTERN.fullmatch(line) is not None
        counts["ardupilot"] += (
            formats.ARDUPILOT_LINE_PATTERN.fullmatch(line.lstrip("\ufeff")) is not None
        )
        counts["crazyflie"] += _CRAZYFLIE_LINE_PATTERN.match(line) is not None
    counts["px4"] = counts["params"] + counts["script"]
    return counts
