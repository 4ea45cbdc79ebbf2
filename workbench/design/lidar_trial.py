"""The lidar trial of the paper's section 5: accuracy, speed of detection, responsiveness."""

import copy
import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass

import numpy as np
from pydrake.geometry import Meshcat

from workbench.design.lidar_trial_accuracy import EXACT, Accuracy, judge, rounding
from workbench.design.lidar_trial_detection import Detection, detect, slowest_detection
from workbench.design.lidar_trial_flight import TrialFlight, fly_between
from workbench.plant.worlds.world import GROUND
from workbench.scenario.scenario import Scenario

LOOK_PERIOD = 1 / 32
"""Between two looks at the clearance [s]."""


@dataclass(frozen=True)
class Demand:
    """A number of the trial that must not be larger than a limit.

    Attributes:
        criterion: accuracy, detection, response or flight.
        quantity: its name.
        unit: of value and limit.
        value: the measured one.
        limit: largest that will do.
    """

    criterion: str
    quantity: str
    unit: str
    value: float
    limit: float

    @property
    def met(self) -> bool:
        """Whether it is as demanded; a NaN never is."""
        return self.value <= self.limit


@dataclass(frozen=True)
class Clearance:
    """How near the flight came to an obstacle other than the ground.

    Attributes:
        distance: smallest from the base link's origin [m]; inf without obstacles.
        obstacle: to which.
        time: when [s].
    """

    distance: float
    obstacle: str
    time: float


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


@dataclass(frozen=True)
class TrialReport:
    """What a lidar trial found.

    Attributes:
        flight: with noise as the description has it.
        accuracy: of this flight.
        exact: the accuracy of the same flight without noise: what is not noise.
        detections: how soon each obstacle was found.
        response: how promptly scans were delivered.
        clearance: how near the flight came to anything.
    """

    flight: TrialFlight
    accuracy: Accuracy
    exact: Accuracy
    detections: tuple[Detection, ...]
    response: Response
    clearance: Clearance

    @property
    def reach(self) -> float:
        """How far the drone reached into an obstacle, 0 if it touched none [m]."""
        return max(0.0, 0.5 * self.flight.recording.vehicle.span - self.clearance.distance)

    @property
    def demands(self) -> list[Demand]:
        """Return everything that is demanded."""
        return [*self._accuracy_demands(), *self._time_demands()]

    def _accuracy_demands(self) -> list[Demand]:
        """Errors as far as the declared noise explains them, and every ray right."""
        noise, total = self.flight.lidar.noise, self.accuracy.total
        least = EXACT + rounding(self.flight.lidar)
        # Five deviations of a mean of n samples; a bias drawn once does not average out.
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
                EXACT,
            ),
        ]

    def _time_demands(self) -> list[Demand]:
        """Everything found in time, every scan in time, and nothing touched."""
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

    Sensors do not change a flight, so both are the same but for the noise.

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
    """Return what two flights come to.

    Args:
        noisy: with noise as described.
        quiet: the same without.
    """
    accuracy = judge(noisy)
    return TrialReport(
        flight=noisy,
        accuracy=accuracy,
        exact=judge(quiet),
        detections=detect(noisy, accuracy),
        response=respond(noisy),
        clearance=_clearance(noisy),
    )


def _clearance(flight: TrialFlight) -> Clearance:
    """Return the nearest that the flight came to an obstacle."""
    record = flight.recording
    step = max(1, round(LOOK_PERIOD / float(record.time[1] - record.time[0])))
    nearest = Clearance(math.inf, "", math.nan)
    for obstacle in flight.obstacles:
        if obstacle.name == GROUND:
            continue
        times = record.time[::step].tolist()
        away = [
            obstacle.distance(time, p_WB)
            for time, p_WB in zip(times, record.p_WB[::step], strict=True)
        ]
        index = int(np.argmin(away))
        if away[index] < nearest.distance:
            nearest = Clearance(away[index], obstacle.name, times[index])
    return nearest


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
