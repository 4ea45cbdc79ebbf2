"""The Visualization screen over a canned flight, by mouse and keyboard."""

import math
from dataclasses import replace

import numpy as np
import pytest
from PyQt6.QtCore import QMimeData, QPointF, Qt
from PyQt6.QtGui import QDropEvent
from PyQt6.QtTest import QTest
from PyQt6.QtWidgets import QApplication

from workbench.gui.visualization.cloud_view import SLANTED_VIEWPOINT, TOP_VIEWPOINT
from workbench.gui.visualization.layouts import MAX_BOARD_CHARTS, ChartSpec, read_stored_layout
from workbench.gui.visualization.signal_tree import SIGNAL_MIME_TYPE
from workbench.gui.visualization.visualization_screen import VisualizationScreen
from workbench.link.backplane import Published
from workbench.systems.sensors.readings import DepthImage


@pytest.fixture
def screen(begun, workspace, canned):
    """The screen at the end of the flight."""
    workspace.flight.streamed.emit([each for some in canned.published for each in some])
    begun.show_view(canned.views[-1])
    return begun


def titles(screen):
    return [pane.title for pane in screen.charts.board.panes]


def test_the_first_charts_are_useful_at_once(screen):
    assert titles(screen) == [
        "Velocity and command",
        "Attitude",
        "Rotor thrusts",
        "Velocity error",
    ]
    assert all(len(pane.chart.canvas.content.lines) >= 3 for pane in screen.charts.board.panes)
    assert screen.charts.board.panes[0].chart.canvas.content.right == pytest.approx(3.0, abs=0.02)


def test_the_error_is_command_minus_response(screen):
    source = screen.charts._source
    time, error = source.series("error.v_x")
    _, wanted = source.series("command_velocity.v_x")
    _, flown = source.series("velocity_data.v_x")
    assert len(time) > 300
    assert np.allclose(error, wanted - flown)
    assert error.max() > 0.5


def test_signals_are_found_by_words_in_any_order(screen):
    tree = screen.charts.tree
    QTest.keyClicks(tree.search, "thrust rotors")
    assert tree.names() == [f"rotors.thrust.{rotor}" for rotor in range(len(tree.names()))]
    assert len(tree.names()) >= 4
    tree.search.setText("rad/s wdot")
    assert "acceleration_data.wdot_x" in tree.names()
    tree.search.setText("(no such")
    assert tree.names() == []


def test_enter_adds_the_signal_to_the_chart_in_use(screen):
    pane = screen.charts.board.panes[1]
    pane.chart.setFocus()
    assert "Attitude" in screen.charts.tree.target.text()
    QTest.keyClicks(screen.charts.tree.search, "velocity_data.w_z")
    QTest.keyClick(screen.charts.tree.search, Qt.Key.Key_Return)
    assert pane.spec.signals[-1] == "velocity_data.w_z"
    assert pane.chart.canvas.content.axes[1].unit.symbol == "°/s"


def test_enter_in_the_tree_adds_too(screen):
    tree, pane = screen.charts.tree, screen.charts.board.panes[0]
    tree.search.setText("wind")
    tree.view.setFocus()
    model = tree.view.model()
    tree.view.setCurrentIndex(model.index(0, 0, model.index(0, 0)))
    QTest.keyClick(tree.view, Qt.Key.Key_Return)
    assert pane.spec.signals[-1] == "wind.wind.0"


def test_signals_are_dropped_on_a_chart(screen):
    pane = screen.charts.board.panes[2]
    data = QMimeData()
    data.setData(SIGNAL_MIME_TYPE, b"imu.specific_force.0\nimu.specific_force.2")
    action, button = Qt.DropAction.CopyAction, Qt.MouseButton.LeftButton
    held = Qt.KeyboardModifier.NoModifier
    pane.dropEvent(QDropEvent(QPointF(50, 50), action, data, button, held))
    assert pane.spec.signals[-2:] == ("imu.specific_force.0", "imu.specific_force.2")


def test_the_tree_drags_names(screen):
    tree = screen.charts.tree
    tree.search.setText("velocity_data.v_x")
    model = tree._model
    top = next(
        model.index(row, 0)
        for row in range(model.rowCount())
        if model.index(row, 0).data() == "Velocity"
    )
    index = model.index(0, 0, top)
    assert model.mimeData([index]).data(SIGNAL_MIME_TYPE).data() == b"velocity_data.v_x"


def test_charts_are_added_up_to_eight_and_removed(screen, told):
    board = screen.charts.board
    for _ in range(MAX_BOARD_CHARTS):
        QTest.mouseClick(screen.charts.add, Qt.MouseButton.LeftButton)
    assert len(board.panes) == MAX_BOARD_CHARTS
    assert "remove one first" in told[-1].what
    board.panes[-1].chart.setFocus()
    QTest.keyClick(board.panes[-1].chart, Qt.Key.Key_Delete, Qt.KeyboardModifier.ShiftModifier)
    assert len(board.panes) == MAX_BOARD_CHARTS - 1


