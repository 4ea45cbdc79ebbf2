"""Outlines from above. Oracle: Drake's signed distances on upright lines; courses by hand."""

import math
from pathlib import Path

import numpy as np
import pytest
from pydrake.geometry import (
    Box,
    Capsule,
    Convex,
    Cylinder,
    Ellipsoid,
    FramePoseVector,
    GeometryFrame,
    GeometryInstance,
    HalfSpace,
    ProximityProperties,
    SceneGraph,
    Sphere,
)
from pydrake.math import RigidTransform, RollPitchYaw

from workbench.plant.worlds.outline import ObstaclePath
from workbench.plant.worlds.world import MovingObstacle, StaticObstacle, World, outlines

MESH = """v 0 0 0
v 2 0 0.3
v 0.2 1.5 0
v 0.5 0.5 1.2
v 0.6 0.5 0.3
f 1 3 2
f 1 2 4
f 2 3 4
f 3 1 4
"""
REACH = 3.0
RIM = 0.03
"""Nearer to its edge than this a place is not asked for [m]: a circle has 32 corners."""


def geometry(shape, name="it::part", X=None):
    made = GeometryInstance(X or RigidTransform(), shape, name)
    made.set_proximity_properties(ProximityProperties())
    return made


def depths(obstacle, p_W):
    """Return Drake's signed distance of an obstacle's one geometry from points in W (N, 3)."""
    scene = SceneGraph()
    source = scene.RegisterSource("it")
    frame = scene.RegisterFrame(source, GeometryFrame("it"))
    part = obstacle.collisions[0]
    posed = geometry(part.shape(), "it", obstacle.X_WO @ part.pose())
    scene.RegisterAnchoredGeometry(source, posed)
    context = scene.CreateDefaultContext()
    poses = FramePoseVector()
    poses.set_value(frame, RigidTransform())
    scene.get_source_pose_port(source).FixValue(context, poses)
    query = scene.get_query_output_port().Eval(context)
    return np.array([query.ComputeSignedDistanceToPoint(p)[0].distance for p in p_W])


def world(obstacles=(), moving=()):
    return World(Path("it"), "it", obstacles=tuple(obstacles), moving=tuple(moving))


def test_an_outline_is_the_shadow_of_what_can_be_bumped_into(case, tmp_path):
    (tmp_path / "wedge.obj").write_text(MESH)
    shapes = (
        Box(1.0, 2.0, 0.5),
        Sphere(0.8),
        Cylinder(0.5, 2.0),
        Capsule(0.4, 1.5),
        Ellipsoid(0.5, 1.2, 0.8),
        Convex(str(tmp_path / "wedge.obj"), 1.3),
    )
    random = np.random.default_rng(3)
    heights = np.linspace(-REACH, REACH, 121)
    for shape in shapes:
        with case(type(shape).__name__):
            X_WO = RigidTransform(RollPitchYaw(random.uniform(-1.5, 1.5, 3)), [0.3, -0.2, 0.1])
            X_OG = RigidTransform(RollPitchYaw(random.uniform(-1.5, 1.5, 3)), [0.1, 0.2, -0.3])
            obstacle = StaticObstacle("it", X_WO, (geometry(shape, X=X_OG),), ())
            (found,) = outlines(world([obstacle]))
            asked = 0
            for x, y in random.uniform(-1.6, 1.6, (40, 2)):
                line = np.column_stack([np.full((len(heights), 2), (x, y)), heights])
                deepest = depths(obstacle, line).min()
                if abs(deepest) > RIM:
                    asked += 1
                    assert found.holds(x, y) == (deepest < 0.0), (x, y, deepest)
            assert asked > 20
            # no point above the highest is inside, and some just below it nearly are
            for height, beyond in ((found.high, 1.0), (found.low, -1.0)):
                grid = np.stack(np.meshgrid(*[np.linspace(-1.6, 1.6, 33)] * 2), -1).reshape(-1, 2)
                level = np.full((len(grid), 1), height)
                assert depths(obstacle, np.hstack([grid, level + 0.01 * beyond])).min() > 0.0
                assert depths(obstacle, np.hstack([grid, level - 0.05 * beyond])).min() < RIM


def test_what_has_no_end_and_no_area_has_no_outline():
    endless = StaticObstacle("plain", RigidTransform(), (geometry(HalfSpace()),), ())
    assert outlines(world([endless])) == ()


def test_what_moves_is_where_its_course_has_it():
    """A cart of 2 by 1 m goes 4 m east in 4 s while it turns to the north, and begins again."""
    corners = ((0.0, 0.0, 0.5, 0.0), (4.0, 0.0, 0.5, 0.5 * math.pi))
    cart = MovingObstacle(
        "cart", geometry(Box(2.0, 1.0, 0.6)), ObstaclePath((0.0, 4.0), corners, repeat=False)
    )
    (found,) = outlines(world(moving=[cart]))
    begun, over = found.at(0.0), found.at(9.0)
    assert (begun.low, begun.high) == pytest.approx((0.2, 0.8))
    assert begun.holds(0.95, 0.45) and not begun.holds(0.45, 0.95)
    assert over.holds(4.45, 0.95) and not over.holds(4.95, 0.45)
    half = found.at(2.0)
    middle = np.mean(half.corners, axis=0)
    assert middle == pytest.approx([2.0, 0.0])
    direction = cart.pose(2.0).rotation().matrix()[:2, 0]  # of its long side, at 45°
    assert direction == pytest.approx([math.sqrt(0.5)] * 2)
    assert half.holds(*(middle + 0.95 * direction)) and not half.holds(*(middle + 1.05 * direction))
