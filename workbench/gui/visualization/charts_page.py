"""The page of charts: a list of signals beside a board of charts, and controls above."""

import re
from collections.abc import Callable
from functools import partial
from pathlib import Path

from PyQt6.QtCore import QSettings, Qt, pyqtSignal
from PyQt6.QtGui import QResizeEvent
from PyQt6.QtWidgets import (
    QDialog,
    QDialogButtonBox,
    QFileDialog,
    QFormLayout,
    QLayout,
    QLineEdit,
    QMenu,
    QSplitter,
    QWidget,
)

from workbench.common.errors import WorkbenchError
from workbench.common.plain_text import plain_name
from workbench.gui.charts.ticks import number_text
from workbench.gui.errands import Answers
from workbench.gui.file_dialogs import open_file, show_file_dialog
from workbench.gui.labels import LONGEST_PATH, Label, menu_text
from workbench.gui.layout import (
    NO_MARGINS,
    FlowLayout,
    buddy,
    button,
    choice,
    column,
    hbox,
    named,
    scrolled,
    vbox,
)
from workbench.gui.opener import FileKind, RecentFiles
from workbench.gui.preferences import log_folder
from workbench.gui.style import set_class
from workbench.gui.visualization.chart_board import ChartBoard
from workbench.gui.visualization.derived_signals import (
    DERIVED,
    OWN_TOPIC,
    Derived,
    SeriesSource,
    WithDerived,
)
from workbench.gui.visualization.layouts import (
    DEFAULT,
    PRESETS,
    ChartSpec,
    Layout,
    kept_text,
    layout_text,
    read_kept,
    read_layout,
)
from workbench.gui.visualization.log_messages import SpecContents
from workbench.gui.visualization.overlays import Overlay, OverlayBar
from workbench.gui.visualization.signal_catalog import make_catalog
from workbench.gui.visualization.signal_tree import SignalTree
from workbench.gui.workspace import Workspace
from workbench.link.topics import Topic
from workbench.logs.expressions import FUNCTIONS

KEPT = "visualization/charts"
"""Settings key of the charts."""
OWN = "Own"
WIDE_PAGE = 980
"""Least width with the list of signals beside the charts [pixels]."""
DIALOG_WIDTH = 520
"""Width of the texts in a dialog [pixels]."""
ENDING = ".layout.yaml"
"""Ending of layout files."""


class SignalDialog(QDialog):
    """Asks for a signal derived by an expression, and shows errors while it is typed.

    Args:
        signal: signal to change; empty for a new one.
        check: raises a WorkbenchError if a signal is invalid.
        parent: the Qt parent.
    """

    given = pyqtSignal(object)
    """The requested `Derived`."""

    def __init__(
        self, signal: Derived, check: Callable[[Derived], object], parent: QWidget | None = None
    ) -> None:
        super().__init__(parent)
        self.setWindowTitle("Derived signal")
        self._check = check
        self.name = QLineEdit(signal.name.partition(".")[2])
        self.name.setPlaceholderText("ground_speed")
        self.expression = QLineEdit(signal.expression)
        self.expression.setPlaceholderText("sqrt(v_x**2 + v_y**2)")
        self.unit = QLineEdit(signal.unit if signal.name else "")
        self.unit.setPlaceholderText("m/s")
        self.said = Label()
        self.said.setWordWrap(True)
        form = QFormLayout(self)
        form.setSizeConstraint(QLayout.SizeConstraint.SetFixedSize)  # as high as the message
        for label, field in (
            ("&Name", self.name),
            ("&Expression", self.expression),
            ("&Unit, in SI", self.unit),
        ):
            field.textChanged.connect(self._look)
            form.addRow(buddy(label, field, kind=""), field)
        known = ", ".join(
            f"{name} ({each.help})" if each.help.count(" ") > 2 else name
            for name, each in FUNCTIONS.items()
        )
        help = Label(f"Signals by their names, + - * / // % **, comparisons, pi, {known}.")
        help.setWordWrap(True)
        help.setFixedWidth(DIALOG_WIDTH)
        self.said.setFixedWidth(DIALOG_WIDTH)
        set_class(help, "muted")
        self.buttons = QDialogButtonBox(
            QDialogButtonBox.StandardButton.Ok | QDialogButtonBox.StandardButton.Cancel
        )
        self.buttons.accepted.connect(self.accept)
        self.buttons.rejected.connect(self.reject)
        for widget in (self.said, help, self.buttons):
            form.addRow(widget)
        self.accepted.connect(lambda: self.given.emit(self.signal))
        self.finished.connect(self.deleteLater)
        self._look()

    @property
    def signal(self) -> Derived:
        """The requested signal."""
        name = f"{OWN_TOPIC}.{self.name.text().strip()}"
        return Derived(name, self.unit.text().strip() or "1", self.expression.text().strip())

    def _look(self) -> None:
        """Show errors."""
        why = ""
        if not re.fullmatch(r"[A-Za-z_]\w*", self.name.text().strip()):
            why = "Give it a name of letters, digits and _."
        else:
            try:
                self._check(self.signal)
            except WorkbenchError as error:
                why = str(error)
        self.said.setText(why)
        button = self.buttons.button(QDialogButtonBox.StandardButton.Ok)
        if button is not None:
            button.setEnabled(not why)


