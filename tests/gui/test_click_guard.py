"""A button that has just come, or does something else now, ignores a click meant for another."""

import pytest
from PyQt6.QtCore import QPoint, Qt
from PyQt6.QtGui import QCursor
from PyQt6.QtTest import QTest
from PyQt6.QtWidgets import QApplication, QVBoxLayout, QWidget

from workbench.gui.layout import button

LEFT = Qt.MouseButton.LeftButton


@pytest.fixture
def page(qtbot, guarded_clock):
    made = QWidget()
    qtbot.addWidget(made)
    made.pressed = []
    made.first = button("Start", lambda: made.pressed.append("first"))
    made.second = button("Keep", lambda: made.pressed.append("second"))
    box = QVBoxLayout(made)
    box.addWidget(made.first)
    box.addWidget(made.second)
    box.addStretch(1)
    made.resize(300, 200)
    made.show()
    qtbot.waitExposed(made)
    made.grab()
    return made


def click(widget):
    QTest.mouseClick(widget, LEFT)


def test_a_button_that_was_there_acts_at_once(page):
    click(page.first)
    click(page.first)
    assert page.pressed == ["first", "first"]


@pytest.mark.parametrize(
    "change",
    [
        lambda page: page.second.setText("Stop"),
        lambda page: (page.second.hide(), page.second.show()),
    ],
    ids=["another text", "shown"],
)
def test_a_click_within_half_a_second_of_a_change_does_nothing(page, guarded_clock, change):
    change(page)
    page.grab()
    for later in (0.0, 0.49):
        guarded_clock[0] = 100.0 + later
        click(page.second)
        QTest.mouseDClick(page.second, LEFT)
    assert page.pressed == []
    guarded_clock[0] = 100.0 + 0.5
    click(page.second)
    assert page.pressed == ["second"]


def test_a_button_that_moves_to_the_place_of_another_does_nothing_yet(page, guarded_clock):
    """The upper one goes, and the lower one comes under the pointer."""
    pointer = page.first.mapToGlobal(page.first.rect().center())
    QCursor.setPos(pointer)
    assert QCursor.pos() == pointer
    page.first.hide()
    QApplication.sendPostedEvents()
    assert page.second.rect().contains(page.second.mapFromGlobal(pointer))
    click(page.second)
    assert page.pressed == []
    guarded_clock[0] += 0.5
    click(page.second)
    assert page.pressed == ["second"]
    QCursor.setPos(QPoint(0, 0))


def test_numbers_and_the_keyboard_are_not_concerned(page):
    page.second.setText("Keep •")
    page.grab()
    click(page.second)
    page.second.setText("Stop")
    page.second.setFocus()
    QTest.keyClick(page.second, Qt.Key.Key_Space)
    assert page.pressed == ["second", "second"]
