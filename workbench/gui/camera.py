"""Takes pictures of the window."""

from datetime import datetime
from functools import partial
from pathlib import Path

from PyQt6.QtGui import QImage
from PyQt6.QtWidgets import QWidget

from workbench.common.errors import WorkbenchError
from workbench.gui.answers import Answers
from workbench.gui.log_folder import log_folder
from workbench.gui.workspace import Workspace


class Camera:
    """Writes pictures of a window into the folder for logs.

    Args:
        window: to be seen.
        workspace: where the folder is chosen, and the path is told.
    """

    def __init__(self, window: QWidget, workspace: Workspace) -> None:
        self._window, self._workspace = window, workspace
        self._answers = Answers(self._refuse, window)

    def take(self) -> None:
        """Take a picture now, and write it in the background: packing it takes a while."""
        image = self._window.grab().toImage()
        name = f"workbench-{datetime.now():%Y%m%d-%H%M%S-%f}"[:-3] + ".png"
        path = log_folder(self._workspace.preferences) / name
        self._answers.expect(
            self._workspace.errands.run(partial(_write, image, path)),
            lambda path: self._workspace.notices.inform(f"wrote {path}"),
        )

    def close(self) -> None:
        """Tell of no further picture."""
        self._answers.close()

    def _refuse(self, said: str) -> None:
        self._workspace.notices.warn(said, "Choose another folder for logs in Settings.")


def _write(image: QImage, path: Path) -> Path:
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        if not image.save(str(path), "PNG"):
            raise OSError("the disk is full, or the folder is not to be written to")
    except OSError as error:
        raise WorkbenchError(f"the picture {path} could not be written: {error}") from error
    return path
