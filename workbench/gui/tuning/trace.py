"""A piece of a flight as the tuning screen draws and measures it."""

from dataclasses import dataclass

import numpy as np

from workbench.gui.signals import Signals
from workbench.plant.vehicle import Vehicle
from workbench.scenario.excitation import Excitation
from workbench.scenario.loads import Load


@dataclass(frozen=True)
class Trace:
    """What was flown from the edge of a round on; (N) each.

    Attributes:
        time: from the edge on [s].
        response: velocity [m/s] or yaw rate [rad/s]; of a load the deviation from where it was.
        tilt: [rad].
        rotor_use: largest share of any rotor's speed limit, at each time.
    """

    time: np.ndarray
    response: np.ndarray
    tilt: np.ndarray
    rotor_use: np.ndarray

    def __len__(self) -> int:
        return len(self.time)

    def until(self, end: float) -> "Trace":
        """Return the part up to a time, which it includes [s]."""
        size = int(np.searchsorted(self.time, end + 1e-6))
        return self.between(0, size)

    def since(self, begin: float) -> "Trace":
        """Return the part from a time on, which becomes zero [s]."""
        first = int(np.searchsorted(self.time, begin - 1e-6))
        return self.between(first, len(self.time), begin)

    def between(self, first: int, last: int, zero: float = 0.0) -> "Trace":
        """Return the samples from one to another, their times from `zero` on."""
        part = slice(first, last)
        return Trace(
            self.time[part] - zero,
            self.response[part],
            self.tilt[part],
            self.rotor_use[part],
        )


def take_trace(
    signals: Signals, excitation: Excitation, vehicle: Vehicle, begun: float, end: float = np.inf
) -> Trace:
    """Return what was flown since a round began, or until its end: copies.

    Args:
        signals: of the flight.
        excitation: that was flown.
        vehicle: that flew it.
        begun: simulated time of the round's edge [s].
        end: simulated time up to which is wanted [s].
    """
    since = begun - 1e-6
    time, response = signals.series(excitation.row.signal, since)
    _, roll = signals.series("position_data.roll", since)
    _, pitch = signals.series("position_data.pitch", since)
    shares = [
        signals.series(f"rotors.speed.{index}", since)[1] / rotor.max_rot_velocity
        for index, rotor in enumerate(vehicle.rotors)
    ]
    last = int(np.searchsorted(time, end + 1e-6))
    # All of these come from one sample of the flight; a topic may be one behind for a moment.
    size = min(last, len(roll), *(len(share) for share in shares))
    time, roll, pitch, response = time[:size], roll[:size], pitch[:size], response[:size]
    if isinstance(excitation.row, Load):
        response = response - response[:1]
    tilt = np.arccos(np.clip(np.cos(roll) * np.cos(pitch), -1.0, 1.0))
    use = np.max(np.abs([share[:size] for share in shares]), axis=0)
    return Trace(time - begun, response.copy(), tilt, use)
