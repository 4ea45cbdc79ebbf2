"""Spectra, x-y charts, common cursors, derived signals and layouts, over a canned flight."""

import dataclasses

import numpy as np
import pytest
import scipy.signal
from PyQt6.QtCore import Qt
from PyQt6.QtTest import QTest
from PyQt6.QtWidgets import QComboBox, QDialogButtonBox, QFileDialog

from workbench.common.errors import WorkbenchError
from workbench.gui.charts.chart_kind import SPECTRUM_CHART, XY_CHART, chart_kinds
from workbench.gui.charts.ticks import Scale
from workbench.gui.visualization.derived_signals import DerivedSignal
from workbench.gui.visualization.layouts import (
    LAYOUT_PRESETS,
    ChartLayout,
    ChartSpec,
    layout_text,
    read_layout,
)

GYRO = "imu.angular_velocity.1"
SPEEDS = ("velocity_data.v_x", "velocity_data.v_z")


@pytest.fixture
def page(begun, workspace, canned):
    """The charts at the end of the flight."""
    for some in canned.published:
        workspace.signals.add(some)
    begun.show_view(canned.views[-1])
    return begun.charts


def show(page, *charts):
    page.show_layout(ChartLayout(charts=charts))
    page.refresh(3.0)
    return [pane.chart for pane in page.board.panes]


