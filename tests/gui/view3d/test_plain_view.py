"""The plain picture of the flight: where points stand, by hand, and what is drawn."""

import dataclasses
import math

import numpy as np
import pytest
from PyQt6.QtGui import QImage

from workbench.gui.poses import rotation_of
from workbench.gui.view3d.plain_view import PlainView
from workbench.gui.view3d.scene import LogTrack
from workbench.plant.worlds.outline import Outline
from workbench.session.snapshot import CableStatus


@pytest.fixture
def view(qtbot, workspace, canned):
    made = PlainView(workspace.look, workspace.preferences)
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
    np.testing.assert_allclose(rotation_of(tuple(q)), expected, atol=1e-12)


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


def test_free_stays_and_a_replayed_drone_is_followed(view, canned):
    """100 px a metre; what was in the middle moves as the picture does."""
    here = view.points(np.array([[3.0, 2.0, 1.0]]))[0]
    assert (here.x(), here.y()) == pytest.approx((200.0, 200.0))
    view.look("side")
    pose = np.eye(4)
    pose[:3, 3] = [4.0, 2.0, 1.0]
    view.show_replay(pose)
    here = view.points(np.array([[3.0, 2.0, 1.0]]))[0]
    assert (here.x(), here.y()) == pytest.approx((100.0, 200.0))
    view.look("free")
    view.show_replay(None)
    here = view.points(np.array([[3.0, 2.0, 1.0]]))[0]
    assert (here.x(), here.y()) == pytest.approx((100.0, 200.0))
    view.look("side")
    here = view.points(np.array([[3.0, 2.0, 1.0]]))[0]
    assert (here.x(), here.y()) == pytest.approx((200.0, 200.0))


def test_obstacles_lidar_a_predicted_way_and_a_log_are_drawn_where_they_are(view, canned, case):
    """Seen from the south, 100 px a metre around (3, 2, 1): a probe each, before and after."""
    view.look("side")
    seen = dataclasses.replace(
        canned.views[-1], snapshot=view._now, outlines=(), vehicle=canned.views[-1].vehicle
    )
    box = Outline("box", ((4.0, 2.0), (4.5, 2.0), (4.5, 3.0), (4.0, 3.0)), 0.5, 2.5)
    log = LogTrack(
        "it", np.arange(2.0), np.array([[2.0, 2.0, 0.0], [2.0, 2.0, 3.0]]), np.zeros((2, 3))
    )
    here = np.eye(4)
    here[:3, 3] = view._now.p_WB

    def show_log():
        view.show_track(log)
        view.show_replay(here)

    now = view._now.time
    way = np.array([[3.0, 2.0, 2.0], [2.5, 2.0, 2.0]])
    for name, (x, y), show, hide in (
        (
            "obstacle",
            (325, 50),
            lambda: view.show_view(dataclasses.replace(seen, outlines=(box,))),
            lambda: view.show_view(seen),
        ),
        (
            "lidar",
            (320, 130),
            lambda: view.show_view(seen, np.array([[4.2, 5.0, 1.7]])),
            lambda: view.show_view(seen),
        ),
        (
            "predicted",
            (175, 100),
            lambda: view.foresee(now + 1.0, way),
            lambda: view.foresee(now - 1.0, way),
        ),
        ("log", (100, 50), show_log, lambda: view.show_replay(None)),
    ):
        with case(name):
            probe = [(x + i, y + j) for i in range(-2, 3) for j in range(-2, 3)]
            images = []
            for change in (hide, show, hide):
                change()
                image = view.grab().toImage()
                images.append([image.pixelColor(*each).name() for each in probe])
            assert images[0] != images[1] and images[0] == images[2]
    view.show_view(seen, np.array([[4.2, 5.0, 1.7]]))
    shown = view.grab().toImage()
    view.show_parts({"trail", "arrows"})
    assert view.grab().toImage() != shown


def test_a_cable_is_drawn_and_said_to_be_slack(view, canned):
    """A taut one along the drone's x is dark; the pixel in its middle, and the text below."""
    view.look("top")
    seen, now = canned.views[-1], view._now
    taut = CableStatus("sling", (3.0, 2.0, 1.0), (4.0, 2.0, 1.0), 1.0, 2.5)

    def shown(*cables: CableStatus) -> QImage:
        view.show_view(dataclasses.replace(seen, snapshot=dataclasses.replace(now, cables=cables)))
        return view.grab().toImage()

    bare, straight = shown(), shown(taut)
    assert straight.pixel(280, 200) != bare.pixel(280, 200)
    view._now = dataclasses.replace(now, cables=(taut, dataclasses.replace(taut, tension=0.0)))
    assert view.words(view._now).endswith(", sling 2.50\xa0N, sling slack")
