"""Firmwares with supported parameter files, and the mapping of their names to those of laws.

Names of parameters of a law are those of the firmware, with _ for the Crazyflie's dot. Other
parameters of laws, such as limits and motors of the workbench, are in no file.
"""

import math
import re
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from pathlib import Path

from workbench.common.errors import WorkbenchError, find_row
from workbench.common.parameter import Parameter
from workbench.control.controller import COMMON, Controller
from workbench.gains.autopilots import parameter_file as formats
from workbench.gains.autopilots import ranges, versions
from workbench.gains.autopilots.parameter_file import (
    Entry,
    ParameterFile,
    joined,
    lines_of,
    read_text,
    single,
)

_BENCH = re.compile(r"thrust_max|vbat|SIM_GZ_EC_(MIN|MAX)|motor_speed|outer_.*|acro|airmode")
"""Parameters of laws that are the bench's own, its motors and outer loops: no vehicle has them."""
_COMMON = {row.name for row in COMMON}


@dataclass(frozen=True)
class Firmware:
    """A firmware, and its files.

    Attributes:
        name: for the option --for.
        version: of the laws here.
        laws: controllers of this firmware, the usual one first.
        suffix: of a new file.
        written: returns the text of a value from an entry and a number.
        new: returns the text of a new file from values and version.
        renames: names and scales of earlier versions.
        families: matches names that belong to its flight control, flown here or not.
        advised: ranges stated by the firmware, if narrower than those of the law.
        steps: whether all its gains are whole numbers.
    """

    name: str
    version: str
    laws: tuple[str, ...]
    suffix: str
    written: Callable[[Entry, float], str]
    new: Callable[[Mapping[str, float], str], str]
    renames: tuple[versions.Rename, ...]
    families: re.Pattern[str]
    advised: ranges.Ranges = field(default_factory=dict)
    steps: bool = False

    def law_name(self, name: str) -> str:
        """Return the name of a parameter in the law."""
        return name.replace(".", "_", 1) if self.name == "crazyflie" else name

    def file_name(self, name: str) -> str:
        """Return the name of a parameter of the law in the firmware."""
        if self.name != "crazyflie":
            return name
        match = _GROUP.match(name)
        return f"{match[1]}.{match[2]}" if match else name

    def rows(self, law: Controller) -> tuple[Parameter, ...]:
        """Return the parameters of a law that the firmware has."""
        return tuple(row for row in law.parameters if self.has(row.name))

    def has(self, name: str) -> bool:
        """Return whether the firmware has a parameter of a law, not only the workbench."""
        return name not in _COMMON and not _BENCH.fullmatch(name)

    def to_law(self, values: Mapping[str, float], version: str) -> dict[str, float]:
        """Return the values of a file by the names and in the scales of the law.

        Args:
            values: by the names of the file.
            version: of the file; "" for that of the law.
        """
        known = {self.law_name(name): value for name, value in values.items()}
        if self.name == "betaflight" and versions.numbers_of(version) < versions.PEAK_BEFORE:
            known = versions.d_of_today(known)
        return versions.with_new_names(known, self.renames)[0]

    def to_file(self, values: Mapping[str, float], version: str) -> dict[str, float]:
        """Return the values of a law by the names and in the scales of a version."""
        numbers = versions.numbers_of(version)
        found = dict(values)
        if self.name == "betaflight" and numbers < versions.PEAK_BEFORE:
            found = versions.d_of_before(found)
        found = versions.with_old_names(found, self.renames, numbers)
        return {self.file_name(name): value for name, value in found.items()}


