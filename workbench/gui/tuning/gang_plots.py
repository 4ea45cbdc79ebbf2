"""The plots of the gang of four of a loop: S, T, KS and GS, each with its peak."""

from collections.abc import Callable, Sequence

import numpy as np

from workbench.gui.charts.content import ReferenceLine
from workbench.gui.charts.ticks import Scale
from workbench.gui.tuning.drawn_loop import DrawnLoop, MarginMark, loop_with_margins, response_peak
from workbench.gui.tuning.frequency_plots import (
    WHOLE_AXIS,
    FrequencyPlots,
    GuidesWithCaption,
    keep_curves,
)
from workbench.gui.units import frequency_text
from workbench.gui.workspace import Workspace

LoopResponse = Callable[[DrawnLoop], np.ndarray]
GANG_OF_FOUR: tuple[tuple[str, str, LoopResponse], ...] = (
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
        for plot, (name, _, _), unit in zip(self.plots, GANG_OF_FOUR, units, strict=True):
            plot.set_axes("Frequency", name, unit, "rad/s")

    def show_loops(self, loops: Sequence[DrawnLoop]) -> None:
        """Draw loops, with the peaks of the proposed gains, or else of the flown ones."""
        now = loop_with_margins(loops)
        for plot, (_, what, response) in zip(self.plots, GANG_OF_FOUR, strict=True):
            shown: GuidesWithCaption = ([], "")
            names = []
            for loop in loops:
                values = np.abs(response(loop))
                if not len(values):
                    continue
                names.append(loop.name)
                plot.set_curve(loop.name, loop.frequency, values, loop.style, loop.colour)
                if loop is now:
                    shown = peak_guide(what, response_peak(loop.frequency, values))
            keep_curves(plot, names)
            plot.set_guides(*shown)


def peak_guide(what: str, mark: MarginMark) -> GuidesWithCaption:
    """Return lines at a peak, with its magnitude and frequency."""
    frequency, size = mark
    lines = [
        ReferenceLine(WHOLE_AXIS, (size, size), "warning"),
        ReferenceLine((frequency, frequency), WHOLE_AXIS),
    ]
    if what == "peak":  # its unit replaces its frequency for lack of room
        return lines, f"peak {size:.4g}"
    return lines, f"{what} {size:.3g} at {frequency_text(frequency)}"
