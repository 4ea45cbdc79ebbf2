"""The lidar trial of the paper's section 5: accuracy, speed of detection, responsiveness."""

import copy
import math
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass
from functools import cached_property
from time import perf_counter

import numpy as np
from pydrake.common.eigen_geometry import Quaternion
from pydrake.geometry import Meshcat
from pydrake.math import RigidTransform, RotationMatrix

from workbench.common.errors import WorkbenchError
from workbench.design.obstacles import Obstacle, first_hits, world_obstacles
from workbench.diagram.sensor_choice import SensorChoice, choose_sensors
from workbench.plant.sensors import Lidar
from workbench.plant.vehicle import Vehicle
from workbench.plant.worlds.world import GROUND
from workbench.scenario.scenario import Scenario
from workbench.session.recording import Recording
from workbench.session.session import Session
from workbench.systems.sensors.readings import LidarScan

LOOK_PERIOD = 1 / 32
"""Between two looks at the clearance [s]."""
EXACT = 1e-3
"""A lidar without noise measures to this [m]; so near to an edge a ray may pass on either side."""
DEVIATIONS = 6.0
"""Right noise lies within this many standard deviations: all but one in 500 million samples do."""
JUMP = 0.1
"""Where the next ray's length differs by more, there is an edge [m]."""


@dataclass(frozen=True, eq=False)
class Scan:
    """A scan as its reader got it.

    Attributes:
        stamp: when it was taken, as the scan states [s].
        delivered: when it could first be read, at the control rate [s].
        ranges: (layers, steps) [m]; what is not finite is no return.
        X_WS: pose of the lidar, as the scan states.
    """

    stamp: float
    delivered: float
    ranges: np.ndarray
    X_WS: RigidTransform


@dataclass(frozen=True)
class TrialFlight:
    """The flight that a lidar trial judges.

    Attributes:
        recording: with a sample at the stamp of every scan that is on time.
        lidar: as described; exact if the flight was without noise.
        asked_rate: scans a second that are asked for [1/s].
        period: between scans, in whole physics steps [s].
        latency: from a scan to its delivery, as asked for [s].
        control_period: at which scans are looked for [s].
        obstacles: what its rays can meet.
        scans: in the order of their delivery.
        computing_time: median wall clock time for a scan on this machine [s]; NaN if unknown.
    """

    recording: Recording
    lidar: Lidar
    asked_rate: float
    period: float
    latency: float
    control_period: float
    obstacles: tuple[Obstacle, ...]
    scans: tuple[Scan, ...]
    computing_time: float

    @cached_property
    def directions(self) -> np.ndarray:
        """Rays in the sensor's frame, layer by layer (layers · steps, 3)."""
        return ray_directions(self.lidar)

    @cached_property
    def X_BS(self) -> RigidTransform:
        """Return the lidar's mounting."""
        lidar = self.lidar
        return RigidTransform(RotationMatrix(np.array(lidar.R_BS)), np.array(lidar.p_BS))

    def X_WS(self, time: float) -> RigidTransform:
        """Return where the lidar was at a time [s]: exact where there is a sample.

        Between samples it goes straight and evenly; in the 6 ms of a usual trial that is off by
        5 µm for each m/s² of acceleration.
        """
        record = self.recording
        after = int(np.clip(np.searchsorted(record.time, time - 1e-9), 1, len(record.time) - 1))
        span = record.time[after] - record.time[after - 1]
        share = float(np.clip((time - record.time[after - 1]) / span, 0.0, 1.0))
        if share > 1.0 - 1e-6:
            share = 1.0
        p_WB = (1.0 - share) * record.p_WB[after - 1] + share * record.p_WB[after]
        one, other = record.q_WB[after - 1], record.q_WB[after]
        q_WB = (1.0 - share) * one + share * (other if one @ other > 0.0 else -other)
        X_WB = RigidTransform(Quaternion(q_WB / np.linalg.norm(q_WB)), p_WB)
        return X_WB @ self.X_BS


def ray_directions(lidar: Lidar) -> np.ndarray:
    """Return unit vectors in S, layer by layer from the lowest (layers · steps, 3).

    Azimuth turns from x towards y, elevation rises from the x-y plane towards z.
    """
    azimuth, elevation = (
        np.linspace(axis.min_angle, axis.max_angle, axis.samples)
        for axis in (lidar.horizontal, lidar.vertical)
    )
    up, around = np.meshgrid(elevation, azimuth, indexing="ij")
    return np.stack(
        [np.cos(up) * np.cos(around), np.cos(up) * np.sin(around), np.sin(up)], axis=-1
    ).reshape(-1, 3)


