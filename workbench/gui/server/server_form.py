"""The form of a server: where it listens, whom it lets in, and what they may do."""

from collections.abc import Callable, Mapping
from dataclasses import asdict, dataclass
from pathlib import Path

from PyQt6.QtCore import QSettings, QTimer, pyqtSignal
from PyQt6.QtWidgets import (
    QCheckBox,
    QFileDialog,
    QGridLayout,
    QHBoxLayout,
    QLabel,
    QLineEdit,
    QPushButton,
    QWidget,
)

from workbench.common.errors import WorkbenchError
from workbench.gui.file_dialogs import show_file_dialog
from workbench.gui.style import dressed, set_class
from workbench.gui.typed_number import read_whole_number
from workbench.link.address import DEFAULT_PORT, LOOPBACK
from workbench.link.authentication import write_tokens
from workbench.link.server.config import ServerConfig

GROUP = "server"

AFTER_TYPING = 250
"""Files are looked for when no key was pressed for so long [ms]."""


@dataclass(frozen=True)
class ServerFields:
    """The form as it is written; the names are those of its fields.

    Attributes:
        host: where to listen.
        port: of TCP, as a text.
        token_file: path, "" without login.
        tls_cert: path of the certificate, "" without TLS.
        tls_key: path of its key.
        allow_commands: whether clients may fly.
        web: whether a page for phones is served.
    """

    host: str = LOOPBACK
    port: str = str(DEFAULT_PORT)
    token_file: str = ""
    tls_cert: str = ""
    tls_key: str = ""
    allow_commands: bool = True
    web: bool = False

    def config(self) -> ServerConfig:
        """Return what a server is to do; its `check` says whether it can be had."""
        try:
            port: int | str = read_whole_number(self.port)
        except WorkbenchError:
            port = self.port
        return ServerConfig(
            host=self.host,
            port=port,  # type: ignore[arg-type]
            token_file=self.token_file,
            tls_cert=self.tls_cert,
            tls_key=self.tls_key,
            allow_commands=self.allow_commands,
            web=self.web,
        )


def written_faults(fields: ServerFields) -> Mapping[str, str]:
    """Return what is wrong, by field, without a look at any file."""
    config, faults = fields.config(), {}
    if said := _refusal(ServerConfig(port=config.port).check):
        faults["port"] = said
    if said := _refusal(ServerConfig(host=config.host).check):
        # A host that is none is said before all else; what is left is that others can reach it.
        first = _refusal(ServerConfig(host=config.host, clients=0).check)
        if said == first:
            faults["host"] = said
        elif not config.token_file:
            faults["token_file"] = said
    return faults


def file_faults(fields: ServerFields) -> Mapping[str, str]:
    """Return what is wrong with files that are named, by field; they are small, and read here."""
    config, faults = fields.config(), {}
    if said := _no_plain_file(config.token_file) or _refusal(config.tokens):
        faults["token_file"] = said
    if said := _no_plain_file(config.tls_cert):
        faults["tls_cert"] = said
    elif said := _no_plain_file(config.tls_key) or _refusal(config.tls):
        faults["tls_key"] = said
    return faults


def read_fields(store: QSettings) -> ServerFields:
    """Return the fields as they were kept, or the defaults."""
    found: dict[str, str | bool] = {}
    for name, default in asdict(ServerFields()).items():
        kept = str(store.value(f"{GROUP}/{name}", default))
        found[name] = kept.lower() == "true" if isinstance(default, bool) else kept
    return ServerFields(**found)  # type: ignore[arg-type]


def keep_fields(store: QSettings, fields: ServerFields) -> None:
    """Keep the fields for the next start; of tokens and keys only the paths."""
    for name, value in asdict(fields).items():
        store.setValue(f"{GROUP}/{name}", value)


def _no_plain_file(path: str) -> str:
    """Return why a path cannot be read without waiting, as for a pipe; "" if it can."""
    if not path:
        return ""
    try:
        odd = Path(path).exists() and not Path(path).is_file()
    except (OSError, ValueError):  # whoever opens it says what is wrong with it
        return ""
    return f"{path}: is no plain file: choose another" if odd else ""


