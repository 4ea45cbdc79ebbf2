"""A strip chart by mouse and keyboard, against series that are known."""

import threading

import numpy as np
import pytest
from PyQt6.QtCore import QPoint, Qt
from PyQt6.QtGui import QGuiApplication
from PyQt6.QtTest import QTest
from pyqtgraph import PlotCurveItem

from workbench.common.errors import WorkbenchError
from workbench.gui.charts.curve import COMMAND_COLOUR, CurveStyle
from workbench.gui.charts.strip_chart import StripChart

TIME = np.arange(0.0, 60.0, 0.005)


def source_of(values):
    def series(since):
        first = np.searchsorted(TIME, since)
        return TIME[first:], values[first:]

    return series


@pytest.fixture
def chart(workspace, qtbot):
    made = StripChart(workspace)
    qtbot.addWidget(made)
    made.resize(600, 320)
    made.set_title("Velocity")
    made.add_curve("ramp", "m/s", source_of(0.1 * TIME))
    made.add_curve("wave", "m/s", source_of(np.sin(TIME)))
    made.show()
    qtbot.waitExposed(made)
    made.setFocus()
    made.refresh(40.0)
    return made


@pytest.fixture
def mouse(chart, mouse_on):
    return mouse_on(chart)


def test_the_last_seconds_are_seen_with_now_at_the_right(chart):
    assert chart.window_ends == (20.0, 40.0)
    content = chart.canvas.content
    assert content.origin == 40.0
    assert [line.time[-1] for line in content.lines] == pytest.approx([40.0, 40.0], abs=0.01)


def test_curves_of_a_unit_share_an_axis_and_others_have_their_own(chart):
    chart.add_curve("angle", "rad", source_of(0.0 * TIME + np.pi / 4))
    chart.redraw()
    content = chart.canvas.content
    assert [line.axis for line in content.lines] == [0, 0, 1]
    assert content.axes[1].unit.symbol == "°"
    assert content.axes[1].low < 45.0 < content.axes[1].high


def test_a_fifth_unit_is_refused_with_a_sentence(chart):
    for unit in ("rad", "N", "m"):
        chart.add_curve(unit, unit, source_of(TIME))
    with pytest.raises(WorkbenchError, match="room for 4 units"):
        chart.add_curve("pressure", "Pa", source_of(TIME))


def test_a_pause_keeps_the_picture_while_the_flight_goes_on(chart):
    QTest.mouseClick(chart.pause, Qt.MouseButton.LeftButton)
    assert chart.is_paused
    assert chart.canvas.content.state == "PAUSED"
    chart.refresh(50.0)
    assert chart.window_ends == (20.0, 40.0)
    QTest.mouseClick(chart.pause, Qt.MouseButton.LeftButton)
    assert chart.window_ends == (30.0, 50.0)


def test_what_is_paused_outlives_its_source(workspace, qtbot):
    kept = [np.arange(2000.0)]
    chart = StripChart(workspace)
    qtbot.addWidget(chart)
    chart.add_curve("a", "m", lambda since: (kept[0] / 100.0, kept[0]))
    chart.show()
    chart.refresh(20.0)
    assert len(chart.canvas.content.lines) == 1
    chart.set_paused(True)
    kept[0] = np.zeros(0)
    chart.redraw()
    assert chart.canvas.content.lines[0].values[-1] == 1999.0


def test_a_picture_that_moves_on_by_less_than_a_column_is_not_made_anew(chart):
    """And looks as if it were: the same curves, in a window of the present time."""
    chart.redraw()
    built = chart.canvas.content.lines
    width = 20.0 / chart.canvas.columns
    chart.refresh(40.0 + 0.4 * width)
    content = chart.canvas.content
    assert content.lines is built
    assert chart.window_ends == (content.left, content.right)
    items = [each for each in chart.canvas.scene().items() if isinstance(each, PlotCurveItem)]
    newest = max(each.mapToScene(built[0].time[-1], 0.0).x() for each in items)
    way = (content.right - built[0].time[-1]) / 20.0
    box = chart.canvas.view.sceneBoundingRect()
    assert newest == pytest.approx(box.right() - way * box.width(), abs=1.0)
    chart.refresh(40.0 + 1.1 * width)
    assert chart.canvas.content.lines is not built


