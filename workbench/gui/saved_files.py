"""Files that the app writes to the folder for logs: pictures, and data of charts."""

from collections.abc import Callable
from datetime import datetime
from functools import partial
from pathlib import Path

from PyQt6.QtWidgets import QWidget

from workbench.common.errors import WorkbenchError
from workbench.gui.preferences import log_folder
from workbench.gui.workspace import Workspace


def save_beside_logs(workspace: Workspace, name: str, write: Callable[[Path], int]) -> None:
    """Write a file to the folder for logs in the background; a notice has its path, or a refusal.

    Args:
        workspace: has the folder, and takes the notice.
        name: name of the file.
        write: writes it; returns 0 if it has written nothing.
    """
    path, notices = log_folder(workspace.preferences).absolute() / name, workspace.notices
    workspace.answers.expect(
        workspace.errands.run(partial(_write_file, path, write)),
        lambda path: notices.inform(f"Saved {path}"),
        lambda said: notices.warn(said, "Choose another folder for logs in Settings."),
    )


def save_screenshot(window: QWidget, workspace: Workspace) -> None:
    """Take a picture of a window now, and write it in the background, as compression is slow."""
    image = window.grab().toImage()
    name = f"workbench-{datetime.now():%Y%m%d-%H%M%S-%f}"[:-3] + ".png"
    save_beside_logs(workspace, name, lambda path: image.save(str(path), "PNG"))


def _write_file(path: Path, write: Callable[[Path], int]) -> Path:
    """Write a file, make its folder if necessary, and return its path.

    Raises:
        WorkbenchError: if the file cannot be written.
    """
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        if not write(path):
            raise OSError("the disk is full, or the folder is not writable")
    except OSError as error:
        raise WorkbenchError(f"{path} was not saved: {error.strerror or error}") from error
    return path
