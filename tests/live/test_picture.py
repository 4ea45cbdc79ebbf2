"""The flight in Meshcat comes as often as the flight carries, and only where a page looks on."""

import dataclasses
import math

import pytest
from pydrake.geometry import Meshcat, MeshcatParams

from workbench.live.messages import Pace
from workbench.live.picture import CALM, DRONE, LONGEST, SHORTEST, TRAIL, Picture
from workbench.session.session import Session

FRAME = 1 / 60


class Page:
    """Meshcat with pages that look on, and a note of what they are told."""

    def __init__(self, pages=1):
        self.pages = pages
        self.poses, self.lines, self.deleted = [], [], []

    def GetNumActiveConnections(self):
        return self.pages

    def SetCameraPose(self, camera_in_world, target_in_world):
        pass

    def SetCameraTarget(self, target_in_world):
        pass

    def SetTransform(self, path, X_ParentPath):
        if path == DRONE:
            self.poses.append(X_ParentPath)

    def SetLine(self, path, vertices, line_width, rgba):
        self.lines.append((path, vertices))

    def Delete(self, path):
        self.deleted.append(path)


class Bench:
    """A picture, its clock, and a drone that flies along x at 1 m/s."""

    def __init__(self, pages=1):
        self.page, self.drawn, self.wall = Page(pages), 0, 0.0
        self.snapshot = Session().snapshot()
        self.picture = Picture(self.page, self._draw, 0.25, lambda: self.wall)

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
    assert bench.show(2.0) == pytest.approx(2.0 / SHORTEST, abs=3)
    bench.show(5.0, lag=0.2)
    assert bench.picture.period == LONGEST
    assert bench.show(2.0, lag=0.2) <= 2.0 / LONGEST + 1
    bench.show(6 * CALM)
    assert bench.picture.period == SHORTEST


def test_the_speed_of_the_flight_makes_no_more_pictures():
    bench = Bench()
    assert bench.show(2.0, speed=10.0) <= 2.0 / SHORTEST + 1


def test_where_no_page_looks_on_nothing_is_drawn_until_one_does():
    bench = Bench(pages=0)
    assert bench.show(2.0) == 0
    bench.page.pages = 1
    assert bench.show(1.0) > 0


def test_the_trail_is_the_last_thirty_seconds_and_begins_anew_with_a_reset():
    bench = Bench()
    bench.show(40.0)
    path, points = bench.page.lines[-1]
    assert path == TRAIL
    assert points[0, -1] - points[0, 0] == pytest.approx(30.0, abs=0.5)
    assert points[0, -1] == pytest.approx(bench.snapshot.p_WB[0], abs=0.5)
    assert len(bench.page.lines) < 200  # each is a new object for the page
    bench.snapshot = Session().snapshot()
    bench.show(1.0)
    assert bench.page.deleted == [TRAIL]
    assert bench.page.lines[-1][1].shape[1] <= 11


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
