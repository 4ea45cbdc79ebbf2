"""The estimators that a scenario can name."""

from collections.abc import Callable, Sequence
from functools import lru_cache
from typing import Any, NamedTuple

import numpy as np

from workbench.common.compiled import Compiled, compile_cached
from workbench.estimation import complementary, ekf
from workbench.estimation.ekf import InitialDeviations
from workbench.estimation.samples import Mounting
from workbench.estimation.settings import (
    COMPLEMENTARY,
    EKF,
    ComplementarySettings,
    EkfSettings,
    check_estimator,
)

SOURCES = ("estimation", "dynamics/rigid_body.py", "plant/gravity.py")
"""What the compiled updates stand in, below `workbench/`."""
TRIANGLE = np.triu_indices(9)
"""Rows and columns of a covariance's upper triangle (45), of attitude, place and velocity."""


class Estimator(NamedTuple):
    """An estimator as pure functions.

    The first 16 numbers of the memory are the nominal state, see `ekf`.

    Attributes:
        name: in scenarios.
        settings: its live numbers, a named tuple's type.
        update: one update of its memory in place, see `ekf.update`.
        begin: from a motion (13), the mounting, standard normal numbers (15) and what is known
            of the errors at the start to a memory.
        deviations: from a memory to the standard deviations of its errors (15), NaN where it
            does not know them; so the next two.
        covariance: of the errors of attitude, place and velocity, the upper triangle row by row
            (45).
        innovations: of each number that this update measured the innovation and its variance
            (20), see `ekf.CHANNELS`; NaN where there was none.
    """

    name: str
    settings: Any
    update: Callable[..., None]
    begin: Callable[[np.ndarray, Mounting, np.ndarray, InitialDeviations], np.ndarray]
    deviations: Callable[[np.ndarray], np.ndarray]
    covariance: Callable[[np.ndarray], np.ndarray]
    innovations: Callable[[np.ndarray], np.ndarray]


def _begin_ekf(
    state: np.ndarray, mounting: Mounting, drawn: np.ndarray, known: InitialDeviations
) -> np.ndarray:
    """Return the memory of a filter whose errors are as large as it takes them to be."""
    memory = ekf.initial(state, mounting.p_BI, known)
    errors = np.repeat(np.array(known), 3) * drawn
    errors[9:] = 0.0  # biases are what they are, and not known
    memory[: ekf.NOMINAL] = ekf.corrected(memory[: ekf.NOMINAL], errors)
    return memory


def _ekf_deviations(memory: np.ndarray) -> np.ndarray:
    P = memory[ekf.COVARIANCE : ekf.INNOVATIONS].reshape(ekf.ERRORS, ekf.ERRORS)
    found: np.ndarray = np.sqrt(np.maximum(np.diag(P), 0.0))
    return found


def _ekf_covariance(memory: np.ndarray) -> np.ndarray:
    P = memory[ekf.COVARIANCE : ekf.INNOVATIONS].reshape(ekf.ERRORS, ekf.ERRORS)
    found: np.ndarray = P[TRIANGLE]
    return found


def _ekf_innovations(memory: np.ndarray) -> np.ndarray:
    return memory[ekf.INNOVATIONS : ekf.SIZE]


def _begin_complementary(
    state: np.ndarray, mounting: Mounting, drawn: np.ndarray, known: InitialDeviations
) -> np.ndarray:
    return complementary.initial(state, mounting.p_BI)


def _no_deviations(memory: np.ndarray) -> np.ndarray:
    return np.full(ekf.ERRORS, np.nan)


def _no_covariance(memory: np.ndarray) -> np.ndarray:
    return np.full(len(TRIANGLE[0]), np.nan)


def _no_innovations(memory: np.ndarray) -> np.ndarray:
    return np.full(2 * ekf.CHANNELS, np.nan)


_KNOWN = (
    Estimator(
        COMPLEMENTARY,
        ComplementarySettings,
        complementary.update,
        _begin_complementary,
        _no_deviations,
        _no_covariance,
        _no_innovations,
    ),
    Estimator(
        EKF,
        EkfSettings,
        ekf.update,
        _begin_ekf,
        _ekf_deviations,
        _ekf_covariance,
        _ekf_innovations,
    ),
)


def find_estimator(name: str) -> Estimator | None:
    """Return the estimator of a name, None for the truth.

    Raises:
        WorkbenchError: if there is none of that name.
    """
    found = {each.name: each for each in _KNOWN}
    return found.get(check_estimator(name))


@lru_cache(maxsize=8)
def compiled_update(name: str) -> Compiled:
    """Return the update of an estimator, compiled at its first call."""
    estimator = find_estimator(name)
    assert estimator
    return compile_cached(estimator.update, SOURCES, f"the estimator {name}", parts=20)


def known_motion(memory: np.ndarray, rates: np.ndarray, p_BI: Sequence[float]) -> np.ndarray:
    """Return the motion of the base origin that a memory says (13).

    Args:
        memory: of an estimator.
        rates: angular velocity that the gyro shows, in B, first of it (3) [rad/s].
        p_BI: of the IMU (3) [m].

    Returns:
        q_WB, p_WB [m], w_WB_W [rad/s] and v_WB_W [m/s].
    """
    found = np.array(ekf.estimate(memory[: ekf.NOMINAL], rates, p_BI))
    R = ekf.rotation(found[:4].tolist())
    found[7:10] = ekf.into_world(R, found[7:10].tolist())
    return found
