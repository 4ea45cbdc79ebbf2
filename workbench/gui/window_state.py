"""Where the window was and what it showed, kept between starts."""

from PyQt6.QtCore import QByteArray, QSettings
from PyQt6.QtWidgets import QMainWindow, QSplitter

from workbench.common.errors import WorkbenchError
from workbench.gui.screen_table import SCREENS, find_screen

GROUP = "window/1"
"""Another number where what is kept would no longer fit."""


class WindowState:
    """What is kept of the window; whatever else stands in the settings is passed over.

    Args:
        store: where it is kept.
    """

    def __init__(self, store: QSettings) -> None:
        self._store = store

    def save(self, window: QMainWindow, splitter: QSplitter, screen: str, *, beside: bool) -> None:
        """Keep all."""
        self._store.setValue(f"{GROUP}/geometry", window.saveGeometry())
        if beside:
            self._store.setValue(f"{GROUP}/splitter", splitter.saveState())
        self._store.setValue(f"{GROUP}/screen", screen)
        self._store.setValue(f"{GROUP}/beside", beside)
        self._store.sync()

    def restore(self, window: QMainWindow, splitter: QSplitter) -> None:
        """Put window and splitter where they were."""
        geometry = self._store.value(f"{GROUP}/geometry")
        if isinstance(geometry, QByteArray):
            window.restoreGeometry(geometry)
        state = self._store.value(f"{GROUP}/splitter")
        if isinstance(state, QByteArray):
            splitter.restoreState(state)

    @property
    def screen(self) -> str:
        """Name of the screen that was seen last."""
        try:
            return find_screen(str(self._store.value(f"{GROUP}/screen", ""))).name
        except WorkbenchError:
            return SCREENS[0].name

    @property
    def beside(self) -> bool:
        """Whether the 3-D view was beside it."""
        return str(self._store.value(f"{GROUP}/beside", True)).lower() == "true"
