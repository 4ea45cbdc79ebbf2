"""Tables of texts: their look, their headings, and their cells."""

from typing import TypeVar

from PyQt6.QtCore import Qt
from PyQt6.QtWidgets import (
    QAbstractItemView,
    QHeaderView,
    QTableView,
    QTableWidget,
    QTableWidgetItem,
)

Table = TypeVar("Table", bound=QTableView)


def text_table(table: Table, name: str, wide: int | None = None) -> Table:
    """Return a table of texts: its rows are chosen one at a time, and none is edited.

    Args:
        table: the table.
        name: its name for screen readers.
        wide: index of the column that fills the width, None for none.
    """
    table.setAccessibleName(name)
    table.setEditTriggers(QAbstractItemView.EditTrigger.NoEditTriggers)
    table.setSelectionBehavior(QAbstractItemView.SelectionBehavior.SelectRows)
    table.setSelectionMode(QAbstractItemView.SelectionMode.SingleSelection)
    table.setTabKeyNavigation(False)
    table.setShowGrid(False)
    heads, sides = table_heads(table)
    sides.hide()
    heads.setHighlightSections(False)
    heads.setDefaultAlignment(Qt.AlignmentFlag.AlignLeft | Qt.AlignmentFlag.AlignVCenter)
    heads.setSectionResizeMode(QHeaderView.ResizeMode.ResizeToContents)
    if wide is not None:
        heads.setSectionResizeMode(wide, QHeaderView.ResizeMode.Stretch)
    return table


def write_cell(
    table: QTableWidget,
    row: int,
    column: int,
    text: str,
    side: Qt.AlignmentFlag = Qt.AlignmentFlag.AlignLeft,
) -> QTableWidgetItem:
    """Write a text into a cell, without a signal if it is there already; return its item.

    Args:
        table: the table.
        row: index of the row.
        column: index of the column.
        text: the text.
        side: side of the cell at which it stands.
    """
    item = table.item(row, column)
    if item is None:
        item = QTableWidgetItem()
        item.setTextAlignment(side | Qt.AlignmentFlag.AlignVCenter)
        table.setItem(row, column, item)
    item.setText(text)
    return item


def table_heads(table: QTableView) -> tuple[QHeaderView, QHeaderView]:
    """Return the headings of the columns and of the rows."""
    heads, sides = table.horizontalHeader(), table.verticalHeader()
    assert heads is not None and sides is not None
    return heads, sides
