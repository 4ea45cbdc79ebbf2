"""Errors of the ranges of a lidar against the true distances."""

import math
from collections.abc import Iterable
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from pydrake.math import RigidTransform

from workbench.design.lidar_flight import Scan, TrialFlight
from workbench.design.obstacles import first_hits
from workbench.plant.sensors import Lidar

RANGE_TOLERANCE_M = 1e-3
"""Tolerance of a lidar without noise [m]; this near an edge, a ray may pass on either side."""
MAX_NOISE_SIGMAS = 6.0
"""Noise must lie within this many standard deviations, as all but one in 500 million samples do."""
EDGE_GAP_M = 0.1
"""Difference in length between neighbouring rays above which there is an edge [m]."""


@dataclass(frozen=True)
class RangeErrors:
    """Statistics of a set of errors [m]; all NaN without returns."""

    returns: int
    bias: float
    rmse: float
    percentile_95: float
    maximum: float

    @classmethod
    def of(cls, error: np.ndarray) -> "RangeErrors":
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
        at_edges: number of rays explained by an edge within `RANGE_TOLERANCE_M`; they are not
            judged.
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
    def total(self) -> RangeErrors:
        """Statistics over all returns."""
        return RangeErrors.of(self.error)

    @cached_property
    def by_obstacle(self) -> tuple[RangeErrors, ...]:
        """Statistics over the returns of each obstacle, in the flight's order."""
        return tuple(
            RangeErrors.of(self.error[self.obstacle == number])
            for number in range(len(self.missed))
        )


def range_rounding(lidar: Lidar) -> float:
    """Return the largest rounding error of a range [m]."""
    return 0.5 * (lidar.resolution or lidar.noise.precision)


def range_tolerance(lidar: Lidar) -> float:
    """Return the tolerance of a correct range [m]."""
    noise = lidar.noise
    spread = MAX_NOISE_SIGMAS * (noise.stddev + noise.bias_stddev)
    return RANGE_TOLERANCE_M + range_rounding(lidar) + abs(noise.mean + noise.bias_mean) + spread


def judge_scans(flight: TrialFlight) -> Accuracy:
    """Judge every scan of a flight against the closed form."""
    lidar, allowed = flight.lidar, range_tolerance(flight.lidar)
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
        error = _masked_difference(measured, length, returned & nearly)
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
    """Return which rays (k) agree with a ray that passes within `RANGE_TOLERANCE_M` of them at an
    edge.
    """
    if not len(rays):
        return np.zeros(0, dtype=bool)
    measured = scan.ranges.ravel()[rays]
    length, obstacle = (each[rays] for each in hits)
    at = np.where(np.isfinite(length), length, np.where(np.isfinite(measured), measured, 1.0))
    explained = np.zeros(len(rays), dtype=bool)
    d_S, farthest = flight.directions[rays], flight.lidar.max_range + allowed
    for aside in _across(d_S):
        tilted = d_S + (RANGE_TOLERANCE_M / at)[:, None] * aside
        tilted /= np.linalg.norm(tilted, axis=1, keepdims=True)
        length_beside, obstacle_beside = first_hits(
            flight.obstacles, scan.stamp, X_WS, tilted, farthest
        )
        there = np.isfinite(length_beside) & np.isfinite(length)
        gap = np.abs(_masked_difference(length_beside, length, there))
        edge = (obstacle_beside != obstacle) | (gap > EDGE_GAP_M)
        near = (length_beside >= flight.lidar.min_range) & (length_beside <= flight.lidar.max_range)
        both = near & np.isfinite(measured)
        apart = np.abs(_masked_difference(measured, length_beside, both))
        agrees = np.where(both, apart <= allowed, near == np.isfinite(measured))
        explained |= edge & agrees
    return explained


def _masked_difference(one: np.ndarray, other: np.ndarray, where: np.ndarray) -> np.ndarray:
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