def fly_between(
    scenario: Scenario,
    settings: Mapping[str, float] | None = None,
    progress: Callable[[float], None] | None = None,
    meshcat: Meshcat | None = None,
) -> TrialFlight:
    """Fly a scenario with its vehicle's lidar, and look for a scan every control period.

    Args:
        scenario: what to fly; its lidar is switched on if it is not.
        settings: parameter values.
        progress: called with the flown share, 0 .. 1.
        meshcat: where to draw, if anywhere.

    Raises:
        WorkbenchError: if it cannot be flown, the vehicle has no lidar, or no scan was delivered.
    """
    scenario = copy.deepcopy(scenario)
    choice = _choose(Session(Scenario(vehicle=scenario.vehicle)).vehicle, scenario)
    scenario.rates.record_period = _record_period(scenario, choice.period)
    session = Session(scenario, settings, meshcat)
    control_period = scenario.rates.control_period
    scans: list[Scan] = []
    busy: list[float] = []
    slices = math.ceil(scenario.duration / control_period - 1e-9)
    for index in range(slices):
        begun = perf_counter()
        session.tick(min(control_period, scenario.duration - index * control_period))
        reading = session.reading(choice.sensor.name)
        busy.append(perf_counter() - begun)
        if isinstance(reading, LidarScan) and (not scans or reading.stamp != scans[-1].stamp):
            X_WS = RigidTransform(RotationMatrix(reading.R_WS), reading.p_WS)
            scans.append(Scan(reading.stamp, session.time, np.array(reading.ranges), X_WS))
        if progress:
            progress((index + 1) / slices)
    recording = session.recording()
    if not scans or len(recording.time) < 2:
        least = choice.period + choice.latency + control_period
        raise WorkbenchError(
            f"the flight of {session.time:.3g} s is too short to judge a scan: fly longer than "
            f"{least:.3g} s"
            if scans
            else f"no scan was delivered in the flight: with a period of {choice.period:.3g} s and "
            f"a latency of {choice.latency:g} s fly longer than {least:.3g} s, with a lidar "
            "that is not silent"
        )
    lidar = choice.sensor
    assert isinstance(lidar, Lidar)
    return TrialFlight(
        recording=recording,
        lidar=lidar,
        asked_rate=choice.asked_rate,
        period=choice.period,
        latency=choice.latency,
        control_period=control_period,
        obstacles=world_obstacles(session.world),
        scans=tuple(scans),
        computing_time=_computing_time(busy, scans, control_period),
    )


def _choose(vehicle: Vehicle, scenario: Scenario) -> SensorChoice:
    """Return the lidar to try: the first one in use, or else the first one, which then is."""
    lidars = [sensor for sensor in vehicle.sensors if isinstance(sensor, Lidar)]
    if not lidars:
        raise WorkbenchError(f"{vehicle.source}: there is no lidar in it to try: add one")
    for choice in choose_sensors(vehicle, scenario):
        if choice.sensor.kind == Lidar.kind:
            return choice
    scenario.sensors.use.append(lidars[0].name)
    return _choose(vehicle, scenario)


def _record_period(scenario: Scenario, scan_period: float) -> float:
    """Return a period for the recording that gives it a sample at every scan [s].

    It is the largest whole part of a scan period that is not longer than the scenario's.
    """
    step = scenario.rates.physics_step
    steps, most = round(scan_period / step), round(scenario.rates.record_period / step)
    return step * max(part for part in range(1, min(steps, most) + 1) if steps % part == 0)


def _computing_time(busy: list[float], scans: list[Scan], slice_time: float) -> float:
    """Return how much longer the slices of flight take in which a scan is taken [s]."""
    taken = {int(scan.stamp / slice_time + 1e-6) for scan in scans}
    with_scan = [spent for index, spent in enumerate(busy) if index in taken]
    without = [spent for index, spent in enumerate(busy) if index not in taken]
    if not with_scan or not without:
        return math.nan
    return float(np.median(with_scan) - np.median(without))


@dataclass(frozen=True)
class JudgedScan:
    """A scan compared with closed form, at its stamp and the recorded pose of the lidar.

    Attributes:
        scan: what was delivered.
        error: (n) measured less true length, of every return that has a true one [m].
        length: (n) the true lengths [m].
        obstacle: (n) index of the obstacle that each ray meets, in the flight's order.
        p_WP: (n, 3) the measured points, at the pose that the scan states [m].
        missed: for each ray that should return and does not, the index of its obstacle.
        false: number of rays that return where there is no obstacle.
        at_edges: number of rays that an edge within `EXACT` explains; they are not judged.
        seen: indices of the obstacles with at least one right return.
        displacement: of a point at the farthest range, by an error of the stated pose [m].
    """

    scan: Scan
    error: np.ndarray
    length: np.ndarray
    obstacle: np.ndarray
    p_WP: np.ndarray
    missed: tuple[int, ...]
    false: int
    at_edges: int
    seen: frozenset[int]
    displacement: float


