"""Every number field of every screen and dialog, typed into by the keyboard in the real window."""

import copy
import dataclasses

import pytest
from PyQt6.QtCore import Qt
from PyQt6.QtWidgets import QAbstractSpinBox, QApplication, QLineEdit, QScrollArea, QTabWidget

from workbench.common.errors import WorkbenchError
from workbench.gui.number_field import NumberField, read_number
from workbench.gui.screen_table import SCREEN_TABLE
from workbench.gui.units import SHARE_UNIT
from workbench.live.orders import FlightOrder, SetSpeed
from workbench.scenario.scenario import Action

RIGHT = {
    "1.2": 1.2,
    "1,2": 1.2,
    "0,5": 0.5,
    ",5": 0.5,
    "-0,5": -0.5,
    "1e-1": 0.1,
    "1,5E+1": 15.0,
    "1e9": 1e9,
    "+3": 3.0,
    " 7 ": 7.0,
}
"""What is typed, and the number that it says."""
FEW = {text: RIGHT[text] for text in ("1,2", "-0,5", "1e9")}
WRONG = ("1.000,5", "1,000.5", "1.2.3", "1 2", "abc", "", "1e", "--1", "1e999", "nan", "0x10")
"""What says no number."""


def test_a_comma_separates_decimals_and_nothing_else():
    for text, number in RIGHT.items():
        assert read_number(text) == number, text
    for text in WRONG:
        with pytest.raises(WorkbenchError, match=r"\.$"):
            read_number(text)


@pytest.fixture
def window(shared_window, workspace, canned, unasked, monkeypatch):
    """The window with all its screens, before a flight out of a can that does what it is told.

    It is a flight of the test's own, of another vehicle: what was typed before is not proposed.
    """
    view = dataclasses.replace(canned.views[0], vehicle=copy.copy(canned.views[0].vehicle))
    monkeypatch.setattr(workspace.flight, "_view", view)
    monkeypatch.setattr(workspace.flight, "do", lambda order, done=None, refused=None: None)
    workspace.flight.begun.emit(view)
    workspace.flight.viewed.emit(view)
    return shared_window


def uncover(window, widget) -> bool:
    """Show a widget as its user would: open what it is in; return whether it can be seen then."""
    part = widget
    while part is not None and part is not window:
        parent = part.parentWidget()
        tabs = parent.parentWidget() if parent is not None else None
        if isinstance(tabs, QTabWidget) and tabs.indexOf(part) >= 0:
            tabs.setCurrentWidget(part)
        elif isinstance(parent, QScrollArea):
            parent.ensureWidgetVisible(widget)
        part.setVisible(True)
        part = parent
    QApplication.processEvents()
    return widget.isVisible() and widget.isEnabled()


def enter(qtbot, field, text) -> None:
    """Type a text in place of what stands there, unit and all, and leave with Enter."""
    field.setFocus()
    field.selectAll()
    qtbot.keyClick(field, Qt.Key.Key_Delete)
    qtbot.keyClicks(field, text)
    qtbot.keyClick(field, Qt.Key.Key_Return)


def try_field(qtbot, field, right, wrong) -> int:
    """Type texts into one field; return how many it took."""
    name, taken = field.accessibleName(), 0
    for text, number in right.items():
        before = field.value()
        enter(qtbot, field, text)
        if field.fault:
            refused(field, text.strip(), before, name)
        elif not said_beside(field):
            assert field.value() == pytest.approx(number, rel=1e-9), f"{name}: {text}"
            assert "bad" not in str(field.property("class")), name
            taken += 1
    for text in wrong:
        before = field.value()
        enter(qtbot, field, text)
        refused(field, text.strip(), before, name)
    qtbot.keyClick(field, Qt.Key.Key_Escape)
    assert not field.fault, f"{name}: Escape brings the value back"
    return taken


def refused(field, text, before, name) -> None:
    """Assert that a text stands where it was typed, is marked and told, and has changed nothing."""
    assert field.cleanText() == text, f"{name}: {text} is gone, {field.text()} stands there"
    assert field.value() == before, f"{name}: {text} was taken"
    assert field.fault.endswith("."), f"{name}: {text}"
    assert field.accessibleDescription() == field.fault, name
    assert "bad" in str(field.property("class")), f"{name}: {text} is not marked"
    assert field.toolTip() == field.fault or said_beside(field), f"{name}: {text} is not told"


