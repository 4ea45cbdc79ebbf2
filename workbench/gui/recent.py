"""Files that were opened lately, kept between starts; what is gone is forgotten."""

from dataclasses import dataclass
from pathlib import Path

from PyQt6.QtCore import QObject, QSettings, pyqtSignal

from workbench.gui.opening import FileKind

KEY = "recent/1"
MOST = 8


@dataclass(frozen=True)
class Recent:
    """A file that was opened.

    Attributes:
        kind: what it is.
        path: of it.
    """

    kind: FileKind
    path: str


class RecentFiles(QObject):
    """The newest files first.

    Args:
        store: where they are kept.
        parent: the Qt parent; this object is deleted with it.
    """

    changed = pyqtSignal()
    """Another file was opened."""

    def __init__(self, store: QSettings, parent: QObject | None = None) -> None:
        super().__init__(parent)
        self._store = store

    def add(self, kind: FileKind, path: str) -> None:
        """Remember a file as the newest."""
        new = Recent(kind, str(Path(path).expanduser().absolute()))
        kept = [each for each in self._read() if each.path != new.path]
        self._write([new, *kept][:MOST])
        self.changed.emit()

    def files(self) -> tuple[Recent, ...]:
        """Return those that are still there."""
        return tuple(each for each in self._read() if Path(each.path).exists())

    def _read(self) -> list[Recent]:
        """Return what is kept, without what makes no sense."""
        kept = self._store.value(KEY, [])
        lines = [kept] if isinstance(kept, str) else kept if isinstance(kept, list) else []
        found = []
        kinds = {kind.value: kind for kind in FileKind}
        for line in lines:
            word, colon, path = str(line).partition(":")
            if colon and word in kinds and path:
                found.append(Recent(kinds[word], path))
        return found

    def _write(self, files: list[Recent]) -> None:
        self._store.setValue(KEY, [f"{each.kind.value}:{each.path}" for each in files])
