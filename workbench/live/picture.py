"""The flight in Meshcat: drawn by the wall clock, as often as flight and machine allow."""

import math
from collections import deque
from collections.abc import Callable, Mapping

import numpy as np
from pydrake.geometry import Cylinder, Meshcat, MeshcatCone, Rgba
from pydrake.math import RigidTransform, RollPitchYaw
from pydrake.perception import PointCloud

from workbench.live.arrows import arrow_ends, drawn_disc_radius
from workbench.live.cable_lines import cable_line
from workbench.live.messages import Pace
from workbench.plant.vehicle import Vehicle
from workbench.session.snapshot import Snapshot
from workbench.systems.sensors.readings import LidarScan, Reading

MIN_PICTURE_PERIOD_S = 1 / 30
MAX_PICTURE_PERIOD_S = 0.5
"""Limits of the period between pictures [s of wall]."""
PICTURE_LAG_S = 0.1
"""Lag of a flight at which the rate of pictures is halved, before time must be skipped [s]."""
PICTURE_CALM_S = 5.0
"""After this time without such a lag the rate is doubled [s of wall]."""
DRONE_PATH = "/drone"
"""Meshcat's path whose transform has the drone's position and heading; pages follow it."""
TRAIL_PATH = "/trail"
"""Meshcat's path of the flown line."""
TRAIL_LENGTH_S = 30.0
"""Length of the flown line in simulated time [s]."""
TRAIL_STEP_S = 0.1
"""Simulated time between its points [s]."""
TRAIL_PERIOD_S = 0.25
"""Period between sent lines, each of which is a new object for the page [s of wall]."""
TRAIL_COLOUR = Rgba(1.0, 0.55, 0.0, 1.0)
AHEAD_PATH = "/ahead"
"""Meshcat's path of the predicted line."""
AHEAD_COLOUR = Rgba(0.65, 0.35, 0.95, 0.6)
ARROWS_PATH = "/arrows"
"""Meshcat's path of the arrows: `thrust_1` to `thrust_n`, and `wind`."""
ARROW_HEAD_RADII, ARROW_HEAD_SHARE = 0.25, 0.3
"""Radius of an arrow's head in radii of a rotor's disc, and its share of the length."""
MIN_ARROW_M = 1e-4
"""Shorter arrows are not drawn, as their matrix could not be inverted [m]."""
THRUST_COLOUR, WIND_COLOUR = Rgba(0.1, 0.7, 0.35, 1.0), Rgba(0.2, 0.65, 0.95, 1.0)
CABLES_PATH = "/cables"
"""Meshcat's path of the lines of cables, by their numbers."""
TAUT_COLOUR, SLACK_COLOUR = Rgba(0.15, 0.15, 0.2, 1.0), Rgba(0.9, 0.3, 0.1, 1.0)
LIDAR_PATH = "/lidar"
"""Meshcat's path of the lidar's points."""
MAX_SCAN_POINTS = 3000
"""Largest number of drawn points per scan."""
LIDAR_PERIOD_S = 0.25
"""Least period between sent clouds, each of which is a new object for the page [s of wall]..."""
PICTURES_PER_SCAN = 6.0
"""... and least number of pictures between them."""
SCAN_POINT_SIZE_M = 0.04
LIDAR_COLOUR = Rgba(0.95, 0.25, 0.45, 1.0)
MAX_DRAWN_DISTANCE_M = 1e5
"""A drone farther away is lost, and so would be the page's numbers [m]."""

CAMERA_DISTANCE_RADII = 7.0
"""Distance of the camera, in distances from the drone's origin to its farthest rotor."""
MIN_CAMERA_DISTANCE_M, MAX_CAMERA_DISTANCE_M = 1.0, 20.0
"""Limits of the camera's distance [m]."""
CAMERA_DIRECTION_W = np.array([-0.75, -0.55, 0.37])
"""From the drone to the camera, in W: behind, to the right and above."""
CAMERA_ORBIT_PATH = "/Cameras/default"
"""Meshcat's name of the point that the mouse turns its camera around."""


