"""The bar above the gains: keys, buttons, slots and files."""

import pytest
from PyQt6.QtCore import Qt
from PyQt6.QtGui import QGuiApplication, QKeySequence
from PyQt6.QtTest import QTest
from PyQt6.QtWidgets import QFileDialog, QVBoxLayout, QWidget

from workbench.gui.gains.gain_bar import GainBar
from workbench.gui.gains.gain_panel import GainPanel

NAME = "kp_velocity_x"
LEFT = Qt.MouseButton.LeftButton


@pytest.fixture
def window(rig, workspace, qtbot):
    made = QWidget()
    qtbot.addWidget(made)
    layout = QVBoxLayout(made)
    layout.setContentsMargins(0, 0, 0, 0)
    made.bar = GainBar(workspace, rig.editor, rig.gain_files)
    made.panel = GainPanel(workspace, rig.editor)
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


def test_the_state_is_said_in_words(rig, window):
    rig.know()
    assert window.bar.state.text() == "Flown = kept"
    rig.editor.adopt({NAME: 4.0, "kp_velocity_y": 4.0, "kp_roll": 151.0}, "a search")
    assert window.bar.state.text() == "3 gains tried, not kept"
    assert "changed" in window.bar.law.text()


def test_keep_and_revert_by_their_keys(rig, window):
    rig.know()
    rig.editor.propose(NAME, 4.0)
    press(window, "Ctrl+K")
    assert rig.editor.kept[NAME] == 4.0
    rig.editor.propose(NAME, 5.0)
    press(window, "Ctrl+Shift+K")
    assert rig.editor.flown[NAME] == 4.0


def test_undo_and_redo_work_while_a_number_has_the_focus(rig, window):
    rig.know()
    rig.editor.propose(NAME, 4.0)
    field = window.panel.rows[NAME].field
    field.setFocus()
    press(window, "Ctrl+Z")
    assert rig.editor.flown[NAME] == 3.0
    press(window, "Ctrl+Shift+Z")
    assert rig.editor.flown[NAME] == 4.0


def test_undo_says_what_it_would_take_back(rig, window):
    rig.know()
    assert not window.bar.buttons["undo"].isEnabled()
    rig.editor.propose(NAME, 4.0)
    assert window.bar.buttons["undo"].isEnabled()
    assert window.bar.buttons["undo"].accessibleName() == "Undo Velocity x Kp"


def test_a_slot_is_filled_and_compared_by_one_key(rig, window):
    rig.know()
    rig.editor.propose(NAME, 4.0)
    press(window, "F2")
    assert rig.editor.slots["A"][NAME] == 4.0
    rig.editor.propose(NAME, 5.0)
    press(window, "F2")
    assert rig.editor.flown[NAME] == 4.0
    assert window.bar.buttons["compare_A"].isChecked()
    press(window, "F2")
    assert rig.editor.flown[NAME] == 5.0
    assert not window.bar.buttons["compare_A"].isChecked()
    press(window, "Shift+F2")
    assert rig.editor.slots["A"][NAME] == 5.0


def test_buttons_do_what_the_keys_do(rig, window):
    rig.know()
    rig.editor.propose(NAME, 4.0)
    QTest.mouseClick(window.bar.buttons["keep"], LEFT)
    assert rig.editor.kept[NAME] == 4.0
    QTest.mouseClick(window.bar.buttons["undo"], LEFT)
    assert rig.editor.flown[NAME] == 3.0
    QTest.mouseClick(window.bar.buttons["revert"], LEFT)
    assert rig.editor.flown[NAME] == 4.0


def test_copied_gains_can_be_pasted_line_by_line(rig, window, qtbot):
    rig.know()
    rig.editor.propose(NAME, 4.0)
    rig.editor.propose("kp_roll", 151.0)
    press(window, "Ctrl+Shift+C")
    assert "kp_velocity_x: 4.0 1/s" in QGuiApplication.clipboard().text()
    rig.editor.revert()
    rig.flight.given.clear()
    press(window, "Ctrl+Shift+V")
    diff = window.bar.diff
    qtbot.waitUntil(diff.isVisible, timeout=10000)
    assert set(diff.ticks) == {NAME, "kp_roll"}
    diff.ticks["kp_roll"].click()
    assert diff.fly.text() == "&Fly 1 ticked"
    assert rig.flight.given == []
    QTest.mouseClick(diff.fly, LEFT)
    assert rig.flight.given == [(NAME, 4.0)]
    assert not diff.isVisible()


def test_nothing_of_an_offer_needs_be_taken(rig, window, gain_file, qtbot):
    rig.gain_files.load(gain_file)
    diff = window.bar.diff
    qtbot.waitUntil(diff.isVisible, timeout=10000)
    assert "found by hand" in diff.said.text()
    QTest.mouseClick(diff.none, LEFT)
    assert not diff.fly.isEnabled()
    QTest.mouseClick(diff.back, LEFT)
    assert not diff.isVisible()
    assert rig.flight.given == []


def test_a_file_is_chosen_while_the_app_goes_on(rig, window, gain_file, qtbot):
    press(window, "Ctrl+Shift+L")
    (dialog,) = window.bar.findChildren(QFileDialog)
    dialog.fileSelected.emit(str(gain_file))
    dialog.reject()
    qtbot.waitUntil(window.bar.diff.isVisible, timeout=10000)


def test_a_file_is_saved_under_the_name_that_was_chosen(rig, window, tmp_path, qtbot):
    press(window, "Ctrl+S")
    (dialog,) = window.bar.findChildren(QFileDialog)
    dialog.fileSelected.emit(str(tmp_path / "mine.yaml"))
    dialog.reject()
    qtbot.waitUntil(lambda: "mine" in window.bar.name.text(), timeout=10000)
    assert (tmp_path / "mine.yaml").is_file()


def test_a_key_leads_to_the_search(window, qtbot):
    press(window, "Ctrl+F")
    qtbot.waitUntil(window.panel.search.hasFocus)


def test_a_key_flies_what_is_doubted(rig, window):
    rig.editor.propose("kp_roll", 900.0)
    rig.analysis.judge(stable=False)
    press(window, "Ctrl+Return")
    assert rig.flight.given == [("kp_roll", 900.0)]


def test_it_stands_in_the_width_of_the_gains(window):
    assert window.width() == 380
    for button in window.bar.buttons.values():
        assert button.geometry().right() < 380
        words = button.fontMetrics().horizontalAdvance(button.text().replace("&", ""))
        assert words < button.width()
