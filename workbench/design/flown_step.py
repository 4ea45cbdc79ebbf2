"""What the records of flown steps share: the part from the edge on, and the loss of the flight."""

import math
from dataclasses import dataclass, field
from typing import TYPE_CHECKING

import numpy as np

from workbench.design.flier import FlierFlight
from workbench.scenario.axes import AXIS_NAMES

if TYPE_CHECKING:
    from workbench.design.lost import Loss
    from workbench.session.recording import Recording

STEP_EDGE_S = 1.0
"""Time of hover before the edge of the command [s]."""


@dataclass(frozen=True)
class FlownStep(FlierFlight):
    """A recorded flight with a step; the base of the records of its kinds.

    Attributes:
        edge: time of the step [s].
    """

    edge: float = field(default=STEP_EDGE_S, kw_only=True)

    @property
    def after(self) -> "Recording":
        """The recording from the edge on."""
        return self.recording.between(self.edge, np.inf)

    @property
    def time(self) -> np.ndarray:
        """Time from the edge on [s]."""
        return self.after.time - self.edge

    @property
    def loss(self) -> "Loss | None":
        """When and how the flight was lost, else None; the metrics of a lost flight mean little."""
        from workbench.design.lost import find_loss

        return find_loss(self.recording)

    @property
    def diverged_at(self) -> float:
        """Time from the edge to the loss [s]; 0 if it was before, NaN without a loss."""
        return max(0.0, self.loss.time - self.edge) if self.loss else math.nan


def axis_velocity(recording: "Recording", axis: str) -> np.ndarray:
    """Return the velocity along an axis of W [m/s], or the yaw rate [rad/s]."""
    if axis == "yaw":
        return recording.w_WB[:, 2]
    return recording.v_WB[:, AXIS_NAMES.index(axis)]