class LivePicture:
    """Draws the reported flight for the pages that are open.

    A picture costs the flight half a millisecond, and the machine much more if its processor draws.
    So the flight has priority: if it falls behind, it is drawn half as often.

    Args:
        meshcat: the Meshcat to draw in.
        draw: draws the present scene there.
        vehicle: the flying vehicle.
        now: returns the wall time [s].
        scan: returns the lidar's last scan, None before the first.
    """

    def __init__(
        self,
        meshcat: Meshcat,
        draw: Callable[[], None],
        vehicle: Vehicle,
        now: Callable[[], float],
        scan: Callable[[], Reading | None] = lambda: None,
    ) -> None:
        self._meshcat, self._draw, self._now, self._scan = meshcat, draw, now, scan
        self._vehicle = vehicle
        reach = max(math.dist((0.0, 0.0, 0.0), rotor.p_BR) for rotor in vehicle.rotors)
        place_camera(meshcat, reach)
        numbers = range(1, len(vehicle.rotors) + 1)
        thrusts = {f"{ARROWS_PATH}/thrust_{number}": THRUST_COLOUR for number in numbers}
        colours = {**thrusts, f"{ARROWS_PATH}/wind": WIND_COLOUR}
        self._arrows = MeshcatArrows(
            meshcat, colours, ARROW_HEAD_RADII * drawn_disc_radius(vehicle)
        )
        self._due = self._trail_due = self._scan_due = -math.inf
        self._stamp = -math.inf
        self._ahead_ends = -math.inf
        self._late = now()
        self._trail: deque[tuple[float, ...]] = deque()
        self._time = -math.inf
        self._cables = False
        self.period = MIN_PICTURE_PERIOD_S

    def show(self, snapshot: Snapshot, pace: Pace) -> None:
        """Draw the present if a picture is due."""
        if not all(
            abs(x) < MAX_DRAWN_DISTANCE_M for x in snapshot.p_WB
        ):  # never, where this is NaN
            return
        self._remember(snapshot)
        now = self._now()
        self._adapt(pace, now)
        if now < self._due or not self._meshcat.GetNumActiveConnections():
            return
        self._due = max(self._due + self.period, now)
        self._draw()
        yaw = RollPitchYaw(0.0, 0.0, snapshot.roll_pitch_yaw[2])
        self._meshcat.SetTransform(DRONE_PATH, RigidTransform(yaw, np.array(snapshot.p_WB)))
        move_camera(self._meshcat, np.array(snapshot.p_WB))
        self._arrows.reach(*arrow_ends(self._vehicle, snapshot))
        self._show_cables(snapshot)
        self._show_scan(snapshot, now)
        if snapshot.time > self._ahead_ends:
            self.foresee(-math.inf, np.empty((0, 3)))
        if now >= self._trail_due and len(self._trail) > 1:
            self._trail_due = now + TRAIL_PERIOD_S
            points = np.array(self._trail)[:, 1:].T
            self._meshcat.SetLine(TRAIL_PATH, points, 2.0, TRAIL_COLOUR)

    def foresee(self, ends: float, p_WB: np.ndarray) -> None:
        """Show a predicted path (N, 3) [m] until a simulated time [s]; an empty one shows none."""
        if len(p_WB) > 1:
            self._ahead_ends = ends
            self._meshcat.SetLine(AHEAD_PATH, p_WB.T, 2.0, AHEAD_COLOUR)
        elif self._ahead_ends > -math.inf:
            self._ahead_ends = -math.inf
            self._meshcat.Delete(AHEAD_PATH)

    def _show_cables(self, snapshot: Snapshot) -> None:
        """Show the cables, slack ones in another colour; none where hooks are open."""
        if self._cables and not snapshot.cables:
            self._meshcat.Delete(CABLES_PATH)
        self._cables = bool(snapshot.cables)
        for number, cable in enumerate(snapshot.cables):
            colour = SLACK_COLOUR if cable.slack else TAUT_COLOUR
            self._meshcat.SetLine(f"{CABLES_PATH}/{number}", cable_line(cable).T, 3.0, colour)

    def _show_scan(self, snapshot: Snapshot, now: float) -> None:
        """Show the lidar's points, if there is a new scan and it is due."""
        seen = snapshot.lidar
        if seen is None or seen.stamp == self._stamp or now < self._scan_due:
            return
        scan = self._scan()
        if not isinstance(scan, LidarScan):
            return
        self._stamp = seen.stamp
        self._scan_due = now + max(LIDAR_PERIOD_S, PICTURES_PER_SCAN * self.period)
        points = scan.points_W()
        points = points[:: 1 + len(points) // MAX_SCAN_POINTS]
        cloud = PointCloud(len(points))
        cloud.mutable_xyzs()[:] = points.T
        self._meshcat.SetObject(LIDAR_PATH, cloud, SCAN_POINT_SIZE_M, LIDAR_COLOUR)

    def _remember(self, snapshot: Snapshot) -> None:
        """Add the drone's position to the trail; a reset starts a new trail."""
        if snapshot.time < self._time:
            self._trail.clear()
            self._meshcat.Delete(TRAIL_PATH)
        self._time = snapshot.time
        if not self._trail or snapshot.time - self._trail[-1][0] >= TRAIL_STEP_S:
            self._trail.append((snapshot.time, *snapshot.p_WB))
            while snapshot.time - self._trail[0][0] > TRAIL_LENGTH_S:
                self._trail.popleft()

    def _adapt(self, pace: Pace, now: float) -> None:
        """Adapt the rate of pictures to the flight's lag."""
        if pace.lag > PICTURE_LAG_S and now >= self._late + self.period:
            self.period = min(2.0 * self.period, MAX_PICTURE_PERIOD_S)
            self._late = now
        elif now - self._late > PICTURE_CALM_S and self.period > MIN_PICTURE_PERIOD_S:
            self.period = max(self.period / 2.0, MIN_PICTURE_PERIOD_S)
            self._late = now


class MeshcatArrows:
    """Arrows that are drawn once, and then only turned, moved and stretched.

    Args:
        meshcat: the Meshcat to draw in.
        colours: colour of each arrow, by its path there.
        radius: radius of their heads [m].
    """

    def __init__(self, meshcat: Meshcat, colours: Mapping[str, Rgba], radius: float) -> None:
        self._meshcat, self._paths, self._radius = meshcat, tuple(colours), radius
        # of length and radius 1 along z; Meshcat's cones stand on their tips
        tip = RigidTransform(RollPitchYaw(math.pi, 0.0, 0.0), np.array([0.0, 0.0, 1.0]))
        shaft = 1.0 - ARROW_HEAD_SHARE
        for path, colour in colours.items():
            meshcat.SetObject(f"{path}/head", MeshcatCone(ARROW_HEAD_SHARE, 1.0, 1.0), colour)
            meshcat.SetTransform(f"{path}/head", tip)
            meshcat.SetObject(f"{path}/shaft", Cylinder(0.3, shaft), colour)
            meshcat.SetTransform(f"{path}/shaft", RigidTransform(np.array([0.0, 0.0, shaft / 2])))

    def reach(self, tails: np.ndarray, tips: np.ndarray) -> None:
        """Stretch the arrows from tails to tips in W (N, 3) [m]; one without length is invisible.

        The columns of a matrix are the arrow's x, y and z axes, and its tail. All are computed at
        once: numpy takes as long for a single arrow.
        """
        z = tips - tails
        length = np.sqrt((z * z).sum(axis=1))
        none = length < MIN_ARROW_M
        z[none], length[none] = [0.0, 0.0, MIN_ARROW_M], MIN_ARROW_M
        x = np.zeros_like(z)  # across z, in the plane of its two larger components
        rows, small = np.arange(len(z)), np.abs(z).argmin(axis=1)
        one, other = (small + 1) % 3, (small + 2) % 3
        x[rows, one], x[rows, other] = -z[rows, other], z[rows, one]
        thick = np.where(none, MIN_ARROW_M, self._radius)
        x *= (thick / np.sqrt((x * x).sum(axis=1)))[:, None]
        matrices = np.tile(np.eye(4), (len(z), 1, 1))
        matrices[:, :3, 0], matrices[:, :3, 2], matrices[:, :3, 3] = x, z, tails
        for to, (first, second) in enumerate(((1, 2), (2, 0), (0, 1))):  # z × x / |z|
            matrices[:, to, 1] = (z[:, first] * x[:, second] - z[:, second] * x[:, first]) / length
        for path, matrix in zip(self._paths, matrices, strict=True):
            self._meshcat.SetTransform(path, matrix)


def place_camera(meshcat: Meshcat, reach: float) -> None:
    """Place Meshcat's camera behind a drone, farther off if it is larger; the mouse may move it.

    Args:
        meshcat: the camera's Meshcat.
        reach: distance from the drone's origin to its farthest rotor [m].
    """
    distance = float(
        np.clip(CAMERA_DISTANCE_RADII * reach, MIN_CAMERA_DISTANCE_M, MAX_CAMERA_DISTANCE_M)
    )
    meshcat.SetCameraPose(
        distance * CAMERA_DIRECTION_W / np.linalg.norm(CAMERA_DIRECTION_W), np.zeros(3)
    )


def move_camera(meshcat: Meshcat, p_WB: np.ndarray) -> None:
    """Move Meshcat's camera along with a drone, from where it was placed or the mouse left it."""
    meshcat.SetTransform(CAMERA_ORBIT_PATH, RigidTransform(p_WB))
    meshcat.SetCameraTarget(p_WB)
