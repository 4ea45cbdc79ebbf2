"""The table of preferences: a row makes a line of the Settings screen and a value that is kept."""

import math
from collections.abc import Sequence
from dataclasses import dataclass

from workbench.common.errors import WorkbenchError, find_row, unknown_name

PreferenceValue = float | bool | str


@dataclass(frozen=True)
class Preference:
    """One thing that a user may prefer otherwise; its kind follows from the default.

    Attributes:
        name: unique.
        group: heading under which it stands.
        label: in words.
        default: a number, a switch or a text.
        help: what it does, a sentence.
        unit: SI, of a number.
        minimum: of a number.
        maximum: of a number.
        choices: that a text may be; empty where it may be any.
        folder: whether the text is a folder's path.
    """

    name: str
    group: str
    label: str
    default: PreferenceValue
    help: str
    unit: str = ""
    minimum: float = -math.inf
    maximum: float = math.inf
    choices: Sequence[str] = ()
    folder: bool = False

    def check(self, value: PreferenceValue) -> PreferenceValue:
        """Return a value that may be kept.

        Raises:
            WorkbenchError: if it may not.
        """
        if isinstance(self.default, bool):
            return bool(value)
        if isinstance(self.default, str):
            if self.choices and value not in self.choices:
                raise unknown_name(self.label.lower(), str(value), list(self.choices))
            return str(value)
        number = float(value)
        if not self.minimum <= number <= self.maximum:
            raise WorkbenchError(
                f"{self.label} is {number:g} {self.unit}: keep it within "
                f"{self.minimum:g} .. {self.maximum:g}"
            )
        return number

    def read(self, kept: object) -> PreferenceValue:
        """Return the value that was kept, which a settings file may have made a text.

        Raises:
            WorkbenchError: if it is none.
        """
        if isinstance(self.default, bool):
            return str(kept).lower() in ("true", "1")
        try:
            return self.check(str(kept) if isinstance(self.default, str) else float(str(kept)))
        except ValueError:
            raise WorkbenchError(f"{self.label} was kept as '{kept}'") from None


def _number(
    name: str,
    group: str,
    label: str,
    default: float,
    limits: tuple[float, float],
    unit: str,
    help: str,
) -> Preference:
    return Preference(name, group, label, default, help, unit, *limits)


LOOKS = "Appearance"
UNITS = "Units shown"
STICKS = "Sticks"
CHARTS = "Charts"
TUNING = "Tuning"
FILES = "Files"
FLIGHT = "Flight"

PREFERENCES: tuple[Preference, ...] = (
    Preference(
        "theme",
        LOOKS,
        "Theme",
        "system",
        "Light or dark, or as the desktop is.",
        choices=("system", "light", "dark"),
    ),
    Preference(
        "angle_unit",
        UNITS,
        "Angles",
        "degree",
        "How angles and turning rates are shown; files keep radians.",
        choices=("degree", "radian"),
    ),
    Preference(
        "speed_unit",
        UNITS,
        "Speeds",
        "m/s",
        "How speeds are shown; files keep metres per second.",
        choices=("m/s", "km/h"),
    ),
    _number(
        "stick_speed",
        STICKS,
        "Speed at full stick",
        8.0,
        (0.1, 20.0),
        "m/s",
        "Level and climbing speed that a full stick asks for; the flight's limits hold besides.",
    ),
    _number(
        "stick_yaw_rate",
        STICKS,
        "Turning rate at full stick",
        0.4,
        (0.05, 6.0),
        "rad/s",
        "Yaw rate that a full stick asks for.",
    ),
    _number(
        "stick_sensitivity",
        STICKS,
        "Sensitivity",
        1.0,
        (0.1, 1.0),
        "1",
        "Share of the speed at full stick that is reached.",
    ),
    _number(
        "stick_expo",
        STICKS,
        "Expo",
        0.3,
        (0.0, 1.0),
        "1",
        "How much gentler a stick is around its middle; 0 is a straight line.",
    ),
    _number(
        "stick_dead_band",
        STICKS,
        "Dead band",
        0.05,
        (0.0, 0.5),
        "1",
        "Share of the way around the middle that asks for nothing; full stick stays full.",
    ),
    _number(
        "chart_seconds",
        CHARTS,
        "Time shown",
        20.0,
        (1.0, 180.0),
        "s",
        "How much of the past a chart shows.",
    ),
    Preference(
        "apply_gains",
        TUNING,
        "Apply gains",
        "at once",
        "Whether a moved slider flies at once, or is tried on paper until Enter.",
        choices=("at once", "on Enter"),
    ),
    Preference(
        "log_folder",
        FILES,
        "Folder for logs",
        "",
        "Where the Record button writes; empty for the folder the app was started in.",
        folder=True,
    ),
    Preference(
        "draw_3d",
        FLIGHT,
        "3-D view",
        True,
        "Whether flights are drawn in Meshcat; from the next flight on.",
    ),
)


def find_preference(name: str) -> Preference:
    """Return the row of a name.

    Raises:
        WorkbenchError: if there is none.
    """
    return find_row("preference", name, PREFERENCES)
