"""File dialogs and the clipboard, as the whole app uses them."""

from collections.abc import Callable
from pathlib import Path

from PyQt6.QtCore import Qt
from PyQt6.QtGui import QClipboard, QGuiApplication
from PyQt6.QtWidgets import QFileDialog, QWidget

from workbench.logs.readers.log_reader import log_endings


def log_file_filter() -> str:
    """Return the filter of file dialogs for logs."""
    return "Logs ({})".format(" ".join(f"*{ending} *{ending.upper()}" for ending in log_endings()))


def clipboard() -> QClipboard:
    """Return the desktop's clipboard."""
    found = QGuiApplication.clipboard()
    assert found is not None
    return found


def open_file(
    parent: QWidget, title: str, chosen: Callable[[Path], object], at: str = "", kinds: str = ""
) -> QFileDialog:
    """Show a dialog for an existing file, and return it; one that is open comes to the front.

    Args:
        parent: the Qt parent; with the title it says which dialog is the same.
        title: title of the dialog.
        chosen: called with the path.
        at: folder or file that it shows first; "" for the present folder.
        kinds: filter of names as Qt writes it; "" for all.
    """
    if earlier := shown_again(parent, title):
        return earlier
    dialog = QFileDialog(parent, title, at, kinds)
    dialog.setFileMode(QFileDialog.FileMode.ExistingFile)
    dialog.setOption(QFileDialog.Option.ReadOnly)  # Qt's questions would render a file's name
    show_file_dialog(dialog, lambda path: chosen(Path(path)))
    return dialog


def save_file(
    parent: QWidget, title: str, chosen: Callable[[Path], object], at: str = "", kinds: str = ""
) -> QFileDialog:
    """Show a dialog for a file to write, and return it; arguments as for `open_file`.

    It does not ask before an existing file is chosen: use it where nothing in such a file is lost.
    """
    if earlier := shown_again(parent, title):
        return earlier
    dialog = QFileDialog(parent, title, at, kinds)
    dialog.setAcceptMode(QFileDialog.AcceptMode.AcceptSave)
    dialog.setOption(QFileDialog.Option.DontConfirmOverwrite)
    dialog.selectFile(at)
    show_file_dialog(dialog, lambda path: chosen(Path(path)))
    return dialog


def choose_folder(parent: QWidget, title: str, chosen: Callable[[str], object], at: str) -> None:
    """Show a dialog for a folder; arguments as for `open_file`."""
    if shown_again(parent, title):
        return
    dialog = QFileDialog(parent, title, at)
    dialog.setFileMode(QFileDialog.FileMode.Directory)
    dialog.setOption(QFileDialog.Option.ShowDirsOnly)
    show_file_dialog(dialog, chosen)


def shown_again(parent: QWidget, title: str) -> QFileDialog | None:
    """Return the open dialog of a title, brought to the front; None without one."""
    direct = Qt.FindChildOption.FindDirectChildrenOnly
    for earlier in parent.findChildren(QFileDialog, options=direct):
        if earlier.isVisible() and earlier.windowTitle() == title:
            earlier.raise_()
            earlier.activateWindow()
            return earlier
    return None


def show_file_dialog(dialog: QFileDialog, chosen: Callable[[str], object]) -> None:
    """Show a dialog, while the flight and the key that stops it keep working.

    Args:
        dialog: the dialog. It is Qt's own, because the desktop's would take the key, and not modal,
            because shortcuts do not work behind a modal one.
        chosen: called with the path.
    """
    dialog.setOption(QFileDialog.Option.DontUseNativeDialog)
    dialog.setModal(False)
    dialog.fileSelected.connect(chosen)
    dialog.finished.connect(dialog.deleteLater)
    dialog.show()