def said_beside(field) -> str:
    """Return what the tool tip of a gain's field says is wrong with it."""
    first = field.toolTip().splitlines()[:1]
    return "".join(first) if first and first[0].startswith("✕") else ""


def test_what_flies_is_what_was_typed(window, qtbot, workspace, monkeypatch):
    """A gain, a limit and the speed, as they are ordered of the flight."""
    ordered = []

    def do(order, done=None, refused=None):
        if order is not FlightOrder.GET_CHECKPOINT:
            ordered.append(order)

    monkeypatch.setattr(workspace.flight, "do", do)
    window.show_screen("tuning")
    panel = window.stack.current.panel
    monkeypatch.setattr(window.stack.current.gains._stability, "knows", lambda values: True)
    enter(qtbot, panel.rows["max_climb_rate"].field, "1,2")
    assert ordered.pop() == Action(set={"max_climb_rate": 1.2})
    enter(qtbot, window.top_bar.speed, "0,5")
    assert ordered.pop() == SetSpeed(0.5)
    for text in ("1.000,5", "1e9", "abc"):
        enter(qtbot, window.top_bar.speed, text)
        assert window.top_bar.speed.cleanText() == text
    assert not ordered


def test_a_typed_number_is_held_even_beside_what_is_shown(qtbot):
    field = NumberField("Thrust left", 0, 5.0)
    qtbot.addWidget(field)
    field.set_range(SHARE_UNIT, 0.0, 1.0)
    told = []
    field.edited.connect(told.append)
    field.show()
    for typed in ("99.6", "100", "20.1", "20", "80.4", "80", "0.5", "33.3333", "33.333"):
        enter(qtbot, field, typed)
        assert field.si == pytest.approx(float(typed) / 100.0, rel=1e-12), typed
        assert told.pop() == field.si and not told, typed
        assert float(field.text().split()[0]) == pytest.approx(float(typed), rel=1e-4)


def test_a_value_keeps_the_decimals_that_are_not_shown(qtbot):
    """Also one that comes while a text is typed that shows alike."""
    field = NumberField("Thrust left", 0, 5.0)
    qtbot.addWidget(field)
    field.set_range(SHARE_UNIT, 0.0, 1.0)
    told = []
    field.edited.connect(told.append)
    field.show()
    field.selectAll()
    qtbot.keyClicks(field, "80")
    field.show_si(0.800001)
    field.interpretText()
    qtbot.keyClick(field, Qt.Key.Key_Return)
    assert (field.si, field.text(), told) == (0.800001, "80\N{NO-BREAK SPACE}%", [])


def test_lines_with_a_number_in_them_follow_the_same_rule(window, qtbot):
    """The server's port is a text; its number is read alike."""
    window.show_screen("server")
    form = window.stack.current.form
    port = form.lines["port"]
    assert isinstance(port, QLineEdit)
    for text, number in (("7,7e3", 7700), ("7733", 7733), ("1,2", None), ("77.33", None)):
        enter(qtbot, port, text)
        assert port.text() == text
        assert bool(form.fault("port")) == (number is None), form.fault("port")
        assert number is None or form.config.port == number


def test_every_number_field_takes_what_is_typed_or_says_why_not(window, qtbot):
    """What is read of each text is one rule; a field adds its range, and whether it is whole."""
    tried, taken = [], 0
    for row in SCREEN_TABLE:
        window.show_screen(row.name)
        if row.name == "tuning":
            window.stack.current.panel._make_more()
        for field in window.findChildren(QAbstractSpinBox):
            if field in tried or not uncover(window, field):
                continue
            assert isinstance(field, NumberField), f"{field.accessibleName()} takes 1,2 for 12"
            few = len(tried) > 3  # all texts in some fields, and one of each kind in all
            taken += try_field(qtbot, field, FEW if few else RIGHT, WRONG[:1] if few else WRONG)
            tried.append(field)
    left = [each for each in window.findChildren(QAbstractSpinBox) if each not in tried]
    assert not [each.accessibleName() for each in left if each.isEnabled()]
    assert len(tried) > 60
    assert taken > 100
