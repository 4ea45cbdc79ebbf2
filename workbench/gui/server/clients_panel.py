"""Connected clients and who has control, with the operator's actions on them."""

import math
from collections.abc import Callable, Sequence

from PyQt6.QtCore import Qt
from PyQt6.QtGui import QAction, QKeySequence, QPainter, QPaintEvent
from PyQt6.QtWidgets import (
    QAbstractItemView,
    QHeaderView,
    QPushButton,
    QTableWidget,
    QTableWidgetItem,
    QWidget,
)

from workbench.common.plain_text import plain_name
from workbench.gui.flight_model import FlightModel
from workbench.gui.labels import ElidedLabel, set_tip
from workbench.gui.layout import NO_MARGINS, buddy, button, fill, hbox, named, vbox
from workbench.link.authority import NOBODY_YET
from workbench.link.backplane import ClientStatus
from workbench.link.messages import ControlState, Hand, Role, Stage
from workbench.live.messages import NetworkView

COLUMNS = (
    ("Client", "its own name"),
    ("Address", "its host and port"),
    ("By", "tcp, tls, or websocket for a browser"),
    ("May", "watch, or watch and fly"),
    ("Control", "whether it flies"),
    ("Frames/s", "frames a second that it gets"),
    ("Age", "of the newest data that it has acknowledged"),
    ("Drops", "frames that it was too slow for"),
    ("Refused", "commands and operations that were refused"),
)
FIRST_NUMBER = 5
"""Columns from this index on have numbers, aligned right."""
_MAY = {None: "login", Role.VIEW: "watch", Role.COMMAND: "fly"}
_DOES = {Stage.LIVE: "flies", Stage.HOLD: "silent, holds"}

NOBODY = "No client is connected."


class ClientsTable(QTableWidget):
    """Rows of clients, updated in place so that the selection stays."""

    def __init__(self) -> None:
        super().__init__(0, len(COLUMNS))
        for column, (name, help) in enumerate(COLUMNS):
            heading = QTableWidgetItem(name)
            set_tip(heading, help)
            heading.setTextAlignment(_side(column))
            self.setHorizontalHeaderItem(column, heading)

    def show_clients(self, clients: Sequence[ClientStatus], control: ControlState | None) -> None:
        """Show the present clients; known ones keep their row."""
        present = {client.peer for client in clients}
        for row in reversed(range(self.rowCount())):
            if self.peer_at(row) not in present:
                self.removeRow(row)
        rows = {self.peer_at(row): row for row in range(self.rowCount())}
        for client in clients:
            texts = client_texts(client, control)
            if client.peer in rows:
                self._update(rows[client.peer], texts)
            else:
                self._append(client.peer, texts)

    def peer_at(self, row: int) -> int:
        """Return the number of the client in a row."""
        item = self.item(row, 0)
        assert item is not None
        return int(item.data(Qt.ItemDataRole.UserRole))

    def paintEvent(self, event: QPaintEvent | None) -> None:
        """Paint the rows, or the hint that there are none."""
        super().paintEvent(event)
        port = self.viewport()
        if port is None or self.rowCount() > 0:
            return
        painter = QPainter(port)
        painter.setPen(self.palette().placeholderText().color())
        painter.drawText(port.rect(), Qt.AlignmentFlag.AlignCenter, NOBODY)

    def _append(self, peer: int, texts: Sequence[str]) -> None:
        row = self.rowCount()
        self.insertRow(row)
        for column in range(len(COLUMNS)):
            item = QTableWidgetItem()
            item.setFlags(Qt.ItemFlag.ItemIsEnabled | Qt.ItemFlag.ItemIsSelectable)
            item.setTextAlignment(_side(column))
            item.setData(Qt.ItemDataRole.UserRole, peer)
            self.setItem(row, column, item)
        self._update(row, texts)

    def _update(self, row: int, texts: Sequence[str]) -> None:
        for column, text in enumerate(map(plain_name, texts)):
            item = self.item(row, column)
            if item is not None and item.text() != text:
                item.setText(text)
                set_tip(item, text)
                spoken = f"{COLUMNS[column][0]}: {text}"
                item.setData(Qt.ItemDataRole.AccessibleTextRole, spoken)


def client_texts(client: ClientStatus, control: ControlState | None) -> tuple[str, ...]:
    """Return the texts of a client's columns."""
    flies = control is not None and control.hand is Hand.CLIENT and control.peer == client.peer
    does = _DOES.get(control.stage, "lost") if control and flies else "–"
    age = f"{1e3 * client.age:.0f}\N{NO-BREAK SPACE}ms" if client.age < 10.0 else _long(client.age)
    return (
        client.name or f"client {client.peer}",
        client.address,
        client.transport,
        _MAY[client.role],
        does,
        f"{client.rate:.0f}",
        age,
        str(client.dropped),
        str(client.refused),
    )


def _side(column: int) -> Qt.AlignmentFlag:
    across = Qt.AlignmentFlag.AlignRight if column >= FIRST_NUMBER else Qt.AlignmentFlag.AlignLeft
    return across | Qt.AlignmentFlag.AlignVCenter


def _long(age: float) -> str:
    """Return an age that indicates a problem [s]."""
    return f"{age:.0f}\N{NO-BREAK SPACE}s" if math.isfinite(age) and age < 1e4 else "–"


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
        self.table = ClientsTable()
        self.control = ElidedLabel()
        self.take_over = _button(
            "Take over",
            "Take over: you fly, and clients wait",
            lambda: flight.order(lambda live: live.take_over()),
        )
        self.give_back = _button(
            "Give back",
            "Give back: clients may request control",
            lambda: flight.order(lambda live: live.give_back()),
        )
        self.disconnect_button = _button(
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
        meant = None if chosen is None else self.table.peer_at(chosen)
        self.table.show_clients(peers, network.control)
        chosen = self.chosen
        if chosen is not None and self.table.peer_at(chosen) != meant:
            self._clear_choice()  # Qt selected a neighbour, which the user did not intend
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
        """Row of the selected client."""
        selection = self.table.selectionModel()
        rows = selection.selectedRows() if selection else []
        return rows[0].row() if rows else None

    def _prepare_table(self) -> None:
        table = self.table
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

    def _clear_choice(self) -> None:
        selection = self.table.selectionModel()
        if selection is not None:
            selection.clear()

    def _disconnect(self) -> None:
        row = self.chosen
        if row is not None:
            peer = self.table.peer_at(row)
            self._flight.order(lambda live: live.disconnect(peer))


def _button(text: str, name: str, pressed: Callable[[], None]) -> QPushButton:
    return named(button(text, pressed), name, f"{name}.")


def say_control(network: NetworkView) -> str:
    """Return who has control, as a sentence."""
    control: ControlState | None = network.control
    if network.server is None:
        return ""
    if control is None or control.hand is Hand.NOBODY:
        reason = control.reason if control else NOBODY_YET
        return f"{reason[:1].upper()}{reason[1:]}."
    if control.hand is Hand.OPERATOR:
        return "You have control; clients wait."
    return f"{control.name or f'client {control.peer}'} has control."
