"""The server screen: let others watch and fly, and see who does."""

from PyQt6.QtWidgets import (
    QFrame,
    QGridLayout,
    QHBoxLayout,
    QLabel,
    QPushButton,
    QVBoxLayout,
    QWidget,
)

from workbench.gui.page import fit_page
from workbench.gui.screen import Screen
from workbench.gui.server.clients_panel import ClientsPanel
from workbench.gui.server.connect_panel import ConnectPanel
from workbench.gui.server.refusals_panel import RefusalsPanel
from workbench.gui.server.server_control import ServerControl
from workbench.gui.server.server_form import ServerForm
from workbench.gui.server.server_state import Running
from workbench.gui.style import dressed, set_class
from workbench.gui.workspace import Workspace
from workbench.live.messages import NetworkView
from workbench.live.view import LiveView

CLASSES = {Running.LISTENING: "value good", Running.FAILED: "value bad"}
SIGNS = {Running.LISTENING: "●", Running.FAILED: "✕"}


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
