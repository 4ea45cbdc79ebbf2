"""Curves over a logarithmic axis of frequency: Bode's two, and the gang of four."""

import math
from collections.abc import Callable, Sequence

import numpy as np
from PyQt6.QtCore import pyqtSignal
from PyQt6.QtGui import QResizeEvent
from PyQt6.QtWidgets import QGridLayout, QWidget

from workbench.design.judge.margins import LoopMargins
from workbench.gui.charts.content import Guide
from workbench.gui.charts.curve import CurveStyle
from workbench.gui.charts.plots import StaticPlot
from workbench.gui.charts.ticks import Scale
from workbench.gui.tuning.drawn_loop import DrawnLoop, counting
from workbench.gui.tuning.limit_table import Limit, find_limit
from workbench.gui.tuning.loop_marks import (
    Mark,
    decibel,
    gain_margin_mark,
    peak,
    phase_margin_mark,
    unwrapped,
)
from workbench.gui.workspace import Workspace

EVERYWHERE = (-math.inf, math.inf)
GAIN, REDUCTION, PHASE = map(find_limit, ("gain_margin", "gain_reduction_margin", "phase_margin"))
LOW = 150
"""Height that a plot needs so that its curves can be read [px]."""


class FrequencyPlots(QWidget):
    """Plots over one axis of frequency, one cursor in all.

    Args:
        workspace: colours.
        titles: what each shows, in the order they stand.
        parent: the Qt parent; this object is deleted with it.

    Attributes:
        plots: in their order.
    """

    pointed = pyqtSignal(object)
    """Frequency under the mouse [rad/s], None where it has left."""

    def __init__(
        self,
        workspace: Workspace,
        titles: Sequence[str],
        parent: QWidget | None = None,
    ) -> None:
        super().__init__(parent)
        self._linking = False
        self.plots = tuple(StaticPlot(workspace) for _ in titles)
        self._box = QGridLayout(self)
        self._box.setContentsMargins(0, 0, 0, 0)
        self._box.setSpacing(2)
        self._columns = 0
        for plot, title in zip(self.plots, titles, strict=True):
            plot.setMinimumHeight(LOW)
            plot.set_hint("Not known yet: the analyst is asked")
            plot.show_head(False)
            plot.set_title(title)
            plot.cursor_moved.connect(self.pointed)
            plot.picture_changed.connect(lambda plot=plot: self._link(plot))
        self._arrange(2)

    def _arrange(self, columns: int) -> None:
        """Stand in so many columns."""
        if columns == self._columns:
            return
        self._columns = columns
        for place, plot in enumerate(self.plots):
            self._box.addWidget(plot, place // columns, place % columns)

    def set_cursor(self, frequency: float | None) -> None:
        """Put the cursor of all plots to a frequency [rad/s], or take it away."""
        for plot in self.plots:
            if plot.cursor_time != frequency:
                plot.set_cursor(frequency)

    def show_window(self, left: float, right: float) -> None:
        """Show frequencies from one to another [rad/s]."""
        for plot in self.plots:
            plot.set_window(left, right)

    def _link(self, plot: StaticPlot) -> None:
        """Show the frequencies in all plots that the user has zoomed to in one."""
        if self._linking:
            return
        self._linking = True
        for other in self.plots:
            if other is not plot and other.window_ends != plot.window_ends:
                other.set_window(*plot.window_ends)
        self._linking = False


class BodePlots(FrequencyPlots):
    """Magnitude and phase of L, with crossover and margins."""

    def __init__(self, workspace: Workspace, parent: QWidget | None = None) -> None:
        super().__init__(workspace, ("Magnitude of L", "Phase of L"), parent)
        magnitude, phase = self.plots
        magnitude.set_axes("Frequency", "Magnitude", "dB", "rad/s")
        phase.set_axes("Frequency", "Phase", "°", "rad/s")
        for plot in self.plots:
            plot.set_scales(Scale.LOGARITHMIC)

    def resizeEvent(self, event: QResizeEvent | None) -> None:
        """Stand below each other where there is the height for it, else beside each other."""
        super().resizeEvent(event)
        self._arrange(1 if self.height() >= 2 * LOW else 2)

    def show_loops(self, loops: Sequence[DrawnLoop]) -> None:
        """Draw these, with the margins of the one that counts."""
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
"""Lines in a plot, and what they say."""


def margin_guides(loop: DrawnLoop | None) -> tuple[Shown, Shown]:
    """Return crossover and margins in the magnitude's plot, and in the phase's."""
    sizes, turns = [Guide(EVERYWHERE, (0.0, 0.0))], [Guide(EVERYWHERE, (-180.0, -180.0))]
    if loop is None or loop.margins is None or not loop.margins.stable:
        return (sizes, ""), (turns, "")
    margins, said, turned = loop.margins, [], ""
    if math.isfinite(margins.crossover):
        sizes.append(Guide((margins.crossover,) * 2, EVERYWHERE))
        said.append(f"{margins.crossover:.3g} rad/s")
    at = phase_margin_mark(loop)
    if at is not None:
        degrees = math.degrees(at.value)
        level = 360.0 * round((degrees - 180.0) / 360.0) + 180.0
        turns = [
            Guide(EVERYWHERE, (level, level)),
            Guide((at.frequency,) * 2, (level, degrees), "warning"),
        ]
        turned = _words(PHASE, margins)
    for limit in (GAIN, REDUCTION):
        mark = gain_margin_mark(loop, getattr(margins, limit.name))
        if mark is not None:
            sizes.append(Guide((mark.frequency,) * 2, (mark.value, 0.0), "warning"))
            turns.append(Guide((mark.frequency,) * 2, EVERYWHERE))
            said.append(_words(limit, margins))
    return (sizes, ", ".join(said)), (turns, turned)


def _words(limit: Limit, margins: LoopMargins) -> str:
    """Return a margin with its unit, as the table of margins has it."""
    glue = "" if limit.unit == "°" else " "
    return f"{limit.short} {limit.text(getattr(margins, limit.name))}{glue}{limit.unit}"


def keep(plot: StaticPlot, names: Sequence[str]) -> None:
    """Keep curves of these names alone, in this order, by which they are numbered."""
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
"""Name, name of the peak, and the response of a loop."""


class GangPlots(FrequencyPlots):
    """Sizes of S, T, KS and GS, each with its peak."""

    def __init__(self, workspace: Workspace, parent: QWidget | None = None) -> None:
        super().__init__(
            workspace,
            (
                "S, sensitivity",
                "T, complementary sensitivity",
                "KS, control sensitivity",
                "GS, load sensitivity",
            ),
            parent,
        )
        self.name_units("1", "1")
        for plot in self.plots:
            plot.set_scales(Scale.LOGARITHMIC, Scale.LOGARITHMIC)

    def name_units(self, control: str, load: str) -> None:
        """Write the units of KS and GS."""
        units = "1", "1", control, load
        for plot, (name, _, _), unit in zip(self.plots, FOUR, units, strict=True):
            plot.set_axes("Frequency", name, unit, "rad/s")

    def show_loops(self, loops: Sequence[DrawnLoop]) -> None:
        """Draw these, with the peaks of the one that counts."""
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
    """Return lines at a peak, with its size and frequency."""
    lines = [
        Guide(EVERYWHERE, (mark.value, mark.value), "warning"),
        Guide((mark.frequency,) * 2, EVERYWHERE),
    ]
    if what == "peak":  # its unit takes the room of its frequency
        return lines, f"peak {mark.value:.4g}"
    return lines, f"{what} {mark.value:.3g} at {mark.frequency:.3g} rad/s"