@dataclass(frozen=True)
class Errors:
    """Statistics of a set of errors [m]; all NaN without returns."""

    returns: int
    bias: float
    rmse: float
    percentile_95: float
    maximum: float

    @classmethod
    def of(cls, error: np.ndarray) -> "Errors":
        """Return the figures of errors (n) [m]; 95th percentile and maximum are of their size."""
        if not len(error):
            return cls(0, *[float("nan")] * 4)
        size = np.abs(error)
        return cls(
            returns=len(error),
            bias=float(error.mean()),
            rmse=float(np.sqrt(np.mean(error**2))),
            percentile_95=float(np.percentile(size, 95.0)),
            maximum=float(size.max()),
        )


@dataclass(frozen=True)
class Accuracy:
    """Accuracy of all scans of a flight.

    Attributes:
        scans: each of them.
        obstacles: how many the flight has.
    """

    scans: tuple[JudgedScan, ...]
    obstacles: int

    @cached_property
    def error(self) -> np.ndarray:
        """Of all returns [m]."""
        return np.concatenate([np.zeros(0), *(scan.error for scan in self.scans)])

    @cached_property
    def length(self) -> np.ndarray:
        """True lengths of all returns [m]."""
        return np.concatenate([np.zeros(0), *(scan.length for scan in self.scans)])

    @cached_property
    def obstacle(self) -> np.ndarray:
        """Index of the obstacle of each return, in the flight's order."""
        return np.concatenate([np.zeros(0, dtype=int), *(scan.obstacle for scan in self.scans)])

    @cached_property
    def p_WP(self) -> np.ndarray:
        """All measured points [m]."""
        return np.concatenate([np.zeros((0, 3)), *(scan.p_WP for scan in self.scans)])

    @cached_property
    def total(self) -> Errors:
        """Over all returns."""
        return Errors.of(self.error)

    @cached_property
    def by_obstacle(self) -> tuple[Errors, ...]:
        """Over the returns of each obstacle, in the flight's order."""
        return tuple(
            Errors.of(self.error[self.obstacle == number]) for number in range(self.obstacles)
        )

    @cached_property
    def missed(self) -> tuple[int, ...]:
        """Rays that should have returned, by obstacle."""
        missed = [number for scan in self.scans for number in scan.missed]
        return tuple(missed.count(number) for number in range(self.obstacles))

    @property
    def false(self) -> int:
        """Rays that should not have returned."""
        return sum(scan.false for scan in self.scans)

    @property
    def at_edges(self) -> int:
        """Rays that were not judged."""
        return sum(scan.at_edges for scan in self.scans)

    @property
    def displacement(self) -> float:
        """Largest of any scan [m]."""
        return max((scan.displacement for scan in self.scans), default=math.nan)


def judge(flight: TrialFlight) -> Accuracy:
    """Judge every scan of a flight."""
    scans = tuple(judge_scan(flight, scan) for scan in flight.scans)
    return Accuracy(scans, len(flight.obstacles))


def rounding(lidar: Lidar) -> float:
    """Return how far a range is rounded at most [m]."""
    return 0.5 * (lidar.resolution or lidar.noise.precision)


def tolerance(lidar: Lidar) -> float:
    """Return how far a right range may lie from the true one [m]."""
    noise = lidar.noise
    spread = DEVIATIONS * (noise.stddev + noise.bias_stddev)
    return EXACT + rounding(lidar) + abs(noise.mean + noise.bias_mean) + spread


