"""Who is connected, as a table that changes in place: a selection outlives its updates."""

import math
from collections.abc import Sequence
from dataclasses import dataclass

from PyQt6.QtCore import QAbstractTableModel, QModelIndex, QObject, Qt

from workbench.link.backplane import ClientStatus
from workbench.link.operations import Role
from workbench.link.server_messages import ControlState, Hand, Stage

COLUMNS = (
    ("Client", "what it calls itself"),
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
"""Columns from here on are numbers, to the right."""
_MAY = {None: "login", Role.VIEW: "watch", Role.COMMAND: "fly"}
_DOES = {Stage.LIVE: "flies", Stage.HOLD: "silent, holds"}
_EVERYWHERE = QModelIndex()


@dataclass(frozen=True)
class ClientRow:
    """A client as it is shown.

    Attributes:
        peer: its number.
        texts: one a column.
    """

    peer: int
    texts: tuple[str, ...]


def client_row(peer: ClientStatus, control: ControlState | None) -> ClientRow:
    """Return a client as it is shown."""
    flies = control is not None and control.hand is Hand.CLIENT and control.peer == peer.peer
    does = _DOES.get(control.stage, "lost") if control and flies else "–"
    age = f"{1e3 * peer.age:.0f}\N{NO-BREAK SPACE}ms" if peer.age < 10.0 else _long(peer.age)
    return ClientRow(
        peer.peer,
        (
            peer.name or f"client {peer.peer}",
            peer.address,
            peer.transport,
            _MAY[peer.role],
            does,
            f"{peer.rate:.0f}",
            age,
            str(peer.dropped),
            str(peer.refused),
        ),
    )


class ClientsModel(QAbstractTableModel):
    """Rows of clients.

    Args:
        parent: the Qt parent; this object is deleted with it.
    """

    def __init__(self, parent: QObject | None = None) -> None:
        super().__init__(parent)
        self._rows: list[ClientRow] = []

    def show_clients(self, peers: Sequence[ClientStatus], control: ControlState | None) -> None:
        """Show who is here now; who stays keeps its row."""
        present = {peer.peer for peer in peers}
        for index in reversed(range(len(self._rows))):
            if self._rows[index].peer not in present:
                self.beginRemoveRows(_EVERYWHERE, index, index)
                del self._rows[index]
                self.endRemoveRows()
        places = {row.peer: index for index, row in enumerate(self._rows)}
        for peer in peers:
            row = client_row(peer, control)
            if peer.peer in places:
                self._update(places[peer.peer], row)
            else:
                last = len(self._rows)
                self.beginInsertRows(_EVERYWHERE, last, last)
                self._rows.append(row)
                self.endInsertRows()

    def peer_at(self, row: int) -> int:
        """Return the number of the client in a row."""
        return self._rows[row].peer

    def name_at(self, row: int) -> str:
        """Return what the client in a row calls itself."""
        return self._rows[row].texts[0]

    def rowCount(self, parent: QModelIndex = _EVERYWHERE) -> int:
        """Return how many clients there are."""
        return 0 if parent.isValid() else len(self._rows)

    def columnCount(self, parent: QModelIndex = _EVERYWHERE) -> int:
        """Return how many columns there are."""
        return 0 if parent.isValid() else len(COLUMNS)

    def data(self, index: QModelIndex, role: int = Qt.ItemDataRole.DisplayRole) -> object:
        """Return a cell's text and where it stands."""
        if not index.isValid():
            return None
        if role in (Qt.ItemDataRole.DisplayRole, Qt.ItemDataRole.ToolTipRole):
            return self._rows[index.row()].texts[index.column()]
        if role == Qt.ItemDataRole.AccessibleTextRole:
            return f"{COLUMNS[index.column()][0]}: {self._rows[index.row()].texts[index.column()]}"
        if role == Qt.ItemDataRole.TextAlignmentRole:
            return _side(index.column())
        return None

    def headerData(
        self,
        section: int,
        orientation: Qt.Orientation,
        role: int = Qt.ItemDataRole.DisplayRole,
    ) -> object:
        """Return a column's heading."""
        if orientation is not Qt.Orientation.Horizontal or not 0 <= section < len(COLUMNS):
            return None
        if role == Qt.ItemDataRole.DisplayRole:
            return COLUMNS[section][0]
        if role == Qt.ItemDataRole.ToolTipRole:
            return COLUMNS[section][1]
        return _side(section) if role == Qt.ItemDataRole.TextAlignmentRole else None

    def _update(self, index: int, row: ClientRow) -> None:
        before, self._rows[index] = self._rows[index], row
        for column, (old, new) in enumerate(zip(before.texts, row.texts, strict=True)):
            if old != new:
                cell = self.index(index, column)
                self.dataChanged.emit(cell, cell)


def _side(column: int) -> Qt.AlignmentFlag:
    across = Qt.AlignmentFlag.AlignRight if column >= FIRST_NUMBER else Qt.AlignmentFlag.AlignLeft
    return across | Qt.AlignmentFlag.AlignVCenter


def _long(age: float) -> str:
    """Return an age that is no good sign [s]."""
    return f"{age:.0f}\N{NO-BREAK SPACE}s" if math.isfinite(age) and age < 1e4 else "–"
