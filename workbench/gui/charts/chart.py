"""A chart: legend, canvas and statistics of some curves, and the visible time window."""

import math
import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import NamedTuple

import numpy as np
from PyQt6.QtCore import QEvent, Qt, pyqtSignal
from PyQt6.QtGui import (
    QAction,
    QContextMenuEvent,
    QFocusEvent,
    QKeyEvent,
    QKeySequence,
    QShowEvent,
)
from PyQt6.QtWidgets import QMenu, QToolButton, QWidget

from workbench.common.errors import WorkbenchError
from workbench.gui.charts.canvas import Canvas
from workbench.gui.charts.content import Axis, Content, Guide, Line
from workbench.gui.charts.curve import Curve, CurveSet, Extent, Samples
from workbench.gui.charts.decimation import Peaks
from workbench.gui.charts.legend import Entry, Legend
from workbench.gui.charts.statistics import (
    HEADS,
    StatisticsTable,
    value_at,
    window_statistics,
)
from workbench.gui.charts.ticks import Scale, decimals_for, round_step
from workbench.gui.errands import Answers, single_shot
from workbench.gui.file_dialogs import clipboard
from workbench.gui.icons import icon
from workbench.gui.labels import menu_text, set_tip
from workbench.gui.layout import NO_MARGINS, hbox, vbox
from workbench.gui.preferences import Preferences, log_folder
from workbench.gui.style import dressed
from workbench.gui.theme import Look
from workbench.gui.units import Unit, unit_for
from workbench.gui.workspace import Workspace

SHORTEST = 0.02
"""Shortest time window [s]; of a logarithmic axis, in decades."""
LONGEST = 180.0
"""Longest time window that follows a flight [s]: the signals keep no more."""
WHOLE = 7200.0
"""Longest paused time window [s], for a long log."""
PATIENCE = 2.0
"""Time for which data must be small before the axis shrinks [s]."""
SHRINK = 0.5
"""Share of the range that data must leave free before the axis shrinks."""
PARTS = 5
"""Number of parts of a range for round ends."""
LEAST_DECADES = 0.1
"""Least number of decades of a logarithmic value axis."""
Ends = tuple[float, float]
STEP = 0.02
"""Step of the crosshair per arrow key, as a share of the window."""
PAGE = 0.25
"""Step of Page Up and Page Down, as a share of the window."""
ZOOM = 0.8
"""Zoom factor per key."""
IGNORED = 0x2200_0000
"""Qt's KeypadModifier and ShiftModifier: they do not change the meaning of a key."""


class Column(NamedTuple):
    """A column of a table: name, SI unit, times [s], and a value for each."""

    label: str
    unit: str
    time: np.ndarray
    values: np.ndarray


def table_text(columns: Sequence[Column], over: str, separator: str = "\t") -> str:
    """Return a line of names with units, then a line for each time with a sample.

    A curve without a sample at that time has an empty cell.

    Args:
        columns: columns of the table.
        over: name and unit of the first column, as time [s].
        separator: text between cells.
    """
    heads = [over, *(f"{each.label} [{each.unit or '1'}]" for each in columns)]
    lines = [separator.join(heads)]
    if columns:
        time = columns[0].time
        if any(each.time.shape != time.shape or (each.time != time).any() for each in columns[1:]):
            time = np.unique(np.concatenate([each.time for each in columns]))
        table = np.full((len(time), 1 + len(columns)), np.nan)
        table[:, 0] = time
        for index, each in enumerate(columns, 1):
            table[np.searchsorted(time, each.time), index] = each.values
        row = separator.join(["%.9g"] * table.shape[1])
        filled = "\n".join([row] * len(time)) % tuple(table.ravel().tolist())
        lines.append(filled.replace("nan", ""))
    return "\n".join(line for line in lines if line) + "\n"


def _write_file(path: Path, write: Callable[[Path], int]) -> Path:
    """Write a file, make its folder if necessary, and return its path.

    Args:
        path: path of the file.
        write: returns 0 if it has written nothing.

    Raises:
        WorkbenchError: if the file cannot be written.
    """
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        if not write(path):
            raise OSError("it cannot be written there")
    except OSError as error:
        reason = error.strerror or str(error)
        raise WorkbenchError(
            f"{path}: the chart was not saved: {reason}; choose another folder for logs in "
            "the settings"
        ) from error
    return path


