"""The window: screens, keys, files that are dropped, what is kept, and its end."""

import dataclasses
import gc
import importlib
import sys
import types
from pathlib import Path

import pytest
from PyQt6.QtCore import QMimeData, QPointF, Qt, QUrl
from PyQt6.QtGui import QDropEvent
from PyQt6.QtWidgets import QDoubleSpinBox, QFileDialog, QLineEdit, QVBoxLayout

from workbench.gui.help_pages import KeysPage
from workbench.gui.main_window import MainWindow
from workbench.gui.opening import FileKind
from workbench.gui.recorder import log_name, size_text
from workbench.gui.screen import Screen
from workbench.gui.screen_table import SCREENS, ScreenRow
from workbench.live.choice import Choice
from workbench.live.messages import Phase
from workbench.live.network_orders import NetworkView
from workbench.resources import find_scenario
from workbench.scenario import Scenario, SensorsConfig
from workbench.systems.mode import FlightMode

FLYING = 60_000
"""Longest wait for a flight to begin [ms]."""


class Page(Screen):
    """A screen that notes what is done to it."""

    def __init__(self, workspace, parent=None):
        super().__init__(workspace, parent)
        self.heard = []
        layout = QVBoxLayout(self)
        self.number, self.line = QDoubleSpinBox(), QLineEdit()
        layout.addWidget(self.number)
        layout.addWidget(self.line)

    def begin(self, view):
        self.heard.append("begin")

    def show_view(self, view):
        self.heard.append("view")

    def release(self):
        self.heard.append("release")

    def close_screen(self):
        self.heard.append("close")

    def open_log(self, path):
        self.heard.append(f"log {path.name}")


class BrokenPage(Screen):
    def __init__(self, workspace, parent=None):
        raise RuntimeError("no more paint")


@pytest.fixture
def rows(monkeypatch):
    """The six screens, light ones."""
    module = types.ModuleType("workbench.gui.light_page")
    module.Page, module.BrokenPage = Page, BrokenPage
    monkeypatch.setitem(sys.modules, module.__name__, module)
    return tuple(dataclasses.replace(row, module="light_page", kind="Page") for row in SCREENS)


@pytest.fixture
def opened(qtbot, workspace, rows, tmp_path):
    """Open a window without 3-D and show its first screen."""
    workspace.preferences.set("log_folder", str(tmp_path / "logs"))
    windows = []

    def open_window(rows=rows, **options):
        window = MainWindow(workspace, rows, **{"view3d": False, **options})
        windows.append(window)
        qtbot.addWidget(window)
        window.show()
        qtbot.waitUntil(lambda: window.stack.name != "", timeout=10_000)
        return window

    yield open_window
    for window in windows:
        window.close()


@pytest.fixture
def show(workspace, monkeypatch):
    def show_view(view):
        monkeypatch.setattr(workspace.flight, "_view", view)
        workspace.flight.viewed.emit(view)

    return show_view


def press(qtbot, window, key, modifier=Qt.KeyboardModifier.NoModifier):
    qtbot.keyClick(window, key, modifier)


CTRL = Qt.KeyboardModifier.ControlModifier


def test_ctrl_and_a_number_show_the_screens(opened, qtbot):
    window = opened()
    for number, row in enumerate(SCREENS):
        press(qtbot, window, Qt.Key(Qt.Key.Key_1 + number), CTRL)
        assert window.stack.name == row.name
        marked = [name for name in window.actions_by_name if name.startswith("show_")]
        on = [name for name in marked if window.actions_by_name[name].isChecked()]
        assert on == [f"show_{row.name}"]


def test_the_side_bar_shows_the_screens(opened, qtbot):
    window = opened()
    layout = window.side_bar.layout()
    for at, row in enumerate(SCREENS):
        button = layout.itemAt(at).widget()
        assert row.title in button.accessibleName()
        qtbot.mouseClick(button, Qt.MouseButton.LeftButton)
        assert window.stack.name == row.name
        assert button.isChecked()


def test_all_screens_are_made_while_nothing_is_to_do(opened, qtbot):
    window = opened()
    qtbot.waitUntil(lambda: window.stack.count() == len(SCREENS), timeout=10_000)


def test_the_collector_passes_over_what_lives_as_long_as_the_window(opened, qtbot):
    gc.unfreeze()
    window = opened(first="home")
    qtbot.waitUntil(lambda: gc.get_freeze_count() > 0, timeout=10_000)
    assert window.isVisible()
    gc.unfreeze()


