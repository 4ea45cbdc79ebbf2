"""Every key on every widget of the real window, which keeps much of what was pressed."""

from PyQt6 import sip
from PyQt6.QtCore import Qt, QTimer
from PyQt6.QtWidgets import QApplication, QWidget

from tests.gui.conftest import view_of
from workbench.control.mode import FlightMode
from workbench.gui.screen_table import SCREEN_TABLE
from workbench.live.messages import Phase
from workbench.scenario.scenario import Action

LEFT = Qt.MouseButton.LeftButton
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


def press(qtbot, widget, key, modifier=Qt.KeyboardModifier.NoModifier) -> None:
    """Press a key on a widget, and close what it has opened above the window."""
    window = widget.window()
    qtbot.keyClick(widget, key, modifier)
    close_popups(window)


def close_popups(window) -> None:
    """Close menus, lists and dialogs above the window."""
    while (popup := QApplication.activePopupWidget()) is not None:
        popup.close()
    for each in QApplication.topLevelWindows():  # of what was shown, a tenth of all widgets
        if each.isVisible() and each != window.windowHandle():
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


def test_no_key_but_f12_stops_the_rotors(
    window, workspace, orders, canned, show, qtbot, monkeypatch
):
    """With the focus on every widget that can have it, on every screen.

    Scenarios that keys open do not fly: that would be a process for each, and end what is shown.
    """
    opened = []
    monkeypatch.setattr(workspace.flight, "_ask", opened.append)
    stop = window.top_bar.button("stop")
    show(view_of(canned, Phase.FLYING, FlightMode.HOVERING))
    tried = 0
    closer = QTimer()  # a button's menu has an event loop of its own
    closer.timeout.connect(lambda: close_popups(window))
    closer.start(20)
    for row in SCREEN_TABLE:
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
    assert opened
    assert Action(request="stop") not in orders
    assert window.actions_by_name["stop"] not in all_menu_actions(window)
    window.top_bar.button("hold").setFocus()
    for _ in range(400):
        press(qtbot, QApplication.focusWidget() or window, Qt.Key.Key_Tab)
        assert QApplication.focusWidget() is not stop
    qtbot.mouseClick(stop, LEFT)
    assert orders[-1] == Action(request="stop")
