"""The linear model of an estimator at an operating point, with its settled gain.

Sensors measure at their own rates, and between their samples the estimator uses the IMU. The linear
model of one control period treats each sensor as measuring at every update, with a weight reduced
by the ratio of rates: the same information per time.
"""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from workbench.design.linear.model import MEASURED_SIGNALS, NOMINAL_ERRORS
from workbench.dynamics.rigid_body import cross, into_body, into_world, rotation
from workbench.estimation import ekf, ekf_measurements, ekf_propagation, ekf_state
from workbench.estimation.estimators import Estimator, checked_update
from workbench.estimation.samples import (
    BAROMETER,
    GPS,
    MAGNETOMETER,
    RANGE_FINDER,
    SAMPLE_ARRAY_SIZE,
    Mounting,
)
from workbench.estimation.settings import EKF
from workbench.plant.gravity import GRAVITY

COVARIANCE_DOUBLINGS = 16
"""The covariance is that after 2^16 control periods: 512 s at 128 Hz."""
DERIVATIVE_STEP = 1e-6
"""Difference of numbers for derivatives."""
MIN_DERIVATIVE = 1e-6
"""Derivatives below this are rounding errors: of positions of hundreds of metres, over that
difference."""
UPDATES_PER_CHECK = 128
"""Number of updates between checks whether a memory has settled."""
MEMORY_TOLERANCE = 1e-9
"""Relative deviation from a constant rate of change up to which it is settled."""
TRUE_MOTION_SIZE = 12
IMU_SAMPLE_SIZE = 6
GYRO_OUTPUT_SIZE = 3
"""Sizes of true motion, mean sample of the IMU, and output of the gyro's filters."""
SAMPLE_FLAGS = {
    "gps": GPS,
    "barometer": BAROMETER,
    "magnetometer": MAGNETOMETER,
    "range_finder": RANGE_FINDER,
}
"""Index of the flag of a sensor in samples, by its kind."""
SENSOR_ROWS = {
    "gps": slice(0, 6),
    "barometer": slice(6, 7),
    "magnetometer": slice(7, 8),
    "range_finder": slice(8, 9),
}
"""Rows of `ekf_state.innovations_of` that a sensor fills."""


@dataclass(frozen=True)
class EstimatorModel:
    """An update of an estimator, and its derivatives.

    Columns are the true motion (12), the mean sample of the IMU since the previous update (6), the
    filtered angular velocity (3), and the memory of the estimator (e); then, for noise, the
    measurements of the other sensors (9), see `MEASURED_SIGNALS`.

    Attributes:
        memory_by: rows of its memory after the update (e).
        seen_by: rows of the motion passed to the controller (12).
        names: of its memory, with units.
    """

    memory_by: np.ndarray
    seen_by: np.ndarray
    names: tuple[tuple[str, str], ...]


