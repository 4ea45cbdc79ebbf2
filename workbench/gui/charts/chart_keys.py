"""The chart that single keys are for, wherever the focus is."""

from PyQt6.QtGui import QKeyEvent
from PyQt6.QtWidgets import QWidget

from workbench.gui.charts.chart import Chart
from workbench.gui.charts.chart_command import pressed_key
from workbench.gui.key_map import KeyMap
from workbench.gui.key_table import CHART_KEYS


def give_key_to_chart(event: QKeyEvent, page: QWidget, keys: KeyMap) -> bool:
    """Give a key of charts to the one under the pointer, or else to the first visible one.

    Args:
        event: the pressed key, which the focused widget has not used.
        page: the page with the charts.
        keys: keys of all rows.

    Returns:
        Whether a chart has got it.
    """
    if pressed_key(event) not in {keys.key(row.name) for row in CHART_KEYS}:
        return False
    charts = [each for each in page.findChildren(Chart) if each.isVisible()]
    chart = next((each for each in charts if each.underMouse()), charts[0] if charts else None)
    if chart is None:
        return False
    chart.keyPressEvent(event)
    return True
