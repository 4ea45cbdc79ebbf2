"""All screens in the real window, before a flight out of a can: what holds for each of them."""

from itertools import product

import pytest
from PyQt6.QtCore import QEvent, QObject, Qt
from PyQt6.QtWidgets import (
    QAbstractButton,
    QAbstractSpinBox,
    QComboBox,
    QLabel,
    QLineEdit,
    QSlider,
    QToolButton,
)

from workbench.gui.elided_label import ElidedLabel
from workbench.gui.screen_table import SCREENS

NAMES = [row.name for row in SCREENS]
CONTROLS = (QAbstractButton, QAbstractSpinBox, QComboBox, QLineEdit, QSlider)


class Windows(QObject):
    """Takes note of every widget that is shown as a window of its own."""

    def __init__(self):
        super().__init__()
        self.seen = []

    def eventFilter(self, receiver, event):
        if event.type() == QEvent.Type.Show and receiver.isWidgetType() and receiver.isWindow():
            self.seen.append(type(receiver).__name__)
        return False


@pytest.fixture(scope="module")
def workspace(shared_workspace):
    return shared_workspace


@pytest.fixture
def play(workspace, canned, monkeypatch):
    """Show a view of the canned flight, with what was sampled until then."""

    def show(index):
        view = canned.views[index]
        monkeypatch.setattr(workspace.flight, "_view", view)
        if index == 0:
            workspace.flight.begun.emit(view)
        workspace.flight.streamed.emit(list(canned.published[index]))
        workspace.flight.viewed.emit(view)

    return show


@pytest.fixture(scope="module")
def windows(qapp):
    """Watch before the window is made: it is asked for before `shared_window`."""
    made = Windows()
    qapp.installEventFilter(made)
    yield made
    qapp.removeEventFilter(made)


@pytest.fixture
def window(windows, shared_window, play):
    shared_window.resize(1280, 720)
    for index in range(60):
        play(index)
    return shared_window


def test_there_is_one_window(window, windows, qapp):
    for name in NAMES:
        window.show_screen(name)
        qapp.processEvents()
    assert windows.seen == ["MainWindow"]


def test_every_control_has_a_name(window, qapp):
    buddies = {label.buddy() for label in window.findChildren(QLabel)}
    for name in NAMES:
        window.show_screen(name)
        qapp.processEvents()
        for control in window.stack.current.findChildren(CONTROLS):
            if not control.isVisible() or control.focusPolicy() is Qt.FocusPolicy.NoFocus:
                continue
            if isinstance(control.parent(), QAbstractSpinBox | QComboBox):
                continue  # part of a control that has a name
            named = control.accessibleName() or control in buddies or control.focusProxy()
            text = control.text() if isinstance(control, QAbstractButton) else ""
            assert named or text, f"{name}: {type(control).__name__} in {control.parent()}"


def test_no_text_of_a_button_or_label_is_cut(window, workspace, qapp):
    for theme, name in product(("light", "dark"), NAMES):
        workspace.preferences.set("theme", theme)
        window.show_screen(name)
        qapp.processEvents()
        for each in window.findChildren((QLabel, QAbstractButton)):
            if each.isVisible() and not isinstance(each, ElidedLabel):  # a tool tip has all of it
                assert text_width(each) <= each.width(), f"{theme} {name}: '{each.text()}'"


def text_width(each):
    """Return the width of a plain text that stands in one line, 0 for any other [px]."""
    if isinstance(each, QLabel) and (each.wordWrap() or "<" in each.text()):
        return 0
    if "paintEvent" in vars(type(each)) or is_icon(each):
        return 0
    return each.fontMetrics().horizontalAdvance(each.text().replace("&", ""))


def is_icon(each):
    """Return whether a button shows a picture, and has its text for readers of screens alone."""
    alone = Qt.ToolButtonStyle.ToolButtonIconOnly
    shown = isinstance(each, QToolButton) and each.toolButtonStyle() is alone
    return shown and not each.icon().isNull()
