"""What all pictures of sweeps share: labels, marks, and the scale of a metric."""

from typing import Any

import numpy as np
from matplotlib.axes import Axes

from workbench.design.metrics import Metric, for_people
from workbench.design.plots import PALETTE
from workbench.design.sweep.best import BestCandidate
from workbench.design.sweep.ranges import SweepRange
from workbench.design.sweep.table import SweepTable

HATCH: Any = {"facecolor": "0.94", "edgecolor": "0.65", "hatch": "////", "lw": 0.0}
"""How what was lost is drawn."""
PRESENT: Any = {"marker": "o", "ms": 9, "mfc": "white", "mec": "black", "mew": 1.5}
BEST: Any = {"marker": "*", "ms": 16, "mfc": PALETTE.mean, "mec": "white", "mew": 1.0}
_MOST = 0.95
"""Share of the candidates that the scale has room for; what is beyond has the last colour."""


def axis_label(span: SweepRange) -> str:
    """Return the label of a swept number's axis, with its unit."""
    return f"{span.name} [{span.unit}]" if span.unit != "1" else f"{span.name} [1]"


def metric_label(table: SweepTable, metric: Metric) -> str:
    """Return the label of a metric's axis, with its unit."""
    _, unit = for_people(table.units[table.names.index(metric.name)])
    return f"{metric.name.replace('_', ' ')} [{unit or '1'}]"


def shown_values(table: SweepTable, metric: Metric) -> np.ndarray:
    """Return a metric (N) as it is drawn: angles in degrees, NaN where it is not finite."""
    values = for_people(metric.unit)[0] * table.column(metric.name)
    return np.where(np.isfinite(values), values, np.nan)


def colour_limits(values: np.ndarray) -> tuple[float, float]:
    """Return where a scale begins and ends, so that a few wild candidates do not fill it."""
    finite = values[np.isfinite(values)]
    if not len(finite):
        return 0.0, 1.0
    low, most, high = finite.min(), np.quantile(finite, _MOST), finite.max()
    high = most if high - low > 2.0 * (most - low) > 0.0 else high
    return float(low), float(high if high > low else low + 1.0)


def mark_points(axes: Axes, table: SweepTable, best: BestCandidate | None) -> None:
    """Mark the present values, where they are within the ranges, and the best on a map."""
    x, y = table.ranges
    if x.low <= table.present[0] <= x.high and y.low <= table.present[1] <= y.high:
        axes.plot(*table.present, ls="", label="present", zorder=5, **PRESENT)
    if best:
        axes.plot(*best.parameters, ls="", label="best", zorder=6, **BEST)
