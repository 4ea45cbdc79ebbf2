"""The time and the distance at which a lidar first reports an obstacle."""

import math
from dataclasses import dataclass

import numpy as np
from pydrake.math import RigidTransform

from workbench.design.lidar_accuracy import Accuracy, range_tolerance
from workbench.design.lidar_flight import Scan, TrialFlight


@dataclass(frozen=True)
class Detection:
    """The delay until one obstacle was found; NaN if it never was.

    An obstacle comes into view when, in closed form, a ray hits it first and within range, for at
    least a scan period or until a scan contains it: a scan must fall into that time. A ray that
    only grazes it between two scans does not count.

    Attributes:
        obstacle: its name.
        from_start: whether it was in view at the start of the flight.
        entered: when it came into view [s].
        entered_distance: from the lidar to its nearest point then [m].
        returned: time of delivery of the first scan with a return from it [s].
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

        The delay is infinite if it was in view and never returned.
        """
        if math.isnan(self.entered):
            return math.nan
        return math.inf if math.isnan(self.returned) else self.returned - self.entered


def find_detections(flight: TrialFlight, accuracy: Accuracy) -> tuple[Detection, ...]:
    """Return the detection of each obstacle of a flight, in their order."""
    numbers = range(len(flight.obstacles))
    right = np.abs(accuracy.error) <= range_tolerance(flight.lidar)
    firsts = [
        flight.scans[accuracy.scan[found[0]]]
        if len(found := np.flatnonzero(right & (accuracy.obstacle == index)))
        else None
        for index in numbers
    ]
    entered = _came_into_view(flight, [scan.stamp if scan else math.inf for scan in firsts])
    return tuple(_detection(flight, index, entered[index], firsts[index]) for index in numbers)


def slowest_detection(flight: TrialFlight) -> float:
    """Return the longest delay of a lidar that meets its specification [s].

    A scan comes within a period. Its reader checks for it once every control period.
    """
    return flight.period + flight.latency + flight.control_period


def _detection(flight: TrialFlight, index: int, entered: float, first: Scan | None) -> Detection:
    """Return the record of one obstacle; `first` is the first scan that contains it."""
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

    An obstacle in view for less than a scan period at the end of the flight does not count, as no
    scan needs to fall into that time.

    Args:
        flight: the flight.
        stamps: of the first scan that contains each obstacle [s].
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
    """Return whether a ray of the lidar hits an obstacle first, and within range."""
    lidar, d_S = flight.lidar, flight.directions
    length = flight.obstacles[index].first(time, X_WS, d_S, lidar.max_range)
    some = np.flatnonzero((length >= lidar.min_range) & (length <= lidar.max_range))
    free, length = d_S[some], length[some]
    for number, other in enumerate(flight.obstacles):
        if number != index and len(free):
            open_way = other.first(time, X_WS, free, lidar.max_range) >= length
            free, length = free[open_way], length[open_way]
    return len(free) > 0
