"""Connected clients and who has control, with the operator's actions on them."""

from collections.abc import Callable, Sequence

from PyQt6.QtCore import Qt
from PyQt6.QtGui import QKeySequence
from PyQt6.QtWidgets import QPushButton, QTableWidget, QTableWidgetItem, QWidget

from workbench.common.plain_text import plain_name
from workbench.gui.flight_model import FlightModel
from workbench.gui.labels import WrappedLabel, set_tip
from workbench.gui.layout import (
    NO_MARGINS,
    add_action,
    buddy,
    button,
    fill,
    hbox,
    label,
    named,
    vbox,
)
from workbench.gui.tables import table_heads, text_table, write_cell
from workbench.gui.units import age_text
from workbench.link.authority import NO_HOLDER_YET
from workbench.link.backplane import ClientStatus, Disconnect
from workbench.link.messages import ControlOwner, ControlState, LinkLossStage, Role
from workbench.live.messages import NetworkView
from workbench.live.orders import NetworkOrder

CLIENT_COLUMNS = (
    ("Client", "its own name"),
    ("Address", "its host and port"),
    ("Transport", "tcp, tls, or websocket for a browser"),
    ("Role", "watch, or watch and fly"),
    ("Control", "whether it flies"),
    ("Frames/s", "frames a second that it gets"),
    ("Age", "of the newest data that it has acknowledged"),
    ("Drops", "frames that it was too slow for"),
    ("Refused", "commands and operations that were refused"),
)
FIRST_NUMBER_COLUMN = 5
"""Columns from this index on have numbers, aligned right."""
_ROLE_WORDS = {None: "login", Role.VIEW: "watch", Role.COMMAND: "fly"}
_STAGE_WORDS = {LinkLossStage.LIVE: "flies", LinkLossStage.HOLD: "silent, holds"}

NO_CLIENT_TEXT = "No client is connected."


def client_texts(client: ClientStatus, control: ControlState | None) -> tuple[str, ...]:
    """Return the texts of a client's columns."""
    flies = (
        control is not None and control.hand is ControlOwner.CLIENT and control.peer == client.peer
    )
    does = _STAGE_WORDS.get(control.stage, "lost") if control and flies else "–"
    return (
        client.name or f"client {client.peer}",
        client.address,
        client.transport,
        _ROLE_WORDS[client.role],
        does,
        f"{client.rate:.0f}",
        age_text(client.age),
        str(client.dropped),
        str(client.refused),
    )


def _column_side(column: int) -> Qt.AlignmentFlag:
    sides = Qt.AlignmentFlag
    return sides.AlignRight if column >= FIRST_NUMBER_COLUMN else sides.AlignLeft


