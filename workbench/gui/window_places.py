"""Positions of the window and its parts, stored between starts."""

from PyQt6.QtCore import QByteArray, QSettings
from PyQt6.QtWidgets import QMainWindow, QSplitter

from workbench.common.errors import WorkbenchError
from workbench.gui.screen_table import DEFAULT_SCREEN, find_screen

WINDOW_SETTINGS_GROUP = "window/1"
"""Group of settings; the number changes when stored values no longer fit."""


def save_places(
    store: QSettings, window: QMainWindow, splitter: QSplitter, *, screen: str, beside: bool
) -> None:
    """Store the window's position and layout for the next start.

    Args:
        store: the storage.
        window: the window.
        splitter: has the screens and the 3-D view.
        screen: name of the visible screen.
        beside: whether the 3-D view is beside it; else the splitter's position is not stored.
    """
    store.setValue(f"{WINDOW_SETTINGS_GROUP}/geometry", window.saveGeometry())
    if beside:
        store.setValue(f"{WINDOW_SETTINGS_GROUP}/splitter", splitter.saveState())
    store.setValue(f"{WINDOW_SETTINGS_GROUP}/screen", screen)
    store.setValue(f"{WINDOW_SETTINGS_GROUP}/beside", beside)
    store.sync()


def restore_places(store: QSettings, window: QMainWindow, splitter: QSplitter) -> None:
    """Restore the positions of window and splitter; invalid stored values are ignored."""
    for name, restore in (
        ("geometry", window.restoreGeometry),
        ("splitter", splitter.restoreState),
    ):
        kept = store.value(f"{WINDOW_SETTINGS_GROUP}/{name}")
        if isinstance(kept, QByteArray):
            restore(kept)


def last_screen(store: QSettings) -> str:
    """Return the name of the last screen."""
    try:
        return find_screen(str(store.value(f"{WINDOW_SETTINGS_GROUP}/screen", ""))).name
    except WorkbenchError:
        return DEFAULT_SCREEN


def was_beside(store: QSettings) -> bool:
    """Return whether the 3-D view was beside the screen; at the first start it is closed."""
    return str(store.value(f"{WINDOW_SETTINGS_GROUP}/beside", False)).lower() == "true"
