import numpy as np
import pytest
from PyQt6.QtCore import QPoint, QPointF, Qt

from workbench.analysis.replies import Judged
from workbench.gui.tuning.pole import Pole, drawn_poles, poles_headline
from workbench.gui.tuning.pole_plane import PolePlane

SWINGING = -3.0 + 4.0j
SIDES = "left", "bottom"


@pytest.fixture
def plane(workspace, qtbot):
    made = PolePlane(workspace.look)
    qtbot.addWidget(made)
    made.resize(400, 260)
    made.show()
    made.heard = []
    made.read.connect(made.heard.append)
    return made


def judged(poles, loops=()):
    return Judged((), np.array(poles, dtype=complex), True, "", tuple(loops))


def test_a_pole_says_its_frequency_and_its_damping():
    pole = Pole(SWINGING, proposed=True)
    assert (pole.frequency, pole.damping, pole.is_stable) == (5.0, 0.6, True)
    assert (
        pole.text == "proposed: 5\N{NO-BREAK SPACE}rad/s (0.796\N{NO-BREAK SPACE}Hz), damping 0.60"
    )
    assert Pole(2.0 + 0.0j, proposed=False).text.endswith("damping −1.00, unstable")
    assert Pole(-1.0 + 0.0j, True, "yaw_rate").text.endswith(", of the loop yaw rate")


def test_of_a_pair_the_upper_one_is_shown():
    flown = judged([-1.0])
    poles = drawn_poles(flown, judged([SWINGING, SWINGING.conjugate()], ["roll", "roll"]))
    assert poles == (Pole(-1.0 + 0.0j, False), Pole(SWINGING, True, "roll"))


def test_the_headline_counts_what_is_unstable_and_names_its_loop():
    def headline(*poles, loops=()):
        return poles_headline(drawn_poles(None, judged(poles, loops)))

    assert headline(-1.0, 2.0, 0.5 + 1j, 0.5 - 1j) == "3 unstable poles."
    said = "Least damping 0.60, at 5\N{NO-BREAK SPACE}rad/s, of the loop yaw rate."
    assert headline(SWINGING, -1.0, loops=["yaw_rate", ""]) == said
    assert headline(0.1, 0.2, loops=["roll", "pitch"]) == "2 unstable poles, of the loop pitch."
    assert headline(-1.0) == "Nothing oscillates."
    for idle in (0.0, 4.5e-13):  # an integrator that an autopilot's law stops while it holds
        assert headline(-1.0, idle) == "Nothing oscillates."


def test_real_and_imaginary_parts_have_one_scale_so_that_angles_say_the_damping(plane):
    zero, there = plane.place(Pole(0j, True)), plane.place(Pole(SWINGING, True))
    assert (zero.x() - there.x()) / (zero.y() - there.y()) == pytest.approx(0.75)


def test_both_axes_have_numbers_and_units(plane):
    """Rings of 10 1/s to a span of 40: their numbers are along both axes."""
    left, bottom = ([text for _, text in plane.getAxis(each)._tickLevels[0]] for each in SIDES)
    assert left[:3] == ["0", "10", "20"]
    assert {"−10", "−20", "−30", "0"} <= set(bottom)
    assert [plane.getAxis(each).labelText for each in SIDES] == ["Im 1/s", "Re 1/s"]


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
