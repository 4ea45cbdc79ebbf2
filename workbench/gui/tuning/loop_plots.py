"""Plots of a loop over frequency: Bode, Nyquist, gang of four, and phase budget."""

import math
from collections.abc import Callable, Sequence

import numpy as np
from PyQt6.QtCore import QSize, pyqtSignal
from PyQt6.QtGui import QColor, QMouseEvent, QResizeEvent, QShowEvent
from PyQt6.QtWidgets import QLayout, QWidget

from workbench.analysis.replies import Judged, JudgedLoop
from workbench.design.judge.margins import LoopMargins
from workbench.gui.charts.canvas import Canvas
from workbench.gui.charts.content import Axis, Content, Guide, Line, Point
from workbench.gui.charts.curve import CurveStyle
from workbench.gui.charts.plots import StaticPlot
from workbench.gui.charts.ticks import Scale, number_text
from workbench.gui.layout import NO_MARGINS, grid, vbox
from workbench.gui.tuning.card import SPACING, wrapped
from workbench.gui.tuning.drawn_loop import (
    DrawnLoop,
    Mark,
    counting,
    decibel,
    gain_margin_mark,
    peak,
    phase_margin_mark,
    unwrapped,
)
from workbench.gui.tuning.judgement import Judgement
from workbench.gui.tuning.limits import Limit, Limits, find_limit
from workbench.gui.tuning.margins_card import (
    LimitOf,
    loop_label,
    margins_headline,
    short_label,
    weakest_loop,
)
from workbench.gui.tuning.number_table import Cell, NumberTable, Row, State
from workbench.gui.units import Unit
from workbench.gui.workspace import Workspace

EVERYWHERE = (-math.inf, math.inf)
GAIN, REDUCTION, PHASE = map(find_limit, ("gain_margin", "gain_reduction_margin", "phase_margin"))
LOW = 150
"""Least height of a legible plot [px]."""
LOWEST = 120
"""The same of plots side by side in a low window [px]."""
MIDDLE, HALF = (-0.8, 0.0), 2.4
"""Initial centre and half height of the picture, as in `workbench judge`."""
SPANS = (0.02, 200.0)
"""Smallest and largest half height."""
WIDEST = 60.0
"""Largest extent of a drawn disk; its edge is then almost straight."""
CROSS = 0.03
"""Half the size of the mark at -1, as a share of the height."""
NEAR = 0.08
"""Largest distance from the mouse at which a curve is read, as a share of the height."""
DISK = find_limit("disk_margin")
TURN = np.linspace(0.0, 2.0 * np.pi, 181)
LAW = "law"
PARTS = {
    LAW: "the gains and the rigid body itself, as if all else were instantaneous",
    "filters": "the low-passes and the notch: gyro, setpoint and derivative",
    "estimator": "flying on an estimate instead of the true motion",
    "delay": "late readings, late commands, and the physics step by which these act",
    "hold": "a command is held for a control period, so it is half a period late on average",
    "rotors": "rotors take time to speed up and slow down",
}
"""Descriptions of the parts of a phase, by their names in `JudgedLoop.turned`."""
ABSENT = {
    "filters": "No filter is on.",
    "estimator": "No estimator flies: the loops have the true motion.",
}
"""Text for a part that affects no loop."""
HEADS = {"estimator": "estim."}
"""Short headings for a narrow window."""
LEAST = 1e-9
"""Smaller angles count as zero [rad]."""
ROWS = 9
"""Number of rows to expect before they are known."""


