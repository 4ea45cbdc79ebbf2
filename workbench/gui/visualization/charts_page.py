"""The page of charts: a list of signals beside a board of charts, and a line of choices above."""

from PyQt6.QtCore import QSettings, Qt
from PyQt6.QtGui import QResizeEvent
from PyQt6.QtWidgets import (
    QComboBox,
    QHBoxLayout,
    QLabel,
    QPushButton,
    QSplitter,
    QVBoxLayout,
    QWidget,
)

from workbench.gui.page import scrolled
from workbench.gui.visualization.board_layout import (
    DEFAULT,
    PRESETS,
    ChartSpec,
    board_text,
    read_board,
)
from workbench.gui.visualization.chart_board import ChartBoard
from workbench.gui.visualization.derived_signals import SeriesSource, WithDerived
from workbench.gui.visualization.signal_catalog import make_catalog
from workbench.gui.visualization.signal_tree import SignalTree
from workbench.gui.workspace import Workspace
from workbench.link.topics import Topic

KEPT = "visualization/charts"
"""Where the charts are kept between starts."""
OWN = "Own"
WIDE = 980
"""From here on there is room for the list of signals beside the charts [pixels]."""


class ChartsPage(QWidget):
    """Charts of the flight, or of a log.

    Args:
        workspace: signals, preferences and colours.
        parent: the Qt parent; this object is deleted with it.
    """

    def __init__(self, workspace: Workspace, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self._store: QSettings = workspace.preferences.store
        self._source: SeriesSource = WithDerived(workspace.signals)
        self._live = self._source
        self._topics: tuple[Topic, ...] = ()
        self._tree_chosen: bool | None = None
        self.board = ChartBoard(workspace, self._source)
        self.tree = SignalTree()
        self.presets = QComboBox()
        self.presets.addItems([*PRESETS, OWN])
        self.presets.setAccessibleName("Layout of the charts")
        self.signals_shown = QPushButton("&Signals")
        self.signals_shown.setCheckable(True)
        self.signals_shown.setToolTip("Show the list of all signals")
        self.add = QPushButton("Add &chart")
        self.pause = QPushButton("Pause &all")
        self.pause.setCheckable(True)
        self.pause.setToolTip("Let all pictures stand still; the flight goes on")
        self.line = QHBoxLayout()
        self._lay_out()
        self.tree.chosen.connect(self.board.add_signal)
        self.tree.chosen_apart.connect(lambda name: self.board.add_chart(ChartSpec(name, (name,))))
        self.board.changed.connect(self._keep)
        self.board.used.connect(self.tree.set_target)
        self.presets.activated.connect(lambda _: self._show_preset(self.presets.currentText()))
        self.signals_shown.clicked.connect(self._choose_tree)
        self.add.clicked.connect(lambda: self.board.add_chart())
        self.pause.clicked.connect(self.board.set_paused)
        kept = read_board(str(self._store.value(KEPT, "")))
        self.board.show_board(kept or PRESETS[DEFAULT], self._source)
        self._name_preset()

    def begin(self, topics: tuple[Topic, ...]) -> None:
        """Show the signals of a flight that begins."""
        self._topics = topics
        if self._source is self._live:
            self._show_catalog()
            self.board.show_source(self._source)
            self.pause.setChecked(False)

    def show_source(self, source: SeriesSource | None) -> None:
        """Show the series of a log, None for those of the flight."""
        if source is None:
            self._source = self._live
            self.board.write_times_ago()
        else:
            self._source = WithDerived(source)
            self.board.write_clock_times()
        self.pause.setChecked(False)
        self._show_catalog()
        self.board.show_source(self._source)

    def refresh(self, now: float) -> None:
        """Draw until a time [s]."""
        self.board.refresh(now)

    def resizeEvent(self, event: QResizeEvent | None) -> None:
        """Show the list of signals where there is room for it."""
        self._show_tree()

    def _show_catalog(self) -> None:
        self.tree.show_groups(make_catalog(self._source.units, self._topics))

    def _choose_tree(self, shown: bool) -> None:
        self._tree_chosen = shown
        self._show_tree()
        if shown:
            self.tree.search.setFocus()

    def _show_tree(self) -> None:
        shown = self.width() >= WIDE if self._tree_chosen is None else self._tree_chosen
        self.tree.setVisible(shown)
        self.signals_shown.setChecked(shown)

    def _show_preset(self, name: str) -> None:
        if name in PRESETS:
            self.board.show_board(PRESETS[name], self._source)
            self.pause.setChecked(False)
            self._store.setValue(KEPT, board_text(self.board.board))

    def _keep(self) -> None:
        self._store.setValue(KEPT, board_text(self.board.board))
        self._name_preset()

    def _name_preset(self) -> None:
        """Show which preset the charts are, if any."""
        board = self.board.board
        name = next((each for each, preset in PRESETS.items() if preset == board), OWN)
        self.presets.setCurrentText(name)

    def _lay_out(self) -> None:
        label = QLabel("La&yout")
        label.setBuddy(self.presets)
        self.line.setSpacing(8)
        for widget in (self.signals_shown, label, self.presets, self.add, self.pause):
            self.line.addWidget(widget)
        self.line.addStretch(1)
        split = QSplitter(Qt.Orientation.Horizontal)
        split.setChildrenCollapsible(False)
        split.addWidget(self.tree)
        split.addWidget(scrolled(self.board))
        split.setStretchFactor(1, 1)
        split.setSizes([250, 900])
        self.tree.setMinimumWidth(200)
        box = QVBoxLayout(self)
        box.setContentsMargins(0, 8, 0, 0)
        box.setSpacing(8)
        box.addLayout(self.line)
        box.addWidget(split, 1)
