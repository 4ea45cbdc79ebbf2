"""Pictures of files, drawn by a process of their own when the start page is first shown."""

from concurrent.futures import Future
from functools import partial
from pathlib import Path
from typing import Any

from PyQt6.QtCore import QObject, pyqtSignal

from workbench.common.errors import WorkbenchError
from workbench.gui.errands import FutureCallbacks
from workbench.gui.recent_files import FileKind
from workbench.gui.start.sketch import Sketch
from workbench.ipc.worker_process import WorkerProcess

SKETCH_WORKER_MODULE = "workbench.gui.start.sketch_worker"


class Sketches(QObject):
    """Asks for drawings, each once.

    Args:
        parent: the Qt parent.
    """

    ready = pyqtSignal(object, object)
    """Path of a file, and its `Sketch`."""

    def __init__(self, parent: QObject | None = None) -> None:
        super().__init__(parent)
        self._process: WorkerProcess | None = None
        self._asked: set[tuple[FileKind, Path, float]] = set()
        self._waiting = 0
        self._answers = FutureCallbacks(lambda _: None, self)

    @property
    def is_waiting(self) -> bool:
        """Whether drawings are still expected."""
        return self._waiting > 0

    def ask(self, kind: FileKind, path: Path) -> None:
        """Ask for the drawing of a file, unless it is known and the file has not changed."""
        try:
            changed = path.stat().st_mtime
            if (kind, path, changed) in self._asked:
                return
            self._asked.add((kind, path, changed))
            if self._process is None or self._process.ended:
                self._process = WorkerProcess(SKETCH_WORKER_MODULE, "sketcher", lambda _: None)
        except (OSError, WorkbenchError):
            return  # the card keeps its placeholder
        self._waiting += 1
        answer: Future[Any] = self._process.do((kind, path))
        self._answers.expect(answer, partial(self._end, path), lambda _: self._end(path, None))

    def _end(self, path: Path, sketch: Sketch | None) -> None:
        """Tell a drawing, None for a file that has none; the process ends after the last one."""
        self._waiting -= 1
        if sketch is not None:
            self.ready.emit(path, sketch)
        if not self._waiting and self._process is not None:
            process, self._process = self._process, None
            process.close()

    def close(self) -> None:
        """End the process."""
        self._answers.close()
        if self._process is not None:
            self._process.close()