class FrequencyPlots(QWidget):
    """Plots over a common frequency axis, with a common cursor.

    Args:
        workspace: source of colours.
        titles: titles in order.

    Attributes:
        plots: the plots, in order.
    """

    pointed = pyqtSignal(object)
    """Frequency under the mouse [rad/s], None when it has left."""

    def __init__(self, workspace: Workspace, titles: Sequence[str]) -> None:
        super().__init__()
        self._linking = False
        self.plots = tuple(StaticPlot(workspace) for _ in titles)
        self._box = grid(of=self, margins=NO_MARGINS, spacing=(2, 2))
        self._columns = 0
        for plot, title in zip(self.plots, titles, strict=True):
            plot.setMinimumHeight(LOW)
            plot.set_hint("Not known yet: the analyst is computing it")
            plot.show_head(False)
            plot.set_title(title)
            plot.cursor_moved.connect(self.pointed)
            plot.picture_changed.connect(lambda plot=plot: self._link(plot))
        self._arrange(2)

    def _arrange(self, columns: int) -> None:
        """Arrange the plots in this many columns."""
        if columns == self._columns:
            return
        self._columns = columns
        for place, plot in enumerate(self.plots):
            self._box.addWidget(plot, place // columns, place % columns)

    def set_cursor(self, frequency: float | None) -> None:
        """Set the cursor of all plots to a frequency [rad/s], or remove it."""
        for plot in self.plots:
            if plot.cursor_time != frequency:
                plot.set_cursor(frequency)

    def show_window(self, left: float, right: float) -> None:
        """Show the frequencies between two [rad/s]."""
        for plot in self.plots:
            plot.set_window(left, right)

    def _link(self, plot: StaticPlot) -> None:
        """Zoom all plots to the frequencies of one."""
        if self._linking:
            return
        self._linking = True
        for other in self.plots:
            if other is not plot and other.window_ends != plot.window_ends:
                other.set_window(*plot.window_ends)
        self._linking = False


class BodePlots(FrequencyPlots):
    """Magnitude and phase of L, with crossover and margins.

    Args:
        workspace: source of colours.
        high: least height at which the phase is below the magnitude [px].
    """

    def __init__(self, workspace: Workspace, high: int = 2 * LOW) -> None:
        super().__init__(workspace, ("Magnitude of L", "Phase of L"))
        self._high = high
        magnitude, phase = self.plots
        magnitude.set_axes("Frequency", "Magnitude", "dB", "rad/s")
        phase.set_axes("Frequency", "Phase", "°", "rad/s")
        for plot in self.plots:
            plot.set_scales(Scale.LOGARITHMIC)
            plot.setMinimumHeight(LOWEST)
        # one below the other they may become lower again, or they would stay so
        self._box.setSizeConstraint(QLayout.SizeConstraint.SetNoConstraint)

    def minimumSizeHint(self) -> QSize:
        """Return the size of both plots side by side."""
        return QSize(320, LOWEST)

    def resizeEvent(self, event: QResizeEvent | None) -> None:
        """Arrange the plots in one column if the height allows it, else in two."""
        super().resizeEvent(event)
        self._arrange(1 if self.height() >= self._high else 2)

    def show_loops(self, loops: Sequence[DrawnLoop]) -> None:
        """Draw loops, with the margins of the proposed gains, or else of the flown ones."""
        magnitude, phase = self.plots
        now = counting(loops)
        names = []
        for loop in loops:
            size = decibel(loop.open_loop)
            about = now.crossover if now is not None else math.nan
            turn = np.degrees(unwrapped(loop.frequency, loop.open_loop, about))
            spread = loop.deviation
            bands = [("", size, turn, loop.style)]
            if len(spread):
                for sign, name in ((1.0, " +σ"), (-1.0, " −σ")):
                    wide = 20.0 * np.log10(np.maximum(1.0 + sign * spread, 1e-3))
                    turned = sign * np.degrees(np.arcsin(np.minimum(spread, 1.0)))
                    bands.append((name, size + wide, turn + turned, CurveStyle.FAINT))
            for name, sizes, turns, style in bands:
                names.append(loop.name + name)
                for plot, values in ((magnitude, sizes), (phase, turns)):
                    plot.set_curve(loop.name + name, loop.frequency, values, style, loop.colour)
        for plot in self.plots:
            keep(plot, names)
        for plot, shown in zip(self.plots, margin_guides(now), strict=True):
            plot.set_guides(*shown)


Shown = tuple[list[Guide], str]
"""Lines in a plot, and their caption."""


def margin_guides(loop: DrawnLoop | None) -> tuple[Shown, Shown]:
    """Return crossover and margins in the plots of magnitude and phase."""
    sizes, turns = [Guide(EVERYWHERE, (0.0, 0.0))], [Guide(EVERYWHERE, (-180.0, -180.0))]
    if loop is None or loop.margins is None or not loop.margins.stable:
        return (sizes, ""), (turns, "")
    margins, said, turned = loop.margins, [], ""
    if math.isfinite(margins.crossover):
        sizes.append(Guide((margins.crossover,) * 2, EVERYWHERE))
        said.append(f"{margins.crossover:.3g} rad/s")
    at = phase_margin_mark(loop)
    if at is not None:
        degrees = math.degrees(at[1])
        level = 360.0 * round((degrees - 180.0) / 360.0) + 180.0
        turns = [
            Guide(EVERYWHERE, (level, level)),
            Guide((at[0],) * 2, (level, degrees), "warning"),
        ]
        turned = _words(PHASE, margins)
    for limit in (GAIN, REDUCTION):
        mark = gain_margin_mark(loop, getattr(margins, limit.name))
        if mark is not None:
            frequency, size = mark
            sizes.append(Guide((frequency, frequency), (size, 0.0), "warning"))
            turns.append(Guide((frequency, frequency), EVERYWHERE))
            said.append(_words(limit, margins))
    return (sizes, ", ".join(said)), (turns, turned)


def _words(limit: Limit, margins: LoopMargins) -> str:
    """Return a margin with its unit, as in the table of margins."""
    glue = "" if limit.unit == "°" else " "
    return f"{limit.short} {limit.text(getattr(margins, limit.name))}{glue}{limit.unit}"


def keep(plot: StaticPlot, names: Sequence[str]) -> None:
    """Keep only the curves of these names, in this order, which determines their numbers."""
    if plot.names != tuple(names):
        curves = {each.label: each for each in plot.curves}
        plot.clear()
        for name in names:
            each = curves[name]
            plot.set_curve(name, *each.samples(-math.inf), each.style, each.colour)


Response = Callable[[DrawnLoop], np.ndarray]
FOUR: tuple[tuple[str, str, Response], ...] = (
    ("S", "Ms", lambda loop: loop.sensitivity),
    ("T", "Mt", lambda loop: loop.open_loop * loop.sensitivity),
    ("KS", "peak", lambda loop: loop.control_sensitivity),
    ("GS", "peak", lambda loop: loop.load_sensitivity),
)
"""Name, name of the peak, and the loop's response."""


class GangPlots(FrequencyPlots):
    """Magnitudes of S, T, KS and GS, each with its peak."""

    def __init__(self, workspace: Workspace) -> None:
        super().__init__(
            workspace,
            (
                "S, sensitivity",
                "T, complementary sensitivity",
                "KS, control sensitivity",
                "GS, load sensitivity",
            ),
        )
        self.name_units("1", "1")
        for plot in self.plots:
            plot.set_scales(Scale.LOGARITHMIC, Scale.LOGARITHMIC)

    def name_units(self, control: str, load: str) -> None:
        """Show the units of KS and GS."""
        units = "1", "1", control, load
        for plot, (name, _, _), unit in zip(self.plots, FOUR, units, strict=True):
            plot.set_axes("Frequency", name, unit, "rad/s")

    def show_loops(self, loops: Sequence[DrawnLoop]) -> None:
        """Draw loops, with the peaks of the proposed gains, or else of the flown ones."""
        now = counting(loops)
        for plot, (_, what, response) in zip(self.plots, FOUR, strict=True):
            shown: Shown = ([], "")
            names = []
            for loop in loops:
                values = np.abs(response(loop))
                if not len(values):
                    continue
                names.append(loop.name)
                plot.set_curve(loop.name, loop.frequency, values, loop.style, loop.colour)
                if loop is now:
                    shown = peak_guide(what, peak(loop.frequency, values))
            keep(plot, names)
            plot.set_guides(*shown)


def peak_guide(what: str, mark: Mark) -> Shown:
    """Return lines at a peak, with its magnitude and frequency."""
    frequency, size = mark
    lines = [
        Guide(EVERYWHERE, (size, size), "warning"),
        Guide((frequency, frequency), EVERYWHERE),
    ]
    if what == "peak":  # its unit replaces its frequency for lack of room
        return lines, f"peak {size:.4g}"
    return lines, f"{what} {size:.3g} at {frequency:.3g} rad/s"


class Plane(Canvas):
    """A canvas that reports the complex number under the mouse."""

    pointed = pyqtSignal(object)
    """A complex number, None when the mouse has left."""

    def mouseMoveEvent(self, event: QMouseEvent | None) -> None:
        """Report the position of the mouse."""
        if event is None:
            return
        place = self._scene_point(event.position())
        inside = self.view.sceneBoundingRect().contains(place)
        at = self.view.mapSceneToView(place)
        self.pointed.emit(complex(at.x(), at.y()) if inside else None)


class NyquistPlot(QWidget):
    """Draws open loops in the complex plane. Wheel: zoom around the mouse. Double click: all.

    Args:
        workspace: source of colours.

    Attributes:
        canvas: the drawing area.
    """

    pointed = pyqtSignal(object)
    """Frequency of the curve under the mouse [rad/s], None without one."""

    def __init__(self, workspace: Workspace) -> None:
        super().__init__()
        self._look = workspace.look
        self._loops: tuple[DrawnLoop, ...] = ()
        self._cursor: float | None = None
        self._middle, self._half = MIDDLE, HALF
        self.canvas = Plane(workspace.look)
        self.setAccessibleName("Nyquist curve of the loop, with the disk of the disk margin")
        vbox(self.canvas, of=self, margins=NO_MARGINS)
        self.canvas.pointed.connect(self._point)
        self.canvas.turned.connect(self._turn)
        self.canvas.boxed.connect(self._box)
        self.canvas.reset_wanted.connect(self.reset)
        self.canvas.resized.connect(self._draw)

    def show_loops(self, loops: Sequence[DrawnLoop]) -> None:
        """Draw loops."""
        self._loops = tuple(loops)
        self._draw()

    def show_window(self, left: float, right: float) -> None:
        """Do nothing: the plane has no frequency axis."""

    def set_cursor(self, frequency: float | None) -> None:
        """Mark a frequency [rad/s] on all curves, or none."""
        if frequency != self._cursor:
            self._cursor = frequency
            self._draw()

    def reset(self) -> None:
        """Show the surroundings of -1."""
        self._middle, self._half = MIDDLE, HALF
        self._draw()

    def _turn(self, x: float, share: float, factor: float, _: bool) -> None:
        half = min(max(self._half * factor, SPANS[0]), SPANS[1])
        factor = half / self._half
        y = self._middle[1] + (2.0 * share - 1.0) * self._half
        self._middle = (
            x + (self._middle[0] - x) * factor,
            y + (self._middle[1] - y) * factor,
        )
        self._half = half
        self._draw()

    def _box(self, left: float, right: float, low: float, high: float) -> None:
        bottom = self._middle[1] - self._half
        ends = [bottom + 2.0 * self._half * share for share in (low, high)]
        tall = max(ends[1] - ends[0], (right - left) / self._aspect)
        self._middle = 0.5 * (left + right), 0.5 * (ends[0] + ends[1])
        self._half = min(max(0.5 * tall, SPANS[0]), SPANS[1])
        self._draw()

    def _point(self, place: complex | None) -> None:
        """Report the frequency of the curve nearest to the mouse."""
        found: tuple[float, float | None] = (NEAR * 2.0 * self._half, None)
        for loop in self._loops if place is not None else ():
            way = np.abs(loop.open_loop - place)
            if np.isfinite(way).any():
                nearest = int(np.nanargmin(way))
                if way[nearest] < found[0]:
                    found = float(way[nearest]), float(loop.frequency[nearest])
        self.pointed.emit(found[1])

    @property
    def _aspect(self) -> float:
        view = self.canvas.view
        return max(view.width(), 1.0) / max(view.height(), 1.0)

    def _draw(self) -> None:
        if not self.isVisible():
            return
        (x, y), half = self._middle, self._half
        wide = half * self._aspect
        plain = Unit("")
        self.canvas.show_content(
            Content(
                left=x - wide,
                right=x + wide,
                x_label="Re",
                x_unit="",
                axes=(Axis(plain, y - half, y + half, "Im"),),
                lines=tuple(self._lines()),
                points=tuple(self._points()),
                guides=(Guide((-math.inf, math.inf), (0.0, 0.0)),),
                caption=self._caption,
                hint="" if self._loops else "Not known yet: the analyst is computing it",
            )
        )

    def showEvent(self, event: QShowEvent | None) -> None:
        """Draw changes made while it was hidden."""
        self._draw()

    @property
    def _disk_margin(self) -> float:
        """Disk margin of the loop whose margins are drawn; 0 if unstable."""
        loop = counting(self._loops)
        return loop.margins.disk_margin if loop is not None and loop.margins is not None else 0.0

    @property
    def _caption(self) -> str:
        if counting(self._loops) is None:
            return ""
        margin = self._disk_margin
        return f"disk {DISK.text(margin)}" if margin else "unstable"

    def _lines(self) -> list[Line]:
        look = self._look
        lines = [Line(np.cos(TURN), np.sin(TURN), 0, look.colour("muted"), CurveStyle.DASHED)]
        if self._disk_margin:
            lines.append(Line(*disk(self._disk_margin), 0, look.colour("bad")))
        for loop in self._loops:
            colour, response = look.curve(loop.colour), loop.open_loop
            mirrored = Line(response.real, -response.imag, 0, colour, CurveStyle.FAINT)
            lines += [mirrored, Line(response.real, response.imag, 0, colour, loop.style)]
        lines.append(_cross(complex(-1.0, 0.0), CROSS * 2.0 * self._half, look.colour("bad")))
        return lines

    def _points(self) -> list[Point]:
        """Return the points of the curves at the cursor."""
        if self._cursor is None:
            return []
        found = [(loop.at(self._cursor, loop.open_loop), loop.colour) for loop in self._loops]
        return [Point(at.real, at.imag, 0, self._look.curve(colour)) for at, colour in found]


def _cross(at: complex, size: float, colour: QColor) -> Line:
    """Return a cross at a point with a half size."""
    x = np.array([at.real - size, at.real + size, np.nan, at.real, at.real])
    y = np.array([at.imag, at.imag, np.nan, at.imag - size, at.imag + size])
    return Line(x, y, 0, colour)


def disk(margin: float) -> tuple[np.ndarray, np.ndarray]:
    """Return the edge of the disk that a loop with a disk margin alpha (skew 0) avoids.

    Its diameter is on the real axis, from -(2 + alpha) / (2 - alpha) to the inverse of that.
    """
    share = min(0.5 * margin, 1.0 - 1.0 / WIDEST)
    near, far = (1.0 - share) / (1.0 + share), (1.0 + share) / (1.0 - share)
    radius = 0.5 * (far - near)
    return -0.5 * (near + far) + radius * np.cos(TURN), radius * np.sin(TURN)


def phase_rows(now: Judged, before: Judged | None, limit_of: LimitOf) -> tuple[Row, ...]:
    """Return a row for each loop: the parts of its phase in degrees, and its crossover [rad/s].

    Args:
        now: results for the proposed gains, or else for the flown ones.
        before: results for the flown gains, None if these are the same.
        limit_of: returns a limit by name, as shown.
    """
    old = {loop.name: loop for loop in before.loops} if before is not None else {}
    weakest = weakest_loop(now, limit_of) if now.stable else None
    return tuple(_row(loop, old.get(loop.name), loop is weakest) for loop in now.loops)


def costliest(loop: JudgedLoop) -> str:
    """Return the part other than the law that takes the most phase, "" if none takes any.

    The law is left out: it includes the body's own -90 or -180 degrees, and would always be the
    largest.
    """
    costs = [(angle, name) for name, angle in loop.turned if name != LAW]
    cost, name = min(costs, default=(0.0, ""))
    return name if degrees(cost) != degrees(0.0) else ""


def degrees(angle: float, *, fine: bool = False) -> str:
    """Return an angle [rad] in degrees, with a decimal below 10, or always if `fine`."""
    shown = math.degrees(angle)
    return number_text(shown, 1 if fine or abs(shown) < 9.95 else 0)


def phase_headline(judged: Judged, limit_of: LimitOf) -> str:
    """Return the part that takes the most phase of the weakest loop, as a sentence."""
    loop = weakest_loop(judged, limit_of)
    if not judged.stable or loop is None:
        return margins_headline(judged, None, limit_of)
    most = costliest(loop)
    cost = f"; most: {most} {degrees(dict(loop.turned)[most])}°" if most else ""
    return f"Weakest: {loop_label(loop.name)}{cost}"


def missing_phase(judged: Judged) -> str:
    """Return which loops and parts have no phase, and why, in sentences; "" if all have one."""
    if not judged.stable:
        return "Phases are known only for a stable closed loop."
    said = []
    uncrossed = [loop_label(loop.name) for loop in judged.loops if not loop.turned]
    if uncrossed:
        said.append(f"Without a crossover: {', '.join(uncrossed)}.")
    crossed = [dict(loop.turned) for loop in judged.loops if loop.turned]
    for name, sentence in ABSENT.items() if crossed else ():
        if all(abs(turned[name]) < LEAST for turned in crossed):
            said.append(sentence)
    return " ".join(said)


def _row(loop: JudgedLoop, old: JudgedLoop | None, strong: bool) -> Row:
    label, most = loop_label(loop.name), costliest(loop)
    turned, before = dict(loop.turned), dict(old.turned) if old is not None else {}
    cells = []
    for name, words in PARTS.items():
        help = f"{label}: {name}, {words}"
        if not turned:
            cells.append(Cell("–", help=help))
            continue
        text = degrees(turned[name])
        was = degrees(before[name]) if before else text
        help = f"{help}: {degrees(turned[name], fine=True)}° at {loop.crossover:.3g} rad/s"
        cells.append(
            Cell(text, was if was != text else "", help=help, marked="most" if name == most else "")
        )
    cells.append(_crossover_cell(loop, old if before else None))
    state = State.BROKEN if loop.growing else State.NONE
    return Row(short_label(loop.name), tuple(cells), state, strong)


def _crossover_cell(loop: JudgedLoop, old: JudgedLoop | None) -> Cell:
    label = loop_label(loop.name)
    if not loop.turned:
        return Cell("–", help=f"{label}: no crossover is known")
    text = _frequency(loop)
    was = _frequency(old) if old is not None else text
    hertz = loop.crossover / (2.0 * math.pi)
    help = (
        f"{label}: its gain is 1 at {loop.crossover:.3g} rad/s ({hertz:.3g} Hz); "
        f"there, all parts leave {degrees(loop.phase_margin, fine=True)}° to −180°"
    )
    return Cell(text, was if was != text else "", help=help)


def _frequency(loop: JudgedLoop) -> str:
    """Return a crossover [rad/s], for a narrow column."""
    return f"{loop.crossover:.3g}" if loop.crossover >= 1.0 else f"{loop.crossover:.2f}"


class PhaseView(QWidget):
    """The phase budget of each loop, with proposed gains beside the flown ones.

    Args:
        workspace: source of colours.
        judgement: known results for both.
        limits: limits that determine the weakest loop.

    Attributes:
        headline: summary as a sentence, and its tone.
        table: one row per loop.
        missing: loops and parts without a phase, in sentences; hidden if there are none.
    """

    changed = pyqtSignal()
    """The table changed."""

    def __init__(self, workspace: Workspace, judgement: Judgement, limits: Limits) -> None:
        super().__init__()
        self._judgement = judgement
        self._limits = limits
        self.headline = "", "muted"
        self.table = NumberTable(
            "Where the phase of every loop went, in degrees at its crossover",
            [*(f"{HEADS.get(name, name)} °" for name in PARTS), "at rad/s"],
            workspace.look,
            paired=True,
            widest="yaw rate",
            worded=False,
            head_help=[
                *(f"{name}: {words}" for name, words in PARTS.items()),
                "at: the crossover, where the loop's gain is 1; the highest, if there are more",
            ],
        )
        self.table.expect(ROWS)
        self.missing = wrapped()
        vbox(self.missing, (self.table, 1), of=self, margins=NO_MARGINS, spacing=SPACING)
        judgement.changed.connect(self._show)
        limits.changed.connect(lambda _: self._show())
        self._show()

    def _show(self) -> None:
        now, before = self._judgement.proposed, self._judgement.flown
        missing = missing_phase(now) if now is not None else ""
        self.missing.setText(missing)
        self.missing.setVisible(bool(missing))
        self.headline = self._headline(now)
        if now is None:
            self.table.set_rows(())
        else:
            other = before if before is not now else None
            self.table.expect(len(now.loops))
            self.table.set_rows(phase_rows(now, other, self._limits.value))
        self.changed.emit()

    def _headline(self, now: Judged | None) -> tuple[str, str]:
        if now is None:
            return self._judgement.said or "Not known yet: the analyst is computing it.", "muted"
        if caveat := self._judgement.caveat:
            return caveat, "warning"
        return phase_headline(now, self._limits.value), "muted" if now.stable else "bad"
