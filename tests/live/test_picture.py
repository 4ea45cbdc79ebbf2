"""The flight in Meshcat comes as often as the flight carries, and only where a page looks on."""

import dataclasses
import math

import numpy as np
import pytest
from pydrake.geometry import Meshcat, MeshcatParams

from workbench.live.messages import Pace
from workbench.live.picture import (
    AHEAD_PATH,
    ARROWS_PATH,
    CABLES_PATH,
    CAMERA_ORBIT_PATH,
    DRONE_PATH,
    LIDAR_PATH,
    MAX_CAMERA_DISTANCE_M,
    MAX_PICTURE_PERIOD_S,
    MAX_SCAN_POINTS,
    MIN_CAMERA_DISTANCE_M,
    MIN_PICTURE_PERIOD_S,
    PICTURE_CALM_S,
    TRAIL_PATH,
    LivePicture,
    move_camera,
    place_camera,
)
from workbench.scenario.scenario import Scenario, SensorsConfig
from workbench.session.session import Session
from workbench.session.snapshot import CableStatus

FRAME = 1 / 60


class Page:
    """Meshcat with pages that look on, and a note of what they are told."""

    def __init__(self, pages=1):
        self.pages = pages
        self.poses, self.lines, self.deleted = [], [], []
        self.clouds, self.matrices = [], {}

    def GetNumActiveConnections(self):
        return self.pages

    def SetCameraPose(self, camera_in_world, target_in_world):
        pass

    def SetCameraTarget(self, target_in_world):
        pass

    def SetTransform(self, path, pose):
        if path == DRONE_PATH:
            self.poses.append(pose)
        elif path.startswith(ARROWS_PATH):
            self.matrices[path.removeprefix(f"{ARROWS_PATH}/")] = pose

    def SetObject(self, path, shape, *look):
        if path == LIDAR_PATH:
            self.clouds.append(shape.xyzs().T)

    def SetLine(self, path, vertices, line_width, rgba):
        self.lines.append((path, vertices))

    def Delete(self, path):
        self.deleted.append(path)


class Bench:
    """A picture, its clock, and a drone that flies along x at 1 m/s."""

    def __init__(self, pages=1):
        self.page, self.drawn, self.wall = Page(pages), 0, 0.0
        session = Session()
        self.vehicle, self.snapshot = session.vehicle, session.snapshot()
        self.scan = None
        self.picture = LivePicture(
            self.page, self._draw, self.vehicle, lambda: self.wall, lambda: self.scan
        )

    def _draw(self):
        self.drawn += 1

    def show(self, seconds, lag=0.0, speed=1.0):
        """Return how many pictures there are in a time of sixty reports a second."""
        before = self.drawn
        for _ in range(round(seconds / FRAME)):
            self.wall += FRAME
            x, y, z = self.snapshot.p_WB
            step = speed * FRAME
            self.snapshot = dataclasses.replace(
                self.snapshot, time=self.snapshot.time + step, p_WB=(x + step, y, z)
            )
            self.picture.show(self.snapshot, Pace(1.0, 1.0, lag, 0.0, False))
        return self.drawn - before


def test_a_flight_that_falls_behind_is_drawn_less_and_one_that_recovers_more():
    bench = Bench()
    assert bench.show(2.0) == pytest.approx(2.0 / MIN_PICTURE_PERIOD_S, abs=3)
    bench.show(5.0, lag=0.2)
    assert bench.picture.period == MAX_PICTURE_PERIOD_S
    assert bench.show(2.0, lag=0.2) <= 2.0 / MAX_PICTURE_PERIOD_S + 1
    bench.show(6 * PICTURE_CALM_S)
    assert bench.picture.period == MIN_PICTURE_PERIOD_S


def test_the_speed_of_the_flight_makes_no_more_pictures():
    bench = Bench()
    assert bench.show(2.0, speed=10.0) <= 2.0 / MIN_PICTURE_PERIOD_S + 1


def test_where_no_page_looks_on_nothing_is_drawn_until_one_does():
    bench = Bench(pages=0)
    assert bench.show(2.0) == 0
    bench.page.pages = 1
    assert bench.show(1.0) > 0


def test_the_trail_is_the_last_thirty_seconds_and_begins_anew_with_a_reset():
    bench = Bench()
    bench.show(40.0)
    path, points = bench.page.lines[-1]
    assert path == TRAIL_PATH
    assert points[0, -1] - points[0, 0] == pytest.approx(30.0, abs=0.5)
    assert points[0, -1] == pytest.approx(bench.snapshot.p_WB[0], abs=0.5)
    assert len(bench.page.lines) < 200  # each is a new object for the page
    bench.snapshot = Session().snapshot()
    bench.show(1.0)
    assert bench.page.deleted == [TRAIL_PATH]
    assert bench.page.lines[-1][1].shape[1] <= 11


