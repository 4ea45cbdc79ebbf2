"""A row of the Settings screen for each live limit of a flight, out of the parameter table."""

from collections.abc import Mapping

from workbench.gui.settings.controls import NumberBox
from workbench.gui.settings.row import Row
from workbench.gui.workspace import Workspace
from workbench.scenario.parameters import Parameter, find_parameter

LIMITS = (
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
"""Parameters that bound what a flight does; the gains have a screen of their own."""
GROUP = "limits"


class LimitRow(Row):
    """One limit of what flies; a value set here is kept, and set again in later flights.

    Args:
        workspace: of the flight.
        parameter: its row of the table.
    """

    def __init__(self, workspace: Workspace, parameter: Parameter) -> None:
        self._workspace, self._parameter = workspace, parameter
        label = words(parameter.name)
        self._box = NumberBox(
            workspace.preferences,
            parameter.unit,
            parameter.minimum,
            parameter.maximum,
            label,
            self._set,
        )
        super().__init__(label, f"{parameter.help[0].upper()}{parameter.help[1:]}.", self._box)
        self.reset.clicked.connect(self._forget)
        self._start = parameter.default
        self._vehicle = ""
        self.setEnabled(False)
        self.mark(False)

    def begin(self, vehicle: str, values: Mapping[str, float]) -> bool:
        """Take note of a new flight; return whether a kept value was set.

        Args:
            vehicle: that flies; limits are kept for each by itself.
            values: of its parameters at the start.
        """
        name = self._parameter.name
        self._vehicle = vehicle
        self.setEnabled(name in values)
        if name not in values:
            return False
        self._start = values[name]
        kept = self._workspace.preferences.store.value(self._key)
        value = self._start if kept is None else _number(kept, self._parameter, self._start)
        self.show_value(value)
        if value != self._start:
            self._order(value)
        return value != self._start

    def show_value(self, value: float) -> None:
        """Show what is flown."""
        self._box.show_value(value)
        self.mark(abs(value - self._start) > 1e-9 * max(1.0, abs(self._start)))

    @property
    def name(self) -> str:
        """Of the parameter."""
        return self._parameter.name

    @property
    def _key(self) -> str:
        return f"{GROUP}/{self._vehicle}/{self._parameter.name}"

    def _set(self, value: float) -> None:
        self._workspace.preferences.store.setValue(self._key, value)
        self._order(value)

    def _forget(self) -> None:
        self._workspace.preferences.store.remove(self._key)
        self._order(self._start)

    def _order(self, value: float) -> None:
        name = self._parameter.name
        self._workspace.flight.order(
            lambda live: live.set(name, value), lambda _: self.show_value(value)
        )


def limit_rows(workspace: Workspace) -> list[LimitRow]:
    """Return a row for every limit."""
    return [LimitRow(workspace, find_parameter(name)) for name in LIMITS]


def words(name: str) -> str:
    """Return a parameter's name in words, as Max climb rate."""
    return name.replace("_", " ").capitalize()


def _number(kept: object, parameter: Parameter, otherwise: float) -> float:
    """Return a number that was kept, unless that is no good any more."""
    try:
        value = float(str(kept))
    except ValueError:
        return otherwise
    return value if parameter.minimum <= value <= parameter.maximum else otherwise
