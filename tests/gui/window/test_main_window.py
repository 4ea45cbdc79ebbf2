"""The window: keys, what is kept, and its end."""

import gc

import pytest
from PyQt6.QtCore import Qt
from PyQt6.QtWidgets import QFileDialog, QLineEdit

from workbench.control.mode import FlightMode
from workbench.gui.gains.gain_bar import ask_to_save
from workbench.gui.main_window import MIN_WINDOW_SIZE_PX
from workbench.live.choice import Choice
from workbench.live.messages import Phase
from workbench.scenario.scenario import Action

FLYING = 60_000
"""Longest wait for a flight to begin [ms]."""

CTRL = Qt.KeyboardModifier.ControlModifier


@pytest.mark.slow
def test_the_collector_passes_over_what_lives_as_long_as_the_window(opened, qtbot):
    gc.unfreeze()
    window = opened(first="home")
    qtbot.waitUntil(lambda: gc.get_freeze_count() > 0, timeout=10_000)
    assert window.isVisible()
    gc.unfreeze()


@pytest.mark.parametrize("field", ["number", "line"])
def test_the_stop_key_works_wherever_the_keyboard_is(opened, qtbot, workspace, field, monkeypatch):
    window = opened(first="home")
    asked = []
    monkeypatch.setattr(workspace.flight, "do", lambda order, *rest: asked.append(order))
    widget = getattr(window.stack.current, field)
    widget.setFocus()
    qtbot.keyClick(widget, Qt.Key.Key_F12)
    assert asked == [Action(request="stop")]
    window.top_bar.speed.setFocus()
    qtbot.keyClick(window.top_bar.speed, Qt.Key.Key_F12)
    assert asked == [Action(request="stop")] * 2


def test_the_stop_key_works_above_an_open_dialog(opened, qtbot, workspace, monkeypatch):
    window = opened(first="home")
    asked = []
    monkeypatch.setattr(workspace.flight, "do", lambda order, *rest: asked.append(order))
    window.actions_by_name["open_scenario"].trigger()
    (dialog,) = window.findChildren(QFileDialog)
    qtbot.waitExposed(dialog)
    qtbot.keyClick(dialog.findChild(QLineEdit), Qt.Key.Key_F12)
    assert asked == [Action(request="stop")]
    dialog.close()


def test_a_key_pressed_twice_opens_one_dialog(opened, qtbot):
    """The first comes back to the front with what was typed; a closed one does not."""
    window = opened(first="home")
    actions = window.actions_by_name

    def dialogs():
        return [each for each in window.findChildren(QFileDialog) if each.isVisible()]

    actions["open_scenario"].trigger()
    (scenario,) = dialogs()
    scenario.findChild(QLineEdit).setText("my.yaml")
    actions["open_log"].trigger()
    actions["open_log"].trigger()
    assert len(dialogs()) == 2
    actions["open_scenario"].trigger()
    assert len(dialogs()) == 2
    qtbot.waitUntil(scenario.isActiveWindow, timeout=60_000)
    assert scenario.findChild(QLineEdit).text() == "my.yaml"
    scenario.close()
    actions["open_scenario"].trigger()
    assert len(dialogs()) == 2 and scenario not in dialogs()
    for each in dialogs():
        each.close()
    ask_to_save(window, print)
    ask_to_save(window, print)
    (saving,) = dialogs()
    saving.close()


def test_what_the_window_showed_is_there_at_the_next_start(opened, workspace):
    workspace.preferences.store.setValue("window/1/beside", True)
    window = opened(first="home", view3d=True)
    window.resize(MIN_WINDOW_SIZE_PX[0], 700)  # the test's screen is too narrow for another width
    at_first = window.splitter.sizes()
    window.splitter.setSizes([sum(at_first), 0])  # as far as both can be dragged
    sizes = window.splitter.sizes()
    assert sizes != at_first
    window.show_screen("settings")
    window.close()
    again = opened(view3d=True)
    assert again.height() == 700
    assert again.stack.name == "settings"
    assert again.splitter.sizes() == sizes


