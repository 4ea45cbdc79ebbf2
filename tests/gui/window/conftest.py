"""A window of six light screens."""

import dataclasses
import sys
import types

import pytest
from PyQt6.QtWidgets import QDoubleSpinBox, QLineEdit, QVBoxLayout

from workbench.gui.main_window import MainWindow
from workbench.gui.screen_table import SCREEN_TABLE
from workbench.gui.screens import Screen


class Page(Screen):
    """A screen that notes what is done to it."""

    def __init__(self, workspace):
        super().__init__(workspace)
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
    def __init__(self, workspace):
        raise RuntimeError("no more paint")


@pytest.fixture
def light(monkeypatch):
    """The module that has the light screens."""
    module = types.ModuleType("workbench.gui.light_page")
    module.Page, module.BrokenPage = Page, BrokenPage
    monkeypatch.setitem(sys.modules, module.__name__, module)
    return module


@pytest.fixture
def rows(light):
    """The six screens, light ones."""
    return tuple(dataclasses.replace(row, module="light_page", kind="Page") for row in SCREEN_TABLE)


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
