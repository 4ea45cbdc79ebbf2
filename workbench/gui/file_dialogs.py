"""File dialogs, as all of the app opens them."""

from collections.abc import Callable

from PyQt6.QtWidgets import QFileDialog

from workbench.logs.flight_record import LOG_ENDINGS

LOG_FILES = "Logs ({})".format(" ".join(f"*{ending} *{ending.upper()}" for ending in LOG_ENDINGS))
"""What a file dialog shows of logs."""


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
