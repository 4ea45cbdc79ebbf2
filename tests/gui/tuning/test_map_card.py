import numpy as np
import pytest
from PyQt6.QtCore import QPoint, QPointF, Qt
from PyQt6.QtWidgets import QApplication

from workbench.analysis.queries import DrawMap, RequestedStep
from workbench.analysis.replies import Mapped
from workbench.control.controller_file import load_controller
from workbench.gui.tuning.map_card import MapCard, axis_gains
from workbench.gui.tuning.map_view import contour_levels, contour_segments, value_range
from workbench.gui.tuning.trial import NO_TRIAL_STEP_TEXT

STEP = RequestedStep("x", 1.0, 2.0)


def test_a_line_of_equal_value_lies_where_the_value_is():
    x, y = np.meshgrid(np.arange(11.0), np.arange(11.0))
    pieces = contour_segments(np.hypot(x - 5.0, y - 5.0), 3.0)
    ends = np.array(pieces).reshape(-1, 2)
    assert len(pieces) > 12
    assert np.hypot(*(ends - 5.0).T) == pytest.approx(3.0, abs=0.1)


def test_there_is_no_line_beside_what_was_lost():
    values = np.tile(np.arange(5.0), (5, 1))
    values[2, 2] = np.nan
    for x0, y0, x1, y1 in contour_segments(values, 1.5):
        assert not (1.0 < (y0 + y1) / 2.0 < 3.0)
        assert x0 == x1 == 1.5


def test_levels_are_round_and_inside():
    assert contour_levels(0.0, 10.0, 5) == (2.0, 4.0, 6.0, 8.0)
    assert contour_levels(0.31, 0.58, 5) == pytest.approx((0.4, 0.5))
    assert contour_levels(3.0, 3.0, 5) == ()


def test_a_few_values_far_away_do_not_hide_the_others():
    values = np.linspace(0.0, 10.0, 100).reshape(10, 10)
    assert value_range(values) == (0.0, 10.0)
    values[9, 5:] = 1e6
    low, high = value_range(values)
    assert low == 0.0
    assert high < 10.0


def test_a_map_of_nothing_has_no_range():
    assert value_range(np.full((3, 3), np.nan)) == (0.0, 0.0)


def mapped(asked: DrawMap) -> tuple[DrawMap, Mapped]:
    x, y = np.linspace(2.0, 10.0, 9), np.linspace(100.0, 400.0, 7)
    values = np.add.outer(y / 100.0, x)
    values[-1, -1] = np.nan
    return asked, Mapped(x, y, values, "%")


def pixel(view, x: float, y: float) -> QPoint:
    """Return where gains are drawn."""
    QApplication.processEvents()  # a layout may be new
    column = np.interp(x, view.mapped.x, range(len(view.mapped.x)))
    row = np.interp(y, view.mapped.y, range(len(view.mapped.y)))
    return view.mapFromScene(view.getViewBox().mapViewToScene(QPointF(column, row)))


@pytest.fixture
def card(offline, trial, qtbot):
    made = MapCard(offline, trial)
    qtbot.addWidget(made)
    made.resize(420, 330)
    made.show()
    made.begin()
    made.set_seen(True)
    trial.set_step(STEP)
    qtbot.waitUntil(lambda: bool(offline.analysis.of(DrawMap)))
    return made


def test_it_asks_for_the_gains_that_matter_along_the_axis(card, offline, trial):
    asked = offline.analysis.of(DrawMap)[-1]
    assert (asked.x, asked.y, asked.metric) == ("kp_velocity_x", "kp_pitch", "overshoot")
    assert asked.step == STEP
    assert asked.gains == trial.proposed
    trial.set_step(RequestedStep("z", 1.0, 2.0))
    assert card.across.currentData() == "kp_velocity_z"


def test_it_follows_the_proposed_gains_with_one_map_at_a_time(card, offline, trial, gains, qtbot):
    for value in (3.0, 4.0, 5.0):
        gains.propose("kp_velocity_x", value)
    qtbot.wait(300)
    maps = offline.analysis.of(DrawMap)
    assert len(maps) == 1
    offline.analysis.tell(*mapped(maps[0]))
    assert offline.analysis.of(DrawMap)[-1].gains["kp_velocity_x"] == 5.0


def test_a_click_proposes_the_gains_there_as_one_step_of_undo(card, offline, gains, qtbot):
    offline.analysis.tell(*mapped(offline.analysis.of(DrawMap)[-1]))
    before = dict(gains.proposed)
    qtbot.mouseClick(
        card.view.viewport(), Qt.MouseButton.LeftButton, pos=pixel(card.view, 7.0, 200.0)
    )
    assert gains.proposed["kp_velocity_x"] == pytest.approx(7.0, abs=0.1)
    assert gains.proposed["kp_pitch"] == pytest.approx(200.0, abs=5.0)
    gains.undo()
    assert dict(gains.proposed) == before


def test_places_and_gains_map_onto_each_other(card, offline):
    offline.analysis.tell(*mapped(offline.analysis.of(DrawMap)[-1]))
    for x, y in ((2.0, 100.0), (6.5, 275.0), (10.0, 400.0)):
        found = card.view.point_at(QPointF(pixel(card.view, x, y)))
        assert found == (pytest.approx(x, abs=0.03), pytest.approx(y, abs=1.5))
    assert card.view.point_at(QPointF(0.0, 0.0)) is None


def test_arrows_and_enter_propose_too(card, offline, gains, qtbot):
    offline.analysis.tell(*mapped(offline.analysis.of(DrawMap)[-1]))
    card.view.setFocus()
    qtbot.keyClick(card.view, Qt.Key.Key_Right)
    qtbot.keyClick(card.view, Qt.Key.Key_Up)
    assert card.reading.text() == "Velocity x Kp 7, Pitch Kp 300: 10 %"
    qtbot.keyClick(card.view, Qt.Key.Key_Return)
    assert (gains.proposed["kp_velocity_x"], gains.proposed["kp_pitch"]) == (7.0, 300.0)


