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
from workbench.design.metrics import Demand
from workbench.design.obstacles import Obstacle, first_hits, world_obstacles
from workbench.diagram.sensor_choice import SensorChoice, choose_sensors
from workbench.dynamics.motion_between import motions_between, point_motion
from workbench.plant.sensors import Lidar
from workbench.plant.vehicle import Vehicle
from workbench.plant.worlds.world import GROUND
from workbench.scenario.scenario import Scenario
from workbench.session.recording import Recording
from workbench.session.session import Session
from workbench.systems.sensors.readings import LidarScan

LOOK_PERIOD = 1 / 32
"""Period between checks of the clearance [s]."""
EXACT = 1e-3
"""Tolerance of a lidar without noise [m]; this near an edge, a ray may pass on either side."""
DEVIATIONS = 6.0
"""Noise must lie within this many standard deviations, as all but one in 500 million samples do."""
JUMP = 0.1
"""Difference in length between neighbouring rays above which there is an edge [m]."""


@dataclass(frozen=True, eq=False)
class Scan:
    """A scan as delivered to its reader.

    Attributes:
        stamp: when it was taken, as the scan states [s].
        delivered: when it could first be read, at the control rate [s].
        ranges: (layers, steps) [m]; not finite without a return.
        X_WS: pose of the lidar, as the scan states.
    """

    stamp: float
    delivered: float
    ranges: np.ndarray
    X_WS: RigidTransform


@dataclass(frozen=True)
class TrialFlight:
    """The flight judged by a lidar trial.

    Attributes:
        recording: has a sample at the stamp of every punctual scan.
        lidar: as described; without noise if the flight was.
        asked_rate: requested scans per second [1/s].
        period: between scans, in whole physics steps [s].
        latency: requested, from a scan to its delivery [s].
        control_period: period between checks for a new scan [s].
        obstacles: all that its rays can hit.
        scans: in the order of their delivery.
        computing_time: median wall-clock time per scan on this machine [s]; NaN if unknown.
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
        """Return the pose of the lidar at a time [s], see `motions_between`.

        Over the physics step between two samples of the recording, its error is below 1 µm.
        """
        record = self.recording
        after = int(np.clip(np.searchsorted(record.time, time), 1, len(record.time) - 1))
        near = 1.0 if record.q_WB[after - 1] @ record.q_WB[after] > 0.0 else -1.0
        before, now = (
            point_motion(
                [*sign * record.q_WB[k], *record.p_WB[k], *record.w_WB[k], *record.v_WB[k]],
                self.lidar.p_BS,
            )
            for k, sign in ((after - 1, near), (after, 1.0))
        )
        span = record.time[after] - record.time[after - 1]
        share = float(np.clip((time - record.time[after - 1]) / span, 0.0, 1.0))
        motion = motions_between(before, now, span, 1, share)[0, 0]
        R_WB = RotationMatrix(Quaternion(motion[:4] / np.linalg.norm(motion[:4])))
        return RigidTransform(R_WB, motion[4:7]) @ RigidTransform(self.X_BS.rotation())


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
    """Fly a scenario with the lidar of its vehicle, and check for a scan every control period.

    Args:
        scenario: what to fly; its lidar is switched on if necessary.
        settings: parameter values.
        progress: called with the flown share, 0 .. 1.
        meshcat: where to draw, if anywhere.

    Raises:
        WorkbenchError: if it cannot be flown, the vehicle has no lidar, or no scan was delivered.
    """
    scenario = copy.deepcopy(scenario)
    choice = _choose(Session(Scenario(vehicle=scenario.vehicle)).vehicle, scenario)
    rates = scenario.rates
    rates.record_period = rates.physics_step
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
    if not scans:
        least = choice.period + choice.latency + control_period
        raise WorkbenchError(
            f"no scan was delivered in the flight: with a period of {choice.period:.3g} s and "
            f"a latency of {choice.latency:g} s fly longer than {least:.3g} s, with a lidar that "
            "works"
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
    """Return the lidar to try: the first one in use, or else the first one, switched on."""
    lidars = [sensor for sensor in vehicle.sensors if isinstance(sensor, Lidar)]
    if not lidars:
        raise WorkbenchError(f"{vehicle.source}: it has no lidar: add one")
    for choice in choose_sensors(vehicle, scenario):
        if choice.sensor.kind == Lidar.kind:
            return choice
    scenario.sensors.use.append(lidars[0].name)
    return _choose(vehicle, scenario)


def _computing_time(busy: list[float], scans: list[Scan], slice_time: float) -> float:
    """Return the additional time that slices of flight with a scan take [s]."""
    taken = {int(scan.stamp / slice_time + 1e-6) for scan in scans}
    with_scan = [spent for index, spent in enumerate(busy) if index in taken]
    without = [spent for index, spent in enumerate(busy) if index not in taken]
    if not with_scan or not without:
        return math.nan
    return float(np.median(with_scan) - np.median(without))


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
        """Return the statistics of errors (n) [m]; 95th percentile and maximum are absolute."""
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


@dataclass(frozen=True, eq=False)
class Accuracy:
    """Scans compared with the closed form, each at its stamp and the recorded pose of the lidar.

    Attributes:
        error: (n) measured minus true length, of every return that has a true one [m].
        length: (n) the true lengths [m].
        obstacle: (n) index of the obstacle that each ray hits, in the flight's order.
        scan: (n) index of the scan of each return.
        p_WP: (n, 3) the measured points, at the pose that their scan states [m].
        missed: number of missing returns, by obstacle.
        false: number of returns without an obstacle.
        at_edges: number of rays explained by an edge within `EXACT`; they are not judged.
        displacement: largest one of a point at the farthest range, due to the error of a stated
            pose [m]; NaN without scans.
    """

    error: np.ndarray
    length: np.ndarray
    obstacle: np.ndarray
    scan: np.ndarray
    p_WP: np.ndarray
    missed: tuple[int, ...]
    false: int
    at_edges: int
    displacement: float

    @cached_property
    def total(self) -> Errors:
        """Statistics over all returns."""
        return Errors.of(self.error)

    @cached_property
    def by_obstacle(self) -> tuple[Errors, ...]:
        """Statistics over the returns of each obstacle, in the flight's order."""
        return tuple(
            Errors.of(self.error[self.obstacle == number]) for number in range(len(self.missed))
        )


