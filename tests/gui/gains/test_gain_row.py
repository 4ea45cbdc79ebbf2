"""The slider: what keys, pointer and wheel ask for, and what it shows."""

import math

import pytest
from PyQt6.QtCore import QEvent, QPoint, QPointF, Qt
from PyQt6.QtGui import QMouseEvent, QWheelEvent
from PyQt6.QtTest import QTest
from PyQt6.QtWidgets import QApplication

from workbench.common.quantity import DisplayUnit
from workbench.control.controller_file import load_controller
from workbench.gui.charts.ticks import decimals_for_step
from workbench.gui.gains.gain_input import GainSlider
from workbench.gui.gains.gain_scale import GainScale
from workbench.gui.gains.step_key import COARSE_STEP_FACTOR, FINE_STEP_FACTOR, FINEST_STEP_FACTOR

LEFT = Qt.MouseButton.LeftButton
NONE = Qt.KeyboardModifier.NoModifier
SHIFT = Qt.KeyboardModifier.ShiftModifier
CONTROL = Qt.KeyboardModifier.ControlModifier
WIDTH, EDGE = 218, 9
"""So that the track is 200 pixels long, and a pixel half a percent."""
SI = DisplayUnit("")


@pytest.fixture
def slider(workspace, qtbot):
    made = GainSlider(
        GainScale(load_controller().table.find("rotor_1"), DisplayUnit("")), workspace.look
    )
    qtbot.addWidget(made)
    made.resize(WIDTH, 25)
    made.show_value(0.5, 0.5)
    made.show()
    return made


@pytest.fixture
def emitted(slider):
    changes = []
    slider.dragged.connect(lambda place: changes.append(("dragged", place)))
    slider.stepped.connect(lambda way, size: changes.append(("stepped", way, size)))
    slider.edit_begun.connect(lambda: changes.append(("begun",)))
    slider.edit_ended.connect(lambda: changes.append(("ended",)))
    return changes


def at(place):
    return QPoint(round(EDGE + 200 * place), 12)


def turn(slider, angle, modifiers=NONE):
    place = QPointF(at(0.5))
    event = QWheelEvent(
        place,
        slider.mapToGlobal(place),
        QPoint(),
        QPoint(0, angle),
        Qt.MouseButton.NoButton,
        modifiers,
        Qt.ScrollPhase.NoScrollPhase,
        False,
    )
    QApplication.sendEvent(slider, event)
    return event


def test_a_drag_is_one_movement(slider, emitted):
    QTest.mousePress(slider, LEFT, pos=at(0.5))
    QTest.mouseMove(slider, at(0.6))
    QTest.mouseMove(slider, at(0.75))
    QTest.mouseRelease(slider, LEFT, pos=at(0.75))
    assert emitted[0] == ("begun",)
    assert emitted[1:3] == [("dragged", pytest.approx(0.6)), ("dragged", pytest.approx(0.75))]
    assert emitted[-1] == ("ended",)


@pytest.mark.parametrize("held", [SHIFT, CONTROL])
def test_a_key_makes_a_drag_ten_times_finer(slider, emitted, held):
    QTest.mousePress(slider, LEFT, pos=at(0.5))
    place = QPointF(at(0.7))
    moves = QEvent.Type.MouseMove, place, slider.mapToGlobal(place), LEFT, LEFT, held
    QApplication.sendEvent(slider, QMouseEvent(*moves))
    QTest.mouseRelease(slider, LEFT, pos=at(0.7))
    assert emitted[1] == ("dragged", pytest.approx(0.52))


def test_a_drag_beyond_the_end_stays_at_the_end(slider, emitted):
    QTest.mousePress(slider, LEFT, pos=at(0.5))
    QTest.mouseMove(slider, QPoint(900, 12))
    assert emitted[-1] == ("dragged", 1.0)


def test_a_press_beside_the_handle_makes_a_coarse_step_and_no_leap(slider, emitted):
    QTest.mouseClick(slider, LEFT, pos=at(0.9))
    assert emitted == [("begun",), ("stepped", 1, COARSE_STEP_FACTOR), ("ended",)]
    emitted.clear()
    QTest.mouseClick(slider, LEFT, pos=at(0.1))
    assert ("stepped", -1, COARSE_STEP_FACTOR) in emitted


@pytest.mark.parametrize(
    ("key", "modifiers", "way", "size"),
    [
        (Qt.Key.Key_Right, NONE, 1, FINE_STEP_FACTOR),
        (Qt.Key.Key_Down, NONE, -1, FINE_STEP_FACTOR),
        (Qt.Key.Key_Up, SHIFT, 1, COARSE_STEP_FACTOR),
        (Qt.Key.Key_Left, CONTROL, -1, FINEST_STEP_FACTOR),
        (Qt.Key.Key_PageUp, NONE, 1, COARSE_STEP_FACTOR),
    ],
)
def test_keys_step(slider, emitted, key, modifiers, way, size):
    QTest.keyClick(slider, key, modifiers)
    assert emitted == [("begun",), ("stepped", way, size), ("ended",)]


def test_the_end_key_does_not_throw_a_gain_to_its_limit(slider, emitted):
    QTest.keyClick(slider, Qt.Key.Key_End)
    QTest.keyClick(slider, Qt.Key.Key_Home)
    assert not [each for each in emitted if each[0] in ("stepped", "dragged")]


