"""Asks for gain files; the app goes on meanwhile."""

from collections.abc import Callable
from pathlib import Path

from PyQt6.QtWidgets import QFileDialog, QWidget

from workbench.gui.file_dialogs import show_file_dialog

FILTER = "Gain files (*.yaml *.yml)"


def ask_to_load(parent: QWidget, folder: str, chosen: Callable[[Path], None]) -> QFileDialog:
    """Show a dialog for a file that is there.

    Args:
        parent: over which it stands.
        folder: in which it begins.
        chosen: hears the path.
    """
    dialog = QFileDialog(parent, "Load gains", folder, FILTER)
    dialog.setFileMode(QFileDialog.FileMode.ExistingFile)
    return _show(dialog, chosen)


def ask_to_save(parent: QWidget, path: str, chosen: Callable[[Path], None]) -> QFileDialog:
    """Show a dialog for a file to be written; one that is there gets a longer history.

    Args:
        parent: over which it stands.
        path: that is proposed.
        chosen: hears the path.
    """
    dialog = QFileDialog(parent, "Save gains", path, FILTER)
    dialog.setAcceptMode(QFileDialog.AcceptMode.AcceptSave)
    dialog.setDefaultSuffix("yaml")
    dialog.setOption(QFileDialog.Option.DontConfirmOverwrite)  # the history keeps what was there
    dialog.selectFile(path)
    return _show(dialog, chosen)


def _show(dialog: QFileDialog, chosen: Callable[[Path], None]) -> QFileDialog:
    show_file_dialog(dialog, lambda path: chosen(Path(path)))
    return dialog
