"""The panel with what a client needs to connect: address, command, fingerprint and QR code."""

import hashlib
import ssl
from pathlib import Path

from PyQt6.QtCore import Qt
from PyQt6.QtGui import QPixmap
from PyQt6.QtWidgets import QLineEdit, QPushButton, QWidget

from workbench.gui.file_dialogs import clipboard
from workbench.gui.labels import Label, set_tip
from workbench.gui.layout import NO_MARGINS, buddy, button, grid, hbox, label, named
from workbench.link.address import Address, parse_address
from workbench.link.backplane import ServerStatus
from workbench.link.connection import FINGERPRINT_PREFIX
from workbench.link.page_address import is_page_reachable, is_wildcard, lan_address
from workbench.link.qr import png_code
from workbench.link.server.config import ServerConfig

NOT_LISTENING_HINT = "When the server listens, its command line and its page are here to copy."
NO_WEB_PAGE_HINT = "For a browser, too: stop the server, tick Page for phones, and start it again."
FILE_HINT = "FILE: a copy of the tokens."
PHONE_HINT = "A phone in the same network opens the page with this code."
LOCAL_HINT = "Only this machine opens the page; for a phone, listen at 0.0.0.0 with tokens and TLS."
MAX_QR_CODE_PX = 132
"""Largest size of a QR code, which a phone can read from an arm's length [px]."""


def reachable_address(listening: str) -> str:
    """Return the address at which others reach a server; asks the system, and sends nothing.

    Args:
        listening: HOST:PORT; the host may stand for all addresses of this machine.
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
        address: address at which the server is reached.
        config: configuration of the server.
    """
    words = ["workbench gateway foxglove", address]
    if config.token_file:
        words.append("--token-file FILE")
    if config.tls_cert:
        words.append(f"--tls {fingerprint(config.tls_cert)}")
    return " ".join(words)


def fingerprint(certificate: str) -> str:
    """Return the fingerprint of a server's certificate, the first one in a file (PEM)."""
    begin, end = ssl.PEM_HEADER, ssl.PEM_FOOTER
    try:
        text = Path(certificate).read_text(encoding="ascii", errors="replace")
        first = text[text.index(begin) : text.index(end) + len(end)]
        digits = hashlib.sha256(ssl.PEM_cert_to_DER_cert(first)).hexdigest()
    except (OSError, ValueError):  # deleted after the server has read it
        digits = "FINGERPRINT"
    return FINGERPRINT_PREFIX + digits


class ConnectPanel(QWidget):
    """Connection details while a server listens.

    Attributes:
        address: address for others, "" without a server.
        texts: lines to copy, by kind: command, page.
        copies: their buttons.
        code: QR code of the page.
        hint: further hints.
    """

    def __init__(self) -> None:
        super().__init__()
        self.address = ""
        self.texts: dict[str, QLineEdit] = {}
        self.copies: dict[str, QPushButton] = {}
        self.code = Label()
        self.code.setFixedSize(MAX_QR_CODE_PX, MAX_QR_CODE_PX)
        self.code.setAlignment(Qt.AlignmentFlag.AlignCenter)
        self.hint = label(NOT_LISTENING_HINT, "muted", wraps=True)
        self.hint.setAlignment(Qt.AlignmentFlag.AlignLeft | Qt.AlignmentFlag.AlignVCenter)
        self._known: tuple[str, str] = ("", "")
        rows = (self._make_line("command", "Terminal"), self._make_line("page", "Page"))
        box = grid(*rows, of=self, margins=NO_MARGINS, spacing=(8, 4), stretches=(0, 1))
        box.addLayout(hbox(self.code, (self.hint, 1), spacing=12), len(rows), 0, 1, 3)
        box.setRowStretch(len(rows), 1)
        self.code.hide()

    def show_server(self, server: ServerStatus | None, config: ServerConfig) -> None:
        """Show how to connect to a server with this configuration; None if no server listens."""
        known = (server.address, server.page) if server else ("", "")
        if known == self._known:
            return
        self._known = known
        listening, page = known
        self.address = reachable_address(listening) if listening else ""
        command = connect_line(self.address, config) if listening else ""
        for name, text in (("command", command), ("page", page)):
            self.texts[name].setText(text)
            set_tip(self.texts[name], text)
            self.texts[name].setCursorPosition(0)
            self.copies[name].setEnabled(bool(text))
        self.code.setVisible(bool(page))
        if page:
            self.code.setPixmap(code_picture(page, self.devicePixelRatioF()))
            self.code.setAccessibleName(f"QR code of {page}")
        self.hint.setText(connect_hint_text(command, page))

    def copy_address(self) -> None:
        """Copy the server's address."""
        clipboard().setText(self.address)

    def _make_line(self, name: str, said: str) -> tuple[QWidget, ...]:
        text = named(QLineEdit(), f"{said}, to copy")
        text.setReadOnly(True)
        text.setPlaceholderText("–")
        copy = button("Copy", lambda: clipboard().setText(text.text()), "compact")
        copy.setEnabled(False)
        self.texts[name], self.copies[name] = text, named(copy, f"Copy the {name}")
        return buddy(said, text, kind=""), text, copy


def code_picture(text: str, ratio: float) -> QPixmap:
    """Return a text as a QR code, black on white, with a whole number of pixels per module.

    Args:
        text: the text.
        ratio: pixels of the screen per layout pixel.
    """
    code = QPixmap()
    code.loadFromData(png_code(text, scale=1))
    side = max(1, round(MAX_QR_CODE_PX * ratio) // code.width()) * code.width()
    code = code.scaled(side, side)
    code.setDevicePixelRatio(ratio)
    return code


def connect_hint_text(command: str, page: str) -> str:
    """Return further hints about connecting by a command line and a page."""
    if not command:
        return NOT_LISTENING_HINT
    hints = [FILE_HINT] if "FILE" in command.split() else []
    if not page:
        hints.append(NO_WEB_PAGE_HINT)
    else:
        hints.append(PHONE_HINT if is_page_reachable(page) else LOCAL_HINT)
    return "\n".join(hints)
