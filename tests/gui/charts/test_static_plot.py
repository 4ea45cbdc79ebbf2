"""Finished curves over each other."""

import numpy as np
import pytest
from PyQt6.QtCore import QLineF, Qt
from PyQt6.QtGui import QColor, QGuiApplication, QImage, QPainter
from PyQt6.QtTest import QTest

from workbench.gui.charts.curve import COMMAND_COLOUR, CurveStyle, make_pen
from workbench.gui.charts.static_plot import StaticPlot

TIME = np.linspace(0.0, 2.0, 201)


@pytest.fixture
def plot(workspace, qtbot):
    made = StaticPlot(workspace)
    qtbot.addWidget(made)
    made.resize(500, 280)
    made.set_title("Step")
    made.set_axes("Time", "Velocity", "m/s")
    made.set_curve("command", TIME, np.ones(201), CurveStyle.DASHED, COMMAND_COLOUR)
    made.set_curve("flown", TIME, 1.0 - np.exp(-3.0 * TIME))
    made.show()
    qtbot.waitExposed(made)
    made.redraw()
    return made


@pytest.fixture
def mouse(plot, mouse_on):
    return mouse_on(plot)


def test_all_curves_are_seen_whole(plot):
    content = plot.canvas.content
    assert (content.left, content.right) == (0.0, 2.0)
    assert content.axes[0].low <= 0.0
    assert content.axes[0].high >= 1.0
    assert [line.style for line in content.lines] == [CurveStyle.DASHED, CurveStyle.SOLID]


def test_a_curve_is_replaced_by_its_name_and_removed(plot):
    plot.set_curve("flown", TIME, 3.0 * TIME)
    plot.redraw()
    assert plot.names == ("command", "flown")
    assert plot.canvas.content.axes[0].high >= 6.0
    plot.remove_curve("flown")
    plot.remove_curve("nonsense")
    plot.redraw()
    assert len(plot.canvas.content.lines) == 1


def test_units_are_as_the_user_prefers(plot, workspace):
    workspace.preferences.set("speed_unit", "km/h")
    axis = plot.canvas.content.axes[0]
    assert axis.unit.symbol == "km/h"
    assert axis.high >= 3.6


def test_the_mouse_reads_the_curves(plot, mouse):
    mouse.move(1.0)
    assert plot.legend.entries[1].value == "0.95\N{NO-BREAK SPACE}m/s"
    mouse.leave()
    assert plot.legend.entries[1].value == ""


def test_a_box_zooms_and_a_double_click_shows_all(plot, mouse):
    mouse.drag((0.5, 0.5), (1.0, 0.5))
    assert plot.window_ends == pytest.approx((0.5, 1.0), abs=0.02)
    plot.set_curve("flown", TIME, 0.5 * TIME)
    plot.redraw()
    assert plot.window_ends == pytest.approx((0.5, 1.0), abs=0.02), "a new curve undoes the zoom"
    mouse.click_twice(0.7)
    assert plot.window_ends == (0.0, 2.0)


def test_a_zoom_between_two_samples_shows_the_line_through_it(plot, mouse):
    """As of a command, of which only the corners are known."""
    plot.set_curve("command", np.array([0.0, 2.0]), np.array([1.0, 1.0]), CurveStyle.SOLID)
    plot.remove_curve("flown")
    plot.redraw()
    mouse.drag((0.5, 0.5), (1.0, 0.5))
    line = plot.canvas.content.lines[0]
    assert line.time[0] <= 0.5 and line.time[-1] >= 1.0


def test_it_is_read_by_keys_as_other_charts_are(plot, statistic):
    plot.setFocus()
    QTest.keyClick(plot, Qt.Key.Key_Left)
    assert plot.cursor_time == pytest.approx(1.96)
    QTest.keyClick(plot, Qt.Key.Key_A)
    assert plot.statistics.isVisible()
    assert statistic(plot, 0, "A at 1.96") == "1.000"
    QTest.keyClick(plot, Qt.Key.Key_Plus)
    assert plot.window_ends[0] > 0.3
    QTest.keyClick(plot, Qt.Key.Key_Home)
    assert plot.window_ends == (0.0, 2.0)


def test_data_are_copied(plot):
    plot.copy_data()
    lines = QGuiApplication.clipboard().text().splitlines()
    assert lines[0] == "time [s]\tcommand [m/s]\tflown [m/s]"
    assert len(lines) == 202


