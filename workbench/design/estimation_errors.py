"""Errors of an estimate against the truth, and their consistency with its covariance."""

import math
from dataclasses import dataclass, field

import numpy as np
from scipy.spatial.transform import Rotation, Slerp
from scipy.stats import chi2

from workbench.common.series import interpolated_on_grid
from workbench.common.vectors import Numbers
from workbench.estimation import ekf_state
from workbench.estimation.estimators import COVARIANCE_TRIANGLE
from workbench.estimation.run import EstimateHistory
from workbench.session.recording import Recording

NEES_STATES = 9
"""Number of errors in NEES: attitude, position and velocity."""
CONSISTENT_SHARE = 0.95
"""Share of the samples of a consistent estimator that lie within the bounds."""
CONSISTENT_SHARE_TOLERANCE = 0.05
"""Share below that which is tolerated: neighbouring samples are not independent."""
_ERROR_ROWS = (
    ("attitude_B", ("roll", "pitch", "yaw"), "rad"),
    ("position", ("x", "y", "z"), "m"),
    ("velocity", ("v_x", "v_y", "v_z"), "m/s"),
    ("angular_velocity", ("w_x", "w_y", "w_z"), "rad/s"),
)
_MATRICES_PER_BATCH = 4096
"""Number of matrices inverted together."""


@dataclass(frozen=True)
class EstimateOverTruth(EstimateHistory):
    """An estimate computed from a past flight, with the true motion.

    Attributes:
        q_WB: (N, 4) true orientation.
        p_WB: (N, 3) true position [m].
        w_WB: (N, 3) true angular velocity in W [rad/s].
        v_WB: (N, 3) true velocity in W [m/s].
        p_BI: place of the IMU in B (3) [m].
        charge: (0), as a log has no estimate of the charge; the same holds for the next one.
    """

    q_WB: np.ndarray
    p_WB: np.ndarray
    w_WB: np.ndarray
    v_WB: np.ndarray
    p_BI: np.ndarray
    estimated: bool = True
    charge: np.ndarray = field(default_factory=lambda: np.empty(0))
    known_charge: np.ndarray = field(default_factory=lambda: np.empty(0))


Estimated = Recording | EstimateOverTruth
"""A motion and its estimate over time."""


def over_truth(
    history: EstimateHistory, state_time: np.ndarray, states: np.ndarray, p_BI: Numbers
) -> EstimateOverTruth:
    """Return a history with the true motion, for the times where that is known.

    Args:
        history: of an estimator.
        state_time: of the true motion (M) [s]; between its states it is interpolated.
        states: q_WB, p_WB, w_WB_W, v_WB_W (M, 13).
        p_BI: place of the IMU in B (3) [m].
    """
    known = history.only((history.time >= state_time[0]) & (history.time <= state_time[-1]))
    time = known.time
    q_WB = np.tile(states[0, 0:4], (len(time), 1))
    if len(state_time) > 1:
        q_WB = Slerp(state_time, _quaternion_rotations(states[:, 0:4]))(time).as_quat()[
            :, [3, 0, 1, 2]
        ]
    motion = interpolated_on_grid(state_time, states[:, 4:], time)
    return EstimateOverTruth(
        **vars(known),
        q_WB=q_WB,
        p_WB=motion[:, 0:3],
        w_WB=motion[:, 3:6],
        v_WB=motion[:, 6:9],
        p_BI=np.array(p_BI),
    )


@dataclass(frozen=True)
class EstimateErrors:
    """Errors of an estimate over time: the true motion less the estimated one, of the base origin.

    Attributes:
        time: (N) [s].
        attitude_B: (N, 3) rotation vector d in the estimated body frame, R_true = R exp(d) [rad];
            its components are named roll, pitch and yaw. Differences of the angles themselves are
            meaningless near a pitch of 90 deg.
        position: (N, 3) in W [m].
        velocity: (N, 3) in W [m/s].
        angular_velocity: (N, 3) in W [rad/s].
    """

    time: np.ndarray
    attitude_B: np.ndarray
    position: np.ndarray
    velocity: np.ndarray
    angular_velocity: np.ndarray


@dataclass(frozen=True)
class StateError:
    """Root mean square and largest size of one state's error, in its unit."""

    name: str
    unit: str
    rms: float
    worst: float


@dataclass(frozen=True)
class Nees:
    """Normalised estimation error squared (NEES), e' P^-1 e, of attitude, position and velocity.

    For a consistent estimator it has a chi-square distribution with as many degrees of freedom as
    there are states, so its mean is the number of states. Neighbouring samples are not independent,
    so the bounds are those of a single sample, not of the mean.

    Attributes:
        states: their number.
        mean: over the flight.
        lower: bound of the middle 95 %.
        upper: likewise.
        within: share of the samples between the bounds, 0 .. 1.
    """

    states: int
    mean: float
    lower: float
    upper: float
    within: float


