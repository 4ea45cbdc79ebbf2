"""Poles moved by mouse and keys in the tuning screen: where they are, by python-control."""

import control
import numpy as np
import pytest
from PyQt6.QtCore import Qt
from PyQt6.QtTest import QTest

from workbench.design.linear.linearize import linearize
from workbench.design.linear.operating_point import OperatingPoint
from workbench.gui.tuning.pole import Pole

LEFT = Qt.MouseButton.LeftButton
SHIFT = Qt.KeyboardModifier.ShiftModifier
PERIOD = 1 / 128


@pytest.fixture
def screen(screen):
    """The tuning screen with its poles."""
    screen.tabs.setCurrentWidget(screen.poles)
    return screen


def flown_poles(screen):
    """Poles of the sampled model of hover on a place, by python-control [1/s]."""
    names = ("kp_pitch", "kd_pitch", "kp_position_xy", "kp_velocity_x", "kd_velocity_x")
    gains = {name: screen.gains.proposed[name] for name in names}
    system = linearize(at=OperatingPoint(hold=True), gains=gains)
    assert isinstance(system, control.StateSpace) and system.dt == PERIOD
    z = np.linalg.eigvals(system.A)
    return np.log(z[np.abs(z) > 1e-9].astype(complex)) / PERIOD


def nearest(poles, place):
    return complex(poles[np.argmin(np.abs(poles - place))])


def take(screen, settle, loop, near):
    """Return the plane, and the proposed pole near to a place, of a chosen loop."""
    card = screen.poles
    settle(lambda: card.loops.count() > 1)
    card.loops.setCurrentIndex(card.loops.findData(loop))
    proposed = [pole for pole in card.plane.poles if pole.proposed]
    return card.plane, min(proposed, key=lambda pole: abs(pole.value - near))


def drag(plane, pole, place, settle, steps=4):
    """Drag a pole to a place by the mouse, and return the place that the pointer came to."""
    start, end = plane.place(pole), plane.place(Pole(place, True))
    QTest.mousePress(plane.viewport(), LEFT, pos=start.toPoint())
    for step in range(1, steps + 1):
        at = (start + (end - start) * (step / steps)).toPoint()
        QTest.mouseMove(plane.viewport(), at)
        settle(lambda: True)
    wanted = plane._place
    QTest.mouseRelease(plane.viewport(), LEFT, pos=at)
    settle(lambda: True)
    return wanted


@pytest.mark.parametrize(
    ("loop", "near", "place", "span"),
    [
        ("pitch", -20.0 + 24.0j, -14.0 + 20.0j, 40.0),
        pytest.param("velocity_x", -5.7 + 3.3j, -5.0 + 4.5j, 12.0, marks=pytest.mark.slow),
        ("position_x", -1.4, -1.0, 6.0),
    ],
)
def test_a_dragged_pole_comes_to_the_pointer_as_one_step_of_undo(
    screen, settle, loop, near, place, span
):
    plane, pole = take(screen, settle, loop, near)
    plane.zoom(span / plane.span)
    before = dict(screen.gains.proposed)
    wanted = drag(plane, pole, complex(place), settle)
    found = nearest(flown_poles(screen), wanted if pole.value.imag else wanted.real)
    assert abs(found - (wanted if pole.value.imag else wanted.real)) < 0.02 * abs(wanted)
    assert abs(wanted - place) < 0.05 * abs(place)
    assert abs(found - pole.value) > 0.1 * abs(place)
    assert screen.gains.next_undo == f"Pole of {loop.replace('_', ' ')}"
    assert f"{abs(found):.3g}" in screen.poles.reading.text()
    screen.gains.undo()
    assert screen.gains.proposed == before


def test_arrow_keys_move_the_chosen_pole(screen, settle):
    plane, pole = take(screen, settle, "pitch", -20.0 + 24.0j)
    plane.setFocus()
    for _ in range(40):
        if plane.chosen == pole:
            break
        QTest.keyClick(plane, Qt.Key.Key_Left)
    assert plane.chosen == pole
    for _ in range(3):
        QTest.keyPress(plane, Qt.Key.Key_Up, SHIFT)
        settle(lambda: True)
    QTest.keyRelease(plane, Qt.Key.Key_Up, SHIFT)
    settle(lambda: True)
    wanted = pole.value + 3 * 0.02j * abs(pole.value)
    assert abs(nearest(flown_poles(screen), wanted) - wanted) < 0.002 * abs(wanted)
    screen.gains.undo()
    assert nearest(flown_poles(screen), pole.value) == pytest.approx(pole.value, rel=1e-6)