def test_the_screen_that_is_left_lets_go_and_only_the_seen_one_is_shown(opened, show, canned):
    window = opened(first="home")
    home = window.stack.current
    window.show_screen("joystick")
    assert home.heard == ["release"]
    show(canned.views[0])
    assert home.heard == ["release"]
    assert window.stack.current.heard == ["view"]


def test_every_screen_hears_that_a_flight_begins(opened, qtbot, workspace, show, canned):
    window = opened(first="home")
    qtbot.waitUntil(lambda: window.stack.count() == len(SCREENS), timeout=10_000)
    show(canned.views[0])
    workspace.flight.begun.emit(canned.views[0])
    for row in SCREENS:
        assert "begin" in window.stack.screen_of(row.name).heard


def test_a_screen_that_is_made_late_hears_of_the_flight(opened, show, canned, rows):
    window = opened(first="home", rows=rows)
    window.stack._ahead = []
    show(canned.views[0])
    window.show_screen("tuning")
    assert window.stack.current.heard[0] == "begin"


def test_a_screen_that_cannot_be_made_is_a_page_and_a_notice(opened, rows, told, qtbot):
    broken = dataclasses.replace(rows[1], kind="BrokenPage")
    window = opened(rows=(rows[0], broken, *rows[2:]), first="server")
    assert window.stack.current is None
    assert "the Server screen cannot be shown: RuntimeError: no more paint" in told[0].what
    press(qtbot, window, Qt.Key.Key_1, CTRL)
    assert window.stack.name == "home"


def test_a_screen_that_fails_as_it_begins_is_made_once(opened, rows, show, canned, monkeypatch):
    class Stumbling(Page):
        made = 0

        def __init__(self, workspace, parent=None):
            super().__init__(workspace, parent)
            Stumbling.made += 1

        def begin(self, view):
            raise RuntimeError("not this flight")

    module = sys.modules["workbench.gui.light_page"]
    monkeypatch.setattr(module, "Stumbling", Stumbling, raising=False)
    window = opened(first="home", rows=(rows[0], dataclasses.replace(rows[1], kind="Stumbling")))
    window.stack._ahead = []
    show(canned.views[0])
    with pytest.raises(RuntimeError):
        window.show_screen("server")
    window.show_screen("server")
    assert Stumbling.made == 1
    assert window.stack.name == "server"


def test_a_missing_module_is_a_page_and_a_notice(opened, rows, told):
    gone = dataclasses.replace(rows[4], module="nowhere.screen")
    opened(rows=(*rows[:4], gone, rows[5]), first="tuning")
    assert "the Tuning screen cannot be shown" in told[0].what


def test_the_real_table_names_modules_of_the_app():
    folder = Path(importlib.import_module("workbench.gui").__file__).parent
    for row in SCREENS:
        assert isinstance(row, ScreenRow)
        assert (folder / (row.module.replace(".", "/") + ".py")).is_file(), row.module


@pytest.mark.parametrize("field", ["number", "line"])
def test_the_stop_key_works_wherever_the_keyboard_is(opened, qtbot, workspace, field, monkeypatch):
    window = opened(first="home")
    asked = []
    monkeypatch.setattr(workspace.flight, "order", lambda give, *rest: give(Asked(asked)))
    widget = getattr(window.stack.current, field)
    widget.setFocus()
    qtbot.keyClick(widget, Qt.Key.Key_F12)
    assert asked == [("request", "stop")]
    window.top_bar.speed.setFocus()
    qtbot.keyClick(window.top_bar.speed, Qt.Key.Key_F12)
    assert asked == [("request", "stop")] * 2


def test_the_stop_key_works_above_an_open_dialog(opened, qtbot, workspace, monkeypatch):
    window = opened(first="home")
    asked = []
    monkeypatch.setattr(workspace.flight, "order", lambda give, *rest: give(Asked(asked)))
    window.actions_by_name["open_scenario"].trigger()
    (dialog,) = window.findChildren(QFileDialog)
    qtbot.waitExposed(dialog)
    qtbot.keyClick(dialog.findChild(QLineEdit), Qt.Key.Key_F12)
    assert asked == [("request", "stop")]
    dialog.close()


class Asked:
    """A live flight that notes what it is asked for."""

    def __init__(self, asked):
        self._asked = asked

    def __getattr__(self, name):
        return lambda *args: self._asked.append((name, *args))