def test_the_crosshair_stays_under_the_mouse_while_time_goes_on(chart, mouse):
    mouse.move(30.0)
    before = chart.cursor_time
    assert before == pytest.approx(30.0, abs=0.1)
    chart.refresh(45.0)
    assert chart.cursor_time == pytest.approx(before + 5.0, abs=1e-6)


def test_the_crosshair_reads_all_curves(chart, mouse):
    mouse.move(30.0)
    values = [entry.value for entry in chart.legend.entries]
    assert values[0].startswith("3.0")
    wave = float(values[1].replace("\N{MINUS SIGN}", "-").split("\N{NO-BREAK SPACE}")[0])
    assert wave == pytest.approx(np.sin(chart.cursor_time), abs=0.006)
    mouse.leave()
    assert chart.legend.entries[0].value.startswith("4.0")


def test_arrows_move_the_crosshair(chart):
    QTest.keyClick(chart, Qt.Key.Key_Left)
    assert chart.cursor_time == pytest.approx(39.6)
    QTest.keyClick(chart, Qt.Key.Key_Right)
    QTest.keyClick(chart, Qt.Key.Key_Right)
    assert chart.cursor_time == pytest.approx(40.0)


def test_two_cursors_tell_their_difference(chart, statistic):
    chart.set_cursor(25.0)
    QTest.keyClick(chart, Qt.Key.Key_A)
    chart.set_cursor(35.0)
    QTest.keyClick(chart, Qt.Key.Key_B)
    assert statistic(chart, 0, "A at 25") == "2.500"
    assert statistic(chart, 0, "B at 35") == "3.500"
    assert statistic(chart, 0, "B − A over 10.000 s") == "1.000"


def test_the_statistics_are_those_of_what_is_seen(chart, statistic):
    QTest.keyClick(chart, Qt.Key.Key_S)
    assert chart.statistics.isVisible()
    assert statistic(chart, 0, "Min") == "2.000"
    assert statistic(chart, 0, "Max") == "4.000"
    assert statistic(chart, 0, "Mean") == "3.000"
    seen = np.sin(TIME[4000:8001])
    assert float(statistic(chart, 1, "Std dev")) == pytest.approx(seen.std(), abs=0.01)


def test_a_cursor_is_dragged(chart, mouse, statistic):
    chart.set_mark("A", 25.0)
    mouse.drag((25.0, 0.5), (30.0, 0.5))
    assert float(statistic(chart, 0, "A at ")) == pytest.approx(3.0, abs=0.1)


def test_ctrl_and_the_wheel_zoom_the_time_and_with_shift_the_values(chart, mouse):
    """The wheel alone is the page's, which it scrolls."""
    assert not mouse.wheel(30.0, 1, Qt.KeyboardModifier.NoModifier)
    assert chart.window_ends == (20.0, 40.0)
    assert mouse.wheel(30.0, 1)
    left, right = chart.window_ends
    assert right == 40.0
    assert right - left == pytest.approx(20.0 * 0.85)
    before = chart.canvas.content.axes[0]
    shift = Qt.KeyboardModifier.ControlModifier | Qt.KeyboardModifier.ShiftModifier
    mouse.wheel(35.0, 1, shift)
    after = chart.canvas.content.axes[0]
    assert after.high - after.low == pytest.approx(0.85 * (before.high - before.low))


def test_a_box_zooms_and_a_double_click_follows_again(chart, mouse):
    high = chart.canvas.content.axes[0].high
    mouse.drag((25.0, 0.9), (30.0, 0.5))
    assert chart.window_ends == pytest.approx((25.0, 30.0), abs=0.1)
    assert chart.canvas.content.state == "ZOOMED"
    assert chart.canvas.content.axes[0].high < high
    mouse.click_twice(27.0)
    assert chart.window_ends == (20.0, 40.0)


