"""How others connect: a command line and a page, ready to be copied, and a code for phones."""

from PyQt6.QtCore import Qt
from PyQt6.QtGui import QGuiApplication
from PyQt6.QtWidgets import QGridLayout, QHBoxLayout, QLabel, QLineEdit, QPushButton, QWidget

from workbench.gui.server.code_view import CodeView
from workbench.gui.server.connect_line import connect_line, reachable_address
from workbench.gui.style import dressed
from workbench.link.backplane import ServerStatus
from workbench.link.page_address import PageAddress
from workbench.link.server.config import ServerConfig

NOT_YET = "Once the server listens, its command line and its page stand here, to be copied."
NO_PAGE = "Tick the page for phones to watch and fly in a browser, too."
FILE_HINT = "FILE: a copy of the tokens."
PHONE_HINT = "A phone in the same network opens the page by this code."
LOCAL_HINT = "Only this machine opens the page; for a phone, listen at 0.0.0.0 with tokens."


class ConnectPanel(QWidget):
    """Texts that are there while a server listens.

    Attributes:
        address: where others reach the server, "" while none listens.
        texts: lines to copy, by what they are: command, page.
        copies: their buttons.
        code: of the page.
        hint: what else there is to know.
    """

    def __init__(self, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self.address = ""
        self.texts: dict[str, QLineEdit] = {}
        self.copies: dict[str, QPushButton] = {}
        self.code = CodeView(self)
        self.hint = dressed(QLabel(NOT_YET, self), "muted")
        self.hint.setWordWrap(True)
        self.hint.setAlignment(Qt.AlignmentFlag.AlignLeft | Qt.AlignmentFlag.AlignVCenter)
        self._known: tuple[str, str] = ("", "")
        grid = QGridLayout(self)
        grid.setContentsMargins(0, 0, 0, 0)
        grid.setHorizontalSpacing(8)
        grid.setVerticalSpacing(4)
        grid.setColumnStretch(1, 1)
        self._add(grid, "command", "Terminal")
        self._add(grid, "page", "Page")
        lower = QHBoxLayout()
        lower.setSpacing(12)
        lower.addWidget(self.code)
        lower.addWidget(self.hint, 1)
        grid.addLayout(lower, 3, 0, 1, 3)
        grid.setRowStretch(3, 1)
        self.code.hide()

    def show_server(self, server: ServerStatus | None, config: ServerConfig) -> None:
        """Show how to connect to a server that was started so; None where none listens."""
        known = (server.address, server.page) if server else ("", "")
        if known == self._known:
            return
        self._known = known
        listening, page = known
        self.address = reachable_address(listening) if listening else ""
        command = connect_line(self.address, config) if listening else ""
        for name, text in (("command", command), ("page", page)):
            self.texts[name].setText(text)
            self.texts[name].setToolTip(text)
            self.texts[name].setCursorPosition(0)
            self.copies[name].setEnabled(bool(text))
        self.code.show_text(page)
        self.code.setVisible(bool(page))
        self.hint.setText(say_hint(command, page))

    def copy_address(self) -> None:
        """Copy where others reach the server."""
        _copy(self.address)

    def _add(self, grid: QGridLayout, name: str, label: str) -> None:
        text = QLineEdit(self)
        text.setReadOnly(True)
        text.setPlaceholderText("–")
        text.setAccessibleName(f"{label}, to copy")
        before = QLabel(label, self)
        before.setBuddy(text)
        copy = dressed(QPushButton("Copy", self), "compact")
        copy.setAccessibleName(f"Copy the {name}")
        copy.setEnabled(False)
        copy.clicked.connect(lambda: _copy(text.text()))
        self.texts[name], self.copies[name] = text, copy
        row = len(self.texts)
        for column, widget in enumerate((before, text, copy)):
            grid.addWidget(widget, row, column)


def say_hint(command: str, page: str) -> str:
    """Return what else there is to know about connecting by a command line and a page."""
    if not command:
        return NOT_YET
    hints = [FILE_HINT] if "FILE" in command.split() else []
    if not page:
        hints.append(NO_PAGE)
    else:
        hints.append(PHONE_HINT if PageAddress(page).is_reachable else LOCAL_HINT)
    return "\n".join(hints)


def _copy(text: str) -> None:
    clipboard = QGuiApplication.clipboard()
    if clipboard is not None:
        clipboard.setText(text)
