"""Logarithmic axes: places by hand, ticks, what the mouse reads, ranges, zoom and decimation."""

import math

import numpy as np
import pytest
from PyQt6.QtCore import QPointF, Qt
from PyQt6.QtGui import QGuiApplication
from PyQt6.QtTest import QTest

from workbench.gui.charts.decimation import reduce_columns
from workbench.gui.charts.static_plot import StaticPlot
from workbench.gui.charts.ticks import Scale, decade_text, decade_ticks

FREQUENCY = np.logspace(-1.0, 3.0, 401)


@pytest.fixture
def plot(workspace, qtbot):
    made = StaticPlot(workspace)
    qtbot.addWidget(made)
    made.resize(600, 300)
    made.set_axes("Frequency", "Magnitude", "", "rad/s")
    made.set_scales(Scale.LOGARITHMIC, Scale.LOGARITHMIC)
    made.set_curve("1/s", FREQUENCY, 1.0 / FREQUENCY)
    made.show()
    qtbot.waitExposed(made)
    made.redraw()
    return made


@pytest.fixture
def mouse(plot, mouse_on):
    return mouse_on(plot)


def pixel(plot, x, y):
    """Where a point of the first curve is painted, as shares of the view from left and below."""
    plot.grab()  # the view lays itself out as it is painted
    canvas, view = plot.canvas, plot.canvas.view
    at = canvas._groups[0].mapToScene(QPointF(math.log10(x), math.log10(y)))
    box = view.sceneBoundingRect()
    return (at.x() - box.left()) / box.width(), (box.bottom() - at.y()) / box.height()


def test_a_decade_takes_the_same_way_everywhere(plot):
    """Four decades of frequency: 10 rad/s lies in the middle, 1 rad/s at a quarter."""
    assert plot.window_ends == pytest.approx((0.1, 1000.0))
    low, high = (plot.canvas.content.axes[0].low, plot.canvas.content.axes[0].high)
    for x, across in ((0.1, 0.0), (1.0, 0.25), (10.0, 0.5), (1000.0, 1.0)):
        up = math.log(1.0 / x / low) / math.log(high / low)
        assert pixel(plot, x, 1.0 / x) == pytest.approx((across, up), abs=4e-3)
    drawn = plot.canvas._curves[0].getData()
    np.testing.assert_allclose(drawn[1], -drawn[0], atol=1e-12)


def test_values_in_another_unit_lie_where_they_are_shown(plot, workspace):
    """5 m/s are 18 km/h: the axis has the one, the curve the other."""
    workspace.preferences.set("speed_unit", "km/h")
    plot.set_axes("Frequency", "Speed", "m/s", "rad/s")
    plot.redraw()
    axis = plot.canvas.content.axes[0]
    up = math.log(5.0 * 3.6 / axis.low) / math.log(axis.high / axis.low)
    assert pixel(plot, 1.0, 5.0)[1] == pytest.approx(up, abs=4e-3)


def test_the_mouse_reads_frequency_and_value(plot, mouse):
    mouse.move(1.0)  # the view's axis has logarithms: 10 rad/s
    assert plot.cursor_time == pytest.approx(10.0, rel=0.02)
    assert float(plot.legend.entries[0].value) == pytest.approx(0.1, rel=0.05)
    said = plot.canvas._cross.label.format.split("\N{NO-BREAK SPACE}")
    assert float(said[0]) == pytest.approx(10.0, rel=0.02) and said[1] == "rad/s"
    dot = plot.canvas._dots.getData()
    assert dot[0][0] == pytest.approx(math.log10(plot.cursor_time))
    assert dot[1][0] == pytest.approx(-dot[0][0], abs=0.01)


