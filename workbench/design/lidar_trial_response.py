"""Responsiveness of a lidar: how old scans are when they are delivered, and whether all come."""

import math
from dataclasses import dataclass

import numpy as np

from workbench.design.lidar_trial_flight import TrialFlight


@dataclass(frozen=True)
class Response:
    """How promptly scans were delivered; all times are simulated.

    Attributes:
        expected: scans that were to be delivered before the flight's end.
        delivered: scans that were.
        late: those older than a scan period and the latency asked for when they were delivered.
        lost: those that were left out.
        median_age: from stamp to delivery [s].
        maximum_age: likewise [s].
        rate: scans delivered a second of the flight between the first and the last [1/s].
    """

    expected: int
    delivered: int
    late: int
    lost: int
    median_age: float
    maximum_age: float
    rate: float

    @property
    def share_on_time(self) -> float:
        """Of the scans that were to come, those that came in time, 0 .. 1."""
        return (self.delivered - self.late) / self.expected if self.expected else math.nan


def respond(flight: TrialFlight) -> Response:
    """Return how promptly the scans of a flight were delivered."""
    stamps = np.array([scan.stamp for scan in flight.scans])
    ages = np.array([scan.delivered - scan.stamp for scan in flight.scans])
    # What is taken less than this before the end may still be under way then.
    under_way = flight.latency + flight.control_period
    last = float(flight.recording.time[-1]) - under_way
    lost = _left_out(stamps, flight.period, last)
    span = float(np.ptp(stamps)) if len(stamps) > 1 else math.nan
    return Response(
        expected=len(stamps) + lost,
        delivered=len(stamps),
        late=int(np.sum(ages > flight.period + flight.latency + 1e-9)),
        lost=lost,
        median_age=float(np.median(ages)) if len(ages) else math.nan,
        maximum_age=float(np.max(ages)) if len(ages) else math.nan,
        rate=(len(stamps) - 1) / span if len(stamps) > 1 else 0.0,
    )


def _left_out(stamps: np.ndarray, period: float, last: float) -> int:
    """Return how many scans are missing before, between and after those with stamps (n) [s].

    The first may be taken at any time of the first period, and the last up to `last` [s].
    """
    if not len(stamps):
        return int(last / period) + 1
    before = math.ceil(stamps[0] / period - 1e-6) - 1
    between = np.round(np.diff(stamps) / period).astype(int) - 1
    after = math.floor((last - stamps[-1]) / period + 1e-6)
    return max(0, before) + int(np.sum(np.maximum(between, 0))) + max(0, after)
