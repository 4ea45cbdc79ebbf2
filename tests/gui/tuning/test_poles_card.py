import numpy as np
import pytest
from PyQt6.QtCore import QPoint, QPointF, Qt

from workbench.gui.tuning.poles_card import Pole, PolePlane, poles_headline, shown_poles

SWINGING = -3.0 + 4.0j


@pytest.fixture
def plane(workspace, qtbot):
    made = PolePlane(workspace.look)
    qtbot.addWidget(made)
    made.resize(400, 260)
    made.show()
    made.heard = []
    made.read.connect(made.heard.append)
    return made


def test_a_pole_says_its_frequency_and_its_damping():
    pole = Pole(SWINGING, proposed=True)
    assert (pole.frequency, pole.damping, pole.is_stable) == (5.0, 0.6, True)
    assert pole.text == "proposed: 5 rad/s (0.796 Hz), damping 0.60"
    assert Pole(2.0 + 0.0j, proposed=False).text.endswith("damping −1.00, unstable")


def test_of_a_pair_the_upper_one_is_shown():
    poles = shown_poles(np.array([-1.0]), np.array([SWINGING, SWINGING.conjugate()]))
    assert poles == (Pole(-1.0 + 0.0j, False), Pole(SWINGING, True))


def test_the_headline_counts_what_is_unstable():
    assert poles_headline(np.array([-1.0, 2.0, 0.5 + 1j])) == "2 unstable poles."
    assert poles_headline(np.array([SWINGING, -1.0])) == "Least damping 0.60, at 5 rad/s."
    assert poles_headline(np.array([-1.0 + 0j])) == "Nothing oscillates."


def test_real_and_imaginary_parts_have_one_scale_so_that_angles_say_the_damping(plane):
    zero, there = plane.place(Pole(0j, True)), plane.place(Pole(SWINGING, True))
    assert (zero.x() - there.x()) / (zero.y() - there.y()) == pytest.approx(0.75)


def test_the_pointer_reads_the_pole_that_is_near(plane, qtbot):
    plane.show_poles([Pole(SWINGING, True), Pole(-30.0 + 0.0j, False)])
    at = plane.place(Pole(SWINGING, True)) + QPointF(3.0, 3.0)
    qtbot.mouseMove(plane.viewport(), at.toPoint())
    assert plane.heard[-1] == Pole(SWINGING, True).text
    qtbot.mouseMove(plane.viewport(), QPoint(10, 20))
    assert plane.heard[-1] == ""


def test_arrow_keys_go_from_pole_to_pole(plane, qtbot):
    poles = [Pole(-30.0 + 0.0j, False), Pole(SWINGING, True)]
    plane.show_poles(poles)
    plane.setFocus()
    qtbot.keyClick(plane, Qt.Key.Key_Left)
    assert plane.heard[-1] == poles[1].text
    qtbot.keyClick(plane, Qt.Key.Key_Left)
    assert plane.heard[-1] == poles[0].text


def test_plus_and_minus_zoom(plane, qtbot):
    before = plane.span
    qtbot.keyClick(plane, Qt.Key.Key_Plus)
    assert plane.span == pytest.approx(0.8 * before)
    qtbot.keyClick(plane, Qt.Key.Key_Minus)
    assert plane.span == pytest.approx(before)


def test_an_unstable_pole_has_another_shape(plane):
    """Beside its middle, on the diagonal, a cross is drawn, and a disc leaves the ground open."""
    disc, cross = Pole(-2.0 + 5.0j, True), Pole(0.5 + 5.0j, True)

    def changes(pole: Pole) -> bool:
        at = plane.place(pole)
        here = round(at.x()) + 4, round(at.y()) + 4
        plane.show_poles([])
        ground = plane.grab().toImage().pixelColor(*here)
        plane.show_poles([pole])
        return plane.grab().toImage().pixelColor(*here) != ground

    assert changes(cross)
    assert not changes(disc)


def test_an_unstable_pole_beyond_the_picture_stands_at_its_edge(plane):
    right, up, both = Pole(900.0 + 1.0j, True), Pole(0.1 + 900.0j, True), Pole(900.0 + 900.0j, True)
    inside = plane.rect().adjusted(10, 10, -10, -10)
    for pole in (right, up, both):
        assert plane.is_beyond(pole)
        assert inside.contains(plane.place(pole).toPoint())
    assert not plane.is_beyond(Pole(0.5 + 5.0j, True))
    far = Pole(-900.0 + 1.0j, True)  # one that dies at once is of no interest
    assert not plane.is_beyond(far)
    assert plane.place(far).x() < 0.0
    plane.show_poles([right])
    shown = plane.grab().toImage()
    plane.show_poles([])
    assert plane.grab().toImage() != shown