def test_the_wheel_scrolls_the_page_and_steps_it_only_with_ctrl_and_the_focus(
    slider, emitted, qtbot
):
    slider.clearFocus()
    assert not turn(slider, 120, CONTROL).isAccepted()
    slider.setFocus()
    qtbot.waitUntil(slider.hasFocus)
    assert not turn(slider, 120).isAccepted()
    assert emitted == []
    assert turn(slider, 120, CONTROL).isAccepted()
    turn(slider, -120, CONTROL | SHIFT)
    assert emitted == [("stepped", 1, FINE_STEP_FACTOR), ("stepped", -1, COARSE_STEP_FACTOR)]


def test_what_the_model_shows_tells_nobody(slider, emitted):
    changed = []
    slider.valueChanged.connect(changed.append)
    slider.show_value(0.8, 0.7)
    assert emitted == [] and changed == []
    assert slider.value() == 8000


def test_stable_values_are_a_band_with_ends_and_old_ones_are_fainter(slider, workspace):
    slider.show_stable((0.2, 0.9), fresh=True)
    fresh = slider.grab().toImage()
    slider.show_stable((0.2, 0.9), fresh=False)
    old = slider.grab().toImage()
    slider.show_stable(None, fresh=True)
    none = slider.grab().toImage()
    end = at(0.2)
    ground = none.pixelColor(2, 2)

    def ink(image):
        """How far the end's mark stands out, wherever its dots are."""
        column = [image.pixelColor(end.x(), end.y() - up) for up in range(3, 7)]
        return max(abs(c.red() - ground.red()) + abs(c.blue() - ground.blue()) for c in column)

    assert ink(fresh) > ink(old) > ink(none) == 0
    band = [image.pixelColor(end.x() + 20, end.y()) for image in (fresh, old, none)]
    assert len({colour.name() for colour in band}) == 3


def test_what_is_flown_shows_as_a_ring_where_something_else_is_proposed(slider):
    slider.show_value(0.5, 0.5)
    same = slider.grab().toImage()
    slider.show_value(0.5, 0.8)
    other = slider.grab().toImage()
    ring = at(0.8)
    assert same.pixelColor(ring.x(), ring.y() - 4) != other.pixelColor(ring.x(), ring.y() - 4)


def scale_of(name):
    return GainScale(load_controller().table.find(name), SI)


def test_every_row_rises_from_end_to_end_and_comes_back(case):
    for row in load_controller().table:
        with case(row):
            scale = GainScale(row, SI)
            assert scale.place(row.minimum) == pytest.approx(0.0, abs=1e-12)
            assert scale.place(row.maximum) == pytest.approx(1.0)
            values = [scale.value(index / 200) for index in range(201)]
            assert values == sorted(values)
            assert values[0] == row.minimum
            assert values[-1] == pytest.approx(row.maximum)
            if not row.whole:
                for place in (0.1, 0.5, 0.9):
                    assert scale.place(scale.value(place)) == pytest.approx(place)


def test_positive_values_over_a_decade_stand_by_their_ratio():
    scale = scale_of("kp_velocity_z")  # 0.5 .. 30
    assert scale.value(0.5) == pytest.approx((0.5 * 30.0) ** 0.5)


def test_where_zero_is_allowed_doublings_are_even_far_from_it():
    scale = scale_of("kp_roll")  # 0 .. 2500, 150 by default
    first = scale.place(400.0) - scale.place(200.0)
    second = scale.place(800.0) - scale.place(400.0)
    assert first == pytest.approx(second, rel=0.01)
    assert scale.place(0.0) == 0.0


def test_a_share_whose_default_is_an_end_is_spread_evenly():
    assert scale_of("rotor_1").value(0.25) == pytest.approx(0.25)


def test_whole_numbers_stay_whole():
    scale = scale_of("imu_fault")
    assert {scale.value(index / 50) for index in range(51)} == {0.0, 1.0, 2.0, 3.0}
    assert scale.step(2.0) == 1.0


@pytest.mark.parametrize(
    ("name", "value", "step"),
    [
        ("kp_velocity_x", 4.45, 0.1),
        ("kp_roll", 225.0, 5.0),
        ("kd_roll", 27.0, 0.5),
        ("kd_velocity_x", 0.1, 0.002),
        ("kd_velocity_x", 0.0, 0.0002),
    ],
)
def test_a_step_is_some_two_percent_and_round(name, value, step):
    assert scale_of(name).step(value) == step


def test_a_value_beyond_the_limits_stands_at_the_end():
    scale = scale_of("kp_velocity_x")
    assert (scale.place(-5.0), scale.place(99.0)) == (0.0, pytest.approx(1.0))


def test_three_digits_are_kept_as_they_are_shown():
    scale = scale_of("kp_velocity_x")
    assert scale.round_value(0.6) == float(f"{scale.value(0.6):.3g}")
    degrees = GainScale(load_controller().table.find("max_tilt"), DisplayUnit("°", 180.0 / math.pi))
    shown = math.degrees(degrees.round_value(0.5))
    assert shown == pytest.approx(float(f"{shown:.3g}"), abs=1e-12)
    assert degrees.round_value(0.0) == load_controller().table.find("max_tilt").minimum


def test_steps_stay_within_the_limits():
    scale = scale_of("kp_velocity_x")
    assert scale.stepped(3.0, 1, FINE_STEP_FACTOR) == 3.05
    assert scale.stepped(3.0, -1, COARSE_STEP_FACTOR) == 2.75
    assert scale.stepped(29.9, 1, COARSE_STEP_FACTOR) == 30.0
    assert scale_of("imu_fault").stepped(2.0, 1, FINEST_STEP_FACTOR) == 3.0


def test_decimals_show_a_step():
    assert [decimals_for_step(step) for step in (0.5, 0.01, 1.0, 20.0, 0.002)] == [1, 2, 0, 0, 3]
