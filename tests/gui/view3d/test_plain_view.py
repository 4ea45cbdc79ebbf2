"""The plain picture of the flight: where points stand, by hand, and what is drawn."""

import dataclasses
import math

import numpy as np
import pytest

from workbench.gui.view3d.plain_view import PlainView, rotation


@pytest.fixture
def view(qtbot, workspace, canned):
    made = PlainView(workspace.look)
    qtbot.addWidget(made)
    made.resize(400, 400)
    seen = canned.views[-1]
    snapshot = dataclasses.replace(
        seen.snapshot, p_WB=(3.0, 2.0, 1.0), roll_pitch_yaw=(0.0, 0.0, 0.5 * math.pi)
    )
    made.show_view(dataclasses.replace(seen, snapshot=snapshot))
    return made


def test_points_stand_where_they_are_by_hand(view, case):
    """400 px show 4 m: 100 px a metre. The drone stands in the middle and looks north."""
    tilted = math.radians(20.0)
    for way, point, right, up in (
        ("top", (4.0, 2.0, 9.0), 100.0, 0.0),
        ("top", (3.0, 3.0, 1.0), 0.0, 100.0),
        ("side", (4.0, 7.0, 1.0), 100.0, 0.0),
        ("side", (3.0, 2.0, 2.0), 0.0, 100.0),
        ("follow", (4.0, 2.0, 1.0), 100.0, 0.0),
        ("follow", (3.0, 3.0, 1.0), 0.0, 100.0 * math.sin(tilted)),
        ("follow", (3.0, 2.0, 2.0), 0.0, 100.0 * math.cos(tilted)),
    ):
        with case(way, point):
            view.look(way)
            (place,) = view.points(np.array([point]))
            assert (place.x(), place.y()) == pytest.approx((200.0 + right, 200.0 - up))


def test_a_quaternion_turns_as_scipy_has_it():
    from scipy.spatial.transform import Rotation

    q = np.array([0.3, -0.5, 0.7, 0.2])
    q /= np.linalg.norm(q)
    expected = Rotation.from_quat([*q[1:], q[0]]).as_matrix()
    np.testing.assert_allclose(rotation(tuple(q)), expected, atol=1e-12)


def test_drone_thrusts_and_wind_are_drawn(view, canned):
    """What is drawn differs by the wind's arrow, and by the trail."""
    view.look("reset")
    calm = view.grab().toImage()
    colours = {calm.pixel(x, y) for x in range(0, 400, 2) for y in range(0, 400, 2)}
    assert len(colours) > 5
    seen = canned.views[-1]
    windy = dataclasses.replace(seen.snapshot, wind=(4.0, 0.0, 0.0))
    view.show_view(dataclasses.replace(seen, snapshot=windy))
    assert view.grab().toImage() != calm
