"""The keys that step a gain: direction, and size by the modifier."""

from PyQt6.QtCore import Qt

FINEST_STEP_FACTOR, FINE_STEP_FACTOR, COARSE_STEP_FACTOR = 0.1, 1.0, 5.0
"""Sizes of a step, as multiples of the plain one."""
_INCREASE_KEYS = (Qt.Key.Key_Right, Qt.Key.Key_Up)
_DECREASE_KEYS = (Qt.Key.Key_Left, Qt.Key.Key_Down)


def key_step_size(modifiers: Qt.KeyboardModifier) -> float:
    """Return the step size of a pressed key: plain, coarse with Shift, finest with Ctrl."""
    if modifiers & Qt.KeyboardModifier.ShiftModifier:
        return COARSE_STEP_FACTOR
    if modifiers & Qt.KeyboardModifier.ControlModifier:
        return FINEST_STEP_FACTOR
    return FINE_STEP_FACTOR


def key_step(key: int, modifiers: Qt.KeyboardModifier) -> tuple[int, float] | None:
    """Return direction and size of a key's step, None for another key."""
    if key in _INCREASE_KEYS:
        return 1, key_step_size(modifiers)
    if key in _DECREASE_KEYS:
        return -1, key_step_size(modifiers)
    if key in (Qt.Key.Key_PageUp, Qt.Key.Key_PageDown):
        return (1 if key == Qt.Key.Key_PageUp else -1), COARSE_STEP_FACTOR
    return None


def is_step_key(key: int) -> bool:
    """Return whether a key makes a step."""
    return key_step(key, Qt.KeyboardModifier.NoModifier) is not None