def test_a_spectrum_is_scipy_s_of_the_samples_in_the_window(page, qtbot):
    (chart,) = show(page, ChartSpec("Gyro", (GYRO, "velocity_data.v_x")).of_kind(SPECTRUM_CHART))
    qtbot.waitUntil(lambda: len(chart.curves) == 2)
    time, values = page._source.series(GYRO)
    rate = (len(time) - 1) / (time[-1] - time[0])
    first = 2 * (len(values) // 9)
    for window, averages, detrend in (("Hann", 8, "Mean off"), ("Flat top", 2, "Line off")):
        boxes = chart.findChildren(QComboBox)
        wanted = zip(boxes, (window, f"{averages} averages", detrend), strict=True)
        said = chart.said.text()
        for box, text in wanted:
            box.setCurrentText(text)
            box.activated.emit(box.currentIndex())
        segment = 2 * (len(values) // (averages + 1))
        qtbot.waitUntil(
            lambda segment=segment, said=said: (
                len(chart.columns()[0].time) == segment // 2
                and (chart.said.text() != said or segment == first)
            )
        )
        column = chart.columns()[0]
        frequency, density = scipy.signal.welch(
            values,
            rate,
            {"Hann": "hann", "Flat top": "flattop"}[window],
            segment,
            detrend={"Mean off": "constant", "Line off": "linear"}[detrend],
        )
        np.testing.assert_allclose(column.time, frequency[1:], rtol=1e-9)
        np.testing.assert_allclose(column.values, density[1:], rtol=1e-9, atol=1e-30)
        assert column.unit == "(rad/s)^2/Hz"
    content = chart.canvas.content
    assert (content.x_scale, content.y_scale) == (Scale.LOGARITHMIC, Scale.LOGARITHMIC)
    assert content.axes[0].unit.symbol == "(°/s)²/Hz"
    assert content.axes[0].unit.factor == pytest.approx((180.0 / np.pi) ** 2)
    spec = page.board.panes[0].spec
    assert (spec.window, spec.averages, spec.detrend) == ("flattop", 2, "linear")


def test_with_two_cursors_the_spectrum_is_of_what_lies_between(page, qtbot):
    over, chart = show(
        page, ChartSpec("Over", (GYRO,)), ChartSpec("", (GYRO,)).of_kind(SPECTRUM_CHART)
    )
    over.set_mark("A", 0.5)
    over.set_mark("B", 2.5)
    qtbot.waitUntil(lambda: chart.said.text().startswith("2 s:"))
    time, values = page._source.series(GYRO)
    part = values[(time >= 0.5) & (time <= 2.5)]
    segment = 2 * (len(part) // 9)
    _, density = scipy.signal.welch(part, (len(time) - 1) / (time[-1] - time[0]), nperseg=segment)
    np.testing.assert_allclose(chart.columns()[0].values, density[1:], rtol=1e-9, atol=1e-30)


def test_a_signal_without_a_spectrum_says_why(page, qtbot):
    (chart,) = show(page, ChartSpec("Charge", ("drone_state.charge",)).of_kind(SPECTRUM_CHART))
    page.board.set_marks({"A": 1.0, "B": 1.2})
    qtbot.waitUntil(
        lambda: "charge: a spectrum needs 16 samples, but there are only" in chart.said.text()
    )
    assert not chart.curves


def test_x_y_draws_one_signal_over_another_at_the_same_times(page):
    chart, over = show(
        page,
        ChartSpec("Path", ("position_data.x", "velocity_data.v_x"), XY_CHART),
        ChartSpec("Speed", SPEEDS),
    )
    (line,) = chart.canvas.content.lines
    assert np.array_equal(line.time, page._source.series("position_data.x")[1])
    assert np.array_equal(line.values, page._source.series("velocity_data.v_x")[1])
    over.cursor_moved.emit(2.0)
    (point,) = chart.canvas.content.points
    at = np.abs(page._source.series("position_data.x")[0] - 2.0).argmin()
    assert (point.x, point.y) == (line.time[at], line.values[at])
    assert "v_x over x" in chart.legend.entries[0].label
    chart.set_equal(True)
    content, size = chart.canvas.content, chart.canvas.view
    across = (content.right - content.left) / size.width()
    up = (content.axes[0].high - content.axes[0].low) / size.height()
    assert across == pytest.approx(up)


def test_crosshair_cursors_and_zoom_are_those_of_all_charts(page):
    first, second, third = show(
        page,
        ChartSpec("a", SPEEDS),
        ChartSpec("b", (GYRO,)),
        ChartSpec("c", ("position_data.z",)),
    )
    first.setFocus()
    QTest.keyClick(first, Qt.Key.Key_Left)
    assert second.cursor_time == third.cursor_time == first.cursor_time
    first.set_mark("A", 1.0)
    QTest.keyClick(second, Qt.Key.Key_Home)
    third.set_mark("B", 2.5)
    assert page.board.marks == {"A": 1.0, "B": 2.5}
    assert page.marks.text() == "B − A = 1.500 s"
    for chart in (first, second, third):
        assert chart.is_paused
        assert dict(chart.canvas.content.marks) == page.board.marks
    first.canvas.hovered.emit(None)
    time, height = page._source.series("position_data.z")
    change = height[np.abs(time - 2.5).argmin()] - height[np.abs(time - 1.0).argmin()]
    value = third.legend.entries[0].value.replace("\N{MINUS SIGN}", "-")
    assert value.startswith("Δ")
    assert float(value.split("\N{NO-BREAK SPACE}")[1]) == pytest.approx(change, abs=0.02)
    first.show_window(1.2, 1.8)
    assert second.window_ends == third.window_ends == pytest.approx((1.2, 1.8))
    QTest.mouseClick(page.clear_marks, Qt.MouseButton.LeftButton)
    assert page.board.marks == {} and not third.canvas.content.marks
    QTest.keyClick(first, Qt.Key.Key_Escape)
    assert not (second.is_paused or third.is_paused)


def test_the_slope_between_two_cursors_stands_in_the_table(page, statistic):
    (chart,) = show(page, ChartSpec("a", ("velocity_data.v_x",)))
    chart.set_mark("A", 1.0)
    chart.set_mark("B", 1.5)
    change = float(statistic(chart, 0, "B − A").replace("\N{MINUS SIGN}", "-"))
    slope = float(statistic(chart, 0, "Slope per s").replace("\N{MINUS SIGN}", "-"))
    assert slope == pytest.approx(change / 0.5, abs=0.01)
    assert change > 0.3


def test_a_chart_changes_its_kind_by_its_menu(page, qtbot):
    (chart,) = show(page, ChartSpec("a", SPEEDS))
    pane = page.board.panes[0]
    for name, kind in (("Spectrum", SPECTRUM_CHART), ("x-y, over the first signal", XY_CHART)):
        menus = [each.menu() for each in pane.chart.make_menu().actions() if each.menu()]
        menu = next(each for each in menus if each.title() == "Show as")
        next(each for each in menu.actions() if each.text() == name).trigger()
        assert pane.spec.kind == kind
        assert pane.spec.signals == SPEEDS
    assert pane.chart is not chart
    assert page.presets.currentText() == "Own"


def test_a_derived_signal_is_typed_checked_and_drawn(page, told):
    (chart,) = show(page, ChartSpec("a", ()))
    dialog = page.ask_signal()
    okay = dialog.buttons.button(QDialogButtonBox.StandardButton.Ok)
    for field, text, said in (
        (dialog.name, "2 x", "Give it a name"),
        (dialog.name, "ground_speed", "at its end: no expression"),
        (dialog.expression, "sqrt(v_x**2 + v_q**2)", "unknown signal 'v_q'"),
        (dialog.expression, "lowpass(v_x, 4000)", "below"),
        (dialog.expression, "own.ground_speed + v_x", "unknown signal 'own.ground_speed'"),
    ):
        field.setText(text)
        assert said in dialog.said.text(), text
        assert not okay.isEnabled()
    dialog.expression.setText("sqrt(v_x**2 + v_y**2)")
    dialog.unit.setText("m/s")
    assert dialog.said.text() == ""
    QTest.mouseClick(okay, Qt.MouseButton.LeftButton)
    page.refresh(3.0)
    line = chart.canvas.content.lines[0]
    (_, v_x), (_, v_y) = (page._source.series(f"velocity_data.{name}") for name in ("v_x", "v_y"))
    np.testing.assert_allclose(line.values, np.hypot(v_x, v_y), rtol=1e-12)
    assert "own.ground_speed" in page.tree.names()
    page.ask_signal(page._own[0]).given.emit(
        dataclasses.replace(page._own[0], name="own.fast", expression="2*v_x")
    )
    assert page.board.panes[0].spec.signals == ("own.fast",)
    chart.redraw()
    np.testing.assert_allclose(chart.canvas.content.lines[0].values, 2 * v_x, rtol=1e-12)
    assert told == []


def test_a_layout_is_saved_and_opened_as_it_was(page, qtbot, tmp_path, told):
    show(page, ChartSpec("Mine", SPEEDS), ChartSpec("S", (GYRO,)).of_kind(SPECTRUM_CHART))
    page._take(DerivedSignal("own.k", "m/s", "v_x*2"), None)
    page.board.set_marks({"A": 1.0, "B": 2.0})
    before = dataclasses.replace(page.layout_shown, version=1)
    page.save_layout(tmp_path / "mine")
    qtbot.waitUntil(lambda: len(told) == 1)
    path = tmp_path / "mine.layout.yaml"
    assert read_layout(path) == before
    page._ask_save()
    page._ask_save()
    (asked,) = page.findChildren(QFileDialog)
    asked.close()
    page.show_layout(ChartLayout(charts=LAYOUT_PRESETS["Rotors"]))
    page.open_layout(path)
    qtbot.waitUntil(lambda: page.layout_shown.charts == before.charts)
    assert dataclasses.replace(page.layout_shown, version=1) == before


def test_layouts_of_all_kinds_go_round(tmp_path):
    path = tmp_path / "a.layout.yaml"
    rng = np.random.default_rng(2)
    for charts in LAYOUT_PRESETS.values():
        marks = dict(zip("AB", rng.normal(size=2).tolist(), strict=True))
        charts = tuple(
            dataclasses.replace(
                each, kind=str(rng.choice([*chart_kinds()])), log_y=bool(rng.integers(2))
            )
            for each in charts
        )
        layout = ChartLayout(1, charts, (), marks)
        path.write_text(layout_text(layout))
        assert read_layout(path) == layout


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("charts: []", ":1: this is version 0 of a layout"),
        ("version: 9", ":1: this is version 9"),
        ("version: 1\ncharts:\n- title: a\n  kin: time", ":4: unknown key 'kin'"),
        ("version: 1\ncharts:\n- kind: pie", ":3: unknown kind 'pie'"),
        ("version: 1\ncharts:\n- window: hat", ":3: unknown window 'hat'"),
        ("version: 1\ncharts:\n- averages: 0", ":3: averages is 0"),
        ("version: 1\ncharts:\n- signals: v_x", ":3: charts.0.signals is 'v_x'"),
        ("version: 1\ncharts:\n" + "- title: a\n" * 9, ":11: at most 8"),
        ("version: 1\nsignals:\n- name: own.a\n  expression: sqrt(", ":3: 'sqrt('"),
        ("version: 1\nsignals:\n- name: a.b\n  expression: v_x", "begin with own."),
        ("version: 1\nmarks: {C: 1.0}", ":2: unknown mark 'C'"),
        ("[1]", "key: value"),
    ],
)
def test_a_file_that_is_no_layout_is_refused_with_its_line(tmp_path, text, said):
    path = tmp_path / "wrong.layout.yaml"
    path.write_text(text)
    with pytest.raises(WorkbenchError) as refused:
        read_layout(path)
    assert said in str(refused.value)
