"""A chart: legend, canvas and statistics of some curves, and the window of time that is seen."""

from collections.abc import Callable
from dataclasses import dataclass

from PyQt6.QtCore import QEvent, Qt, QTimer, pyqtSignal
from PyQt6.QtGui import QAction, QContextMenuEvent, QFocusEvent, QKeyEvent, QKeySequence, QShowEvent
from PyQt6.QtWidgets import QHBoxLayout, QMenu, QToolButton, QVBoxLayout, QWidget

from workbench.gui.charts.canvas import Canvas
from workbench.gui.charts.chart_model import ChartModel
from workbench.gui.charts.curve import Curve
from workbench.gui.charts.legend import Entry, Legend
from workbench.gui.charts.saving import Copies
from workbench.gui.charts.statistics import StatisticsTable
from workbench.gui.icons import icon
from workbench.gui.style import dressed
from workbench.gui.workspace import Workspace

STEP = 0.02
"""Of the window that an arrow key moves the crosshair."""
PAGE = 0.25
"""Of the window that a page is."""
ZOOM = 0.8
"""Of the window that is left by one key."""
IGNORED = 0x2200_0000
"""Qt's KeypadModifier and ShiftModifier: they change nothing in what a key asks for."""


@dataclass(frozen=True)
class Command:
    """Something that a chart does.

    Attributes:
        text: in the menu, "" where it is for keys alone.
        key: as Qt writes it, several with spaces between, "" for none.
        do: it; takes whether it is switched on, where it is a switch.
        checked: whether it is on, None where it is no switch.
    """

    text: str
    key: str
    do: Callable[[bool], object]
    checked: bool | None = None


SEPARATOR = Command("-", "", bool)


