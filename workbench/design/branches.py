"""Branches of a flight from a checkpoint, without Drake, so that screens can import them."""

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from workbench.scenario.axes import find_axis


@dataclass(frozen=True)
class Branch:
    """One way to continue a flight.

    Attributes:
        name: of the branch.
        gains: values of live parameters to set at the checkpoint, by name.
        controller: the one that takes over at the checkpoint, see `load_controller`; "" keeps the
            present one. A different controller starts with its own gains, see `Session.begin_from`.
    """

    name: str
    gains: Mapping[str, float]
    controller: str = ""


@dataclass(frozen=True)
class FlownBranch:
    """The simulated flight of one branch; it ends where the flight is lost.

    Attributes:
        name: of the branch.
        time: simulated (N) [s]; the first is the time of the checkpoint, or of the next recorded
            sample.
        velocity: in W (N, 3) [m/s].
        yaw_rate: (N) [rad/s].
        position: in W (N, 3) [m].
        tilt: (N) [rad].
        rotor_use: largest share of any rotor's speed limit (N).
        lost: why the flight was lost, "" if it was not.
    """

    name: str
    time: np.ndarray
    velocity: np.ndarray
    yaw_rate: np.ndarray
    position: np.ndarray
    tilt: np.ndarray
    rotor_use: np.ndarray
    lost: str

    def response(self, axis: str) -> np.ndarray:
        """Return the velocity along x, y or z [m/s], or the yaw rate [rad/s]."""
        place = find_axis(axis).place
        return self.yaw_rate if place is None else self.velocity[:, place]
