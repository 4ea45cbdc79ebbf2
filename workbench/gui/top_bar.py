"""The top bar: a row of buttons, and a row with the state of the flight."""

from bisect import bisect_left, bisect_right
from collections.abc import Mapping
from dataclasses import dataclass

from PyQt6.QtCore import QEvent, QSize, Qt, QTimer
from PyQt6.QtGui import QAction, QResizeEvent, QShowEvent
from PyQt6.QtWidgets import (
    QFrame,
    QSizePolicy,
    QToolButton,
    QWidget,
)

from workbench.common.plain_text import plain_name
from workbench.gui.actions import SPEEDS, find_row
from workbench.gui.flight_control import FlightControl
from workbench.gui.icons import MODES, icon, picture
from workbench.gui.labels import Label, set_tip
from workbench.gui.layout import NO_MARGINS, buddy, fill, hbox, vbox
from workbench.gui.number_field import NumberField
from workbench.gui.recorder import Recorder
from workbench.gui.style import set_class
from workbench.gui.theme import Look
from workbench.gui.units import Unit
from workbench.gui.workspace import Workspace
from workbench.link.messages import Hand, Stage
from workbench.live.announcer import LOW_CHARGE, RESERVE
from workbench.live.messages import Phase
from workbench.live.view import LiveView

PLAIN, GOOD, WARNING, BAD, MUTED = "", "good", "warning", "bad", "muted"

CHIP_ICON = 16

LOST = 0.01
"""Share of lost answers of an autopilot above which a warning is shown."""
WARNINGS = 2
"""Number of places for warnings."""

SLOWEST, FASTEST = 0.01, 20.0
"""Limits of the selectable speed."""
SPEED_WIDTH = 11
"""Width of the speed's text and arrows, in digits."""

MODE_WIDTH = 15
"""Width of the usual flight modes, in digits."""

ICON = 18
FLYING = ("arm", "take_off", "hold", "land", "stop")
HOLDING = ("pause", "step", "reset")
SHORTENED = (("record",), ("arm", "take_off", "hold", "land"))
"""Buttons that show only their icon if there is no room for text; STOP keeps its text."""
DISABLED = "line"
"""Colour of the icon on a disabled button."""


@dataclass(frozen=True)
class Said:
    """A short text with an icon.

    Attributes:
        text: the text.
        icon: name of the icon, see `icons`.
        tone: class of its colour.
        full: the same as a sentence, for screen readers.
    """

    text: str
    icon: str
    tone: str = PLAIN
    full: str = ""


_PHASES = {
    Phase.STARTING: Said("starting", "pace", MUTED),
    Phase.BROKEN: Said("broken", "failure", BAD),
    Phase.ENDED: Said("ended", "failure", BAD),
}


def mode_said(view: LiveView) -> Said:
    """Return the flight mode."""
    if view.phase in _PHASES or view.snapshot is None:
        said = _PHASES.get(view.phase, _PHASES[Phase.STARTING])
        return Said(said.text, said.icon, said.tone, f"{said.text}: {view.said}")
    mode = view.snapshot.mode
    if view.autopilot is not None and view.autopilot.ended:
        return Said(f"{mode.label}, held", "failure", BAD, view.autopilot.ended)
    if view.phase is Phase.PAUSED:
        return Said(f"paused, {mode.label}", "pause", WARNING, f"paused while {mode.label}")
    return Said(mode.label, MODES[mode], PLAIN, f"flight mode: {mode.label}")


def time_said(view: LiveView) -> Said:
    """Return the simulated time."""
    if view.snapshot is None or view.phase is Phase.STARTING:
        return Said(view.said or "–", "clock", MUTED, view.said)
    time = view.snapshot.time
    minutes, seconds = divmod(int(time * 10.0) / 10.0, 60.0)
    return Said(f"{int(minutes)}:{seconds:04.1f}", "clock", PLAIN, "simulated time")


def battery_said(view: LiveView) -> Said:
    """Return the battery's charge."""
    if view.snapshot is None:
        return Said("–", "battery", MUTED, "battery: not known yet")
    charge = view.snapshot.charge
    reserve = view.values.get(RESERVE, 0.0)
    text = f"{100.0 * charge:.0f} %"
    if charge <= reserve:
        full = f"battery {text} left: the drone lands by itself"
        return Said(f"{text} left", "battery", BAD, full)
    if charge <= reserve + LOW_CHARGE:
        return Said(f"{text} low", "battery", WARNING, f"battery {text}, low")
    return Said(text, "battery", PLAIN, f"battery {text}")


