"""A log in the charts: read beside the app, scrubbed and played, refused with a sentence."""

import contextlib
import math
import threading
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
import pytest
from mcap.reader import make_reader
from PyQt6.QtCore import QPoint, Qt
from PyQt6.QtTest import QTest
from PyQt6.QtWidgets import QApplication, QPushButton

from workbench.common.errors import WorkbenchError
from workbench.gui.charts.chart_kind import STEP_CHART, XY_CHART
from workbench.gui.charts.curve import CurveStyle
from workbench.gui.number_field import NumberField
from workbench.gui.visualization.derived_signals import DerivedSignal
from workbench.gui.visualization.layouts import ChartLayout, ChartSpec
from workbench.gui.visualization.log_bar import LogBar, LogClock
from workbench.gui.visualization.log_worker import (
    drawable_flight,
    live_name,
    short_series_name,
    si_unit,
)
from workbench.gui.visualization.overlays import Overlay
from workbench.gui.visualization.signal_catalog import signal_label
from workbench.link.backplane import Sampled
from workbench.logs.flight_log import FlightLog

LIMIT = 60_000
"""For a process to start and read [ms]."""


@pytest.fixture(scope="module")
def log(canned, tmp_path_factory) -> Path:
    view = canned.views[0]
    path = tmp_path_factory.mktemp("logs") / "flight.mcap"
    made = FlightLog(path, view.topics, view.scenario, {}, dict(view.values), view.vehicle.name)
    for some in canned.published:
        for each in some:
            made.write(Sampled(each, (1.0,) + 12 * (0.0,)))
    made.close()
    return path


@pytest.fixture(scope="module")
def drawn(log):
    """What the process of a reader tells of the log."""
    return drawable_flight(log, lambda _: None)


@pytest.fixture
def shown(begun, drawn):
    begun._reader.ready.emit(drawn)
    assert begun.shows_log
    return begun


def test_a_name_without_end_is_shortened_and_stays_the_only_one():
    assert short_series_name("imu.q_WS.0", {}) == "imu.q_WS.0"
    first = short_series_name("x" * 1_000_000, {})
    assert first == "x" * 200 + "… (1,000,000 characters)"
    assert short_series_name("x" * 1_000_000, {first: "m"}) == f"{first} 2"


def test_series_are_those_of_the_flight_by_the_same_names(canned, workspace, log):
    shares = []
    source = drawable_flight(log, shares.append)
    workspace.signals.begin(canned.views[0].topics)
    for some in canned.published:
        workspace.signals.add(some)
    for name in (
        "velocity_data.v_x",
        "rotors.thrust.3",
        "command_velocity.v_x",
        "imu.specific_force.2",
        "imu.q_WS.0",
        "gps.latitude",
        "gps.velocity.0",
        "lidar.nearest",
    ):
        time, values = source.series(name)
        flown_time, flown = workspace.signals.series(name)
        assert np.allclose(time[-20:], flown_time[-20:]), name
        assert np.allclose(values[-20:], flown[-20:], rtol=1e-6, atol=1e-9), name
        assert source.units[name] == workspace.signals.units[name], name
    assert shares == sorted(shares)
    assert shares[-1] == pytest.approx(1.0)


def test_an_unknown_series_is_named(drawn):
    with pytest.raises(WorkbenchError, match="unknown signal of flight.mcap, 'velocity_data.v_q'"):
        drawn.series("velocity_data.v_q")


def test_names_of_a_log_are_those_of_a_flight():
    assert live_name("imu.linear_acceleration.y") == "imu.specific_force.1"
    assert live_name("imu.orientation.w") == "imu.q_WS.0"
    assert live_name("magnetometer.magnetic_field.z") == "magnetometer.magnetic_field.2"
    assert live_name("velocity_data.v_x") == "velocity_data.v_x"
    assert live_name("imu.orientation_covariance.3") is None
    assert live_name("estimate.sigma_roll") == "estimate.sigma_roll"
    assert live_name("estimated_odometry.pose.pose.position.x") is None
    assert si_unit("deg") == ("rad", math.pi / 180.0)


