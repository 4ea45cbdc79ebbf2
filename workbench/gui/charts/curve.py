"""A curve of a chart: where its samples come from and how it looks."""

from collections.abc import Callable
from dataclasses import dataclass, field

import numpy as np

from workbench.gui.charts.curve_style import CurveStyle
from workbench.gui.charts.decimation import Peaks

Samples = tuple[np.ndarray, np.ndarray]
"""Times [s], rising, and values."""
Source = Callable[[float], Samples]
"""Returns samples from a time on [s]."""


@dataclass(eq=False)
class Curve:
    """One curve; two are the same only if they are one.

    Attributes:
        label: in the legend.
        unit: SI, as topics have it; curves of a unit share an axis.
        source: of its samples.
        colour: number of its colour, `COMMAND` for that of commands.
        style: of its stroke.
        number: in the legend and at its end.
        visible: whether it is drawn.
        peaks: what is drawn of it.
    """

    label: str
    unit: str
    source: Source
    colour: int = 0
    style: CurveStyle = CurveStyle.SOLID
    number: int = 1
    visible: bool = True
    peaks: Peaks = field(default_factory=Peaks, repr=False)
    _frozen: Samples | None = field(default=None, repr=False)

    def samples(self, since: float) -> Samples:
        """Return the samples from a time on [s]: views, to be used at once."""
        if self._frozen is None:
            return self.source(since)
        time, values = self._frozen
        first = int(np.searchsorted(time, since))
        return time[first:], values[first:]

    def freeze(self) -> None:
        """Keep what there is by now, and show nothing newer."""
        time, values = self.source(-np.inf)
        self._frozen = time.copy(), values.copy()
        self.peaks = Peaks()

    def thaw(self) -> None:
        """Follow the source again."""
        self._frozen = None
        self.peaks = Peaks()
