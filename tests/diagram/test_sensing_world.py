"""Oracles: signed distances of boxes, cylinders and balls in closed form, and rays by hand."""

import logging
import math

import numpy as np
import pytest
from pydrake.geometry import Meshcat

from workbench.common.resources import find_model
from workbench.plant.description import read_description
from workbench.plant.reach import reach_sphere
from workbench.scenario.scenario import Scenario, ScenarioStart, SensorsConfig
from workbench.session.session import Session

FLAT, FACETS = 1e-3, 0.0025
"""Errors [m] on flat faces, and of radii where the renderer draws facets, as shares."""
RADIUS, COLUMN, BALL = 0.5, np.array([4.0, 1.3]), np.array([4.5, -1.2, 1.2])
BALL_RADIUS = 0.7
BOX, HALF, YAW = np.array([6.0, 0.2, 1.0]), np.array([0.5, 1.5, 1.0]), 0.4
WORLD = """
obstacles:
- {name: box, shape: {box: [1.0, 3.0, 2.0]}, position: [6, 0.2, 1], roll_pitch_yaw: [0, 0, 0.4]}
- {name: column, shape: {cylinder: [0.5, 3]}, position: [4, 1.3, 1.5]}
- {name: ball, shape: {sphere: 0.7}, position: [4.5, -1.2, 1.2]}
"""
MOVING = """
moving:
- name: ball
  shape: {sphere: 0.4}
  path: [[0, 3, -2, 1.5], [4, 3, 2, 1.5], [8, 3, -2, 1.5]]
  repeat: true
- name: plate
  shape: {box: [1, 1, 0.2]}
  path: [[0, -4, 0, 0.5], [4, 4, 0, 0.5]]
"""


def distances(points: np.ndarray) -> np.ndarray:
    """Return signed distances to ground, box, column and ball, (4, n)."""
    c, s = math.cos(YAW), math.sin(YAW)
    in_box = (points - BOX) @ np.array([[c, -s, 0.0], [s, c, 0.0], [0.0, 0.0, 1.0]])
    column = np.column_stack(
        [np.hypot(*(points[:, :2] - COLUMN).T) - RADIUS, np.abs(points[:, 2] - 1.5) - 1.5]
    )
    return np.stack(
        [
            points[:, 2],
            outside(np.abs(in_box) - HALF),
            outside(column),
            np.linalg.norm(points - BALL, axis=1) - BALL_RADIUS,
        ]
    )


def outside(excess: np.ndarray) -> np.ndarray:
    """Return the signed distance of a convex thing from that to its sides."""
    away = np.linalg.norm(np.maximum(excess, 0.0), axis=1)
    return np.where((excess > 0.0).any(axis=1), away, excess.max(axis=1))


@pytest.fixture(scope="module")
def world(tmp_path_factory):
    path = tmp_path_factory.mktemp("worlds") / "solids.yaml"
    path.write_text(WORLD)
    return str(path)


@pytest.fixture(
    scope="module", params=[[0.0, 0.0, 0.0], [0.05, -0.1, -0.15]], ids=["level", "tilt"]
)
def views(request, world):
    """Return a scan and a picture taken at the same moment, the first of the flight."""
    start = ScenarioStart(position=[0.3, 0.1, 1.4], roll_pitch_yaw=request.param)
    sensors = SensorsConfig(use=["lidar", "camera"], noise=False)
    session = Session(Scenario(world=world, start=start, sensors=sensors))
    session.tick(1 / 128)
    scan, picture = session.reading("lidar"), session.reading("camera")
    assert scan.stamp == picture.stamp == 0.0
    return scan, picture