def test_a_log_is_marked_and_leads_back_to_live(shown, canned):
    assert "LOG" in shown.log_bar.name.text()
    assert "flight.mcap" in shown.log_bar.name.text()
    assert not shown.tabs.isTabEnabled(1)
    pane = shown.charts.board.panes[0]
    assert pane.chart.canvas.content.x_label == "s"
    assert len(pane.chart.canvas.content.lines) == 6
    scene, last = shown.workspace.scene, canned.views[-1].snapshot
    assert scene.log == "flight.mcap"
    assert scene.track.at(last.time)[:3, 3] == pytest.approx(last.p_WB, abs=0.05)
    QTest.mouseClick(shown.log_bar.back, Qt.MouseButton.LeftButton)
    assert scene.log == "" and scene.track is None
    assert not shown.shows_log
    assert shown.tabs.isTabEnabled(1)
    assert pane.chart.canvas.content.x_label == "s from now"


def test_numbers_follow_a_replay_only_as_often_as_they_are_legible(shown, monkeypatch, qtbot):
    """The crosshair moves each time; once the replay rests, numbers are those of its time."""
    board = shown.charts.board
    chart, written = board.panes[0].chart, []
    show = chart.legend.show_entries
    monkeypatch.setattr(
        chart.legend, "show_entries", lambda entries: (written.append(entries), show(entries))
    )
    for time in range(100, 200):
        board.point_at(0.01 * time)
    assert chart.cursor_time == 0.01 * 199 and written == []
    qtbot.waitUntil(lambda: bool(written))
    assert len(written) == 1
    assert written[0] == chart._model.entries(0.01 * 199)


def test_the_time_bar_scrubs(shown):
    bar, pane = shown.log_bar, shown.charts.board.panes[0]
    assert bar.slider.maximum() == 300
    bar.slider.setValue(150)
    assert pane.chart.window_ends == pytest.approx((0.0, 3.0), abs=0.02)  # the whole log
    assert pane.chart.cursor_time == 1.5
    pane.chart.follow()
    bar.slider.setValue(151)
    bar.slider.setValue(150)
    assert pane.chart.window_ends[1] == 1.5
    assert max(line.time[-1] for line in pane.chart.canvas.content.lines) <= 1.5
    assert bar.time.text() == "1.50 of 0.00 to 3.00\N{NO-BREAK SPACE}s"
    assert shown.workspace.scene.time == 1.5
    bar.slider.setFocus()
    QTest.keyClick(bar.slider, Qt.Key.Key_Right)
    assert bar.clock.time == pytest.approx(1.6)
    QTest.mouseClick(bar.earlier, Qt.MouseButton.LeftButton)
    assert bar.clock.time == pytest.approx(1.5)


def test_the_time_bar_of_a_log_that_began_in_flight_begins_with_its_first_sample(drawn, qtbot):
    assert (drawn.begin, drawn.end) == pytest.approx((0.0, 3.0), abs=0.02)
    bar = LogBar()
    qtbot.addWidget(bar)
    bar.show_log(drawn.between(1.0, 2.0))
    assert (bar.slider.minimum(), bar.slider.maximum()) == (100, 200)
    assert bar.time.text() == "2.00 of 1.00 to 2.00\N{NO-BREAK SPACE}s"
    bar.slider.setFocus()
    QTest.keyClick(bar.slider, Qt.Key.Key_Home)
    assert bar.clock.time == 1.0
    bar.clock.step(-1)
    assert bar.clock.time == 1.0
    with qtbot.waitSignal(bar.whole_wanted) as wanted:
        QTest.mouseClick(bar.whole, Qt.MouseButton.LeftButton)
    assert wanted.args == [1.0, 2.0]


def test_all_of_a_log_is_seen_at_once(shown):
    QTest.mouseClick(shown.log_bar.whole, Qt.MouseButton.LeftButton)
    left, right = shown.charts.board.panes[0].chart.window_ends
    assert (left, right) == pytest.approx((0.0, 3.0), abs=0.02)


def test_a_log_plays_to_its_end(shown, qtbot):
    bar = shown.log_bar
    bar.speed.setCurrentText("10 ×")
    QTest.mouseClick(bar.play, Qt.MouseButton.LeftButton)
    assert bar.clock.plays
    qtbot.waitUntil(lambda: not bar.clock.plays, timeout=LIMIT)
    assert bar.clock.time == bar.clock.end
    assert bar.play.text() == "&Play"


