"""File dialogs, as the whole app opens them."""

from collections.abc import Callable

from PyQt6.QtWidgets import QFileDialog

from workbench.logs.flight_record import LOG_ENDINGS

LOG_FILES = "Logs ({})".format(" ".join(f"*{ending} *{ending.upper()}" for ending in LOG_ENDINGS))
"""Filter of file dialogs for logs."""


def show_file_dialog(dialog: QFileDialog, chosen: Callable[[str], None]) -> None:
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
