"""The bar above the gains: keys, buttons, slots and files."""

import pytest
from PyQt6.QtCore import Qt
from PyQt6.QtGui import QGuiApplication, QKeySequence
from PyQt6.QtTest import QTest
from PyQt6.QtWidgets import QAbstractButton, QFileDialog, QVBoxLayout, QWidget
from PyQt6.sip import unwrapinstance

from workbench.gui.gains.gain_bar import GainBar
from workbench.gui.gains.gain_input import GainField, GainSlider
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


def test_a_long_name_of_a_law_wraps(window):
    law = window.bar.law
    law.setText("·\N{NO-BREAK SPACE}my_law_of_many_words_that_have_no_room_in_one_line")
    QTest.qWait(0)
    lines = 2 * law.fontMetrics().lineSpacing()
    assert law.height() >= lines >= law.heightForWidth(law.width()) / 2


def press(window, keys):
    (combination,) = [QKeySequence(keys)[0]]
    target = window.focusWidget() or window
    QTest.keyClick(target, combination.key(), combination.keyboardModifiers())


def test_the_state_is_said_in_words(rig, window):
    rig.know()
    assert window.bar.state.text() == "Saved · kept"
    rig.editor.adopt({NAME: 4.0, "kp_velocity_y": 4.0, "kp_roll": 151.0}, "a search")
    assert window.bar.state.text() == "Unsaved · 3 gains not kept"
    rig.editor.keep()
    assert window.bar.state.text() == "Unsaved · kept"


def places(window):
    """Places of all sliders, fields and buttons that are shown."""
    QTest.qWait(1)
    kinds = (QAbstractButton, GainSlider, GainField)
    shown = [each for kind in kinds for each in window.findChildren(kind) if each.isVisible()]
    assert len(shown) > 40
    return {unwrapinstance(each): each.mapTo(window, each.rect().center()) for each in shown}


def test_a_doubt_is_shown_with_a_way_on_and_a_way_back_and_moves_nothing(rig, window):
    bar, before = window.bar, places(window)
    back, fly = bar.buttons["discard"], bar.buttons["confirm"]
    assert not back.isEnabled() and not fly.isEnabled()
    rig.editor.propose("kp_roll", 900.0)
    rig.analysis.judge(stable=False, said="a mode grows through roll, as its gain is too high")
    assert "▲ Not flown: a mode grows through roll" in bar.state.text()
    assert places(window) == before
    QTest.mouseClick(back, LEFT)
    assert window.panel.rows["kp_roll"].field.value() == 150.0
    assert bar.state.text() == "Saved · kept" and not fly.isEnabled()
    rig.editor.propose("kp_roll", 900.0)
    rig.analysis.judge(stable=False)
    QTest.mouseClick(fly, LEFT)
    assert rig.flight.given == [("kp_roll", 900.0)]
    assert not fly.isEnabled() and places(window) == before


def test_a_refused_value_is_told_above_the_gains_and_moves_no_line(rig, window, style, workspace):
    """In the app's style, which has equal heights with and without a mark."""
    style(workspace.look)
    rig.know()
    field = window.panel.rows[NAME].field
    field.setFocus()
    before = places(window)
    field.selectAll()
    QTest.keyClicks(field, "99")
    QTest.keyClick(field, Qt.Key.Key_Return)
    assert window.bar.state.text().startswith("✕") and "0 .. 30" in window.bar.state.text()
    assert places(window) == before
    QTest.keyClick(field, Qt.Key.Key_Escape)
    assert window.bar.state.text() == "Saved · kept"


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


def test_a_slot_says_how_it_differs_and_that_it_would_be_replaced(rig, window):
    rig.know()
    button, store = window.bar.buttons["compare_A"], window.bar.actions_by_name["store_A"]
    assert store.text() == "Store in slot &A"
    rig.editor.propose(NAME, 4.0)
    QTest.mouseClick(button, LEFT)
    assert store.text() == "Replace slot &A"
    assert "has the present gains" in button.toolTip()
    rig.editor.propose(NAME, 5.25)
    assert "Velocity x Kp 4 (now 5.25)" in button.toolTip()
    assert button.actions() == [store]  # the menu of a right click


def test_a_slot_promises_to_return_only_where_there_is_something_else(rig, window):
    rig.know()
    button = window.bar.buttons["compare_A"]
    rig.editor.propose(NAME, 4.0)
    QTest.mouseClick(button, LEFT)
    assert "return" not in button.toolTip()  # nothing was there before
    rig.editor.propose(NAME, 5.0)
    QTest.mouseClick(button, LEFT)
    assert "return to those before it" in button.toolTip()
    rig.editor.store("A")
    assert "return" not in button.toolTip()


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
