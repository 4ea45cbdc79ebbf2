"""The list of all signals: for searching, dragging onto charts, or selecting by Enter."""

from collections.abc import Iterable

from PyQt6.QtCore import QMimeData, QModelIndex, QPoint, QSortFilterProxyModel, Qt, pyqtSignal
from PyQt6.QtGui import QKeyEvent, QStandardItem, QStandardItemModel
from PyQt6.QtWidgets import QHeaderView, QLineEdit, QMenu, QTreeView, QWidget

from workbench.common.plain_text import plain_name, plain_text
from workbench.gui.labels import set_tip
from workbench.gui.layout import NO_MARGINS, buddy, label, named, vbox
from workbench.gui.visualization.derived_signals import OWN_TOPIC
from workbench.gui.visualization.signal_catalog import Catalog, signal_label, topic_title

MIME = "application/x-workbench-signal"
"""MIME type of dragged data: names of signals, one per line."""
NAME, SEARCHED = (Qt.ItemDataRole.UserRole.value + number for number in (1, 2))


class SignalModel(QStandardItemModel):
    """Topics, each with its signals and their units."""

    def mimeTypes(self) -> list[str]:
        """Return the type of dragged data."""
        return [MIME]

    def mimeData(self, indexes: Iterable[QModelIndex]) -> QMimeData:
        """Return the names of signals."""
        names = [str(index.data(NAME)) for index in indexes if index.data(NAME)]
        data = QMimeData()
        data.setData(MIME, "\n".join(dict.fromkeys(names)).encode())
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
            for name, unit, help in signals:
                own, label = plain_name(name.partition(".")[2]), signal_label(name)
                row = [QStandardItem(label if label == own else f"{label} ({own})")]
                row.append(QStandardItem(plain_name(unit)))
                tip = f"{name} [{unit or '1'}], {label}" + (f": {help}" if help else "")
                for item in row:
                    item.setData(name, NAME)
                    item.setData(plain_text(tip), SEARCHED)
                    set_tip(item, tip)
                    item.setEditable(False)
                    item.setDropEnabled(False)
                row[0].setAccessibleText(f"{plain_name(name)}, unit {plain_name(unit) or 'none'}")
                top.appendRow(row)
            self.appendRow([top, empty])


class SignalView(QTreeView):
    """The tree; Enter and double click select a signal."""

    chosen = pyqtSignal(str)
    """Name of a selected signal."""

    def keyPressEvent(self, event: QKeyEvent | None) -> None:
        """Select by Enter."""
        if event is not None and event.key() in (Qt.Key.Key_Return, Qt.Key.Key_Enter):
            self.choose(self.currentIndex())
        else:
            super().keyPressEvent(event)

    def choose(self, index: QModelIndex) -> None:
        """Select the signal at an index; a topic is opened or closed."""
        name = index.data(NAME)
        if name:
            self.chosen.emit(str(name))
        elif index.isValid():
            self.setExpanded(index, not self.isExpanded(index))


class SignalTree(QWidget):
    """Search field and tree."""

    chosen = pyqtSignal(str)
    """Name of a signal to add to the selected chart."""
    chosen_apart = pyqtSignal(str)
    """Name of a signal that should get its own chart."""
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
        self.view = named(SignalView(), "Signals: Enter adds one to the chart in use")
        self.view.setModel(self._proxy)
        self.view.setDragEnabled(True)
        self.view.setUniformRowHeights(True)
        self.view.setSelectionMode(QTreeView.SelectionMode.ExtendedSelection)
        self.view.setExpandsOnDoubleClick(False)
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
        self.target.setText(f"Enter, or a double click, adds to “{shown}”. Or drag onto a chart.")

    def names(self) -> list[str]:
        """Return the names that match the search."""
        found = []
        for row in range(self._proxy.rowCount()):
            top = self._proxy.index(row, 0)
            for below in range(self._proxy.rowCount(top)):
                found.append(str(self._proxy.index(below, 0, top).data(NAME)))
        return found

    def _filter(self, text: str) -> None:
        """Show signals with all words, in any order, in their name, topic or unit."""
        self._proxy.setFilterRole(SEARCHED)
        words = "".join(f"(?=.*{_escaped(word)})" for word in text.split())
        self._proxy.setFilterRegularExpression(f"(?i)^{words}" if words else "")
        if text:
            self.view.expandAll()
        else:
            self.view.collapseAll()

    def _choose_first(self) -> None:
        found = self.names()
        if found:
            self.chosen.emit(found[0])

    def _open_menu(self, place: QPoint) -> None:
        index = self.view.currentIndex()
        if not index.data(NAME):
            return
        name = str(index.data(NAME))
        menu = QMenu(self)
        menu.aboutToHide.connect(menu.deleteLater)
        add, apart = (
            menu.addAction("Add to the chart in use"),
            menu.addAction("Show in a new chart"),
        )
        if add is not None and apart is not None:
            add.triggered.connect(lambda: self.chosen.emit(name))
            apart.triggered.connect(lambda: self.chosen_apart.emit(name))
        if name.startswith(f"{OWN_TOPIC}."):
            for text, wanted in (("Edit…", self.edit_wanted), ("Remove", self.removal_wanted)):
                action = menu.addAction(text)
                if action is not None:
                    action.triggered.connect(lambda _, wanted=wanted: wanted.emit(name))
        port = self.view.viewport()
        if port is not None:
            menu.popup(port.mapToGlobal(place))


def _escaped(word: str) -> str:
    return "".join(each if each.isalnum() or each == "_" else f"\\{each}" for each in word)
