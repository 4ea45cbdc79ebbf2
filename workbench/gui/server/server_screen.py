"""The server screen: let others watch and fly, and see who does."""

from collections import deque
from collections.abc import Mapping, Sequence

from PyQt6.QtCore import QTime
from PyQt6.QtWidgets import (
    QFrame,
    QGridLayout,
    QHBoxLayout,
    QLabel,
    QPlainTextEdit,
    QPushButton,
    QVBoxLayout,
    QWidget,
)

from workbench.gui.elided_label import ElidedLabel
from workbench.gui.page import fit_page
from workbench.gui.screen import Screen
from workbench.gui.server.clients_panel import ClientsPanel
from workbench.gui.server.connect_panel import ConnectPanel
from workbench.gui.server.server_control import Running, ServerControl
from workbench.gui.server.server_form import ServerForm
from workbench.gui.style import dressed, set_class
from workbench.gui.workspace import Workspace
from workbench.link.backplane import ServerStatus
from workbench.live.messages import NetworkView
from workbench.live.view import LiveView

LONGEST = 300
"""Lines that are kept."""

CLASSES = {Running.LISTENING: "value good", Running.FAILED: "value bad"}
SIGNS = {Running.LISTENING: "●", Running.FAILED: "✕"}


class RefusalLog:
    """The last refusals in words, with the time at which they were heard of.

    Attributes:
        lines: oldest first.
    """

    def __init__(self) -> None:
        self.lines: deque[str] = deque(maxlen=LONGEST)
        self._total = 0

    def begin(self) -> None:
        """Take what a new server tells as new."""
        self._total = 0

    def hear(self, told: Sequence[str], counts: Mapping[str, int], clock: str) -> list[str]:
        """Take what a server tells, and return the lines that are new.

        Args:
            told: its last refusals, newest last.
            counts: how often something was refused since its start, by code.
            clock: the time of the day, as text.
        """
        total = sum(counts.values())
        fresh = total - self._total
        self._total = total
        if fresh <= 0:
            return []
        new = [f"{clock}  {said}" for said in told[-fresh:]]
        if fresh > len(told):
            new.insert(0, f"{clock}  … {fresh - len(told)} more, too many to be told")
        self.lines.extend(new)
        return new


def say_counts(counts: Mapping[str, int]) -> str:
    """Return how often something was refused, as a sentence."""
    if not counts:
        return "Nothing was refused."
    often = sorted(counts.items(), key=lambda pair: -pair[1])
    said = ", ".join(f"{code.replace('_', ' ')} {count}×" for code, count in often)
    return f"Refused since the server's start: {said}."


