"""The lidar trial of the paper's section 5: accuracy, speed of detection, responsiveness."""

import copy
import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass

import numpy as np
from pydrake.geometry import Meshcat

from workbench.design.lidar_accuracy import RANGE_TOLERANCE_M, Accuracy, judge_scans, range_rounding
from workbench.design.lidar_flight import TrialFlight, fly_between
from workbench.design.metrics import Demand
from workbench.design.obstacle_detection import Detection, find_detections, slowest_detection
from workbench.plant.worlds.world import GROUND_NAME
from workbench.scenario.scenario import Scenario

CLEARANCE_PERIOD_S = 1 / 32
"""Period between checks of the clearance [s]."""


@dataclass(frozen=True)
class ObstacleClearance:
    """The smallest distance of the flight from an obstacle other than the ground.

    Attributes:
        distance: smallest from the base link's origin [m]; inf without obstacles.
        obstacle: the nearest one.
        time: when [s].
    """

    distance: float
    obstacle: str
    time: float


@dataclass(frozen=True)
class ScanTiming:
    """The punctuality of scans; all times are simulated.

    Attributes:
        expected: number of scans due before the end of the flight.
        delivered: number of scans delivered.
        late: number of scans older at delivery than a scan period plus the requested latency.
        lost: number of missing scans.
        median_age: from stamp to delivery [s].
        maximum_age: from stamp to delivery [s].
        rate: scans delivered per second between the first and the last [1/s].
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
        """Share of the expected scans that came in time, 0 .. 1."""
        return (self.delivered - self.late) / self.expected if self.expected else math.nan


@dataclass(frozen=True)
class TrialReport:
    """The results of a lidar trial.

    Attributes:
        flight: with noise as the description has it.
        accuracy: in this flight.
        exact: the accuracy in the same flight without noise, which shows all other errors.
        detections: of each obstacle.
        response: the punctuality of scans.
        clearance: from the nearest obstacle.
    """

    flight: TrialFlight
    accuracy: Accuracy
    exact: Accuracy
    detections: tuple[Detection, ...]
    response: ScanTiming
    clearance: ObstacleClearance

    @property
    def reach(self) -> float:
        """Depth of the drone's overlap with an obstacle, 0 if it touched none [m]."""
        return max(0.0, 0.5 * self.flight.recording.vehicle.span - self.clearance.distance)

    @property
    def demands(self) -> list[Demand]:
        """Return all demands."""
        return [*self._accuracy_demands(), *self._time_demands()]

    def _accuracy_demands(self) -> list[Demand]:
        """Return the demands on accuracy: no error beyond the declared noise, and no wrong ray."""
        noise, total = self.flight.lidar.noise, self.accuracy.total
        least = RANGE_TOLERANCE_M + range_rounding(self.flight.lidar)
        # Five standard deviations of a mean of n samples; a bias drawn once does not average out.
        offset = abs(noise.mean + noise.bias_mean) + 5.0 * noise.bias_stddev
        bias = offset + 5.0 * noise.stddev / math.sqrt(max(1, total.returns)) + least
        rmse = 1.02 * math.hypot(noise.stddev, offset) + least
        missed, false = (
            float(sum(self.accuracy.missed) + sum(self.exact.missed)),
            float(self.accuracy.false + self.exact.false),
        )
        return [
            Demand("accuracy", "bias", "m", abs(total.bias), bias),
            Demand("accuracy", "rmse", "m", total.rmse, rmse),
            Demand("accuracy", "error_without_noise", "m", self.exact.total.maximum, least),
            Demand("accuracy", "missed_returns", "", missed, 0.0),
            Demand("accuracy", "false_returns", "", false, 0.0),
            Demand(
                "accuracy",
                "displacement_by_pose",
                "m",
                max(self.accuracy.displacement, self.exact.displacement),
                RANGE_TOLERANCE_M,
            ),
        ]

    def _time_demands(self) -> list[Demand]:
        """Return the demands on detection, delivery in time, and no contact."""
        delays = [each.delay for each in self.detections if not math.isnan(each.delay)]
        flight, response = self.flight, self.response
        return [
            Demand(
                "detection",
                "slowest",
                "s",
                max(delays, default=math.nan),
                slowest_detection(flight),
            ),
            Demand(
                "response",
                "maximum_age",
                "s",
                response.maximum_age,
                flight.period + flight.latency,
            ),
            Demand("response", "late_scans", "", float(response.late), 0.0),
            Demand("response", "lost_scans", "", float(response.lost), 0.0),
            Demand("flight", "reach_into_obstacles", "m", self.reach, 0.0),
        ]