def test_a_lost_flight_is_hatched_and_called_a_crash(card, offline, qtbot):
    offline.analysis.tell(*mapped(offline.analysis.of(DrawMap)[-1]))
    qtbot.mouseMove(card.view.viewport(), pixel(card.view, 10.0, 400.0))
    assert card.reading.text().endswith(": crashes")


def test_two_equal_gains_make_no_map(card, offline, qtbot):
    asked = len(offline.analysis.asked)
    card.upwards.setCurrentIndex(card.across.currentIndex())
    card.upwards.activated.emit(card.upwards.currentIndex())
    assert card.said.text() == "Choose two different gains."
    assert len(offline.analysis.asked) == asked


def test_a_map_that_is_not_seen_is_not_asked_for(offline, trial, qtbot):
    card = MapCard(offline, trial)
    qtbot.addWidget(card)
    card.begin()
    trial.set_step(STEP)
    qtbot.wait(200)
    assert offline.analysis.of(DrawMap) == []


def test_a_wait_for_the_compiler_says_so(card, offline):
    offline.analysis.preparing.emit("compiling flights: 40 %")
    assert card.said.text() == "Drawing … compiling flights: 40 %"
    offline.analysis.tell(*mapped(offline.analysis.of(DrawMap)[-1]))
    assert card.said.text() == ""


def test_the_colours_have_a_scale_with_the_unit(card, offline):
    """Values of the map are from 3 to 13.5 %, where nothing is lost."""
    offline.analysis.tell(*mapped(offline.analysis.of(DrawMap)[-1]))
    scale = card.view._scale
    assert scale.isVisible()
    assert scale.getAxis("left").labelText == "Overshoot %"
    assert scale.levels() == (3.0, pytest.approx(13.5, abs=0.6))
    assert tuple(card.view._image.levels) == scale.levels()


def test_no_map_is_not_hatched_in_another_look(card, offline):
    card.view.show_map(None)
    offline.look.changed.emit()
    assert not card.view.getViewBox().background.isVisible()


@pytest.mark.parametrize(
    ("law", "axis", "first"),
    [
        ("pd", "x", ["kp_velocity_x", "kp_pitch"]),
        ("pd", "z", ["kp_velocity_z", "kd_velocity_z"]),
        ("pid", "x", ["kp_velocity_xy", "kp_tilt"]),
        ("crazyflie", "yaw", ["pid_attitude_yaw_kp", "pid_rate_yaw_kp"]),
        ("px4", "y", ["MPC_XY_VEL_P_ACC", "MC_ROLL_P"]),
    ],
)
def test_the_first_map_of_an_axis_is_over_the_main_gains_of_its_loops(law, axis, first):
    assert axis_gains(load_controller(law), axis)[:2] == first


def test_a_map_of_an_earlier_step_does_not_stay_for_an_attitude(card, offline, trial, qtbot):
    offline.analysis.tell(*mapped(offline.analysis.of(DrawMap)[-1]))
    assert card.view.mapped is not None
    trial.set_step(RequestedStep("x", 0.5, 2.0))
    qtbot.waitUntil(lambda: len(offline.analysis.of(DrawMap)) == 2)
    trial.set_step(RequestedStep("pitch", 0.1, 1.0))
    qtbot.waitUntil(lambda: card.said.text() == NO_TRIAL_STEP_TEXT)
    assert card.view.mapped is None
    offline.analysis.tell(*mapped(offline.analysis.of(DrawMap)[-1]))
    assert card.view.mapped is None and card.said.text() == NO_TRIAL_STEP_TEXT


def test_gains_beside_the_map_have_no_mark_on_its_edge(card, offline, gains):
    offline.analysis.tell(*mapped(offline.analysis.of(DrawMap)[-1]))
    assert len(card.view._spot.data)
    gains.propose("kp_pitch", 450.0)  # the map ends at 400
    assert not len(card.view._spot.data)
    gains.propose("kp_pitch", 390.0)
    assert len(card.view._spot.data)


def test_a_refused_map_leaves_none_of_an_earlier_step(card, offline, trial, gains, qtbot):
    """One of the same step stays: its gains are named beside it."""

    def refuse(count):
        qtbot.waitUntil(lambda: len(offline.analysis.of(DrawMap)) == count)
        offline.analysis.refused.emit(offline.analysis.of(DrawMap)[-1], "no step of this length")
        assert card.said.text() == "no step of this length"

    offline.analysis.tell(*mapped(offline.analysis.of(DrawMap)[-1]))
    gains.propose("kp_pitch", 333.0)
    refuse(2)
    assert card.view.mapped is not None
    trial.set_step(RequestedStep("x", 1.0, 12.0))
    refuse(3)
    assert card.view.mapped is None


def test_two_equal_gains_leave_no_map_of_an_earlier_step(card, offline, trial, qtbot):
    earlier = offline.analysis.of(DrawMap)[-1]
    offline.analysis.tell(*mapped(earlier))
    trial.set_step(RequestedStep("x", 0.5, 2.0))
    qtbot.waitUntil(lambda: len(offline.analysis.of(DrawMap)) == 2)
    card.upwards.setCurrentIndex(card.across.currentIndex())
    card.upwards.activated.emit(card.upwards.currentIndex())
    for answered in (False, True):
        if answered:  # what was asked before comes too late
            offline.analysis.tell(*mapped(offline.analysis.of(DrawMap)[-1]))
        assert card.view.mapped is None
        assert card.said.text() == "Choose two different gains."
