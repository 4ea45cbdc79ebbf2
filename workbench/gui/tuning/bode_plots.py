"""The Bode plots of open loops, with crossovers and margins."""

import math
from collections.abc import Sequence

import numpy as np
from PyQt6.QtCore import QSize
from PyQt6.QtGui import QShowEvent

from workbench.design.judge.loop_response import decibels
from workbench.design.judge.margins import LoopMargins
from workbench.gui.charts.content import ReferenceLine
from workbench.gui.charts.curve import CurveStyle
from workbench.gui.charts.static_plot import StaticPlot
from workbench.gui.charts.ticks import Scale
from workbench.gui.errands import single_shot
from workbench.gui.tuning.drawn_loop import (
    MIN_DRAWN_COHERENCE,
    DrawnLoop,
    gain_margin_mark,
    loop_with_margins,
    phase_beside,
    phase_margin_mark,
)
from workbench.gui.tuning.frequency_plots import (
    WHOLE_AXIS,
    FrequencyPlots,
    GuidesWithCaption,
    keep_curves,
)
from workbench.gui.tuning.limits import NumberLimit, find_limit
from workbench.gui.units import frequency_text
from workbench.gui.workspace import Workspace

GAIN_MARGIN_LIMIT, GAIN_REDUCTION_LIMIT, PHASE_MARGIN_LIMIT = map(
    find_limit, ("gain_margin", "gain_reduction_margin", "phase_margin")
)
MIN_BODE_SIZE_PX = (400, 250)
"""Least size of magnitude and phase together [px]."""
COHERENCE_HEIGHT_PX = 110
"""Height of the plot of the coherence [px]."""
DEVIATION_CURVES = "one sigma"
"""Name of the lines around a measurement, in the menu of curves."""


