"""Where the keyboard is: Tab, single keys and Space over the real window."""

from collections import defaultdict

import pytest
from PyQt6.QtCore import Qt
from PyQt6.QtGui import QKeySequence
from PyQt6.QtTest import QTest
from PyQt6.QtWidgets import QAbstractButton, QApplication, QComboBox, QLabel, QTabWidget

from tests.gui.conftest import view_of
from workbench.control.mode import FlightMode
from workbench.gui.screen_table import SCREEN_TABLE
from workbench.gui.tuning.excitation_card import ExcitationCard
from workbench.live.messages import Phase
from workbench.live.orders import FlightOrder
from workbench.scenario.excitation import Excitation

LEFT = Qt.MouseButton.LeftButton
CONTROL = Qt.KeyboardModifier.ControlModifier


@pytest.fixture(scope="module")
def workspace(shared_workspace):
    return shared_workspace


@pytest.fixture
def window(shared_window, qtbot):
    shared_window.activateWindow()
    qtbot.waitUntil(shared_window.isActiveWindow)
    yield shared_window
    shared_window.resize(1280, 720)


@pytest.fixture
def flying(window, orders, canned, show):
    """A drone that hovers, and the orders to it."""
    show(view_of(canned, Phase.FLYING, FlightMode.HOVERING))
    orders.clear()
    return orders


def press(key, modifier=Qt.KeyboardModifier.NoModifier):
    QTest.keyClick(QApplication.focusWidget(), key, modifier)


def click(window, widget):
    """Click in the window's middle of a widget, as the window system reports it."""
    place = widget.mapTo(window, widget.rect().center())
    QTest.mouseClick(window.windowHandle(), LEFT, pos=place)
    QApplication.processEvents()


def test_tab_reaches_the_first_gain_second(window, flying):
    window.show_screen("home")
    window.show_screen("tuning")
    window.top_bar.speed.setFocus()
    window.show_screen("tuning")  # again: the focus comes back
    QApplication.processEvents()
    panel = window.stack.current.panel
    row = next(iter(panel.rows.values()))
    press(Qt.Key.Key_Tab)
    press(Qt.Key.Key_Tab)
    assert QApplication.focusWidget() is row.slider
    press(Qt.Key.Key_Tab)
    assert QApplication.focusWidget() is row.field


def test_the_key_of_the_excitation_works_whatever_tab_is_shown(window, flying):
    """In a narrow window the card is in a tab of its own."""
    window.show_screen("tuning")
    window.resize(960, 600)
    QApplication.processEvents()
    screen = window.stack.current
    screen.excitation.show_view(window.workspace.flight.view)
    screen.tabs.setCurrentWidget(screen.margins)
    assert not screen.findChild(ExcitationCard).isVisible()
    press(Qt.Key.Key_E, CONTROL)
    assert [type(order) for order in flying] == [Excitation]


def test_letters_are_for_the_charts_wherever_the_mouse_has_clicked(window, flying):
    window.show_screen("visualization")
    screen = window.stack.current
    screen.tabs.setCurrentWidget(screen.charts)
    click(window, screen.charts.add.parentWidget())
    for box in (screen.charts.presets, screen.charts.signals_shown):
        assert isinstance(box, QComboBox) or box.isCheckable()
        click(window, box)
        if popup := QApplication.activePopupWidget():
            popup.close()
        assert QApplication.focusWidget() is not box
    preset = screen.charts.presets.currentText()
    press(Qt.Key.Key_A)
    press(Qt.Key.Key_B)
    assert set(screen.charts.board.marks) == {"A", "B"}
    shown = [pane.chart.are_statistics_shown for pane in screen.charts.board.panes]
    press(Qt.Key.Key_S)
    assert [pane.chart.are_statistics_shown for pane in screen.charts.board.panes] != shown
    assert screen.charts.presets.currentText() == preset
    screen.charts.board.set_marks({})