def test_del_removes_the_last_signal(screen):
    pane = screen.charts.board.panes[1]
    pane.chart.setFocus()
    QTest.keyClick(pane.chart, Qt.Key.Key_Delete)
    assert pane.spec.signals == ("position_data.roll", "position_data.pitch")


def test_a_chart_is_split_into_one_for_each_signal(screen):
    pane = screen.charts.board.panes[1]
    pane.split_wanted.emit()
    assert pane.spec.signals == ("position_data.roll",)
    assert titles(screen)[-2:] == ["position_data.pitch", "position_data.yaw"]


def test_charts_are_kept_between_starts(screen, workspace, canned, qtbot):
    screen.charts.board.add_chart(ChartSpec("Mine", ("wind.wind.1",)))
    assert screen.charts.presets.currentText() == "Own"
    again = VisualizationScreen(workspace)
    qtbot.addWidget(again)
    assert again.charts.board.board == screen.charts.board.board
    again.close_screen()


@pytest.mark.parametrize("text", ["", "{", "[]", '[{"title": 3}]', "[1]", '{"a": 1}'])
def test_what_is_no_layout_is_passed_over(text):
    assert read_stored_layout(text) is None


def test_charts_that_an_earlier_version_kept_are_shown():
    kept = read_stored_layout('[{"title": "Mine", "signals": ["wind.wind.1"]}]')
    assert kept.charts == (ChartSpec("Mine", ("wind.wind.1",)),)


def test_a_preset_is_chosen(screen):
    screen.charts.presets.setCurrentText("Sensors")
    screen.charts.presets.activated.emit(screen.charts.presets.currentIndex())
    assert titles(screen)[0] == "Specific force"


def test_a_signal_that_is_not_measured_is_named(screen):
    screen.charts.board.show_board((ChartSpec("Far", ("radar.range",)),), screen.charts._source)
    pane = screen.charts.board.panes[0]
    pane.chart.redraw()
    assert "radar.range" in pane.chart.canvas.content.hint
    assert pane.spec.signals == ("radar.range",)


def test_pause_all_lets_all_pictures_stand(screen):
    QTest.mouseClick(screen.charts.pause, Qt.MouseButton.LeftButton)
    assert all(pane.chart.is_paused for pane in screen.charts.board.panes)
    QTest.mouseClick(screen.charts.pause, Qt.MouseButton.LeftButton)
    assert not any(pane.chart.is_paused for pane in screen.charts.board.panes)


def test_the_list_of_signals_gives_way_on_a_narrow_screen(screen):
    assert screen.charts.tree.isVisible()
    screen.resize(760, 600)
    assert not screen.charts.tree.isVisible()
    QTest.mouseClick(screen.charts.signals_shown, Qt.MouseButton.LeftButton)
    assert screen.charts.tree.isVisible()


def test_it_fits_beside_the_3d_view(screen):
    screen.resize(760, 600)
    QApplication.processEvents()
    assert screen.minimumSizeHint().width() <= 760
    assert screen.minimumSizeHint().height() <= 600


def test_it_does_not_make_its_window_larger(workspace, qtbot):
    screen = VisualizationScreen(workspace)
    qtbot.addWidget(screen)
    screen.resize(760, 600)
    screen.show()
    QApplication.processEvents()
    assert (screen.width(), screen.height()) == (760, 600)
    assert "open a scenario" in screen.charts.board.panes[0].chart.canvas.content.hint
    screen.close_screen()


def test_the_cloud_is_where_the_room_is(screen, canned):
    screen.tabs.setCurrentWidget(screen.cloud)
    screen.show_view(canned.views[-1])
    view = screen.cloud.view
    assert len(view.points) > 500
    snapshot = canned.views[-1].snapshot
    lowest = np.percentile(view.points[:, 2], 1.0)
    assert lowest == pytest.approx(-snapshot.p_WB[2], abs=0.15)
    nearest = np.linalg.norm(view.points, axis=1).min()
    assert nearest == pytest.approx(snapshot.lidar.nearest, abs=0.5)
    assert "rays returned" in screen.cloud.said.text()


def test_the_cloud_turns_by_keys_and_mouse(screen):
    screen.tabs.setCurrentWidget(screen.cloud)
    view = screen.cloud.view
    view.setFocus()
    QTest.keyClick(view, Qt.Key.Key_T)
    assert view.viewpoint.tilt == TOP_VIEWPOINT.tilt
    QTest.keyClick(view, Qt.Key.Key_P)
    QTest.keyClick(view, Qt.Key.Key_Left)
    assert view.viewpoint.turn == pytest.approx(SLANTED_VIEWPOINT.turn + math.radians(10.0))
    QTest.keyClick(view, Qt.Key.Key_Plus)
    assert view.viewpoint.width == pytest.approx(32.0)
    view.grab()