class SteadyRange:
    """Round ends around data: they widen at once, and shrink only after some time.

    Args:
        smallest: shown range if the data hardly vary.
    """

    def __init__(self, smallest: float = 0.1) -> None:
        self._smallest = smallest
        self._ends: tuple[float, float] | None = None
        self._small_since = math.inf

    def follow(self, low: float, high: float, now: float) -> tuple[float, float]:
        """Return the ends for data between two values at a time [s]."""
        if not (math.isfinite(low) and math.isfinite(high)):
            return self._ends or (-1.0, 1.0)
        wanted = round_ends(low, high, self._smallest)
        if self._ends is None or low < self._ends[0] or high > self._ends[1]:
            kept = self._ends or wanted
            if self._ends is not None and wanted[1] - wanted[0] > SHRINK * (kept[1] - kept[0]):
                wanted = min(wanted[0], kept[0]), max(wanted[1], kept[1])
                wanted = round_ends(*wanted, self._smallest, room=0.0)
            self._ends, self._small_since = wanted, math.inf
        elif wanted[1] - wanted[0] <= SHRINK * (self._ends[1] - self._ends[0]):
            self._small_since = min(self._small_since, now)
            if now - self._small_since >= PATIENCE:
                self._ends, self._small_since = wanted, math.inf
        else:
            self._small_since = math.inf
        return self._ends


def round_ends(
    low: float, high: float, smallest: float = 0.0, room: float = 0.04
) -> tuple[float, float]:
    """Return round numbers around two values, with a margin of a share of the range."""
    span = max(high - low, smallest, 1e-9 * max(abs(low), abs(high)), 1e-12)
    middle, half = 0.5 * (low + high), 0.5 * span
    low, high = min(low, middle - half) - room * span, max(high, middle + half) + room * span
    step = 0.5 * round_step(high - low, PARTS)
    return step * math.floor(low / step + 1e-6), step * math.ceil(high / step - 1e-6)


class ChartWindow:
    """The visible part of the curves.

    Args:
        span: length of the time window that follows the flight [s].
        smallest: shown range of values if the data hardly vary.

    Attributes:
        span: length of the time window that follows the flight [s].
        with_zero: whether zero is always visible.
        x_scale: scale of the horizontal axis, for moving and zooming.
        y_scale: scale of the value axes.
    """

    def __init__(self, span: float, smallest: float) -> None:
        self.span = span
        self._smallest = smallest
        self.with_zero = False
        self.x_scale = self.y_scale = Scale.LINEAR
        self._still: Ends | None = None
        self._fixed: dict[int, Ends] = {}
        self._ranges: dict[int, SteadyRange] = {}

    @property
    def follows(self) -> bool:
        """Whether the window follows the newest samples."""
        return self._still is None

    def ends(self, now: float) -> Ends:
        """Return the first and last visible time [s]."""
        return self._still or (now - self.span, now)

    def stand(self, now: float) -> None:
        """Stop following."""
        self._still = self.ends(now)

    def follow(self) -> None:
        """Follow the newest samples; the axes follow the data."""
        self._still = None
        self.release_values()

    def show(self, left: float, right: float) -> None:
        """Stop at a time window [s]."""
        first, last = self.x_scale.place(left), self.x_scale.place(right)
        middle, half = 0.5 * (first + last), 0.5 * abs(last - first)
        half = min(max(half, 0.5 * SHORTEST), 0.5 * WHOLE)
        self._stay(middle - half, middle + half)

    def move(self, share: float, now: float) -> None:
        """Move by a share of the window."""
        first, last = self._places(now)
        way = share * (last - first)
        self._stay(first + way, last + way)

    def zoom_time(self, about: float, factor: float, now: float) -> None:
        """Scale the window by a factor; while it follows, the newest sample stays at the edge."""
        if self.follows:
            self.span = min(max(self.span * factor, 0.5), LONGEST)
            return
        first, last = self._places(now)
        factor = min(max((last - first) * factor, SHORTEST), WHOLE) / (last - first)
        at = self.x_scale.place(about)
        self._stay(at - (at - first) * factor, at + (last - at) * factor)

    def time_at(self, share: float, now: float) -> float:
        """Return the time at a share of the width [s]."""
        first, last = self._places(now)
        return self.x_scale.value_of(first + share * (last - first))

    def time_from(self, time: float, share: float, now: float) -> float:
        """Return the time that is a share of the width after another, within the window [s]."""
        first, last = self._places(now)
        place = self.x_scale.place(time) + share * (last - first)
        return self.x_scale.value_of(min(max(place, first), last))

    def _places(self, now: float) -> Ends:
        left, right = self.ends(now)
        return self.x_scale.place(left), self.x_scale.place(right)

    def _stay(self, first: float, last: float) -> None:
        """Stop between two positions."""
        self._still = self.x_scale.value_of(first), self.x_scale.value_of(last)

    def zoom_values(self, axes: Sequence[Ends], share: float, factor: float) -> None:
        """Scale the values of all axes by a factor, around a share of the height."""
        for index, ends in enumerate(axes):
            low, high = map(self.y_scale.place, ends)
            at = low + share * (high - low)
            self._fix(index, at - (at - low) * factor, at + (high - at) * factor)

    def cut_values(self, axes: Sequence[Ends], low: float, high: float) -> None:
        """Show the values between two shares of the height, on all axes."""
        if high - low > 0.98:
            return
        for index, ends in enumerate(axes):
            least, largest = map(self.y_scale.place, ends)
            span = largest - least
            self._fix(index, least + low * span, least + high * span)

    def _fix(self, axis: int, low: float, high: float) -> None:
        """Fix an axis between two positions."""
        self._fixed[axis] = self.y_scale.value_of(low), self.y_scale.value_of(high)

    def values(self, axis: int, low: float, high: float, now: float) -> Ends:
        """Return the shown ends of an axis with data between two values."""
        if axis in self._fixed:
            return self._fixed[axis]
        if self.y_scale is Scale.LOGARITHMIC:
            kept = self._ranges.setdefault(axis, SteadyRange(LEAST_DECADES))
            first, last = kept.follow(self.y_scale.place(low), self.y_scale.place(high), now)
            return self.y_scale.value_of(first), self.y_scale.value_of(last)
        if self.with_zero and math.isfinite(low):
            low, high = min(low, 0.0), max(high, 0.0)
        return self._ranges.setdefault(axis, SteadyRange(self._smallest)).follow(low, high, now)

    def release_values(self) -> None:
        """Let the axes follow the data again."""
        self._fixed.clear()
        self.forget_ranges()

    def forget_ranges(self) -> None:
        """Recompute the ends of the axes that follow the data."""
        self._ranges.clear()