def rounding(lidar: Lidar) -> float:
    """Return the largest rounding error of a range [m]."""
    return 0.5 * (lidar.resolution or lidar.noise.precision)


def tolerance(lidar: Lidar) -> float:
    """Return the tolerance of a correct range [m]."""
    noise = lidar.noise
    spread = DEVIATIONS * (noise.stddev + noise.bias_stddev)
    return EXACT + rounding(lidar) + abs(noise.mean + noise.bias_mean) + spread


def judge(flight: TrialFlight) -> Accuracy:
    """Judge every scan of a flight against the closed form."""
    lidar, allowed = flight.lidar, tolerance(flight.lidar)
    farthest = lidar.max_range + allowed
    returns = [(np.zeros(0), np.zeros(0), np.zeros(0, dtype=int), np.zeros(0, dtype=int))]
    points, missed = [np.zeros((0, 3))], np.zeros(len(flight.obstacles), dtype=int)
    false = at_edges = 0
    displaced = []
    for number, scan in enumerate(flight.scans):
        X_WS, measured = flight.X_WS(scan.stamp), scan.ranges.ravel()
        hits = first_hits(flight.obstacles, scan.stamp, X_WS, flight.directions, farthest)
        length, obstacle = hits
        returned = np.isfinite(measured)
        # Noise may move a length near the limit of range to either side.
        surely = (length >= lidar.min_range + allowed) & (length <= lidar.max_range - allowed)
        nearly = (length >= lidar.min_range - allowed) & (length <= farthest)
        lacking, beyond = surely & ~returned, returned & ~nearly
        error = _difference(measured, length, returned & nearly)
        doubtful = np.flatnonzero(lacking | beyond | (np.abs(error) > allowed))
        explained = doubtful[_at_edge(flight, scan, X_WS, hits, doubtful, allowed)]
        judged = np.ones(len(measured), dtype=bool)
        judged[explained] = False
        kept = returned & nearly & judged
        whose = np.full(len(error[kept]), number)
        returns.append((error[kept], length[kept], obstacle[kept], whose))
        points.append(scan.X_WS.multiply((measured[kept, None] * flight.directions[kept]).T).T)
        missed += np.bincount(obstacle[lacking & judged], minlength=len(missed))
        false += int(np.sum(beyond & judged))
        at_edges += len(explained)
        displaced.append(_displacement(X_WS, scan.X_WS, lidar.max_range))
    columns = (np.concatenate(column) for column in zip(*returns, strict=True))
    return Accuracy(
        *columns,
        p_WP=np.concatenate(points),
        missed=tuple(missed.tolist()),
        false=false,
        at_edges=at_edges,
        displacement=max(displaced, default=math.nan),
    )


