"""Meshcat's camera beside the drone: it comes along, and may be turned and moved by the mouse."""

import numpy as np
from pydrake.geometry import Meshcat
from pydrake.math import RigidTransform

from workbench.session.snapshot import Snapshot

SIZES = 7.0
"""Its distance, in reaches of the drone's rotors."""
NEAREST, FARTHEST = 1.0, 20.0
"""Bounds of that [m]."""
DIRECTION = np.array([-0.75, -0.55, 0.37])
"""From the drone to the camera, in W: behind, to the right and above."""
ORBIT = "/Cameras/default"
"""Meshcat's name of the point around which the mouse turns its camera."""


class ChaseCamera:
    """Keeps the drone in the middle of the picture.

    Args:
        meshcat: whose camera.
        reach: from the drone's origin to its farthest rotor [m].
    """

    def __init__(self, meshcat: Meshcat, reach: float) -> None:
        self._meshcat = meshcat
        distance = float(np.clip(SIZES * reach, NEAREST, FARTHEST))
        meshcat.SetCameraPose(distance * DIRECTION / np.linalg.norm(DIRECTION), np.zeros(3))

    def follow(self, snapshot: Snapshot) -> None:
        """Go where the drone is."""
        p_WB = np.array(snapshot.p_WB)
        self._meshcat.SetTransform(ORBIT, RigidTransform(p_WB))
        self._meshcat.SetCameraTarget(p_WB)
