"""The form of the server's configuration, with errors beside the fields."""

from collections.abc import Callable, Mapping
from functools import partial
from pathlib import Path
from typing import Any

from PyQt6.QtCore import QSettings, Qt, pyqtSignal
from PyQt6.QtWidgets import QCheckBox, QFormLayout, QHBoxLayout, QLineEdit, QPushButton, QWidget

from workbench.common.errors import WorkbenchError
from workbench.gui.errands import single_shot
from workbench.gui.file_dialogs import open_file, save_file
from workbench.gui.labels import Label, set_tip
from workbench.gui.layout import NO_MARGINS, buddy, button, hbox, label, named, vbox
from workbench.gui.number_field import read_whole_number
from workbench.gui.style import set_class
from workbench.link.authentication import write_tokens
from workbench.link.server.config import ServerConfig

SERVER_FORM_FIELDS = ("host", "port", "token_file", "tls_cert", "tls_key", "allow_commands", "web")
"""Parts of a configuration in the form."""
SERVER_LINES = (
    ("host", "H&ost", "127.0.0.1 for this machine only, 0.0.0.0 for all networks", ""),
    ("port", "Po&rt", "TCP port, 0 to 65535; 0 takes a free one", ""),
    ("token_file", "&Tokens", "file of two tokens, to watch and to fly", "file of tokens"),
    (
        "tls_cert",
        "TLS cert&ificate",
        "PEM file; other machines are served over TLS alone",
        "certificate",
    ),
    ("tls_key", "TLS &key", "PEM file of its private key", "key"),
)
"""Lines of the form: name, label, help, and what a dialog chooses, "" for a line without one."""
SERVER_SETTINGS_GROUP = "server"
FORM_LABEL_PADDING_PX = 2
"""Space after a label, whose last letter a form would cut [px]."""
FILE_CHECK_DELAY_MS = 250
"""Delay after the last key before files are checked [ms]."""


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
        if said != first and not (config.tls_cert or config.tls_key):
            # Refused before the file is looked at.
            faults["tls_cert"] = _refusal(ServerConfig(config.host, token_file="x").check)
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
    for name in SERVER_FORM_FIELDS:
        default = getattr(ServerConfig, name)
        kept = str(store.value(f"{SERVER_SETTINGS_GROUP}/{name}", default))
        found[name] = kept.lower() == "true" if isinstance(default, bool) else kept
    return ServerConfig(**found | {"port": read_port(str(found["port"]))})


def save_config(store: QSettings, config: ServerConfig) -> None:
    """Store the form for the next start; of tokens and keys only the paths."""
    for name in SERVER_FORM_FIELDS:
        store.setValue(f"{SERVER_SETTINGS_GROUP}/{name}", getattr(config, name))


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
        self._form = QFormLayout(self)
        self._form.setContentsMargins(*NO_MARGINS)
        self._form.setVerticalSpacing(4)
        self._form.setFieldGrowthPolicy(QFormLayout.FieldGrowthPolicy.ExpandingFieldsGrow)
        for name, text, help, what in SERVER_LINES:
            self._add(name, text, help, what)
        self.allow_commands = QCheckBox("&Allow commands", self)
        set_tip(self.allow_commands, "Without it, everybody can only watch.")
        self.allow_commands.setAccessibleName("Allow commands: clients may fly")
        self.web = QCheckBox("Pa&ge for phones", self)
        set_tip(self.web, "Serve a web page that shows the flight, and flies it, on a phone.")
        self.web.setAccessibleName("Serve a page for phones and browsers")
        ticks = hbox(self.allow_commands, self.web, 1, spacing=16)
        self._form.addRow(label(), ticks)
        self._timer = single_shot(self._look_at_files, self, FILE_CHECK_DELAY_MS)
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

    def _add(self, name: str, text: str, help: str, what: str) -> None:
        """Add a line with a label before it, its error below, and buttons if it names a file."""
        tip = help[:1].upper() + help[1:] + "."
        line = named(QLineEdit(), f"{text.replace('&', '')}: {help}", tip)
        fault = label(kind="bad", wraps=True)
        fault.setTextInteractionFlags(Qt.TextInteractionFlag.TextSelectableByMouse)  # to be copied
        fault.hide()
        self.lines[name], self._faults[name] = line, fault
        row = hbox((line, 1), spacing=4)
        if what:
            line.setPlaceholderText("none")
            choose = partial(self._choose, name, what)
            self._add_button(row, "Choose…", f"Choose a {what}", choose)
        if name == "token_file":
            self._add_button(row, "New…", f"Make a new {what}", self._choose_new)
        name_of_line = buddy(text, line, kind="")
        name_of_line.setContentsMargins(0, 0, FORM_LABEL_PADDING_PX, 0)
        self._form.addRow(name_of_line, vbox(row, fault, spacing=4))

    def _add_button(
        self, row: QHBoxLayout, text: str, name: str, pressed: Callable[[], None]
    ) -> None:
        self._buttons.append(named(button(text, pressed, "compact"), name))
        row.addWidget(self._buttons[-1])

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
        save_config(self._store, config)
        faults = written_faults(config)
        for name in ("host", "port", "token_file", "tls_cert"):
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
