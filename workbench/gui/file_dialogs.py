"""File dialogs, as all of the app opens them."""

from collections.abc import Callable

from PyQt6.QtWidgets import QFileDialog


def show_file_dialog(dialog: QFileDialog, chosen: Callable[[str], None]) -> None:
    """Show a dialog, while the flight, and the key that stops it, go on.

    Args:
        dialog: as it is to be seen; it is Qt's own, as the desktop's would take the key, and not
            modal, as shortcuts are dead behind a modal one.
        chosen: hears the path.
    """
    dialog.setOption(QFileDialog.Option.DontUseNativeDialog)
    dialog.setModal(False)
    dialog.fileSelected.connect(chosen)
    dialog.finished.connect(dialog.deleteLater)
    dialog.show()