def test_escape_gives_a_drag_up(screen, settle):
    plane, pole = take(screen, settle, "pitch", -20.0 + 24.0j)
    before = dict(screen.gains.proposed)
    start = plane.place(pole).toPoint()
    QTest.mousePress(plane.viewport(), LEFT, pos=start)
    QTest.mouseMove(plane.viewport(), start + type(start)(-20, -10))
    settle(lambda: screen.gains.proposed != before)
    QTest.keyClick(plane, Qt.Key.Key_Escape)
    assert screen.gains.proposed == before
    QTest.mouseRelease(plane.viewport(), LEFT, pos=start)
    settle(lambda: True)
    assert screen.gains.proposed == before


def test_what_holds_a_pole_is_said(screen, settle, case):
    """Another loop, filters, one gain that is not enough, a gain that is at its end."""
    for loop, near, place, said in (
        ("yaw_rate", -20.0 + 24.0j, -10.0 + 20.0j, "No gain of yaw rate moves this pole"),
        (
            "pitch",
            -48.5,
            -42.0,
            "The nearest that the gains of pitch can reach: the pole also belongs to filters",
        ),
        ("position_x", -5.7 + 3.3j, -4.0 + 3.6j, "which moves it along one line"),
        ("velocity_x", -5.7 + 3.3j, -3.0 + 2.0j, "kd_velocity_x is at its smallest value"),
    ):
        with case(said):
            plane, pole = take(screen, settle, loop, near)
            plane.zoom(2.0 * abs(near) / plane.span)
            drag(plane, pole, place, settle)
            assert said in screen.poles.reading.text()
            while screen.gains.next_undo:
                screen.gains.undo()
            settle(lambda: True)


def test_flown_poles_stay_where_they_are(screen, settle):
    plane, _ = take(screen, settle, "pitch", 0.0)
    flown = Pole(-12.0 + 9.0j, proposed=False)
    plane.show_poles([flown])
    at = plane.place(flown).toPoint()
    QTest.mousePress(plane.viewport(), LEFT, pos=at)
    QTest.mouseMove(plane.viewport(), at + type(at)(20, 20))
    assert plane._place is None and screen.poles._base is None


def test_the_loop_of_a_pole_is_named_with_a_way_to_it(screen, settle):
    """The fast tilt poles of this law are those of roll and pitch, at one place."""
    plane, pole = take(screen, settle, "", -20.8 + 22.8j)
    for loop, other in (("roll", "pitch"), ("pitch", "roll")):
        screen.margins.loop_chosen.emit(loop)
        QTest.mouseMove(plane.viewport(), plane.viewport().rect().topLeft())
        QTest.mouseMove(plane.viewport(), plane.place(pole).toPoint())
        assert plane.chosen.loop == loop
        said = f"of the loop {loop}; a pole of {other} lies under it"
        assert said in screen.poles.reading.text()
    QTest.mouseMove(plane.viewport(), plane.viewport().rect().topLeft())
    QTest.mouseClick(screen.poles.to_loop, LEFT)
    assert screen.tabs.currentWidget() is screen.frequency
    assert screen.frequency.curves.loop == loop


@pytest.mark.parametrize("loop", ["roll", "pitch"])
def test_a_pole_is_moved_by_the_gains_of_the_loop_that_is_read_there(screen, settle, loop):
    """Poles of roll and pitch lie on one another; only that of the read loop moves."""
    plane, pole = take(screen, settle, "", -20.8 + 22.8j)
    screen.gains.set_linked(False)
    screen.margins.loop_chosen.emit(loop)
    before = dict(screen.gains.proposed)
    drag(plane, pole, -14.0 + 20.0j, settle)
    moved = {name for name, value in screen.gains.proposed.items() if value != before[name]}
    assert moved == {f"kp_{loop}", f"kd_{loop}"}
    assert screen.gains.next_undo == f"Pole of {loop}"


def test_a_pole_of_no_loop_asks_for_one(screen, settle):
    plane, _ = take(screen, settle, "", 0.0)
    of_none = Pole(-12.0 + 9.0j, proposed=True)
    plane.show_poles([of_none])
    before = dict(screen.gains.proposed)
    drag(plane, of_none, -14.0 + 9.0j, settle)
    assert screen.gains.proposed == before
    assert screen.poles.reading.text().startswith("No loop moves this pole by itself")
