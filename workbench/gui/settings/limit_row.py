"""The rows of the flight's limits, which are stored for later flights."""

from collections.abc import Mapping

from workbench.common.parameter import Parameter
from workbench.control.controller_file import load_controller
from workbench.gui.settings.setting_field import NumberBox
from workbench.gui.settings.setting_row import SettingRow
from workbench.gui.workspace import Workspace
from workbench.scenario.scenario import Action

LIMIT_SETTINGS = (
    "max_speed",
    "max_climb_rate",
    "max_height",
    "max_tilt",
    "max_yaw_rate",
    "take_off_speed",
    "landing_speed",
    "battery_reserve",
    "obstacle_brake",
    "stop_distance",
    "warning_distance",
)
"""Parameters that limit a flight; gains are on the tuning screen."""
LIMITS_SETTINGS_GROUP = "limits"


class LimitRow(SettingRow):
    """One limit of the flight; a value set here is stored, and set again in later flights.

    Args:
        workspace: the flight's workspace.
        parameter: the parameter's row of the table.
    """

    def __init__(self, workspace: Workspace, parameter: Parameter) -> None:
        self._workspace, self._parameter = workspace, parameter
        label = parameter.name.replace("_", " ").capitalize()
        self._box = NumberBox(workspace.preferences, parameter, self._set, label)
        super().__init__(label, f"{parameter.help[0].upper()}{parameter.help[1:]}.", self._box)
        self.reset.clicked.connect(self._forget)
        self._start = parameter.default
        self._vehicle = ""
        self.setEnabled(False)
        self.mark(False)

    def begin(self, vehicle: str, values: Mapping[str, float]) -> bool:
        """Note a new flight; return whether a stored value was set.

        Args:
            vehicle: the flying vehicle; limits are stored for each vehicle.
            values: initial parameter values.
        """
        name = self._parameter.name
        self._vehicle = vehicle
        self.setEnabled(name in values)
        if name not in values:
            return False
        self._start = values[name]
        kept = self._workspace.preferences.store.value(self._key)
        value = self._start if kept is None else _stored_number(kept, self._parameter, self._start)
        self.show_value(value)
        if value != self._start:
            self._order(value)
        return value != self._start

    def show_value(self, value: float) -> None:
        """Show the present value."""
        self._box.show_value(value)
        self.mark(abs(value - self._start) > 1e-9 * max(1.0, abs(self._start)))

    @property
    def name(self) -> str:
        """Name of the parameter."""
        return self._parameter.name

    @property
    def _key(self) -> str:
        return f"{LIMITS_SETTINGS_GROUP}/{self._vehicle}/{self._parameter.name}"

    def _set(self, value: float) -> None:
        self._workspace.preferences.store.setValue(self._key, value)
        self._order(value)

    def _forget(self) -> None:
        self._workspace.preferences.store.remove(self._key)
        self._order(self._start)

    def _order(self, value: float) -> None:
        name = self._parameter.name
        self._workspace.flight.do(Action(set={name: value}), lambda _: self.show_value(value))


def limit_rows(workspace: Workspace) -> list[LimitRow]:
    """Return a row for every limit."""
    return [LimitRow(workspace, load_controller().table.find(name)) for name in LIMIT_SETTINGS]


def _stored_number(kept: object, parameter: Parameter, otherwise: float) -> float:
    """Return a stored number if it is still valid."""
    try:
        value = float(str(kept))
    except ValueError:
        return otherwise
    return value if parameter.minimum <= value <= parameter.maximum else otherwise
