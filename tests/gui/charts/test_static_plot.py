"""Finished curves over each other."""

import numpy as np
import pytest
from PyQt6.QtCore import QPoint, Qt
from PyQt6.QtGui import QGuiApplication
from PyQt6.QtTest import QTest

from workbench.gui.charts.curve_style import COMMAND, CurveStyle
from workbench.gui.charts.plot import StaticPlot

TIME = np.linspace(0.0, 2.0, 201)


@pytest.fixture
def plot(workspace, qtbot):
    made = StaticPlot(workspace)
    qtbot.addWidget(made)
    made.resize(500, 280)
    made.set_title("Step")
    made.set_axes("Time s", "Velocity", "m/s")
    made.set_curve("command", TIME, np.ones(201), CurveStyle.DASHED, COMMAND)
    made.set_curve("flown", TIME, 1.0 - np.exp(-3.0 * TIME))
    made.show()
    qtbot.waitExposed(made)
    return made


def test_all_curves_are_seen_whole(plot):
    scene = plot.canvas.scene
    assert (scene.left, scene.right) == (0.0, 2.0)
    assert scene.axes[0].low <= 0.0
    assert scene.axes[0].high >= 1.0
    assert [line.style for line in scene.lines] == [CurveStyle.DASHED, CurveStyle.SOLID]


def test_a_curve_is_replaced_by_its_name_and_removed(plot):
    plot.set_curve("flown", TIME, 3.0 * TIME)
    assert plot.names == ("command", "flown")
    assert plot.canvas.scene.axes[0].high >= 6.0
    plot.remove_curve("flown")
    plot.remove_curve("nonsense")
    assert len(plot.canvas.scene.lines) == 1


def test_a_limit_that_is_near_is_seen_and_one_far_away_does_not_flatten(plot):
    plot.set_limits([(1.2, "overshoot"), (50.0, "speed")])
    assert [limit.label for limit in plot.canvas.scene.limits] == ["overshoot", "speed"]
    assert 1.2 <= plot.canvas.scene.axes[0].high < 5.0


def test_units_are_as_the_user_prefers(plot, workspace):
    workspace.preferences.set("speed_unit", "km/h")
    axis = plot.canvas.scene.axes[0]
    assert axis.unit.symbol == "km/h"
    assert axis.high >= 3.6


def test_the_mouse_reads_the_curves(plot):
    plot.canvas.hovered.emit(1.0)
    assert plot.head.legend.entries[1].value == "0.95\N{NO-BREAK SPACE}m/s"
    plot.canvas.hovered.emit(None)
    assert plot.head.legend.entries[1].value == ""


def test_a_box_zooms_and_a_double_click_shows_all(plot):
    layout, scene = plot.canvas.layout_now, plot.canvas.scene
    y = round(layout.plot.center().y())
    first, last = (QPoint(round(layout.x_of(scene, at)), y) for at in (0.5, 1.0))
    QTest.mousePress(plot.canvas, Qt.MouseButton.LeftButton, pos=first)
    QTest.mouseRelease(plot.canvas, Qt.MouseButton.LeftButton, pos=last)
    assert plot.canvas.scene.left == pytest.approx(0.5, abs=0.02)
    assert plot.canvas.scene.right == pytest.approx(1.0, abs=0.02)
    QTest.mouseDClick(plot.canvas, Qt.MouseButton.LeftButton, pos=first)
    assert (plot.canvas.scene.left, plot.canvas.scene.right) == (0.0, 2.0)


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
    plot.grab()
    assert plot.canvas.scene.hint == "Fly a step to see its response"
    assert "no curves" in plot.accessibleDescription()


def test_what_is_set_together_is_drawn_once(plot, monkeypatch):
    drawn = []
    monkeypatch.setattr(plot.canvas, "show_scene", drawn.append)
    with plot.together():
        plot.set_curve("flown", TIME, 2.0 * TIME)
        plot.set_curve("predicted", TIME, 3.0 * TIME)
        plot.remove_curve("command")
        plot.set_window(0.0, 1.0)
    assert len(drawn) == 1
    assert len(drawn[0].lines) == 2
    assert drawn[0].right == 1.0
    assert "predicted" in plot.accessibleDescription()
