"""The table of actions: one place for menus, buttons and keys."""

from collections import Counter

from PyQt6.QtCore import Qt
from PyQt6.QtGui import QKeySequence
from PyQt6.QtWidgets import QMainWindow, QMenuBar

from workbench.gui.actions import (
    ACTION_TABLE,
    MENU_TITLES,
    fill_menus,
    find_action,
    menu_rows,
)
from workbench.gui.command_action import make_actions
from workbench.gui.icons import ICON_STROKES
from workbench.gui.screen_table import SCREEN_TABLE

TEXT_KEYS = ("Left", "Home", "Ctrl+A", "Ctrl+C", "Ctrl+V", "Ctrl+X", "Ctrl+Z", "Ctrl+Y", "Up")


def mnemonic(text):
    """Return the letter after the ampersand."""
    return text[text.index("&") + 1].lower() if "&" in text else ""


def test_names_are_unique():
    names = [row.name for row in ACTION_TABLE]
    assert len(set(names)) == len(names)


def test_no_key_does_two_things():
    keys = [QKeySequence(row.shortcut).toString() for row in ACTION_TABLE if row.shortcut]
    assert all(keys)
    assert len(set(keys)) == len(keys)


def test_no_key_is_one_that_text_fields_need():
    keys = {QKeySequence(row.shortcut).toString() for row in ACTION_TABLE if row.shortcut}
    assert keys.isdisjoint(TEXT_KEYS)


def test_mnemonics_are_unique_in_each_menu():
    assert len({mnemonic(text) for text in MENU_TITLES}) == len(MENU_TITLES)
    for menu in MENU_TITLES:
        groups = {row.submenu for row in menu_rows(menu)}
        for group in groups:
            letters = [mnemonic(row.text) for row in menu_rows(menu) if row.submenu == group]
            if not group:
                letters += [mnemonic(each) for each in groups if each]
            if menu == "&File":
                letters += ["f"]  # the recent files, between the rows
            twice = [each for each, times in Counter(filter(None, letters)).items() if times > 1]
            assert not twice, f"{menu} {group}: {twice}"


def test_every_row_says_what_it_does():
    for row in ACTION_TABLE:
        assert row.help.endswith("."), row.name
        assert row.text.replace("&", "").strip(), row.name
        assert row.icon in ("", *ICON_STROKES), row.name


def test_the_screens_have_the_first_six_numbers():
    keys = [find_action(f"show_{screen.name}").shortcut for screen in SCREEN_TABLE]
    assert keys == ["Ctrl+N", "Ctrl+1", "Ctrl+2", "Ctrl+3", "Ctrl+4", "Ctrl+5", "Ctrl+6"]


def test_stop_is_one_key_without_another():
    key = QKeySequence(find_action("stop").shortcut)[0]
    assert key.key() == Qt.Key.Key_F12
    assert key.keyboardModifiers() == Qt.KeyboardModifier.NoModifier


def test_tips_name_the_key(qtbot, workspace):
    window = QMainWindow()
    qtbot.addWidget(window)
    actions = make_actions(window, {row.name: int for row in ACTION_TABLE}, workspace.keys)
    assert actions["reset"].toolTip().endswith("(Ctrl+R)")
    assert actions["about"].toolTip() == find_action("about").help


def test_an_action_does_what_its_name_is_for(qtbot, workspace):
    window = QMainWindow()
    qtbot.addWidget(window)
    done = []
    handlers = {row.name: lambda name=row.name: done.append(name) for row in ACTION_TABLE}
    made = make_actions(window, handlers, workspace.keys)
    for row in ACTION_TABLE:
        made[row.name].trigger()
    assert done == [row.name for row in ACTION_TABLE]


def test_every_row_stands_in_its_menu(qtbot, workspace):
    window = QMainWindow()
    qtbot.addWidget(window)
    handlers = {row.name: lambda: None for row in ACTION_TABLE}
    actions = make_actions(window, handlers, workspace.keys)
    bar = QMenuBar(window)
    menus = fill_menus(bar, actions)
    for row in ACTION_TABLE:
        menu = menus[row.submenu or row.menu]
        assert (actions[row.name] in menu.actions()) == (row.name != "stop"), row.name