def test_the_live_flight_does_not_disturb_a_log(shown, canned):
    before = shown.charts.board.panes[0].chart.window_ends
    shown.show_view(canned.views[-1])
    shown.begin(canned.views[0])
    assert shown.charts.board.panes[0].chart.window_ends == before
    assert len(shown.charts.board.panes[0].chart.canvas.content.lines) == 6


@pytest.mark.parametrize(
    ("content", "said"), [(b"not a log at all", "not an MCAP file"), (b"", "empty")]
)
def test_what_is_no_log_is_refused_with_a_sentence(begun, told, qtbot, tmp_path, content, said):
    path = tmp_path / "other.mcap"
    path.write_bytes(content)
    begun.open_log(path)
    qtbot.waitUntil(lambda: bool(told), timeout=LIMIT)
    assert said in told[0].what
    assert not begun.shows_log
    assert not begun.is_reading


def test_a_reader_that_dies_is_a_sentence_with_the_file(
    begun, log, told, qtbot, tmp_path, monkeypatch
):
    killed = "import os, signal; os.kill(os.getpid(), signal.SIGKILL)"
    (tmp_path / "sitecustomize.py").write_text(killed)
    monkeypatch.setenv("PYTHONPATH", str(tmp_path))
    begun.open_log(log)
    qtbot.waitUntil(lambda: bool(told), timeout=LIMIT)
    assert told[0].what.startswith(f"{log}: the log reader's process was killed")
    assert not begun.is_reading


def test_reading_moves_no_button_and_can_be_cancelled_and_leaves_nothing(begun, log):
    threads = set(threading.enumerate())
    place = begun.open_button.mapTo(begun, QPoint())
    begun.open_log(log)
    assert begun.is_reading and begun.cancel.isVisible()
    QApplication.processEvents()
    assert begun.open_button.mapTo(begun, QPoint()) == place
    QTest.mouseClick(begun.cancel, Qt.MouseButton.LeftButton)
    assert not begun.is_reading
    assert not begun.cancel.isVisible()
    assert set(threading.enumerate()) <= threads


def test_a_reader_that_is_no_longer_wanted_ends_all_that_it_started(
    begun, log, qtbot, tmp_path, monkeypatch
):
    """Its own process would go on reading, and leave its files."""
    monkeypatch.setenv("TMPDIR", str(tmp_path))
    with log.open("rb") as file:
        first, *_ = make_reader(file).get_summary().chunk_indexes
    end = first.chunk_start_offset + first.chunk_length
    data, big = log.read_bytes()[:end], tmp_path / "big.mcap"
    big.write_bytes(data + data[first.chunk_start_offset :] * 500)
    begun.open_log(big)
    # its own process reads: one that was just being started ends a moment later, by the kernel
    qtbot.waitUntil(
        lambda: any(each.stat().st_size for each in tmp_path.glob("*/progress")), timeout=LIMIT
    )
    QTest.mouseClick(begun.cancel, Qt.MouseButton.LeftButton)
    qtbot.waitUntil(lambda: [*tmp_path.iterdir()] == [big], timeout=LIMIT)
    assert not begun.is_reading
    folder = str(tmp_path)
    for file in Path("/proc").glob("[0-9]*/fd/*"):
        with contextlib.suppress(OSError):
            assert not str(file.readlink()).startswith(folder)


def test_the_newest_of_two_logs_wins(begun, log, told, qtbot, tmp_path):
    (tmp_path / "bad.mcap").write_bytes(b"nothing")
    begun.open_log(tmp_path / "bad.mcap")
    begun.open_log(log)
    qtbot.waitUntil(lambda: begun.shows_log, timeout=LIMIT)
    assert told == []


def test_a_clock_loops():
    clock = LogClock(0.0, 10.0)
    clock.play()
    assert clock.time == 0.0
    clock.speed = 2.0
    clock.advance(4.0)
    assert clock.time == 8.0
    clock.loops = True
    clock.advance(1.5)
    assert clock.time == pytest.approx(1.0)
    clock.loops = False
    clock.advance(9.0)
    assert (clock.time, clock.plays) == (10.0, False)


