"""The curves of a chart: source of samples, appearance, and axes."""

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, field
from enum import Enum

import numpy as np
from PyQt6.QtGui import QColor, QPen

from workbench.common.errors import WorkbenchError
from workbench.gui.charts.decimation import Peaks

Samples = tuple[np.ndarray, np.ndarray]
"""Times [s], increasing, and values."""
Source = Callable[[float], Samples]
"""Returns samples from a time on [s]."""
MOST_AXES = 4
MOST_CURVES = 24
COMMAND = -1
"""Instead of a curve's number: the colour of commands."""
LIMIT = -2
"""Instead of a curve's number: the colour of limits."""
FAINT_SHARE = 0.45
"""Share of its colour that a faint curve keeps."""


class CurveStyle(Enum):
    """Line style of a curve."""

    SOLID = "solid"
    """Measured values."""
    DASHED = "dashed"
    """Commanded or predicted values."""
    FAINT = "faint"
    """Past values, or those of a log."""


def make_pen(colour: QColor, style: CurveStyle, ground: QColor) -> QPen:
    """Return the pen of a curve on a background: one pixel wide, which Qt paints fast."""
    if style is CurveStyle.FAINT:  # mixed, as blending is slow
        pairs = zip(colour.getRgb()[:3], ground.getRgb()[:3], strict=True)
        mixed = [FAINT_SHARE * (a or 0) + (1.0 - FAINT_SHARE) * (b or 0) for a, b in pairs]
        colour = QColor(*map(round, mixed))
    pen = QPen(colour, 1)
    pen.setCosmetic(True)
    if style is CurveStyle.DASHED:
        pen.setDashPattern([6.0, 4.0])
    return pen


@dataclass(eq=False)
class Curve:
    """One curve; curves are compared by identity.

    Attributes:
        label: name in the legend.
        unit: SI unit, as in topics; curves with the same unit share an axis.
        source: source of its samples.
        colour: number of its colour, `COMMAND` for that of commands, `LIMIT` for that of limits.
        style: line style.
        number: number in the legend and at its end.
        visible: whether it is drawn.
        peaks: the drawn extremes.
    """

    label: str
    unit: str
    source: Source
    colour: int = 0
    style: CurveStyle = CurveStyle.SOLID
    number: int = 1
    visible: bool = True
    peaks: Peaks = field(default_factory=Peaks, repr=False)
    _frozen: Source | None = field(default=None, repr=False)

    @property
    def axis_unit(self) -> str:
        """SI unit of its axis."""
        return self.unit or "1"

    def samples(self, since: float) -> Samples:
        """Return the samples from a time on [s], as views that must be used at once."""
        return (self._frozen or self.source)(since)

    def freeze(self) -> None:
        """Keep the present samples, and show no newer ones."""
        time, values = self.source(-np.inf)
        self._frozen = source_of(time.copy(), values.copy())
        self.peaks = Peaks()

    def thaw(self) -> None:
        """Follow the source again."""
        self._frozen = None
        self.peaks = Peaks()


class CurveSet:
    """Curves in order; those with the same unit share an axis."""

    def __init__(self) -> None:
        self._curves: list[Curve] = []

    def __iter__(self) -> Iterator[Curve]:
        return iter(self._curves)

    def __len__(self) -> int:
        return len(self._curves)

    def __getitem__(self, index: int) -> Curve:
        return self._curves[index]

    @property
    def units(self) -> Sequence[str]:
        """SI unit of each axis."""
        return [*dict.fromkeys(each.axis_unit for each in self._curves)]

    def add(
        self, label: str, unit: str, source: Source, colour: int | None, style: CurveStyle
    ) -> Curve:
        """Add a curve; its default is the first free colour.

        Raises:
            WorkbenchError: if there is no room for it.
        """
        if len(self._curves) >= MOST_CURVES:
            raise WorkbenchError(
                f"a chart has room for {MOST_CURVES} curves: remove one, or add a chart"
            )
        axis, units = unit or "1", self.units
        if axis not in units and len(units) >= MOST_AXES:
            raise WorkbenchError(
                f"'{label}' is in {axis}, and a chart has room for {MOST_AXES} units: "
                "remove a curve, or add a chart"
            )
        taken = {each.colour for each in self._curves}
        free = next(index for index in range(MOST_CURVES + 1) if index not in taken)
        made = Curve(label, unit, source, free if colour is None else max(colour, LIMIT), style)
        self._curves.append(made)
        self._number()
        return made

    def remove(self, curve: Curve) -> None:
        """Remove a curve, if it is one of these."""
        self._curves = [each for each in self._curves if each is not curve]
        self._number()

    def _number(self) -> None:
        for index, curve in enumerate(self._curves, 1):
            curve.number = index


@dataclass
class Extent:
    """Least and largest value of an axis."""

    low: float = np.inf
    high: float = -np.inf

    def take(self, values: np.ndarray) -> np.ndarray:
        """Extend it to values; returns them with NaN for those that are not finite."""
        finite = np.isfinite(values)
        if not finite.all():
            values = np.where(finite, values, np.nan)
        if finite.any():
            self.low = min(self.low, float(np.fmin.reduce(values)))
            self.high = max(self.high, float(np.fmax.reduce(values)))
        return values


def source_of(time: np.ndarray, values: np.ndarray) -> Source:
    """Return a source of fixed samples, starting with the last one before a time [s]."""

    def samples(since: float) -> Samples:
        first = max(0, int(np.searchsorted(time, since)) - 1)
        return time[first:], values[first:]

    return samples