def judge_scan(flight: TrialFlight, scan: Scan) -> JudgedScan:
    """Judge one scan against closed form."""
    lidar, X_WS = flight.lidar, flight.X_WS(scan.stamp)
    allowed = tolerance(lidar)
    farthest = lidar.max_range + allowed
    measured = scan.ranges.ravel()
    hits = first_hits(flight.obstacles, scan.stamp, X_WS, flight.directions, farthest)
    length, obstacle = hits
    returned = np.isfinite(measured)
    # Noise may take a length that is nearly out of range either way.
    surely = (length >= lidar.min_range + allowed) & (length <= lidar.max_range - allowed)
    nearly = (length >= lidar.min_range - allowed) & (length <= farthest)
    missed, false = surely & ~returned, returned & ~nearly
    error = _difference(measured, length, returned & nearly)
    doubtful = np.flatnonzero(missed | false | (np.abs(error) > allowed))
    explained = doubtful[_at_edge(flight, scan, X_WS, hits, doubtful, allowed)]
    judged = np.ones(len(measured), dtype=bool)
    judged[explained] = False
    kept = returned & nearly & judged
    right = kept & (np.abs(error) <= allowed)
    return JudgedScan(
        scan=scan,
        error=error[kept],
        length=length[kept],
        obstacle=obstacle[kept],
        p_WP=scan.X_WS.multiply((measured[kept, None] * flight.directions[kept]).T).T,
        missed=tuple(obstacle[missed & judged].tolist()),
        false=int(np.sum(false & judged)),
        at_edges=len(explained),
        seen=frozenset(obstacle[right].tolist()),
        displacement=_displacement(X_WS, scan.X_WS, lidar.max_range),
    )


def _at_edge(
    flight: TrialFlight,
    scan: Scan,
    X_WS: RigidTransform,
    hits: tuple[np.ndarray, np.ndarray],
    rays: np.ndarray,
    allowed: float,
) -> np.ndarray:
    """Return which of some rays (k) agree with a ray that passes `EXACT` beside them at an edge."""
    if not len(rays):
        return np.zeros(0, dtype=bool)
    measured = scan.ranges.ravel()[rays]
    length, obstacle = (each[rays] for each in hits)
    at = np.where(np.isfinite(length), length, np.where(np.isfinite(measured), measured, 1.0))
    explained = np.zeros(len(rays), dtype=bool)
    d_S, farthest = flight.directions[rays], flight.lidar.max_range + allowed
    for aside in _across(d_S):
        tilted = d_S + (EXACT / at)[:, None] * aside
        tilted /= np.linalg.norm(tilted, axis=1, keepdims=True)
        length_beside, obstacle_beside = first_hits(
            flight.obstacles, scan.stamp, X_WS, tilted, farthest
        )
        there = np.isfinite(length_beside) & np.isfinite(length)
        gap = np.abs(_difference(length_beside, length, there))
        edge = (obstacle_beside != obstacle) | (gap > JUMP)
        near = (length_beside >= flight.lidar.min_range) & (length_beside <= flight.lidar.max_range)
        both = near & np.isfinite(measured)
        apart = np.abs(_difference(measured, length_beside, both))
        agrees = np.where(both, apart <= allowed, near == np.isfinite(measured))
        explained |= edge & agrees
    return explained


def _difference(one: np.ndarray, other: np.ndarray, where: np.ndarray) -> np.ndarray:
    """Return one less other where that is asked for, 0 elsewhere, where both may be infinite."""
    return np.subtract(one, other, out=np.zeros(len(one)), where=where)


def _across(d: np.ndarray) -> Iterable[np.ndarray]:
    """Return four unit vectors around each direction (n, 3), at right angles to it."""
    helper = np.where(np.abs(d[:, 2:]) < 0.9, [[0.0, 0.0, 1.0]], [[1.0, 0.0, 0.0]])
    one = np.cross(d, helper)
    one /= np.linalg.norm(one, axis=1, keepdims=True)
    other = np.cross(d, one)
    return one, -one, other, -other


def _displacement(X_WS: RigidTransform, claimed: RigidTransform, farthest: float) -> float:
    """Return how far a claimed pose moves a point at the farthest range, at most [m]."""
    apart = X_WS.inverse() @ claimed
    # sin(angle / 2) from the antisymmetric part is exact for small angles, as acos is not
    R = apart.rotation().matrix()
    turn = 0.5 * np.array([R[2, 1] - R[1, 2], R[0, 2] - R[2, 0], R[1, 0] - R[0, 1]])
    angle = np.arctan2(np.linalg.norm(turn), 0.5 * (np.trace(R) - 1.0))
    chord = 2.0 * np.sin(0.5 * angle)
    return float(np.linalg.norm(apart.translation()) + farthest * chord)


@dataclass(frozen=True)
class Detection:
    """How soon one obstacle was found; NaN where it never was.

    It comes into view when, in closed form, a ray meets it first and within range, and keeps doing
    so for a scan period or until a scan contains it: a scan must fall into that time. A ray that
    only grazes it between two scans does not count.

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

        The delay is infinite if it was in view and never returned.
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
        """Whether the demand is met; a NaN never meets it."""
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
