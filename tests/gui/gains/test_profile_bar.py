"""The bar above the gains: keys, buttons, slots and files."""

import pytest
from PyQt6.QtCore import Qt
from PyQt6.QtGui import QGuiApplication, QKeySequence
from PyQt6.QtTest import QTest
from PyQt6.QtWidgets import QFileDialog, QVBoxLayout, QWidget

from workbench.gui.gains.gain_panel import GainPanel
from workbench.gui.gains.profile_bar import ProfileBar

NAME = "kp_velocity_x"
LEFT = Qt.MouseButton.LeftButton


@pytest.fixture
def window(bench, workspace, qtbot):
    made = QWidget()
    qtbot.addWidget(made)
    layout = QVBoxLayout(made)
    layout.setContentsMargins(0, 0, 0, 0)
    made.bar = ProfileBar(workspace, bench.desk)
    made.panel = GainPanel(workspace, bench.desk)
    layout.addWidget(made.bar)
    layout.addWidget(made.panel)
    made.resize(380, 700)
    made.show()
    made.activateWindow()
    qtbot.waitExposed(made)
    qtbot.waitUntil(made.isActiveWindow)
    return made


def press(window, keys):
    (combination,) = [QKeySequence(keys)[0]]
    target = window.focusWidget() or window
    QTest.keyClick(target, combination.key(), combination.keyboardModifiers())


def test_the_state_is_said_in_words(bench, window):
    bench.know()
    assert window.bar.state.text() == "Flown = kept"
    bench.desk.adopt({NAME: 4.0, "kp_velocity_y": 4.0, "kp_roll": 151.0}, "a search")
    assert window.bar.state.text() == "3 gains tried, not kept"
    assert "changed" in window.bar.name.text()


def test_keep_and_revert_by_their_keys(bench, window):
    bench.know()
    bench.desk.propose(NAME, 4.0)
    press(window, "Ctrl+K")
    assert bench.desk.kept[NAME] == 4.0
    bench.desk.propose(NAME, 5.0)
    press(window, "Ctrl+Shift+K")
    assert bench.desk.flown[NAME] == 4.0


def test_undo_and_redo_work_while_a_number_has_the_focus(bench, window):
    bench.know()
    bench.desk.propose(NAME, 4.0)
    field = window.panel.rows[NAME].field
    field.setFocus()
    press(window, "Ctrl+Z")
    assert bench.desk.flown[NAME] == 3.0
    press(window, "Ctrl+Shift+Z")
    assert bench.desk.flown[NAME] == 4.0


def test_undo_says_what_it_would_take_back(bench, window):
    bench.know()
    assert not window.bar.buttons["undo"].isEnabled()
    bench.desk.propose(NAME, 4.0)
    assert window.bar.buttons["undo"].isEnabled()
    assert window.bar.buttons["undo"].accessibleName() == "Undo Velocity x Kp"


def test_a_slot_is_filled_and_compared_by_one_key(bench, window):
    bench.know()
    bench.desk.propose(NAME, 4.0)
    press(window, "F2")
    assert bench.desk.slots["A"][NAME] == 4.0
    bench.desk.propose(NAME, 5.0)
    press(window, "F2")
    assert bench.desk.flown[NAME] == 4.0
    assert window.bar.buttons["compare_A"].isChecked()
    press(window, "F2")
    assert bench.desk.flown[NAME] == 5.0
    assert not window.bar.buttons["compare_A"].isChecked()
    press(window, "Shift+F2")
    assert bench.desk.slots["A"][NAME] == 5.0


def test_buttons_do_what_the_keys_do(bench, window):
    bench.know()
    bench.desk.propose(NAME, 4.0)
    QTest.mouseClick(window.bar.buttons["keep"], LEFT)
    assert bench.desk.kept[NAME] == 4.0
    QTest.mouseClick(window.bar.buttons["undo"], LEFT)
    assert bench.desk.flown[NAME] == 3.0
    QTest.mouseClick(window.bar.buttons["revert"], LEFT)
    assert bench.desk.flown[NAME] == 4.0


def test_copied_gains_can_be_pasted_line_by_line(bench, window, qtbot):
    bench.know()
    bench.desk.propose(NAME, 4.0)
    bench.desk.propose("kp_roll", 151.0)
    press(window, "Ctrl+Shift+C")
    assert "kp_velocity_x: 4.0 1/s" in QGuiApplication.clipboard().text()
    bench.desk.revert()
    bench.flight.given.clear()
    press(window, "Ctrl+Shift+V")
    offer = window.bar.offer
    qtbot.waitUntil(offer.isVisible, timeout=10000)
    assert set(offer.ticks) == {NAME, "kp_roll"}
    offer.ticks["kp_roll"].click()
    assert offer.fly.text() == "&Fly 1 ticked"
    assert bench.flight.given == []
    QTest.mouseClick(offer.fly, LEFT)
    assert bench.flight.given == [(NAME, 4.0)]
    assert not offer.isVisible()


def test_nothing_of_an_offer_needs_be_taken(bench, window, gain_file, qtbot):
    bench.desk.load(gain_file)
    offer = window.bar.offer
    qtbot.waitUntil(offer.isVisible, timeout=10000)
    assert "found by hand" in offer.said.text()
    QTest.mouseClick(offer.none, LEFT)
    assert not offer.fly.isEnabled()
    QTest.mouseClick(offer.back, LEFT)
    assert not offer.isVisible()
    assert bench.flight.given == []


def test_a_file_is_chosen_while_the_app_goes_on(bench, window, gain_file, qtbot):
    press(window, "Ctrl+Shift+L")
    (dialog,) = window.bar.findChildren(QFileDialog)
    dialog.fileSelected.emit(str(gain_file))
    dialog.reject()
    qtbot.waitUntil(window.bar.offer.isVisible, timeout=10000)


def test_a_file_is_saved_under_the_name_that_was_chosen(bench, window, tmp_path, qtbot):
    press(window, "Ctrl+S")
    (dialog,) = window.bar.findChildren(QFileDialog)
    dialog.fileSelected.emit(str(tmp_path / "mine.yaml"))
    dialog.reject()
    qtbot.waitUntil(lambda: "mine" in window.bar.name.text(), timeout=10000)
    assert (tmp_path / "mine.yaml").is_file()


def test_a_key_leads_to_the_search(window, qtbot):
    press(window, "Ctrl+F")
    qtbot.waitUntil(window.panel.search.hasFocus)


def test_a_key_flies_what_is_doubted(bench, window):
    bench.desk.propose("kp_roll", 900.0)
    bench.analysis.judge(stable=False)
    press(window, "Ctrl+Return")
    assert bench.flight.given == [("kp_roll", 900.0)]


def test_it_stands_in_the_width_of_the_gains(window):
    assert window.width() == 380
    for button in window.bar.buttons.values():
        assert button.geometry().right() < 380
        words = button.fontMetrics().horizontalAdvance(button.text().replace("&", ""))
        assert words < button.width()
