"""The flight in Meshcat: drawn by the wall clock, as often as flight and machine carry."""

import math
from collections import deque
from collections.abc import Callable

import numpy as np
from pydrake.geometry import Meshcat, Rgba
from pydrake.math import RigidTransform, RollPitchYaw

from workbench.live.messages import Pace
from workbench.session.snapshot import Snapshot

SHORTEST, LONGEST = 1 / 30, 0.5
"""Between two pictures [s of wall]."""
BEHIND = 0.1
"""Lag of a flight from which pictures come half as often, before it has to give up time [s]."""
CALM = 5.0
"""After so long without such a lag they come twice as often [s of wall]."""
DRONE = "/drone"
"""Meshcat's path whose transform is the drone's place and heading; pages follow it."""
TRAIL = "/trail"
"""Meshcat's path of the line that was flown."""
TRAIL_TIME = 30.0
"""Simulated time of which the line is shown [s]."""
TRAIL_STEP = 0.1
"""Simulated time between its points [s]."""
TRAIL_PERIOD = 0.25
"""Between two lines sent, each of which is a new object for the page [s of wall]."""
TRAIL_COLOUR = Rgba(1.0, 0.55, 0.0, 1.0)
FARTHEST = 1e5
"""A drone farther off is lost, and a page's numbers with it [m]."""

SIZES = 7.0
"""Distance of the camera, in reaches of the drone's rotors."""
CAMERA_NEAREST, CAMERA_FARTHEST = 1.0, 20.0
"""Bounds of that [m]."""
DIRECTION = np.array([-0.75, -0.55, 0.37])
"""From the drone to the camera, in W: behind, to the right and above."""
ORBIT = "/Cameras/default"
"""Meshcat's name of the point around which the mouse turns its camera."""


class Picture:
    """Draws what is reported, where a page looks on.

    A picture costs the flight half a millisecond, and the machine much more where its processor
    draws. So the flight comes first: one that falls behind is drawn half as often.

    Args:
        meshcat: where to draw.
        draw: draws the scene there as it is now.
        reach: from the drone's origin to its farthest rotor [m].
        now: tells the wall time [s].
    """

    def __init__(
        self, meshcat: Meshcat, draw: Callable[[], None], reach: float, now: Callable[[], float]
    ) -> None:
        self._meshcat, self._draw, self._now = meshcat, draw, now
        self._camera = ChaseCamera(meshcat, reach)
        self._due = self._trail_due = -math.inf
        self._late = now()
        self._trail: deque[tuple[float, ...]] = deque()
        self._time = -math.inf
        self.period = SHORTEST

    def show(self, snapshot: Snapshot, pace: Pace) -> None:
        """Draw the present, if a picture is due."""
        if not all(abs(x) < FARTHEST for x in snapshot.p_WB):  # nor is it where that is NaN
            return
        self._remember(snapshot)
        now = self._now()
        self._adapt(pace, now)
        if now < self._due or not self._meshcat.GetNumActiveConnections():
            return
        self._due = max(self._due + self.period, now)
        self._draw()
        yaw = RollPitchYaw(0.0, 0.0, snapshot.roll_pitch_yaw[2])
        self._meshcat.SetTransform(DRONE, RigidTransform(yaw, np.array(snapshot.p_WB)))
        self._camera.follow(snapshot)
        if now >= self._trail_due and len(self._trail) > 1:
            self._trail_due = now + TRAIL_PERIOD
            points = np.array(self._trail)[:, 1:].T
            self._meshcat.SetLine(TRAIL, points, 2.0, TRAIL_COLOUR)

    def _remember(self, snapshot: Snapshot) -> None:
        """Keep where the drone is for the trail; a reset begins it anew."""
        if snapshot.time < self._time:
            self._trail.clear()
            self._meshcat.Delete(TRAIL)
        self._time = snapshot.time
        if not self._trail or snapshot.time - self._trail[-1][0] >= TRAIL_STEP:
            self._trail.append((snapshot.time, *snapshot.p_WB))
            while snapshot.time - self._trail[0][0] > TRAIL_TIME:
                self._trail.popleft()

    def _adapt(self, pace: Pace, now: float) -> None:
        """Let pictures come as often as the flight stands."""
        if pace.lag > BEHIND and now >= self._late + self.period:
            self.period = min(2.0 * self.period, LONGEST)
            self._late = now
        elif now - self._late > CALM and self.period > SHORTEST:
            self.period = max(self.period / 2.0, SHORTEST)
            self._late = now


class ChaseCamera:
    """Keeps Meshcat's camera on the drone; the mouse may turn and move it.

    Args:
        meshcat: whose camera.
        reach: from the drone's origin to its farthest rotor [m].
    """

    def __init__(self, meshcat: Meshcat, reach: float) -> None:
        self._meshcat = meshcat
        distance = float(np.clip(SIZES * reach, CAMERA_NEAREST, CAMERA_FARTHEST))
        meshcat.SetCameraPose(distance * DIRECTION / np.linalg.norm(DIRECTION), np.zeros(3))

    def follow(self, snapshot: Snapshot) -> None:
        """Go where the drone is."""
        p_WB = np.array(snapshot.p_WB)
        self._meshcat.SetTransform(ORBIT, RigidTransform(p_WB))
        self._meshcat.SetCameraTarget(p_WB)
