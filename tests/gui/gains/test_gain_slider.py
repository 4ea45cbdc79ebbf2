"""The slider: what keys, pointer and wheel ask for, and what it shows."""

import pytest
from PyQt6.QtCore import QPoint, QPointF, Qt
from PyQt6.QtGui import QWheelEvent
from PyQt6.QtTest import QTest
from PyQt6.QtWidgets import QApplication

from workbench.gui.gains.gain_scale import GainScale, StepSize
from workbench.gui.gains.gain_slider import GainSlider
from workbench.gui.units import Unit
from workbench.scenario.parameters import parameter_table

LEFT = Qt.MouseButton.LeftButton
NONE = Qt.KeyboardModifier.NoModifier
SHIFT = Qt.KeyboardModifier.ShiftModifier
CONTROL = Qt.KeyboardModifier.ControlModifier
WIDTH, EDGE = 218, 9
"""So that the track is 200 pixels long, and a pixel half a percent."""


@pytest.fixture
def slider(workspace, qtbot):
    made = GainSlider(GainScale(parameter_table().find("rotor_1"), Unit("")), workspace.look)
    qtbot.addWidget(made)
    made.resize(WIDTH, 25)
    made.show_value(0.5, 0.5)
    made.show()
    return made


@pytest.fixture
def heard(slider):
    said = []
    slider.dragged.connect(lambda place: said.append(("dragged", place)))
    slider.stepped.connect(lambda way, size: said.append(("stepped", way, size)))
    slider.edit_begun.connect(lambda: said.append(("begun",)))
    slider.edit_ended.connect(lambda: said.append(("ended",)))
    return said


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


def test_a_drag_is_one_movement(slider, heard):
    QTest.mousePress(slider, LEFT, pos=at(0.5))
    QTest.mouseMove(slider, at(0.6))
    QTest.mouseMove(slider, at(0.75))
    QTest.mouseRelease(slider, LEFT, pos=at(0.75))
    assert heard[0] == ("begun",)
    assert heard[1:3] == [("dragged", pytest.approx(0.6)), ("dragged", pytest.approx(0.75))]
    assert heard[-1] == ("ended",)


def test_a_drag_beyond_the_end_stays_at_the_end(slider, heard):
    QTest.mousePress(slider, LEFT, pos=at(0.5))
    QTest.mouseMove(slider, QPoint(900, 12))
    assert heard[-1] == ("dragged", 1.0)


def test_a_press_beside_the_handle_makes_a_coarse_step_and_no_leap(slider, heard):
    QTest.mouseClick(slider, LEFT, pos=at(0.9))
    assert heard == [("begun",), ("stepped", 1, StepSize.COARSE), ("ended",)]
    heard.clear()
    QTest.mouseClick(slider, LEFT, pos=at(0.1))
    assert ("stepped", -1, StepSize.COARSE) in heard


@pytest.mark.parametrize(
    ("key", "modifiers", "way", "size"),
    [
        (Qt.Key.Key_Right, NONE, 1, StepSize.FINE),
        (Qt.Key.Key_Down, NONE, -1, StepSize.FINE),
        (Qt.Key.Key_Up, SHIFT, 1, StepSize.COARSE),
        (Qt.Key.Key_Left, CONTROL, -1, StepSize.FINEST),
        (Qt.Key.Key_PageUp, NONE, 1, StepSize.COARSE),
    ],
)
def test_keys_step(slider, heard, key, modifiers, way, size):
    QTest.keyClick(slider, key, modifiers)
    assert heard == [("begun",), ("stepped", way, size), ("ended",)]


def test_the_end_key_does_not_throw_a_gain_to_its_limit(slider, heard):
    QTest.keyClick(slider, Qt.Key.Key_End)
    QTest.keyClick(slider, Qt.Key.Key_Home)
    assert not [each for each in heard if each[0] in ("stepped", "dragged")]


def test_the_wheel_turns_it_only_with_the_focus(slider, heard, qtbot):
    slider.clearFocus()
    assert not turn(slider, 120).isAccepted()
    assert heard == []
    slider.setFocus()
    qtbot.waitUntil(slider.hasFocus)
    turn(slider, 120)
    turn(slider, -120, CONTROL)
    assert heard == [("stepped", 1, StepSize.FINE), ("stepped", -1, StepSize.FINEST)]


def test_what_the_model_shows_tells_nobody(slider, heard):
    changed = []
    slider.valueChanged.connect(changed.append)
    slider.show_value(0.8, 0.7)
    assert heard == [] and changed == []
    assert slider.value() == 8000


def test_stable_values_are_a_band_with_ends_and_old_ones_are_fainter(slider, workspace):
    slider.show_stable((0.2, 0.9), fresh=True)
    fresh = slider.grab().toImage()
    slider.show_stable((0.2, 0.9), fresh=False)
    old = slider.grab().toImage()
    slider.show_stable(None, fresh=True)
    none = slider.grab().toImage()
    end = at(0.2)
    ends = [image.pixelColor(end.x(), end.y() - 5) for image in (fresh, old, none)]
    ground = none.pixelColor(2, 2)
    assert ends[2] == ground
    distances = [abs(each.red() - ground.red()) + abs(each.blue() - ground.blue()) for each in ends]
    assert distances[0] > distances[1] > 0 or ends[1] == ground  # a dotted mark has gaps
    band = [image.pixelColor(end.x() + 20, end.y()) for image in (fresh, old, none)]
    assert len({colour.name() for colour in band}) == 3


def test_what_is_flown_shows_as_a_ring_where_something_else_is_proposed(slider):
    slider.show_value(0.5, 0.5)
    same = slider.grab().toImage()
    slider.show_value(0.5, 0.8)
    other = slider.grab().toImage()
    ring = at(0.8)
    assert same.pixelColor(ring.x(), ring.y() - 4) != other.pixelColor(ring.x(), ring.y() - 4)
