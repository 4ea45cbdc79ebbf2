"""The server screen: let others watch and fly, and see who does."""

import hashlib
import ssl
from collections.abc import Callable, Mapping
from concurrent.futures import Future
from enum import Enum
from functools import partial
from pathlib import Path
from typing import Any

from PyQt6.QtCore import QObject, QSettings, Qt, QTime, pyqtSignal
from PyQt6.QtGui import QPixmap
from PyQt6.QtWidgets import (
    QCheckBox,
    QFrame,
    QGridLayout,
    QLineEdit,
    QPlainTextEdit,
    QPushButton,
    QWidget,
)

from workbench.common.errors import WorkbenchError
from workbench.common.plain_text import LONGEST_TEXT, plain_name
from workbench.gui.errands import single_shot
from workbench.gui.file_dialogs import clipboard, open_file, save_file
from workbench.gui.flight_model import FlightModel
from workbench.gui.help import explain, explained
from workbench.gui.labels import ElidedLabel, Label, set_tip
from workbench.gui.layout import (
    NO_MARGINS,
    Pair,
    buddy,
    button,
    fit_page,
    grid,
    hbox,
    label,
    named,
    vbox,
)
from workbench.gui.number_field import read_whole_number
from workbench.gui.screens import Screen
from workbench.gui.server.clients_panel import ClientsPanel
from workbench.gui.style import dressed, set_class
from workbench.gui.workspace import Workspace
from workbench.link.address import Address, parse_address
from workbench.link.authentication import write_tokens
from workbench.link.backplane import ServerStatus
from workbench.link.connection import FINGERPRINT
from workbench.link.page_address import PageAddress, is_wildcard, lan_address
from workbench.link.qr import png_code
from workbench.link.server.config import ServerConfig
from workbench.live.flight import LiveFlight
from workbench.live.messages import NetworkView, Phase
from workbench.live.view import LiveView