def test_wheel_box_and_keys_move_in_decades(plot, mouse):
    mouse.wheel(1.0, -1)
    left, right = plot.window_ends
    assert math.log10(right / left) == pytest.approx(4.0 / 0.85, rel=1e-3)
    assert math.sqrt(left * right) == pytest.approx(10.0, rel=0.05), "the place under the mouse"
    mouse.click_twice(1.0)
    assert plot.window_ends == pytest.approx((0.1, 1000.0))
    mouse.drag((0.0, 0.5), (2.0, 0.5))
    assert plot.window_ends == pytest.approx((1.0, 100.0), rel=0.05)
    plot.setFocus()
    before = plot.window_ends
    QTest.keyClick(plot, Qt.Key.Key_PageDown)
    assert plot.window_ends[0] == pytest.approx(before[0] * math.sqrt(10.0), rel=0.05)
    QTest.keyClick(plot, Qt.Key.Key_Home)
    mouse.move(1.5)
    QTest.keyClick(plot, Qt.Key.Key_A)
    assert plot._model.marks["A"] == pytest.approx(10.0**1.5, rel=0.05)


def test_a_mark_stands_at_its_frequency(plot, statistic):
    plot.set_mark("A", 10.0)
    plot.redraw()
    assert plot.canvas._marks[0].value() == pytest.approx(1.0)
    assert statistic(plot, 0, "A at 10 rad/s") == "0.1"


def test_what_is_not_positive_is_left_out(plot):
    """As the zero frequency of a spectrum, and a power of zero."""
    x = np.array([0.0, 1.0, 10.0, 100.0])
    plot.set_curve("1/s", x, np.array([5.0, 1.0, 0.0, 0.01]))
    plot.reset()
    plot.redraw()
    assert plot.window_ends == pytest.approx((1.0, 100.0))
    line, axis = plot.canvas.content.lines[0], plot.canvas.content.axes[0]
    np.testing.assert_allclose(line.time, [1.0, 10.0, 100.0])
    assert np.isnan(line.values[1])
    assert 0.001 < axis.low <= 0.01 and 1.0 <= axis.high < 10.0
    plot.grab()


def test_many_points_are_reduced_by_columns_of_decades(plot):
    """A narrow peak stays, wherever it is."""
    x = np.logspace(-1.0, 3.0, 100_000)
    y = np.ones_like(x)
    y[777] = 50.0
    plot.set_curve("1/s", x, y)
    plot.redraw()
    line = plot.canvas.content.lines[0]
    assert len(line.time) < 2000
    assert line.values.max() == 50.0
    width = 4.0 / plot.canvas.columns
    first = math.floor(-1.0 / width)
    places, values = reduce_columns(np.log10(x), y, first, first + 10, width)
    np.testing.assert_allclose(np.log10(line.time[: len(places)]), places, atol=1e-9)
    np.testing.assert_array_equal(line.values[: len(values)], values)


def test_data_are_copied_over_frequency(plot):
    plot.copy_data()
    assert QGuiApplication.clipboard().text().startswith("frequency [rad/s]\t1/s [1]\n0.1\t10\n")


def test_a_linear_axis_comes_back(plot):
    plot.set_scales()
    plot.redraw()
    assert plot.window_ends == pytest.approx((0.1, 1000.0))
    drawn = plot.canvas._curves[0].getData()
    assert drawn[0][-1] == pytest.approx(1000.0)


def test_ticks_by_hand():
    decades = [math.log10(each) for each in (0.1, 1.0, 10.0, 100.0)]
    numbered, bare = decade_ticks(-1.0, 2.0, 6)
    np.testing.assert_allclose(numbered, decades, atol=1e-12)
    assert len(bare) == 3 * 8 and math.log10(20.0) in bare
    numbered, bare = decade_ticks(-1.0, 2.0, 12)
    np.testing.assert_allclose(
        10.0 ** np.sort(numbered), [0.1, 0.2, 0.5, 1, 2, 5, 10, 20, 50, 100], rtol=1e-12
    )
    numbered, bare = decade_ticks(math.log10(4.0), math.log10(9.0), 6)
    np.testing.assert_allclose(10.0 ** np.array(numbered), [4, 5, 6, 7, 8, 9], rtol=1e-12)
    numbered, bare = decade_ticks(-6.0, 6.0, 4)
    np.testing.assert_allclose(numbered, [-6, -3, 0, 3, 6], atol=1e-12)
    assert not bare


@pytest.mark.parametrize(
    ("value", "said"),
    [(0.01, "0.01"), (0.5, "0.5"), (20.0, "20"), (1000.0, "1000"), (2e5, "2·10⁵"), (1e-6, "10⁻⁶")],
)
def test_numbers_at_ticks(value, said):
    assert decade_text(value) == said
