"""Copies and files of what a chart shows."""

from collections.abc import Callable
from functools import partial
from pathlib import Path

from PyQt6.QtCore import QObject
from PyQt6.QtGui import QGuiApplication
from PyQt6.QtWidgets import QWidget

from workbench.gui.answers import Answers
from workbench.gui.charts.saving import file_for, save_image, save_table
from workbench.gui.charts.table_text import Column, table_text
from workbench.gui.log_folder import log_folder
from workbench.gui.workspace import Workspace


class Copies(QObject):
    """Takes pictures and data to the clipboard or to a file, and tells of it.

    Args:
        workspace: folder and notices.
        parent: whose life it shares.
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
        self._run(partial(save_image, image, self._file(title, "png")))

    def save_data(self, columns: tuple[Column, ...], title: str) -> None:
        """Write samples (CSV), in SI, to the folder for logs."""
        kept = tuple(
            Column(each.label, each.unit, each.time.copy(), each.values.copy()) for each in columns
        )
        self._run(partial(save_table, kept, self._file(title, "csv")))

    def _run(self, save: Callable[[], Path]) -> None:
        self._answers.expect(self._workspace.errands.run(save), self._saved)

    def _file(self, title: str, suffix: str) -> Path:
        return file_for(log_folder(self._workspace.preferences), title, suffix)

    def _saved(self, path: Path) -> None:
        self._workspace.notices.inform(f"Saved {path}")
