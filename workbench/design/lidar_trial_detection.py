"""Speed of detection: from coming into a lidar's view to the first return, by obstacle."""

import math
from dataclasses import dataclass

import numpy as np
from pydrake.math import RigidTransform

from workbench.design.lidar_trial_accuracy import Accuracy
from workbench.design.lidar_trial_flight import Scan, TrialFlight


@dataclass(frozen=True)
class Detection:
    """How soon one obstacle was found; NaN where it never was.

    It comes into view when, by closed form, a ray meets it first and within range, and goes on to
    for a scan period or until a scan has it: a scan is bound to fall into that time, while
    a ray that brushes it between two scans is nothing that a lidar has to notice.

    Attributes:
        obstacle: its name.
        from_start: whether it was in view when the flight began.
        entered: when it came into view [s].
        entered_distance: from the lidar to its nearest point then [m].
        returned: when a scan with a return from it was delivered first [s].
        returned_distance: from the lidar to its nearest point then [m].
    """

    obstacle: str
    from_start: bool
    entered: float
    entered_distance: float
    returned: float
    returned_distance: float

    @property
    def delay(self) -> float:
        """From coming into view to the delivery of the first return [s]; NaN if never in view.

        In view and never returned is an endless delay.
        """
        if math.isnan(self.entered):
            return math.nan
        return math.inf if math.isnan(self.returned) else self.returned - self.entered


def detect(flight: TrialFlight, accuracy: Accuracy) -> tuple[Detection, ...]:
    """Return how soon each obstacle of a flight was found, in their order."""
    numbers = range(len(flight.obstacles))
    firsts = [
        next((each.scan for each in accuracy.scans if index in each.seen), None)
        for index in numbers
    ]
    entered = _came_into_view(flight, [scan.stamp if scan else math.inf for scan in firsts])
    return tuple(_detection(flight, index, entered[index], firsts[index]) for index in numbers)


def slowest_detection(flight: TrialFlight) -> float:
    """Return the longest delay of a lidar that delivers as promised [s].

    A scan comes within a period; its reader looks for it once every control period.
    """
    return flight.period + flight.latency + flight.control_period


def _detection(flight: TrialFlight, index: int, entered: float, first: Scan | None) -> Detection:
    """Return the record of one obstacle; `first` is the first scan that has it."""
    obstacle = flight.obstacles[index]
    returned = first.delivered if first else math.nan
    entered_distance, returned_distance = (
        math.nan if math.isnan(time) else obstacle.distance(time, flight.X_WS(time).translation())
        for time in (entered, returned)
    )
    return Detection(
        obstacle=obstacle.name,
        from_start=entered == float(flight.recording.time[0]),
        entered=entered,
        entered_distance=entered_distance,
        returned=returned,
        returned_distance=returned_distance,
    )


def _came_into_view(flight: TrialFlight, stamps: list[float]) -> list[float]:
    """Return when each obstacle came into view [s], see `Detection`; NaN if it never did.

    A stay in view that has not lasted for a scan period when the flight ends does not count, as
    no scan needs to fall into it.

    Args:
        flight: what was flown.
        stamps: for each obstacle, that of the first scan that has it [s].
    """
    since = [math.nan] * len(stamps)
    entered = [math.nan] * len(stamps)
    for time in flight.recording.time.tolist():
        X_WS = flight.X_WS(time)
        for index, stamp in enumerate(stamps):
            if not math.isnan(entered[index]):
                continue
            if not _in_view(flight, index, time, X_WS):
                since[index] = math.nan
                continue
            if math.isnan(since[index]):
                since[index] = time
            lasted = time - since[index] >= flight.period - 1e-9
            if lasted or since[index] <= stamp <= time:
                entered[index] = since[index]
    return entered


def _in_view(flight: TrialFlight, index: int, time: float, X_WS: RigidTransform) -> bool:
    """Return whether a ray of the lidar meets an obstacle first, and within range."""
    lidar, d_S = flight.lidar, flight.directions
    length = flight.obstacles[index].first(time, X_WS, d_S, lidar.max_range)
    some = np.flatnonzero((length >= lidar.min_range) & (length <= lidar.max_range))
    free, length = d_S[some], length[some]
    for number, other in enumerate(flight.obstacles):
        if number != index and len(free):
            open_way = other.first(time, X_WS, free, lidar.max_range) >= length
            free, length = free[open_way], length[open_way]
    return len(free) > 0
