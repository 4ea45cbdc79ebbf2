"""The user's preferences: their table, and their values, stored between starts.

Each row of the table is a line of the Settings screen.
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

from PyQt6.QtCore import QObject, QSettings, pyqtSignal

from workbench.common.errors import WorkbenchError, find_row, unknown_name

PreferenceValue = float | bool | str


@dataclass(frozen=True)
class Preference:
    """One preference; its kind follows from the default.

    Attributes:
        name: unique name.
        group: its heading.
        label: name in words.
        default: a number, a switch or a text.
        help: what it does, as a sentence.
        unit: SI unit of a number.
        minimum: minimum of a number.
        maximum: maximum of a number.
        choices: allowed texts; empty if any text is allowed.
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
        """Return a value if it is valid.

        Raises:
            WorkbenchError: if it is not valid.
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
        """Return the stored value, which a settings file may have turned into text.

        Raises:
            WorkbenchError: if it is not valid.
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
        "Light, dark, or as on the desktop.",
        choices=("system", "light", "dark"),
    ),
    Preference(
        "angle_unit",
        UNITS,
        "Angles",
        "degree",
        "Units of angles and yaw rates on screens; files keep radians.",
        choices=("degree", "radian"),
    ),
    Preference(
        "speed_unit",
        UNITS,
        "Speeds",
        "m/s",
        "Units of speeds on screens; files keep metres per second.",
        choices=("m/s", "km/h"),
    ),
    _number(
        "stick_speed",
        STICKS,
        "Speed at full stick",
        8.0,
        (0.1, 20.0),
        "m/s",
        "Horizontal and climb speed that a full stick commands; the flight's limits apply, too.",
    ),
    _number(
        "stick_yaw_rate",
        STICKS,
        "Turning rate at full stick",
        0.4,
        (0.05, 6.0),
        "rad/s",
        "Yaw rate that a full stick commands.",
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
        "Share of the travel around the middle that commands nothing; full stick stays full.",
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
        "Whether a moved slider flies at once, or only after Enter.",
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
    """Return the row with a name.

    Raises:
        WorkbenchError: if there is none.
    """
    return find_row("preference", name, PREFERENCES)


GROUP = "preferences"


class Preferences(QObject):
    """Values of all preferences.

    Args:
        store: storage of the values.
    """

    changed = pyqtSignal(str)
    """Name of a preference whose value has changed."""

    def __init__(self, store: QSettings | None = None) -> None:
        super().__init__()
        self.store = store or QSettings()
        self._values: dict[str, PreferenceValue] = {}

    def number(self, name: str) -> float:
        """Return the value of a number, in SI units."""
        return float(self.value(name))

    def text(self, name: str) -> str:
        """Return the value of a text or a choice."""
        return str(self.value(name))

    def switch(self, name: str) -> bool:
        """Return whether a switch is on."""
        return bool(self.value(name))

    def value(self, name: str) -> PreferenceValue:
        """Return a value; it is cached, because reading the store is slow."""
        if name not in self._values:
            self._values[name] = self._read(find_preference(name))
        return self._values[name]

    def set(self, name: str, value: PreferenceValue) -> None:
        """Set a preference.

        Raises:
            WorkbenchError: if the value is not valid.
        """
        row = find_preference(name)
        value = row.check(value)
        if value != self.value(name):
            self.store.setValue(f"{GROUP}/{name}", value)
            self._values[name] = value
            self.changed.emit(name)

    def reset(self, name: str) -> None:
        """Restore a preference's default."""
        self.set(name, find_preference(name).default)

    def _read(self, row: Preference) -> PreferenceValue:
        """Return the stored value, or the default without a valid one."""
        kept = self.store.value(f"{GROUP}/{row.name}", row.default)
        try:
            return row.read(kept)
        except WorkbenchError:  # written by another version or an editor
            return row.default


def log_folder(preferences: Preferences) -> Path:
    """Return the preferred folder for logs, or else the folder in which the app was started."""
    chosen = preferences.text("log_folder")
    return Path(chosen).expanduser() if chosen else Path.cwd()