def reached_said(view: LiveView) -> Said:
    """Return the achieved real-time factor."""
    if view.pace is None or view.phase not in (Phase.FLYING, Phase.PAUSED):
        return Said("–", "pace", MUTED, "speed reached: not known")
    if view.phase is Phase.PAUSED:
        return Said("paused", "pause", MUTED, "the flight is paused")
    tone = WARNING if view.pace.too_slow else PLAIN
    return Said(f"reached {view.pace.text}", "pace", tone, str(view.pace))


def link_said(view: LiveView) -> Said:
    """Return who is connected and who has control."""
    server, control = view.network.server, view.network.control
    if server is None:
        return Said("no server", "link", MUTED, "no server runs: start one on the Server screen")
    clients = len(server.clients)
    count = "1 client" if clients == 1 else f"{clients} clients"
    full = f"server at {server.address}, {count}"
    if control is None or control.hand is Hand.NOBODY:
        return Said(f"{count}, nobody flies", "link", PLAIN, full)
    who = "you fly" if control.hand is Hand.OPERATOR else f"{control.name or 'a client'} flies"
    if control.stage is not Stage.LIVE:
        text = f"{control.name or 'client'} silent: {control.stage.value}"
        return Said(text, "warning", WARNING, f"{full}: {control.reason}")
    return Said(f"{count}, {who}", "link", PLAIN, f"{full}; {control.reason}")


def autopilot_said(view: LiveView) -> Said | None:
    """Return the state of the exchange with a program that runs the law, None without one."""
    if view.autopilot is None or view.controller is None or not view.autopilot.exchange:
        return None
    name = view.controller.name
    if view.autopilot.ended:
        return Said(f"{name} ended", "failure", BAD, view.autopilot.ended)
    sent, lost = (round(view.autopilot.exchange[what]) for what in ("packets", "lost"))
    full = f"{name} did not answer {lost} of {sent} packets in time; the motors were held then"
    return Said(f"{name}: {lost} lost", "link", WARNING if lost > LOST * sent else PLAIN, full)


def warnings_said(view: LiveView) -> tuple[Said, ...]:
    """Return the present warnings, the most severe first."""
    if view.snapshot is None or view.phase not in (Phase.FLYING, Phase.PAUSED):
        return ()
    found = []
    near = view.snapshot.clearance
    if near is not None and near.warning:
        text = f"obstacle {max(near.distance, 0.0):.1f} m"
        found.append(Said(text, "warning", BAD, f"an obstacle is {near.distance:.1f} m away"))
    if view.pace is not None and view.pace.too_slow and view.phase is Phase.FLYING:
        found.append(Said("machine too slow", "warning", WARNING, str(view.pace)))
    return tuple(found)


class Chip(QWidget):
    """Shows a short text; repainted only if the text changes.

    Args:
        name: name of the quantity, for screen readers.
        look: source of colours.
        characters: length of the longest usual text, so that neighbours do not move.
    """

    def __init__(self, name: str, look: Look, characters: int = 0) -> None:
        super().__init__()
        self._name, self._look = name, look
        self._said: Said | None = None
        self._shape = Label()
        self._text = Label()
        self.setSizePolicy(QSizePolicy.Policy.Maximum, QSizePolicy.Policy.Preferred)
        layout = hbox(self._shape, (self._text, 1), of=self, margins=NO_MARGINS, spacing=5)
        beside = CHIP_ICON + layout.spacing()
        self._reserved = beside + characters * self.fontMetrics().horizontalAdvance("0")
        self.reserve(characters > 0)
        look.changed.connect(self._draw)

    @property
    def text(self) -> str:
        """The shown text."""
        return self._text.text()

    def reserve(self, reserves: bool) -> None:
        """Reserve room for the longest usual text, or only for the present one."""
        self.setMinimumWidth(self._reserved if reserves else 0)

    def show_said(self, said: Said) -> None:
        """Show another text."""
        before, self._said = self._said, said
        if said == before:
            return
        if before is None or said.text != before.text:
            self._text.setText(plain_name(said.text))
        if before is None or (said.icon, said.tone) != (before.icon, before.tone):
            self._draw()
        full = said.full or said.text
        set_tip(self, f"{self._name}: {full}")
        self.setAccessibleName(f"{self._name}: {full}")

    def _draw(self) -> None:
        if self._said is None:
            return
        tone = self._said.tone
        set_class(self._text, tone)
        colour = self._look.colour(tone if tone != PLAIN else "ink")
        self._shape.setPixmap(picture(self._said.icon, colour, CHIP_ICON, self.devicePixelRatioF()))


