"""Keys over the real window: what stops the rotors, what does not, and shortcuts in fields."""

import dataclasses

import pytest
from PyQt6 import sip
from PyQt6.QtCore import QEvent, Qt, QTimer
from PyQt6.QtGui import QAction, QKeySequence, QShortcut
from PyQt6.QtWidgets import QApplication, QFileDialog, QLineEdit, QWidget

from workbench.control.mode import FlightMode
from workbench.gui.actions import ACTIONS
from workbench.gui.gains.gain_bar import GAIN_ACTIONS
from workbench.gui.screen_table import SCREENS
from workbench.live.choice import Choice
from workbench.live.messages import Phase

LIMIT = 120_000
"""Any single thing happens within this time, however slow the machine is [ms]."""
LEFT = Qt.MouseButton.LeftButton
CONTROL = Qt.KeyboardModifier.ControlModifier
ALT = Qt.KeyboardModifier.AltModifier
KEYS = (
    Qt.Key.Key_Space,
    Qt.Key.Key_Return,
    Qt.Key.Key_Enter,
    Qt.Key.Key_Select,
    Qt.Key.Key_Tab,
    Qt.Key.Key_Escape,
    Qt.Key.Key_Delete,
    Qt.Key.Key_S,
)
FLIES = (FlightMode.TAKING_OFF, FlightMode.HOVERING, FlightMode.CRUISING, FlightMode.ASCENDING)


class Orders:
    """A live flight that notes what it is asked for."""

    def __init__(self):
        self.given = []

    def __getattr__(self, name):
        if name == "checkpoint":  # the ghost asks for it, and no key
            return lambda: None
        return lambda *args: self.given.append((name, *args))


@pytest.fixture(scope="module")
def workspace(shared_workspace):
    return shared_workspace


@pytest.fixture
def window(shared_window):
    shared_window.activateWindow()
    return shared_window


@pytest.fixture
def orders(window, workspace, canned, unasked, monkeypatch):
    """What a flight out of a can is asked for."""
    made = Orders()
    monkeypatch.setattr(
        workspace.flight, "order", lambda give, done=None, refused=None: give(made) and None
    )
    workspace.flight.begun.emit(canned.views[0])
    return made


def view_of(canned, phase, mode):
    """Return a view of a flight in a phase and a mode."""
    view = canned.views[0]
    return dataclasses.replace(
        view, phase=phase, snapshot=dataclasses.replace(view.snapshot, mode=mode)
    )


def test_space_after_take_off_does_not_stop_the_rotors(window, qtbot, workspace):
    """By mouse and keyboard on a real flight: the button that was pressed is disabled by then."""
    window.control.fly(Choice("network"))
    flight = workspace.flight
    take_off = window.top_bar.button("take_off")
    qtbot.waitUntil(lambda: flight.is_flying and take_off.isEnabled(), timeout=LIMIT)
    take_off.setFocus()
    qtbot.mouseClick(take_off, LEFT)
    qtbot.waitUntil(lambda: not take_off.isEnabled(), timeout=LIMIT)
    for _ in range(5):
        focus = QApplication.focusWidget()
        assert focus is not None and focus.window() is window
        qtbot.keyClick(focus, Qt.Key.Key_Space)
        now = flight.view.snapshot.time
        qtbot.waitUntil(lambda now=now: flight.view.snapshot.time > now + 0.2, timeout=LIMIT)
        assert flight.view.snapshot.mode in FLIES
    qtbot.keyClick(QApplication.focusWidget(), Qt.Key.Key_F12)
    qtbot.waitUntil(lambda: flight.view.snapshot.mode is FlightMode.OFF, timeout=LIMIT)
    flight.close()


class TerminalLine(QLineEdit):
    """A line that takes every Ctrl+letter for itself, as Qt's do with some of them on X11."""

    def event(self, event):
        if event.type() == QEvent.Type.ShortcutOverride and event.modifiers() & CONTROL:
            event.accept()
            return True
        return super().event(event)


def test_shortcuts_work_in_a_field_unless_they_edit_text(window, orders, canned, show, qtbot):
    show(view_of(canned, Phase.FLYING, FlightMode.HOVERING))
    window.show_screen("tuning")
    screen = window.stack.current
    screen.excitation.show_view(window.workspace.flight.view)
    line = TerminalLine(screen)
    line.show()
    line.setFocus()
    qtbot.keyClick(line, Qt.Key.Key_E, CONTROL)
    assert [name for name, *_ in orders.given] == ["excite"]
    for text in (*(row.shortcut for row in (*ACTIONS, *GAIN_ACTIONS)), "Ctrl+E", "Ctrl+F"):
        sequence = QKeySequence(text)
        if sequence.count() == 0:
            continue
        key = sequence[0]
        if not key.keyboardModifiers() & CONTROL:
            continue
        claimed = claims(line, key)
        edits = text in ("Ctrl+Z", "Ctrl+Shift+Z")
        assert claimed == edits, text
    for text in ("Ctrl+A", "Ctrl+C", "Ctrl+V", "Ctrl+X", "Ctrl+Z", "Ctrl+Left"):
        assert claims(line, QKeySequence(text)[0]), text


def claims(field, key) -> bool:
    """Return whether a field takes a key from the shortcuts."""
    from PyQt6.QtGui import QKeyEvent

    event = QKeyEvent(QEvent.Type.ShortcutOverride, key.key(), key.keyboardModifiers())
    event.ignore()
    QApplication.sendEvent(field, event)
    return event.isAccepted()


