"""The kinds of files that the app opens, and the files that were opened last."""

from enum import Enum
from pathlib import Path

from PyQt6.QtCore import QObject, QSettings, pyqtSignal

RECENT_FILES_KEY = "recent/1"
MAX_RECENT_FILES = 8


class FileKind(Enum):
    """Kind of a file."""

    SCENARIO = "scenario"
    MODEL = "model"
    WORLD = "world"
    CONTROLLER = "controller"
    LOG = "log"
    LAYOUT = "layout"
    SPEC = "spec"

    @property
    def label(self) -> str:
        """Its name as shown; its value is stored, and stays."""
        return "drone" if self is FileKind.MODEL else self.value


RecentFile = tuple[FileKind, str]
"""Kind and path of an opened file."""


class RecentFiles(QObject):
    """The recent files, newest first.

    Args:
        store: storage of the list.
        parent: the Qt parent; this object is deleted with it.
    """

    changed = pyqtSignal()
    """Another file was opened."""
    wanted = pyqtSignal(object, object)
    """A file should be opened: its `FileKind` and path."""
    choice_wanted = pyqtSignal(object)
    """A file of a `FileKind` should be chosen and opened."""

    def __init__(self, store: QSettings, parent: QObject | None = None) -> None:
        super().__init__(parent)
        self._store = store

    def add(self, kind: FileKind, path: str) -> None:
        """Add a file as the newest."""
        path = str(Path(path).expanduser().absolute())
        kept = [each for each in self._read() if each[1] != path]
        self._store.setValue(
            RECENT_FILES_KEY,
            [f"{of.value}:{at}" for of, at in [(kind, path), *kept][:MAX_RECENT_FILES]],
        )
        self.changed.emit()

    def files(self) -> tuple[RecentFile, ...]:
        """Return the files that still exist."""
        return tuple(each for each in self._read() if Path(each[1]).exists())

    def _read(self) -> list[RecentFile]:
        """Return the stored list, without invalid entries."""
        kept = self._store.value(RECENT_FILES_KEY, [])
        lines = [kept] if isinstance(kept, str) else kept if isinstance(kept, list) else []
        found = []
        kinds = {kind.value: kind for kind in FileKind}
        for line in lines:
            word, colon, path = str(line).partition(":")
            if colon and word in kinds and path:
                found.append((kinds[word], path))
        return found
