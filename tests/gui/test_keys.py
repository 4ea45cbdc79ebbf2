"""Keys over the real window: what stops the rotors, what does not, and shortcuts in fields."""

from PyQt6.QtCore import QEvent, Qt
from PyQt6.QtGui import QAction, QKeySequence, QShortcut
from PyQt6.QtWidgets import QApplication, QFileDialog, QLineEdit, QWidget

from tests.gui.conftest import delete_widgets, view_of
from workbench.control.mode import FlightMode
from workbench.gui.key_table import KEY_ROWS
from workbench.gui.screen_table import SCREEN_TABLE
from workbench.live.choice import Choice
from workbench.live.messages import Phase
from workbench.live.orders import FlightOrder
from workbench.scenario.excitation import Excitation
from workbench.scenario.scenario import Action

LIMIT = 120_000
"""Any single thing happens within this time, however slow the machine is [ms]."""
LEFT = Qt.MouseButton.LeftButton
CONTROL = Qt.KeyboardModifier.ControlModifier
FLIES = (FlightMode.TAKING_OFF, FlightMode.HOVERING, FlightMode.CRUISING, FlightMode.ASCENDING)


def test_space_pauses_and_resumes_after_a_click_on_take_off(window, qtbot, workspace):
    """By mouse and keyboard on a real flight: the button that was pressed is disabled by then."""
    window.control.fly(Choice("network"))
    flight = workspace.flight
    take_off = window.top_bar.button("take_off")
    qtbot.waitUntil(lambda: flight.is_flying and take_off.isEnabled(), timeout=LIMIT)
    take_off.setFocus()
    qtbot.mouseClick(take_off, LEFT)
    qtbot.waitUntil(lambda: not take_off.isEnabled(), timeout=LIMIT)
    for phase in (Phase.PAUSED, Phase.FLYING):
        focus = QApplication.focusWidget()
        assert focus is not None and focus.window() is window
        qtbot.keyClick(focus, Qt.Key.Key_Space)
        qtbot.waitUntil(lambda phase=phase: flight.view.phase is phase, timeout=LIMIT)
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
    assert [type(order) for order in orders] == [Excitation]
    assert not claims(line, QKeySequence("Ctrl+Z")[0])  # nothing typed yet: the gains' undo
    qtbot.keyClicks(line, "12")
    for row in KEY_ROWS:
        text = row.shortcut
        sequence = QKeySequence(text)
        if sequence.count() == 0:
            continue
        key = sequence[0]
        if not key.keyboardModifiers() & CONTROL or not text[-1:].isalnum() or "Return" in text:
            continue
        claimed = claims(line, key)
        assert claimed == (text == "Ctrl+Z"), text  # nothing to redo, as nothing was undone
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
                orders.clear()
                for key in (Qt.Key.Key_Space, Qt.Key.Key_Return, Qt.Key.Key_Enter):
                    qtbot.keyClick(QApplication.focusWidget() or window, key)
                plays = (FlightOrder.PAUSE, FlightOrder.RESUME)
                assert all(order in plays for order in orders), (
                    f"{name}, {before} to {after}: {orders}"
                )
    assert lost > 20


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
        orders.clear()
        opens()
        (dialog,) = [each for each in window.findChildren(QFileDialog) if each.isVisible()]
        qtbot.keyClick(dialog.findChild(QLineEdit), Qt.Key.Key_F12)
        assert Action(request="stop") in orders, name
        dialog.close()
        delete_widgets()
        opened += 1
    assert opened == 5


def test_no_key_does_two_things_on_any_screen(window, orders, canned, show):
    """Qt does neither of two things that one key would do."""
    show(view_of(canned, Phase.FLYING, FlightMode.HOVERING))
    for row in SCREEN_TABLE:
        window.show_screen(row.name)
        others = [
            window.stack.screen_of(each.name) for each in SCREEN_TABLE if each.name != row.name
        ]
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
