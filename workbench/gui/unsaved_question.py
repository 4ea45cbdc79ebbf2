"""The question whether unsaved data should be saved before its flight ends."""

from collections.abc import Callable

from PyQt6.QtCore import Qt
from PyQt6.QtWidgets import QMessageBox, QWidget

from workbench.common.plain_text import plain_text
from workbench.gui.screens import Screen


def ask_about_unsaved(
    screen: Screen | None, go_on: Callable[[], object], before: str, parent: QWidget
) -> None:
    """Continue with what ends the flight, once nothing would be lost or the user agrees.

    It does not ask because of a flight in the air: that can be repeated, and its log is completed.
    The question is not modal: the flight continues, and F12 stops the rotors. It takes the place of
    an earlier one.

    Args:
        screen: has data that would be lost with the flight; None if there is none.
        go_on: ends the flight.
        before: what follows, in words.
        parent: the window.
    """
    for earlier in parent.findChildren(QMessageBox):
        earlier.close()
    if screen is None:
        go_on()
        return
    kinds = QMessageBox.StandardButton
    box = QMessageBox(
        QMessageBox.Icon.Question,
        "Unsaved gains",
        f"Save the tuned gains before {before}?",
        kinds.Save | kinds.Discard | kinds.Cancel,
        parent,
    )
    box.setTextFormat(Qt.TextFormat.PlainText)
    box.setInformativeText(plain_text(screen.unsaved()))
    box.setModal(False)
    save, discard = box.button(kinds.Save), box.button(kinds.Discard)
    assert save is not None and discard is not None
    save.setText("&Save…")
    save.clicked.connect(lambda: screen.save_unsaved(go_on))
    discard.clicked.connect(lambda: go_on())
    box.finished.connect(box.deleteLater)
    box.show()
