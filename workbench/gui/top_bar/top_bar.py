"""The top bar: buttons in one row, and how the flight does in another."""

from collections.abc import Mapping

from PyQt6.QtCore import QSize, Qt
from PyQt6.QtGui import QAction, QResizeEvent
from PyQt6.QtWidgets import (
    QFrame,
    QHBoxLayout,
    QLabel,
    QSizePolicy,
    QToolButton,
    QVBoxLayout,
    QWidget,
)

from workbench.gui.actions import find_row
from workbench.gui.flight_control import FlightControl
from workbench.gui.icons import icon
from workbench.gui.recorder import Recorder
from workbench.gui.style import dressed
from workbench.gui.top_bar.mode_badge import ModeBadge
from workbench.gui.top_bar.speed_box import SpeedBox
from workbench.gui.top_bar.status_strip import StatusStrip
from workbench.gui.top_bar.wording import BAD, Said
from workbench.gui.workspace import Workspace
from workbench.live.view import LiveView

ICON = 18
FLYING = ("arm", "take_off", "hold", "land", "stop")
HOLDING = ("pause", "step", "reset")
SHORTENED = (("record",), ("arm", "take_off", "hold", "land"))
"""Buttons that have their picture alone where there is no room for their words; STOP keeps its."""
DISABLED = "line"
"""Colour of a picture on a button that has no effect now."""


class TopBar(QFrame):
    """What flies, how it does, and what can be asked of it; on every screen.

    Args:
        workspace: whose flight is shown.
        actions: of the table, by name.
        control: gives the flight its orders.
        recorder: the Record button's model.
        parent: in which it stands.
    """

    def __init__(
        self,
        workspace: Workspace,
        actions: Mapping[str, QAction],
        control: FlightControl,
        recorder: Recorder,
        parent: QWidget | None = None,
    ) -> None:
        super().__init__(parent)
        self.setObjectName("top_bar")
        self.setAccessibleName("Flight")
        self.setSizePolicy(QSizePolicy.Policy.Preferred, QSizePolicy.Policy.Fixed)
        self._look, self._actions, self._recorder = workspace.look, actions, recorder
        self.badge = ModeBadge(workspace.look)
        self.speed = SpeedBox()
        self.speed.edited.connect(control.set_speed)
        self.strip = StatusStrip(workspace.look)
        self._buttons: dict[str, QToolButton] = {}
        self._lay_out()
        workspace.look.changed.connect(self._draw)
        recorder.changed.connect(self._show_recording)
        workspace.flight.viewed.connect(self.show_view)
        workspace.flight.opening.connect(self.strip.show_opening)
        self._draw()
        self._show_recording()
        self.show_view(workspace.flight.view)

    def button(self, name: str) -> QToolButton:
        """Return the button of an action."""
        return self._buttons[name]

    def show_view(self, view: LiveView) -> None:
        """Show the present."""
        self.badge.show_view(view)
        self.strip.show_view(view)
        if view.pace is not None:
            self.speed.show_factor(view.pace.asked)

    def resizeEvent(self, event: QResizeEvent | None) -> None:
        """Show as many words as there is room for."""
        super().resizeEvent(event)
        self._fit()

    def minimumSizeHint(self) -> QSize:
        """Return the height of both rows; what is too wide is shortened."""
        return QSize(0, super().minimumSizeHint().height())

    def _fit(self) -> None:
        """Shorten one group after the other, until all has room."""
        for shortened in range(len(SHORTENED) + 1):
            for index, names in enumerate(SHORTENED):
                for name in names:
                    self._show_words(name, index >= shortened)
            self._speed_label.setVisible(shortened < len(SHORTENED))
            if self._row.minimumSize().width() <= self.width():
                return

    def _show_words(self, name: str, shown: bool) -> None:
        styles = Qt.ToolButtonStyle
        style = styles.ToolButtonTextBesideIcon if shown else styles.ToolButtonIconOnly
        if self._buttons[name].toolButtonStyle() is not style:
            self._buttons[name].setToolButtonStyle(style)

    def _show_recording(self) -> None:
        recorder = self._recorder
        self.strip.recording.setVisible(recorder.is_recording)
        if recorder.is_recording:
            said = Said(recorder.said(), "record", BAD, recorder.path)
            self.strip.recording.show_said(said)
        self._draw_button("record", "recording" if recorder.is_recording else "record")
        self._actions["record"].setIconText("Stop" if recorder.is_recording else "Record")
        self._fit()

    def _draw(self) -> None:
        """Draw the pictures in the present colours."""
        for name in self._buttons:
            self._draw_button(name, find_row(name).icon)
        self._show_recording()

    def _draw_button(self, name: str, shape: str) -> None:
        colour = {"stop": "on_accent", "record": "bad"}.get(name, "ink")
        made = icon(shape, self._look.colour(colour), self._look.colour(DISABLED))
        self._actions[name].setIcon(made)

    def _lay_out(self) -> None:
        row = self._row = QHBoxLayout()
        row.setContentsMargins(10, 8, 10, 5)
        row.setSpacing(6)
        row.addWidget(self.badge)
        row.addSpacing(6)
        for name in FLYING:
            row.addWidget(self._make_button(name, with_text=True))
        self._buttons["stop"].setProperty("class", "danger")
        self._buttons["stop"].setFocusPolicy(Qt.FocusPolicy.NoFocus)  # its key is F12, and no other
        row.addSpacing(10)
        for name in HOLDING:
            row.addWidget(self._make_button(name, with_text=False))
        row.addSpacing(10)
        label = self._speed_label = dressed(QLabel("Sp&eed"), "muted")
        label.setBuddy(self.speed)
        row.addWidget(label)
        row.addWidget(self.speed)
        row.addStretch(1)
        row.addWidget(self._make_button("record", with_text=True))
        row.addWidget(self._make_button("screenshot", with_text=False))
        row.addWidget(self._make_button("view_3d", with_text=False))
        layout = QVBoxLayout(self)
        layout.setContentsMargins(0, 0, 0, 0)
        layout.setSpacing(0)
        layout.addLayout(row)
        layout.addWidget(self.strip)

    def _make_button(self, name: str, *, with_text: bool) -> QToolButton:
        action, row = self._actions[name], find_row(name)
        button = QToolButton(self)
        button.setDefaultAction(action)
        button.setIconSize(QSize(ICON, ICON))
        button.setFocusPolicy(Qt.FocusPolicy.StrongFocus)
        button.setSizePolicy(QSizePolicy.Policy.Minimum, QSizePolicy.Policy.Fixed)
        keys = f", {row.shortcut}" if row.shortcut else ""
        button.setAccessibleName(f"{row.label}{keys}")
        style = Qt.ToolButtonStyle
        button.setToolButtonStyle(
            style.ToolButtonTextBesideIcon if with_text else style.ToolButtonIconOnly
        )
        if not with_text:
            button.setProperty("class", "compact")
        self._buttons[name] = button
        return button
