"""Accuracy of a lidar: every ray of every scan against closed form."""

from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np
from pydrake.math import RigidTransform

from workbench.design.lidar_trial_flight import Scan, TrialFlight
from workbench.design.lidar_trial_world import Hits, first_hits
from workbench.plant.sensors import Lidar

EXACT = 1e-3
"""A lidar without noise measures to this [m]; so near to an edge a ray may pass on either side."""
DEVIATIONS = 6.0
"""Noise may reach so many standard deviations; of a normal one, one in 500 million goes beyond."""
JUMP = 0.1
"""Where the next ray's length differs by more, there is an edge [m]."""


@dataclass(frozen=True)
class JudgedScan:
    """A scan beside closed form at its stamp, from where the recording says that the lidar was.

    Attributes:
        scan: what was delivered.
        error: (n) measured less true length, of every return that has a true one [m].
        length: (n) the true lengths [m].
        obstacle: (n) what they lead to, as a number among the flight's obstacles.
        p_WP: (n, 3) the measured points, by the scan's own pose [m].
        missed: obstacles of rays that must return and do not, one a ray.
        false: rays that return from where nothing is.
        at_edges: rays that an edge within `EXACT` of them explains; they are not judged.
        seen: obstacles from which anything returned as it should.
        due: obstacles from which anything must return.
        displacement: of a point at the farthest range by the scan's own pose [m].
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
    due: frozenset[int]
    displacement: float


@dataclass(frozen=True)
class Errors:
    """What a set of errors comes to [m]; all NaN without returns."""

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
    """How well all scans of a flight measured.

    Attributes:
        total: over all returns.
        by_obstacle: likewise, in the order of the flight's obstacles.
        missed: rays that should have returned, by obstacle.
        false: rays that should not have.
        at_edges: rays that were not judged.
        displacement: largest of any scan [m].
        scans: each of them.
    """

    total: Errors
    by_obstacle: tuple[Errors, ...]
    missed: tuple[int, ...]
    false: int
    at_edges: int
    displacement: float
    scans: tuple[JudgedScan, ...]

    @property
    def error(self) -> np.ndarray:
        """Of all returns [m]."""
        return _all([scan.error for scan in self.scans])

    @property
    def length(self) -> np.ndarray:
        """True lengths of all returns [m]."""
        return _all([scan.length for scan in self.scans])

    @property
    def obstacle(self) -> np.ndarray:
        """What all returns come from, as a number among the flight's obstacles."""
        return _all([scan.obstacle for scan in self.scans])

    @property
    def p_WP(self) -> np.ndarray:
        """All measured points [m]."""
        return np.concatenate([np.zeros((0, 3)), *(scan.p_WP for scan in self.scans)])


def judge(flight: TrialFlight) -> Accuracy:
    """Judge every scan of a flight."""
    scans = tuple(judge_scan(flight, scan) for scan in flight.scans)
    error = _all([scan.error for scan in scans])
    obstacle = _all([scan.obstacle for scan in scans])
    missed = [index for scan in scans for index in scan.missed]
    numbers = range(len(flight.obstacles))
    return Accuracy(
        total=Errors.of(error),
        by_obstacle=tuple(Errors.of(error[obstacle == index]) for index in numbers),
        missed=tuple(missed.count(index) for index in numbers),
        false=sum(scan.false for scan in scans),
        at_edges=sum(scan.at_edges for scan in scans),
        displacement=max((scan.displacement for scan in scans), default=float("nan")),
        scans=scans,
    )


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
    returned = np.isfinite(measured)
    inside = (hits.length >= lidar.min_range) & (hits.length <= lidar.max_range)
    # Noise may take a length that is nearly out of range either way.
    surely = (hits.length >= lidar.min_range + allowed) & (hits.length <= lidar.max_range - allowed)
    nearly = (hits.length >= lidar.min_range - allowed) & (hits.length <= farthest)
    missed, false = surely & ~returned, returned & ~nearly
    error = _difference(measured, hits.length, returned & nearly)
    doubtful = np.flatnonzero(missed | false | (np.abs(error) > allowed))
    explained = doubtful[_at_edge(flight, scan, X_WS, hits, doubtful, allowed)]
    judged = np.ones(len(measured), dtype=bool)
    judged[explained] = False
    kept = returned & nearly & judged
    right = kept & (np.abs(error) <= allowed)
    return JudgedScan(
        scan=scan,
        error=error[kept],
        length=hits.length[kept],
        obstacle=hits.obstacle[kept],
        p_WP=scan.X_WS.multiply((measured[kept, None] * flight.directions[kept]).T).T,
        missed=tuple(hits.obstacle[missed & judged].tolist()),
        false=int(np.sum(false & judged)),
        at_edges=len(explained),
        seen=_obstacles(hits, right),
        due=_obstacles(hits, inside),
        displacement=_displacement(X_WS, scan.X_WS, lidar.max_range),
    )


def _at_edge(
    flight: TrialFlight,
    scan: Scan,
    X_WS: RigidTransform,
    hits: Hits,
    rays: np.ndarray,
    allowed: float,
) -> np.ndarray:
    """Return which of some rays (k) agree with a ray that passes `EXACT` beside them at an edge."""
    if not len(rays):
        return np.zeros(0, dtype=bool)
    measured, length = scan.ranges.ravel()[rays], hits.length[rays]
    at = np.where(np.isfinite(length), length, np.where(np.isfinite(measured), measured, 1.0))
    explained = np.zeros(len(rays), dtype=bool)
    d_S, farthest = flight.directions[rays], flight.lidar.max_range + allowed
    for aside in _across(d_S):
        tilted = d_S + (EXACT / at)[:, None] * aside
        tilted /= np.linalg.norm(tilted, axis=1, keepdims=True)
        beside = first_hits(flight.obstacles, scan.stamp, X_WS, tilted, farthest)
        there = np.isfinite(beside.length) & np.isfinite(length)
        gap = np.abs(_difference(beside.length, length, there))
        edge = (beside.obstacle != hits.obstacle[rays]) | (gap > JUMP)
        near = (beside.length >= flight.lidar.min_range) & (beside.length <= flight.lidar.max_range)
        both = near & np.isfinite(measured)
        apart = np.abs(_difference(measured, beside.length, both))
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


def _all(parts: list[np.ndarray]) -> np.ndarray:
    """Return arrays behind one another."""
    return np.concatenate(parts) if parts else np.zeros(0)


def _obstacles(hits: Hits, rays: np.ndarray) -> frozenset[int]:
    """Return what the chosen rays lead to."""
    return frozenset(np.unique(hits.obstacle[rays]).tolist())


def _displacement(X_WS: RigidTransform, claimed: RigidTransform, farthest: float) -> float:
    """Return how far a claimed pose moves a point at the farthest range, at most [m]."""
    apart = X_WS.inverse() @ claimed
    # sin(angle / 2) from the antisymmetric part is exact for small angles, as acos is not
    R = apart.rotation().matrix()
    turn = 0.5 * np.array([R[2, 1] - R[1, 2], R[0, 2] - R[2, 0], R[1, 0] - R[0, 1]])
    angle = np.arctan2(np.linalg.norm(turn), 0.5 * (np.trace(R) - 1.0))
    chord = 2.0 * np.sin(0.5 * angle)
    return float(np.linalg.norm(apart.translation()) + farthest * chord)
