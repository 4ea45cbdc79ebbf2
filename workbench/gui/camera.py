"""Takes pictures of the window."""

import threading
from concurrent.futures import Future
from datetime import datetime
from pathlib import Path

from PyQt6.QtGui import QImage
from PyQt6.QtWidgets import QWidget

from workbench.errors import WorkbenchError
from workbench.gui.answers import Answers
from workbench.gui.log_folder import log_folder
from workbench.gui.notices import Notices
from workbench.gui.preferences import Preferences


class Camera:
    """Writes pictures of a window into the folder for logs.

    Args:
        window: to be seen.
        preferences: where the folder is chosen.
        notices: where the path is told.
    """

    def __init__(self, window: QWidget, preferences: Preferences, notices: Notices) -> None:
        self._window, self._preferences, self._notices = window, preferences, notices
        self._answers = Answers(self._refuse, window)
        self._writing: list[threading.Thread] = []

    def take(self) -> None:
        """Take a picture now, and write it in the background: packing it takes a while."""
        image = self._window.grab().toImage()
        name = f"workbench-{datetime.now():%Y%m%d-%H%M%S-%f}"[:-3] + ".png"
        path = log_folder(self._preferences) / name
        future: Future[Path] = Future()
        self._answers.expect(future, lambda path: self._notices.inform(f"wrote {path}"))
        self._writing = [thread for thread in self._writing if thread.is_alive()]
        thread = threading.Thread(target=_write, args=(image, path, future), name="a picture")
        self._writing.append(thread)
        thread.start()

    def close(self) -> None:
        """Wait for what is being written."""
        self._answers.close()
        for thread in self._writing:
            thread.join()

    def _refuse(self, said: str) -> None:
        self._notices.warn(said, "Choose another folder for logs in Settings.")


def _write(image: QImage, path: Path, future: "Future[Path]") -> None:
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        if not image.save(str(path), "PNG"):
            raise OSError("the disk is full, or the folder is not to be written to")
    except OSError as error:
        future.set_exception(WorkbenchError(f"the picture {path} could not be written: {error}"))
    else:
        future.set_result(path)