_GROUP = re.compile(r"(pid_rate|pid_attitude|velCtlPid|posCtlPid|ctrlMel)_(.+)")
PX4 = Firmware(
    "px4",
    "1.16",
    ("px4",),
    ".params",
    formats.px4_value,
    formats.new_px4_file,
    versions.PX4,
    re.compile(r"MC_|MPC_|THR_MDL|IMU_D?GYRO_"),
    ranges.PX4,
)
ARDUPILOT = Firmware(
    "ardupilot",
    "4.7",
    ("ardupilot",),
    ".param",
    formats.ardupilot_value,
    formats.new_ardupilot_file,
    versions.ARDUPILOT,
    re.compile(r"ATC_|PSC_|MOT_|INS_GYRO_FILTER|ANGLE_MAX"),
    ranges.ARDUPILOT,
)
BETAFLIGHT = Firmware(
    "betaflight",
    "4.6.0",
    ("betaflight", "betaflight-sitl"),
    ".txt",
    formats.betaflight_value,
    formats.new_betaflight_file,
    (),
    re.compile(
        r"[pidfs]_(max_|min_)?(roll|pitch|yaw)|.*(dterm|gyro_lpf|tpa_|iterm|anti_gravity).*"
    ),
    steps=True,
)
CRAZYFLIE = Firmware(
    "crazyflie",
    "2025.12",
    ("crazyflie", "mellinger"),
    ".yaml",
    formats.crazyflie_value,
    formats.new_crazyflie_file,
    (),
    re.compile(r"(pid_rate|pid_attitude|velCtlPid|posCtlPid|ctrlMel)\."),
)
FIRMWARES = (PX4, ARDUPILOT, BETAFLIGHT, CRAZYFLIE)
_CRAZYFLIE_LINE = re.compile(r"[ \t{,]*[\"']?[A-Za-z]\w*\.\w+[\"']?[ \t]*:.*")
_MOST_LINES = 5000
"""Largest number of lines used to detect the format of a file."""


def find_firmware(name: str) -> Firmware:
    """Return a firmware by name.

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
        firmware: its name; without it the text tells.
        profile: of Betaflight's file, which one counts.

    Raises:
        WorkbenchError: if it is invalid, with the line.
    """
    text = read_text(path)
    counts = _matching_lines(text)
    chosen = find_firmware(firmware) if firmware else max(FIRMWARES, key=lambda f: counts[f.name])
    if profile is not None and chosen is not BETAFLIGHT:
        raise WorkbenchError("--profile is of Betaflight's files: leave it out")
    if not firmware and not any(counts.values()):
        raise WorkbenchError(
            f"{path}: is not a parameter file of {joined([f.name for f in FIRMWARES])}: expected "
            "lines as '1 1 MC_ROLL_P 6.5 9', 'ATC_ANG_RLL_P,4.5', 'set p_roll = 45' or "
            "'pid_rate.roll_kp: 250'"
        )
    if chosen is ARDUPILOT:
        return chosen, formats.read_ardupilot_param(path, text)
    if chosen is BETAFLIGHT:
        return chosen, formats.read_betaflight_cli(path, text, profile)
    if chosen is CRAZYFLIE:
        return chosen, formats.read_crazyflie_parameters(path, text)
    scripted = counts["script"] and not counts["params"]
    read = formats.read_px4_script if scripted else formats.read_px4_params
    return chosen, read(path, text)


def _matching_lines(text: str) -> dict[str, int]:
    """Return the number of lines of a text that match each firmware."""
    counts = dict.fromkeys([*(each.name for each in FIRMWARES), "script", "params"], 0)
    for number, _, line in lines_of(text):
        if number > _MOST_LINES:
            break
        counts["params"] += formats.PX4_LINE.fullmatch(line) is not None
        counts["script"] += formats.PX4_SCRIPT_LINE.match(line) is not None
        counts["betaflight"] += formats.BETAFLIGHT_LINE.fullmatch(line) is not None
        counts["ardupilot"] += formats.ARDUPILOT_LINE.fullmatch(line.lstrip("\ufeff")) is not None
        counts["crazyflie"] += _CRAZYFLIE_LINE.match(line) is not None
    counts["px4"] = counts["params"] + counts["script"]
    return counts


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
