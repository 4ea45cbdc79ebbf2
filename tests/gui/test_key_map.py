"""Keys that the user chooses, and the page where they stand."""

import pytest
from PyQt6.QtCore import QSettings, Qt
from PyQt6.QtGui import QKeySequence
from PyQt6.QtTest import QTest
from PyQt6.QtWidgets import QApplication, QKeySequenceEdit, QLineEdit, QPushButton, QTableView

from tests.gui.conftest import view_of
from workbench.common.errors import WorkbenchError
from workbench.control.mode import FlightMode
from workbench.gui.key_map import KeyMap
from workbench.gui.key_table import KEY_ROWS
from workbench.gui.keys_page import KEY_COLUMN, KeysPage
from workbench.live.messages import Phase
from workbench.scenario.scenario import Action

LEFT = Qt.MouseButton.LeftButton
CONTROL = Qt.KeyboardModifier.ControlModifier


@pytest.fixture
def store(tmp_path):
    return QSettings(str(tmp_path / "settings.ini"), QSettings.Format.IniFormat)


@pytest.fixture
def keys(store):
    return KeyMap(store)


def test_every_row_has_a_name_and_a_key_of_its_own(keys):
    names = [row.name for row in KEY_ROWS]
    assert len({*names}) == len(names)
    assert not [name for name in names if keys.fault(name, keys.key(name))]


def test_chosen_keys_are_there_at_the_next_start(store, keys):
    """Also two that were exchanged, each of which has the other's default."""
    keys.set_key("arm", "")
    keys.set_key("take_off", "F5")
    keys.set_key("arm", "F6")
    keys.set_key("stick_climb", "Z")  # for a French keyboard; the charts have a Z of their own
    again = KeyMap(store)
    chosen = [again.key(name) for name in ("arm", "take_off", "stick_climb", "land")]
    assert chosen == ["F6", "F5", "Z", "F8"]
    again.reset()
    assert KeyMap(store).key("arm") == "F5"


@pytest.mark.parametrize("kept", ["F6", "Ctrl+C", "Tab"])
def test_stored_keys_that_make_no_sense_are_passed_over(store, kept):
    store.setValue("keys/land", kept)
    assert KeyMap(store).key("land") == "F8"


@pytest.mark.parametrize(
    ("name", "key", "said"),
    [
        ("stop", "", "STOP needs a key"),
        ("land", "F6", "'Take off'"),
        ("land", "Space", "needed to use buttons"),
        ("land", "Tab", "needed to use buttons"),
        ("land", "Down", "needed to use buttons"),
        ("land", "Ctrl+C", "edits the text"),
        ("land", "Ctrl+K, Ctrl+L", "one key"),
        ("cursor_a", "Ctrl+J", "without Ctrl"),
        ("cursor_a", "S", "'Statistics'"),
    ],
)
def test_a_key_that_cannot_be_is_refused_with_the_reason(keys, name, key, said):
    before = keys.key(name)
    with pytest.raises(WorkbenchError, match=said):
        keys.set_key(name, key)
    assert keys.key(name) == before


def test_sentences_name_the_chosen_keys(keys):
    text = (
        "Press F6. F12 stops the rotors; F1 lists all keys, Ctrl+K keeps and Ctrl+Shift+K reverts."
    )
    assert keys.in_text(text) == text
    keys.set_key("keys", "")
    keys.set_key("take_off", "F1")
    keys.set_key("keep", "Ctrl+J")
    assert keys.in_text(text) == (
        "Press F1. F12 stops the rotors; Keys, which has no key lists all keys, Ctrl+J keeps and "
        "Ctrl+Shift+K reverts."
    )


def edit_key(table, help, key, modifier=Qt.KeyboardModifier.NoModifier):
    """Double-click the key of a row, and press another one."""
    model = table.model()
    row = next(r for r in range(model.rowCount()) if model.index(r, 1).data() == help)
    index = model.index(row, KEY_COLUMN)
    table.scrollTo(index)
    place = table.visualRect(index).center()
    QTest.mouseClick(table.viewport(), LEFT, pos=place)
    QTest.mouseDClick(table.viewport(), LEFT, pos=place)
    (field,) = [each for each in table.findChildren(QKeySequenceEdit) if each.isVisible()]
    QTest.keyClick(field, key, modifier)
    QApplication.processEvents()
    return index


def test_a_key_is_changed_on_the_page_and_acts_at_once(window, orders, canned, show, qtbot):
    show(view_of(canned, Phase.FLYING, FlightMode.OFF))
    page = KeysPage(window.workspace.keys, window)
    page.show()
    qtbot.waitExposed(page)
    table = page.findChild(QTableView)
    help = "Climb to 1.5 m and hover."
    index = edit_key(table, help, Qt.Key.Key_T, CONTROL)
    qtbot.waitUntil(lambda: index.data() == "Ctrl+T", timeout=10_000)
    QTest.keyClick(window, Qt.Key.Key_F6)
    assert orders == []
    QTest.keyClick(window, Qt.Key.Key_T, CONTROL)
    assert orders == [Action(request="take_off")]
    take_off = window.top_bar.button("take_off")
    assert take_off.toolTip().endswith("(Ctrl+T)") and take_off.accessibleName().endswith("Ctrl+T")
    edit_key(table, help, Qt.Key.Key_F8)
    assert index.data() == "Ctrl+T"
    assert "'Land'" in page.fault.text()
    field = page.findChild(QLineEdit)
    QTest.keyClicks(field, "ctrl+t")
    assert table.model().rowCount() == 1
    defaults = [each for each in page.findChildren(QPushButton) if "efault" in each.text()]
    QTest.mouseClick(defaults[0], LEFT)
    assert window.actions_by_name["take_off"].shortcut() == QKeySequence("F6")
    page.close()


def test_the_key_of_stop_stops_while_a_key_is_being_chosen(window, orders, canned, show, qtbot):
    show(view_of(canned, Phase.FLYING, FlightMode.HOVERING))
    page = KeysPage(window.workspace.keys, window)
    page.show()
    qtbot.waitExposed(page)
    index = edit_key(
        page.findChild(QTableView),
        "Brake and hold the position; ends any manoeuvre, and the scenario's script.",
        Qt.Key.Key_F12,
    )
    assert orders == [Action(request="stop")]
    assert index.data() == "F7"
    page.close()