class Chart(QWidget):
    """Shows curves over time.

    Wheel: time; with Ctrl, or over an axis: values. Drag: zoom to a box. Double click, Escape or
    Home: undo that. Arrows: crosshair. Page up and down: move. A, B: cursors that stay, and can be
    dragged. S: statistics. Z: always show zero. +, -: zoom. Ctrl+C: copy the data.

    Args:
        workspace: colours, units and preferences.
        smallest: range of values that is shown where the data hardly move.
        kind: what it is called, before its title.
        parent: the Qt parent; this object is deleted with it.

    Attributes:
        legend: title and names.
        canvas: where curves are drawn.
        statistics: table below.
        buttons: beside the legend.
        extra_actions: of the menu, besides the chart's own.
    """

    picture_changed = pyqtSignal()
    """It stands still, follows again, or shows other curves."""

    def __init__(
        self, workspace: Workspace, smallest: float, kind: str, parent: QWidget | None = None
    ) -> None:
        super().__init__(parent)
        self._workspace, self._kind = workspace, kind
        self._model = ChartModel(workspace.preferences, workspace.look, smallest)
        self._copies = Copies(workspace, self)
        self._soon = QTimer(self)  # several curves are added in one go
        self._soon.setSingleShot(True)
        self._soon.timeout.connect(self._redraw_if_seen)
        self.extra_actions: list[QAction] = []
        self.legend = Legend(workspace.look)
        self.canvas = Canvas(workspace.look)
        self.statistics = StatisticsTable()
        self.statistics.hide()
        self.buttons = QHBoxLayout()
        self.buttons.setSpacing(0)
        head = QHBoxLayout()
        head.addWidget(self.legend, 1)
        head.addLayout(self.buttons)
        head.setAlignment(self.buttons, Qt.AlignmentFlag.AlignTop)
        more = self._add_button("more", "Menu", "What this chart can do")
        more.clicked.connect(
            lambda: self.make_menu().popup(more.mapToGlobal(more.rect().bottomLeft()))
        )
        box = QVBoxLayout(self)
        box.setContentsMargins(0, 0, 0, 0)
        box.setSpacing(2)
        box.addLayout(head)
        box.addWidget(self.canvas, 1)
        box.addWidget(self.statistics)
        self.setFocusPolicy(Qt.FocusPolicy.StrongFocus)
        self.legend.toggled.connect(self.toggle_curve)
        self.canvas.hovered.connect(self.set_cursor)
        self.canvas.turned.connect(self._turn)
        self.canvas.boxed.connect(self._box)
        self.canvas.reset_wanted.connect(self.reset)
        self.canvas.mark_moved.connect(self.set_mark)
        self.canvas.resized.connect(self._soon.start)
        workspace.preferences.changed.connect(self._on_preference)
        self._describe()

    @property
    def curves(self) -> tuple[Curve, ...]:
        """What is drawn."""
        return tuple(self._model.curves)

    @property
    def title(self) -> str:
        """Its name."""
        return self.legend.title

    def set_title(self, title: str) -> None:
        """Give the chart a name."""
        self.legend.set_title(title)
        self._describe()

    def set_hint(self, hint: str) -> None:
        """Say what is to be done where there are no curves."""
        self._model.hint = hint
        self._soon.start()

    def toggle_curve(self, index: int) -> None:
        """Hide a curve, or show it again."""
        curve = self._model.curves[index]
        curve.visible = not curve.visible
        self._model.window.forget_ranges()
        self.redraw()

    @property
    def window_ends(self) -> tuple[float, float]:
        """First and last time that are seen [s]."""
        return self._model.ends

    def reset(self) -> None:
        """Show what is shown as long as nobody zooms."""
        raise NotImplementedError

    def redraw(self) -> None:
        """Draw anew, and write all numbers."""
        self.canvas.show_content(self._model.content(self.canvas.columns))
        self._show_numbers()

    def set_zero_shown(self, shown: bool) -> None:
        """Show zero always, or only where the data are near it."""
        self._model.window.with_zero = shown
        self._model.window.forget_ranges()
        self._settle()

    @property
    def is_zero_shown(self) -> bool:
        """Whether zero is always seen."""
        return self._model.window.with_zero

    def set_statistics_shown(self, shown: bool) -> None:
        """Show the statistics of what is seen below."""
        self.statistics.setVisible(shown)
        self._settle()

    @property
    def are_statistics_shown(self) -> bool:
        """Whether the statistics are below."""
        return not self.statistics.isHidden()

    @property
    def cursor_time(self) -> float | None:
        """Where the crosshair is [s]."""
        return self.canvas.cursor_time

    def set_cursor(self, time: float | None) -> None:
        """Put the crosshair to a time [s], or take it away."""
        self.canvas.set_cursor(time)
        self._show_numbers()

    def set_mark(self, name: str, time: float | None = None) -> None:
        """Put cursor A or B to a time [s]; where there is none, to the crosshair or the middle.

        The picture pauses, and the statistics show the values at the cursors.
        """
        left, right = self.window_ends
        if time is None:
            time = self.cursor_time if self.cursor_time is not None else 0.5 * (left + right)
        self._stand("PAUSED")
        self._model.marks[name] = time
        self.set_statistics_shown(True)

    def clear_marks(self) -> None:
        """Take cursors A and B away."""
        self._model.marks.clear()
        self._settle()

    def move_by(self, share: float) -> None:
        """Stand still, a share of the window later than now."""
        self._stand("PAUSED")
        self._model.window.move(share, self._model.now)
        self._settle()

    def zoom_by(self, factor: float) -> None:
        """Show a factor of the time, about the crosshair."""
        about = self.window_ends[1] if self.cursor_time is None else self.cursor_time
        self._model.window.zoom_time(about, factor, self._model.now)
        self._settle()

    def step_cursor(self, share: float) -> None:
        """Move the crosshair by a share of the window; it begins at the newest sample."""
        self.canvas.forget_mouse()
        left, right = self.window_ends
        at = right if self.cursor_time is None else self.cursor_time
        self.set_cursor(min(max(at + share * (right - left), left), right))

    def copy_picture(self) -> None:
        """Copy the chart as a picture."""
        self._copies.copy_picture(self)

    def copy_data(self) -> None:
        """Copy the samples that are seen, in SI, with tabs between."""
        self._copies.copy_data(self._model.columns())

    def save_picture(self) -> None:
        """Write the chart as a picture (PNG) to the folder for logs."""
        self._copies.save_picture(self, self.title)

    def save_data(self) -> None:
        """Write the samples that are seen (CSV), in SI, to the folder for logs."""
        self._copies.save_data(self._model.columns(), self.title)

    def make_menu(self) -> QMenu:
        """Return a menu that is gone once it is closed."""
        menu = QMenu(self)
        menu.aboutToHide.connect(menu.deleteLater)
        for command in self._commands():
            if command is SEPARATOR:
                menu.addSeparator()
            elif command.text:
                _add(menu, command)
        curves = menu.addMenu("Curves")
        if curves is not None:
            curves.setEnabled(bool(self.curves))
            for index, curve in enumerate(self.curves):
                _add(curves, Command(curve.label, "", self._toggle(index), curve.visible))
        menu.addActions(self.extra_actions)
        return menu

    def contextMenuEvent(self, event: QContextMenuEvent | None) -> None:
        """Offer what can be done."""
        if event is not None:
            self.make_menu().popup(event.globalPos())

    def keyPressEvent(self, event: QKeyEvent | None) -> None:
        """Obey the keyboard."""
        if event is None:
            return
        pressed = QKeySequence(event.keyCombination().toCombined() & ~IGNORED).toString()
        for command in self._commands():
            if pressed and pressed in command.key.split():
                command.do(not command.checked)
                return
        super().keyPressEvent(event)

    def focusInEvent(self, event: QFocusEvent | None) -> None:
        """Show that keys go here."""
        self.canvas.set_focus_shown(True)

    def focusOutEvent(self, event: QFocusEvent | None) -> None:
        """Keys go elsewhere."""
        self.canvas.set_focus_shown(False)

    def showEvent(self, event: QShowEvent | None) -> None:
        """Draw what was set while nobody saw it."""
        self._soon.start()

    def changeEvent(self, event: QEvent | None) -> None:
        """Follow another font."""
        super().changeEvent(event)
        if event is not None and event.type() == QEvent.Type.FontChange:
            self._soon.start()

    def _commands(self) -> list[Command]:
        """Return what can be done, in the order of the menu."""
        return [
            Command("Statistics", "S", self.set_statistics_shown, self.are_statistics_shown),
            Command("Always show zero", "Z", self.set_zero_shown, self.is_zero_shown),
            Command("Set cursor A", "A", lambda _: self.set_mark("A")),
            Command("Set cursor B", "B", lambda _: self.set_mark("B")),
            Command("Clear cursors", "", lambda _: self.clear_marks()),
            SEPARATOR,
            Command("Copy picture", "", lambda _: self.copy_picture()),
            Command("Copy data", "Ctrl+C", lambda _: self.copy_data()),
            Command("Save picture (PNG)", "", lambda _: self.save_picture()),
            Command("Save data (CSV)", "", lambda _: self.save_data()),
            Command("", "Left", lambda _: self.step_cursor(-STEP)),
            Command("", "Right", lambda _: self.step_cursor(STEP)),
            Command("", "PgUp", lambda _: self.move_by(-PAGE)),
            Command("", "PgDown", lambda _: self.move_by(PAGE)),
            Command("", "+ =", lambda _: self.zoom_by(ZOOM)),
            Command("", "-", lambda _: self.zoom_by(1.0 / ZOOM)),
            Command("", "Menu", lambda _: self.make_menu().popup(self.mapToGlobal(self.pos()))),
        ]

    def _toggle(self, index: int) -> Callable[[bool], None]:
        return lambda _: self.toggle_curve(index)

    def _add_button(self, picture: str, name: str, help: str) -> QToolButton:
        """Put a button before the others beside the legend."""
        button = dressed(QToolButton(), "quiet small")
        button.setAccessibleName(name)
        button.setAccessibleDescription(help)
        button.setToolTip(help)
        look = self._workspace.look
        look.changed.connect(lambda: button.setIcon(icon(picture, look.colour("muted"))))
        button.setIcon(icon(picture, look.colour("muted")))
        self.buttons.insertWidget(0, button)
        return button

    def _stand(self, note: str) -> None:
        """Let the picture stand still."""
        self._model.note = note
        self._model.stand()

    def _turn(self, time: float, share: float, factor: float, values: bool) -> None:
        window = self._model.window
        if values:
            window.zoom_values(self._model.axis_ends, share, factor)
        else:
            window.zoom_time(time, factor, self._model.now)
        self._settle()

    def _box(self, left: float, right: float, low: float, high: float) -> None:
        self._stand("ZOOMED")
        self._model.window.show(left, right)
        self._model.window.cut_values(self._model.axis_ends, low, high)
        self._settle()

    def _settle(self) -> None:
        self._redraw_if_seen()
        self.picture_changed.emit()

    def _redraw_if_seen(self) -> None:
        if self.isVisible():
            self.redraw()

    def _curves_changed(self) -> None:
        self._model.window.forget_ranges()
        self._describe()
        self._soon.start()
        self.picture_changed.emit()

    def _show_numbers(self) -> None:
        self.legend.show_entries(self._entries())
        if self.are_statistics_shown:
            self.statistics.show_rows(self._model.statistics(), self._model.marks)

    def _entries(self) -> list[Entry]:
        return self._model.entries(self.cursor_time)

    def _describe(self) -> None:
        labels = ", ".join(curve.label for curve in self.curves) or "no curves"
        self.setAccessibleName(f"{self._kind} {self.title}".strip())
        of = f"{self._model.y_label} of " if self._model.y_label else ""
        self.setAccessibleDescription(f"{of}{labels}, over time in s")

    def _on_preference(self, name: str) -> None:
        if name.endswith("_unit"):
            self._model.window.release_values()
            self._settle()


def _add(menu: QMenu, command: Command) -> None:
    """Add an action; the key is heard by the chart itself, and only told here."""
    key = command.key.partition(" ")[0]
    action = QAction(f"{command.text}\t{key}" if key else command.text, menu)
    if command.checked is not None:
        action.setCheckable(True)
        action.setChecked(command.checked)
    action.triggered.connect(command.do)
    menu.addAction(action)
