"""The Settings screen: what the user prefers, what bounds the flight, and what it is built from."""

import math
from collections.abc import Mapping, Sequence
from functools import partial
from itertools import groupby
from pathlib import Path

from PyQt6.QtCore import Qt
from PyQt6.QtWidgets import (
    QFrame,
    QHBoxLayout,
    QLabel,
    QLineEdit,
    QPushButton,
    QScrollArea,
    QVBoxLayout,
    QWidget,
)

from workbench.common.errors import WorkbenchError
from workbench.gui.answers import Answers
from workbench.gui.parameter_reader import ParameterReader
from workbench.gui.preference_table import PREFERENCES, Preference, PreferenceValue
from workbench.gui.screen import Screen
from workbench.gui.settings.controls import Choices, Folder, NumberBox, Switch
from workbench.gui.settings.flight_form import FlightForm
from workbench.gui.settings.last_setup import keep_setup, last_setup
from workbench.gui.settings.row import Row
from workbench.gui.style import dressed
from workbench.gui.workspace import Workspace
from workbench.link.backplane import Published
from workbench.live.view import LiveView
from workbench.plant.vehicle import Vehicle
from workbench.scenario.parameters import Parameter, parameter_table
from workbench.scenario.scenario import Scenario

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

WIDEST = 900
"""Lines longer than this are hard to follow [px]."""


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
    return [LimitRow(workspace, parameter_table().find(name)) for name in LIMITS]


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


class PreferenceRow(Row):
    """One preference, and what it is now.

    Args:
        workspace: where it is kept.
        preference: its row of the table.
    """

    def __init__(self, workspace: Workspace, preference: Preference) -> None:
        self.preference = preference
        self._preferences, self._notices = workspace.preferences, workspace.notices
        self._control = self._make(workspace)
        super().__init__(preference.label, preference.help, self._control)
        self.reset.clicked.connect(lambda: self._preferences.reset(preference.name))
        self._preferences.changed.connect(self._hear)
        self.show_present()

    def show_present(self) -> None:
        """Show what is preferred now."""
        name, default = self.preference.name, self.preference.default
        value: PreferenceValue
        if isinstance(self._control, Switch):
            value = self._preferences.switch(name)
            self._control.show_value(value)
        elif isinstance(self._control, NumberBox):
            value = self._preferences.number(name)
            self._control.show_value(value)
        else:
            value = self._preferences.text(name)
            self._control.show_value(value)
        self.mark(value != default)

    def _hear(self, name: str) -> None:
        if name == self.preference.name:
            self.show_present()

    def _make(self, workspace: Workspace) -> Switch | NumberBox | Choices | Folder:
        row, change = self.preference, self._set
        if isinstance(row.default, bool):
            return Switch(change)
        if isinstance(row.default, float):
            assert math.isfinite(row.maximum - row.minimum)
            preferences = workspace.preferences
            return NumberBox(preferences, row.unit, row.minimum, row.maximum, row.label, change)
        if row.choices:
            return Choices(row.choices, change)
        return Folder(row.label, str(Path.cwd()), change)

    def _set(self, value: PreferenceValue) -> None:
        if self.preference.folder and value and not Path(str(value)).is_dir():
            self._notices.warn(f"There is no folder {value}.", "Choose one that is there.")
            self.show_present()
            return
        try:
            self._preferences.set(self.preference.name, value)
        except WorkbenchError as error:
            self._notices.warn(str(error))
            self.show_present()


class Group(QFrame):
    """Settings under one heading."""

    def __init__(self, heading: str, rows: Sequence[Row], note: str = "") -> None:
        super().__init__()
        self.setProperty("class", "card")
        self.rows = rows
        layout = QVBoxLayout(self)
        title = dressed(QLabel(heading), "heading")
        layout.addWidget(title)
        if note:
            label = QLabel(note)
            label.setWordWrap(True)
            label.setProperty("class", "muted")
            layout.addWidget(label)
        for row in rows:
            layout.addWidget(row)

    def show_matching(self, wanted: str) -> int:
        """Show the rows that have all words, and return how many do."""
        found = [row for row in self.rows if row.matches(wanted)]
        for row in self.rows:
            row.setVisible(row in found)
        self.setVisible(bool(found))
        return len(found)


