"""Oracle: straight lines by hand."""

import math

import numpy as np
import pytest
from pydrake.math import RigidTransform

from workbench.common.errors import WorkbenchError
from workbench.plant.shapes import Sphere
from workbench.plant.worlds.geometry import solid_geometry
from workbench.plant.worlds.outline import ObstaclePath
from workbench.plant.worlds.world import (
    EMPTY_WORLD,
    MovingObstacle,
    StaticObstacle,
    World,
    first_duplicate,
    obstacle_of,
)


def ball(repeat: bool) -> MovingObstacle:
    corners = ((0.0, 0.0, 1.0, 0.0), (4.0, 0.0, 1.0, math.pi), (0.0, 0.0, 1.0, 0.0))
    geometry = solid_geometry("ball::shape", Sphere(0.5), None)
    return MovingObstacle("ball", geometry, ObstaclePath((0.0, 2.0, 10.0), corners, repeat))


@pytest.mark.parametrize(
    ("time", "x", "yaw"),
    [(0.0, 0.0, 0.0), (0.5, 1.0, math.pi / 4), (2.0, 4.0, math.pi), (8.0, 1.0, math.pi / 4)],
)
def test_it_moves_straight_and_evenly_between_corners(time, x, yaw):
    X_WO = ball(repeat=False).pose(time)
    np.testing.assert_allclose(X_WO.translation(), [x, 0.0, 1.0], atol=1e-12)
    expected = [[math.cos(yaw), -math.sin(yaw), 0], [math.sin(yaw), math.cos(yaw), 0], [0, 0, 1]]
    np.testing.assert_allclose(X_WO.rotation().matrix(), expected, atol=1e-12)


def test_after_its_path_it_stays_or_begins_again():
    assert ball(repeat=False).pose(11.0).translation()[0] == 0.0
    assert ball(repeat=True).pose(11.0).translation()[0] == pytest.approx(2.0)
    assert ball(repeat=True).pose(10.0 * 1000 + 1.0).translation()[0] == pytest.approx(2.0)


def test_a_world_knows_where_each_obstacle_is():
    post = StaticObstacle("post", RigidTransform([1.0, 2.0, 3.0]), (), ())
    world = World(EMPTY_WORLD.source, "w", obstacles=(post,), moving=(ball(repeat=True),))
    assert world.names == ("post", "ball")
    assert world.pose("post", 5.0).translation().tolist() == [1.0, 2.0, 3.0]
    assert world.pose("ball", 1.0).translation().tolist() == [2.0, 0.0, 1.0]
    with pytest.raises(WorkbenchError, match="unknown obstacle 'pots': did you mean 'post'"):
        world.pose("pots", 0.0)


def test_a_geometrys_name_tells_its_obstacle():
    assert obstacle_of("crate::body") == "crate"
    assert obstacle_of("town::house::roof") == "town::house"
    assert obstacle_of("ground") == "ground"


def test_the_first_name_that_comes_twice_is_found():
    assert first_duplicate(["a", "b", "c", "b", "a"]) == "b"
    assert first_duplicate(["a", "b"]) is None