@dataclass(frozen=True)
class Innovations:
    """The innovations of one measured channel.

    Attributes:
        channel: its name, see `MEASUREMENT_NAMES`.
        count: number of innovations.
        within: share of NIS, the innovation squared over its variance, within the bounds that hold
            95 % for a consistent estimator, 0 .. 1.
        scale: root of its mean, 1 for a consistent estimator.
        setting: parameter with the standard deviation that the estimator assumes.
    """

    channel: str
    count: int
    within: float
    scale: float
    setting: str

    @property
    def surprises(self) -> bool:
        """Whether measurements are further from the estimate than it assumes, beyond chance."""
        return self.within < CONSISTENT_SHARE - CONSISTENT_SHARE_TOLERANCE - 3.0 * math.sqrt(
            CONSISTENT_SHARE * (1 - CONSISTENT_SHARE) / self.count
        )


@dataclass(frozen=True)
class EstimateReport:
    """The judgement of an estimate.

    Attributes:
        states: RMS and worst of every state.
        nees: None if the estimator has no covariance.
        innovations: of each channel that measured; empty if the estimator has none.
    """

    states: tuple[StateError, ...]
    nees: Nees | None
    innovations: tuple[Innovations, ...]


def estimate_errors(recording: Estimated) -> EstimateErrors | None:
    """Return the errors of the estimate; None if the controller knew the true motion."""
    estimate = recording.estimate
    if not recording.estimated:
        return None
    return EstimateErrors(
        time=recording.time,
        attitude_B=(
            _quaternion_rotations(estimate[:, 0:4]).inv() * _quaternion_rotations(recording.q_WB)
        ).as_rotvec(),
        position=recording.p_WB - estimate[:, 4:7],
        velocity=recording.v_WB - estimate[:, 10:13],
        angular_velocity=recording.w_WB - estimate[:, 7:10],
    )


def nees(recording: Estimated) -> np.ndarray | None:
    """Return e' P^-1 e over time (N), see `Nees`; None if there is no covariance.

    The full covariance is used, with correlations: standard deviations alone would count twice an
    error that tilt and velocity share. Position and velocity are those of the IMU, in the
    covariance and in the errors.
    """
    errors, triangle = estimate_errors(recording), recording.covariance
    if errors is None or not np.isfinite(triangle).any():
        return None
    p_BI = recording.p_BI
    arm = _quaternion_rotations(recording.q_WB).apply(p_BI)
    known_arm = _quaternion_rotations(recording.estimate[:, 0:4]).apply(p_BI)
    swing = np.cross(recording.w_WB, arm)
    known_swing = np.cross(recording.estimate[:, 7:10], known_arm)
    e = np.hstack(
        [
            errors.attitude_B,
            errors.position + arm - known_arm,
            errors.velocity + swing - known_swing,
        ]
    )
    found = np.full(len(e), np.nan)
    good = np.flatnonzero(np.isfinite(triangle).all(axis=1) & np.isfinite(e).all(axis=1))
    rows, columns = COVARIANCE_TRIANGLE
    for begin in range(0, len(good), _MATRICES_PER_BATCH):
        part = good[begin : begin + _MATRICES_PER_BATCH]
        P = np.zeros((len(part), NEES_STATES, NEES_STATES))
        P[:, rows, columns] = triangle[part]
        P[:, columns, rows] = triangle[part]
        found[part] = np.einsum("ni,nij,nj->n", e[part], np.linalg.pinv(P, hermitian=True), e[part])
    return found


def judge_estimate(recording: Estimated) -> EstimateReport | None:
    """Return the judgement of the estimate; None if the controller knew the true motion."""
    errors = estimate_errors(recording)
    if errors is None:
        return None
    states = [
        _state_error(name, unit, each)
        for quantity, names, unit in _ERROR_ROWS
        for name, each in zip(names, getattr(errors, quantity).T, strict=True)
    ]
    if recording.known_charge.size:
        off = recording.charge - recording.known_charge[:, 0]
        states.append(_state_error("charge", "1", off))
    return EstimateReport(tuple(states), _judged_nees(recording), _channel_innovations(recording))


def _state_error(name: str, unit: str, errors: np.ndarray) -> StateError:
    return StateError(name, unit, float(np.sqrt(np.mean(errors**2))), float(np.abs(errors).max()))


def _judged_nees(recording: Estimated) -> Nees | None:
    values = nees(recording)
    if values is None:
        return None
    values = values[np.isfinite(values)]
    lower, upper = map(float, chi2.interval(CONSISTENT_SHARE, NEES_STATES))
    within = (lower <= values) & (values <= upper)
    return Nees(NEES_STATES, float(values.mean()), lower, upper, float(within.mean()))


def _channel_innovations(recording: Estimated) -> tuple[Innovations, ...]:
    """Return the innovations of each channel that measured at a recorded time."""
    found = []
    for channel, name in enumerate(ekf_state.MEASUREMENT_NAMES):
        gaps, variances = recording.innovations[:, 2 * channel : 2 * channel + 2].T
        new = np.isfinite(gaps) & np.isfinite(variances)
        if new.any():
            squared = gaps[new] ** 2 / variances[new]
            within = float((squared <= chi2.ppf(CONSISTENT_SHARE, 1)).mean())
            scale, setting = float(np.sqrt(squared.mean())), ekf_state.MEASUREMENT_SETTINGS[channel]
            found.append(Innovations(name, int(new.sum()), within, scale, setting))
    return tuple(found)


def _quaternion_rotations(q: np.ndarray) -> Rotation:
    """Return rotations of quaternions w, x, y, z (N, 4)."""
    return Rotation.from_quat(q[:, [1, 2, 3, 0]])