def _refusal(check: Callable[[], object]) -> str:
    try:
        check()
    except WorkbenchError as error:
        return str(error)
    return ""


class ServerForm(QWidget):
    """Fields that say beside themselves what is wrong with them, and are kept.

    Args:
        store: where they are kept.
        parent: the Qt parent; this object is deleted with it.

    Attributes:
        lines: fields of text, by name.
        allow_commands: whether clients may fly.
        web: whether a page for phones is served.
    """

    changed = pyqtSignal()
    """What is written, or whether it is right, is another."""
    entered = pyqtSignal()
    """Return was pressed in a field."""

    def __init__(self, store: QSettings, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self._store = store
        self.lines: dict[str, QLineEdit] = {}
        self._faults: dict[str, QLabel] = {}
        self._buttons: list[QPushButton] = []
        self._grid = QGridLayout(self)
        self._grid.setContentsMargins(0, 0, 0, 0)
        self._grid.setHorizontalSpacing(8)
        self._grid.setVerticalSpacing(4)
        self._grid.setColumnStretch(1, 1)
        kept = read_fields(store)
        self._add("host", "&Host", "127.0.0.1 for this machine only, 0.0.0.0 for all networks")
        self._add("port", "P&ort", "TCP port, 0 to 65535; 0 takes a free one")
        self._add("token_file", "&Tokens", "file of two tokens, to watch and to fly")
        self._add("tls_cert", "T&LS certificate", "PEM file; empty without TLS")
        self._add("tls_key", "TLS &key", "PEM file of its private key")
        for name in ("token_file", "tls_cert", "tls_key"):
            self.lines[name].setPlaceholderText("none")
        self._add_buttons()
        self.allow_commands = QCheckBox("&Allow commands", self)
        self.allow_commands.setToolTip("Without it, everybody can only watch.")
        self.allow_commands.setAccessibleName("Allow commands: clients may fly")
        self.web = QCheckBox("Pa&ge for phones", self)
        self.web.setToolTip("Serve a web page that shows the flight, and flies it, on a phone.")
        self.web.setAccessibleName("Serve a page for phones and browsers")
        ticks = QHBoxLayout()
        ticks.setSpacing(16)
        ticks.addWidget(self.allow_commands)
        ticks.addWidget(self.web)
        ticks.addStretch(1)
        self._grid.addLayout(ticks, self._grid.rowCount(), 1, 1, 2)
        self._grid.setRowStretch(self._grid.rowCount(), 1)
        self._timer = QTimer(self)
        self._timer.setSingleShot(True)
        self._timer.setInterval(AFTER_TYPING)
        self._timer.timeout.connect(self._look_at_files)
        self._show(kept)
        for line in self.lines.values():
            line.textChanged.connect(self._written)
            line.returnPressed.connect(self.entered)
        self.allow_commands.toggled.connect(self._written)
        self.web.toggled.connect(self._written)
        self._look_at_files()

    @property
    def fields(self) -> ServerFields:
        """What is written."""
        texts = {name: line.text().strip() for name, line in self.lines.items()}
        return ServerFields(
            **texts,
            allow_commands=self.allow_commands.isChecked(),
            web=self.web.isChecked(),
        )

    @property
    def is_right(self) -> bool:
        """Whether nothing is known to be wrong."""
        return not any(label.text() for label in self._faults.values())

    def fault(self, name: str) -> str:
        """Return what stands beside a field, "" if nothing does."""
        return self._faults[name].text()

    def check(self) -> bool:
        """Look at everything now, files too, and return whether all is right."""
        self._look_at_files()
        return self.is_right

    def let_write(self, may: bool) -> None:
        """Let the fields be changed or not: a server that runs keeps what it was started with."""
        for line in self.lines.values():
            line.setReadOnly(not may)
        for button in self._buttons:
            button.setEnabled(may)
        self.allow_commands.setEnabled(may)
        self.web.setEnabled(may)

    def make_tokens(self, path: str) -> None:
        """Write a new file of tokens and name it; only its owner can read it."""
        try:
            write_tokens(Path(path))
        except WorkbenchError as error:
            self._say("token_file", str(error))
            self.changed.emit()
        else:
            self.lines["token_file"].setText(path)
            self._look_at_files()

    def _add(self, name: str, label: str, help: str) -> None:
        """Add a line with its label before it, and what is wrong with it below."""
        row = self._grid.rowCount()
        line = QLineEdit(self)
        line.setToolTip(help[:1].upper() + help[1:] + ".")
        line.setAccessibleName(f"{label.replace('&', '')}: {help}")
        before = QLabel(label, self)
        before.setBuddy(line)
        fault = dressed(QLabel(self), "bad")
        fault.setWordWrap(True)
        fault.hide()
        self.lines[name], self._faults[name] = line, fault
        self._grid.addWidget(before, row, 0)
        self._grid.addWidget(line, row, 1, 1, 1 if name not in ("host", "port") else 2)
        self._grid.addWidget(fault, row + 1, 1, 1, 2)

    def _add_buttons(self) -> None:
        for name, what in (
            ("token_file", "file of tokens"),
            ("tls_cert", "certificate"),
            ("tls_key", "key"),
        ):
            buttons = QHBoxLayout()
            buttons.setSpacing(4)
            choose = self._button("Choose…", f"Choose a {what}")
            choose.clicked.connect(lambda _, name=name, what=what: self._choose(name, what))
            buttons.addWidget(choose)
            before: QWidget = self.lines[name]
            if name == "token_file":
                new = self._button("New…", "Make a new file of tokens")
                new.clicked.connect(self._choose_new)
                buttons.addWidget(new)
                self.setTabOrder(choose, new)
            self.setTabOrder(before, choose)
            place = self._grid.getItemPosition(self._grid.indexOf(before))
            self._grid.addLayout(buttons, place[0] or 0, 2)

    def _button(self, text: str, name: str) -> QPushButton:
        button = dressed(QPushButton(text, self), "compact")
        button.setAccessibleName(name)
        self._buttons.append(button)
        return button

    def _choose(self, name: str, what: str) -> None:
        dialog = QFileDialog(self, f"Choose a {what}", self.lines[name].text())
        dialog.setFileMode(QFileDialog.FileMode.ExistingFile)
        show_file_dialog(dialog, self.lines[name].setText)

    def _choose_new(self) -> None:
        dialog = QFileDialog(self, "Make a file of tokens", "link.tokens")
        dialog.setAcceptMode(QFileDialog.AcceptMode.AcceptSave)
        dialog.setOption(QFileDialog.Option.DontConfirmOverwrite)  # none is overwritten
        dialog.selectFile("link.tokens")
        show_file_dialog(dialog, self.make_tokens)

    def _show(self, fields: ServerFields) -> None:
        for name, line in self.lines.items():
            line.setText(getattr(fields, name))
            line.setCursorPosition(0)
        self.allow_commands.setChecked(fields.allow_commands)
        self.web.setChecked(fields.web)

    def _written(self) -> None:
        """Say at once what is wrong with what is written, and look at files a little later."""
        fields = self.fields
        keep_fields(self._store, fields)
        faults = written_faults(fields)
        for name in ("host", "port", "token_file"):
            self._say(name, faults.get(name, ""))
        self._timer.start()
        self.changed.emit()

    def _look_at_files(self) -> None:
        self._timer.stop()
        fields = self.fields
        faults = {**file_faults(fields), **written_faults(fields)}
        for name in self.lines:
            self._say(name, faults.get(name, ""))
        self.changed.emit()

    def _say(self, name: str, fault: str) -> None:
        self._faults[name].setText(f"✕ {fault}" if fault else "")
        self._faults[name].setVisible(bool(fault))
        set_class(self.lines[name], "bad" if fault else "")
