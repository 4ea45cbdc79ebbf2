"""The list of all signals: for searching, dragging onto charts, or selecting by Enter."""

import re
from collections.abc import Iterable

from PyQt6.QtCore import QMimeData, QModelIndex, QPoint, QSortFilterProxyModel, Qt, pyqtSignal
from PyQt6.QtGui import QKeyEvent, QStandardItem, QStandardItemModel
from PyQt6.QtWidgets import QHeaderView, QLineEdit, QMenu, QTreeView, QWidget

from workbench.common.plain_text import plain_name, plain_text
from workbench.gui.labels import set_tip
from workbench.gui.layout import NO_MARGINS, add_action, buddy, label, named, vbox
from workbench.gui.visualization.derived_signals import OWN_TOPIC
from workbench.gui.visualization.signal_catalog import Catalog, signal_label, topic_title

SIGNAL_MIME_TYPE = "application/x-workbench-signal"
"""MIME type of dragged data: names of signals, one per line."""
SIGNAL_NAME_ROLE, SEARCHED_TEXT_ROLE = (
    Qt.ItemDataRole.UserRole.value + number for number in (1, 2)
)
SIGNAL_INDENT_PX = 14
MAX_LINE_CHARACTERS = 26
"""Longest line of a signal with its name in the log of another program, so that none is elided."""
_BREAKABLE_PART = re.compile(r"[^_.,]*[_.,]?")


class SignalModel(QStandardItemModel):
    """Topics, each with its signals and their units."""

    def mimeTypes(self) -> list[str]:
        """Return the type of dragged data."""
        return [SIGNAL_MIME_TYPE]

    def mimeData(self, indexes: Iterable[QModelIndex]) -> QMimeData:
        """Return the names of signals."""
        names = [
            str(index.data(SIGNAL_NAME_ROLE)) for index in indexes if index.data(SIGNAL_NAME_ROLE)
        ]
        data = QMimeData()
        data.setData(SIGNAL_MIME_TYPE, "\n".join(dict.fromkeys(names)).encode())
        return data

    def show_groups(self, groups: Catalog) -> None:
        """Show groups of signals."""
        self.clear()
        self.setHorizontalHeaderLabels(["Signal", "Unit"])
        for topic, signals in groups.items():
            top = QStandardItem(topic_title(topic))
            set_tip(top, topic)
            top.setFlags(Qt.ItemFlag.ItemIsEnabled | Qt.ItemFlag.ItemIsSelectable)
            empty = QStandardItem("")
            empty.setFlags(Qt.ItemFlag.ItemIsEnabled)
            for name, unit, help, source in signals:
                own, label = plain_name(name.partition(".")[2]), signal_label(name)
                text = label if label == own else f"{label} ({own})"
                if source:
                    text = _with_source(label, plain_name(source))
                row = [QStandardItem(text)]
                row.append(QStandardItem(plain_name(unit)))
                tip = f"{name} [{unit or '1'}], {label}" + (f": {help}" if help else "")
                tip += f", in the log {source}" if source else ""
                for item in row:
                    item.setData(name, SIGNAL_NAME_ROLE)
                    item.setData(plain_text(tip), SEARCHED_TEXT_ROLE)
                    set_tip(item, tip)
                    item.setEditable(False)
                    item.setDropEnabled(False)
                row[0].setAccessibleText(f"{plain_name(name)}, unit {plain_name(unit) or 'none'}")
                top.appendRow(row)
            self.appendRow([top, empty])


class SignalView(QTreeView):
    """The tree; Enter and double click take all selected signals."""

    chosen = pyqtSignal(list)
    """Names of the selected signals."""

    def keyPressEvent(self, event: QKeyEvent | None) -> None:
        """Select by Enter."""
        if event is not None and event.key() in (Qt.Key.Key_Return, Qt.Key.Key_Enter):
            self.choose(self.currentIndex())
        elif event is not None and event.text().isprintable() and event.text():
            event.ignore()  # single keys are for the charts, and the field above finds signals
        else:
            super().keyPressEvent(event)

    def choose(self, index: QModelIndex) -> None:
        """Take the signal at an index and all others that are selected; a topic opens or closes."""
        if index.data(SIGNAL_NAME_ROLE):
            self.chosen.emit(self.selected_names(index))
        elif index.isValid():
            self.setExpanded(index, not self.isExpanded(index))

    def selected_names(self, index: QModelIndex) -> list[str]:
        """Return the names of the selected signals, or of that at an index that is not selected."""
        rows = sorted(self.selectedIndexes(), key=lambda each: (each.parent().row(), each.row()))
        names = [str(each.data(SIGNAL_NAME_ROLE)) for each in rows if each.data(SIGNAL_NAME_ROLE)]
        own = str(index.data(SIGNAL_NAME_ROLE))
        return list(dict.fromkeys(names)) if own in names else [own]


