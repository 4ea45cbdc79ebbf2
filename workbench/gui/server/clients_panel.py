"""Who is connected and who flies, with what the operator can do about it."""

from PyQt6.QtCore import Qt
from PyQt6.QtGui import QAction, QKeySequence
from PyQt6.QtWidgets import (
    QAbstractItemView,
    QHBoxLayout,
    QHeaderView,
    QLabel,
    QPushButton,
    QVBoxLayout,
    QWidget,
)

from workbench.gui.elided_label import ElidedLabel
from workbench.gui.flight_model import FlightModel
from workbench.gui.server.clients_model import COLUMNS, ClientsModel
from workbench.gui.server.clients_table import ClientsTable
from workbench.gui.style import dressed
from workbench.link.authority import NOBODY_YET
from workbench.link.server_messages import ControlState, Hand
from workbench.live.messages import NetworkView


class ClientsPanel(QWidget):
    """A table of clients, and three buttons.

    Args:
        flight: that they watch.
        parent: the Qt parent; this object is deleted with it.

    Attributes:
        model: its rows.
        table: shows them.
        control: who flies, in words.
        take_over: lets the operator fly.
        give_back: lets clients ask for control again.
        disconnect_button: sends the chosen client away.
    """

    def __init__(self, flight: FlightModel, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self._flight = flight
        self.model = ClientsModel(self)
        self.table = ClientsTable(self)
        self.control = ElidedLabel(self)
        self.take_over = self._button("Take over", "Take over: you fly, and clients wait")
        self.give_back = self._button("Give back", "Give back: clients may ask for control")
        self.disconnect_button = self._button("Disconnect", "Disconnect the chosen client")
        self._prepare_table()
        self.take_over.clicked.connect(lambda: flight.order(lambda live: live.take_over()))
        self.give_back.clicked.connect(lambda: flight.order(lambda live: live.give_back()))
        self.disconnect_button.clicked.connect(self._disconnect)
        heading = dressed(QLabel("Clients", self), "heading")
        heading.setBuddy(self.table)
        top = QHBoxLayout()
        top.setSpacing(8)
        top.addWidget(heading)
        top.addSpacing(8)
        top.addWidget(self.control, 1)
        for button in (self.take_over, self.give_back, self.disconnect_button):
            top.addWidget(button)
        layout = QVBoxLayout(self)
        layout.setContentsMargins(0, 0, 0, 0)
        layout.setSpacing(6)
        layout.addLayout(top)
        layout.addWidget(self.table, 1)
        self.show_network(NetworkView())

    def show_network(self, network: NetworkView) -> None:
        """Show who is here and who flies."""
        peers = network.server.clients if network.server else ()
        chosen = self.chosen
        meant = None if chosen is None else self.model.peer_at(chosen)
        self.model.show_clients(peers, network.control)
        chosen = self.chosen
        if chosen is not None and self.model.peer_at(chosen) != meant:
            self._choose_nobody()  # Qt chose a neighbour, whom nobody means to send away
        said = say_control(network)
        if self.control.text() != said:
            self.control.setText(said)
        hand = network.control.hand if network.control else Hand.NOBODY
        serves = network.server is not None
        self.take_over.setEnabled(serves and hand is not Hand.OPERATOR)
        self.give_back.setEnabled(serves and hand is Hand.OPERATOR)
        self._show_choice()

    @property
    def chosen(self) -> int | None:
        """Row of the client that is chosen."""
        selection = self.table.selectionModel()
        rows = selection.selectedRows() if selection else []
        return rows[0].row() if rows else None

    def _prepare_table(self) -> None:
        table = self.table
        table.setModel(self.model)
        table.setAccessibleName("Clients: name, address, role, control, rate, age, drops, refused")
        table.setSelectionBehavior(QAbstractItemView.SelectionBehavior.SelectRows)
        table.setSelectionMode(QAbstractItemView.SelectionMode.SingleSelection)
        table.setTabKeyNavigation(False)
        table.setShowGrid(False)
        table.setWordWrap(False)
        table.setMinimumHeight(82)
        down, across = table.verticalHeader(), table.horizontalHeader()
        selection = table.selectionModel()
        assert down is not None
        assert across is not None
        assert selection is not None
        down.hide()
        down.setDefaultSectionSize(26)
        across.setHighlightSections(False)
        across.setSectionResizeMode(QHeaderView.ResizeMode.ResizeToContents)
        across.setSectionResizeMode(0, QHeaderView.ResizeMode.Stretch)
        assert len(COLUMNS) == across.count()
        selection.selectionChanged.connect(self._show_choice)
        leave = QAction("Disconnect", table)
        leave.setShortcut(QKeySequence(Qt.Key.Key_Delete))
        leave.setShortcutContext(Qt.ShortcutContext.WidgetShortcut)
        leave.triggered.connect(self._disconnect)
        table.addAction(leave)
        table.setContextMenuPolicy(Qt.ContextMenuPolicy.ActionsContextMenu)

    def _show_choice(self) -> None:
        row = self.chosen
        self.disconnect_button.setEnabled(row is not None)

    def _choose_nobody(self) -> None:
        selection = self.table.selectionModel()
        if selection is not None:
            selection.clear()

    def _disconnect(self) -> None:
        row = self.chosen
        if row is not None:
            peer = self.model.peer_at(row)
            self._flight.order(lambda live: live.disconnect(peer))

    def _button(self, text: str, name: str) -> QPushButton:
        button = QPushButton(text, self)
        button.setAccessibleName(name)
        button.setToolTip(f"{name}.")
        return button


def say_control(network: NetworkView) -> str:
    """Return who flies, as a sentence."""
    control: ControlState | None = network.control
    if network.server is None:
        return ""
    if control is None or control.hand is Hand.NOBODY:
        reason = control.reason if control else NOBODY_YET
        return f"{reason[:1].upper()}{reason[1:]}."
    if control.hand is Hand.OPERATOR:
        return "You have control; clients wait."
    return f"{control.name or f'client {control.peer}'} has control."