class SettingsScreen(Screen):
    """Everything that can be set besides gains, made of tables and searchable."""

    title = "Settings"
    icon = "settings"

    def __init__(self, workspace: Workspace, parent: QWidget | None = None) -> None:
        super().__init__(workspace, parent)
        self._answers = Answers(workspace.notices.warn, self)
        self._search = QLineEdit()
        self._search.setPlaceholderText("Search settings")
        self._search.setAccessibleName("Search settings")
        self._search.setClearButtonEnabled(True)
        self._search.textChanged.connect(self._find)
        self._none = QLabel("No setting has these words.")
        self._none.hide()
        self._to_keep: Scenario | None = None
        self._vehicle: Vehicle | None = None
        self._limits = limit_rows(workspace)
        self._reader = ParameterReader()
        self._form = FlightForm()
        self._form.edited.connect(self._show_edited)
        self._fly = dressed(QPushButton("Fly with these"), "primary")
        self._fly.setAccessibleDescription("Ends the present flight and begins another")
        self._fly.clicked.connect(self._begin_flight)
        self._groups = [
            *(
                Group(heading, [PreferenceRow(workspace, row) for row in rows])
                for heading, rows in groupby(PREFERENCES, lambda row: row.group)
            ),
            Group("Limits", self._limits, "They act at once, and are kept for each vehicle."),
            Group("The flight", self._form.rows, "Another flight begins with what is set here."),
        ]
        workspace.flight.streamed.connect(self._follow)
        self._lay_out()
        self._show_edited()

    def begin(self, view: LiveView) -> None:
        """Show what flies, and set the limits that were kept for it."""
        self._form.begin(view)
        self._reader.begin(view.topics)
        if self._to_keep is not None and view.scenario == self._to_keep:  # it can be flown
            path = last_setup(self.workspace.preferences.store)
            keep = partial(keep_setup, path, self._to_keep)
            self._answers.expect(self.workspace.errands.run(keep))
            self._to_keep = None
        vehicle = view.vehicle.name if view.vehicle else ""
        kept = [row.name for row in self._limits if row.begin(vehicle, view.values)]
        anew, self._vehicle = view.vehicle is not self._vehicle, view.vehicle
        if kept and anew:
            names = ", ".join(kept)
            self.workspace.notices.inform(f"Your limits from last time hold again: {names}.")

    def _follow(self, published: list[Published]) -> None:
        """Follow limits that others change."""
        for change in self._reader.read(published):
            for row in self._limits:
                if row.name == change.name:
                    row.show_value(change.value)

    def _lay_out(self) -> None:
        column = QWidget()
        inside = QVBoxLayout(column)
        inside.setContentsMargins(8, 0, 8, 8)
        inside.setSpacing(12)
        for group in self._groups:
            inside.addWidget(group)
        self._groups[-1].layout().addWidget(self._fly, 0, Qt.AlignmentFlag.AlignRight)  # type: ignore[union-attr, call-arg]
        inside.addWidget(self._none)
        inside.addStretch(1)
        column.setMaximumWidth(WIDEST)
        area = QScrollArea()
        area.setWidgetResizable(True)
        area.setFrameShape(QFrame.Shape.NoFrame)
        area.setAlignment(Qt.AlignmentFlag.AlignHCenter)
        area.setWidget(column)
        top = QHBoxLayout()
        top.setContentsMargins(8, 0, 16, 0)  # in line with the cards below
        self._search.setMaximumWidth(WIDEST - 16)
        top.addStretch(1)
        top.addWidget(self._search, 1000)
        top.addStretch(1)
        layout = QVBoxLayout(self)
        layout.setContentsMargins(0, 8, 0, 0)
        layout.addLayout(top)
        layout.addWidget(area, 1)

    def _find(self, wanted: str) -> None:
        found = sum([group.show_matching(wanted) for group in self._groups])
        self._none.setVisible(not found)

    def _show_edited(self) -> None:
        self._fly.setEnabled(self._form.is_changed)

    def _begin_flight(self) -> None:
        scenario = self._form.scenario()
        draw = self.workspace.preferences.switch("draw_3d")
        self._to_keep = scenario
        self.workspace.flight.fly(scenario, draw=draw)
