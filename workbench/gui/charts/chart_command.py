"""A command of a chart, and its line in the chart's menu."""

from collections.abc import Callable
from dataclasses import dataclass

from PyQt6.QtGui import QKeyEvent, QKeySequence
from PyQt6.QtWidgets import QMenu

from workbench.gui.layout import add_action

IGNORED_KEY_MODIFIERS = 0x2200_0000
"""Qt's KeypadModifier and ShiftModifier: they do not change the meaning of a key."""


def pressed_key(event: QKeyEvent) -> str:
    """Return a pressed key as Qt writes it, without Shift."""
    return QKeySequence(event.keyCombination().toCombined() & ~IGNORED_KEY_MODIFIERS).toString()


@dataclass(frozen=True)
class ChartCommand:
    """A command of a chart.

    Attributes:
        text: its text in the menu, "" for a key alone.
        key: keys as Qt writes them, separated by spaces, "" for none.
        do: the function to call; takes the new state if it is a switch.
        checked: whether it is on, None if it is not a switch.
    """

    text: str
    key: str
    do: Callable[[bool], object]
    checked: bool | None = None


COMMAND_SEPARATOR = ChartCommand("-", "", bool)


def add_command_action(menu: QMenu, command: ChartCommand) -> None:
    """Add an action; the chart itself handles the key, which is only shown here."""
    key = command.key.partition(" ")[0]
    text = f"{command.text}\t{key}" if key else command.text
    add_action(menu, text, command.do, command.checked)
