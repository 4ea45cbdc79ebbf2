"""The Settings screen: what the user prefers, what bounds the flight, and what it is built from."""

from collections.abc import Sequence
from functools import partial
from itertools import groupby

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

from workbench.gui.answers import Answers
from workbench.gui.parameter_reader import ParameterReader
from workbench.gui.preference_table import PREFERENCES
from workbench.gui.screen import Screen
from workbench.gui.settings.flight_form import FlightForm
from workbench.gui.settings.last_setup import keep_setup, last_setup
from workbench.gui.settings.limit_rows import limit_rows
from workbench.gui.settings.preference_rows import PreferenceRow
from workbench.gui.settings.row import Row
from workbench.gui.style import dressed
from workbench.gui.workspace import Workspace
from workbench.link.backplane import Published
from workbench.live.view import LiveView
from workbench.plant.vehicle import Vehicle
from workbench.scenario.scenario import Scenario

WIDEST = 900
"""Lines longer than this are hard to follow [px]."""


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
