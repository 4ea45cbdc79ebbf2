"""The Settings screen: what the user prefers, what bounds the flight, and what it is built from."""

from collections.abc import Sequence
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

from workbench.gui.preference_table import PREFERENCES
from workbench.gui.screen import Screen
from workbench.gui.settings.flight_form import FlightForm
from workbench.gui.settings.limit_rows import limit_rows
from workbench.gui.settings.preference_rows import PreferenceRow
from workbench.gui.settings.row import Row
from workbench.gui.workspace import Workspace
from workbench.live.view import LiveView

WIDEST = 900
"""Lines longer than this are hard to follow [px]."""


class Group(QFrame):
    """Settings under one heading."""

    def __init__(self, heading: str, rows: Sequence[Row], note: str = "") -> None:
        super().__init__()
        self.setProperty("class", "card")
        self.rows = rows
        layout = QVBoxLayout(self)
        title = QLabel(heading)
        title.setProperty("class", "heading")
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
        self._search = QLineEdit()
        self._search.setPlaceholderText("Search settings")
        self._search.setAccessibleName("Search settings")
        self._search.setClearButtonEnabled(True)
        self._search.textChanged.connect(self._find)
        self._none = QLabel("No setting has these words.")
        self._none.hide()
        self._limits = limit_rows(workspace)
        self._form = FlightForm()
        self._form.edited.connect(self._show_edited)
        self._fly = QPushButton("Fly with these")
        self._fly.setProperty("class", "primary")
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
        self._lay_out()
        self._show_edited()

    def begin(self, view: LiveView) -> None:
        """Show what flies, and set the limits that were kept for it."""
        self._form.begin(view)
        vehicle = view.vehicle.name if view.vehicle else ""
        kept = [row.name for row in self._limits if row.begin(vehicle, view.values)]
        if kept:
            names = ", ".join(kept)
            self.workspace.notices.inform(f"Your limits from last time hold again: {names}.")

    def show_view(self, view: LiveView) -> None:
        """Follow parameters that others change."""
        said = self.workspace.signals.newest("parameters")
        for row in self._limits:
            if said and said.get("name") == row.name:
                row.show_value(float(said["value"]))  # type: ignore[arg-type]

    def _lay_out(self) -> None:
        column = QWidget()
        inside = QVBoxLayout(column)
        inside.setContentsMargins(0, 0, 8, 8)
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
        self._search.setMaximumWidth(WIDEST)
        top.addWidget(self._search)
        layout = QVBoxLayout(self)
        layout.addLayout(top)
        layout.addWidget(area, 1)

    def _find(self, wanted: str) -> None:
        found = sum([group.show_matching(wanted) for group in self._groups])
        self._none.setVisible(not found)

    def _show_edited(self) -> None:
        self._fly.setEnabled(self._form.is_changed)

    def _begin_flight(self) -> None:
        draw = self.workspace.preferences.switch("draw_3d")
        self.workspace.flight.fly(self._form.scenario(), draw=draw)
