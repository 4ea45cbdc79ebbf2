"""Imports what is needed soon while the window is already there."""

import contextlib
import importlib
import threading
from collections.abc import Sequence

from PyQt6.QtCore import QObject, Qt, pyqtSignal


class ModuleLoader(QObject):
    """Imports modules in a thread of its own, one after another, so that the window stays quick.

    A module that cannot be imported is passed over: who needs it finds out why.

    Args:
        modules: full names.
        parent: the Qt parent; this object is deleted with it.
    """

    loaded = pyqtSignal(str)
    """Name of a module that is there now, or cannot be had."""
    _arrived = pyqtSignal(str)

    def __init__(self, modules: Sequence[str], parent: QObject | None = None) -> None:
        super().__init__(parent)
        self._modules = tuple(modules)
        self._wanted = True
        self._thread: threading.Thread | None = None
        queued = Qt.ConnectionType.QueuedConnection
        self._arrived.connect(self._pass_on, queued)  # type: ignore[call-arg]

    def start(self) -> None:
        """Begin."""
        if self._thread is None and self._wanted:
            self._thread = threading.Thread(target=self._load, name="loading screens")
            self._thread.start()

    def close(self) -> None:
        """Load no further module, and wait for the one that is being loaded."""
        self._wanted = False
        if self._thread is not None:
            self._thread.join()

    def _load(self) -> None:
        for name in self._modules:
            if not self._wanted:
                return
            # who shows the screen imports it again, and tells what is wrong with it
            with contextlib.suppress(Exception):
                importlib.import_module(name)
            self._arrived.emit(name)

    def _pass_on(self, name: str) -> None:
        if self._wanted:
            self.loaded.emit(name)
