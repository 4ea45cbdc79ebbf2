"""A chart: legend, canvas and statistics of some curves, with its keys and its menu."""

import time
from collections.abc import Callable, Sequence
from pathlib import Path

from PyQt6.QtCore import QEvent, Qt, pyqtSignal
from PyQt6.QtGui import (
    QAction,
    QContextMenuEvent,
    QFocusEvent,
    QKeyEvent,
    QShowEvent,
)
from PyQt6.QtWidgets import QMenu, QToolButton, QWidget

from workbench.common.series import Series
from workbench.gui.charts.canvas import Canvas
from workbench.gui.charts.chart_command import (
    COMMAND_SEPARATOR,
    ChartCommand,
    add_command_action,
    pressed_key,
)
from workbench.gui.charts.chart_model import ChartModel
from workbench.gui.charts.chart_table import table_text
from workbench.gui.charts.content import ReferenceLine
from workbench.gui.charts.curve import ChartCurve
from workbench.gui.charts.legend import Legend, LegendEntry
from workbench.gui.charts.statistics import (
    STATISTICS_COLUMNS,
    StatisticsTable,
)
from workbench.gui.charts.ticks import Scale
from workbench.gui.errands import single_shot
from workbench.gui.file_dialogs import clipboard
from workbench.gui.icons import icon
from workbench.gui.labels import menu_text
from workbench.gui.layout import NO_MARGINS, hbox, named, tool_button, vbox
from workbench.gui.saved_files import save_beside_logs
from workbench.gui.workspace import Workspace

CURSOR_STEP_SHARE = 0.02
"""Step of the crosshair per arrow key, as a share of the window."""
PAGE_STEP_SHARE = 0.25
"""Step of Page Up and Page Down, as a share of the window."""
KEY_ZOOM_FACTOR = 0.8
"""Zoom factor per key."""