NOT_YET = "When the server listens, its command line and its page are here to copy."
NO_PAGE = "Tick the page for phones to watch and fly in a browser, too."
FILE_HINT = "FILE: a copy of the tokens."
PHONE_HINT = "A phone in the same network opens the page with this code."
LOCAL_HINT = "Only this machine opens the page; for a phone, listen at 0.0.0.0 with tokens."
KEPT = ("host", "port", "token_file", "tls_cert", "tls_key", "allow_commands", "web")
"""Parts of a configuration in the form."""
GROUP = "server"
AFTER_TYPING = 250
"""Delay after the last key before files are checked [ms]."""
ENDED_WITH_FLIGHT = "the server has ended with its flight: start it again"
CODE = 132
"""Largest size of a QR code, which a phone can read from an arm's length [px]."""
LONGEST = 300
"""Number of kept lines."""


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
    words = ["workbench monitor", address]
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
    return FINGERPRINT + digits


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
        self.code.setFixedSize(CODE, CODE)
        self.code.setAlignment(Qt.AlignmentFlag.AlignCenter)
        self.hint = label(NOT_YET, "muted", wraps=True)
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
        self.hint.setText(say_hint(command, page))

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
    side = max(1, round(CODE * ratio) // code.width()) * code.width()
    code = code.scaled(side, side)
    code.setDevicePixelRatio(ratio)
    return code


def say_hint(command: str, page: str) -> str:
    """Return further hints about connecting by a command line and a page."""
    if not command:
        return NOT_YET
    hints = [FILE_HINT] if "FILE" in command.split() else []
    if not page:
        hints.append(NO_PAGE)
    else:
        hints.append(PHONE_HINT if PageAddress(page).is_reachable else LOCAL_HINT)
    return "\n".join(hints)


def read_port(text: str) -> int | str:
    """Return a port as a number; unchanged if it is not a number; `check` then refuses it."""
    try:
        return read_whole_number(text)
    except WorkbenchError:
        return text


def written_faults(config: ServerConfig) -> Mapping[str, str]:
    """Return errors by field, without access to any file."""
    faults = {}
    if said := _refusal(ServerConfig(port=config.port).check):
        faults["port"] = said
    if said := _refusal(ServerConfig(host=config.host).check):
        # An invalid host is refused first; any later refusal is that others can reach the server.
        first = _refusal(ServerConfig(host=config.host, clients=0).check)
        if said == first:
            faults["host"] = said
        elif not config.token_file:
            faults["token_file"] = said
    return faults


def file_faults(config: ServerConfig) -> Mapping[str, str]:
    """Return errors in named files, by field; they are small, and are read here."""
    faults = {}
    if said := _no_plain_file(config.token_file) or _refusal(config.tokens):
        faults["token_file"] = said
    if said := _no_plain_file(config.tls_cert):
        faults["tls_cert"] = said
    elif said := _no_plain_file(config.tls_key) or _refusal(config.tls):
        faults["tls_key"] = said
    return faults


def read_config(store: QSettings) -> ServerConfig:
    """Return the stored configuration of the form, or the default."""
    found: dict[str, Any] = {}
    for name in KEPT:
        default = getattr(ServerConfig, name)
        kept = str(store.value(f"{GROUP}/{name}", default))
        found[name] = kept.lower() == "true" if isinstance(default, bool) else kept
    return ServerConfig(**found | {"port": read_port(str(found["port"]))})


def keep_config(store: QSettings, config: ServerConfig) -> None:
    """Store the form for the next start; of tokens and keys only the paths."""
    for name in KEPT:
        store.setValue(f"{GROUP}/{name}", getattr(config, name))


def _no_plain_file(path: str) -> str:
    """Return why reading a path could block, as for a pipe; "" if it cannot."""
    if not path:
        return ""
    try:
        odd = Path(path).exists() and not Path(path).is_file()
    except (OSError, ValueError):  # opening it reports the error
        return ""
    return f"{path}: is not a plain file: choose another" if odd else ""


def _refusal(check: Callable[[], object]) -> str:
    try:
        check()
    except WorkbenchError as error:
        return str(error)
    return ""


class ServerForm(QWidget):
    """Fields that show their errors beside themselves, and are stored.

    Args:
        store: storage of the values.

    Attributes:
        lines: text fields, by name.
        allow_commands: whether clients may fly.
        web: whether a page for phones is served.
    """

    changed = pyqtSignal()
    """The content, or its validity, has changed."""
    entered = pyqtSignal()
    """Enter was pressed in a field."""

    def __init__(self, store: QSettings) -> None:
        super().__init__()
        self._store = store
        self.lines: dict[str, QLineEdit] = {}
        self._faults: dict[str, Label] = {}
        self._buttons: list[QPushButton] = []
        self._grid = QGridLayout(self)
        self._grid.setContentsMargins(0, 0, 0, 0)
        self._grid.setHorizontalSpacing(8)
        self._grid.setVerticalSpacing(4)
        self._grid.setColumnStretch(1, 1)
        self._add("host", "&Host", "127.0.0.1 for this machine only, 0.0.0.0 for all networks")
        self._add("port", "P&ort", "TCP port, 0 to 65535; 0 takes a free one")
        self._add("token_file", "&Tokens", "file of two tokens, to watch and to fly")
        self._add("tls_cert", "T&LS certificate", "PEM file; empty without TLS")
        self._add("tls_key", "TLS &key", "PEM file of its private key")
        for name in ("token_file", "tls_cert", "tls_key"):
            self.lines[name].setPlaceholderText("none")
        self._add_buttons()
        self.allow_commands = QCheckBox("&Allow commands", self)
        set_tip(self.allow_commands, "Without it, everybody can only watch.")
        self.allow_commands.setAccessibleName("Allow commands: clients may fly")
        self.web = QCheckBox("Pa&ge for phones", self)
        set_tip(self.web, "Serve a web page that shows the flight, and flies it, on a phone.")
        self.web.setAccessibleName("Serve a page for phones and browsers")
        ticks = hbox(self.allow_commands, self.web, 1, spacing=16)
        self._grid.addLayout(ticks, self._grid.rowCount(), 1, 1, 2)
        self._grid.setRowStretch(self._grid.rowCount(), 1)
        self._timer = single_shot(self._look_at_files, self, AFTER_TYPING)
        self._show(read_config(store))
        for line in self.lines.values():
            line.textChanged.connect(self._written)
            line.returnPressed.connect(self.entered)
        self.allow_commands.toggled.connect(self._written)
        self.web.toggled.connect(self._written)
        self._look_at_files()

    @property
    def config(self) -> ServerConfig:
        """The configuration; its `check` says whether it is valid."""
        texts: dict[str, Any] = {name: line.text().strip() for name, line in self.lines.items()}
        return ServerConfig(
            **texts | {"port": read_port(texts["port"])},
            allow_commands=self.allow_commands.isChecked(),
            web=self.web.isChecked(),
        )

    @property
    def is_right(self) -> bool:
        """Whether no error is known."""
        return not any(label.text() for label in self._faults.values())

    def fault(self, name: str) -> str:
        """Return the error beside a field, "" without one."""
        return self._faults[name].text()

    def check(self) -> bool:
        """Check everything now, including files, and return whether all is valid."""
        self._look_at_files()
        return self.is_right

    def let_write(self, may: bool) -> None:
        """Enable or disable the fields: a running server keeps its configuration."""
        for line in self.lines.values():
            line.setReadOnly(not may)
        for each in self._buttons:
            each.setEnabled(may)
        self.allow_commands.setEnabled(may)
        self.web.setEnabled(may)

    def make_tokens(self, path: Path) -> None:
        """Write a new file of tokens and enter its path; only its owner can read it."""
        try:
            write_tokens(path)
        except WorkbenchError as error:
            self._say("token_file", str(error))
            self.changed.emit()
        else:
            self.lines["token_file"].setText(str(path))
            self._look_at_files()

    def _add(self, name: str, text: str, help: str) -> None:
        """Add a line with a label before it and its error below."""
        row = self._grid.rowCount()
        tip = help[:1].upper() + help[1:] + "."
        line = named(QLineEdit(self), f"{text.replace('&', '')}: {help}", tip)
        fault = label(kind="bad", wraps=True)
        fault.hide()
        self.lines[name], self._faults[name] = line, fault
        self._grid.addWidget(buddy(text, line, kind=""), row, 0)
        self._grid.addWidget(line, row, 1, 1, 1 if name not in ("host", "port") else 2)
        self._grid.addWidget(fault, row + 1, 1, 1, 2)

    def _add_buttons(self) -> None:
        for name, what in (
            ("token_file", "file of tokens"),
            ("tls_cert", "certificate"),
            ("tls_key", "key"),
        ):
            buttons = hbox(spacing=4)
            choose = self._button("Choose…", f"Choose a {what}", partial(self._choose, name, what))
            buttons.addWidget(choose)
            before: QWidget = self.lines[name]
            if name == "token_file":
                new = self._button("New…", "Make a new file of tokens", self._choose_new)
                buttons.addWidget(new)
                self.setTabOrder(choose, new)
            self.setTabOrder(before, choose)
            place = self._grid.getItemPosition(self._grid.indexOf(before))
            self._grid.addLayout(buttons, place[0] or 0, 2)

    def _button(self, text: str, name: str, pressed: Callable[[], None]) -> QPushButton:
        made = named(button(text, pressed, "compact"), name)
        made.setParent(self)  # the order of Tab is set before it is placed
        self._buttons.append(made)
        return made

    def _choose(self, name: str, what: str) -> None:
        line = self.lines[name]
        open_file(self, f"Choose a {what}", lambda path: line.setText(str(path)), line.text())

    def _choose_new(self) -> None:
        # no existing file is overwritten
        save_file(self, "Make a file of tokens", self.make_tokens, "link.tokens")

    def _show(self, config: ServerConfig) -> None:
        for name, line in self.lines.items():
            line.setText(str(getattr(config, name)))
            line.setCursorPosition(0)
        self.allow_commands.setChecked(config.allow_commands)
        self.web.setChecked(config.web)

    def _written(self) -> None:
        """Show errors in the text at once, and check files a little later."""
        config = self.config
        keep_config(self._store, config)
        faults = written_faults(config)
        for name in ("host", "port", "token_file"):
            self._say(name, faults.get(name, ""))
        self._timer.start()
        self.changed.emit()

    def _look_at_files(self) -> None:
        self._timer.stop()
        config = self.config
        faults = {**file_faults(config), **written_faults(config)}
        for name in self.lines:
            self._say(name, faults.get(name, ""))
        self.changed.emit()

    def _say(self, name: str, fault: str) -> None:
        self._faults[name].setText(f"✕ {fault}" if fault else "")
        self._faults[name].setVisible(bool(fault))
        set_class(self.lines[name], "bad" if fault else "")


class Running(Enum):
    """State of a server; the word is shown."""

    NO_FLIGHT = "No flight"
    STOPPED = "Stopped"
    STARTING = "Starting"
    LISTENING = "Listening"
    STOPPING = "Stopping"
    FAILED = "Failed"


CLASSES = {Running.LISTENING: "value good", Running.FAILED: "value bad"}
SIGNS = {Running.LISTENING: "●", Running.FAILED: "✕"}


def server_state(
    view: LiveView, flies: bool, wanted: Running | None, failure: str
) -> tuple[Running, str]:
    """Return the server's state, and the same as a sentence with what to do.

    Args:
        view: view of the flight.
        flies: whether there is a flight.
        wanted: STARTING or STOPPING while such an order has no answer, else None.
        failure: why the last start failed, or the server ended; else "".
    """
    if not flies or view.phase is Phase.ENDED:
        return Running.NO_FLIGHT, "A server serves a flight: open a scenario first."
    if wanted is Running.STOPPING:
        return Running.STOPPING, "Clients get a goodbye."
    if view.network.server is not None:
        count = len(view.network.server.clients)
        clients = "nobody is connected" if not count else f"{count} connected"
        return Running.LISTENING, f"at {view.network.server.address}; {clients}."
    if view.network.starts_again:
        return Running.STARTING, f"{failure[:1].upper()}{failure[1:]}."
    if wanted is Running.STARTING:
        return Running.STARTING, "It takes a moment."
    if failure:
        return Running.FAILED, f"{failure[:1].upper()}{failure[1:]}."
    return Running.STOPPED, "Nobody else can watch or fly until you start it."


class ServerControl(QObject):
    """The server of the present flight.

    Args:
        flight: the flight.
        parent: the Qt parent; this object is deleted with it.

    Attributes:
        config: last configuration of the server.
    """

    changed = pyqtSignal()
    """The state may have changed."""

    def __init__(self, flight: FlightModel, parent: QObject | None = None) -> None:
        super().__init__(parent)
        self._flight = flight
        self.config = ServerConfig()
        self._wanted: Running | None = None
        self._failure = ""
        self._served: LiveFlight | None = None
        self._listened = False
        flight.viewed.connect(self._look)

    @property
    def state(self) -> tuple[Running, str]:
        """The state, and the same as a sentence with what to do."""
        flies = self._flight.live is not None
        return server_state(self._flight.view, flies, self._wanted, self._failure)

    def start(self, config: ServerConfig) -> None:
        """Start a server; an error appears as its state."""
        if self._flight.live is None or self._wanted is not None:
            return
        self.config, self._served = config, self._flight.live
        self._wanted, self._failure = Running.STARTING, ""
        self._order(lambda live: live.serve(config))

    def stop(self) -> None:
        """Disconnect all clients and end the server."""
        if self._flight.live is None or self._wanted is Running.STOPPING:
            return
        self._wanted, self._failure, self._listened = Running.STOPPING, "", False
        self._order(lambda live: live.stop_serving())

    def _order(self, give: "Callable[[LiveFlight], Future[Any]]") -> None:
        served = self._flight.live
        self._flight.order(
            give,
            done=lambda _: self._answered(served, ""),
            refused=lambda said: self._answered(served, said),
        )
        self.changed.emit()

    def _answered(self, served: LiveFlight | None, failure: str) -> None:
        if served is not self._flight.live:
            return  # that flight is over, and so is its server
        self._wanted, self._failure = None, failure
        self.changed.emit()

    def _look(self, view: LiveView) -> None:
        """Notice a server that has ended by itself, or with its flight."""
        if self._flight.live is not self._served:
            self._served = self._flight.live
            self._failure = ENDED_WITH_FLIGHT if self._listened else ""
            self._wanted, self._listened = None, False
            self.changed.emit()
        listens = view.network.server is not None
        ended = (self._listened or self._failure) and not listens
        if ended and self._wanted is None:
            failure = view.network.said or self._failure or "the server has ended: start it again"
            if self._listened or failure != self._failure:
                self._failure = failure
                self.changed.emit()
        self._listened = listens and self._wanted is not Running.STOPPING


def say_counts(counts: Mapping[str, int]) -> str:
    """Return the number of refusals, as a sentence."""
    if not counts:
        return "Nothing was refused."
    often = sorted(counts.items(), key=lambda pair: -pair[1])
    said = ", ".join(f"{code.replace('_', ' ')} {count}×" for code, count in often)
    return f"Refused since the server's start: {said}."


class RefusalsPanel(QWidget):
    """A line with counts, and a list of limited length.

    Attributes:
        counts: the line.
        list: the last refusals, newest below.
    """

    def __init__(self) -> None:
        super().__init__()
        self._total: int | None = None  # refusals of the present server that are in the list
        self.counts = dressed(ElidedLabel(say_counts({})), "muted")
        self.list = named(QPlainTextEdit(), "Refusals, newest last")
        self.list.setReadOnly(True)
        self.list.setMaximumBlockCount(LONGEST)
        self.list.setLineWrapMode(QPlainTextEdit.LineWrapMode.WidgetWidth)
        self.list.setTabChangesFocus(True)
        self.list.setMinimumHeight(46)
        heading = buddy("Refusals", self.list, kind="heading")
        top = hbox(heading, (self.counts, 1), spacing=16)
        vbox(top, (self.list, 1), of=self, margins=NO_MARGINS, spacing=6)

    def show_server(self, server: ServerStatus | None) -> None:
        """Show a server's report; lines of earlier servers stay in the list."""
        if server is None:
            self._total = None
            return
        total = sum(server.refusals.values())
        fresh, self._total = total - (self._total or 0), total
        clock = QTime.currentTime().toString("HH:mm:ss")
        if fresh > len(server.log):
            more = f"… {fresh - len(server.log)} more, too many to list"
            self.list.appendPlainText(f"{clock}  {more}")
        for said in server.log[-fresh:] if fresh > 0 else ():
            self.list.appendPlainText(f"{clock}  {plain_name(said, LONGEST_TEXT)}")
        said = say_counts(server.refusals)
        if said != self.counts.text():
            self.counts.setText(said)


class ServerScreen(Screen):
    """Starts and stops the server of the present flight.

    Args:
        workspace: services that all screens share.

    Attributes:
        control: starts and stops the server.
        form: configuration of the server.
        connect_panel: how others connect.
        clients: connected clients, and who has control.
        refusals: refused requests.
        start_button: starts the server.
        stop_button: ends it.
        copy_button: copies the address.
        state: the server's state, a word.
        said: the same as a sentence.
    """

    def __init__(self, workspace: Workspace) -> None:
        super().__init__(workspace)
        self.control = ServerControl(workspace.flight, self)
        self.state, self.said = label(), label(wraps=True)
        self.form = ServerForm(workspace.preferences.store)
        self.connect_panel = ConnectPanel()
        self.clients = ClientsPanel(workspace.flight)
        self.refusals = RefusalsPanel()
        self.copy_button = named(
            button("&Copy address", self.connect_panel.copy_address),
            "Copy the address at which others reach the server",
        )
        self.copy_button.hide()
        self.start_button = named(button("&Start", self.start, "primary"), "Start the server")
        self.stop_button = named(
            button("Sto&p", self.control.stop), "Stop the server: all clients are disconnected"
        )
        self.form.entered.connect(self.start)
        self.form.changed.connect(self._show_state)
        self.control.changed.connect(self._show_state)
        self._shown: NetworkView | None = None
        self._lay_out()
        self._show_state()

    def begin(self, view: LiveView) -> None:
        """Note that a flight has begun, which has no server yet."""
        self.show_view(view)

    def show_view(self, view: LiveView) -> None:
        """Show the server's state, and its clients."""
        if view.network is not self._shown:
            self._shown = view.network
            self.clients.show_network(view.network)
            self.refusals.show_server(view.network.server)
            self.connect_panel.show_server(view.network.server, self.control.config)
        self._show_state()

    def start(self) -> None:
        """Start the server if the form is valid."""
        if self.start_button.isEnabled() and self.form.check():
            self.control.start(self.form.config)

    def _show_state(self) -> None:
        """Show the server's state, and enable only buttons that have an effect."""
        running, said = self.control.state
        word = f"{SIGNS.get(running, '○')} {running.value}"
        if word != self.state.text():
            self.state.setText(word)
            set_class(self.state, CLASSES.get(running, "value"))
        if said != self.said.text():
            self.said.setText(said)
        idle = running in (Running.STOPPED, Running.FAILED)
        self.start_button.setEnabled(idle and self.form.is_right)
        self.stop_button.setEnabled(running in (Running.LISTENING, Running.STARTING))
        self.copy_button.setVisible(running is Running.LISTENING)
        self.form.let_write(idle or running is Running.NO_FLIGHT)

    def _lay_out(self) -> None:
        top = dressed(QFrame(), "card")
        explain(top, "Server")
        hbox(
            self.state,
            (self.said, 1),
            self.copy_button,
            self.start_button,
            self.stop_button,
            of=top,
            margins=(16, 8, 16, 8),
            spacing=12,
        )
        around = partial(explained, margins=(16, 10, 16, 10), spacing=6)
        form = around("Where and who", label("Where and who", "heading"), (self.form, 1))
        connect = around("Connect", label("Connect", "heading"), (self.connect_panel, 1))
        page = vbox(
            top,
            Pair(form, connect, (1, 1), 10),
            (around("Clients", (self.clients, 1)), 2),
            (around("Refusals", (self.refusals, 1)), 1),
            margins=(16, 12, 16, 12),
            spacing=10,
        )
        fit_page(self, page)
