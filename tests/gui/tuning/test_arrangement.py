"""Where the tuning screen's parts are: by the size of the window, and as the user moves them."""

import pytest
from PyQt6.QtCore import Qt
from PyQt6.QtTest import QTest
from PyQt6.QtWidgets import QApplication

from workbench.gui.tuning.card_window import CardWindow

LEFT = Qt.MouseButton.LeftButton
SHIFT, CONTROL = Qt.KeyboardModifier.ShiftModifier, Qt.KeyboardModifier.ControlModifier


@pytest.fixture
def sized(screen, qapp):
    """Returns the titles of the tabs at a size of the screen."""

    def size(width, height=627):
        screen.resize(width, height)
        qapp.processEvents()
        return [screen.tabs.tabText(index) for index in range(screen.tabs.count())]

    return size


def double_click(card):
    """Click twice on a card's name."""
    name = card.head.itemAt(0).widget()
    QTest.mouseDClick(name, LEFT)
    QApplication.processEvents()


def test_the_fewer_pixels_the_fewer_parts_at_a_time(screen, sized):
    assert sized(1832, 987)[0] == "Frequency" and screen.response.isVisible()
    assert sized(1192)[:2] == ["Step", "Frequency"] and screen.panel.isVisible()
    assert sized(936)[:2] == ["Step", "Frequency"] and screen.panel.isVisible()
    assert sized(872)[:3] == ["Gains", "Step", "Margins"] and not screen.margins.isVisible()
    assert sized(1832, 987)[0] == "Frequency" and screen.response.isVisible()


def test_margins_are_one_line_in_a_low_window(screen, sized):
    sized(1192, 627)
    assert screen.margins.said.isVisible() and not screen.margins.table.isVisible()
    assert screen.margins.height() < 60
    QTest.mouseClick(screen.margins.fold, LEFT)
    assert screen.margins.table.isVisible()
    sized(1192, 987)
    assert screen.margins.table.isVisible()
    sized(1192, 627)
    assert not screen.margins.table.isVisible()


def test_a_double_click_on_its_name_lets_a_card_fill_its_column(screen, sized):
    sized(1832, 987)
    before = screen.response.height()
    double_click(screen.response)
    assert not screen.excitation.isVisible() and screen.response.height() > before + 100
    assert screen.panel.isVisible() and screen.margins.isVisible()
    double_click(screen.response)
    assert screen.excitation.isVisible() and screen.response.height() == before


def test_keys_fill_the_column_and_give_a_window_to_the_card_with_the_keyboard(screen, sized, qtbot):
    sized(1192)
    screen.activateWindow()
    qtbot.waitUntil(screen.isActiveWindow)
    screen.tabs.setCurrentWidget(screen.poles)
    screen.poles.loops.setFocus()
    QTest.keyClick(screen.poles.loops, Qt.Key.Key_F11, SHIFT)
    assert not screen.margins.isVisible() and not screen.tabs.tabBar().isVisible()
    QTest.keyClick(screen.poles.loops, Qt.Key.Key_F11, SHIFT)
    assert screen.margins.isVisible() and screen.tabs.tabBar().isVisible()
    QTest.keyClick(screen.poles.loops, Qt.Key.Key_F11, CONTROL)
    assert isinstance(screen.poles.window(), CardWindow)


def test_margins_that_fill_their_column_show_their_table(screen, sized):
    sized(1192)
    double_click(screen.margins)
    assert screen.margins.table.isVisible() and not screen.tabs.isVisible()
    double_click(screen.margins)
    assert not screen.margins.table.isVisible() and screen.tabs.isVisible()


def test_a_card_in_its_own_window_stays_up_to_date_and_comes_back(screen, sized, qapp):
    titles = sized(1192)
    screen.arrangement.move_to_window(screen.frequency)
    window = screen.frequency.window()
    assert isinstance(window, CardWindow) and window.isVisible()
    assert sized(1192) == titles
    screen.hide()
    assert screen.frequency.isVisible() and screen.frequency._seen
    screen.show()
    sized(872)  # the tabs are arranged anew meanwhile
    window.close()
    qapp.processEvents()
    assert screen.frequency.window() is screen.window()
    assert sized(1192) == titles
    screen.tabs.setCurrentWidget(screen.frequency)
    assert screen.frequency.isVisible()


def test_another_arrangement_shows_what_a_card_has_hidden(screen, sized):
    sized(1832, 987)
    double_click(screen.response)
    sized(1192)
    assert screen.excitation.isVisible() and screen.margins.isVisible()
