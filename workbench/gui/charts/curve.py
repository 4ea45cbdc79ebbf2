"""The curves of a chart: source of samples, appearance, and axes."""

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, field
from enum import Enum

import numpy as np
from PyQt6.QtCore import Qt
from PyQt6.QtGui import QColor, QPen

from workbench.common.errors import WorkbenchError
from workbench.common.series import TimedValues
from workbench.gui.charts.decimation import ColumnReducer

SampleSource = Callable[[float], TimedValues]
"""Returns samples from a time on [s]."""
MAX_CHART_AXES = 4
MAX_CHART_CURVES = 24
COMMAND_COLOUR = -1
"""Instead of a curve's number: the colour of commands."""
LIMIT_COLOUR = -2
"""Instead of a curve's number: the colour of limits."""
CURVE_WIDTH_PX = 1.5
"""Width of a curve [layout pixels]."""
FAINT_COLOUR_SHARE = 0.45
"""Share of its colour that a faint curve keeps."""


class CurveStyle(Enum):
    """Line style of a curve."""

    SOLID = "solid"
    """Measured values."""
    DASHED = "dashed"
    """Commanded or predicted values."""
    FAINT = "faint"
    """Past values, or those of a log."""
    POINTS = "points"
    """Measured points, which no line joins."""


def make_pen(colour: QColor, style: CurveStyle, ground: QColor, ratio: float = 1.0) -> QPen:
    """Return the pen of a curve on a background.

    Args:
        colour: colour of the curve.
        style: line style.
        ground: colour of the background.
        ratio: screen pixels per layout pixel, as Qt takes the width of such a pen in screen pixels.
    """
    if style is CurveStyle.FAINT:  # mixed, as blending is slow
        pairs = zip(colour.getRgb()[:3], ground.getRgb()[:3], strict=True)
        mixed = [
            FAINT_COLOUR_SHARE * (a or 0) + (1.0 - FAINT_COLOUR_SHARE) * (b or 0) for a, b in pairs
        ]
        colour = QColor(*map(round, mixed))
    pen = QPen(colour, CURVE_WIDTH_PX * ratio)
    pen.setCosmetic(True)
    pen.setCapStyle(Qt.PenCapStyle.FlatCap)
    if style is CurveStyle.DASHED:
        pen.setDashPattern([4.0, 2.5])
    return pen


@dataclass(eq=False)
class ChartCurve:
    """One curve; curves are compared by identity.

    Attributes:
        label: name in the legend.
        unit: SI unit, as in topics; curves with the same unit share an axis.
        source: source of its samples.
        colour: number of its colour, `COMMAND_COLOUR` for that of commands, `LIMIT_COLOUR` for that
            of limits.
        style: line style.
        group: name of the curves that share one entry of the legend, as earlier steps; "" for none.
        visible: whether it is drawn.
        peaks: the drawn extremes.
    """

    label: str
    unit: str
    source: SampleSource
    colour: int = 0
    style: CurveStyle = CurveStyle.SOLID
    group: str = ""
    visible: bool = True
    peaks: ColumnReducer = field(default_factory=ColumnReducer, repr=False)
    _frozen: SampleSource | None = field(default=None, repr=False)

    @property
    def axis_unit(self) -> str:
        """SI unit of its axis."""
        return self.unit or "1"

    @property
    def number(self) -> int:
        """Number in the legend and at its end: its colour's, so it stays; 0 for none."""
        return self.colour + 1 if self.colour >= 0 and not self.group else 0

    def samples(self, since: float) -> TimedValues:
        """Return the samples from a time on [s], as views that must be used at once."""
        return (self._frozen or self.source)(since)

    def freeze(self) -> None:
        """Keep the present samples, and show no newer ones."""
        time, values = self.source(-np.inf)
        self._frozen = fixed_source(time.copy(), values.copy())
        self.peaks = ColumnReducer()

    def thaw(self) -> None:
        """Follow the source again."""
        self._frozen = None
        self.peaks = ColumnReducer()


class CurveSet:
    """Curves in order; those with the same unit share an axis."""

    def __init__(self) -> None:
        self._curves: list[ChartCurve] = []

    def __iter__(self) -> Iterator[ChartCurve]:
        return iter(self._curves)

    def __len__(self) -> int:
        return len(self._curves)

    def __getitem__(self, index: int) -> ChartCurve:
        return self._curves[index]

    @property
    def units(self) -> Sequence[str]:
        """SI unit of each axis."""
        return [*dict.fromkeys(each.axis_unit for each in self._curves)]

    def add(
        self, label: str, unit: str, source: SampleSource, colour: int | None, style: CurveStyle
    ) -> ChartCurve:
        """Add a curve; its default is the first free colour.

        Raises:
            WorkbenchError: if there is no room for it.
        """
        if len(self._curves) >= MAX_CHART_CURVES:
            raise WorkbenchError(
                f"a chart has room for {MAX_CHART_CURVES} curves: remove one, or add a chart"
            )
        axis, units = unit or "1", self.units
        if axis not in units and len(units) >= MAX_CHART_AXES:
            raise WorkbenchError(
                f"'{label}' is in {axis}, and a chart has room for {MAX_CHART_AXES} units: "
                "remove a curve, or add a chart"
            )
        taken = {each.colour for each in self._curves}
        free = next(index for index in range(MAX_CHART_CURVES + 1) if index not in taken)
        made = ChartCurve(
            label, unit, source, free if colour is None else max(colour, LIMIT_COLOUR), style
        )
        self._curves.append(made)
        return made

    def remove(self, curve: ChartCurve) -> None:
        """Remove a curve, if it is one of these."""
        self._curves = [each for each in self._curves if each is not curve]

    def groups(self) -> list[list[ChartCurve]]:
        """Return the curves of each entry of the legend, in order."""
        found: dict[str | ChartCurve, list[ChartCurve]] = {}
        for curve in self._curves:
            found.setdefault(curve.group or curve, []).append(curve)
        return [*found.values()]


@dataclass
class AxisExtent:
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


def fixed_source(time: np.ndarray, values: np.ndarray) -> SampleSource:
    """Return a source of fixed samples, starting with the last one before a time [s]."""

    def samples(since: float) -> TimedValues:
        first = max(0, int(np.searchsorted(time, since)) - 1)
        return time[first:], values[first:]

    return samples
