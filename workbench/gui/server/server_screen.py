"""The server screen: let others watch and fly, and see who does."""

from functools import partial

from PyQt6.QtWidgets import (
    QFrame,
)

from workbench.gui.help import help_card, set_card_help
from workbench.gui.instruments.instrument import SIGN_SHAPES, Sign
from workbench.gui.layout import (
    CardPair,
    button,
    fit_page,
    hbox,
    label,
    named,
    vbox,
)
from workbench.gui.screens import Screen
from workbench.gui.server.clients_panel import ClientsPanel
from workbench.gui.server.connect_panel import ConnectPanel
from workbench.gui.server.refusals_panel import RefusalsPanel
from workbench.gui.server.server_control import (
    LISTENING_STATE_SIGNS,
    ListeningState,
    ServerControl,
)
from workbench.gui.server.server_form import ServerForm
from workbench.gui.style import set_class, with_class
from workbench.gui.workspace import Workspace
from workbench.live.messages import NetworkView
from workbench.live.view import LiveView


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
        sign = LISTENING_STATE_SIGNS.get(running, Sign.OFF)
        self.state.setText(f"{SIGN_SHAPES[sign]} {running.value}")
        set_class(self.state, "value" if sign is Sign.OFF else f"value {sign.value}")
        self.said.setText(said)
        idle = running in (ListeningState.STOPPED, ListeningState.FAILED)
        self.start_button.setEnabled(idle and self.form.is_right)
        self.stop_button.setEnabled(running in (ListeningState.LISTENING, ListeningState.STARTING))
        self.copy_button.setVisible(running is ListeningState.LISTENING)
        self.form.let_write(idle or running is ListeningState.NO_FLIGHT)

    def _lay_out(self) -> None:
        top = with_class(QFrame(), "card")
        set_card_help(top, "Server")
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
        around = partial(help_card, margins=(16, 10, 16, 10), spacing=6)
        form = around("Where and who", label("Where and who", "heading"), (self.form, 1))
        connect = around("Connect", label("Connect", "heading"), (self.connect_panel, 1))
        page = vbox(
            top,
            CardPair(form, connect, (1, 1), 10),
            (around("Clients", (self.clients, 1)), 2),
            (around("Refusals", (self.refusals, 1)), 1),
            margins=(16, 12, 16, 12),
            spacing=10,
        )
        fit_page(self, page)