class Chart(QWidget):
    """Shows curves over time.

    Ctrl and wheel: time; with Shift, or over an axis: values. Drag: zoom to a box. Double click,
    Escape or Home: undo zooming. Arrows: crosshair. Page Up, Page Down: move. A, B: cursors that
    can be dragged. S: statistics. Z: always show zero. +, -: zoom. Ctrl+C: copy the data.

    Args:
        workspace: source of colours, units and preferences.
        smallest: shown range of values if the data hardly vary.
        kind: name of its kind, before its title.

    Attributes:
        legend: title and names.
        canvas: the drawing area.
        statistics: table below the canvas.
        buttons: buttons beside the legend.
        extra_actions: additional actions of the menu.
    """

    picture_changed = pyqtSignal()
    """It was paused, follows again, or shows other curves."""
    cursor_moved = pyqtSignal(object)
    """The user has moved the crosshair to a time [s], or removed it: None."""
    slid = pyqtSignal(float)
    """Dragged sideways with Shift, by this much [s]."""
    focused = pyqtSignal()
    """It has received the keyboard focus."""

    def __init__(self, workspace: Workspace, smallest: float, kind: str) -> None:
        super().__init__()
        self._workspace, self._kind = workspace, kind
        self._model = ChartModel(workspace.preferences, workspace.look, smallest)
        self._soon = single_shot(self._redraw_if_seen, self)  # several curves are added at once
        self.extra_actions: list[QAction] = []
        self.legend = Legend(workspace.look)
        self.canvas = Canvas(workspace.look)
        self.statistics = StatisticsTable()
        self.statistics.hide()
        self.buttons = hbox(spacing=0)
        head = hbox((self.legend, 1), self.buttons)
        head.setAlignment(self.buttons, Qt.AlignmentFlag.AlignTop)
        more = self._add_button("more", "Menu", "Menu of this chart")
        more.clicked.connect(
            lambda: self.make_menu().popup(more.mapToGlobal(more.rect().bottomLeft()))
        )
        vbox(head, (self.canvas, 1), self.statistics, of=self, margins=NO_MARGINS, spacing=2)
        self.setFocusPolicy(Qt.FocusPolicy.StrongFocus)
        self.legend.toggled.connect(self.toggle_entry)
        self.canvas.hovered.connect(self._point)
        self.canvas.turned.connect(self._turn)
        self.canvas.boxed.connect(self._box)
        self.canvas.view.slid.connect(self.slid)
        self.canvas.reset_wanted.connect(self.reset)
        self.canvas.mark_moved.connect(self.set_mark)
        self.canvas.resized.connect(self._soon.start)
        workspace.preferences.changed.connect(self._on_preference)
        self._describe()

    @property
    def curves(self) -> tuple[ChartCurve, ...]:
        """The drawn curves."""
        return tuple(self._model.curves)

    @property
    def title(self) -> str:
        """Its name."""
        return self.legend.title

    def set_title(self, title: str) -> None:
        """Set the chart's name."""
        self.legend.set_title(title)
        self._describe()

    def show_head(self, shown: bool) -> None:
        """Show the line of names and buttons, or leave its space to the curves."""
        self.legend.setVisible(shown)
        for index in range(self.buttons.count()):
            item = self.buttons.itemAt(index)
            button = item.widget() if item is not None else None
            if button is not None:
                button.setVisible(shown)

    def set_hint(self, hint: str) -> None:
        """Set the text that a chart without curves shows."""
        self._model.hint = hint
        self._soon.start()

    def set_guides(self, guides: Sequence[ReferenceLine], caption: str = "") -> None:
        """Draw straight lines below the curves, as margins; replaces the last ones.

        Args:
            guides: the lines.
            caption: text above the picture that explains them.
        """
        self._model.guides, self._model.caption = tuple(guides), caption
        self._soon.start()

    def toggle_entry(self, index: int) -> None:
        """Hide or show the curves of an entry of the legend."""
        for curve in self._model.curves.groups()[index]:
            curve.visible = not curve.visible
        self._model.window.forget_ranges()
        self.redraw()

    @property
    def window_ends(self) -> tuple[float, float]:
        """First and last visible time [s]."""
        return self._model.ends

    def reset(self) -> None:
        """Undo all zooming."""
        raise NotImplementedError

    def redraw(self) -> None:
        """Redraw, with all numbers."""
        self.canvas.show_content(self._model.content(self.canvas.columns))
        self._show_numbers()

    def set_zero_shown(self, shown: bool) -> None:
        """Always show zero, or only if the data are near it."""
        self._model.window.with_zero = shown
        self._model.window.forget_ranges()
        self._settle()

    @property
    def is_zero_shown(self) -> bool:
        """Whether zero is always shown."""
        return self._model.window.with_zero

    def set_statistics_shown(self, shown: bool) -> None:
        """Show or hide the statistics."""
        self.statistics.setVisible(shown)
        self._settle()

    def set_scales(self, x: Scale = Scale.LINEAR, y: Scale = Scale.LINEAR) -> None:
        """Set the scales of the horizontal axis and of all value axes."""
        self._model.set_scales(x, y)
        self._settle()

    @property
    def are_statistics_shown(self) -> bool:
        """Whether the statistics are shown."""
        return not self.statistics.isHidden()

    @property
    def cursor_time(self) -> float | None:
        """Position of the crosshair [s]."""
        return self.canvas.cursor_time

    def set_cursor(self, time: float | None) -> None:
        """Set the crosshair to a time [s], or remove it."""
        self.canvas.set_cursor(time)
        self._show_numbers()

    def set_mark(self, name: str, time: float | None = None) -> None:
        """Set cursor A or B to a time [s]; by default to the crosshair or the middle.

        The picture pauses, and the statistics show the values at the cursors.
        """
        if time is None:
            middle = self._model.window.time_at(0.5, self._model.now)
            time = self.cursor_time if self.cursor_time is not None else middle
        self._stand("PAUSED")
        self._model.marks[name] = time
        self.set_statistics_shown(True)

    def clear_marks(self) -> None:
        """Remove cursors A and B."""
        self._model.marks.clear()
        self._settle()

    def move_by(self, share: float) -> None:
        """Pause, and move by a share of the window."""
        self._stand("PAUSED")
        self._model.window.move(share, self._model.now)
        self._settle()

    def zoom_by(self, factor: float) -> None:
        """Scale the time window by a factor around the crosshair."""
        about = self.window_ends[1] if self.cursor_time is None else self.cursor_time
        self._model.window.zoom_time(about, factor, self._model.now)
        self._settle()

    def step_cursor(self, share: float) -> None:
        """Move the crosshair by a share of the window; it starts at the newest sample."""
        self.canvas.forget_mouse()
        at = self.window_ends[1] if self.cursor_time is None else self.cursor_time
        self._point(self._model.window.time_from(at, share, self._model.now))

    def copy_picture(self) -> None:
        """Copy the chart as a picture."""
        clipboard().setPixmap(self.grab())
        self._workspace.notices.inform("The chart is on the clipboard, as a picture.")

    def columns(self) -> tuple[Series, ...]:
        """Return the visible samples in SI units, as views that must be used at once."""
        return self._model.columns()

    def copy_data(self) -> None:
        """Copy the visible samples in SI units, separated by tabs."""
        clipboard().setText(table_text(self.columns(), self._model.over))
        self._workspace.notices.inform("The chart's data are on the clipboard, in SI units.")

    def save_picture(self) -> None:
        """Write the chart as a picture (PNG) to the folder for logs."""
        image = self.grab().toImage()
        self._write("png", lambda path: image.save(str(path)))

    def save_data(self) -> None:
        """Write the visible samples (CSV) in SI units to the folder for logs."""
        kept = [each.copy() for each in self.columns()]
        over = self._model.over
        self._write("csv", lambda path: path.write_text(table_text(kept, over, ","), "utf-8"))

    def _write(self, suffix: str, write: Callable[[Path], int]) -> None:
        """Write a file to the folder for logs, named after the chart and the time of day."""
        title = self.title.lower()
        name = "".join(each if each.isalnum() else "_" for each in title) or "chart"
        stamp = time.strftime("%Y%m%d_%H%M%S")
        save_beside_logs(self._workspace, f"{name}_{stamp}.{suffix}", write)

    def make_menu(self) -> QMenu:
        """Return a menu that is deleted when it is closed."""
        menu = QMenu(self)
        menu.aboutToHide.connect(menu.deleteLater)
        for command in self._commands():
            if command is COMMAND_SEPARATOR:
                menu.addSeparator()
            elif command.text:
                add_command_action(menu, command)
        curves = menu.addMenu("Curves")
        if curves is not None:
            curves.setEnabled(bool(self.curves))
            for index, entry in enumerate(self._entries()):
                name = menu_text(entry.label)
                add_command_action(
                    curves, ChartCommand(name, "", self._toggle(index), entry.visible)
                )
        menu.addActions(self.extra_actions)
        return menu

    def contextMenuEvent(self, event: QContextMenuEvent | None) -> None:
        """Open the context menu."""
        if event is not None:
            self.make_menu().popup(event.globalPos())

    def keyPressEvent(self, event: QKeyEvent | None) -> None:
        """Handle a key."""
        if event is None:
            return
        for command in self._commands():
            if pressed_key(event) in command.key.split():
                command.do(not command.checked)
                return
        super().keyPressEvent(event)

    def focusInEvent(self, event: QFocusEvent | None) -> None:
        """Show the keyboard focus."""
        self.canvas.set_focus_shown(True)
        self.focused.emit()

    def focusOutEvent(self, event: QFocusEvent | None) -> None:
        """Hide the keyboard focus."""
        self.canvas.set_focus_shown(False)

    def showEvent(self, event: QShowEvent | None) -> None:
        """Draw changes made while the chart was hidden."""
        self._soon.start()

    def changeEvent(self, event: QEvent | None) -> None:
        """Adapt to another font."""
        super().changeEvent(event)
        if event is not None and event.type() == QEvent.Type.FontChange:
            self._soon.start()

    def _commands(self) -> list[ChartCommand]:
        """Return the commands, in the order of the menu."""
        key, shown = self._workspace.keys.key, self.are_statistics_shown
        zero = ("Always show zero", key("zero"), self.set_zero_shown, self.is_zero_shown)
        return [
            ChartCommand("Statistics", key("statistics"), self.set_statistics_shown, shown),
            *([ChartCommand(*zero)] if self._model.window.y_scale is Scale.LINEAR else []),
            ChartCommand("Set cursor A", key("cursor_a"), lambda _: self.set_mark("A")),
            ChartCommand("Set cursor B", key("cursor_b"), lambda _: self.set_mark("B")),
            ChartCommand("Clear cursors", "", lambda _: self.clear_marks()),
            COMMAND_SEPARATOR,
            ChartCommand("Copy picture", "", lambda _: self.copy_picture()),
            ChartCommand("Copy data", "Ctrl+C", lambda _: self.copy_data()),
            ChartCommand("Save picture (PNG)", "", lambda _: self.save_picture()),
            ChartCommand("Save data (CSV)", "", lambda _: self.save_data()),
            ChartCommand("", "Left", lambda _: self.step_cursor(-CURSOR_STEP_SHARE)),
            ChartCommand("", "Right", lambda _: self.step_cursor(CURSOR_STEP_SHARE)),
            ChartCommand("", "PgUp", lambda _: self.move_by(-PAGE_STEP_SHARE)),
            ChartCommand("", "PgDown", lambda _: self.move_by(PAGE_STEP_SHARE)),
            ChartCommand("", "+ =", lambda _: self.zoom_by(KEY_ZOOM_FACTOR)),
            ChartCommand("", "-", lambda _: self.zoom_by(1.0 / KEY_ZOOM_FACTOR)),
            ChartCommand(
                "", "Menu", lambda _: self.make_menu().popup(self.mapToGlobal(self.pos()))
            ),
        ]

    def _toggle(self, index: int) -> Callable[[bool], None]:
        return lambda _: self.toggle_entry(index)

    def _add_button(self, picture: str, name: str, help: str) -> QToolButton:
        """Add a button before the others beside the legend."""
        button = named(tool_button("", kind="quiet small", help=help), name)
        button.setAccessibleDescription(help)
        look = self._workspace.look
        look.changed.connect(lambda: button.setIcon(icon(picture, look.colour("muted"))))
        button.setIcon(icon(picture, look.colour("muted")))
        self.buttons.insertWidget(0, button)
        return button

    def _point(self, time: float | None) -> None:
        self.set_cursor(time)
        self.cursor_moved.emit(time)

    def _stand(self, note: str) -> None:
        """Pause the picture."""
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
            heads = STATISTICS_COLUMNS | {mark: mark for mark in self._model.mark_heads}
            self.statistics.show_table(heads, self._model.statistics())

    def _entries(self) -> list[LegendEntry]:
        return self._model.entries(self.cursor_time)

    def _describe(self) -> None:
        labels = ", ".join(curve.label for curve in self.curves) or "no curves"
        self.setAccessibleName(f"{self._kind} {self.title}".strip())
        of = f"{self._model.y_label} of " if self._model.y_label else ""
        over = f"{self._model.x_name.lower() or 'time'} in {self._model.x_unit}"
        self.setAccessibleDescription(f"{of}{labels}, over {over}")

    def _on_preference(self, name: str) -> None:
        if name.endswith("_unit"):
            self._model.window.release_values()
            self._settle()