def test_what_the_focus_falls_on_hears_no_key(window, orders, canned, show, qtbot):
    """Whatever button has the focus when the flight disables it: the next key orders nothing."""
    states = [(Phase.FLYING, mode) for mode in FlightMode]
    states += [(Phase.PAUSED, FlightMode.HOVERING), (Phase.BROKEN, FlightMode.HOVERING)]
    lost = 0
    for before in states:
        for after in states:
            for name in ("arm", "take_off", "hold", "land", "pause", "step", "reset", "record"):
                show(view_of(canned, *before))
                button = window.top_bar.button(name)
                if not button.isEnabled():
                    continue
                button.setFocus()
                show(view_of(canned, *after))
                if button.isEnabled():
                    continue
                lost += 1
                orders.given.clear()
                for key in (Qt.Key.Key_Space, Qt.Key.Key_Return, Qt.Key.Key_Enter):
                    qtbot.keyClick(QApplication.focusWidget() or window, key)
                assert not orders.given, f"{name}, {before} to {after}: {orders.given}"
    assert lost > 20


def has_tab(widget) -> bool:
    return bool(widget.focusPolicy().value & Qt.FocusPolicy.TabFocus.value)


def press(qtbot, widget, key, modifier=Qt.KeyboardModifier.NoModifier) -> None:
    """Press a key on a widget, and close what it has opened above the window."""
    window = widget.window()
    qtbot.keyClick(widget, key, modifier)
    close_popups(window)


def close_popups(window) -> None:
    """Close menus, lists and dialogs above the window."""
    while (popup := QApplication.activePopupWidget()) is not None:
        popup.close()
    for each in QApplication.topLevelWidgets():
        if each.isVisible() and each is not window:
            each.close()


def all_menu_actions(window):
    """Return the actions of all menus, whatever they stand in."""
    found = []
    waiting = [window.menuBar()]
    while waiting:
        for action in waiting.pop().actions():
            found.append(action)
            if action.menu() is not None:
                waiting.append(action.menu())
    return found


def test_f12_stops_above_every_file_dialog(window, orders, canned, show, qtbot):
    show(view_of(canned, Phase.FLYING, FlightMode.HOVERING))
    opened = 0
    for name, opens in (
        ("home", window.actions_by_name["open_model"].trigger),
        ("tuning", window.stack.screen_of("tuning").pin._browse),
        ("visualization", window.stack.screen_of("visualization").open_button.click),
        ("server", window.stack.screen_of("server").form._choose_new),
        ("tuning", lambda: qtbot.keyClick(window, Qt.Key.Key_S, CONTROL)),
    ):
        window.show_screen(name)
        orders.given.clear()
        opens()
        (dialog,) = [each for each in window.findChildren(QFileDialog) if each.isVisible()]
        qtbot.keyClick(dialog.findChild(QLineEdit), Qt.Key.Key_F12)
        assert ("request", "stop") in orders.given, name
        dialog.close()
        QApplication.sendPostedEvents(None, QEvent.Type.DeferredDelete)
        opened += 1
    assert opened == 5


def test_no_key_does_two_things_on_any_screen(window, orders, canned, show):
    """Qt does neither of two things that one key would do."""
    show(view_of(canned, Phase.FLYING, FlightMode.HOVERING))
    for row in SCREENS:
        window.show_screen(row.name)
        others = [window.stack.screen_of(each.name) for each in SCREENS if each.name != row.name]
        hidden = {id(key) for other in others for key in keys_of(other)}
        used: dict[str, list[str]] = {}
        for each in keys_of(window):
            if id(each) not in hidden:
                for key in each.shortcuts() if isinstance(each, QAction) else [each.key()]:
                    used.setdefault(key.toString(), []).append(each.objectName() or repr(each))
        twice = {key: names for key, names in used.items() if key and len(names) > 1}
        assert not twice, f"{row.name}: {twice}"
        assert "F12" in used and len(used) > 20


def keys_of(widget: QWidget) -> list[QAction | QShortcut]:
    """Return everything below a widget that a key may do."""
    return [*widget.findChildren(QAction), *widget.findChildren(QShortcut)]


def test_no_key_but_f12_stops_the_rotors(window, orders, canned, show, qtbot):
    """With the focus on every widget that can have it, on every screen.

    It is the last one here: it leaves the window that all share with much that was pressed.
    """
    stop = window.top_bar.button("stop")
    show(view_of(canned, Phase.FLYING, FlightMode.HOVERING))
    tried = 0
    closer = QTimer()  # a button's menu has an event loop of its own
    closer.timeout.connect(lambda: close_popups(window))
    closer.start(20)
    for row in SCREENS:
        window.show_screen(row.name)
        QApplication.processEvents()
        widgets = [
            each
            for each in window.findChildren(QWidget)
            if each.isVisible()
            and each.isEnabled()
            and each.focusPolicy() & Qt.FocusPolicy.TabFocus
        ]
        for widget in widgets:
            for key in KEYS:
                if sip.isdeleted(widget):  # a key before has removed its row
                    break
                widget.setFocus()
                press(qtbot, widget, key)
            tried += 1
        for letter in "ABCDEFGHIJKLMNOPRSTUVWXYZ":
            press(qtbot, window.stack.current, Qt.Key(ord(letter)), ALT)
    closer.stop()
    assert tried > 100
    assert ("request", "stop") not in orders.given
    assert window.actions_by_name["stop"] not in all_menu_actions(window)
    window.top_bar.button("hold").setFocus()
    for _ in range(400):
        press(qtbot, QApplication.focusWidget() or window, Qt.Key.Key_Tab)
        assert QApplication.focusWidget() is not stop
    qtbot.mouseClick(stop, LEFT)
    assert orders.given[-1] == ("request", "stop")