def ends(matrix):
    """Return where a matrix puts tail and tip of the arrow of length 1 along z."""
    x, y, z = matrix[:3, :3].T
    assert np.linalg.det([x, y, z]) > 0.0  # nothing is turned inside out
    assert np.linalg.norm(x) == pytest.approx(np.linalg.norm(y))  # and it is round
    return matrix[:3, 3], (matrix @ [0.0, 0.0, 1.0, 1.0])[:3]


def test_arrows_reach_from_the_hubs_along_the_thrusts_and_with_the_wind():
    """By hand, upright and with the nose to the north.

    A thrust that carries the rotor's share of the weight is two radii of a disc long, which are
    0.35 of the rotors' way from the middle each; 1 m/s of wind is 0.25 m.
    """
    bench = Bench()
    share = bench.vehicle.mass * 9.81 / 4.0
    north = math.sqrt(0.5)
    bench.snapshot = dataclasses.replace(
        bench.snapshot,
        p_WB=(1.0, 2.0, 3.0),
        q_WB=(north, 0.0, 0.0, north),
        thrusts=(share, 0.5 * share, 0.0, 2.0 * share),
        wind=(0.0, -4.0, 0.0),
    )
    bench.show(FRAME)
    x, y, _ = bench.snapshot.p_WB
    centre = np.array(bench.vehicle.p_BoBcm_B)
    ways = [np.linalg.norm(np.array(rotor.p_BR) - centre) for rotor in bench.vehicle.rotors]
    full = 2.0 * 0.35 * sum(ways) / 4.0
    for number, factor in enumerate((1.0, 0.5, 0.0, 2.0), 1):
        p_x, p_y, p_z = bench.vehicle.rotors[number - 1].p_BR
        hub = np.array([x - p_y, y + p_x, 3.0 + p_z])
        tail, tip = ends(bench.page.matrices[f"thrust_{number}"])
        assert tail == pytest.approx(hub)
        assert tip == pytest.approx(hub + [0.0, 0.0, factor * full], abs=1e-3)
    tail, tip = ends(bench.page.matrices["wind"])
    middle = np.array([x - centre[1], y + centre[0], 3.0 + centre[2]])
    assert tip == pytest.approx(middle)
    assert tip - tail == pytest.approx([0.0, -1.0, 0.0])


def test_the_lidar_is_shown_thinned_and_seldom_and_still_less_where_the_flight_is_behind():
    bench = Bench()
    flown = Session(Scenario(world="room", sensors=SensorsConfig(use=["lidar"])))
    flown.tick(0.5)
    bench.scan = flown.reading("lidar")
    seen = flown.snapshot().lidar

    def fly(seconds, lag=0.0):
        before = len(bench.page.clouds)
        for _ in range(round(seconds / FRAME)):
            newer = dataclasses.replace(seen, stamp=bench.snapshot.time)
            bench.snapshot = dataclasses.replace(bench.snapshot, lidar=newer)
            bench.show(FRAME, lag)
        return len(bench.page.clouds) - before

    assert 6 <= fly(2.0) <= 9
    cloud = bench.page.clouds[-1]
    every = bench.scan.points_W()
    step = round(len(every) / len(cloud))
    assert len(cloud) <= MAX_SCAN_POINTS < len(every)
    np.testing.assert_allclose(cloud, every[::step], atol=1e-5)  # points are 32-bit
    fly(5.0, lag=0.2)
    assert fly(4.0, lag=0.2) <= 2


def test_a_predicted_way_is_shown_until_its_time_is_over():
    bench = Bench()
    bench.show(0.5)
    way = np.array([[0.0, 0.0, 1.0], [1.0, 0.0, 1.0], [1.0, 1.0, 1.0]])
    bench.picture.foresee(bench.snapshot.time + 1.0, way)
    path, points = bench.page.lines[-1]
    assert path == AHEAD_PATH
    np.testing.assert_array_equal(points, way.T)
    bench.show(0.9)
    assert bench.page.deleted == []
    bench.show(0.2)
    assert bench.page.deleted == [AHEAD_PATH]
    bench.show(0.5)
    bench.picture.foresee(99.0, way)
    bench.picture.foresee(0.0, np.empty((0, 3)))
    assert bench.page.deleted == [AHEAD_PATH, AHEAD_PATH]