@pytest.fixture
def flown(workspace, monkeypatch):
    """What the window wants to fly."""
    choices = []

    def fly(choice, draw):
        workspace.flight.what = choice
        choices.append(choice)

    monkeypatch.setattr(workspace.flight, "fly", fly)
    return choices


def drop(window, path):
    mime = QMimeData()
    mime.setUrls([QUrl.fromLocalFile(str(path))])
    event = QDropEvent(
        QPointF(10.0, 10.0),
        Qt.DropAction.CopyAction,
        mime,
        Qt.MouseButton.LeftButton,
        Qt.KeyboardModifier.NoModifier,
    )
    window.dropEvent(event)


def test_a_dropped_file_is_flown_for_what_it_is(opened, flown, tmp_path):
    window = opened()
    drone, world = tmp_path / "mine.sdf", tmp_path / "park.world"
    drone.write_text("<sdf/>")
    world.write_text("<sdf/>")
    drop(window, find_scenario("windy"))
    drop(window, world)
    drop(window, drone)
    windy = str(find_scenario("windy"))
    assert flown == [
        Choice(windy),
        Choice(windy, world=str(world)),
        Choice(windy, model=str(drone), world=str(world), sensors=("all",)),
    ]
    assert [each.kind for each in window.recent.files()] == [
        FileKind.MODEL,
        FileKind.WORLD,
        FileKind.SCENARIO,
    ]


def test_a_dropped_log_goes_to_the_charts(opened, tmp_path):
    window = opened(first="home")
    log = tmp_path / "flight.mcap"
    log.write_bytes(b"")
    drop(window, log)
    assert window.stack.name == "visualization"
    assert window.stack.current.heard[-1] == "log flight.mcap"


def test_a_world_that_is_opened_after_a_set_up_keeps_the_rest_of_it(opened, flown):
    window = opened()
    window.desk.fly(Scenario(duration=7.0, sensors=SensorsConfig(use=["imu"])))
    window.desk.fly_world("room")
    window.desk.fly_model("cf2x")
    assert (flown[1].duration, flown[1].world, flown[1].sensors.use) == (7.0, "room", ["imu"])
    assert (flown[2].world, flown[2].vehicle.model) == ("room", "cf2x")


def test_what_cannot_be_opened_is_a_notice(opened, told, tmp_path):
    window = opened()
    letter = tmp_path / "letter.txt"
    letter.write_text("Dear Ada")
    drop(window, letter)
    assert "letter.txt cannot be opened" in told[0].what
    drop(window, tmp_path / "gone.mcap")
    assert "gone.mcap: no such file" in told[1].what


def test_recent_files_fly_again_from_the_menu(opened, flown):
    window = opened()
    window.opener.open(FileKind.SCENARIO, find_scenario("hover"))
    (action,) = window._recent_menu._menu.actions()
    assert "hover.yaml" in action.text()
    action.trigger()
    assert flown == [Choice(str(find_scenario("hover")))] * 2


def test_what_the_window_showed_is_there_at_the_next_start(opened):
    window = opened(first="home", view3d=True)
    window.resize(1024, 700)
    window.splitter.setSizes([700, 400])
    sizes = window.splitter.sizes()
    window.show_screen("settings")
    window.close()
    again = opened(view3d=True)
    assert again.height() == 700  # the test's screen is too narrow for another width
    assert again.stack.name == "settings"
    assert again.splitter.sizes() == sizes


def test_ctrl_0_hides_the_3d_view_and_that_is_kept(opened, qtbot):
    window = opened(view3d=True)
    assert window.view3d.isVisible()
    press(qtbot, window, Qt.Key.Key_0, CTRL)
    assert not window.view3d.isVisible()
    window.close()
    assert not opened(view3d=True).view3d.isVisible()


def test_a_start_without_3d_leaves_the_next_one_its_view(opened):
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


def test_a_screenshot_goes_to_the_folder_and_is_told(opened, qtbot, told, tmp_path):
    window = opened()
    window.actions_by_name["screenshot"].trigger()
    qtbot.waitUntil(lambda: bool(told), timeout=10_000)
    (picture,) = (tmp_path / "logs").iterdir()
    assert told[0].what == f"wrote {picture}"
    assert picture.read_bytes().startswith(b"\x89PNG")


