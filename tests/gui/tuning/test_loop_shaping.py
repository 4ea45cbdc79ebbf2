"""Sliders that shape a loop: what they ask, what they propose, and undo, against python-control."""

import math

import control
import numpy as np
import pytest
from PyQt6.QtCore import QPointF, Qt
from PyQt6.QtTest import QTest

from workbench.design.linear.linearize import linearize

LEFT = Qt.MouseButton.LeftButton


def margins(gains):
    """Phase margin [deg] and bandwidth [rad/s] of the pitch loop, by python-control."""
    frequency = np.geomspace(0.02, 400.0, 4000)
    response = linearize(loop="pitch", gains=gains)(np.exp(1j * frequency / 128.0))
    _, found, _, _, crossings, _ = control.stability_margins(
        control.frd(response, frequency, smooth=True), returnall=True
    )
    size = np.abs(response / (1.0 + response))
    level = size[frequency < 0.05 * crossings.max()][-1] * 10.0**-0.15
    falls = np.nonzero((size[:-1] > level) & (size[1:] <= level))[0]
    return float(np.min(np.abs(found))), float(frequency[falls[0]])


def pitch_gains(screen):
    return {name: screen.gains.proposed[name] for name in ("kp_pitch", "kd_pitch")}


def test_the_sliders_set_what_python_control_finds_and_are_one_step_of_undo(screen, settle):
    card, shaping = screen.frequency, screen.frequency.shaping
    settle(lambda: card.curves.shown)
    card.choose_loop("pitch")
    settle(lambda: "rotor lag" in shaping.said)
    before = pitch_gains(screen)
    assert shaping.bandwidth.value == pytest.approx(margins(before)[1], rel=0.02)
    slider = shaping.phase.slider
    slider.setFocus()
    for _ in range(3):
        QTest.keyPress(slider, Qt.Key.Key_Right, Qt.KeyboardModifier.ShiftModifier)
        QTest.keyRelease(slider, Qt.Key.Key_Right, Qt.KeyboardModifier.ShiftModifier)
        settle(lambda: shaping._base is None)
    wanted, speed = math.degrees(shaping.phase.value), shaping.bandwidth.value
    phase, bandwidth = margins(pitch_gains(screen))
    assert phase == pytest.approx(wanted, abs=1.0) and phase > margins(before)[0] + 3.0
    assert bandwidth == pytest.approx(speed, rel=0.03)
    assert screen.gains.next_undo == "Gains of pitch"
    for _ in range(3):
        screen.gains.undo()
    assert pitch_gains(screen) == before


def test_the_second_slider_sets_the_disk_margin_where_that_is_chosen(screen, settle):
    """α = 1 / max |S - 1/2|, over frequencies."""
    card, shaping = screen.frequency, screen.frequency.shaping
    settle(lambda: card.curves.shown)
    card.choose_loop("pitch")
    settle(lambda: "rotor lag" in shaping.said)
    assert not shaping.disk.slider.isVisible()
    shaping.margin.setFocus()
    QTest.keyPress(shaping.margin, Qt.Key.Key_Down)
    assert shaping.disk.slider.isVisible() and not shaping.phase.slider.isVisible()
    speed, own, slider = shaping.bandwidth.value, shaping.disk.value, shaping.disk.slider
    slider.setFocus()
    QTest.keyPress(slider, Qt.Key.Key_Left, Qt.KeyboardModifier.ShiftModifier)
    QTest.keyRelease(slider, Qt.Key.Key_Left, Qt.KeyboardModifier.ShiftModifier)
    settle(lambda: shaping._base is None)
    gains = pitch_gains(screen)
    response = linearize(loop="pitch", gains=gains)(
        np.exp(1j * np.geomspace(0.02, 400.0, 20_000) / 128.0)
    )
    disk = 1.0 / np.abs(1.0 / (1.0 + response) - 0.5).max()
    assert disk == pytest.approx(shaping.disk.value, abs=0.01) and disk < own - 0.02
    assert margins(gains)[1] == pytest.approx(speed, rel=0.03)
    assert screen.gains.next_undo == "Gains of pitch"