def test_space_pauses_the_flight_after_a_click_and_presses_a_button_after_tab(window, flying):
    window.show_screen("home")
    hold = window.top_bar.button("hold")
    click(window, hold)
    assert hold.isEnabled() and QApplication.focusWidget() is not hold
    flying.clear()
    press(Qt.Key.Key_Space)
    assert flying == [FlightOrder.PAUSE]
    hold.setFocus(Qt.FocusReason.TabFocusReason)
    flying.clear()
    press(Qt.Key.Key_Space)
    assert flying and FlightOrder.PAUSE not in flying


def test_space_plays_the_log_that_is_in_front(window, flying):
    window.show_screen("visualization")
    screen = window.stack.current
    screen.log_bar.clock.end = 10.0
    screen.log_bar.show()
    press(Qt.Key.Key_Space)
    assert screen.log_bar.clock.plays
    press(Qt.Key.Key_Space)
    assert not screen.log_bar.clock.plays
    assert flying == []
    window.show_screen("home")
    press(Qt.Key.Key_Space)
    assert flying == [FlightOrder.PAUSE]
    screen.log_bar.hide()


def test_escape_then_undo_takes_back_the_last_gain_that_flew(window, flying):
    """A value that was being typed is discarded, and leaves the key to the gains."""
    window.show_screen("tuning")
    screen = window.stack.current
    row = screen.panel.rows["kp_velocity_x"]
    before = screen.gains.proposed["kp_velocity_x"]
    row.field.setFocus()
    row.field.selectAll()
    QTest.keyClicks(row.field, f"{before + 0.5:g}")
    press(Qt.Key.Key_Return)
    assert screen.gains.proposed["kp_velocity_x"] == pytest.approx(before + 0.5)
    row.field.selectAll()
    QTest.keyClicks(row.field, "77")
    press(Qt.Key.Key_Escape)
    assert screen.gains.proposed["kp_velocity_x"] == pytest.approx(before + 0.5)
    press(Qt.Key.Key_Z, CONTROL)
    assert screen.gains.proposed["kp_velocity_x"] == pytest.approx(before)


@pytest.mark.parametrize("name", ["amplitude", "period"])
def test_undo_is_for_the_gains_in_a_field_without_a_change(window, flying, name):
    window.show_screen("tuning")
    screen = window.stack.current
    before = screen.gains.proposed["kp_velocity_x"]
    screen.gains.propose("kp_velocity_x", before + 0.25)
    field = getattr(screen.excitation, name)
    field.setFocus()
    QTest.keyClicks(field, "3")
    press(Qt.Key.Key_Escape)
    press(Qt.Key.Key_Z, CONTROL)
    assert screen.gains.proposed["kp_velocity_x"] == pytest.approx(before)


def letters_in(window):
    """Return the texts of all visible widgets and menus by the key that Alt makes of them."""
    texts = [action.text() for action in window.menuBar().actions()]
    texts += [each.text() for each in window.findChildren(QAbstractButton) if each.isVisible()]
    labels = [each for each in window.findChildren(QLabel) if each.isVisible()]
    texts += [each.text() for each in labels if each.buddy() is not None]
    found = defaultdict(list)
    for text in texts:
        found[QKeySequence.mnemonic(text).toString()].append(text)
    found.pop("", None)
    return found


@pytest.mark.parametrize("name", [row.name for row in SCREEN_TABLE])
def test_a_letter_with_alt_is_of_one_thing_on_a_screen(window, flying, name):
    """Otherwise it only moves the focus, and a menu does not open."""
    window.show_screen(name)
    groups = window.stack.current.findChildren(QTabWidget)
    pages = [(tabs, index) for tabs in groups for index in range(tabs.count())]
    for tabs, index in pages or [(None, 0)]:
        if tabs is not None:
            tabs.setCurrentIndex(index)
        QApplication.processEvents()
        assert {key: texts for key, texts in letters_in(window).items() if len(texts) > 1} == {}