class RefusalsPanel(QWidget):
    """A line that counts, and a list that does not grow without bound.

    Attributes:
        counts: the line.
        list: the last refusals, newest below.
    """

    def __init__(self, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self._log = RefusalLog()
        self._served = False
        heading = dressed(QLabel("Refusals", self), "heading")
        self.counts = ElidedLabel(say_counts({}), self)
        self.counts.setProperty("class", "muted")
        self.list = QPlainTextEdit(self)
        self.list.setReadOnly(True)
        self.list.setMaximumBlockCount(LONGEST)
        self.list.setLineWrapMode(QPlainTextEdit.LineWrapMode.WidgetWidth)
        self.list.setTabChangesFocus(True)
        self.list.setAccessibleName("What was refused, newest last")
        self.list.setMinimumHeight(46)
        heading.setBuddy(self.list)
        layout = QVBoxLayout(self)
        layout.setContentsMargins(0, 0, 0, 0)
        layout.setSpacing(6)
        top = QHBoxLayout()
        top.setSpacing(16)
        top.addWidget(heading)
        top.addWidget(self.counts, 1)
        layout.addLayout(top)
        layout.addWidget(self.list, 1)

    def show_server(self, server: ServerStatus | None) -> None:
        """Show what a server tells; what earlier ones told stays in the list."""
        if server is None:
            self._served = False
            return
        if not self._served:
            self._served = True
            self._log.begin()
        clock = QTime.currentTime().toString("HH:mm:ss")
        for line in self._log.hear(server.log, server.refusals, clock):
            self.list.appendPlainText(line)
        said = say_counts(server.refusals)
        if said != self.counts.text():
            self.counts.setText(said)


class ServerScreen(Screen):
    """Start and stop the server of whatever flies.

    Args:
        workspace: what all screens share.
        parent: the Qt parent; this object is deleted with it.

    Attributes:
        control: starts and stops.
        form: where to listen, and whom to let in.
        connect_panel: how others connect.
        clients: who is there, and who flies.
        refusals: what was refused.
        start_button: starts the server.
        stop_button: ends it.
        copy_button: copies the address.
        state: whether it runs, a word.
        said: the same as a sentence.
    """

    title = "Server"
    icon = "server"

    def __init__(self, workspace: Workspace, parent: QWidget | None = None) -> None:
        super().__init__(workspace, parent)
        self.control = ServerControl(workspace.flight, self)
        self.state, self.said = QLabel(self), QLabel(self)
        self.said.setWordWrap(True)
        self.copy_button = QPushButton("&Copy address", self)
        self.copy_button.setAccessibleName("Copy the address where others reach the server")
        self.copy_button.hide()
        self.start_button = QPushButton("&Start", self)
        self.start_button.setAccessibleName("Start the server")
        self.start_button.setProperty("class", "primary")
        self.stop_button = QPushButton("Sto&p", self)
        self.stop_button.setAccessibleName("Stop the server: all clients are sent away")
        self.form = ServerForm(workspace.preferences.store, self)
        self.connect_panel = ConnectPanel(self)
        self.clients = ClientsPanel(workspace.flight, self)
        self.refusals = RefusalsPanel(self)
        self.copy_button.clicked.connect(self.connect_panel.copy_address)
        self.start_button.clicked.connect(self.start)
        self.stop_button.clicked.connect(self.control.stop)
        self.form.entered.connect(self.start)
        self.form.changed.connect(self._show_state)
        self.control.changed.connect(self._show_state)
        self._shown: NetworkView | None = None
        self._lay_out()
        self._show_state()

    def begin(self, view: LiveView) -> None:
        """Take note that a flight has begun, which has no server yet."""
        self.show_view(view)

    def show_view(self, view: LiveView) -> None:
        """Show how the server does, and who is there."""
        if view.network is not self._shown:
            self._shown = view.network
            self.clients.show_network(view.network)
            self.refusals.show_server(view.network.server)
            self.connect_panel.show_server(view.network.server, self.control.config)
        self._show_state()

    def start(self) -> None:
        """Start the server, if what is written is right."""
        if self.start_button.isEnabled() and self.form.check():
            self.control.start(self.form.fields.config())

    def _show_state(self) -> None:
        """Show whether it runs, and let only that be pressed that has an effect."""
        state = self.control.state
        word = f"{SIGNS.get(state.running, '○')} {state.running.value}"
        if word != self.state.text():
            self.state.setText(word)
            set_class(self.state, CLASSES.get(state.running, "value"))
        if state.said != self.said.text():
            self.said.setText(state.said)
        idle = state.running in (Running.STOPPED, Running.FAILED)
        self.start_button.setEnabled(idle and self.form.is_right)
        self.stop_button.setEnabled(state.running in (Running.LISTENING, Running.STARTING))
        self.copy_button.setVisible(state.running is Running.LISTENING)
        self.form.let_write(idle or state.running is Running.NO_FLIGHT)

    def _lay_out(self) -> None:
        top = dressed(QFrame(self), "card")
        bar = QHBoxLayout(top)
        bar.setContentsMargins(16, 8, 16, 8)
        bar.setSpacing(12)
        bar.addWidget(self.state)
        bar.addWidget(self.said, 1)
        bar.addWidget(self.copy_button)
        bar.addWidget(self.start_button)
        bar.addWidget(self.stop_button)
        grid = QGridLayout()
        grid.setContentsMargins(16, 12, 16, 12)
        grid.setSpacing(10)
        grid.addWidget(top, 0, 0, 1, 2)
        grid.addWidget(self._titled("Where and who", self.form), 1, 0)
        grid.addWidget(self._titled("Connect", self.connect_panel), 1, 1)
        grid.addWidget(_around(self.clients, self), 2, 0, 1, 2)
        grid.addWidget(_around(self.refusals, self), 3, 0, 1, 2)
        grid.setColumnStretch(0, 1)
        grid.setColumnStretch(1, 1)
        grid.setRowStretch(2, 2)
        grid.setRowStretch(3, 1)
        fit_page(self, grid)

    def _titled(self, text: str, widget: QWidget) -> QFrame:
        """Return a card with a heading."""
        frame = _around(widget, self)
        heading = dressed(QLabel(text, frame), "heading")
        layout = frame.layout()
        assert isinstance(layout, QVBoxLayout)
        layout.insertWidget(0, heading)
        return frame


def _around(widget: QWidget, parent: QWidget) -> QFrame:
    """Return a card with a widget in it."""
    frame = dressed(QFrame(parent), "card")
    layout = QVBoxLayout(frame)
    layout.setContentsMargins(16, 10, 16, 10)
    layout.setSpacing(6)
    layout.addWidget(widget, 1)
    return frame
