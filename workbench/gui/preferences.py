"""The user's preferences: their table, and their values, stored between starts.

Each row of the table is a line of the Settings screen.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

from PyQt6.QtCore import QObject, QSettings, pyqtSignal

from workbench.common.errors import WorkbenchError, find_named_row, unknown_name
from workbench.common.quantity import Quantity

PreferenceValue = float | bool | str


@dataclass(frozen=True)
class Preference(Quantity):
    """One preference; its kind follows from the default.

    Attributes:
        label: name in words.
        group: its heading.
        default: a number, a switch or a text.
        choices: allowed texts; empty if any text is allowed.
        folder: whether the text is a folder's path.
    """

    label: str = ""
    group: str = ""
    default: PreferenceValue = ""
    choices: Sequence[str] = ()
    folder: bool = False

    @property
    def title(self) -> str:
        """Name in words."""
        return self.label

    def valid(self, value: PreferenceValue) -> PreferenceValue:
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
        return self.check(float(value))

    def read(self, kept: object) -> PreferenceValue:
        """Return the stored value, which a settings file may have turned into text.

        Raises:
            WorkbenchError: if it is not valid.
        """
        if isinstance(self.default, bool):
            return str(kept).lower() in ("true", "1")
        try:
            return self.valid(str(kept) if isinstance(self.default, str) else float(str(kept)))
        except ValueError:
            raise WorkbenchError(f"{self.label} was kept as '{kept}'") from None


APPEARANCE_GROUP = "Appearance"
UNITS_GROUP = "Units shown"
STICKS_GROUP = "Sticks"
CHARTS_GROUP = "Charts"
TUNING_GROUP = "Tuning"
FILES_GROUP = "Files"
FLIGHT_GROUP = "Flight"

PREFERENCES: tuple[Preference, ...] = (
    Preference(
        "theme",
        "",
        "Light, dark, or as on the desktop.",
        label="Theme",
        group=APPEARANCE_GROUP,
        default="system",
        choices=("system", "light", "dark"),
    ),
    Preference(
        "angle_unit",
        "",
        "Units of angles and yaw rates on screens; files keep radians.",
        label="Angles",
        group=UNITS_GROUP,
        default="degree",
        choices=("degree", "radian"),
    ),
    Preference(
        "speed_unit",
        "",
        "Units of speeds on screens; files keep metres per second.",
        label="Speeds",
        group=UNITS_GROUP,
        default="m/s",
        choices=("m/s", "km/h"),
    ),
    Preference(
        "stick_speed",
        "m/s",
        "Horizontal and climb speed that a full stick commands; the flight's limits apply, too.",
        0.1,
        20.0,
        "Speed at full stick",
        STICKS_GROUP,
        8.0,
    ),
    Preference(
        "stick_yaw_rate",
        "rad/s",
        "Yaw rate that a full stick commands.",
        0.05,
        6.0,
        "Turning rate at full stick",
        STICKS_GROUP,
        0.4,
    ),
    Preference(
        "stick_sensitivity",
        "1",
        "Share of the speed at full stick that is reached.",
        0.1,
        1.0,
        "Sensitivity",
        STICKS_GROUP,
        1.0,
    ),
    Preference(
        "stick_expo",
        "1",
        "How much gentler a stick is around its middle; 0 is a straight line.",
        0.0,
        1.0,
        "Expo",
        STICKS_GROUP,
        0.3,
    ),
    Preference(
        "stick_dead_band",
        "1",
        "Share of the travel around the middle that commands nothing; full stick stays full.",
        0.0,
        0.5,
        "Dead band",
        STICKS_GROUP,
        0.05,
    ),
    Preference(
        "chart_seconds",
        "s",
        "How much of the past a chart shows.",
        1.0,
        180.0,
        "Time shown",
        CHARTS_GROUP,
        20.0,
    ),
    Preference(
        "apply_gains",
        "",
        "Whether a moved slider flies at once, or only after Enter.",
        label="Apply gains",
        group=TUNING_GROUP,
        default="at once",
        choices=("at once", "on Enter"),
    ),
    Preference(
        "log_folder",
        "",
        "Where the Record button writes; empty for the folder the app was started in.",
        label="Folder for logs",
        group=FILES_GROUP,
        default="",
        folder=True,
    ),
    Preference(
        "draw_3d",
        "",
        "Whether flights are drawn in Meshcat; from the next flight on.",
        label="3-D view",
        group=FLIGHT_GROUP,
        default=True,
    ),
)


def find_preference(name: str) -> Preference:
    """Return the row with a name.

    Raises:
        WorkbenchError: if there is none.
    """
    return find_named_row("preference", name, PREFERENCES)


PREFERENCES_SETTINGS_GROUP = "preferences"


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
        value = row.valid(value)
        if value != self.value(name):
            self.store.setValue(f"{PREFERENCES_SETTINGS_GROUP}/{name}", value)
            self._values[name] = value
            self.changed.emit(name)

    def reset(self, name: str) -> None:
        """Restore a preference's default."""
        self.set(name, find_preference(name).default)

    def _read(self, row: Preference) -> PreferenceValue:
        """Return the stored value, or the default without a valid one."""
        kept = self.store.value(f"{PREFERENCES_SETTINGS_GROUP}/{row.name}", row.default)
        try:
            return row.read(kept)
        except WorkbenchError:  # written by another version or an editor
            return row.default


def log_folder(preferences: Preferences) -> Path:
    """Return the preferred folder for logs, or else the folder in which the app was started."""
    chosen = preferences.text("log_folder")
    return Path(chosen).expanduser() if chosen else Path.cwd()