class StatusStrip(QFrame):
    """A line of short texts with icons.

    Args:
        look: source of colours.
    """

    def __init__(self, look: Look) -> None:
        super().__init__()
        self.time = Chip("Simulated time", look, 7)
        self.battery = Chip("Battery", look, 5)
        self.reached = Chip("Speed", look, 14)
        self.link = Chip("Link", look)
        self.autopilot = Chip("Autopilot", look)
        self.autopilot.hide()
        self.recording = Chip("Recording", look)
        self.recording.hide()
        self.opening = Chip("Opening", look)
        self.opening.hide()
        self.warnings = [Chip("Warning", look) for _ in range(WARNINGS)]
        hbox(
            self.time,
            self.battery,
            self.reached,
            self.link,
            self.autopilot,
            self.recording,
            self.opening,
            1,
            *self.warnings,
            of=self,
            margins=(20, 1, 12, 7),
            spacing=24,
        )
        self.setMinimumHeight(self.sizeHint().height())

    def show_opening(self, said: str) -> None:
        """Show the progress of starting another flight; "" when it is over."""
        self.opening.setVisible(bool(said))
        if said:
            full = f"another flight is being prepared: {said}; the present one continues until then"
            self.opening.show_said(Said(f"opening: {said}", "pace", MUTED, full))

    def show_view(self, view: LiveView) -> None:
        """Show a view."""
        self.time.show_said(time_said(view))
        self.battery.show_said(battery_said(view))
        self.reached.show_said(reached_said(view))
        self.link.show_said(link_said(view))
        exchange = autopilot_said(view)
        self.autopilot.setVisible(exchange is not None)
        if exchange is not None:
            self.autopilot.show_said(exchange)
        said = warnings_said(view)
        for at, chip in enumerate(self.warnings):
            chip.setVisible(at < len(said))
            if at < len(said):
                chip.show_said(said[at])


class SpeedBox(NumberField):
    """The real-time factor; its arrows step through the usual factors."""

    def __init__(self) -> None:
        super().__init__("Requested speed, in times real time")
        self.set_range(Unit("×"), SLOWEST, FASTEST)
        self.show_si(1.0)
        self.setFixedWidth(SPEED_WIDTH * self.fontMetrics().horizontalAdvance("0"))
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
        at = bisect_right(SPEEDS, factor)
        return SPEEDS[at] if at < len(SPEEDS) else FASTEST
    at = bisect_left(SPEEDS, factor)
    return SPEEDS[at - 1] if at else min(factor, SPEEDS[0])


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
        recorder: Recorder,
    ) -> None:
        super().__init__()
        self.setObjectName("top_bar")
        self.setAccessibleName("Flight")
        self.setSizePolicy(QSizePolicy.Policy.Preferred, QSizePolicy.Policy.Fixed)
        self._look, self._actions, self._recorder = workspace.look, actions, recorder
        self.badge = Chip("Flight", workspace.look, MODE_WIDTH)
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
        self.badge.show_said(mode_said(view))
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
            if wide and self._shortened <= len(SHORTENED):
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
        for shortened in range(len(SHORTENED) + 2):
            for index, names in enumerate(SHORTENED):
                for name in names:
                    self._show_words(name, index >= shortened)
            self._speed_label.setVisible(shortened < len(SHORTENED))
            self.badge.reserve(shortened <= len(SHORTENED))
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
            said = Said(recorder.said(), "record", BAD, recorder.path)
            self.strip.recording.show_said(said)
        self._draw_button("record", "recording" if recorder.is_recording else "record")
        self._actions["record"].setIconText("Stop" if recorder.is_recording else "Record")
        self._fit()

    def _draw(self) -> None:
        """Draw the icons in the present colours."""
        for name in self._buttons:
            self._draw_button(name, find_row(name).icon)
        self._show_recording()

    def _draw_button(self, name: str, shape: str) -> None:
        colour = {"stop": "on_accent", "record": "bad"}.get(name, "ink")
        made = icon(shape, self._look.colour(colour), self._look.colour(DISABLED))
        self._actions[name].setIcon(made)

    def _lay_out(self) -> None:
        badge = QFrame()
        badge.setObjectName("mode_badge")
        hbox(self.badge, of=badge, margins=(9, 4, 9, 4))
        row = self._row = hbox(badge, margins=(10, 8, 10, 5), spacing=6)
        row.addSpacing(6)
        fill(row, *(self._make_button(name, with_text=True) for name in FLYING))
        self._buttons["stop"].setProperty("class", "danger")
        self._buttons["stop"].setFocusPolicy(Qt.FocusPolicy.NoFocus)  # its only key is F12
        row.addSpacing(10)
        fill(row, *(self._make_button(name, with_text=False) for name in HOLDING))
        row.addSpacing(10)
        self._speed_label = buddy("Sp&eed", self.speed)
        fill(row, self._speed_label, self.speed, 1, self._make_button("record", with_text=True))
        fill(row, *(self._make_button(name, with_text=False) for name in ("screenshot", "view_3d")))
        vbox(row, self.strip, of=self, margins=NO_MARGINS, spacing=0)

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
