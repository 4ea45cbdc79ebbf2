"""Firmwares with supported parameter files: which one a file is of, and values in its versions.

Names of parameters of a law are those of the firmware's newest version, with _ for the Crazyflie's
dot. Other parameters of laws, such as limits and motors of the workbench, are in no file. Names,
scales, defaults and ranges of each version are in the firmware's table, see `table.py`.
"""

import math
import re
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path

from workbench.common.errors import WorkbenchError, find_row
from workbench.common.parameter import Parameter
from workbench.control.controller import Controller
from workbench.gains.autopilots import command_line
from workbench.gains.autopilots import parameter_file as formats
from workbench.gains.autopilots.parameter_file import (
    Entry,
    ParameterFile,
    joined,
    lines_of,
    read_text,
    single,
)
from workbench.gains.autopilots.table import BASE, PEAK, Release, Setting, Table, load_table


@dataclass(frozen=True)
class Firmware:
    """A firmware, and its files.

    Attributes:
        name: for the option --for.
        version: the one whose equations the laws have by default.
        laws: controllers of this firmware, the usual one first.
        suffix: of a new file.
        written: returns the text of a value from an entry and a number.
        new: returns the text of a new file from texts of values and version.
        strict: whether it refuses values beyond its ranges and names that it does not know;
            otherwise its ranges are advice, as a ground station only warns.
    """

    name: str
    version: str
    laws: tuple[str, ...]
    suffix: str
    written: Callable[[Entry, float], str]
    new: Callable[[Mapping[str, float], str], str]
    strict: bool = False

    @property
    def table(self) -> Table:
        """Its parameters by version."""
        return load_table(self.name)

    @cached_property
    def _file_names(self) -> Mapping[str, str]:
        """Names in the usual version, else in the newest that has them, by those of the law."""
        newest = {each.law: each.name for each in self.table.settings if each.law and each.name}
        own = self.table.by_law(self.table.release(self.version)[0])
        return newest | {law: each.name for law, each in own.items() if each.name}

    @cached_property
    def _law_names(self) -> Mapping[str, str]:
        settings = [each for each in self.table.settings if each.law and each.name]
        return {each.name: each.law for each in settings} | {
            name: law for law, name in self._file_names.items()
        }

    def law_name(self, name: str) -> str:
        """Return the name of a parameter in the law."""
        return self._law_names.get(name, name)

    def file_name(self, name: str) -> str:
        """Return the name of a parameter of the law in the firmware."""
        return self._file_names.get(name, name)

    def flown_by(self, law: Controller) -> str:
        """Return the version that a law computes."""
        return _FLOWN.get(law.unscheduled, self.version)

    def rows(self, law: Controller) -> tuple[Parameter, ...]:
        """Return the parameters of a law that some version of the firmware has."""
        return tuple(row for row in law.parameters if self.has(row.name))

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
                value = _of_pair(values, setting)
            else:
                value = values.get(law)
                value = None if value is None else value / setting.scale
            if value is not None:
                found[setting.name] = value
        return found


def _of_pair(values: Mapping[str, float], setting: Setting) -> float | None:
    """Return d, or d_min, of before 4.6 from d and d_max of the law; None if it has neither."""
    axis = setting.law.rpartition("_")[2]
    base, peak = values.get(f"d_{axis}"), values.get(f"d_max_{axis}")
    if base is None or peak is None:
        return None
    rises = round(peak) > round(base) > 0  # as the file keeps them
    if setting.pair == PEAK:
        return peak if rises else base
    assert setting.pair == BASE
    return base if rises else 0.0


PX4 = Firmware("px4", "1.17", ("px4",), ".params", formats.px4_value, formats.new_px4_file)
ARDUPILOT = Firmware(
    "ardupilot",
    "4.7",
    ("ardupilot",),
    ".param",
    formats.ardupilot_value,
    formats.new_ardupilot_file,
)
BETAFLIGHT = Firmware(
    "betaflight",
    "2025.12",
    ("betaflight", "betaflight-sitl"),
    ".txt",
    command_line.betaflight_value,
    command_line.new_betaflight_file,
    strict=True,
)
CRAZYFLIE = Firmware(
    "crazyflie",
    "2025.12.1",
    ("crazyflie", "mellinger"),
    ".yaml",
    formats.crazyflie_value,
    formats.new_crazyflie_file,
)
FIRMWARES = (PX4, ARDUPILOT, BETAFLIGHT, CRAZYFLIE)
_FLOWN = {"betaflight-sitl": "4.6"}
"""Versions of laws that are not the usual one of their firmware."""
_CRAZYFLIE_LINE = re.compile(r"[ \t{,]*[\"']?[A-Za-z]\w*\.\w+[\"']?[ \t]*:.*")
_STACK = re.compile(r"#[ \t]*Stack[ \t]*:[ \t]*(.*\S)", re.I)
_VEHICLE = re.compile(r"#[ \t]*Vehicle[ \t]*:[ \t]*(.*\S)", re.I)
_STACKS = {"px4": "px4", "px4 pro": "px4", "ardupilot": "ardupilot", "apm": "ardupilot"}
_NO_MULTIROTOR = re.compile(
    "fixed.?wing|plane|heli|rover|boat|sub|ship|balloon|rocket|tracker|kite|parafoil|flapping|"
    "glider|coaxial",
    re.I,
)
"""Words in QGroundControl's vehicles that are no multirotor; makers write their own names, too."""
_MOST_LINES = 5000
"""Largest number of lines used to detect the format of a file."""
_MOST_HEAD = 60
"""Largest number of lines in which a head is looked for."""