def test_zero_is_shown_on_demand(chart):
    chart.remove_curve(chart.curves[1])
    chart.redraw()
    assert chart.canvas.content.axes[0].low > 0.0
    QTest.keyClick(chart, Qt.Key.Key_Z)
    assert chart.canvas.content.axes[0].low <= 0.0


def test_a_click_in_the_legend_hides_a_curve(chart, qapp):
    qapp.processEvents()
    legend = chart.legend
    text = legend.text()
    assert "ramp" in text and "wave" in text
    row = legend.fontMetrics().height() // 2
    for x in range(0, legend.width(), 4):  # along the line, until a name is hit
        QTest.mouseClick(legend, Qt.MouseButton.LeftButton, pos=QPoint(x, row))
        if not all(entry.visible for entry in legend.entries):
            break
    assert len(chart.canvas.content.lines) == 1
    assert "ramp\N{NO-BREAK SPACE}(hidden)" in legend.text()


def test_the_data_are_copied_in_si_at_all_times(chart, told):
    chart.show_window(10.0, 10.02)
    QTest.keyClick(chart, Qt.Key.Key_C, Qt.KeyboardModifier.ControlModifier)
    lines = QGuiApplication.clipboard().text().splitlines()
    assert lines[0] == "time [s]\tramp [m/s]\twave [m/s]"
    assert lines[1].split("\t")[:2] == ["10", "1"]
    assert len(lines) == 6
    assert "clipboard" in told[-1].what


def test_the_picture_is_copied(chart):
    chart.copy_picture()
    assert QGuiApplication.clipboard().pixmap().size() == chart.grab().size()


def wait_for_threads(qtbot):
    """Until what was saved has let go of its thread."""
    qtbot.waitUntil(
        lambda: not any(each.name.startswith("saving") for each in threading.enumerate()),
        timeout=10_000,
    )


def test_picture_and_data_are_saved_to_the_folder_for_logs(chart, workspace, told, qtbot, tmp_path):
    workspace.preferences.set("log_folder", str(tmp_path / "new"))
    chart.save_data()
    chart.save_picture()
    qtbot.waitUntil(lambda: len(told) == 2, timeout=10_000)
    wait_for_threads(qtbot)
    (table,) = tmp_path.glob("new/*.csv")
    assert table.read_text().startswith("time [s],ramp [m/s],wave [m/s]\n20,2,")
    assert len(list(tmp_path.glob("new/velocity_*.png"))) == 1


def test_a_folder_that_cannot_be_written_is_told(chart, workspace, told, qtbot, tmp_path):
    (tmp_path / "file").write_text("")
    workspace.preferences.set("log_folder", str(tmp_path / "file"))
    chart.save_data()
    qtbot.waitUntil(lambda: len(told) == 1, timeout=10_000)
    wait_for_threads(qtbot)
    assert "was not saved" in told[0].what


def test_other_units_are_shown_at_once(chart, workspace):
    workspace.preferences.set("speed_unit", "km/h")
    assert chart.canvas.content.axes[0].unit.symbol == "km/h"
    assert chart.legend.entries[0].value.startswith("14.4")


def test_the_menu_tells_the_keys_and_has_all_curves(chart):
    actions = chart.make_menu().actions()
    told = {each.text().partition("\t")[0]: each.text().partition("\t")[2] for each in actions}
    assert told == {
        **{"Pause the picture": "", "Follow the flight": "Esc", "": ""},
        **{"Statistics": "S", "Always show zero": "Z", "Set cursor A": "A", "Set cursor B": "B"},
        **{"Clear cursors": "", "Copy picture": "", "Copy data": "Ctrl+C"},
        **{"Save picture (PNG)": "", "Save data (CSV)": "", "Curves": ""},
    }
    curves = next(each.menu() for each in actions if each.text() == "Curves").actions()
    assert [each.text() for each in curves] == ["ramp", "wave"]
    curves[0].trigger()
    assert not chart.curves[0].visible