def test_both_clouds_lie_on_the_surfaces(views):
    scan, picture = views
    flat = np.array([[FLAT], [FLAT], [FLAT], [FLAT]])
    facets = np.array([[FLAT], [FLAT], [FACETS * RADIUS], [FACETS * BALL_RADIUS]])
    for points, within in ((scan.points_W(), flat), (picture.points_W(), facets)):
        far = np.abs(distances(points))
        nearest = far.argmin(axis=0)
        assert (np.bincount(nearest, minlength=4) > 30).all()
        assert (far <= np.maximum(within, FLAT)).any(axis=0).all()
    assert np.abs(distances(scan.points_W())).min(axis=0).max() < 1e-9


def test_where_both_see_a_point_they_agree(views):
    """Rays of the lidar between four pixels that see the same surface as it does.

    Between pixels on a plane one over the depth goes evenly; a ball's or a column's leaves that by
    less than 1 mm here.
    """
    scan, picture = views
    points_W = scan.points_W()
    x, y, z = picture.points().T  # to show that all of them are finite
    assert np.isfinite([x, y, z]).all()
    # optical frame: z ahead, x to the right, y down
    ahead, left, up = ((points_W - picture.p_WS) @ picture.R_WS).T
    pinhole = picture.pinhole
    with np.errstate(divide="ignore", invalid="ignore"):
        u = pinhole.cx - pinhole.fx * left / ahead
        v = pinhole.cy - pinhole.fy * up / ahead
    inside = (ahead > 0.2) & (u > 0) & (v > 0) & (u < pinhole.width - 1) & (v < pinhole.height - 1)
    surface = np.abs(distances(points_W)).argmin(axis=0)
    seen = np.full((*picture.depth.shape, 3), np.nan)
    seen[np.isfinite(picture.depth)] = picture.points_W()
    flat = seen.reshape(-1, 3)
    labels = np.abs(np.nan_to_num(distances(flat), nan=9.0)).argmin(axis=0)
    labels = labels.reshape(picture.depth.shape)
    compared = {0: [], 1: [], 2: [], 3: []}
    for i in np.flatnonzero(inside):
        column, row = int(u[i]), int(v[i])
        four = (slice(row, row + 2), slice(column, column + 2))
        depth = picture.depth[four]
        if not np.isfinite(depth).all() or (labels[four] != surface[i]).any():
            continue  # an edge, or one sees past what hides it from the other
        right, down = u[i] - column, v[i] - row
        weights = np.outer([1 - down, down], [1 - right, right])
        compared[int(surface[i])].append(1.0 / (weights / depth).sum() - ahead[i])
    assert all(len(errors) > 20 for errors in compared.values())
    assert np.abs([*compared[0], *compared[1]]).max() < FLAT
    for number, radius in ((2, RADIUS), (3, BALL_RADIUS)):
        # at a grazing angle a small step inwards is a long way along the ray
        assert np.median(np.abs(compared[number])) < FLAT + 2.0 * FACETS * radius


def ranges_by_hand(scan, centre: np.ndarray, radius: float) -> np.ndarray:
    """Return ranges on the ground and a ball."""
    d = scan.pattern.directions_S @ scan.R_WS.T
    with np.errstate(divide="ignore", invalid="ignore"):
        ground = np.where(d[:, 2] < 0.0, -scan.p_WS[2] / d[:, 2], np.inf)
        to_centre = centre - scan.p_WS
        middle = d @ to_centre
        root = np.sqrt(radius**2 - (to_centre @ to_centre - middle**2))
        ball = np.where((middle > 0.0) & ~np.isnan(root), middle - root, np.inf)
    return np.minimum(ground, ball)


@pytest.fixture(scope="module")
def moving(tmp_path_factory):
    path = tmp_path_factory.mktemp("worlds") / "moving.yaml"
    path.write_text(MOVING)
    rates = {"lidar": 8.0, "camera": 8.0, "range_finder": 8.0}
    sensors = SensorsConfig(use=[*rates], rates=rates, noise=False)
    return Session(Scenario(world=str(path), sensors=sensors))