def fly_trial(
    scenario: Scenario,
    settings: Mapping[str, float] | None = None,
    progress: Callable[[float], None] | None = None,
    meshcat: Meshcat | None = None,
) -> TrialReport:
    """Fly a scenario twice, with the lidar's noise and without, and judge its lidar.

    Sensors do not affect a flight, so both differ only in the noise.

    Args:
        scenario: what to fly.
        settings: parameter values.
        progress: called with the flown share, 0 .. 1.
        meshcat: where to draw the first flight, if anywhere.

    Raises:
        WorkbenchError: if it cannot be flown, the vehicle has no lidar, or no scan was delivered.
    """

    def half(done: float) -> Callable[[float], None]:
        return lambda share: progress(done + 0.5 * share) if progress else None

    noisy = fly_between(scenario, settings, half(0.0), meshcat)
    silent = copy.deepcopy(scenario)
    silent.sensors.noise = False
    quiet = fly_between(silent, settings, half(0.5))
    return report_trial(noisy, quiet)


def report_trial(noisy: TrialFlight, quiet: TrialFlight) -> TrialReport:
    """Return the report on two flights.

    Args:
        noisy: with noise as described.
        quiet: the same flight without noise.
    """
    accuracy = judge_scans(noisy)
    return TrialReport(
        flight=noisy,
        accuracy=accuracy,
        exact=judge_scans(quiet),
        detections=find_detections(noisy, accuracy),
        response=scan_timing(noisy),
        clearance=_smallest_clearance(noisy),
    )


def _smallest_clearance(flight: TrialFlight) -> ObstacleClearance:
    """Return the smallest distance of the flight from an obstacle."""
    record = flight.recording
    step = max(1, round(CLEARANCE_PERIOD_S / float(record.time[1] - record.time[0])))
    nearest = ObstacleClearance(math.inf, "", math.nan)
    for obstacle in flight.obstacles:
        if obstacle.name == GROUND_NAME:
            continue
        times = record.time[::step].tolist()
        away = [
            obstacle.distance(time, p_WB)
            for time, p_WB in zip(times, record.p_WB[::step], strict=True)
        ]
        index = int(np.argmin(away))
        if away[index] < nearest.distance:
            nearest = ObstacleClearance(away[index], obstacle.name, times[index])
    return nearest


def scan_timing(flight: TrialFlight) -> ScanTiming:
    """Return the punctuality of the scans of a flight."""
    stamps = np.array([scan.stamp for scan in flight.scans])
    ages = np.array([scan.delivered - scan.stamp for scan in flight.scans])
    # A scan taken later than this before the end may not be delivered by then.
    under_way = flight.latency + flight.control_period
    last = float(flight.recording.time[-1]) - under_way
    lost = _missing_scans(stamps, flight.period, last)
    span = float(np.ptp(stamps)) if len(stamps) > 1 else math.nan
    return ScanTiming(
        expected=len(stamps) + lost,
        delivered=len(stamps),
        late=int(np.sum(ages > flight.period + flight.latency + 1e-9)),
        lost=lost,
        median_age=float(np.median(ages)) if len(ages) else math.nan,
        maximum_age=float(np.max(ages)) if len(ages) else math.nan,
        rate=(len(stamps) - 1) / span if len(stamps) > 1 else 0.0,
    )


def _missing_scans(stamps: np.ndarray, period: float, last: float) -> int:
    """Return the number of scans missing before, between and after those with stamps (n) [s].

    The first may be taken at any time of the first period, and the last up to `last` [s].
    """
    if not len(stamps):
        return int(last / period) + 1
    before = math.ceil(stamps[0] / period - 1e-6) - 1
    between = np.round(np.diff(stamps) / period).astype(int) - 1
    after = math.floor((last - stamps[-1]) / period + 1e-6)
    return max(0, before) + int(np.sum(np.maximum(between, 0))) + max(0, after)
