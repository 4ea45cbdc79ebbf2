"""The flown signals of one round of an excitation."""

from dataclasses import dataclass, replace

import numpy as np

from workbench.common.series import TimedArrays
from workbench.gui.signals import Signals
from workbench.logs.readers.rotations import quaternion_from_angles
from workbench.plant.vehicle import Vehicle
from workbench.scenario.attitude_axes import AttitudeAxis
from workbench.scenario.excitation import Excitation
from workbench.scenario.loads import Load


@dataclass(frozen=True)
class RoundTrace(TimedArrays):
    """Flown signals from the edge of a round on; (N) each.

    Attributes:
        time: time from the edge on [s].
        response: velocity [m/s], yaw rate [rad/s], attitude [rad] or rate [rad/s]; for a load the
            deviation from the original position.
        tilt: tilt [rad].
        rotor_use: largest share of its speed limit that any rotor has, at each time.
    """

    time: np.ndarray
    response: np.ndarray
    tilt: np.ndarray
    rotor_use: np.ndarray

    def __len__(self) -> int:
        return len(self.time)

    def part(self, begin: float, end: float) -> "RoundTrace":
        """Return the part between two times [s], of which the first becomes zero."""
        found = self.only((self.time > begin - 1e-6) & (self.time < end + 1e-6))
        return replace(found, time=found.time - begin)


def _response(
    signals: Signals, excitation: Excitation, since: float
) -> tuple[np.ndarray, np.ndarray]:
    """Return times (N) [s] and the response (N) to an excitation since a time [s]."""
    row = excitation.row
    time, first = signals.series(row.signal, since)
    if not isinstance(row, AttitudeAxis) or not row.is_rate:
        return time, first
    rates = [signals.series(name, since)[1] for name in row.signals]
    angles = [
        signals.series(f"position_data.{name}", since)[1] for name in ("roll", "pitch", "yaw")
    ]
    size = min(map(len, (*rates, *angles)))
    q_WB = quaternion_from_angles(*(each[:size] for each in angles))
    return time[:size], row.moved(q_WB, np.transpose([each[:size] for each in rates]))


def take_trace(
    signals: Signals, excitation: Excitation, vehicle: Vehicle, begun: float, end: float = np.inf
) -> RoundTrace:
    """Return copies of the signals since the start of a round, or until its end.

    Args:
        signals: signals of the flight.
        excitation: the flown excitation.
        vehicle: the flown vehicle.
        begun: simulated time of the round's edge [s].
        end: simulated time of the end [s].
    """
    since = begun - 1e-6
    time, response = _response(signals, excitation, since)
    _, roll = signals.series("position_data.roll", since)
    _, pitch = signals.series("position_data.pitch", since)
    shares = [
        signals.series(f"rotors.speed.{index}", since)[1] / rotor.max_rot_velocity
        for index, rotor in enumerate(vehicle.rotors)
    ]
    last = int(np.searchsorted(time, end + 1e-6))
    # All of these come from one sample of the flight; a topic may briefly be one sample behind.
    size = min(last, len(roll), *(len(share) for share in shares))
    time, roll, pitch, response = time[:size], roll[:size], pitch[:size], response[:size]
    if isinstance(excitation.row, Load):
        response = response - response[:1]
    tilt = np.arccos(np.clip(np.cos(roll) * np.cos(pitch), -1.0, 1.0))
    use = np.max(np.abs([share[:size] for share in shares]), axis=0)
    return RoundTrace(time - begun, response.copy(), tilt, use)