def estimator_model(
    estimator: Estimator,
    settings: np.ndarray,
    mounting: Mounting,
    duties: dict[str, float],
    period: float,
    state: np.ndarray,
    vdot_WB: np.ndarray,
) -> EstimatorModel:
    """Return the linear update of an estimator in a steady flight.

    Args:
        estimator: which one.
        settings: its live numbers, in order.
        mounting: of the sensors.
        duties: samples per update of each kind of sensor in use, at most 1.
        period: between updates [s].
        state: of the body (13); it does not turn.
        vdot_WB: acceleration in W (3) [m/s²].
    """
    places = mounting.packed()
    pull = (vdot_WB[0], vdot_WB[1], vdot_WB[2] + GRAVITY)
    force = np.array(into_body(rotation(state[0:4]), pull))
    imu = np.concatenate([np.zeros(3), force])
    if estimator.name == EKF:
        update, begin = _settled_ekf(settings, places, duties, period, state, imu)
    else:
        update, begin, state = _mean_update(
            estimator, settings, mounting, duties, period, state, imu
        )
    whose = f"{estimator.name}_" if estimator.file else ""  # else v_x would be ambiguous
    names = (*NOMINAL_ERRORS, *((whose + each.name, each.unit) for each in estimator.memory))

    def updated(errors: np.ndarray) -> np.ndarray:
        """Return memory and motion seen after an update, as differences from the steady flight."""
        sizes = np.cumsum([TRUE_MOTION_SIZE, IMU_SAMPLE_SIZE, GYRO_OUTPUT_SIZE, len(names)])
        motion, sample, rates, memory, noise = np.split(errors, sizes)
        true = _moved_body(state, motion)
        z = perfect_samples(true, imu + sample, places)
        _add_noise(z, noise, true, places)
        after = update(_memory_with_errors(begin, memory), z)
        seen = np.array(ekf.motion_estimate(after[: ekf_state.NOMINAL], rates, mounting.p_BI))
        seen[7:10] = into_world(rotation(seen[:4].tolist()), seen[7:10].tolist())
        return np.concatenate([_memory_errors(begin, after), _motion(state, seen)])

    size = (
        TRUE_MOTION_SIZE + IMU_SAMPLE_SIZE + GYRO_OUTPUT_SIZE + len(names) + len(MEASURED_SIGNALS)
    )
    columns = [
        (updated(DERIVATIVE_STEP * seed) - updated(-DERIVATIVE_STEP * seed))
        / (2.0 * DERIVATIVE_STEP)
        for seed in np.eye(size)
    ]
    by = np.array(columns).T
    acting = _affects_estimate(by, len(names))
    rows = np.concatenate([acting, np.full(TRUE_MOTION_SIZE, True)])
    columns_kept = np.full(size, True)
    columns_kept[TRUE_MOTION_SIZE + IMU_SAMPLE_SIZE + GYRO_OUTPUT_SIZE :][: len(names)] = acting
    by = by[np.ix_(rows, columns_kept)]
    names = tuple(name for name, acts in zip(names, acting, strict=True) if acts)
    return EstimatorModel(by[: len(names)], by[len(names) :], names)


def perfect_samples(state: np.ndarray, imu: np.ndarray, places: np.ndarray) -> np.ndarray:
    """Return the present samples of perfect sensors for a motion; see `estimation.samples`.

    Args:
        state: of the body (13).
        imu: mean angular velocity and specific force in B (6).
        places: see `samples.Mounting.packed`.
    """
    R = rotation(state[0:4].tolist())
    w_B = into_body(R, state[7:10].tolist())
    z = np.zeros(SAMPLE_ARRAY_SIZE)
    z[:6] = imu
    z[[GPS, BAROMETER, MAGNETOMETER, RANGE_FINDER]] = 1.0
    z[GPS + 2 : GPS + 5] = state[4:7] + into_world(R, places[3:6])
    z[GPS + 5 : GPS + 8] = state[10:13] + into_world(R, cross(w_B, places[3:6]))
    z[BAROMETER + 1] = state[6] + into_world(R, places[6:9])[2]
    z[MAGNETOMETER + 1 : MAGNETOMETER + 4] = into_body(R, places[15:18])
    down = -into_world(R, places[12:15])[2]
    z[RANGE_FINDER] = float(down > ekf_measurements.MIN_BEAM_COSINE)
    z[RANGE_FINDER + 1] = (state[6] + into_world(R, places[9:12])[2]) / max(
        down, ekf_measurements.MIN_BEAM_COSINE
    )
    return z


def _add_noise(z: np.ndarray, noise: np.ndarray, state: np.ndarray, places: np.ndarray) -> None:
    """Add noise (9) to measurements, see `MEASURED_SIGNALS`."""
    z[GPS + 2 : GPS + 8] += noise[:6]
    z[BAROMETER + 1] += noise[6]
    m_x, m_y, _ = places[15:18]
    turned = (-m_y * noise[7], m_x * noise[7], 0.0)
    z[MAGNETOMETER + 1 : MAGNETOMETER + 4] += into_body(rotation(state[0:4].tolist()), turned)
    z[RANGE_FINDER + 1] += noise[8]