def test_a_step_stops_the_clock_and_stays_within_the_log():
    clock = LogClock(0.0, 1.0)
    clock.go_to(0.55)
    clock.play()
    clock.step(1)
    assert not clock.plays
    assert clock.time == pytest.approx(0.65)
    clock.step(-20)
    assert clock.time == 0.0


def test_a_log_is_drawn_over_the_live_flight_with_its_time_shifted(
    begun, log, workspace, canned, qtbot
):
    for some in canned.published:
        workspace.signals.add(some)
    begun.show_view(canned.views[-1])
    page = begun.charts
    top = page.board.panes[0].mapTo(page, QPoint()).y()
    begun.open_overlay(log)
    qtbot.waitUntil(lambda: len(page.overlays.overlays) == 1, timeout=LIMIT)
    qtbot.waitUntil(lambda: page.overlays.y() > 0)
    assert page.board.panes[0].mapTo(page, QPoint()).y() == top
    assert page.overlays.y() > top
    assert not begun.shows_log
    (overlay,) = page.overlays.overlays
    chart = page.board.panes[0].chart
    chart.redraw()
    content = chart.canvas.content
    live, paler = content.lines[0], content.lines[1]
    assert len(content.lines) == 12
    assert (paler.style, paler.colour) == (CurveStyle.FAINT, live.colour)
    assert chart.curves[1].label == "v_x · flight"
    (field,) = page.overlays.findChildren(NumberField)
    field.setFocus()
    field.selectAll()
    QTest.keyClicks(field, "-0.5")
    QTest.keyClick(field, Qt.Key.Key_Return)
    chart.redraw()
    shifted = chart.canvas.content.lines[1]
    rises = [line.time[np.argmax(line.values > 0.5)] for line in (paler, shifted)]
    assert rises[0] - rises[1] == pytest.approx(0.5, abs=0.1)
    align, remove = page.overlays.findChildren(QPushButton)
    QTest.mouseClick(align, Qt.MouseButton.LeftButton)
    assert overlay.shift == pytest.approx(0.0, abs=1e-6)
    assert field.si == overlay.shift
    page._take(DerivedSignal("own.twice", "m/s", "2*velocity_data.v_x"), None)
    assert chart.curves[-1].label == "twice · flight"
    assert np.allclose(
        chart.curves[-1].samples(1.0)[1][1:9], 2 * overlay.series("velocity_data.v_x", 1.0)[1][1:9]
    )
    QTest.mouseClick(remove, Qt.MouseButton.LeftButton)
    assert len(chart.curves) == 7
    assert not page.overlays.isVisible()


def test_a_log_is_aligned_by_its_first_step_to_that_of_another():
    """It steps at 2 s, the other one at 5 s; what it had at 2 s is then at 5 s."""
    overlay = Overlay("a", SteppedCommand(2.0))
    overlay.align(SteppedCommand(5.0))
    assert overlay.shift == 3.0
    time, values = overlay.series("command_velocity.v_x")
    assert time[np.argmax(values > 0.0)] == 5.0


def test_logs_without_a_common_event_are_not_aligned(begun, drawn, told):
    overlay = Overlay("a", drawn)
    with pytest.raises(WorkbenchError, match="a: there is no command step or take-off"):
        overlay.align(Overlay("b", begun.charts._live))


@dataclass
class SteppedCommand:
    """A source of a command that steps at a time [s]."""

    at: float
    units = {"command_velocity.v_x": "m/s"}

    def series(self, name, since=-np.inf):
        time = np.arange(10.0)
        return time, 1.0 * (time >= self.at)


@dataclass
class OneSignal:
    """A source of one signal: 1, 2, 3 at 0, 1, 2 s."""

    units: dict[str, str]

    def series(self, name, since=-np.inf):
        assert name in self.units
        time = np.arange(3.0)
        return time[time >= since], np.arange(1.0, 4.0)[time >= since]


def test_a_shifted_log_is_read_from_the_time_that_is_asked_for_on():
    """Its 1 s is 3 s here."""
    overlay = Overlay("real", OneSignal({"a": "m"}))
    overlay.shift = 2.0
    time, values = overlay.series("a", 3.0)
    assert (list(time), list(values)) == ([3.0, 4.0], [2.0, 3.0])