def _at_edge(
    flight: TrialFlight,
    scan: Scan,
    X_WS: RigidTransform,
    hits: tuple[np.ndarray, np.ndarray],
    rays: np.ndarray,
    allowed: float,
) -> np.ndarray:
    """Return which rays (k) agree with a ray that passes within `EXACT` of them at an edge."""
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
    """Return the difference where requested and 0 elsewhere, where both may be infinite."""
    return np.subtract(one, other, out=np.zeros(len(one)), where=where)


def _across(d: np.ndarray) -> Iterable[np.ndarray]:
    """Return four unit vectors perpendicular to each direction (n, 3)."""
    helper = np.where(np.abs(d[:, 2:]) < 0.9, [[0.0, 0.0, 1.0]], [[1.0, 0.0, 0.0]])
    one = np.cross(d, helper)
    one /= np.linalg.norm(one, axis=1, keepdims=True)
    other = np.cross(d, one)
    return one, -one, other, -other


def _displacement(X_WS: RigidTransform, claimed: RigidTransform, farthest: float) -> float:
    """Return the largest displacement of a point at the farthest range by a stated pose [m]."""
    apart = X_WS.inverse() @ claimed
    # sin(angle / 2) from the antisymmetric part is exact for small angles, as acos is not
    R = apart.rotation().matrix()
    turn = 0.5 * np.array([R[2, 1] - R[1, 2], R[0, 2] - R[2, 0], R[1, 0] - R[0, 1]])
    angle = np.arctan2(np.linalg.norm(turn), 0.5 * (np.trace(R) - 1.0))
    chord = 2.0 * np.sin(0.5 * angle)
    return float(np.linalg.norm(apart.translation()) + farthest * chord)


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


def detect(flight: TrialFlight, accuracy: Accuracy) -> tuple[Detection, ...]:
    """Return the detection of each obstacle of a flight, in their order."""
    numbers = range(len(flight.obstacles))
    right = np.abs(accuracy.error) <= tolerance(flight.lidar)
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


@dataclass(frozen=True)
class Clearance:
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
class Response:
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
    response: Response
    clearance: Clearance

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
        least = EXACT + rounding(self.flight.lidar)
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
                EXACT,
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
    """Return the smallest distance of the flight from an obstacle."""
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
    """Return the punctuality of the scans of a flight."""
    stamps = np.array([scan.stamp for scan in flight.scans])
    ages = np.array([scan.delivered - scan.stamp for scan in flight.scans])
    # A scan taken later than this before the end may not be delivered by then.
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
    """Return the number of scans missing before, between and after those with stamps (n) [s].

    The first may be taken at any time of the first period, and the last up to `last` [s].
    """
    if not len(stamps):
        return int(last / period) + 1
    before = math.ceil(stamps[0] / period - 1e-6) - 1
    between = np.round(np.diff(stamps) / period).astype(int) - 1
    after = math.floor((last - stamps[-1]) / period + 1e-6)
    return max(0, before) + int(np.sum(np.maximum(between, 0))) + max(0, after)
