import math

import numpy as np
import pytest
from pydrake.systems.sensors import CameraInfo

from workbench.systems.sensors.readings import R_SC, make_pinhole, seen_points


@pytest.mark.parametrize(
    ("width", "height", "fov"), [(320, 240, 1.047), (641, 480, 2.0), (3, 5, 0.4)]
)
def test_intrinsics_are_those_of_drakes_camera(width, height, fov):
    pinhole = make_pinhole(width, height, fov)
    vertical = 2.0 * math.atan(height / width * math.tan(fov / 2.0))
    drakes = CameraInfo(width=width, height=height, fov_y=vertical)
    own = [[pinhole.fx, 0, pinhole.cx], [0, pinhole.fy, pinhole.cy], [0, 0, 1]]
    np.testing.assert_allclose(own, drakes.intrinsic_matrix(), rtol=1e-12)


def test_points_stand_where_their_pixels_saw_them():
    pinhole = make_pinhole(4, 2, math.pi / 2.0)  # a focal length of two pixels
    depth = np.full((2, 4), np.inf)
    depth[0, 0], depth[1, 3], depth[1, 0] = 4.0, 2.0, -np.inf
    # half a pixel, and one and a half, away from the middle
    np.testing.assert_allclose(seen_points(pinhole, depth), [[-3.0, -1.0, 4.0], [1.5, 0.5, 2.0]])


def test_the_optical_frame_looks_along_the_sensors_x_with_y_down():
    right, down, forward = R_SC.T
    np.testing.assert_array_equal([right, down, forward], [[0, -1, 0], [0, 0, -1], [1, 0, 0]])
    assert np.linalg.det(R_SC) == 1.0