def test_a_cable_is_straight_while_taut_hangs_while_slack_and_is_gone_with_an_open_hook():
    bench = Bench()
    taut = CableStatus("sling", (0.0, 0.0, 2.0), (0.6, 0.0, 1.2), 1.0, 3.0)
    slack = dataclasses.replace(taut, lower=(0.8, 0.0, 2.0), tension=0.0)
    lines = []
    for cables in ((taut,), (slack,), ()):
        bench.snapshot = dataclasses.replace(bench.snapshot, cables=cables)
        bench.show(0.05)
        lines.append([points.T for path, points in bench.page.lines if path == f"{CABLES_PATH}/0"])
    assert lines[0][-1].tolist() == [[0.0, 0.0, 2.0], [0.6, 0.0, 1.2]]
    hung = lines[1][-1]
    assert hung[[0, -1]].tolist() == [[0.0, 0.0, 2.0], [0.8, 0.0, 2.0]]
    assert hung[4] == pytest.approx([0.4, 0.0, 2.0 - 0.26], abs=1e-3)  # 0.866 of a triangle's 0.3
    assert np.linalg.norm(np.diff(hung, axis=0), axis=1).sum() == pytest.approx(1.0, abs=0.02)
    assert bench.page.deleted == [CABLES_PATH]


def test_meshcat_itself_takes_all_of_it():
    class Watched:
        """Meshcat at which somebody looks."""

        def __init__(self):
            self.real = Meshcat(MeshcatParams(host="localhost"))

        def __getattr__(self, name):
            return getattr(self.real, name)

        def GetNumActiveConnections(self):
            return 1

    meshcat = Watched()
    session = Session(Scenario(world="room", sensors=SensorsConfig(use=["lidar"])))
    session.tick(0.5)
    picture = LivePicture(
        meshcat, lambda: None, session.vehicle, lambda: 0.0, lambda: session.reading("lidar")
    )
    picture.show(session.snapshot(), Pace(1.0, 1.0, 0.0, 0.0, False))
    picture.foresee(9.0, np.zeros((2, 3)))
    for path in (
        f"{ARROWS_PATH}/thrust_4/head",
        f"{ARROWS_PATH}/wind/shaft",
        LIDAR_PATH,
        AHEAD_PATH,
    ):
        assert meshcat.real._GetPackedObject(path), path
    assert meshcat.real._GetPackedTransform(f"{ARROWS_PATH}/thrust_1")


@pytest.mark.parametrize("place", [math.nan, math.inf, 1e9])
def test_a_drone_that_is_lost_does_not_take_the_camera_along(place):
    bench = Bench()
    bench.show(0.5)
    told = len(bench.page.poses)
    bench.snapshot = dataclasses.replace(bench.snapshot, p_WB=(place, 0.0, 1.0))
    bench.show(0.5)
    assert len(bench.page.poses) == told


def test_a_session_draws_between_its_own_pictures():
    meshcat = Meshcat(MeshcatParams(host="localhost"))
    session = Session(meshcat=meshcat, picture_period=math.inf)
    session.tick(0.5)
    path = f"/drake/visualizer/dh_drone/{session.vehicle.base_link}"
    before = meshcat._GetPackedTransform(path)
    session.command(velocity=[2.0, 0.0, 0.0])
    session.tick(0.5)
    assert meshcat._GetPackedTransform(path) == before
    session.draw()
    assert meshcat._GetPackedTransform(path) != before


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
    assert camera.orbit[0] == CAMERA_ORBIT_PATH
    assert camera.orbit[1] == pytest.approx(snapshot.p_WB)
    assert snapshot.p_WB[0] > 1.0


@pytest.mark.parametrize(
    ("reach", "distance"),
    [(0.001, MIN_CAMERA_DISTANCE_M), (0.3, 2.1), (50.0, MAX_CAMERA_DISTANCE_M)],
)
def test_it_stands_as_far_off_as_the_drone_is_large(reach, distance):
    camera = Camera()
    place_camera(camera, reach)
    assert camera.way == pytest.approx(distance)


def test_meshcat_has_that_point_of_orbit():
    meshcat = Meshcat(MeshcatParams(host="localhost"))
    move_camera(meshcat, np.array(Session().snapshot().p_WB))
    assert CAMERA_ORBIT_PATH.encode() in meshcat._GetPackedTransform(CAMERA_ORBIT_PATH)
