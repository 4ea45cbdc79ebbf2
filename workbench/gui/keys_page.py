"""The page of all keys, where each can be changed."""

from collections.abc import Sequence
from typing import Any

from PyQt6.QtCore import (
    QEvent,
    QModelIndex,
    QSignalBlocker,
    QSortFilterProxyModel,
    Qt,
)
from PyQt6.QtGui import QFocusEvent, QKeyEvent, QKeySequence, QStandardItem, QStandardItemModel
from PyQt6.QtWidgets import (
    QAbstractItemView,
    QDialog,
    QHeaderView,
    QKeySequenceEdit,
    QLineEdit,
    QStyledItemDelegate,
    QStyleOptionViewItem,
    QTableView,
    QWidget,
)

from workbench.common.errors import WorkbenchError
from workbench.gui.charts.chart_command import pressed_key
from workbench.gui.key_map import KeyMap, sequence_of
from workbench.gui.key_table import KEY_GROUPS
from workbench.gui.layout import button, hbox, label, named, vbox
from workbench.gui.tables import table_heads, text_table

KEYS_PAGE_SIZE_PX = (660, 560)
PAGE_MARGIN_PX = 40
"""Space between the page and the edge of its window [px]."""
KEY_COLUMNS = ("Group", "What it does", "Key")
KEY_COLUMN = 2
FIXED_KEYS = (
    ("Tuning", "Move the slider; with Shift in large steps, with Ctrl in small ones.", "Arrows"),
    ("Tuning", "Drag a slider ten times finer.", "Shift"),
    ("Tuning", "Let a card fill its column, or not; as a double click on its name.", "Shift+F11"),
    ("Tuning", "Give a card a window of its own, or bring it back.", "Ctrl+F11"),
    ("Tuning", "Fly the proposed gains, if gains fly on Enter.", "Enter"),
    ("Tuning", "Discard proposed gains that do not fly.", "Esc"),
    ("Charts", "Zoom the time; with Shift the values.", "Ctrl+Wheel"),
    ("Charts", "Move the crosshair.", "Left, Right"),
    ("Charts", "Move the time.", "PgUp, PgDown"),
    ("Charts", "Zoom the time.", "+, -"),
    ("Charts", "Undo zooming.", "Esc, Home"),
    ("Charts", "Copy the data.", "Ctrl+C"),
    ("Charts", "Remove the last signal; with Shift the chart.", "Del"),
)
"""Keys that cannot be changed: group, what they do, and key."""


class KeyField(QKeySequenceEdit):
    """Takes the next pressed key; that of STOP stops the rotors here, too, and Del means none.

    Args:
        stop: key of STOP.
        parent: the Qt parent.
    """

    def __init__(self, stop: QKeySequence, parent: QWidget | None) -> None:
        super().__init__(parent)
        self._stop = stop.toString()
        self.setMaximumSequenceLength(1)
        self.setClearButtonEnabled(True)

    def event(self, event: QEvent | None) -> bool:
        """Leave the key of STOP to the app."""
        if (
            isinstance(event, QKeyEvent)
            and event.type() is QEvent.Type.ShortcutOverride
            and pressed_key(event) == self._stop
        ):
            event.ignore()
            return False
        return super().event(event)

    def keyPressEvent(self, event: QKeyEvent | None) -> None:
        """Take a key, or clear it."""
        if event is not None and event.key() in (Qt.Key.Key_Delete, Qt.Key.Key_Backspace):
            self.clear()
            self.editingFinished.emit()
        else:
            super().keyPressEvent(event)

    def focusOutEvent(self, event: QFocusEvent | None) -> None:
        """Finish without a signal: the view takes the key then."""
        with QSignalBlocker(self):
            super().focusOutEvent(event)