def test_keys_move_zoom_and_follow(chart):
    QTest.keyClick(chart, Qt.Key.Key_PageUp)
    assert chart.window_ends == (15.0, 35.0)
    QTest.keyClick(chart, Qt.Key.Key_Minus)
    assert chart.window_ends == pytest.approx((10.0, 35.0))
    QTest.keyClick(chart, Qt.Key.Key_Plus, Qt.KeyboardModifier.ShiftModifier)
    assert chart.window_ends == pytest.approx((15.0, 35.0))
    QTest.keyClick(chart, Qt.Key.Key_PageDown)
    assert chart.window_ends == pytest.approx((20.0, 40.0))
    for key in (Qt.Key.Key_Escape, Qt.Key.Key_Home):
        QTest.keyClick(chart, Qt.Key.Key_PageUp)
        assert chart.is_paused
        QTest.keyClick(chart, key)
        assert not chart.is_paused


def test_commands_have_a_colour_of_their_own(chart, workspace):
    chart.add_curve("wish", "m/s", source_of(TIME), colour=COMMAND_COLOUR, style=CurveStyle.DASHED)
    chart.redraw()
    assert chart.canvas.content.lines[2].colour == workspace.look.colour("command")


def test_a_gap_and_infinite_values_are_not_joined(workspace, qtbot):
    chart = StripChart(workspace)
    qtbot.addWidget(chart)
    values = np.where((TIME > 25.0) & (TIME < 30.0), np.inf, np.cos(TIME))
    chart.add_curve("range", "m", source_of(values))
    chart.show()
    chart.refresh(40.0)
    line = chart.canvas.content.lines[0]
    assert np.isnan(line.values[(line.time > 25.5) & (line.time < 29.5)]).all()
    assert chart.canvas.content.axes[0].high < 5.0


def test_a_slow_signal_has_gaps_too(workspace, qtbot):
    chart = StripChart(workspace)
    qtbot.addWidget(chart)
    time, values = np.arange(20.0), np.where(np.arange(20) % 5, 2.0, np.inf)
    chart.add_curve("clearance", "m", lambda since: (time, values))
    chart.show()
    chart.refresh(20.0)
    drawn = chart.canvas.content.lines[0].values
    assert np.isnan(drawn[::5]).all()
    assert np.isfinite(drawn[1:5]).all()


def test_a_hidden_chart_is_not_drawn(chart):
    drawn = chart.canvas.content
    chart.hide()
    chart.refresh(45.0)
    assert chart.canvas.content is drawn


def test_the_menu_does_what_the_keys_do(chart):
    actions = {each.text().partition("\t")[0]: each for each in chart.make_menu().actions()}
    actions["Pause the picture"].trigger()
    assert chart.is_paused
    actions["Always show zero"].trigger()
    assert chart.is_zero_shown


def test_it_is_painted_light_and_dark(chart, workspace):
    workspace.preferences.set("theme", "light")
    light = chart.grab().toImage()
    workspace.preferences.set("theme", "dark")
    dark = chart.grab().toImage()
    corner = chart.canvas.mapFromScene(chart.canvas.view.sceneBoundingRect().topLeft())
    place = chart.canvas.pos() + corner + QPoint(4, 4)
    assert light.pixelColor(place) == workspace.look.colour("field").fromString("#ffffff")
    assert dark.pixelColor(place) == workspace.look.colour("field")


def test_it_says_what_it_is(chart):
    assert chart.accessibleName() == "Chart Velocity"
    assert "ramp, wave" in chart.accessibleDescription()


def test_a_curve_on_a_line_of_the_grid_is_seen(workspace, qtbot, qapp):
    """A smooth line of 1.5 pixels covers a row of them whole at every other height of the chart.

    Which one that is depends on the heights of texts.
    """
    chart = StripChart(workspace)
    qtbot.addWidget(chart)
    chart.add_curve("error", "m", source_of(0.0 * TIME))
    chart.show()
    ink, seen = workspace.look.curve(0), []
    for height in (300, 301):
        chart.resize(500, height)
        chart.refresh(40.0)
        qapp.processEvents()
        picture = chart.grab().toImage()
        column = (picture.pixelColor(picture.width() // 2, y) for y in range(picture.height()))
        seen.append(ink in column)
    assert any(seen)