def settled_gain(
    settings: np.ndarray,
    places: np.ndarray,
    duties: dict[str, float],
    period: float,
    x: np.ndarray,
    z: np.ndarray,
) -> tuple[np.ndarray, np.ndarray]:
    """Return gain K (15, 10) and covariance P before an update (15, 15) of a settled EKF.

    P is the 2^k-th step from 0 of the Riccati recursion, by the structure-preserving doubling
    algorithm: E. Chu, H. Fan, W. Lin and C. Wang, Structure-preserving algorithms for periodic
    discrete-time algebraic Riccati equations, International Journal of Control 77(8), 2004. So
    unobservable states, such as the heading without a magnetometer, cause no failure: their
    covariance has grown.

    Args:
        settings: see `settings.EkfSettings`.
        places: see `samples.Mounting.packed`.
        duties: see `estimator_model`.
        period: between updates [s].
        x: nominal state (16).
        z: perfect samples in the steady flight.
    """
    F, Q = (
        ekf_propagation.transition(x, z[:6], period),
        ekf_propagation.process_noise(settings, period),
    )
    H, gaps = ekf_measurements.measurement_rows(x, z, places, settings)
    information = np.zeros(ekf_state.MEASUREMENT_CHANNELS)
    for kind, duty in duties.items():
        variance = gaps[SENSOR_ROWS[kind], 1]
        information[SENSOR_ROWS[kind]] = np.where(variance > 0.0, duty / variance, 0.0)
    information = np.nan_to_num(information)
    A, G, P = F.T, H.T @ (information[:, None] * H), Q
    for _ in range(COVARIANCE_DOUBLINGS):
        W = np.linalg.solve(np.eye(ekf_state.ERRORS) + G @ P, np.hstack([A, G]))
        WA, WG = W[:, : ekf_state.ERRORS], W[:, ekf_state.ERRORS :]
        A, G, P = A @ WA, G + A @ WG @ A.T, P + A.T @ P @ WA
        P = 0.5 * (P + P.T)
    after = np.linalg.solve(np.eye(ekf_state.ERRORS) + P @ (H.T @ (information[:, None] * H)), P)
    return after @ H.T * information, P


EstimatorUpdate = Callable[[np.ndarray, np.ndarray], np.ndarray]


def _settled_ekf(
    settings: np.ndarray,
    places: np.ndarray,
    duties: dict[str, float],
    period: float,
    state: np.ndarray,
    imu: np.ndarray,
) -> tuple[EstimatorUpdate, np.ndarray]:
    """Return an update with the settled gain, and the nominal state in the steady flight."""
    begin = ekf.initial_ekf(state, places[0:3], ekf.InitialDeviations())[: ekf_state.NOMINAL]
    K, _ = settled_gain(
        settings, places, duties, period, begin, perfect_samples(state, imu, places)
    )

    def update(x: np.ndarray, z: np.ndarray) -> np.ndarray:
        before = np.array(ekf_propagation.propagated(x, z[:6], period))
        _, gaps = ekf_measurements.measurement_rows(before, z, places, settings)
        return np.array(ekf_propagation.corrected(before, K @ np.nan_to_num(gaps[:, 0])))

    # it advances by a period in an update; the initial one is that at the previous update
    back = np.array(begin)
    back[4:7] -= period * state[10:13]
    return update, back


