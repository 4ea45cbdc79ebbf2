"""The kinds of charts of a board."""

from collections.abc import Callable
from functools import cache
from importlib import import_module
from pkgutil import iter_modules
from typing import TYPE_CHECKING, NamedTuple

from workbench.common.extensions import ExtensionGroup, load_extensions

if TYPE_CHECKING:
    from workbench.gui.charts.strip_chart import StripChart
    from workbench.gui.charts.window_plot import WindowPlot
    from workbench.gui.workspace import Workspace

TIME_CHART, SPECTRUM_CHART, XY_CHART, STEP_CHART = "time", "spectrum", "x-y", "steps"


class ChartKind(NamedTuple):
    """A kind of chart.

    Attributes:
        name: in files of layouts.
        title: in menus.
        make: returns an empty chart; a `WindowPlot`, unless it is the one over time.
        log_axes: axes that may be logarithmic, as in "xy".
        over_first: whether signals are drawn over the first one.
    """

    name: str
    title: str
    make: "Callable[[Workspace], StripChart | WindowPlot]"
    log_axes: str = ""
    over_first: bool = False


@cache
def chart_kinds() -> dict[str, ChartKind]:
    """Return all kinds by name: CHART_KIND of each `NAME_chart` here, then other packages'."""
    import workbench.gui.charts as here

    files = (each.name for each in iter_modules(here.__path__) if each.name.endswith("_chart"))
    rows = [import_module(f"{here.__name__}.{name}").CHART_KIND for name in files]
    rows += load_extensions(ExtensionGroup.CHARTS, ChartKind).values()
    return {row.name: row for row in sorted(rows, key=lambda row: row.name != TIME_CHART)}