def test_a_folder_that_cannot_be_written_is_a_notice(opened, qtbot, told, workspace, tmp_path):
    (tmp_path / "file").write_text("")
    workspace.preferences.set("log_folder", str(tmp_path / "file"))
    window = opened()
    window.actions_by_name["screenshot"].trigger()
    qtbot.waitUntil(lambda: bool(told), timeout=10_000)
    assert "could not be written" in told[0].what
    assert "Settings" in told[0].remedy
    window.recorder.toggle()
    assert "the folder for logs cannot be made" in told[1].what


def test_a_log_that_ends_by_itself_is_told_and_the_flight_goes_on(opened, show, canned, told):
    window = opened()
    view = canned.views[0]
    show(dataclasses.replace(view, network=NetworkView(log="/tmp/a.mcap")))
    assert window.recorder.is_recording
    assert window.actions_by_name["record"].isChecked()
    show(dataclasses.replace(view, network=NetworkView(said="the disk is full")))
    assert told[0].what == "recording has ended: the disk is full"
    assert "The flight goes on" in told[0].remedy
    assert not window.actions_by_name["record"].isChecked()


def test_a_log_that_ends_with_its_flight_is_kept_and_told(opened, show, canned, told):
    """A reset goes on in the next file; a flight that is over, or dead, records no more."""
    window = opened()
    first = dataclasses.replace(canned.views[0], network=NetworkView(log="/tmp/a.mcap"))
    second = dataclasses.replace(first, network=NetworkView(log="/tmp/a-2.mcap"))
    for view in (first, second, second.ended("the flight's process was killed")):
        show(view)
    assert not window.recorder.is_recording
    assert not window.actions_by_name["record"].isChecked()
    assert [each.what for each in told] == ["recorded /tmp/a.mcap", "recorded /tmp/a-2.mcap"]


def test_log_names_suit_file_systems():
    from datetime import datetime

    noon = datetime(2026, 3, 4, 12, 30, 5)
    assert log_name("dh_drone", noon) == "dh_drone-20260304-123005.mcap"
    assert log_name("a/b: ü", noon) == "a_b_-20260304-123005.mcap"
    assert [size_text(size) for size in (0, 12_300, 4_560_000, 7_890_000_000)] == [
        "0 kB",
        "12 kB",
        "4.6 MB",
        "7.89 GB",
    ]


def test_the_page_of_keys_lists_every_shortcut(qtbot):
    from PyQt6.QtWidgets import QLabel

    from workbench.gui.actions import ACTIONS

    page = KeysPage()
    qtbot.addWidget(page)
    words = " ".join(label.text() for label in page.findChildren(QLabel))
    for row in ACTIONS:
        assert row.shortcut in words
        assert not row.shortcut or row.help in words


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
    window.desk.fly(Choice("network"))
    view = lambda: workspace.flight.view  # noqa: E731
    qtbot.waitUntil(lambda: view().phase is Phase.FLYING, timeout=FLYING)
    assert window.actions_by_name["take_off"].isEnabled()
    press(qtbot, window, Qt.Key.Key_R, CTRL | Qt.KeyboardModifier.ShiftModifier)
    qtbot.waitUntil(lambda: window.recorder.is_recording, timeout=10_000)
    press(qtbot, window, Qt.Key.Key_F6)
    qtbot.waitUntil(lambda: view().snapshot.mode is FlightMode.HOVERING, timeout=30_000)
    press(qtbot, window, Qt.Key.Key_F9)
    qtbot.waitUntil(lambda: view().phase is Phase.PAUSED, timeout=10_000)
    stood = view().snapshot.time
    press(qtbot, window, Qt.Key.Key_F10)
    qtbot.waitUntil(lambda: view().snapshot.time > stood, timeout=10_000)
    assert view().snapshot.time - stood == pytest.approx(1 / 128)
    press(qtbot, window, Qt.Key.Key_F9)
    qtbot.waitUntil(lambda: view().phase is Phase.FLYING, timeout=10_000)
    press(qtbot, window, Qt.Key.Key_F12)
    qtbot.waitUntil(lambda: view().snapshot.mode is FlightMode.OFF, timeout=10_000)
    press(qtbot, window, Qt.Key.Key_R, CTRL)
    qtbot.waitUntil(lambda: view().snapshot.time < stood, timeout=10_000)
    window.close()
    assert workspace.flight.live is None
    logs = sorted((tmp_path / "logs").iterdir())
    assert len(logs) == 2  # a reset begins the next
    assert all(log.read_bytes().endswith(b"\x89MCAP0\r\n") for log in logs)
    assert [notice.severity.value for notice in told if notice.severity.value == "failure"] == []