class ChartModel:
    """Curves, and the window that shows them.

    Args:
        preferences: source of units.
        look: source of colours.
        smallest: shown range of values if the data hardly vary.

    Attributes:
        curves: the shown curves.
        window: visible part of them.
        now: newest time [s].
        marks: times of cursors A and B [s], by name.
        times_ago: whether times are shown as ages.
        x_name: name of the horizontal quantity if it is not time; "" if the unit says enough.
        x_unit: its unit.
        y_label: name of the values, "" for none.
        guides: straight lines below the curves.
        caption: text above the picture.
        hint: text without any curves.
        note: word over a paused picture.
    """

    def __init__(self, preferences: Preferences, look: Look, smallest: float) -> None:
        self._preferences = preferences
        self._look = look
        self.curves = CurveSet()
        self.window = ChartWindow(preferences.number("chart_seconds"), smallest)
        self.now = 0.0
        self.marks: dict[str, float] = {}
        self.guides: tuple[Guide, ...] = ()
        self.caption = ""
        self.times_ago = False
        self.x_name, self.x_unit, self.y_label = "", "s", ""
        self.hint = self.note = ""
        self._axes: tuple[Axis, ...] = ()

    @property
    def ends(self) -> tuple[float, float]:
        """First and last visible time [s]."""
        return self.window.ends(self.now)

    @property
    def over(self) -> str:
        """The horizontal quantity, with its unit, as time [s]."""
        return f"{self.x_name.lower() or 'time'} [{self.x_unit}]"

    @property
    def mark_heads(self) -> list[str]:
        """Headings of the columns with values at cursors A and B."""
        text, unit, marks = self.window.x_scale.text, self.x_unit, self.marks
        heads = [f"{name} at {text(marks[name], 3)} {unit}" for name in sorted(marks)]
        if len(marks) == 2:
            heads.append(f"B − A over {text(marks['B'] - marks['A'], 3)} {unit}")
            heads.append(f"Slope per {unit}")
        return heads

    def set_scales(self, x: Scale, y: Scale) -> None:
        """Set the scales of the axes."""
        self.window.x_scale, self.window.y_scale = x, y
        self.window.release_values()
        for curve in self.curves:
            curve.peaks = Peaks()

    @property
    def axis_ends(self) -> Sequence[tuple[float, float]]:
        """The axes' ends in the last content, as shown."""
        return [(axis.low, axis.high) for axis in self._axes]

    def show_axes(self, axes: tuple[Axis, ...]) -> None:
        """Set the axes of the last content."""
        self._axes = axes

    def stand(self) -> None:
        """Keep the present samples, even if their source drops them."""
        if self.window.follows:
            for curve in self.curves:
                curve.freeze()
            self.window.stand(self.now)

    def follow(self) -> None:
        """Show the newest samples again."""
        for curve in self.curves:
            curve.thaw()
        self.window.follow()
        self.window.span = self._preferences.number("chart_seconds")

    def content(self, columns: int) -> Content:
        """Return the content to draw in a number of pixel columns."""
        left, right = self.ends
        units = self.curves.units
        extents = [Extent() for _ in units]
        x_scale, y_scale = self.window.x_scale, self.window.y_scale
        ends = x_scale.place(left), x_scale.place(right)
        lines = []
        for curve in self.curves:
            if curve.visible:
                time, values = self._drawn(curve)
                places, values = curve.peaks.reduce(
                    x_scale.places(time), y_scale.known(values), *ends, columns
                )
                time = x_scale.values_of(places)
                axis = units.index(curve.axis_unit)
                values = extents[axis].take(values)
                colour = self._look.curve(curve.colour)
                lines.append(Line(time, values, axis, colour, curve.style, self._number(curve)))
        self._axes = tuple(
            self._axis(index, unit, extent)
            for index, (unit, extent) in enumerate(zip(units, extents, strict=True))
        )
        ago = self.window.follows and self.times_ago
        return Content(
            left=left,
            right=right,
            origin=right if ago else 0.0,
            x_label="s from now" if ago else f"{self.x_name} {self.x_unit}".strip(),
            x_unit=self.x_unit,
            x_scale=x_scale,
            y_scale=y_scale,
            axes=self._axes or (Axis(Unit(""), y_scale.value_of(0.0), y_scale.value_of(1.0)),),
            lines=tuple(lines),
            guides=self.guides,
            caption=self.caption,
            marks=tuple(sorted(self.marks.items())),
            state="" if self.window.follows else self.note,
            hint="All curves are hidden" if len(self.curves) else self.hint,
        )

    def entries(self, when: float | None) -> list[Entry]:
        """Return the legend, with values at a time [s]; if None, with the differences between
        cursors A and B, or, without them, with the newest values.
        """
        made = []
        between = when is None and len(self.marks) == 2
        for curve in self.curves:
            time, values = self._seen(curve)
            unit, decimals = self._shown_in(curve)
            if when is not None:
                value = value_at(time, values, when)
            elif between:
                before, after = (value_at(time, values, self.marks[name]) for name in "AB")
                value = after - before
            else:
                value = float(values[-1]) if len(values) else np.nan
            number_text = self.window.y_scale.text(unit.shown(value), decimals)
            sign = "Δ\N{NO-BREAK SPACE}" if between else ""
            text = f"{sign}{number_text}\N{NO-BREAK SPACE}{unit.symbol}"
            colour = self._look.curve(curve.colour)
            number = self._number(curve)
            entry = Entry(curve.label, text.strip(), colour, curve.style, number, curve.visible)
            made.append(entry)
        return made

    def statistics(self) -> list[list[str]]:
        """Return the texts of the table's row of each visible curve."""
        rows = []
        for curve in self.curves:
            if not curve.visible:
                continue
            time, values = self._seen(curve)
            marks = [value_at(time, values, at) for _, at in sorted(self.marks.items())]
            numbers = [*window_statistics(time, values, *self.ends), *marks]
            if len(marks) == 2:
                change, between = marks[1] - marks[0], self.marks["B"] - self.marks["A"]
                numbers += [change, change / between if between else math.nan]
            unit, decimals = self._shown_in(curve)
            text = self.window.y_scale.text
            shown = (text(unit.shown(value), decimals + 1) for value in numbers)
            rows.append([curve.label, unit.symbol or "–", *shown])
        return rows

    def columns(self) -> tuple[Column, ...]:
        """Return the visible samples in SI units, as views that must be used at once."""
        return tuple(
            Column(curve.label, curve.unit, *self._seen(curve))
            for curve in self.curves
            if curve.visible
        )

    def _drawn(self, curve: Curve) -> Samples:
        """Return the samples in the window; if paused, with the next one after it."""
        left, right = self.ends
        time, values = curve.samples(left)
        last = int(np.searchsorted(time, right, side="right")) + (not self.window.follows)
        first = 0
        if self.window.x_scale is Scale.LOGARITHMIC:
            first = int(np.searchsorted(time, 0.0, side="right"))
        return time[first:last], values[first:last]

    def _seen(self, curve: Curve) -> Samples:
        """Return the samples in the window."""
        left, right = self.ends
        time, values = curve.samples(left)
        first = int(np.searchsorted(time, left))
        last = int(np.searchsorted(time, right, side="right"))
        return time[first:last], values[first:last]

    def _number(self, curve: Curve) -> int:
        return curve.number if len(self.curves) > 1 and curve.colour >= 0 else 0

    def _axis(self, index: int, si: str, extent: Extent) -> Axis:
        unit = unit_for(si, self._preferences)
        low, high = unit.shown(extent.low), unit.shown(extent.high)
        return Axis(unit, *self.window.values(index, low, high, self.now), self.y_label)

    def _shown_in(self, curve: Curve) -> tuple[Unit, int]:
        """Return unit and decimals for a curve's values."""
        index = self.curves.units.index(curve.axis_unit)
        unit = unit_for(curve.unit, self._preferences)
        span = self._axes[index].high - self._axes[index].low if index < len(self._axes) else 1.0
        return unit, decimals_for(span)


