"""The estimators that a scenario can name."""

from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np

from workbench.common.errors import unknown_name
from workbench.estimation import complementary, ekf
from workbench.estimation.samples import Mounting

TRUTH = "truth"
"""What a controller knows is the true motion."""
COMPLEMENTARY, EKF = "complementary", "ekf"
ESTIMATORS = (TRUTH, COMPLEMENTARY, EKF)
"""What a scenario may name."""
HEARD = ("gps", "barometer", "magnetometer", "range_finder")
"""Kinds of sensors that an estimator listens to, besides the IMU."""

_DECIDING = {"gps": slice(0, 2), "magnetometer": slice(7, 8)}
"""Numbers of an EKF's update that say whether it goes by a sample: east and north, heading."""


class Estimator(NamedTuple):
    """An estimator as pure functions.

    The first 16 numbers of the memory are the nominal state, see `ekf`.

    Attributes:
        name: in scenarios.
        settings: its live numbers, a named tuple's type.
        update: one update of its memory in place, see `ekf.update`.
        begin: from a motion (13), the mounting and standard normal numbers (15) to a memory.
        deviations: from a memory to the standard deviations of its errors (15), NaN where it
            does not know them.
        takes_in: whether it goes by the new sample of a kind of sensor that came with the update
            which left its memory; its settings come second.
    """

    name: str
    settings: Any
    update: Callable[..., None]
    begin: Callable[[np.ndarray, Mounting, np.ndarray], np.ndarray]
    deviations: Callable[[np.ndarray], np.ndarray]
    takes_in: Callable[[np.ndarray, np.ndarray, str], bool]


def _begin_ekf(state: np.ndarray, mounting: Mounting, drawn: np.ndarray) -> np.ndarray:
    """Return the memory of a filter whose errors are as large as it takes them to be."""
    known = ekf.InitialDeviations()
    memory = ekf.initial(state, mounting.p_BI, known)
    errors = np.repeat(np.array(known), 3) * drawn
    errors[9:] = 0.0  # biases are what they are, and not known
    memory[: ekf.NOMINAL] = ekf.corrected(memory[: ekf.NOMINAL], errors)
    return memory


def _ekf_deviations(memory: np.ndarray) -> np.ndarray:
    P = memory[ekf.COVARIANCE : ekf.INNOVATIONS].reshape(ekf.ERRORS, ekf.ERRORS)
    found: np.ndarray = np.sqrt(np.maximum(np.diag(P), 0.0))
    return found


def _ekf_takes_in(memory: np.ndarray, settings: np.ndarray, kind: str) -> bool:
    """Return whether none of a sample's first numbers was beyond the gate."""
    told = memory[ekf.INNOVATIONS : ekf.SIZE].reshape(ekf.CHANNELS, 2)[_DECIDING[kind]]
    gate = settings[ekf.EkfSettings._fields.index("ekf_gate")]
    return bool(np.all(told[:, 0] ** 2 <= gate**2 * told[:, 1]))


def _begin_complementary(state: np.ndarray, mounting: Mounting, drawn: np.ndarray) -> np.ndarray:
    return complementary.initial(state, mounting.p_BI)


def _takes_all_in(memory: np.ndarray, settings: np.ndarray, kind: str) -> bool:
    return True


def _no_deviations(memory: np.ndarray) -> np.ndarray:
    return np.full(ekf.ERRORS, np.nan)


_KNOWN = (
    Estimator(
        COMPLEMENTARY,
        complementary.ComplementarySettings,
        complementary.update,
        _begin_complementary,
        _no_deviations,
        _takes_all_in,
    ),
    Estimator(EKF, ekf.EkfSettings, ekf.update, _begin_ekf, _ekf_deviations, _ekf_takes_in),
)


def find_estimator(name: str) -> Estimator | None:
    """Return the estimator of a name, None for the truth.

    Raises:
        WorkbenchError: if there is none of that name.
    """
    if name == TRUTH:
        return None
    for each in _KNOWN:
        if each.name == name:
            return each
    raise unknown_name("estimator", name, ESTIMATORS)
