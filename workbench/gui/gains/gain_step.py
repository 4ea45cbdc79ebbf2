"""How far the keys move a value."""

from enum import Enum

from PyQt6.QtCore import Qt


class StepSize(Enum):
    """Of a step, as a multiple of the plain one."""

    FINEST = 0.1
    FINE = 1.0
    COARSE = 5.0


_UP = (Qt.Key.Key_Right, Qt.Key.Key_Up)
_DOWN = (Qt.Key.Key_Left, Qt.Key.Key_Down)


def size_of(modifiers: Qt.KeyboardModifier) -> StepSize:
    """Return the step of a key that is pressed: plain, with Shift coarse, with Ctrl finest."""
    if modifiers & Qt.KeyboardModifier.ShiftModifier:
        return StepSize.COARSE
    if modifiers & Qt.KeyboardModifier.ControlModifier:
        return StepSize.FINEST
    return StepSize.FINE


def key_step(key: int, modifiers: Qt.KeyboardModifier) -> tuple[int, StepSize] | None:
    """Return direction and size of the step that a key makes, None of another key."""
    if key in _UP:
        return 1, size_of(modifiers)
    if key in _DOWN:
        return -1, size_of(modifiers)
    if key in (Qt.Key.Key_PageUp, Qt.Key.Key_PageDown):
        return (1 if key == Qt.Key.Key_PageUp else -1), StepSize.COARSE
    return None


def moves(key: int) -> bool:
    """Return whether a key makes a step."""
    return key_step(key, Qt.KeyboardModifier.NoModifier) is not None