@pytest.mark.slow
@pytest.mark.parametrize(
    ("time", "ball", "under"),
    [
        (1.0, [3.0, -1.0, 1.5], 0.0),  # the plate is 2 m behind the drone
        (2.0, [3.0, 0.0, 1.5], 0.6),  # the plate is below it, its top at 0.6 m
        (2.125, [3.0, 0.125, 1.5], 0.6),  # not later: at 2.25 s its edge is below the drone
        (2.5, [3.0, 0.5, 1.5], 0.0),  # its edge is past the drone
        (5.0, [3.0, 1.0, 1.5], 0.0),  # on its way back
    ],
)
def test_what_moves_is_seen_where_it_is(moving, time, ball, under):
    moving.reset()
    moving.tick(time + 1 / 128)
    scan, picture = moving.reading("lidar"), moving.reading("camera")
    height = moving.reading("range_finder")
    assert scan.stamp == picture.stamp == height.stamp == time
    centre = np.array(ball)
    assert height.distance == pytest.approx(1.5 - 0.063 - under, abs=1e-6)
    forward = slice(8 * 360, 16 * 360)  # the upper layers, which the plate is not in
    wanted = np.where((w := ranges_by_hand(scan, centre, 0.4)) > 30.0, np.inf, w)[forward]
    np.testing.assert_allclose(scan.ranges.ravel()[forward], wanted, rtol=0.0, atol=1e-6)
    assert np.isfinite(wanted).sum() > 20
    points = picture.points_W()
    on_ball = points[np.linalg.norm(points - centre, axis=1) < 0.45]
    assert len(on_ball) > 300
    off = np.linalg.norm(on_ball - centre, axis=1) - 0.4
    assert -FACETS * 0.4 - 1e-4 < off.min() <= off.max() < 1e-4


def test_the_clearance_is_from_where_it_is(moving):
    """Measured eight times a second, a physics step before the time it is for."""
    description = read_description(find_model("dh_drone"))
    drone = reach_sphere(description.model, description.base_link, description.rotors)
    middle = np.array([0.0, 0.0, 1.5]) + drone.p_BC
    moving.reset()
    directions = []
    for time in (0.5, 3.0, 6.5):
        moving.tick(time + 1 / 1024 - moving.time)
        seen = moving.snapshot().clearance
        when = time - 1 / 1024
        ball = np.array([3.0, when - 2.0 if when < 4.0 else 6.0 - when, 1.5])
        plate = np.array([min(2.0 * when, 8.0) - 4.0, 0.0, 0.5])
        to_ball = np.linalg.norm(ball - middle) - 0.4
        to_plate = outside(np.abs(middle - plate)[None] - [0.5, 0.5, 0.1])[0]
        distance, towards = min((to_ball, ball - middle), (to_plate, None), key=lambda p: p[0])
        assert seen.distance + drone.radius == pytest.approx(distance, abs=1e-6)
        directions += [] if towards is None else [(seen.direction, towards)]
    ((direction, towards),) = directions  # the ball is the nearer one once
    assert direction == pytest.approx(towards / np.linalg.norm(towards), abs=1e-6)


@pytest.mark.parametrize("drawn", [False, True], ids=["not drawn", "drawn"])
def test_the_drone_never_sees_itself(drawn):
    """So high that nothing else is in range; it tilts and turns, its propellers run."""
    logging.getLogger("drake").setLevel(logging.WARNING)
    sensors = SensorsConfig(use=["lidar", "camera", "range_finder"], rates={"camera": 4.0})
    start = ScenarioStart(position=[0.0, 0.0, 60.0], roll_pitch_yaw=[0.3, -0.2, 1.0])
    session = Session(Scenario(start=start, sensors=sensors), None, Meshcat() if drawn else None)
    session.command([2.0, -1.0, 0.5], 0.4)
    for _ in range(8):
        session.tick(0.125)
        assert np.isposinf(session.reading("lidar").ranges).all()
        assert np.isposinf(session.reading("camera").depth).all()
        assert session.reading("range_finder").distance == math.inf
    assert session.recording().rotor_speeds.min() > 100.0
