"""Saves charts to files."""

import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from PyQt6.QtGui import QImage

from workbench.common.errors import WorkbenchError
from workbench.gui.charts.table_text import Column, table_text


def file_for(folder: Path, title: str, suffix: str) -> Path:
    """Return a path in a folder, named by a chart and the time of day."""
    name = "".join(each if each.isalnum() else "_" for each in title.lower()) or "chart"
    stamp = time.strftime("%Y%m%d_%H%M%S")
    return folder.absolute() / f"{name}_{stamp}.{suffix}"


def save_image(image: QImage, path: Path) -> Path:
    """Write a picture, and return its path.

    Raises:
        WorkbenchError: it cannot be written.
    """
    with _folder_of(path):
        if not image.save(str(path)):
            raise OSError("it cannot be written there")
    return path


def save_table(columns: tuple[Column, ...], path: Path) -> Path:
    """Write samples with commas between, and return the path.

    Raises:
        WorkbenchError: it cannot be written.
    """
    with _folder_of(path):
        path.write_text(table_text(columns, ","), encoding="utf-8")
    return path


@contextmanager
def _folder_of(path: Path) -> Iterator[None]:
    """Make the folder that a file is written to, and say what went wrong."""
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        yield
    except OSError as error:
        reason = error.strerror or str(error)
        raise WorkbenchError(
            f"{path}: the chart was not saved: {reason}; choose another folder for logs in "
            "the settings"
        ) from error
