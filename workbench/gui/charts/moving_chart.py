"""A chart whose picture follows time, or stands still: what is seen of it, and its cursors."""

import numpy as np
from PyQt6.QtCore import QTimer, pyqtSignal
from PyQt6.QtWidgets import QVBoxLayout, QWidget

from workbench.gui.charts.canvas import Canvas
from workbench.gui.charts.chart_head import ChartHead
from workbench.gui.charts.chart_picture import ChartPicture
from workbench.gui.charts.statistics_table import StatisticsTable
from workbench.gui.workspace import Workspace

READ_EVERY = 0.2
"""Digits that change faster cannot be read [s of what is shown]."""


class MovingChart(QWidget):
    """Head, canvas and statistics, and the part of time that they show.

    Args:
        workspace: colours, units and preferences.
        parent: whose life it shares.

    Attributes:
        head: title, legend and buttons.
        canvas: where curves are painted.
        statistics: table below.
    """

    picture_changed = pyqtSignal()
    """It stands still, follows again, or shows other curves."""

    def __init__(self, workspace: Workspace, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self._workspace = workspace
        self._picture = ChartPicture(workspace.preferences, workspace.look)
        self._read = self._built = -np.inf
        self._column = 0.0
        self._phase = id(self) // 64 % 8 / 8  # charts do not all build in the same frame
        self._soon = QTimer(self)  # several curves are added in one go
        self._soon.setSingleShot(True)
        self._soon.timeout.connect(lambda: self.redraw() if self.isVisible() else None)
        self.head = ChartHead(workspace.look)
        self.canvas = Canvas(workspace.look)
        self.statistics = StatisticsTable()
        self.statistics.hide()
        box = QVBoxLayout(self)
        box.setContentsMargins(0, 0, 0, 0)
        box.setSpacing(2)
        box.addWidget(self.head)
        box.addWidget(self.canvas, 1)
        box.addWidget(self.statistics)
        self.canvas.hovered.connect(self.set_cursor)
        self.canvas.turned.connect(self._turn)
        self.canvas.boxed.connect(self._box)
        self.canvas.reset_wanted.connect(self.follow)
        self.canvas.resized.connect(lambda: self.redraw() if self.isVisible() else None)
        self.head.pause.clicked.connect(self.set_paused)
        workspace.preferences.changed.connect(self._on_preference)

    def refresh(self, now: float) -> None:
        """Draw the seconds until a time [s], unless it is paused or nobody sees it."""
        self._picture.now = now
        if self.is_paused or not self.isVisible() or self.visibleRegion().isEmpty():
            return
        if self._built <= now < self._built + self._column:
            self.canvas.move_on(*self._picture.ends)  # no column of pixels is full yet
        else:
            self._draw()
        if not self._read <= now < self._read + READ_EVERY:
            self._read = now
            self._show_numbers()

    def redraw(self) -> None:
        """Draw anew, and write all numbers."""
        self._draw()
        self._read = self._picture.now
        self._show_numbers()

    def set_paused(self, paused: bool) -> None:
        """Let the picture stand still, or follow; the flight goes on."""
        if paused:
            self._picture.note = "PAUSED"
            self._picture.stand()
            self._settle()
        else:
            self.follow()

    @property
    def is_paused(self) -> bool:
        """Whether the picture stands still."""
        return not self._picture.window.follows

    def follow(self) -> None:
        """Show the newest seconds again."""
        self._picture.follow()
        self._settle()

    def show_window(self, left: float, right: float) -> None:
        """Stand still at a part of time [s]."""
        self._stand("ZOOMED")
        self._picture.window.show(left, right)
        self._settle()

    @property
    def window_ends(self) -> tuple[float, float]:
        """First and last time that are seen [s]."""
        return self._picture.ends

    def set_zero_shown(self, shown: bool) -> None:
        """Show zero always, or only where the data are near it."""
        self._picture.window.with_zero = shown
        self._picture.window.forget_ranges()
        self._settle()

    @property
    def is_zero_shown(self) -> bool:
        """Whether zero is always seen."""
        return self._picture.window.with_zero

    def show_clock_times(self) -> None:
        """Write times as they are, in place of how long ago they are; for what is no flight."""
        self._picture.times_ago = False

    def show_times_ago(self) -> None:
        """Write how long ago samples are."""
        self._picture.times_ago = True

    def set_hint(self, hint: str) -> None:
        """Say what is to be done where there are no curves."""
        self._picture.hint = hint

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
        self._picture.marks[name] = time
        self.set_statistics_shown(True)

    def clear_marks(self) -> None:
        """Take cursors A and B away."""
        self._picture.marks.clear()
        self._settle()

    def move_by(self, share: float) -> None:
        """Stand still, a share of the window later than now."""
        self._stand("PAUSED")
        self._picture.window.move(share, self._picture.now)
        self._settle()

    def zoom_by(self, factor: float) -> None:
        """Show a factor of the time, about the crosshair."""
        about = self.window_ends[1] if self.cursor_time is None else self.cursor_time
        self._picture.window.zoom_time(about, factor, self._picture.now)
        self._settle()

    def step_cursor(self, share: float) -> None:
        """Move the crosshair by a share of the window; it begins at the newest sample."""
        self.canvas.forget_mouse()
        left, right = self.window_ends
        at = right if self.cursor_time is None else self.cursor_time
        self.set_cursor(min(max(at + share * (right - left), left), right))

    def _stand(self, note: str) -> None:
        if not self.is_paused or note == "ZOOMED":
            self._picture.note = note
        self._picture.stand()

    def _turn(self, time: float, share: float, factor: float, values: bool) -> None:
        window = self._picture.window
        if values:
            window.zoom_values(self._picture.axis_ends, share, factor)
        else:
            window.zoom_time(time, factor, self._picture.now)
        self._settle()

    def _box(self, left: float, right: float, low: float, high: float) -> None:
        self._stand("ZOOMED")
        self._picture.window.show(left, right)
        self._picture.window.cut_values(self._picture.axis_ends, low, high)
        self._settle()

    def _settle(self) -> None:
        self.head.pause.setChecked(self.is_paused)
        if self.isVisible():
            self.redraw()
        self.picture_changed.emit()

    def _draw(self) -> None:
        columns = self.canvas.columns_for(self.canvas.layout_for(len(self._picture.curves.units)))
        left, right = self._picture.ends
        first = self._built == -np.inf
        self._column = (right - left) / columns * (self._phase if first else 1.0)
        self._built = self._picture.now
        self.canvas.show_scene(self._picture.scene(columns))

    def _show_numbers(self) -> None:
        self.head.legend.show_entries(self._picture.entries(self.cursor_time))
        if self.are_statistics_shown:
            self.statistics.show_rows(self._picture.statistics(), self._picture.marks)

    def _on_preference(self, name: str) -> None:
        if name == "chart_seconds" and not self.is_paused:
            self._picture.window.span = self._workspace.preferences.number(name)
        if name.endswith("_unit"):
            self._picture.window.follow_units()
            self.head.legend.forget_widths()
        if name == "chart_seconds" or name.endswith("_unit"):
            self._settle()