def test_a_drag_follows_and_the_factor_comes_back_to_one(screen, settle):
    card, shaping = screen.frequency, screen.frequency.shaping
    settle(lambda: card.curves.shown)
    card.choose_loop("pitch")
    settle(lambda: "rotor lag" in shaping.said)
    before = pitch_gains(screen)
    slider = shaping.factor.slider
    middle = QPointF(slider.width() / 2.0, slider.height() / 2.0).toPoint()
    QTest.mousePress(slider, LEFT, pos=middle)
    middle.setX(middle.x() + slider.width() // 8)
    QTest.mouseMove(slider, middle)
    factor = shaping.factor.value
    assert factor > 1.05
    for name, value in before.items():
        assert screen.gains.proposed[name] == pytest.approx(factor * value)
    QTest.mouseRelease(slider, LEFT, pos=middle)
    assert shaping.factor.value == 1.0
    screen.gains.undo()
    assert pitch_gains(screen) == before


def test_what_cannot_be_is_said_with_what_is_in_the_way(screen, settle):
    card, shaping = screen.frequency, screen.frequency.shaping
    settle(lambda: card.curves.shown)
    card.choose_loop("velocity_x")
    settle(lambda: shaping.said)
    slider = shaping.bandwidth.slider
    slider.setFocus()
    slider.edit_begun.emit()
    slider.dragged.emit(150.0)
    settle(lambda: shaping.said.startswith("The nearest possible"))
    assert "more kd_velocity_x than its largest value" in shaping.said
    assert shaping.tone == "warning"
    slider.edit_ended.emit()
    settle(lambda: shaping._base is None)


def test_linked_gains_move_along(screen, settle):
    card, shaping = screen.frequency, screen.frequency.shaping
    settle(lambda: card.curves.shown)
    card.choose_loop("pitch")
    settle(lambda: "rotor lag" in shaping.said)
    screen.gains.set_linked(True)
    slider = shaping.bandwidth.slider
    slider.setFocus()
    QTest.keyPress(slider, Qt.Key.Key_Right)
    QTest.keyRelease(slider, Qt.Key.Key_Right)
    settle(lambda: shaping._base is None)
    proposed = screen.gains.proposed
    assert proposed["kp_roll"] == proposed["kp_pitch"] != screen.gains.flown["kp_pitch"]


def test_the_dark_band_is_where_all_limits_of_all_loops_hold(screen, settle, with_reach):
    """Roll and pitch have 41° at first; with both linked, the band begins at the limit of 45°, and
    the margin there is what python-control finds."""
    screen.gains.set_linked(True)
    card, shaping = screen.frequency, screen.frequency.shaping
    settle(lambda: card.curves.shown)
    card.choose_loop("pitch")
    settle(lambda: shaping._reach.margins(1.0))
    assert "No bandwidth keeps all limits: the phase margin of roll" in shaping.said
    assert shaping._reach.bandwidths(40.0) is None
    slider, middle = shaping.phase.slider, shaping.phase.slider.height() // 2
    screen.limits.set("phase_margin", 45.0)
    low, high = slider._within_limits
    assert slider._stable[0] < low < high < slider._stable[1]
    assert 45.0 <= math.degrees(slider.scale.value(low)) < 49.5
    dark = slider.grab().toImage()
    x = round(slider._x(0.5 * (low + high)))
    screen.limits.set("phase_margin", 120.0)
    assert slider._within_limits is None
    light = slider.grab().toImage()
    assert dark.pixelColor(x, middle - 3) != light.pixelColor(x, middle - 3)
    screen.limits.set("phase_margin", 45.0)
    assert slider._within_limits == (low, high)
    shaping._take(shaping.phase)
    shaping._want(shaping.phase, slider.scale.value(low))
    settle(lambda: not shaping._queries.is_waiting)
    shaping._release()
    assert margins(pitch_gains(screen))[0] >= 44.9
