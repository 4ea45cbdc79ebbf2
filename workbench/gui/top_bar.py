"""The top bar: a row of buttons, and a row with the state of the flight."""

from bisect import bisect_left, bisect_right
from collections.abc import Mapping
from functools import partial

from PyQt6.QtCore import QEvent, QSize, Qt, QTimer
from PyQt6.QtGui import QAction, QResizeEvent, QShowEvent
from PyQt6.QtWidgets import (
    QFrame,
    QSizePolicy,
    QToolButton,
)

from workbench.common.quantity import DisplayUnit
from workbench.gui.actions import REAL_TIME_FACTORS, find_action
from workbench.gui.click_guard import ClickGuard
from workbench.gui.flight_control import FlightControl
from workbench.gui.icons import icon
from workbench.gui.labels import set_tip
from workbench.gui.layout import NO_MARGINS, buddy, fill, hbox, vbox
from workbench.gui.number_field import NumberField
from workbench.gui.recorder import LogRecorder
from workbench.gui.status_strip import Chip, StatusStrip
from workbench.gui.status_text import BAD_TONE, StatusText, mode_status
from workbench.gui.workspace import Workspace
from workbench.live.view import LiveView

MIN_REAL_TIME_FACTOR, MAX_REAL_TIME_FACTOR = 0.01, 20.0
"""Limits of the selectable speed."""
SPEED_WIDTH_DIGITS = 11
"""Width of the speed's text and arrows, in digits."""
MODE_WIDTH_DIGITS = 15
"""Width of the usual flight modes, in digits."""
TOP_BAR_ICON_PX = 18
FLYING_BUTTONS = ("arm", "take_off", "hold", "land", "stop")
HOLDING_BUTTONS = ("pause", "step", "reset")
SHORTENED_BUTTONS = (("record",), ("arm", "take_off", "hold", "land"))
"""Buttons that show only their icon if there is no room for text; STOP keeps its text."""
DISABLED_ICON_COLOUR = "line"
"""Colour of the icon on a disabled button."""


class SpeedBox(NumberField):
    """The real-time factor; its arrows step through the usual factors."""

    def __init__(self) -> None:
        super().__init__("Requested speed, in times real time")
        self.set_range(DisplayUnit("×"), MIN_REAL_TIME_FACTOR, MAX_REAL_TIME_FACTOR)
        self.show_si(1.0)
        self.setFixedWidth(SPEED_WIDTH_DIGITS * self.fontMetrics().horizontalAdvance("0"))
        set_tip(self, "Requested speed: simulated seconds in a second; arrows step through presets")

    def show_factor(self, factor: float) -> None:
        """Show the present factor, unless the user is typing another one."""
        if factor != self.value() and not self.is_typed_in and not self.fault:
            self.show_si(factor)

    def stepBy(self, steps: int) -> None:
        """Step through the usual factors."""
        self.restore()
        for _ in range(abs(steps)):
            self.setValue(next_speed(self.value(), up=steps > 0))


def next_speed(factor: float, *, up: bool) -> float:
    """Return the nearest usual factor above or below one."""
    if up:
        at = bisect_right(REAL_TIME_FACTORS, factor)
        return REAL_TIME_FACTORS[at] if at < len(REAL_TIME_FACTORS) else MAX_REAL_TIME_FACTOR
    at = bisect_left(REAL_TIME_FACTORS, factor)
    return REAL_TIME_FACTORS[at - 1] if at else min(factor, REAL_TIME_FACTORS[0])