class BodePlots(FrequencyPlots):
    """Magnitude of L above its phase, with crossover and margins.

    Args:
        workspace: source of colours.

    Attributes:
        coherence: coherence of the measurement, below both; hidden without one.
    """

    columns = 1

    def __init__(self, workspace: Workspace) -> None:
        super().__init__(workspace, ("Magnitude of L", "Phase of L"))
        magnitude, phase = self.plots
        magnitude.set_axes("Frequency", "Magnitude", "dB", "rad/s")
        phase.set_axes("Frequency", "Phase", "°", "rad/s")
        for plot, shown in zip(self.plots, margin_guides(None), strict=True):
            plot.set_guides(*shown)
            plot.set_scales(Scale.LOGARITHMIC)
            plot.setMinimumHeight(MIN_BODE_SIZE_PX[1] // 2)
        self.coherence = StaticPlot(workspace)
        self.coherence.show_head(False)
        self.coherence.set_title("Coherence of the measurement")
        self.coherence.set_axes("Frequency", "Coherence", "1", "rad/s")
        self.coherence.set_scales(Scale.LOGARITHMIC)
        self.coherence.set_guides([ReferenceLine(WHOLE_AXIS, (MIN_DRAWN_COHERENCE,) * 2)])
        self.coherence.set_zero_shown(True)
        self.coherence.canvas.setMinimumHeight(COHERENCE_HEIGHT_PX)
        self.coherence.setFixedHeight(COHERENCE_HEIGHT_PX)
        self.coherence.hide()
        self.coherence.cursor_moved.connect(self.pointed)
        self._align_soon = single_shot(self._align, self)  # once the magnitude is drawn
        magnitude.picture_changed.connect(self._align_soon.start)
        self._box.addWidget(self.coherence, 2, 0)

    def minimumSizeHint(self) -> QSize:
        """Return the least legible size, with the coherence if it is shown."""
        width, height = MIN_BODE_SIZE_PX
        below = 0 if self.coherence.isHidden() else COHERENCE_HEIGHT_PX + self._box.spacing()
        return QSize(width, height + below)

    def show_loops(self, loops: Sequence[DrawnLoop]) -> None:
        """Draw loops, with the margins of the proposed gains, or else of the flown ones."""
        magnitude, phase = self.plots
        now = loop_with_margins(loops)
        names = []
        for loop in loops:
            size, turn = decibels(loop.open_loop), np.degrees(phase_beside(loop, now))
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
                    look = style, loop.colour, DEVIATION_CURVES if name else ""
                    plot.set_curve(loop.name + name, loop.frequency, values, *look)
        for plot in self.plots:
            keep_curves(plot, names)
        self._show_coherence(loops, names)
        for plot, shown in zip(self.plots, margin_guides(now), strict=True):
            plot.set_guides(*shown)

    def set_cursor(self, frequency: float | None) -> None:
        """Set the cursor of all plots to a frequency [rad/s], or remove it."""
        super().set_cursor(frequency)
        self.coherence.set_cursor(frequency)

    def show_window(self, left: float, right: float) -> None:
        """Show the frequencies between two [rad/s]."""
        super().show_window(left, right)
        self.coherence.set_window(left, right)

    def _show_coherence(self, loops: Sequence[DrawnLoop], names: Sequence[str]) -> None:
        """Show the coherence of the measurement, also where it is too small for a point of L.

        The other curves are there without values, so that all plots have the same width.
        """
        measured = [each for each in loops if len(each.coherence)]
        self.coherence.setVisible(bool(measured))
        self.setMinimumHeight(self.minimumSizeHint().height())  # the card scrolls where it is low
        if not measured:
            return
        (known, *_) = measured
        look = {each.name: (each.style, each.colour) for each in loops}
        for name in names:
            values = (
                known.coherence if name == known.name else np.full_like(known.coherence, np.nan)
            )
            style, colour = look.get(name, (CurveStyle.FAINT, known.colour))
            group = "" if name in look else DEVIATION_CURVES
            self.coherence.set_curve(name, known.frequency, values, style, colour, group)
        keep_curves(self.coherence, names)

    def _align(self) -> None:
        self.coherence.set_window(*self.plots[0].window_ends)

    def showEvent(self, event: QShowEvent | None) -> None:
        """Align the coherence with the magnitude."""
        super().showEvent(event)
        self._align_soon.start()


def margin_guides(loop: DrawnLoop | None) -> tuple[GuidesWithCaption, GuidesWithCaption]:
    """Return crossover and margins in the plots of magnitude and phase."""
    sizes, turns = (
        [ReferenceLine(WHOLE_AXIS, (0.0, 0.0))],
        [ReferenceLine(WHOLE_AXIS, (-180.0, -180.0))],
    )
    if loop is None or loop.margins is None or not loop.margins.stable:
        return (sizes, ""), (turns, "")
    margins, said, turned = loop.margins, [], ""
    if math.isfinite(margins.crossover):
        sizes.append(ReferenceLine((margins.crossover,) * 2, WHOLE_AXIS))
        said.append(frequency_text(margins.crossover))
    at = phase_margin_mark(loop)
    if at is not None:
        degrees = math.degrees(at[1])
        level = 360.0 * round((degrees - 180.0) / 360.0) + 180.0
        turns.append(ReferenceLine((at[0],) * 2, (level, degrees), "warning"))
        if level != turns[0].level:
            turns.append(ReferenceLine(WHOLE_AXIS, (level, level)))
        turned = _margin_text(PHASE_MARGIN_LIMIT, margins)
    for limit in (GAIN_MARGIN_LIMIT, GAIN_REDUCTION_LIMIT):
        mark = gain_margin_mark(loop, getattr(margins, limit.name))
        if mark is not None:
            frequency, size = mark
            sizes.append(ReferenceLine((frequency, frequency), (size, 0.0), "warning"))
            turns.append(ReferenceLine((frequency, frequency), WHOLE_AXIS))
            said.append(_margin_text(limit, margins))
    return (sizes, ", ".join(said)), (turns, turned)


def _margin_text(limit: NumberLimit, margins: LoopMargins) -> str:
    """Return a margin with its unit, as in the table of margins."""
    return f"{limit.short} {limit.text(getattr(margins, limit.name))}"