class ChartsPage(QWidget):
    """Charts of the flight, or of a log.

    Args:
        workspace: signals, preferences and colours.
    """

    def __init__(self, workspace: Workspace) -> None:
        super().__init__()
        self._workspace = workspace
        self._store: QSettings = workspace.preferences.store
        self._answers = Answers(workspace.notices.warn, self)
        self._recent = RecentFiles(workspace.preferences.store, self)
        self._live: SeriesSource = workspace.signals
        self._base: SeriesSource = self._live
        self._own: tuple[Derived, ...] = ()
        self._source = WithDerived(self._live)
        self._topics: tuple[Topic, ...] = ()
        self._tree_chosen: bool | None = None
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
        self.presets = choice("Layout of the charts", (*PRESETS, OWN))
        help = "Save the charts with their signals and axes, or open saved ones"
        self.files = button("Layout &file", help=help)
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
        self.tree.chosen.connect(self.board.add_signal)
        self.tree.chosen_apart.connect(lambda name: self.board.add_chart(ChartSpec(name, (name,))))
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
        kept = read_kept(str(self._store.value(KEPT, "")))
        self._own = kept.signals if kept else ()
        self._source = self._with_own(self._base)
        self.board.show_board(kept.charts if kept else PRESETS[DEFAULT], self._source)
        self._name_preset()

    @property
    def layout_shown(self) -> Layout:
        """Charts, the user's own signals, and cursors."""
        return Layout(charts=self.board.board, signals=self._own, marks=self.board.marks)

    def show_layout(self, layout: Layout) -> None:
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
        overlay.derive((*DERIVED, *self._own))
        self.overlays.add(overlay)

    def show_limits(self, limits: SpecContents | None) -> None:
        """Draw the limits of a spec on the signals that they apply to, None for none."""
        self.board.show_limits(limits)
        self.limits.setVisible(limits is not None)
        if limits is not None:
            self._limits_of.setText(f"limits of  {plain_name(limits.path.name)}")

    def open_layout(self, path: Path) -> None:
        """Read a layout file and show it; errors become notices."""

        def show(layout: Layout) -> None:
            self.show_layout(layout)
            self._recent.add(FileKind.LAYOUT, str(path))

        self._answers.expect(self._workspace.errands.run(partial(read_layout, path)), show)

    def save_layout(self, path: Path) -> None:
        """Write the charts to a file."""
        if not path.name.endswith((".yaml", ".yml")):
            path = path.with_name(path.name + ENDING)

        def tell(_: object) -> None:
            self._workspace.notices.inform(f"Saved {path}")
            self._recent.add(FileKind.LAYOUT, str(path))

        write = partial(_write_text, path, layout_text(self.layout_shown))
        self._answers.expect(self._workspace.errands.run(write), tell)

    def ask_signal(self, signal: Derived | None = None) -> SignalDialog:
        """Ask for a derived signal, or for another expression of one."""
        dialog = SignalDialog(signal or Derived(), partial(self._check, signal), self)
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
        """Show the series of a log, None for those of the flight."""
        self._base = source or self._live
        self._source = self._with_own(self._base)
        self.pause.setChecked(False)
        self._show_catalog()
        self.board.show_source(self._source, times_ago=source is None)

    def _with_own(self, source: SeriesSource) -> WithDerived:
        return WithDerived(source, (*DERIVED, *self._own))

    def _check(self, old: Derived | None, signal: Derived) -> None:
        """Refuse a derived signal that cannot be made.

        Raises:
            WorkbenchError: says what is wrong.
        """
        if signal.name in (each.name for each in self._own if each is not old):
            raise WorkbenchError(f"{signal.name} exists already: give it another name")
        others = [each for each in self._own if each is not old]
        source = WithDerived(self._base, (*DERIVED, *others, signal))
        if self._base.units:
            full = signal.parsed.find({name: 0 for name in source.units if name != signal.name})
            signal.parsed.series(source.series, full)
        else:
            signal.check()  # no flight yet: its names are resolved later

    def _take(self, signal: Derived, old: Derived | None) -> None:
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

    def _change_own(self, own: tuple[Derived, ...]) -> None:
        self._own = own
        for overlay in self.overlays.overlays:
            overlay.derive((*DERIVED, *own))
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
            action = self.file_menu.addAction(text)
            if action is not None:
                action.triggered.connect(do)
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
            action = self._recent_menu.addAction(menu_text(path, LONGEST_PATH))
            if action is not None:
                action.triggered.connect(partial(self.open_layout, Path(path)))

    def _ask_open(self) -> None:
        folder = str(log_folder(self._workspace.preferences))
        kinds = f"Layouts (*{ENDING});;All files (*)"
        open_file(self, "Open layout", self.open_layout, folder, kinds)

    def _ask_save(self) -> None:
        folder = str(log_folder(self._workspace.preferences))
        dialog = QFileDialog(self, "Save layout", folder, f"Layouts (*{ENDING})")
        dialog.setAcceptMode(QFileDialog.AcceptMode.AcceptSave)
        show_file_dialog(dialog, lambda name: self.save_layout(Path(name)))

    def refresh(self, now: float) -> None:
        """Draw until a time [s]."""
        self.board.refresh(now)

    def resizeEvent(self, event: QResizeEvent | None) -> None:
        """Show the list of signals if there is room for it."""
        self._show_tree()

    def _show_catalog(self) -> None:
        self.tree.show_groups(make_catalog(self._source.units, self._topics))

    def _choose_tree(self, shown: bool) -> None:
        self._tree_chosen = shown
        self._show_tree()
        if shown:
            self.tree.search.setFocus()

    def _show_tree(self) -> None:
        shown = self.width() >= WIDE_PAGE if self._tree_chosen is None else self._tree_chosen
        self._side.setVisible(shown)
        self.signals_shown.setChecked(shown)

    def _show_preset(self, name: str) -> None:
        if name in PRESETS:
            self.board.show_board(PRESETS[name], self._source)
            self.pause.setChecked(False)
            self._keep()

    def _keep(self) -> None:
        self._store.setValue(KEPT, kept_text(self.layout_shown))
        self._name_preset()

    def _name_preset(self) -> None:
        """Show which preset the charts match, if any."""
        board = self.board.board
        name = next((each for each, preset in PRESETS.items() if preset == board), OWN)
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
        split = QSplitter(Qt.Orientation.Horizontal)
        split.setChildrenCollapsible(False)
        split.addWidget(side)
        split.addWidget(scrolled(self.board))
        split.setStretchFactor(1, 1)
        split.setSizes([250, 900])
        side.setMinimumWidth(200)
        self._side = side
        hbox(self._limits_of, self.no_limits, 1, of=self.limits, margins=NO_MARGINS)
        self.limits.hide()
        parts = (self.line, self.overlays, self.limits, (split, 1))
        vbox(*parts, of=self, margins=(0, 8, 0, 0), spacing=8)


def _write_text(path: Path, text: str) -> None:
    """Write a file.

    Raises:
        WorkbenchError: if it cannot be written.
    """
    try:
        path.write_text(text, "utf-8")
    except OSError as error:
        raise WorkbenchError(f"{path}: cannot be written: {error.strerror}") from error
