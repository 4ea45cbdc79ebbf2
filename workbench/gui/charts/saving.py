"""Copies and files of what a chart shows."""

import time
from collections.abc import Callable, Sequence
from functools import partial
from pathlib import Path
from typing import NamedTuple

import numpy as np
from PyQt6.QtCore import QObject
from PyQt6.QtGui import QGuiApplication
from PyQt6.QtWidgets import QWidget

from workbench.common.errors import WorkbenchError
from workbench.gui.answers import Answers
from workbench.gui.preferences import log_folder
from workbench.gui.workspace import Workspace


class Column(NamedTuple):
    """A curve of a table: its name, SI unit, times [s] and values, as many of both."""

    label: str
    unit: str
    time: np.ndarray
    values: np.ndarray


class Copies(QObject):
    """Takes pictures and data to the clipboard or to a file, and tells of it.

    Args:
        workspace: folder and notices.
        parent: the Qt parent; this object is deleted with it.
    """

    def __init__(self, workspace: Workspace, parent: QObject | None = None) -> None:
        super().__init__(parent)
        self._workspace = workspace
        self._answers = Answers(workspace.notices.warn, self)

    def copy_picture(self, widget: QWidget) -> None:
        """Copy a widget as a picture."""
        clipboard = QGuiApplication.clipboard()
        if clipboard is not None:
            clipboard.setPixmap(widget.grab())
            self._workspace.notices.inform("The chart is on the clipboard, as a picture.")

    def copy_data(self, columns: tuple[Column, ...]) -> None:
        """Copy samples, in SI, with tabs between."""
        clipboard = QGuiApplication.clipboard()
        if clipboard is not None:
            clipboard.setText(table_text(columns))
            self._workspace.notices.inform("The chart's data are on the clipboard, in SI units.")

    def save_picture(self, widget: QWidget, title: str) -> None:
        """Write a widget as a picture (PNG) to the folder for logs."""
        image = widget.grab().toImage()
        self._write(title, "png", lambda path: image.save(str(path)))

    def save_data(self, columns: tuple[Column, ...], title: str) -> None:
        """Write samples (CSV), in SI, to the folder for logs."""
        kept = [each._replace(time=each.time.copy(), values=each.values.copy()) for each in columns]
        self._write(title, "csv", lambda path: path.write_text(table_text(kept, ","), "utf-8"))

    def _write(self, title: str, suffix: str, write: Callable[[Path], int]) -> None:
        """Write a file to the folder for logs, named by a chart and the time of day."""
        name = "".join(each if each.isalnum() else "_" for each in title.lower()) or "chart"
        stamp = time.strftime("%Y%m%d_%H%M%S")
        folder = log_folder(self._workspace.preferences).absolute()
        path = folder / f"{name}_{stamp}.{suffix}"
        self._answers.expect(
            self._workspace.errands.run(partial(_write_file, path, write)),
            lambda path: self._workspace.notices.inform(f"Saved {path}"),
        )


def table_text(columns: Sequence[Column], separator: str = "\t") -> str:
    """Return a line of names with units, then a line for each time at which there is a sample.

    A curve without a sample at that time has an empty cell.
    """
    heads = ["time [s]", *(f"{each.label} [{each.unit or '1'}]" for each in columns)]
    lines = [separator.join(heads)]
    if columns:
        time = columns[0].time
        if any(each.time.shape != time.shape or (each.time != time).any() for each in columns[1:]):
            time = np.unique(np.concatenate([each.time for each in columns]))
        table = np.full((len(time), 1 + len(columns)), np.nan)
        table[:, 0] = time
        for index, each in enumerate(columns, 1):
            table[np.searchsorted(time, each.time), index] = each.values
        row = separator.join(["%.9g"] * table.shape[1])
        filled = "\n".join([row] * len(time)) % tuple(table.ravel().tolist())
        lines.append(filled.replace("nan", ""))
    return "\n".join(line for line in lines if line) + "\n"


def _write_file(path: Path, write: Callable[[Path], int]) -> Path:
    """Write a file in its folder, which is made, and return its path.

    Args:
        path: of the file.
        write: returns 0 where it has written nothing.

    Raises:
        WorkbenchError: if it cannot be written.
    """
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        if not write(path):
            raise OSError("it cannot be written there")
    except OSError as error:
        reason = error.strerror or str(error)
        raise WorkbenchError(
            f"{path}: the chart was not saved: {reason}; choose another folder for logs in "
            "the settings"
        ) from error
    return path