def test_curves_of_other_times_leave_cells_empty(plot):
    plot.set_curve("flown", np.array([0.005, 0.01]), np.array([7.0, 8.0]))
    plot.copy_data()
    lines = QGuiApplication.clipboard().text().splitlines()
    assert lines[1:4] == ["0\t1\t", "0.005\t\t7", "0.01\t1\t8"]


def test_an_empty_plot_says_so(workspace, qtbot):
    plot = StaticPlot(workspace)
    qtbot.addWidget(plot)
    plot.set_hint("Fly a step to see its response")
    plot.show()
    plot.redraw()
    plot.grab()
    assert plot.canvas.content.hint == "Fly a step to see its response"
    assert "no curves" in plot.accessibleDescription()


def test_what_is_set_one_after_the_other_is_drawn_once(plot, monkeypatch, qapp):
    qapp.processEvents()
    drawn = []
    monkeypatch.setattr(plot.canvas, "show_content", drawn.append)
    plot.set_curve("flown", TIME, 2.0 * TIME)
    plot.set_curve("predicted", TIME, 3.0 * TIME)
    plot.remove_curve("command")
    plot.set_window(0.0, 1.0)
    qapp.processEvents()
    assert len(drawn) == 1
    assert len(drawn[0].lines) == 2
    assert drawn[0].right == 1.0
    assert "predicted" in plot.accessibleDescription()


def ends_of(plot):
    """Return the texts at the curves' ends, in order."""
    return [curve.end.text() for curve in plot.canvas._curves]


def test_the_names_at_the_curves_stay_as_other_curves_come_and_go(plot):
    assert ends_of(plot) == ["command", "1 flown"]
    plot.set_curve("predicted", TIME, 0.9 * TIME, CurveStyle.DASHED, 1)
    plot.redraw()
    assert ends_of(plot) == ["command", "1 flown", "2 predicted"]
    plot.remove_curve("command")
    plot.redraw()
    assert ends_of(plot) == ["1 flown", "2 predicted"]
    plot.resize(220, 280)
    plot.redraw()
    assert ends_of(plot) == ["1", "2"], "where names are too wide, their numbers stay"


def test_earlier_steps_are_one_entry_that_hides_all(plot):
    for number in range(5):
        look = CurveStyle.FAINT, COMMAND_COLOUR, "earlier steps"
        plot.set_curve(f"step {number}", TIME, 0.1 * number * TIME, *look)
    plot.redraw()
    assert [each.label for each in plot.legend.entries] == ["command", "flown", "5 earlier steps"]
    plot.toggle_entry(2)
    assert len(plot.canvas.content.lines) == 2
    plot.set_curve("step 5", TIME, TIME, *look)
    plot.redraw()
    assert [each.label for each in plot.legend.entries][-1] == "6 earlier steps"
    assert len(plot.canvas.content.lines) == 2, "what comes later is hidden, too"


def test_the_name_of_the_axis_takes_no_number_away(plot):
    """Numbers at 0, 0.5 .. 2 s stand above the name, and none is left out."""
    plot.set_axes("A long name of the horizontal quantity", "Velocity", "m/s")
    plot.redraw()
    plot.grab()
    axis = plot.canvas._bottom
    numbers = axis.tickStrings([0.0, 0.5, 1.0, 1.5, 2.0], 1.0, 0.5)
    assert numbers == ["0.0", "0.5", "1.0", "1.5", "2.0"]
    under = axis.label.pos().y()
    assert under >= plot.canvas.fontMetrics().height() - 3


@pytest.mark.parametrize("ratio", [1.0, 2.0])
def test_a_curve_is_as_wide_on_a_fine_screen(workspace, ratio):
    """1.5 layout pixels are 3 of a screen of scale 2, where a straight line is painted."""
    colour, ground = workspace.look.curve(0), QColor("white")
    pen = make_pen(colour, CurveStyle.SOLID, ground, ratio)
    image = QImage(round(60 * ratio), round(40 * ratio), QImage.Format.Format_RGB32)
    image.setDevicePixelRatio(ratio)
    image.fill(ground)
    painter = QPainter(image)
    painter.setRenderHint(QPainter.RenderHint.Antialiasing)
    painter.setPen(pen)
    painter.drawLine(QLineF(0.0, 20.3, 60.0, 20.3))
    painter.end()
    across = [image.pixelColor(image.width() // 2, y) for y in range(image.height())]
    inked = sum((255 - each.red()) / (255 - colour.red()) for each in across)
    assert inked / ratio == pytest.approx(1.5, abs=0.1)
