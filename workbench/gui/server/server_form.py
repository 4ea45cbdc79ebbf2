"""The form of a server: where it listens, whom it lets in, and what they may do."""

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
from workbench.gui.server.fields import (
    ServerFields,
    file_faults,
    keep_fields,
    read_fields,
    written_faults,
)
from workbench.gui.style import dressed, set_class
from workbench.link.authentication import write_tokens

AFTER_TYPING = 250
"""Files are looked for when no key was pressed for so long [ms]."""


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