def test_an_estimate_is_drawn_over_the_true_motion_and_a_log_without_either_is_reported(
    begun, drawn, told
):
    page = begun.charts
    page.show_layout(ChartLayout(charts=(ChartSpec("Speed", ("velocity_data.v_x",)),)))
    before = len(told)
    page.add_overlay("real", OneSignal({"estimate.v_x": "m/s"}))
    (chart,) = (pane.chart for pane in page.board.panes)
    assert chart.curves[-1].label == f"{signal_label('estimate.v_x')} · real"
    assert list(chart.curves[-1].samples(0.0)[1]) == [1.0, 2.0, 3.0]
    assert len(told) == before
    page.add_overlay("other", OneSignal({"motors.command_1": "1"}))
    assert told[-1].what == "the overlay other has none of the signals in these charts"


def test_paths_and_steps_of_a_log_stand_beside_those_of_the_flight(
    begun, drawn, workspace, canned, qtbot, mouse_on
):
    for some in canned.published:
        workspace.signals.add(some)
    page = begun.charts
    page.show_layout(
        ChartLayout(
            charts=(
                ChartSpec("Path", ("position_data.x", "position_data.z"), XY_CHART),
                ChartSpec("Steps", ("command_velocity.v_x", "velocity_data.v_x"), STEP_CHART),
                ChartSpec("Speed", ("velocity_data.v_x",)),
            )
        )
    )
    begun.show_view(canned.views[-1])
    page.add_overlay("b", drawn)
    path, steps, speed = (pane.chart for pane in page.board.panes)
    path.redraw()
    ours, theirs = path.canvas.content.lines
    assert np.allclose(theirs.time, ours.time, atol=1e-5)
    assert np.allclose(theirs.values, ours.values, atol=1e-5)
    assert path.legend.entries[1].label == "z · b over x"
    qtbot.waitUntil(lambda: len(steps.steps) == 2)
    assert [entry.label for entry in steps.legend.entries[:2]] == ["step 1", "step 1 · b"]
    live, logged = (each.metrics.rise_time for each in steps.steps)
    assert logged == pytest.approx(live, rel=1e-3)
    page.board.set_paused(True)
    mouse_on(speed).drag((-9.0, 0.5), (-4.0, 0.5), Qt.KeyboardModifier.ShiftModifier)
    assert page.overlays.overlays[0].shift == pytest.approx(5.0, abs=0.15)
    assert speed.window_ends[1] - speed.window_ends[0] == pytest.approx(20.0)


@pytest.mark.parametrize(
    ("clock_start", "shown_start", "since"),
    [
        (52.25, 52.25, "since the start of its clock"),
        (1_700_000_000.0, 80_000.0, "since midnight UTC"),  # 14 November 2023, 22:13:20
    ],
)
def test_times_are_those_of_the_logs_own_clock_on_demand(
    begun, drawn, qtbot, clock_start, shown_start, since
):
    """By hand: 22 h 13 min 20 s are 80,000 s."""
    begun._reader.ready.emit(replace(drawn, clock_start=clock_start))
    bar, chart = begun.log_bar, begun.charts.board.panes[0].chart
    begun.charts.board.show_window(1.0, 2.0)
    before = bar.time.text()
    assert chart.canvas.content.origin == 0.0
    qtbot.mouseClick(bar.absolute, Qt.MouseButton.LeftButton)
    assert since in bar.absolute.toolTip()
    assert chart.canvas.content.origin == -shown_start
    words = bar.time.text().replace("of", "to").removesuffix("\N{NO-BREAK SPACE}s").split(" to ")
    clock = (bar.clock.time, bar.clock.begin, bar.clock.end)
    expected = [each + shown_start for each in clock]
    assert list(map(float, words)) == pytest.approx(expected, abs=0.006)
    chart.set_mark("A", 1.5)
    assert float(chart._model.mark_heads[0].split()[2]) == pytest.approx(1.5 + shown_start)
    begun._reader.ready.emit(drawn)
    assert not bar.absolute.isEnabled() and bar.time.text() == before
    assert chart.canvas.content.origin == 0.0