def find_firmware(name: str) -> Firmware:
    """Return the firmware with a name.

    Raises:
        WorkbenchError: if there is none.
    """
    return find_row("firmware", name, FIRMWARES)


def firmware_of(law: Controller) -> Firmware | None:
    """Return the firmware of a controller, or None."""
    return next((each for each in FIRMWARES if law.unscheduled in each.laws), None)


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
    text = read_text(path)
    counts = _matching_lines(text)
    if firmware:
        chosen = find_firmware(firmware)
    else:
        said = _said_firmware(path, text)
        chosen = find_firmware(said) if said else max(FIRMWARES, key=lambda f: counts[f.name])
        if not said and not any(counts.values()):
            raise WorkbenchError(
                f"{path}: is not a parameter file of {joined([f.name for f in FIRMWARES])}: "
                "expected lines as '1 1 MC_ROLL_P 6.5 9', 'ATC_ANG_RLL_P,4.5', 'set p_roll = 45' "
                "or 'pid_rate.roll_kp: 250'"
            )
    if profile is not None and chosen is not BETAFLIGHT:
        raise WorkbenchError("--profile is of Betaflight's files: leave it out")
    file = _read(chosen, path, text, profile, counts)
    for entry in () if firmware else file.entries:
        if owner := chosen.table.owner(entry.name):
            raise WorkbenchError(
                f"{path}:{entry.line}: sets {entry.name[:40]}, a parameter of {owner} alone, whose "
                f"laws are not here; --for {chosen.name} reads it as that firmware's"
            )
    return chosen, file


def _read(
    firmware: Firmware, path: Path, text: str, profile: int | None, counts: Mapping[str, int]
) -> ParameterFile:
    """Read a text of a firmware, by the number of lines of each format."""
    if firmware is BETAFLIGHT:
        return command_line.read_command_line(path, text, profile)
    if firmware is CRAZYFLIE:
        return formats.read_crazyflie_parameters(path, text)
    if firmware is ARDUPILOT and counts["params"] <= counts["ardupilot"]:
        return formats.read_ardupilot_param(path, text)
    scripted = firmware is PX4 and counts["script"] and not counts["params"]
    return (formats.read_px4_script if scripted else formats.read_qgc_params)(path, text)


def _said_firmware(path: Path, text: str) -> str:
    """Return the firmware that the head of a file names, "" if it names none.

    Raises:
        WorkbenchError: if no law here is of that firmware or vehicle.
    """
    said = ""
    for number, _, line in lines_of(text):
        bare = line.lstrip("\ufeff \t")
        if number > _MOST_HEAD:
            break
        if found := _STACK.match(bare):
            said = _STACKS.get(found[1].casefold(), "")
            if not said:
                raise _unsupported(path, number, found[1])
        elif found := command_line.HEAD.match(bare):
            if found[1].casefold() not in ("betaflight", "btfl"):
                raise _unsupported(path, number, found[1])
            said = "betaflight"
        elif (found := _VEHICLE.match(bare)) and _NO_MULTIROTOR.search(found[1]):
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
        f"{joined([f.name for f in FIRMWARES])} can be read; --for NAME reads it as that firmware's"
    )


def _matching_lines(text: str) -> dict[str, int]:
    """Return the number of lines of a text that match each firmware."""
    counts = dict.fromkeys([*(each.name for each in FIRMWARES), "script", "params"], 0)
    for number, _, line in lines_of(text):
        if number > _MOST_LINES:
            break
        counts["params"] += formats.PX4_LINE.fullmatch(line) is not None
        counts["script"] += formats.PX4_SCRIPT_LINE.match(line) is not None
        counts["betaflight"] += command_line.SET_LINE.fullmatch(line) is not None
        counts["ardupilot"] += formats.ARDUPILOT_LINE.fullmatch(line.lstrip("\ufeff")) is not None
        counts["crazyflie"] += _CRAZYFLIE_LINE.match(line) is not None
    counts["px4"] = counts["params"] + counts["script"]
    return counts


def file_of(path: Path, values: Mapping[str, float], version: str = "") -> ParameterFile:
    """Return parameters from elsewhere, such as a log, as a file that `imported` takes.

    Args:
        path: where they come from, for messages.
        values: by the names of the firmware.
        version: of the firmware, "" if not known.
    """
    entries = tuple(
        Entry(name, float(value), f"{value:.9g}", -1, 0) for name, value in values.items()
    )
    return ParameterFile(path, "", entries, version)


def unsafe(row: Parameter, value: float | None) -> str:
    """Return why a value must not fly, as a clause, else ""."""
    if value is None or math.isnan(value):
        return "is not a number"
    if math.isinf(value):
        return "is infinite"
    if value < 0.0 <= row.minimum:
        return "is negative: this would reverse the sign of its part of the loop"
    if not row.minimum <= value <= row.maximum:
        unit = "" if row.unit == "1" else f" {row.unit}"
        return f"is out of range: keep it within {row.minimum:g} .. {row.maximum:g}{unit}"
    if row.whole and not value.is_integer():
        return "is not a whole number"
    return ""


def same(a: float, b: float) -> bool:
    """Return whether two numbers are equal in the single precision of a firmware."""
    return a == b or single(a) == single(b)
