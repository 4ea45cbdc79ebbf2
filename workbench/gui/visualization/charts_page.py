"""The page of charts: a list of signals beside a board of charts, and controls above."""

from contextlib import suppress
from functools import partial
from pathlib import Path

from PyQt6.QtCore import QSettings, Qt
from PyQt6.QtGui import QResizeEvent
from PyQt6.QtWidgets import (
    QFileDialog,
    QMenu,
    QSplitter,
    QWidget,
)

from workbench.common.errors import WorkbenchError
from workbench.common.flight import Flight
from workbench.common.plain_files import write_atomically
from workbench.common.plain_text import plain_name
from workbench.common.quantity import number_text
from workbench.gui.errands import FutureCallbacks
from workbench.gui.file_dialogs import open_file, show_file_dialog, shown_again
from workbench.gui.flow_layout import FlowLayout
from workbench.gui.labels import MAX_MENU_PATH_CHARACTERS, Label, menu_text
from workbench.gui.layout import (
    NO_MARGINS,
    add_action,
    buddy,
    button,
    choice,
    column,
    hbox,
    named,
    scrolled,
    vbox,
)
from workbench.gui.preferences import log_folder
from workbench.gui.recent_files import FileKind
from workbench.gui.visualization.chart_board import ChartBoard
from workbench.gui.visualization.derived_signals import (
    DERIVED_SIGNALS,
    DerivedSignal,
    SeriesSource,
    WithDerived,
)
from workbench.gui.visualization.layouts import (
    DEFAULT_PRESET,
    LAYOUT_PRESETS,
    Board,
    ChartLayout,
    ChartSpec,
    fitting_board,
    layout_text,
    read_layout,
    read_stored_layout,
    stored_layout_text,
)
from workbench.gui.visualization.overlays import Overlay, OverlayBar
from workbench.gui.visualization.signal_catalog import make_catalog
from workbench.gui.visualization.signal_dialog import SignalDialog
from workbench.gui.visualization.signal_tree import SignalTree
from workbench.gui.visualization.spec_limits import SpecContents
from workbench.gui.workspace import Workspace
from workbench.link.topics import Topic

CHARTS_SETTINGS_KEY = "visualization/charts"
"""Settings key of the charts."""
OWN_LAYOUT_NAME = "Own"
MIN_PAGE_WITH_LIST_PX = 980
"""Least width with the list of signals beside the charts [pixels]."""
SOURCES_LIST_PX = 310
"""Width of the list of signals that shows their names in the log of another program [pixels]."""
LAYOUT_FILE_ENDING = ".layout.yaml"
"""Ending of layout files."""


