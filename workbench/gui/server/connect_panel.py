"""How others connect: a command line and a page, ready to be copied, and a code for phones."""

import hashlib
import ssl
from pathlib import Path

from PyQt6.QtCore import QRect, QSize, Qt
from PyQt6.QtGui import QGuiApplication, QPainter, QPaintEvent, QPixmap
from PyQt6.QtWidgets import (
    QGridLayout,
    QHBoxLayout,
    QLabel,
    QLineEdit,
    QPushButton,
    QSizePolicy,
    QWidget,
)

from workbench.gui.style import dressed
from workbench.link.address import Address, parse_address
from workbench.link.backplane import ServerStatus
from workbench.link.client_tls import FINGERPRINT
from workbench.link.page_address import PageAddress, is_wildcard, lan_address
from workbench.link.qr import png_code
from workbench.link.server.config import ServerConfig

NOT_YET = "Once the server listens, its command line and its page stand here, to be copied."
NO_PAGE = "Tick the page for phones to watch and fly in a browser, too."
FILE_HINT = "FILE: a copy of the tokens."
PHONE_HINT = "A phone in the same network opens the page by this code."
LOCAL_HINT = "Only this machine opens the page; for a phone, listen at 0.0.0.0 with tokens."


def reachable_address(listening: str) -> str:
    """Return where others reach a server; this asks the system, and nothing is sent.

    Args:
        listening: HOST:PORT, whose host may mean all addresses of this machine.
    """
    address = parse_address(listening)
    if not is_wildcard(address.host):
        return listening
    by_ipv6 = ":" in address.host
    own = lan_address(by_ipv6) or ("::1" if by_ipv6 else "127.0.0.1")
    return str(Address(own, address.port))


def connect_line(address: str, config: ServerConfig) -> str:
    """Return the command that watches a served flight.

    Args:
        address: where the server is reached.
        config: what it was started with.
    """
    words = ["workbench monitor", address]
    if config.token_file:
        words.append("--token-file FILE")
    if config.tls_cert:
        words.append(f"--tls {fingerprint(config.tls_cert)}")
    return " ".join(words)


def fingerprint(certificate: str) -> str:
    """Return by what a client knows a server's certificate, the first one of a file (PEM)."""
    begin, end = ssl.PEM_HEADER, ssl.PEM_FOOTER
    try:
        text = Path(certificate).read_text(encoding="ascii", errors="replace")
        first = text[text.index(begin) : text.index(end) + len(end)]
        digits = hashlib.sha256(ssl.PEM_cert_to_DER_cert(first)).hexdigest()
    except (OSError, ValueError):  # the server has read it before it was taken away
        digits = "FINGERPRINT"
    return FINGERPRINT + digits


class CodeView(QWidget):
    """Shows a QR code, black on white in every theme, in whole pixels a module."""

    def __init__(self, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self._text = ""
        self._code = QPixmap()
        self.setSizePolicy(QSizePolicy.Policy.Fixed, QSizePolicy.Policy.Fixed)

    def sizeHint(self) -> QSize:
        """Return a size that a phone reads from an arm's length."""
        return QSize(132, 132)

    def show_text(self, text: str) -> None:
        """Show a text as a code; nothing for ""."""
        if text != self._text:
            self._text = text
            self._code = QPixmap()
            if text:
                self._code.loadFromData(png_code(text, scale=1))
            self.setAccessibleName(f"QR code of {text}" if text else "")
            self.update()

    def paintEvent(self, event: QPaintEvent | None) -> None:
        """Paint the code as large as whole pixels allow, in the middle."""
        if self._code.isNull():
            return
        ratio = self.devicePixelRatioF()
        room = round(min(self.width(), self.height()) * ratio)
        side = max(1, room // self._code.width()) * self._code.width() / ratio
        painter = QPainter(self)
        painter.setRenderHint(QPainter.RenderHint.SmoothPixmapTransform, on=False)
        left, top = (self.width() - side) / 2, (self.height() - side) / 2
        area = QRect(round(left), round(top), round(side), round(side))
        painter.fillRect(area, Qt.GlobalColor.white)
        painter.drawPixmap(area, self._code)


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
