"""What holds on every screen of the real window, which takes long to make: these tests share it."""

import re
from dataclasses import dataclass, replace

import pytest
from PyQt6.QtCore import QCoreApplication
from PyQt6.QtGui import QPainter, QWhatsThisClickedEvent
from PyQt6.QtTest import QTest
from PyQt6.QtWidgets import (
    QAbstractButton,
    QAbstractSlider,
    QAbstractSpinBox,
    QApplication,
    QComboBox,
    QLabel,
    QLineEdit,
    QPushButton,
    QTabBar,
    QTableWidget,
    QToolButton,
    QTreeWidget,
    QWidget,
)
from PyQt6.sip import unwrapinstance

from workbench.gui.banner import GUIDE_STAGES
from workbench.gui.click_guard import ClickGuard
from workbench.gui.gains.gain_bar import GainBar
from workbench.gui.help import CARD_HELP, DocsBrowser, card_text
from workbench.gui.home.home_card import HomeCard
from workbench.gui.screen_table import SCREEN_TABLE
from workbench.session.snapshot import NearestClearance


@pytest.fixture(autouse=True)
def unasked(shared_workspace, monkeypatch):
    """Let no screen start processes that judge: none of these tests waits for what they say."""
    monkeypatch.setattr(shared_workspace.analysis, "ask", lambda question: None)
    monkeypatch.setattr(shared_workspace.analysis, "warm_up", lambda: None)


INPUTS = (QAbstractButton, QAbstractSlider, QAbstractSpinBox, QComboBox)
LONG_TEXT = "a sentence about what has happened, with more words than fit into the width " * 6


def inputs(window, but):
    """All inputs that can be seen, but those of some parts."""
    return [
        each
        for each in window.findChildren(INPUTS)
        if each.isVisible() and not any(part.isAncestorOf(each) for part in but)
    ]


def places(window, but):
    """Places and sizes in the window of all inputs that can be seen, but those of some parts."""
    QTest.qWait(1)
    return {unwrapinstance(each): place(window, each) for each in inputs(window, but)}


def place(window, each):
    return each.mapTo(window, each.rect().topLeft()), each.size()


STILL_LOOKS = 20
"""Looks in a row that find nothing moved; fields take their height some events after a screen."""


def settled(window, qtbot):
    """Places once a new screen has been laid out, with its last event."""
    seen, all_of_them = [], inputs(window, [window.banner.remedies])

    def is_still():
        seen.append([place(window, each) for each in all_of_them])
        return seen[-STILL_LOOKS:] == STILL_LOOKS * [seen[-1]]

    qtbot.waitUntil(is_still)
    return places(window, [window.banner.remedies])


def test_notices_move_no_input_on_any_screen(shared_window, shared_workspace, qtbot):
    """Nothing moves under the pointer when something is told."""
    window, notices = shared_window, shared_workspace.notices
    window.resize(1280, 720)
    for row in SCREEN_TABLE:
        window.show_screen(row.name)
        before = settled(window, qtbot)
        assert len(before) > 20
        notices.inform("short")
        notices.alarm(LONG_TEXT, "Reset the flight, or open a scenario.")
        notices.fail("the flight has ended", "Reset the flight (Ctrl+R) to fly again.")
        assert places(window, [window.banner.remedies]) == before, row.name
        window.banner.toggle_list()
        assert places(window, [window.banner.remedies, window.banner.panel]) == before, row.name
        window.banner.toggle_list()
        for _ in range(3):
            window.banner.dismiss()
        assert window.banner.shown is None
        assert places(window, [window.banner.remedies]) == before, row.name


@dataclass(frozen=True)
class Quantity:
    """A number that several screens show.

    Attributes:
        name: its name.
        digits: pattern of its first digits, which no other number has.
        text: how it looks, without its unit.
        unit: what may follow it.
        places: at least so many parts of the window show it.
    """

    name: str
    digits: str
    text: str
    unit: str
    places: int


QUANTITIES = (
    Quantity("clearance", r"7\.7\d*", "7.77", "m", 3),
    Quantity("charge", r"68", "68", "%", 2),
    Quantity("simulated time", r"1:38[.\d]*", "1:38.7", "", 2),
)


@pytest.fixture
def texts(shared_window, shared_workspace, canned, monkeypatch):
    """What each screen writes, by part of the window, for a flight with numbers of its own."""
    now = replace(
        canned.views[-1].snapshot,
        time=98.7654,
        charge=0.6789,
        clearance=NearestClearance(7.7654, (1.0, 0.0, 0.0), True),
    )
    view = replace(canned.views[-1], snapshot=now)
    monkeypatch.setattr(shared_workspace.flight, "_view", view)
    shared_window.resize(1280, 720)
    found, written, draw = {}, [], QPainter.drawText

    def watch(painter, *args):
        written.extend(each for each in args if isinstance(each, str))
        return draw(painter, *args)

    monkeypatch.setattr(QPainter, "drawText", watch)
    for row in SCREEN_TABLE:
        shared_window.show_screen(row.name)
        shared_workspace.flight.begun.emit(view)
        for _ in range(3):
            shared_workspace.flight.viewed.emit(view)
            QApplication.processEvents()
        written.clear()
        shared_window.grab()
        found[row.name] = {*written, *_shown(shared_window)}
    return found


