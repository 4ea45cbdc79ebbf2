"""The Settings screen: preferences, limits of the flight, and its set-up."""

from collections.abc import Sequence
from functools import partial
from itertools import groupby

from PyQt6.QtCore import Qt
from PyQt6.QtWidgets import (
    QFrame,
    QLineEdit,
    QWidget,
)

from workbench.gui.errands import FutureCallbacks
from workbench.gui.first_flight import last_setup, save_setup
from workbench.gui.help import help_card
from workbench.gui.key_table import KEY_ROWS
from workbench.gui.keys_page import KeysPage
from workbench.gui.labels import Label
from workbench.gui.layout import (
    LayoutPart,
    button,
    hbox,
    label,
    named,
    scroll_area,
    vbox,
)
from workbench.gui.preferences import PREFERENCES
from workbench.gui.screens import Screen
from workbench.gui.settings.flight_form import FlightForm
from workbench.gui.settings.limit_row import limit_rows
from workbench.gui.settings.setting_row import PreferenceRow, SettingRow
from workbench.gui.signals import parameter_changes
from workbench.gui.workspace import Workspace
from workbench.link.backplane import Published
from workbench.live.view import LiveView
from workbench.plant.vehicle import Vehicle
from workbench.scenario.scenario import Scenario

MAX_SETTINGS_WIDTH_PX = 900
"""Largest width: longer lines are hard to follow [px]."""


class SettingsScreen(Screen):
    """All settings other than gains, made from tables and searchable."""

    def __init__(self, workspace: Workspace) -> None:
        super().__init__(workspace)
        self._answers = FutureCallbacks(workspace.notices.warn, self)
        self._search = named(QLineEdit(), "Search settings")
        self._search.setPlaceholderText("Search settings")
        self._search.setClearButtonEnabled(True)
        self._search.textChanged.connect(self._find)
        self._none = Label("No setting matches.")
        self._none.hide()
        self._to_keep: Scenario | None = None
        self._vehicle: Vehicle | None = None
        self._limits = limit_rows(workspace)
        self._form = FlightForm()
        self._form.edited.connect(self._show_edited)
        self._fly = button("Fly with these", self._begin_flight, "primary")
        self._fly.setAccessibleDescription("Ends the present flight and starts another")
        self._groups: list[tuple[QFrame, Sequence[SettingRow]]] = []
        for heading, rows in groupby(PREFERENCES, lambda row: row.group):
            self._add_group(heading, [PreferenceRow(workspace, row) for row in rows])
        help = "Which key does what, from take off to stop."
        self._keys_row = SettingRow("Keys", help, button("Keys…", self._open_keys))
        self._keys_row.reset.clicked.connect(workspace.keys.reset)
        self._add_group("Keys", [self._keys_row])
        note = "They take effect at once, and are saved for each vehicle."
        self._add_group("Limits", self._limits, note)
        note = "Another flight starts with these settings."
        fly = (self._fly, Qt.AlignmentFlag.AlignRight)
        self._add_group("The flight", self._form.rows, note, fly)
        workspace.flight.streamed.connect(self._follow)
        workspace.keys.changed.connect(self._mark_keys)
        self._mark_keys()
        self._lay_out()
        self._show_edited()

    def begin(self, view: LiveView) -> None:
        """Show the present flight, and set the limits stored for it."""
        self._form.begin(view)
        if self._to_keep is not None and view.scenario == self._to_keep:  # it can be flown
            path = last_setup(self.workspace.preferences.store)
            keep = partial(save_setup, path, self._to_keep)
            self._answers.expect(self.workspace.errands.run(keep))
            self._to_keep = None
        vehicle = view.vehicle.name if view.vehicle else ""
        kept = [row.name for row in self._limits if row.begin(vehicle, view.values)]
        anew, self._vehicle = view.vehicle is not self._vehicle, view.vehicle
        if kept and anew:
            names = ", ".join(kept)
            self.workspace.notices.inform(f"Your limits from last time apply again: {names}.")

    def _follow(self, published: list[Published]) -> None:
        """Follow limits that others change."""
        for _, name, value in parameter_changes(published):
            for row in self._limits:
                if row.name == name:
                    row.show_value(value)

    def _open_keys(self) -> None:
        KeysPage(self.workspace.keys, self.window()).show()

    def _mark_keys(self, _: str = "") -> None:
        keys = self.workspace.keys
        self._keys_row.mark(not all(keys.is_default(row.name) for row in KEY_ROWS))

    def _add_group(
        self, heading: str, rows: Sequence[SettingRow], note: str = "", *below: LayoutPart
    ) -> None:
        """Add a card with settings under one heading."""
        notes = [label(note, "muted", wraps=True)] if note else []
        parts = (label(heading, "heading"), *notes, *rows, *below)
        self._groups.append((help_card(f"Settings: {heading}", *parts, margins=None), rows))

    def _lay_out(self) -> None:
        page = QWidget()
        cards = (card for card, _ in self._groups)
        vbox(*cards, self._none, 1, of=page, margins=(8, 0, 8, 8), spacing=12)
        page.setMaximumWidth(MAX_SETTINGS_WIDTH_PX)
        area = scroll_area(page)
        area.setFocusPolicy(Qt.FocusPolicy.StrongFocus)  # for keys that scroll
        area.setAlignment(Qt.AlignmentFlag.AlignHCenter)
        self._search.setMaximumWidth(MAX_SETTINGS_WIDTH_PX - 16)
        # aligned with the cards below
        top = hbox(1, (self._search, 1000), 1, margins=(8, 0, 16, 0))
        vbox(top, (area, 1), of=self, margins=(0, 8, 0, 0))

    def _find(self, wanted: str) -> None:
        """Show the rows that contain all words."""
        for card, rows in self._groups:
            for row in rows:
                row.setVisible(row.matches(wanted))
            card.setVisible(any(row.matches(wanted) for row in rows))
        self._none.setVisible(all(card.isHidden() for card, _ in self._groups))

    def _show_edited(self) -> None:
        self._fly.setEnabled(self._form.is_changed)

    def _begin_flight(self) -> None:
        scenario = self._form.scenario()
        draw = self.workspace.preferences.switch("draw_3d")
        self._to_keep = scenario
        self.workspace.flight.fly(scenario, draw=draw)