@dataclass(frozen=True)
class Command:
    """A command of a chart.

    Attributes:
        text: its text in the menu, "" for a key alone.
        key: keys as Qt writes them, separated by spaces, "" for none.
        do: the function to call; takes the new state if it is a switch.
        checked: whether it is on, None if it is not a switch.
    """

    text: str
    key: str
    do: Callable[[bool], object]
    checked: bool | None = None


SEPARATOR = Command("-", "", bool)


class Chart(QWidget):
    """Shows curves over time.

    Wheel: time; with Ctrl, or over an axis: values. Drag: zoom to a box. Double click, Escape or
    Home: undo zooming. Arrows: crosshair. Page Up and Page Down: move. A, B: fixed cursors, which
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
        self._answers = Answers(workspace.notices.warn, self)
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
        self.legend.toggled.connect(self.toggle_curve)
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
    def curves(self) -> tuple[Curve, ...]:
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

    def set_guides(self, guides: Sequence[Guide], caption: str = "") -> None:
        """Draw straight lines below the curves, as margins; replaces the last ones.

        Args:
            guides: the lines.
            caption: text above the picture that explains them.
        """
        self._model.guides, self._model.caption = tuple(guides), caption
        self._soon.start()

    def toggle_curve(self, index: int) -> None:
        """Hide or show a curve."""
        curve = self._model.curves[index]
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

    def columns(self) -> tuple[Column, ...]:
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
        columns = self.columns()
        kept = [each._replace(time=each.time.copy(), values=each.values.copy()) for each in columns]
        over = self._model.over
        self._write("csv", lambda path: path.write_text(table_text(kept, over, ","), "utf-8"))

    def _write(self, suffix: str, write: Callable[[Path], int]) -> None:
        """Write a file to the folder for logs, named after the chart and the time of day."""
        title = self.title.lower()
        name = "".join(each if each.isalnum() else "_" for each in title) or "chart"
        folder = log_folder(self._workspace.preferences).absolute()
        path = folder / f"{name}_{time.strftime('%Y%m%d_%H%M%S')}.{suffix}"
        self._answers.expect(
            self._workspace.errands.run(partial(_write_file, path, write)),
            lambda path: self._workspace.notices.inform(f"Saved {path}"),
        )

    def make_menu(self) -> QMenu:
        """Return a menu that is deleted when it is closed."""
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
                name = menu_text(curve.label)
                _add(curves, Command(name, "", self._toggle(index), curve.visible))
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
        pressed = QKeySequence(event.keyCombination().toCombined() & ~IGNORED).toString()
        for command in self._commands():
            if pressed and pressed in command.key.split():
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

    def _commands(self) -> list[Command]:
        """Return the commands, in the order of the menu."""
        zero = Command("Always show zero", "Z", self.set_zero_shown, self.is_zero_shown)
        return [
            Command("Statistics", "S", self.set_statistics_shown, self.are_statistics_shown),
            *([zero] if self._model.window.y_scale is Scale.LINEAR else []),
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
        """Add a button before the others beside the legend."""
        button = dressed(QToolButton(), "quiet small")
        button.setAccessibleName(name)
        button.setAccessibleDescription(help)
        set_tip(button, help)
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
            heads = HEADS | {mark: mark for mark in self._model.mark_heads}
            self.statistics.show_table(heads, self._model.statistics())

    def _entries(self) -> list[Entry]:
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


def _add(menu: QMenu, command: Command) -> None:
    """Add an action; the chart itself handles the key, which is only shown here."""
    key = command.key.partition(" ")[0]
    action = QAction(f"{command.text}\t{key}" if key else command.text, menu)
    if command.checked is not None:
        action.setCheckable(True)
        action.setChecked(command.checked)
    action.triggered.connect(command.do)
    menu.addAction(action)
