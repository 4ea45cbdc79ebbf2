"""Saves charts to files, in a thread, as disks may be slow."""

import time
from collections.abc import Callable
from concurrent.futures import Future, ThreadPoolExecutor
from pathlib import Path

from PyQt6.QtGui import QImage

from workbench.errors import WorkbenchError
from workbench.gui.charts.table_text import Column, table_text


def file_for(folder: str, title: str, suffix: str) -> Path:
    """Return a path in a folder, "" for the present one, named by a chart and the time of day."""
    name = "".join(each if each.isalnum() else "_" for each in title.lower()) or "chart"
    stamp = time.strftime("%Y%m%d_%H%M%S")
    return Path(folder or ".").absolute() / f"{name}_{stamp}.{suffix}"


def save_image(image: QImage, path: Path) -> "Future[Path]":
    """Write a picture; the answer is its path."""

    def write() -> Path:
        path.parent.mkdir(parents=True, exist_ok=True)
        if not image.save(str(path)):
            raise OSError("it cannot be written there")
        return path

    return _in_thread(write, path)


def save_table(columns: tuple[Column, ...], path: Path) -> "Future[Path]":
    """Write samples with commas between; the answer is the path."""
    kept = tuple(
        Column(each.label, each.unit, each.time.copy(), each.values.copy()) for each in columns
    )

    def write() -> Path:
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(table_text(kept, ","), encoding="utf-8")
        return path

    return _in_thread(write, path)


def _in_thread(write: Callable[[], Path], path: Path) -> "Future[Path]":
    def guarded() -> Path:
        try:
            return write()
        except OSError as error:
            reason = error.strerror or str(error)
            raise WorkbenchError(
                f"{path}: the chart was not saved: {reason}; choose another folder for logs in "
                "the settings"
            ) from error

    pool = ThreadPoolExecutor(1, "saving a chart")
    future = pool.submit(guarded)
    pool.shutdown(wait=False)
    return future