class ClientsPanel(QWidget):
    """A table of clients, and three buttons.

    Args:
        flight: the clients' flight.

    Attributes:
        table: the table of clients.
        control: who has control, in words.
        take_over: gives the operator control.
        give_back: allows clients to request control again.
        disconnect_button: disconnects the selected client.
    """

    def __init__(self, flight: FlightModel) -> None:
        super().__init__()
        self._flight = flight
        self.table = QTableWidget(0, len(CLIENT_COLUMNS))
        self._nothing = label(NO_CLIENT_TEXT, "muted")
        self.control = WrappedLabel(lines=2)
        self.take_over = _named_button(
            "Take over",
            "Take over: you fly, and clients wait",
            lambda: flight.do(NetworkOrder.TAKE_OVER),
        )
        self.give_back = _named_button(
            "Give back",
            "Give back: clients may request control",
            lambda: flight.do(NetworkOrder.GIVE_BACK),
        )
        self.disconnect_button = _named_button(
            "Disconnect", "Disconnect the chosen client", self._disconnect
        )
        self._prepare_table()
        top = hbox(buddy("Clients", self.table, kind="heading"), spacing=8)
        top.addSpacing(8)
        fill(top, (self.control, 1), self.take_over, self.give_back, self.disconnect_button)
        vbox(top, (self.table, 1), of=self, margins=NO_MARGINS, spacing=6)
        self.show_network(NetworkView())

    def show_network(self, network: NetworkView) -> None:
        """Show the clients and who has control."""
        peers = network.server.clients if network.server else ()
        chosen = self.chosen
        meant = None if chosen is None else self.peer_at(chosen)
        self._show_clients(peers, network.control)
        chosen = self.chosen
        if chosen is not None and self.peer_at(chosen) != meant:
            self.table.clearSelection()  # Qt selected a neighbour, which the user did not intend
        self.control.setText(client_control_text(network))
        hand = network.control.hand if network.control else ControlOwner.NOBODY
        serves = network.server is not None
        self.take_over.setEnabled(serves and hand is not ControlOwner.OPERATOR)
        self.give_back.setEnabled(serves and hand is ControlOwner.OPERATOR)
        self._show_choice()

    @property
    def chosen(self) -> int | None:
        """Row of the selected client."""
        items = self.table.selectedItems()
        return items[0].row() if items else None

    def peer_at(self, row: int) -> int:
        """Return the number of the client in a row."""
        item = self.table.item(row, 0)
        assert item is not None
        return int(item.data(Qt.ItemDataRole.UserRole))

    def _show_clients(self, clients: Sequence[ClientStatus], control: ControlState | None) -> None:
        """Show the present clients; known ones keep their row, so that the selection stays."""
        table, present = self.table, {client.peer for client in clients}
        for row in reversed(range(table.rowCount())):
            if self.peer_at(row) not in present:
                table.removeRow(row)
        rows = {self.peer_at(row): row for row in range(table.rowCount())}
        for client in clients:
            row = rows.get(client.peer, table.rowCount())
            if row == table.rowCount():
                table.insertRow(row)
            texts = map(plain_name, client_texts(client, control))
            for (column, (name, _)), text in zip(enumerate(CLIENT_COLUMNS), texts, strict=True):
                item = write_cell(table, row, column, text, _column_side(column))
                item.setData(Qt.ItemDataRole.UserRole, client.peer)
                item.setData(Qt.ItemDataRole.AccessibleTextRole, f"{name}: {text}")
                set_tip(item, text)
        self._nothing.setVisible(not clients)

    def _prepare_table(self) -> None:
        table = self.table
        for column, (head, help) in enumerate(CLIENT_COLUMNS):
            heading = QTableWidgetItem(head)
            set_tip(heading, help)
            heading.setTextAlignment(_column_side(column) | Qt.AlignmentFlag.AlignVCenter)
            table.setHorizontalHeaderItem(column, heading)
        vbox((self._nothing, Qt.AlignmentFlag.AlignCenter), of=table.viewport())
        name = "Clients: name, address, role, control, rate, age, drops, refused"
        text_table(table, name, wide=0).setWordWrap(False)
        table.setMinimumHeight(82)
        table_heads(table)[1].setDefaultSectionSize(26)
        table.itemSelectionChanged.connect(self._show_choice)
        leave = add_action(table, "Disconnect", lambda _: self._disconnect())
        leave.setShortcut(QKeySequence(Qt.Key.Key_Delete))
        leave.setShortcutContext(Qt.ShortcutContext.WidgetShortcut)
        table.setContextMenuPolicy(Qt.ContextMenuPolicy.ActionsContextMenu)

    def _show_choice(self) -> None:
        self.disconnect_button.setEnabled(self.chosen is not None)

    def _disconnect(self) -> None:
        if (row := self.chosen) is not None:
            self._flight.do(Disconnect(self.peer_at(row)))


def _named_button(text: str, name: str, pressed: Callable[[], None]) -> QPushButton:
    return named(button(text, pressed), name, f"{name}.")


def client_control_text(network: NetworkView) -> str:
    """Return who has control, as a sentence."""
    control: ControlState | None = network.control
    if network.server is None:
        return ""
    if control is None or control.hand is ControlOwner.NOBODY:
        reason = control.reason if control else NO_HOLDER_YET
        return f"{reason[:1].upper()}{reason[1:]}."
    if control.hand is ControlOwner.OPERATOR:
        return "You have control; clients wait."
    return f"{control.name or f'client {control.peer}'} has control."