def test_a_camera_that_is_off_is_switched_on_by_a_button(screen, canned, workspace, monkeypatch):
    view, started = canned.views[-1], []
    monkeypatch.setattr(workspace.flight, "_view", view)
    monkeypatch.setattr(workspace.flight, "fly", lambda what, draw: started.append(what))
    screen.tabs.setCurrentWidget(screen.camera)
    assert "depth camera is off" in screen.camera.depth_view.hint
    QTest.mouseClick(screen.camera.offer.button, Qt.MouseButton.LeftButton)
    assert started[0].sensors.use == [*view.scenario.sensors.use, "depth_camera"]
    assert "depth_camera" not in view.scenario.sensors.use
    assert started[0].script == view.scenario.script


def test_a_drone_without_a_camera_says_so_and_offers_none(screen, canned):
    vehicle = canned.views[-1].vehicle
    others = tuple(each for each in vehicle.sensors if each.kind != "depth_camera")
    bare = replace(canned.views[-1], vehicle=replace(vehicle, sensors=others))
    screen.tabs.setCurrentWidget(screen.camera)
    screen.begin(bare)
    assert screen.camera.depth_view.hint == "dh_drone has no depth camera in its description."
    assert not screen.camera.offer.isVisible()
    screen.tabs.setCurrentWidget(screen.cloud)
    assert not screen.cloud.offer.isVisible()  # the lidar measures


def test_a_colour_of_the_depth_image_keeps_its_meaning(screen):
    """Near ones come after far ones, and pictures without any change nothing."""
    shown = []
    for stamp, depths in enumerate(([2.0, 8.0], [2.0, 3.0], [np.inf, np.inf], [0.4, 9.0])):
        depth = np.array([depths], dtype=np.float32)
        reading = DepthImage(float(stamp), "camera", np.zeros(3), np.eye(3), None, depth, None)
        screen.camera.show_reading(reading)
        shown.append(screen.camera.depth_view.scale.levels())
    assert shown == [(2.0, 8.0), (2.0, 8.0), (2.0, 8.0), (0.0, 10.0)]


def test_frames_show_where_the_drone_is(screen, canned):
    screen.tabs.setCurrentWidget(screen.frames)
    screen.show_view(canned.views[-1])
    (item,) = screen.frames.tree.findItems("base_link", Qt.MatchFlag.MatchRecursive)
    texts = [item.text(column) for column in range(1, 10)]
    place = canned.views[-1].snapshot.p_WB
    assert float(texts[0].replace("\N{MINUS SIGN}", "-")) == pytest.approx(place[0], abs=0.05)
    assert texts[0] == texts[6]


def test_frames_are_searched(screen):
    QTest.keyClicks(screen.frames.search, "lidar")
    found = screen.frames.tree.findItems(
        "", Qt.MatchFlag.MatchRecursive | Qt.MatchFlag.MatchContains
    )
    shown = [item.text(0) for item in found if not item.isHidden()]
    assert "base_link" in shown
    assert any("lidar" in name for name in shown)
    assert not any("propeller" in name for name in shown)


def test_events_have_times(screen, workspace, canned):
    topic = next(each for each in canned.views[0].topics if each.name == "/dh_drone/events")
    payload = topic.pack([1, "battery low"])
    workspace.flight.streamed.emit([Published(2_500_000_000, 0, ((topic.id, payload),))])
    table = screen.events.table
    assert [table.item(0, column).text() for column in range(3)] == [
        "2.50",
        "warning",
        "battery low",
    ]


def test_a_flight_that_begins_anew_forgets(screen, canned):
    screen.begin(canned.views[0])
    assert not screen.events.events


def test_everything_that_takes_the_focus_has_a_name(screen):
    from PyQt6.QtWidgets import QAbstractButton, QComboBox, QLineEdit, QSlider

    for kind in (QAbstractButton, QComboBox, QLineEdit, QSlider):
        for widget in screen.findChildren(kind):
            if widget.focusPolicy() != Qt.FocusPolicy.NoFocus and widget.isEnabled():
                named = widget.accessibleName() or getattr(widget, "text", str)()
                assert named or widget.objectName().startswith("qt_"), widget


def test_several_selected_signals_are_added_at_once(screen):
    tree, pane = screen.charts.tree, screen.charts.board.panes[1]
    tree.search.setText("specific_force")
    model = tree.view.model()
    top = model.index(0, 0)
    tree.view.setCurrentIndex(model.index(0, 0, top))
    tree.view.setFocus()
    QTest.keyClick(tree.view, Qt.Key.Key_Down, Qt.KeyboardModifier.ShiftModifier)
    pane.chart.setFocus()
    QTest.keyClick(tree.view, Qt.Key.Key_Return)
    assert pane.spec.signals[-2:] == ("imu.specific_force.0", "imu.specific_force.1")
