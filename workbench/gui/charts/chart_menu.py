"""The menus of charts."""

from collections.abc import Callable
from typing import TYPE_CHECKING

from PyQt6.QtGui import QAction
from PyQt6.QtWidgets import QMenu

if TYPE_CHECKING:
    from workbench.gui.charts.plot import StaticPlot
    from workbench.gui.charts.strip_chart import StripChart


def make_menu(chart: "StripChart") -> QMenu:
    """Return a menu that is gone once it is closed."""
    menu = QMenu(chart)
    menu.aboutToHide.connect(menu.deleteLater)
    _add(menu, "Pause the picture", "Space", chart.set_paused, chart.is_paused)
    _add(menu, "Follow the flight", "Esc", lambda _: chart.follow())
    menu.addSeparator()
    _add(menu, "Statistics", "S", chart.set_statistics_shown, chart.are_statistics_shown)
    _add(menu, "Always show zero", "Z", chart.set_zero_shown, chart.is_zero_shown)
    _add(menu, "Set cursor A", "A", lambda _: chart.set_mark("A"))
    _add(menu, "Set cursor B", "B", lambda _: chart.set_mark("B"))
    _add(menu, "Clear cursors", "", lambda _: chart.clear_marks())
    menu.addSeparator()
    _add(menu, "Copy picture", "", lambda _: chart.copy_picture())
    _add(menu, "Copy data", "Ctrl+C", lambda _: chart.copy_data())
    _add(menu, "Save picture (PNG)", "", lambda _: chart.save_picture())
    _add(menu, "Save data (CSV)", "", lambda _: chart.save_data())
    curves = menu.addMenu("Curves")
    if curves is not None:
        curves.setEnabled(bool(chart.curves))
        for index, curve in enumerate(chart.curves):
            _add(curves, curve.label, "", _toggle(chart, index), curve.visible)
    for action in chart.extra_actions:
        menu.addAction(action)
    return menu


def make_plot_menu(plot: "StaticPlot") -> QMenu:
    """Return the menu of a plot that stands still; it is gone once it is closed."""
    menu = QMenu(plot)
    menu.aboutToHide.connect(menu.deleteLater)
    _add(menu, "Show all", "", lambda _: plot.show_all())
    _add(menu, "Copy picture", "", lambda _: plot.copy_picture())
    _add(menu, "Copy data", "", lambda _: plot.copy_data())
    _add(menu, "Save picture (PNG)", "", lambda _: plot.save_picture())
    _add(menu, "Save data (CSV)", "", lambda _: plot.save_data())
    return menu


def _add(
    menu: QMenu, text: str, key: str, do: Callable[[bool], object], checked: bool | None = None
) -> QAction:
    """Add an action; the key is heard by the chart itself, and only told here."""
    action = QAction(f"{text}\t{key}" if key else text, menu)
    if checked is not None:
        action.setCheckable(True)
        action.setChecked(checked)
    action.triggered.connect(do)
    menu.addAction(action)
    return action


def _toggle(chart: "StripChart", index: int) -> Callable[[bool], object]:
    return lambda _: chart.toggle_curve(index)
