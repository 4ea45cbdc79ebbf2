"""The curves of a chart: their axes, numbers and colours."""

import dataclasses
import math
from collections.abc import Iterator, Sequence

import numpy as np

from workbench.common.errors import WorkbenchError
from workbench.gui.charts.curve import Curve, Source
from workbench.gui.charts.curve_style import COMMAND, CurveStyle

MOST_AXES = 4
MOST_CURVES = 24


class CurveSet:
    """Curves in their order; those of a unit share an axis."""

    def __init__(self) -> None:
        self._curves: list[Curve] = []
        self._units: list[str] = []

    def __iter__(self) -> Iterator[Curve]:
        return iter(self._curves)

    def __len__(self) -> int:
        return len(self._curves)

    def __getitem__(self, index: int) -> Curve:
        return self._curves[index]

    @property
    def units(self) -> Sequence[str]:
        """SI unit of each axis."""
        return tuple(self._units)

    def axis_of(self, unit: str) -> int:
        """Return the number of the axis of a unit."""
        return self._units.index(_axis_unit(unit))

    def add(
        self, label: str, unit: str, source: Source, colour: int | None, style: CurveStyle
    ) -> Curve:
        """Add a curve; without a colour it gets the first that is free.

        Raises:
            WorkbenchError: if there is no room for it.
        """
        if len(self._curves) >= MOST_CURVES:
            raise WorkbenchError(
                f"a chart has room for {MOST_CURVES} curves: remove one, or add a chart"
            )
        axis = _axis_unit(unit)
        if axis not in self._units and len(self._units) >= MOST_AXES:
            raise WorkbenchError(
                f"'{label}' is in {axis}, and a chart has room for {MOST_AXES} units: "
                "remove a curve, or add a chart"
            )
        taken = {each.colour for each in self._curves}
        free = next(index for index in range(MOST_CURVES + 1) if index not in taken)
        made = Curve(label, unit, source, free if colour is None else max(colour, COMMAND), style)
        self._curves.append(made)
        self._settle()
        return made

    def remove(self, curve: Curve) -> None:
        """Remove a curve; nothing happens where it is none of these."""
        self._curves = [each for each in self._curves if each is not curve]
        self._settle()

    def freeze(self) -> None:
        """Let all curves stand still."""
        for curve in self._curves:
            curve.freeze()

    def thaw(self) -> None:
        """Let all curves follow again."""
        for curve in self._curves:
            curve.thaw()

    def _settle(self) -> None:
        units = [_axis_unit(each.unit) for each in self._curves]
        self._units = [*dict.fromkeys(units)]
        for index, curve in enumerate(self._curves):
            curve.number = index + 1


@dataclasses.dataclass
class Extent:
    """Least and largest value of an axis."""

    low: float = np.inf
    high: float = -np.inf

    def take(self, values: np.ndarray) -> np.ndarray:
        """Widen it to values; those that are not finite are NaN in what is returned."""
        if len(values) == 0:
            return values
        low, high = float(values.min()), float(values.max())
        if not (math.isfinite(low) and math.isfinite(high)):
            finite = np.isfinite(values)
            if not finite.any():
                return np.full(len(values), np.nan)
            low, high = float(values[finite].min()), float(values[finite].max())
            values = np.where(finite, values, np.nan)
        self.low, self.high = min(self.low, low), max(self.high, high)
        return values


def _axis_unit(unit: str) -> str:
    return unit or "1"
