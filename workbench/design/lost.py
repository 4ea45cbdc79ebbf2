"""When a flight is lost: the rule of compiled flights, for any recording."""

from dataclasses import dataclass

import numpy as np

from workbench.control.mode import FlightMode
from workbench.design.tumbling import TUMBLING_RATE, TUMBLING_SPEED
from workbench.session.recording import Recording

NEAR_GROUND_MODES = (FlightMode.OFF, FlightMode.ARMED, FlightMode.TAKING_OFF, FlightMode.LANDING)
"""Modes in which a drone may stand on the ground, which yields a little."""


@dataclass(frozen=True)
class Loss:
    """The loss of a flight; what follows it does not count.

    Attributes:
        time: in the flight [s].
        how: in words.
    """

    time: float
    how: str

    @property
    def sentence(self) -> str:
        """Time and cause in a sentence."""
        return f"the flight is lost at t = {self.time:.3f} s: {self.how}"


def find_loss(recording: Recording) -> Loss | None:
    """Return when and how a flight was lost, else None.

    A flight is lost when a number is not finite; when the drone touches the ground, except while
    taking off, landing or with motors off; or when it is tilted over 90 degrees and turns faster
    than 10 rad/s or moves faster than 20 m/s.
    """
    motion = (recording.p_WB, recording.q_WB, recording.v_WB, recording.w_WB)
    broken: np.ndarray = ~np.all(np.isfinite(np.column_stack(motion)), axis=1)
    low = recording.p_WB[:, 2] < recording.vehicle.ground_clearance
    low &= ~np.isin(recording.mode, NEAR_GROUND_MODES)
    with np.errstate(over="ignore", invalid="ignore"):  # of what is broken already
        turning = np.linalg.norm(recording.w_WB, axis=1)
        speed = np.linalg.norm(recording.v_WB, axis=1)
        w, x, y, z = recording.q_WB.T
        over = w * w + z * z <= x * x + y * y
    tumbling = over & ((turning > TUMBLING_RATE) | (speed > TUMBLING_SPEED))
    lost = np.flatnonzero(broken | low | tumbling)
    if not len(lost):
        return None
    at = int(lost[0])
    if broken[at]:
        how = "its state is no longer finite"
    elif low[at]:
        how = "it has come down to the ground"
    elif turning[at] > TUMBLING_RATE:
        how = f"upside down and turning at {turning[at]:.0f} rad/s"
    else:
        how = f"upside down and moving at {speed[at]:.0f} m/s"
    return Loss(float(recording.time[at]), how)