def test_ctrl_0_shows_the_3d_view_which_is_closed_at_first_and_that_is_kept(opened, qtbot):
    window = opened(view3d=True)
    assert not window.view3d.isVisible()
    qtbot.keyClick(window, Qt.Key.Key_0, CTRL)
    assert window.view3d.isVisible()
    window.close()
    again = opened(view3d=True)
    assert again.view3d.isVisible()
    qtbot.keyClick(again, Qt.Key.Key_0, CTRL)
    again.close()
    assert not opened(view3d=True).view3d.isVisible()


def test_a_start_without_3d_leaves_the_next_one_its_view(opened):
    first = opened(view3d=True)
    first.actions_by_name["view_3d"].trigger()
    first.close()
    opened(view3d=False).close()
    assert opened(view3d=True).view3d.isVisible()


@pytest.mark.parametrize(
    ("key", "kept"),
    [("geometry", "nonsense"), ("screen", "kitchen"), ("beside", "perhaps"), ("splitter", 7)],
)
def test_settings_that_make_no_sense_are_passed_over(opened, workspace, key, kept):
    workspace.preferences.store.setValue(f"window/1/{key}", kept)
    assert opened(view3d=True).stack.name == "home"


def test_the_theme_is_chosen_in_the_menu(opened, workspace):
    window = opened()
    window.actions_by_name["theme_dark"].trigger()
    assert workspace.look.is_dark
    checked = [
        name
        for name in ("theme_system", "theme_light", "theme_dark")
        if window.actions_by_name[name].isChecked()
    ]
    assert checked == ["theme_dark"]


def test_leaving_the_window_lets_go(opened, qtbot, qapp):
    window = opened(first="joystick")
    window.activateWindow()
    other = QLineEdit()
    qtbot.addWidget(other)
    other.show()
    other.activateWindow()
    qtbot.waitUntil(lambda: "release" in window.stack.current.heard, timeout=5000)


def test_closing_ends_the_screens_once(opened):
    window = opened(first="home")
    home = window.stack.current
    window.close()
    window.close()
    assert home.heard.count("close") == 1


def test_a_flight_from_the_first_key_to_the_last(opened, qtbot, workspace, told, tmp_path):
    window = opened(first="home")
    window.workspace.flight.draws = False
    window.control.fly(Choice("network"))
    view = lambda: workspace.flight.view  # noqa: E731
    qtbot.waitUntil(lambda: view().phase is Phase.FLYING, timeout=FLYING)
    assert window.actions_by_name["take_off"].isEnabled()
    qtbot.keyClick(window, Qt.Key.Key_R, CTRL | Qt.KeyboardModifier.ShiftModifier)
    qtbot.waitUntil(lambda: window.recorder.is_recording, timeout=10_000)
    qtbot.keyClick(window, Qt.Key.Key_F6)
    qtbot.waitUntil(lambda: view().snapshot.mode is FlightMode.HOVERING, timeout=30_000)
    qtbot.keyClick(window, Qt.Key.Key_F9)
    qtbot.waitUntil(lambda: view().phase is Phase.PAUSED, timeout=10_000)
    stood = view().snapshot.time
    qtbot.keyClick(window, Qt.Key.Key_F10)
    qtbot.waitUntil(lambda: view().snapshot.time > stood, timeout=10_000)
    assert view().snapshot.time - stood == pytest.approx(1 / 128)
    qtbot.keyClick(window, Qt.Key.Key_F9)
    qtbot.waitUntil(lambda: view().phase is Phase.FLYING, timeout=10_000)
    qtbot.keyClick(window, Qt.Key.Key_F12)
    qtbot.waitUntil(lambda: view().snapshot.mode is FlightMode.OFF, timeout=10_000)
    qtbot.keyClick(window, Qt.Key.Key_R, CTRL)
    qtbot.waitUntil(lambda: view().snapshot.time < stood, timeout=10_000)
    window.close()
    assert workspace.flight.live is None
    logs = sorted((tmp_path / "logs").iterdir())
    assert len(logs) == 2  # a reset begins the next
    assert all(log.read_bytes().endswith(b"\x89MCAP0\r\n") for log in logs)
    assert [notice.severity.value for notice in told if notice.severity.value == "failure"] == []
