"""The camera comes along."""

import numpy as np
import pytest
from pydrake.geometry import Meshcat, MeshcatParams

from workbench.live.picture import CAMERA_FARTHEST, CAMERA_NEAREST, ORBIT, move_camera, place_camera
from workbench.session.session import Session


class Camera:
    """Takes note of what Meshcat is told."""

    def SetCameraPose(self, camera_in_world, target_in_world):
        self.way = np.linalg.norm(camera_in_world - target_in_world)

    def SetTransform(self, path, X_ParentPath):
        self.orbit = (path, X_ParentPath.translation())

    def SetCameraTarget(self, target_in_world):
        self.target = target_in_world


def test_the_drone_is_where_it_looks_and_what_the_mouse_turns_around():
    session, camera = Session(), Camera()
    session.command(velocity=[2.0, 0.0, 0.0])
    session.tick(1.0)
    snapshot = session.snapshot()
    move_camera(camera, np.array(snapshot.p_WB))
    assert camera.target == pytest.approx(snapshot.p_WB)
    assert camera.orbit[0] == ORBIT
    assert camera.orbit[1] == pytest.approx(snapshot.p_WB)
    assert snapshot.p_WB[0] > 1.0


@pytest.mark.parametrize(
    ("reach", "distance"), [(0.001, CAMERA_NEAREST), (0.3, 2.1), (50.0, CAMERA_FARTHEST)]
)
def test_it_stands_as_far_off_as_the_drone_is_large(reach, distance):
    camera = Camera()
    place_camera(camera, reach)
    assert camera.way == pytest.approx(distance)


def test_meshcat_has_that_point_of_orbit():
    meshcat = Meshcat(MeshcatParams(host="localhost"))
    move_camera(meshcat, np.array(Session().snapshot().p_WB))
    assert ORBIT.encode() in meshcat._GetPackedTransform(ORBIT)
