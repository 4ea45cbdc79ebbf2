"""The table of actions: one place for menus, buttons and keys."""

from collections import Counter

from PyQt6.QtCore import Qt
from PyQt6.QtGui import QKeySequence
from PyQt6.QtWidgets import QMainWindow, QMenuBar

from workbench.gui.actions import ACTIONS, MENUS, fill_menus, find_row, make_actions, rows_of, tip
from workbench.gui.icons import DRAWN
from workbench.gui.screen_table import SCREENS

TEXT_KEYS = ("Left", "Home", "Ctrl+A", "Ctrl+C", "Ctrl+V", "Ctrl+X", "Ctrl+Z", "Ctrl+Y", "Up")


def mnemonic(text):
    """Return the letter after the ampersand."""
    return text[text.index("&") + 1].lower() if "&" in text else ""


def test_names_are_unique():
    names = [row.name for row in ACTIONS]
    assert len(set(names)) == len(names)


def test_no_key_does_two_things():
    keys = [QKeySequence(row.shortcut).toString() for row in ACTIONS if row.shortcut]
    assert all(keys)
    assert len(set(keys)) == len(keys)


def test_no_key_is_one_that_text_fields_need():
    keys = {QKeySequence(row.shortcut).toString() for row in ACTIONS if row.shortcut}
    assert keys.isdisjoint(TEXT_KEYS)


def test_mnemonics_are_unique_in_each_menu():
    assert len({mnemonic(text) for text in MENUS}) == len(MENUS)
    for menu in MENUS:
        groups = {row.submenu for row in rows_of(menu)}
        for group in groups:
            letters = [mnemonic(row.text) for row in rows_of(menu) if row.submenu == group]
            if not group:
                letters += [mnemonic(each) for each in groups if each]
            if menu == "&File":
                letters += ["f"]  # the recent files, between the rows
            twice = [each for each, times in Counter(filter(None, letters)).items() if times > 1]
            assert not twice, f"{menu} {group}: {twice}"


def test_every_row_says_what_it_does():
    for row in ACTIONS:
        assert row.help.endswith("."), row.name
        assert row.text.replace("&", "").strip(), row.name
        assert row.icon in ("", *DRAWN), row.name


def test_the_screens_have_the_first_six_numbers():
    keys = [find_row(f"show_{screen.name}").shortcut for screen in SCREENS]
    assert keys == ["Ctrl+1", "Ctrl+2", "Ctrl+3", "Ctrl+4", "Ctrl+5", "Ctrl+6"]


def test_stop_is_one_key_without_another():
    key = QKeySequence(find_row("stop").shortcut)[0]
    assert key.key() == Qt.Key.Key_F12
    assert key.keyboardModifiers() == Qt.KeyboardModifier.NoModifier


def test_tips_name_the_key():
    assert tip(find_row("reset")).endswith("(Ctrl+R)")
    assert tip(find_row("about")) == find_row("about").help


def test_an_action_does_what_its_name_is_for(qtbot):
    window = QMainWindow()
    qtbot.addWidget(window)
    done = []
    handlers = {row.name: lambda name=row.name: done.append(name) for row in ACTIONS}
    made = make_actions(window, handlers)
    for row in ACTIONS:
        made[row.name].trigger()
    assert done == [row.name for row in ACTIONS]


def test_every_row_stands_in_its_menu(qtbot):
    window = QMainWindow()
    qtbot.addWidget(window)
    actions = make_actions(window, {row.name: lambda: None for row in ACTIONS})
    bar = QMenuBar(window)
    menus = fill_menus(bar, actions)
    for row in ACTIONS:
        menu = menus[row.submenu or row.menu]
        assert (actions[row.name] in menu.actions()) == (row.name != "stop"), row.name