def _mean_update(
    estimator: Estimator,
    settings: np.ndarray,
    mounting: Mounting,
    duties: dict[str, float],
    period: float,
    state: np.ndarray,
    imu: np.ndarray,
) -> tuple[EstimatorUpdate, np.ndarray, np.ndarray]:
    """Return the mean of updates with and without each sample, a settled memory, and the state.

    The memory is that one period before the state, which has advanced from the given one.
    """
    run, places = checked_update(estimator), mounting.packed()

    def one(memory: np.ndarray, z: np.ndarray) -> np.ndarray:
        after = memory.copy()
        run(after, z, settings, places, period)
        return after

    def update(memory: np.ndarray, z: np.ndarray) -> np.ndarray:
        none = z.copy()
        none[list(SAMPLE_FLAGS.values())] = 0.0
        without = one(memory, none)
        found = without.copy()
        for kind, duty in duties.items():
            some = none.copy()
            some[SAMPLE_FLAGS[kind]] = z[SAMPLE_FLAGS[kind]]
            found += duty * (one(memory, some) - without)
        return found

    motion = np.concatenate([np.zeros(3), period * state[10:13], np.zeros(6)])
    memory = estimator.begin(state, mounting, np.zeros(ekf_state.ERRORS), ekf.InitialDeviations())
    grown = np.full(memory.size, np.inf)
    for _ in range(2**COVARIANCE_DOUBLINGS // UPDATES_PER_CHECK):
        before, last = memory, grown
        for _ in range(UPDATES_PER_CHECK):
            state = _moved_body(state, motion)
            memory = update(memory, perfect_samples(state, imu, places))
        grown = memory - before
        # a position or a clock advances evenly, and nothing depends on it
        if np.all(np.abs(grown - last) <= 1e-15 + MEMORY_TOLERANCE * np.abs(memory)):
            break
    return update, memory, _moved_body(state, motion)


def _affects_estimate(by: np.ndarray, count: int) -> np.ndarray:
    """Return whether each number in the memory affects the estimate and depends on sensors.

    A settled covariance, a clock or a flag does not. The nominal state always counts.

    Args:
        by: derivatives, see `EstimatorModel`, of memory and motion seen.
        count: of numbers in the memory.
    """
    begin = TRUE_MOTION_SIZE + IMU_SAMPLE_SIZE + GYRO_OUTPUT_SIZE
    strong = np.abs(by) > MIN_DERIVATIVE
    among = strong[:count, begin : begin + count]
    others = np.delete(strong[:count], np.s_[begin : begin + count], axis=1)
    driven: np.ndarray = np.any(others, axis=1)
    read: np.ndarray = np.any(strong[count:, begin : begin + count], axis=0)
    driven[: ekf_state.ERRORS] = read[: ekf_state.ERRORS] = True
    for _ in range(count):
        driven = driven | np.any(among[:, driven], axis=1)
        read = read | np.any(among[read], axis=0)
    acting: np.ndarray = driven & read
    return acting


def _moved_body(state: np.ndarray, motion: np.ndarray) -> np.ndarray:
    """Return a state of the body (13) changed by angles in W, position and velocities."""
    moved = state.copy()
    R = rotation(state[:4].tolist())
    moved[:4] = ekf_propagation.turned_by(state[:4].tolist(), into_body(R, motion[:3].tolist()))
    moved[4:7] += motion[3:6]
    moved[7:] += motion[6:]
    return moved


def _motion(state: np.ndarray, other: np.ndarray) -> np.ndarray:
    """Return the difference of a state of the body from another (12), the inverse of
    `_moved_body`.
    """
    R = rotation(state[:4].tolist())
    angles = into_world(R, _small_rotation(state[:4], other[:4]))
    return np.concatenate([angles, other[4:] - state[4:]])


def _small_rotation(q: np.ndarray, other: np.ndarray) -> np.ndarray:
    """Return the small rotation in B from one attitude to another (3)."""
    w, x, y, z = q
    rows = np.array([[-x, w, z, -y], [-y, -z, w, x], [-z, y, -x, w]])
    turn: np.ndarray = 2.0 * rows @ other
    return turn


def _memory_with_errors(begin: np.ndarray, error: np.ndarray) -> np.ndarray:
    """Return a memory with errors added: of the nominal state (15), then of the rest."""
    found = begin.copy()
    found[: ekf_state.NOMINAL] = ekf_propagation.corrected(
        begin[: ekf_state.NOMINAL], error[: ekf_state.ERRORS]
    )
    found[-(len(error) - ekf_state.ERRORS) or len(found) :] += error[ekf_state.ERRORS :]
    return found


def _memory_errors(begin: np.ndarray, after: np.ndarray) -> np.ndarray:
    """Return the errors of a memory, the inverse of `_memory_with_errors`."""
    nominal = np.concatenate(
        [
            _small_rotation(begin[:4], after[:4]),
            after[4 : ekf_state.NOMINAL] - begin[4 : ekf_state.NOMINAL],
        ]
    )
    rest = after[ekf_state.NOMINAL :] - begin[ekf_state.NOMINAL :]
    return np.concatenate([nominal, rest])
