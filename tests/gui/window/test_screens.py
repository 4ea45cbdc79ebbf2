"""The screens: how they are reached, made, told, and what if one fails."""

import dataclasses
import importlib
import sys
from pathlib import Path
from types import SimpleNamespace

import pytest
from PyQt6.QtCore import Qt

from workbench.common.resources import find_model
from workbench.gui.main_window import MainWindow
from workbench.gui.recent_files import FileKind
from workbench.gui.screen_table import SCREEN_TABLE, ScreenRow
from workbench.gui.screens import ScreenStack

CTRL = Qt.KeyboardModifier.ControlModifier


def test_ctrl_and_a_number_show_the_screens(opened, qtbot):
    window = opened()
    for row in SCREEN_TABLE:
        qtbot.keyClick(window, Qt.Key(ord(row.shortcut[-1])), CTRL)
        assert window.stack.name == row.name
        marked = [name for name in window.actions_by_name if name.startswith("show_")]
        on = [name for name in marked if window.actions_by_name[name].isChecked()]
        assert on == [f"show_{row.name}"]


def test_home_shows_the_flight_that_replaces_the_one_of_the_start_page(
    opened, workspace, canned, monkeypatch, qtbot
):
    """A reset, the app's own first flight and an opening that fails or is cancelled stay there."""
    started = []
    monkeypatch.setattr(workspace.flight, "fly", lambda what, draw: started.append(what))
    window = opened(first="start")
    qtbot.waitUntil(lambda: window._known_flight is not None)
    workspace.flight.begun.emit(canned.views[0])
    workspace.recent.wanted.emit(FileKind.MODEL, find_model("gimbal"))
    assert [what.model for what in started] == [str(find_model("gimbal"))]
    workspace.flight.begun.emit(canned.views[0])  # it has failed, and the present one is reset
    assert window.stack.name == "start"
    monkeypatch.setattr(type(workspace.flight), "what", started[0])
    workspace.flight.begun.emit(canned.views[0])
    assert window.stack.name == "home"
    window.show_screen("start")
    workspace.flight.begun.emit(canned.views[0])
    assert window.stack.name == "start"


def test_the_side_bar_shows_the_screens(opened, qtbot):
    window = opened()
    layout = window.side_bar.layout()
    for at, row in enumerate(SCREEN_TABLE):
        button = layout.itemAt(at).widget()
        assert row.title in button.accessibleName()
        qtbot.mouseClick(button, Qt.MouseButton.LeftButton)
        assert window.stack.name == row.name
        assert button.isChecked()


def test_the_window_is_painted_before_the_first_screen_is_made(opened, qtbot, monkeypatch):
    """At the first start the guide's screen took seconds, and the window was black."""
    seen = []

    def note(self, row, make=ScreenStack._make):
        seen.append((row.name, self.window()._painted, self.currentWidget().accessibleName()))
        return make(self, row)

    monkeypatch.setattr(ScreenStack, "_make", note)
    monkeypatch.setattr(MainWindow, "_show_tuning", lambda self: SimpleNamespace(tried=()))
    begin = MainWindow.show
    monkeypatch.setattr(MainWindow, "show", lambda self: (self.begin_with_guide(), begin(self)))
    window = opened()
    assert seen[0] == ("tuning", True, "Starting screen")
    assert window.stack.name == "tuning" and window.guide.isVisible()
    assert window.stack.indexOf(window.stack.currentWidget()) == 0  # "Starting" has gone


def test_all_screens_are_made_while_nothing_is_to_do(opened, qtbot):
    window = opened()
    qtbot.waitUntil(lambda: window.stack.count() == len(SCREEN_TABLE), timeout=10_000)


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
    qtbot.waitUntil(lambda: window.stack.count() == len(SCREEN_TABLE), timeout=10_000)
    show(canned.views[0])
    workspace.flight.begun.emit(canned.views[0])
    for row in SCREEN_TABLE:
        assert "begin" in window.stack.screen_of(row.name).heard


def test_a_screen_that_is_made_late_hears_of_the_flight(opened, show, canned, rows):
    window = opened(first="home", rows=rows)
    window.stack._ahead = []
    show(canned.views[0])
    window.show_screen("tuning")
    assert window.stack.current.heard[0] == "begin"


def test_a_screen_that_cannot_be_made_is_a_page_and_a_notice(opened, rows, told, qtbot):
    broken = dataclasses.replace(rows[2], kind="BrokenPage")
    window = opened(rows=(*rows[:2], broken, *rows[3:]), first="server")
    assert window.stack.current is None
    assert "the Server screen cannot be shown: RuntimeError: no more paint" in told[0].what
    qtbot.keyClick(window, Qt.Key.Key_1, CTRL)
    assert window.stack.name == "home"


def test_a_screen_that_fails_as_it_begins_is_made_once(
    opened, light, rows, show, canned, monkeypatch
):
    class Stumbling(light.Page):
        made = 0

        def __init__(self, workspace):
            super().__init__(workspace)
            Stumbling.made += 1

        def begin(self, view):
            raise RuntimeError("not this flight")

    module = sys.modules["workbench.gui.light_page"]
    monkeypatch.setattr(module, "Stumbling", Stumbling, raising=False)
    window = opened(first="home", rows=(rows[1], dataclasses.replace(rows[2], kind="Stumbling")))
    window.stack._ahead = []
    show(canned.views[0])
    with pytest.raises(RuntimeError):
        window.show_screen("server")
    window.show_screen("server")
    assert Stumbling.made == 1
    assert window.stack.name == "server"


def test_a_missing_module_is_a_page_and_a_notice(opened, rows, told):
    gone = dataclasses.replace(rows[5], module="nowhere.screen")
    opened(rows=(*rows[:5], gone, rows[6]), first="tuning")
    assert "the Tuning screen cannot be shown" in told[0].what


def test_the_real_table_names_modules_of_the_app():
    folder = Path(importlib.import_module("workbench.gui").__file__).parent
    for row in SCREEN_TABLE:
        assert isinstance(row, ScreenRow)
        assert (folder / (row.module.replace(".", "/") + ".py")).is_file(), row.module