class ChartsPage(QWidget):
    """Charts of the flight, or of a log.

    Args:
        workspace: signals, preferences and colours.
    """

    def __init__(self, workspace: Workspace) -> None:
        super().__init__()
        self._workspace = workspace
        self._store: QSettings = workspace.preferences.store
        self._answers = FutureCallbacks(workspace.notices.warn, self)
        self._recent = workspace.recent
        self._live: SeriesSource = workspace.signals
        self._base: SeriesSource = self._live
        self._own: tuple[DerivedSignal, ...] = ()
        self._source = WithDerived(self._live)
        self._topics: tuple[Topic, ...] = ()
        self._tree_chosen: bool | None = None
        self._chosen_for_log: tuple[Board, Board] | None = None  # before, and in its place
        self.board = ChartBoard(workspace, self._source)
        self.tree = SignalTree()
        self.overlays = OverlayBar()
        self.limits = QWidget()
        self._limits_of, self.marks = Label(), Label()
        self.no_limits = named(
            button("Remove", lambda: self.show_limits(None)), "Remove the limits of the spec"
        )
        self.new_signal = button(
            "Derived si&gnal…", self.ask_signal, help="Make a signal from others by an expression"
        )
        self.presets = choice("Layout of the charts", (*LAYOUT_PRESETS, OWN_LAYOUT_NAME))
        help = "Save the charts with their signals and axes, or open saved ones"
        self.files = button("Layou&t file", help=help)
        self.file_menu = QMenu(self)
        self.signals_shown = button("&Signals", help="Show the list of all signals")
        self.add = button("Add &chart", self.board.add_chart)
        help = "Pause all charts; the flight continues"
        self.pause = button("Pause &all", help=help)
        for each in (self.signals_shown, self.pause):
            each.setCheckable(True)
        self.clear_marks = button("Clear A, B", lambda: self.board.set_marks({}))
        self.line = FlowLayout()
        self._lay_out()
        self.tree.chosen.connect(self.board.add_signals)
        self.tree.chosen_apart.connect(
            lambda names: self.board.add_chart(ChartSpec(names[0], tuple(names)))
        )
        self.tree.edit_wanted.connect(self._edit)
        self.tree.removal_wanted.connect(self._remove)
        self.board.changed.connect(self._keep)
        self.board.slid.connect(self.overlays.slide)
        self.board.view_changed.connect(self._show_view)
        self.board.used.connect(self.tree.set_target)
        self.overlays.changed.connect(self._show_overlays)
        self.overlays.align_wanted.connect(self._align)
        self.presets.activated.connect(lambda _: self._show_preset(self.presets.currentText()))
        self.signals_shown.clicked.connect(self._choose_tree)
        self.pause.clicked.connect(self.board.set_paused)
        self._fill_files()
        kept = read_stored_layout(str(self._store.value(CHARTS_SETTINGS_KEY, "")))
        self._own = kept.signals if kept else ()
        self._source = self._with_own(self._base)
        self.board.show_board(kept.charts if kept else LAYOUT_PRESETS[DEFAULT_PRESET], self._source)
        self._name_preset()

    @property
    def layout_shown(self) -> ChartLayout:
        """Charts, the user's own signals, and cursors."""
        return ChartLayout(charts=self.board.board, signals=self._own, marks=self.board.marks)

    def show_layout(self, layout: ChartLayout) -> None:
        """Show the charts, signals and cursors of a layout."""
        self._change_own(layout.signals)
        self._source = self._with_own(self._base)
        self._show_catalog()
        self.board.show_board(layout.charts, self._source)
        self.pause.setChecked(False)
        if layout.marks:
            self.board.set_marks(layout.marks)
        self._keep()

    def add_overlay(self, name: str, log: SeriesSource) -> None:
        """Draw a log over the charts."""
        overlay = Overlay(name, log)
        overlay.derive((*DERIVED_SIGNALS, *self._own))
        with suppress(WorkbenchError):  # nothing to align them by: it stays as it is
            overlay.align(self._base)
        self.overlays.add(overlay)
        self.overlays.show_shifts()
        if not any(overlay.signal(each) for pane in self.board.panes for each in pane.spec.signals):
            self._workspace.notices.warn(
                f"the overlay {name} has none of the signals in these charts",
                "Choose another layout, or add signals that both have.",
            )

    def show_limits(self, limits: SpecContents | None) -> None:
        """Draw the limits of a spec on the signals that they apply to, None for none."""
        self.board.show_limits(limits)
        self.limits.setVisible(limits is not None)
        if limits is not None:
            self._limits_of.setText(f"limits of  {plain_name(limits.path.name)}")

    def open_layout(self, path: Path) -> None:
        """Read a layout file and show it; errors become notices."""

        def show(layout: ChartLayout) -> None:
            self.show_layout(layout)
            self._recent.add(FileKind.LAYOUT, str(path))

        self._answers.expect(self._workspace.errands.run(partial(read_layout, path)), show)

    def save_layout(self, path: Path) -> None:
        """Write the charts to a file."""
        if not path.name.endswith((".yaml", ".yml")):
            path = path.with_name(path.name + LAYOUT_FILE_ENDING)

        def tell(_: object) -> None:
            self._workspace.notices.inform(f"Saved {path}")
            self._recent.add(FileKind.LAYOUT, str(path))

        write = partial(write_atomically, path, layout_text(self.layout_shown))
        self._answers.expect(self._workspace.errands.run(write), tell)

    def ask_signal(self, signal: DerivedSignal | None = None) -> SignalDialog:
        """Ask for a derived signal, or for another expression of one."""
        dialog = SignalDialog(signal or DerivedSignal(), partial(self._check, signal), self)
        dialog.given.connect(lambda given: self._take(given, signal))
        dialog.show()
        return dialog

    def begin(self, topics: tuple[Topic, ...]) -> None:
        """Show the signals of a new flight."""
        self._topics = topics
        if self._base is self._live:
            self._show_catalog()
            self.board.show_source(self._source, times_ago=True)
            self.pause.setChecked(False)

    def show_source(self, source: SeriesSource | None) -> None:
        """Show the series of a log, in charts that suit it; None for those of the flight."""
        self._base = source or self._live
        self._source = self._with_own(self._base)
        self.pause.setChecked(False)
        self._show_catalog()
        self.board.show_source(self._source, times_ago=source is None)
        self._fit_board(source is not None)

    def _fit_board(self, logged: bool) -> None:
        """Show charts that suit a log; after it those before, unless the user changed them."""
        present, chosen = self.board.board, self._chosen_for_log
        before = chosen[0] if chosen and present == chosen[1] else present
        wanted = fitting_board(before, self._source.units) if logged else before
        self._chosen_for_log = (before, wanted) if logged and wanted != before else None
        if wanted != present:
            self.board.show_board(wanted, self._source)
            self._name_preset()

    def _with_own(self, source: SeriesSource) -> WithDerived:
        return WithDerived(source, (*DERIVED_SIGNALS, *self._own))

    def _check(self, old: DerivedSignal | None, signal: DerivedSignal) -> None:
        """Refuse a derived signal that cannot be made.

        Raises:
            WorkbenchError: says what is wrong.
        """
        if signal.name in (each.name for each in self._own if each is not old):
            raise WorkbenchError(f"{signal.name} exists already: give it another name")
        others = [each for each in self._own if each is not old]
        source = WithDerived(self._base, (*DERIVED_SIGNALS, *others, signal))
        if self._base.units:
            full = signal.parsed.find({name: 0 for name in source.units if name != signal.name})
            signal.parsed.series(source.series, full)
        else:
            signal.check()  # no flight yet: its names are resolved later

    def _take(self, signal: DerivedSignal, old: DerivedSignal | None) -> None:
        """Add a derived signal, or replace an old one."""
        if old is None:
            self._change_own((*self._own, signal))
            self.board.add_signal(signal.name)
            return
        self._change_own(tuple(signal if each is old else each for each in self._own))
        if signal.name != old.name:
            self.board.rename_signal(old.name, signal.name)

    def _edit(self, name: str) -> None:
        self.ask_signal(next(each for each in self._own if each.name == name))

    def _remove(self, name: str) -> None:
        self._change_own(tuple(each for each in self._own if each.name != name))

    def _change_own(self, own: tuple[DerivedSignal, ...]) -> None:
        self._own = own
        for overlay in self.overlays.overlays:
            overlay.derive((*DERIVED_SIGNALS, *own))
        self._source = self._with_own(self._base)
        self._show_catalog()
        self.board.change_source(self._source)
        self._keep()

    def _show_overlays(self) -> None:
        self.board.show_overlays(self.overlays.overlays)

    def _align(self, overlay: Overlay) -> None:
        try:
            overlay.align(self._base)
        except WorkbenchError as error:
            self._workspace.notices.warn(str(error))
            return
        self.overlays.show_shifts()

    def _show_view(self) -> None:
        """Show the time between cursors A and B."""
        marks = self.board.marks
        both = len(marks) == 2
        said = f"B − A = {number_text(marks['B'] - marks['A'], 3)} s" if both else ""
        self.marks.setText(said)
        self.marks.setVisible(both)
        self.clear_marks.setVisible(bool(marks))

    def _fill_files(self) -> None:
        for text, do in (("&Open…", self._ask_open), ("&Save as…", self._ask_save)):
            add_action(self.file_menu, text, lambda _, do=do: do())
        self._recent_menu = QMenu("&Recent", self.file_menu)
        self.file_menu.addMenu(self._recent_menu)
        self.file_menu.aboutToShow.connect(self._fill_recent)
        self.files.setMenu(self.file_menu)

    def _fill_recent(self) -> None:
        """List recent layouts that still exist."""
        self._recent_menu.clear()
        paths = [path for kind, path in self._recent.files() if kind is FileKind.LAYOUT]
        self._recent_menu.setEnabled(bool(paths))
        for path in paths:
            text = menu_text(path, MAX_MENU_PATH_CHARACTERS)
            add_action(self._recent_menu, text, lambda _, path=path: self.open_layout(Path(path)))

    def _ask_open(self) -> None:
        folder = str(log_folder(self._workspace.preferences))
        kinds = f"Layouts (*{LAYOUT_FILE_ENDING});;All files (*)"
        open_file(self, "Open layout", self.open_layout, folder, kinds)

    def _ask_save(self) -> None:
        title = "Save layout"
        if shown_again(self, title):
            return
        folder = str(log_folder(self._workspace.preferences))
        dialog = QFileDialog(self, title, folder, f"Layouts (*{LAYOUT_FILE_ENDING})")
        dialog.setAcceptMode(QFileDialog.AcceptMode.AcceptSave)
        show_file_dialog(dialog, lambda name: self.save_layout(Path(name)))

    def refresh(self, now: float) -> None:
        """Draw until a time [s]."""
        self.board.refresh(now)

    def resizeEvent(self, event: QResizeEvent | None) -> None:
        """Show the list of signals if there is room for it."""
        self._show_tree()

    def _show_catalog(self) -> None:
        sources = self._base.sources if isinstance(self._base, Flight) else None
        if sources:
            rest = max(0, sum(self._split.sizes()) - SOURCES_LIST_PX)
            self._split.setSizes([SOURCES_LIST_PX, rest])
        self.tree.show_groups(make_catalog(self._source.units, self._topics, sources))

    def _choose_tree(self, shown: bool) -> None:
        self._tree_chosen = shown
        self._show_tree()
        if shown:
            self.tree.search.setFocus()

    def _show_tree(self) -> None:
        shown = (
            self.width() >= MIN_PAGE_WITH_LIST_PX
            if self._tree_chosen is None
            else self._tree_chosen
        )
        self._side.setVisible(shown)
        self.signals_shown.setChecked(shown)

    def _show_preset(self, name: str) -> None:
        if name in LAYOUT_PRESETS:
            self.board.show_board(LAYOUT_PRESETS[name], self._source)
            self.pause.setChecked(False)
            self._keep()

    def _keep(self) -> None:
        self._store.setValue(CHARTS_SETTINGS_KEY, stored_layout_text(self.layout_shown))
        self._name_preset()

    def _name_preset(self) -> None:
        """Show which preset the charts match, if any."""
        board = self.board.board
        name = next(
            (each for each, preset in LAYOUT_PRESETS.items() if preset == board), OWN_LAYOUT_NAME
        )
        self.presets.setCurrentText(name)

    def _lay_out(self) -> None:
        name = buddy("La&yout", self.presets, kind="")
        for widget in (
            *(self.signals_shown, name, self.presets, self.files, self.add, self.pause),
            *(self.marks, self.clear_marks),
        ):
            self.line.addWidget(widget)
        self._show_view()
        side = column((self.tree, 1), self.new_signal)
        self._split = split = QSplitter(Qt.Orientation.Horizontal)
        split.setChildrenCollapsible(False)
        split.addWidget(side)
        split.addWidget(scrolled(self.board))
        split.setStretchFactor(1, 1)
        split.setSizes([250, 900])
        side.setMinimumWidth(200)
        self._side = side
        hbox(self._limits_of, self.no_limits, 1, of=self.limits, margins=NO_MARGINS)
        self.limits.hide()
        below = (self.overlays, self.limits)  # what comes and goes moves no chart above it
        parts = (self.line, (split, 1), *below)
        vbox(*parts, of=self, margins=(0, 8, 0, 0), spacing=8)