class SignalTree(QWidget):
    """Search field and tree."""

    chosen = pyqtSignal(list)
    """Names of signals to add to the selected chart."""
    chosen_apart = pyqtSignal(list)
    """Names of signals that should get their own chart."""
    edit_wanted = pyqtSignal(str)
    """Name of one of the user's derived signals that should be changed."""
    removal_wanted = pyqtSignal(str)
    """Name of one that should be removed."""

    def __init__(self) -> None:
        super().__init__()
        self._groups: Catalog = {}
        self._model = SignalModel(self)
        self._proxy = QSortFilterProxyModel(self)
        self._proxy.setSourceModel(self._model)
        self._proxy.setRecursiveFilteringEnabled(True)
        self._proxy.setAutoAcceptChildRows(True)
        self._proxy.setFilterCaseSensitivity(Qt.CaseSensitivity.CaseInsensitive)
        self.search = named(QLineEdit(), "Find signal")
        self.search.setPlaceholderText("velocity, thrust, m/s …")
        self.search.setClearButtonEnabled(True)
        self.view = named(SignalView(), "Signals: Enter adds those selected to the chart in use")
        self.view.setModel(self._proxy)
        self.view.setDragEnabled(True)
        self.view.setUniformRowHeights(True)
        self.view.setSelectionMode(QTreeView.SelectionMode.ExtendedSelection)
        self.view.setExpandsOnDoubleClick(False)
        self.view.setIndentation(SIGNAL_INDENT_PX)
        self.view.setContextMenuPolicy(Qt.ContextMenuPolicy.CustomContextMenu)
        self.target = label(kind="muted", wraps=True)
        name = buddy("Find s&ignal", self.search, kind="")
        parts = (name, self.search, (self.view, 1), self.target)
        vbox(*parts, of=self, margins=NO_MARGINS, spacing=6)
        self.search.textChanged.connect(self._filter)
        self.search.returnPressed.connect(self._choose_first)
        self.view.chosen.connect(self.chosen)
        self.view.doubleClicked.connect(self.view.choose)
        self.view.customContextMenuRequested.connect(self._open_menu)

    def show_groups(self, groups: Catalog) -> None:
        """Show signals; does nothing if they are unchanged."""
        if groups == self._groups:
            return
        self._groups = groups
        wraps = any(source for signals in groups.values() for *_, source in signals)
        self.view.setUniformRowHeights(not wraps)
        self._model.show_groups(groups)
        head = self.view.header()
        if head is not None:
            head.setStretchLastSection(False)
            head.setMinimumSectionSize(40)
            head.setSectionResizeMode(0, QHeaderView.ResizeMode.Stretch)
            head.setSectionResizeMode(1, QHeaderView.ResizeMode.ResizeToContents)
        self._filter(self.search.text())

    def set_target(self, title: str) -> None:
        """Show the chart to which signals are added."""
        shown = plain_name(title)
        self.target.setText(
            f"Enter, or a double click, adds the selection to “{shown}”. Or drag it onto a chart."
        )

    def names(self) -> list[str]:
        """Return the names that match the search."""
        found = []
        for row in range(self._proxy.rowCount()):
            top = self._proxy.index(row, 0)
            for below in range(self._proxy.rowCount(top)):
                found.append(str(self._proxy.index(below, 0, top).data(SIGNAL_NAME_ROLE)))
        return found

    def _filter(self, text: str) -> None:
        """Show signals with all words, in any order, in their name, topic or unit."""
        self._proxy.setFilterRole(SEARCHED_TEXT_ROLE)
        words = "".join(f"(?=.*{_escaped(word)})" for word in text.split())
        self._proxy.setFilterRegularExpression(f"(?i)^{words}" if words else "")
        if text:
            self.view.expandAll()
        else:
            self.view.collapseAll()

    def _choose_first(self) -> None:
        found = self.names()
        if found:
            self.chosen.emit(found[:1])

    def _open_menu(self, place: QPoint) -> None:
        index = self.view.currentIndex()
        if not index.data(SIGNAL_NAME_ROLE):
            return
        name, names = str(index.data(SIGNAL_NAME_ROLE)), self.view.selected_names(index)
        menu = QMenu(self)
        menu.aboutToHide.connect(menu.deleteLater)
        add_action(menu, "Add to the chart in use", lambda _: self.chosen.emit(names))
        add_action(menu, "Show in a new chart", lambda _: self.chosen_apart.emit(names))
        if name.startswith(f"{OWN_TOPIC}."):
            add_action(menu, "Edit…", lambda _: self.edit_wanted.emit(name))
            add_action(menu, "Remove", lambda _: self.removal_wanted.emit(name))
        port = self.view.viewport()
        if port is not None:
            menu.popup(port.mapToGlobal(place))


def _with_source(label: str, source: str) -> str:
    """Return the label of a signal and its name in its log, in lines that are short enough."""
    if len(label) + len(source) + 3 <= MAX_LINE_CHARACTERS:
        return f"{label} ({source})"
    lines = [""]
    for part in _BREAKABLE_PART.findall(source):
        if len(lines[-1]) + len(part) > MAX_LINE_CHARACTERS:
            lines.append("")
        lines[-1] += part
    return "\n".join((label, *lines))


def _escaped(word: str) -> str:
    return "".join(each if each.isalnum() or each == "_" else f"\\{each}" for each in word)