class TopBar(QFrame):
    """The flight, its state, and its actions; visible on every screen.

    Args:
        workspace: has the flight.
        actions: actions of the table, by name.
        control: controls the flight.
        recorder: model of the Record button.
    """

    def __init__(
        self,
        workspace: Workspace,
        actions: Mapping[str, QAction],
        control: FlightControl,
        recorder: LogRecorder,
    ) -> None:
        super().__init__()
        self.setObjectName("top_bar")
        self.setAccessibleName("Flight")
        self.setSizePolicy(QSizePolicy.Policy.Preferred, QSizePolicy.Policy.Fixed)
        self._look, self._actions, self._recorder = workspace.look, actions, recorder
        self.badge = Chip("Flight", workspace.look, MODE_WIDTH_DIGITS)
        self.speed = SpeedBox()
        self.speed.edited.connect(control.set_speed)
        self.strip = StatusStrip(workspace.look)
        self._buttons: dict[str, QToolButton] = {}
        self._shortened = 0
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
        """Show a view."""
        self.badge.show_said(mode_status(view))
        self.strip.show_view(view)
        if view.pace is not None:
            self.speed.show_factor(view.pace.asked)

    def resizeEvent(self, event: QResizeEvent | None) -> None:
        """Show as much text as there is room for."""
        super().resizeEvent(event)
        self._fit()

    def event(self, event: QEvent | None) -> bool:
        """Adapt when something has grown too wide."""
        done = super().event(event)
        if event is not None and event.type() is QEvent.Type.LayoutRequest:
            wide = self._row.minimumSize().width() > self.width()
            if wide and self._shortened <= len(SHORTENED_BUTTONS):
                self._fit()
        return done

    def showEvent(self, event: QShowEvent | None) -> None:
        """Adapt once everything is shown: buttons get the style's size only then."""
        super().showEvent(event)
        QTimer.singleShot(0, self._fit)

    def minimumSizeHint(self) -> QSize:
        """Return the height of both rows; texts that are too wide are shortened."""
        return QSize(0, super().minimumSizeHint().height())

    def _fit(self) -> None:
        """Shorten one group after the other, until everything fits."""
        for shortened in range(len(SHORTENED_BUTTONS) + 2):
            for index, names in enumerate(SHORTENED_BUTTONS):
                for name in names:
                    self._show_words(name, index >= shortened)
            self._speed_label.setVisible(shortened < len(SHORTENED_BUTTONS))
            self.badge.reserve(shortened <= len(SHORTENED_BUTTONS))
            if self._row.minimumSize().width() <= self.width():
                break
        self._shortened = shortened

    def _show_words(self, name: str, shown: bool) -> None:
        styles = Qt.ToolButtonStyle
        style = styles.ToolButtonTextBesideIcon if shown else styles.ToolButtonIconOnly
        if self._buttons[name].toolButtonStyle() is not style:
            self._buttons[name].setToolButtonStyle(style)

    def _show_recording(self) -> None:
        recorder = self._recorder
        self.strip.recording.setVisible(recorder.is_recording)
        if recorder.is_recording:
            said = StatusText(recorder.said(), "record", BAD_TONE, recorder.path)
            self.strip.recording.show_said(said)
        self._draw_button("record", "recording" if recorder.is_recording else "record")
        self._actions["record"].setIconText("Stop recording" if recorder.is_recording else "Record")
        self._fit()

    def _draw(self) -> None:
        """Draw the icons in the present colours."""
        for name in self._buttons:
            self._draw_button(name, find_action(name).icon)
        self._show_recording()

    def _draw_button(self, name: str, shape: str) -> None:
        colour = {"stop": "on_accent", "record": "bad"}.get(name, "ink")
        made = icon(shape, self._look.colour(colour), self._look.colour(DISABLED_ICON_COLOUR))
        self._actions[name].setIcon(made)

    def _lay_out(self) -> None:
        badge = QFrame()
        badge.setObjectName("mode_badge")
        hbox(self.badge, of=badge, margins=(9, 4, 9, 4))
        row = self._row = hbox(badge, margins=(10, 8, 10, 5), spacing=6)
        row.addSpacing(6)
        fill(row, *(self._make_button(name, with_text=True) for name in FLYING_BUTTONS))
        self._buttons["stop"].setProperty("class", "danger")
        self._buttons["stop"].setFocusPolicy(Qt.FocusPolicy.NoFocus)  # only its own key does it
        row.addSpacing(10)
        fill(row, *(self._make_button(name, with_text=False) for name in HOLDING_BUTTONS))
        row.addSpacing(10)
        self._speed_label = buddy("Sp&eed", self.speed)
        fill(row, self._speed_label, self.speed, 1, self._make_button("record", with_text=True))
        fill(row, *(self._make_button(name, with_text=False) for name in ("screenshot", "view_3d")))
        vbox(row, self.strip, of=self, margins=NO_MARGINS, spacing=0)

    def _make_button(self, name: str, *, with_text: bool) -> QToolButton:
        action, row = self._actions[name], find_action(name)
        button = QToolButton(self)
        button.setDefaultAction(action)
        button.setIconSize(QSize(TOP_BAR_ICON_PX, TOP_BAR_ICON_PX))
        button.setFocusPolicy(Qt.FocusPolicy.StrongFocus)
        button.setSizePolicy(QSizePolicy.Policy.Minimum, QSizePolicy.Policy.Fixed)
        action.changed.connect(partial(_name_button, button, row.label, action))
        _name_button(button, row.label, action)
        style = Qt.ToolButtonStyle
        button.setToolButtonStyle(
            style.ToolButtonTextBesideIcon if with_text else style.ToolButtonIconOnly
        )
        if not with_text:
            button.setProperty("class", "compact")
        if name != "stop":  # which always acts
            ClickGuard(button)
        self._buttons[name] = button
        return button


def _name_button(button: QToolButton, label: str, action: QAction) -> None:
    """Name a button for screen readers, with the key of its action."""
    key = action.shortcut().toString()
    button.setAccessibleName(f"{label}, {key}" if key else label)