def _shown(window):
    """Yield the texts of labels and tables that can be seen."""
    for label in window.findChildren(QLabel):
        if label.isVisible():
            yield label.text()
    for table in window.findChildren(QTableWidget):
        for row in range(table.rowCount()):
            for column in range(table.columnCount()):
                if table.isVisible() and (item := table.item(row, column)):
                    yield item.text()
    for tree in window.findChildren(QTreeWidget):
        if tree.isVisible() and (item := tree.topLevelItem(0)):
            yield item.text(0)


def test_a_quantity_has_one_format_on_all_screens(texts, case):
    """The same digits, and the same unit."""
    for quantity in QUANTITIES:
        with case(quantity.name):
            pattern = re.compile(rf"(?<![\d.:]){quantity.digits}(?!\d)")
            seen = {
                (screen, text, digits)
                for screen, written in texts.items()
                for text in written
                for digits in pattern.findall(text)
            }
            assert {digits for *_, digits in seen} == {quantity.text}, seen
            assert len(seen) >= quantity.places
            with_space = f"{quantity.text} {quantity.unit}"  # a line may break there
            assert not quantity.unit or not any(with_space in text for _, text, _ in seen)


def test_every_button_of_the_window_is_guarded(shared_window, case):
    """But those whose place and text are fixed, among them STOP, which must always act."""
    for row in SCREEN_TABLE:
        screen = shared_window.stack.screen_of(row.name)
        for each in screen.findChildren(QPushButton) + screen.findChildren(QToolButton):
            if isinstance(each.parent(), QLineEdit | QTabBar):
                continue  # Qt's own, in a part that keeps its place
            with case(f"{row.name}: {each.text() or each.accessibleName()}"):
                assert each.findChild(ClickGuard)
    bar = shared_window.top_bar
    assert not bar.button("stop").findChild(ClickGuard)
    assert bar.button("record").findChild(ClickGuard)


def cards(screen):
    """All that stands on a ground of its own, whatever class it is of."""
    for each in screen.findChildren(QWidget):
        if isinstance(each, HomeCard) or "card" in str(each.property("class") or "").split():
            yield each


def help_of(widget):
    """What Shift+F1 and a click show: its own words, or those of what it stands in."""
    while widget is not None and not widget.whatsThis():
        widget = widget.parentWidget()
    return widget.whatsThis() if widget is not None else ""


def test_every_card_of_every_screen_has_help(shared_window, case):
    counted, shown = 0, set()
    for row in SCREEN_TABLE:
        shared_window.show_screen(row.name)
        screen = shared_window.stack.screen_of(row.name)
        QApplication.processEvents()  # only then all stands where it belongs
        for card in cards(screen):
            with case(f"{row.name}: {type(card).__name__} {card.accessibleName()}"):
                assert help_of(card), "has no help"
                counted += 1
                shown.add(help_of(card))
    assert counted > 35
    tabs = shared_window.stack.screen_of("visualization").tabs
    shown |= {help_of(tabs.widget(place)) for place in range(tabs.count())}
    shown.add(help_of(shared_window.stack.screen_of("tuning").panel))
    assert shown == set(map(card_text, CARD_HELP))  # and none in the table is of no card


def test_a_click_on_the_link_of_a_card_opens_the_page(shared_window, qtbot):
    shared_window.show_screen("tuning")
    card = shared_window.stack.screen_of("tuning").margins
    QCoreApplication.sendEvent(card, QWhatsThisClickedEvent("linear.md#the-judgement"))
    (dialog,) = [each for each in QApplication.topLevelWidgets() if each.windowTitle() == "Docs"]
    assert dialog.isVisible()
    assert dialog.findChild(DocsBrowser).textCursor().block().text() == "The judgement"
    dialog.close()


def test_the_guide_begins_on_the_tuning_screen_and_names_keys_that_act(shared_window):
    shared_window.show_screen("home")
    shared_window.actions_by_name["guide"].trigger()
    assert shared_window.stack.name == "tuning" and shared_window.guide.accessibleName().startswith(
        "1"
    )
    bar = shared_window.stack.screen_of("tuning").findChild(GainBar)
    actions = (*shared_window.actions_by_name.values(), *bar.actions_by_name.values())
    keys = {action.shortcut().toString() for action in actions}
    hints = " ".join(how for _, how in GUIDE_STAGES)
    for name in ("F6", "F12", "Ctrl+K", "Ctrl+Shift+K"):
        assert name in hints and name in keys
    shared_window.guide.end()