class KeyDelegate(QStyledItemDelegate):
    """Edits a key by pressing it.

    Args:
        keys: keys of all actions.
        parent: the Qt parent.
    """

    def __init__(self, keys: KeyMap, parent: QWidget) -> None:
        super().__init__(parent)
        self._keys = keys

    def createEditor(
        self, parent: QWidget | None, option: QStyleOptionViewItem, index: QModelIndex
    ) -> QWidget:
        """Return the field."""
        field = named(KeyField(self._keys.sequence("stop"), parent), "Press a key")
        field.editingFinished.connect(lambda: self._finish(field))
        return field

    def setEditorData(self, editor: QWidget | None, index: QModelIndex) -> None:
        """Show the present key."""
        if isinstance(editor, KeyField):
            editor.setKeySequence(sequence_of(str(index.data(Qt.ItemDataRole.EditRole))))

    def setModelData(self, editor: QWidget | None, model: Any, index: QModelIndex) -> None:
        """Take the pressed key."""
        if isinstance(editor, KeyField):
            text = editor.keySequence().toString(QKeySequence.SequenceFormat.PortableText)
            model.setData(index, text)

    def _finish(self, field: KeyField) -> None:
        self.commitData.emit(field)
        self.closeEditor.emit(field)


class KeysPage(QDialog):
    """All keys, which can be searched and changed.

    Args:
        keys: keys of all actions.
        parent: the Qt parent.

    Attributes:
        table: the keys.
        fault: why the last key was refused.
    """

    def __init__(self, keys: KeyMap, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self.setWindowTitle("Keys")
        self.setAttribute(Qt.WidgetAttribute.WA_DeleteOnClose)
        self._keys = keys
        self._items: dict[str, QStandardItem] = {}
        self._model = QStandardItemModel(self)
        self._model.setHorizontalHeaderLabels(KEY_COLUMNS)
        rows = [(group, row) for group, rows in KEY_GROUPS for row in rows]
        rows.sort(key=lambda row: not row[1].shortcut)  # those without a key come last
        for group, row in rows:
            self._items[row.name] = self._add((group, row.help, keys.key(row.name)), row.name)
        for fixed in FIXED_KEYS:
            self._add(fixed)
        self._model.itemChanged.connect(self._take_key)
        keys.changed.connect(self._show_key)
        matching = QSortFilterProxyModel(self)
        matching.setSourceModel(self._model)
        matching.setFilterKeyColumn(-1)
        matching.setFilterCaseSensitivity(Qt.CaseSensitivity.CaseInsensitive)
        search = named(QLineEdit(), "Search keys")
        search.setPlaceholderText("Search: take off, Ctrl+K, charts …")
        search.setClearButtonEnabled(True)
        search.textChanged.connect(matching.setFilterFixedString)
        self.table = QTableView()
        self.table.setModel(matching)
        text_table(self.table, "Keys: a double click or F2 changes one", wide=1)
        triggers = QAbstractItemView.EditTrigger
        self.table.setEditTriggers(triggers.DoubleClicked | triggers.EditKeyPressed)
        sides = table_heads(self.table)[1]
        sides.setSectionResizeMode(QHeaderView.ResizeMode.ResizeToContents)
        self.table.setItemDelegateForColumn(KEY_COLUMN, KeyDelegate(keys, self))
        help = "Double-click a key, and press another one. Del clears it."
        self._hint = label(help, "muted", wraps=True)
        self.fault = label(kind="bad", wraps=True)
        self.fault.hide()
        defaults = button("&Default keys", keys.reset, help="Give all actions their first keys")
        below = hbox((vbox(self._hint, self.fault), 1), defaults, button("&Close", self.close))
        vbox(search, (self.table, 1), below, of=self, margins=(16, 14, 16, 12), spacing=8)
        above = parent.window() if parent is not None else None
        width, height = KEYS_PAGE_SIZE_PX
        self.resize(width, min(height, above.height() - PAGE_MARGIN_PX) if above else height)

    def _add(self, texts: Sequence[str], name: str = "") -> QStandardItem:
        """Add a row, and return the item of its key; it can be changed if it has a name."""
        items = [QStandardItem(text) for text in texts]
        for item in items:
            item.setEditable(False)
        items[KEY_COLUMN].setEditable(bool(name))
        items[KEY_COLUMN].setData(name)
        self._model.appendRow(items)
        return items[KEY_COLUMN]

    def _take_key(self, item: QStandardItem) -> None:
        """Take an edited key; a refused one becomes what it was, and is explained."""
        name, fault = str(item.data()), ""
        try:
            self._keys.set_key(name, item.text())
        except WorkbenchError as error:
            item.setText(self._keys.key(name))  # calls this again
            fault = str(error)
        self.fault.setText(fault)
        self.fault.setVisible(bool(fault))
        self._hint.setVisible(not fault)

    def _show_key(self, name: str) -> None:
        self._items[name].setText(self._keys.key(name))
