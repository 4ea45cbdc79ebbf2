"""The estimators: those that a scenario can name, and a user's own file.

The file is Python, see docs/estimation.md. It defines

    PARAMETERS   its live parameters, made by `gain`
    MEMORY       its states after the nominal state, `State`s
    update       one update of its memory in place
    begin        the initial memory
    covariance   of its errors

Only `update` is required.
"""

import hashlib
from collections.abc import Callable
from dataclasses import dataclass, field, replace
from functools import lru_cache
from pathlib import Path
from typing import Any

import numpy as np

from workbench.common.errors import WorkbenchError, unknown_name
from workbench.common.jitable import mark_functions
from workbench.common.own_file import (
    check_names,
    find_user_file,
    limit_executed_lines,
    locate_non_finite,
    read_memory,
    read_parameters,
    read_update,
    read_user_file,
    run_user_file,
    user_code_errors,
    user_record_type,
)
from workbench.common.parameter import Parameter, State
from workbench.common.vectors import Numbers
from workbench.dynamics.rigid_body import into_world, rotation
from workbench.estimation import complementary, ekf, ekf_propagation, ekf_state
from workbench.estimation.ekf import InitialDeviations
from workbench.estimation.estimator_file import (
    ESTIMATOR_ARGUMENTS,
    checked_array,
    optional_function,
)
from workbench.estimation.samples import (
    BAROMETER,
    GPS,
    MAGNETOMETER,
    RANGE_FINDER,
    SAMPLE_ARRAY_SIZE,
    Mounting,
)
from workbench.estimation.settings import (
    COMPLEMENTARY,
    EKF,
    ESTIMATORS,
    TRUTH,
    USER_ESTIMATOR,
    ComplementarySettings,
    EkfSettings,
)
from workbench.plant.gravity import GRAVITY

ESTIMATOR_TRIAL_PERIOD_S = 1 / 128
"""Time between two updates in the trial of a file's functions [s]."""
COVARIANCE_TRIANGLE = np.triu_indices(9)
"""Rows and columns of the upper triangle, row by row, of attitude, position and velocity (45)."""
NOMINAL_NAMES = (
    *(f"q_{axis}" for axis in "wxyz"),
    *(f"{name}_{axis}" for name in ("p", "v", "gyro_bias", "accel_bias") for axis in "xyz"),
)
"""Names of the numbers of the nominal state (16)."""


@dataclass(frozen=True, eq=False)
class Estimator:
    """An estimator as pure functions.

    The first 16 numbers of the memory are the nominal state, see `ekf`.

    Attributes:
        name: in scenarios; the stem of a user's own file.
        settings: type of the named tuple of its live parameters.
        update: one update of its memory in place, see `ekf.update`.
        begin: returns the initial memory for a motion (13), the mounting, standard normal numbers
            (15) and the standard deviations of the initial errors.
        error_covariance: returns the covariance of its errors (15, 15), None if it has none.
        measured: returns innovation and variance of each measurement of this update (20), NaN for
            the others, see `ekf_state.MEASUREMENT_CHANNELS`; None if it has none.
        memory: its states after the nominal state; empty for the EKF, because linear models use its
            settled covariance.
        parameters: rows of the parameter table; empty for a shipped one, as are the next two.
        file: of a user's own estimator.
        text: of the file.
    """

    name: str
    settings: Any = field(repr=False)
    update: Callable[[np.ndarray, np.ndarray, np.ndarray, np.ndarray, float], None] = field(
        repr=False
    )
    begin: Callable[[np.ndarray, Mounting, np.ndarray, InitialDeviations], np.ndarray] = field(
        repr=False
    )
    error_covariance: Callable[[np.ndarray], np.ndarray] | None = field(default=None, repr=False)
    measured: Callable[[np.ndarray], np.ndarray] | None = field(default=None, repr=False)
    memory: tuple[State, ...] = field(default=(), repr=False)
    parameters: tuple[Parameter, ...] = field(default=(), repr=False)
    file: Path | None = None
    text: str = field(default="", repr=False)

    @property
    def digest(self) -> str:
        """SHA-256 of the text of its file."""
        return hashlib.sha256(self.text.encode()).hexdigest()

    @property
    def key(self) -> str:
        """Name for machine code, see `give_unique_name`."""
        return f"{self.name}_{self.digest[:12]}" if self.file else self.name

    def __reduce__(self) -> tuple[Any, ...]:
        """Pickle the text, so that another process needs no file."""
        if self.file is None:
            return find_estimator, (self.name,)
        return _from_text, (self.name, self.file, self.text)

    def deviations(self, memory: np.ndarray) -> np.ndarray:
        """Return the standard deviations of its errors (15), NaN if it has no covariance."""
        found: np.ndarray = np.sqrt(np.maximum(self._covariance(memory).diagonal(), 0.0))
        return found

    def covariance(self, memory: np.ndarray) -> np.ndarray:
        """Return the covariance of attitude, position and velocity, see `COVARIANCE_TRIANGLE`
        (45).
        """
        found: np.ndarray = self._covariance(memory)[COVARIANCE_TRIANGLE]
        return found

    def innovations(self, memory: np.ndarray) -> np.ndarray:
        """Return innovations and variances of the measurements of this update, see `measured`."""
        return (
            self.measured(memory)
            if self.measured
            else np.full(2 * ekf_state.MEASUREMENT_CHANNELS, np.nan)
        )

    def _covariance(self, memory: np.ndarray) -> np.ndarray:
        if self.error_covariance is None:
            return np.full((ekf_state.ERRORS, ekf_state.ERRORS), np.nan)
        return self.error_covariance(memory)


def _begin_ekf(
    state: np.ndarray, mounting: Mounting, drawn: np.ndarray, known: InitialDeviations
) -> np.ndarray:
    """Return the initial memory, with errors of the standard deviations that the filter assumes."""
    memory = ekf.initial_ekf(state, mounting.p_BI, known)
    errors = np.repeat(np.array(known), 3) * drawn
    errors[9:] = 0.0  # estimated biases start at 0, because the true ones are unknown
    memory[: ekf_state.NOMINAL] = ekf_propagation.corrected(memory[: ekf_state.NOMINAL], errors)
    return memory


def _ekf_innovations(memory: np.ndarray) -> np.ndarray:
    return ekf_state.innovations_of(memory).ravel()


def _begin_complementary(
    state: np.ndarray, mounting: Mounting, drawn: np.ndarray, known: InitialDeviations
) -> np.ndarray:
    return complementary.initial_complementary(state, mounting.p_BI)


_SHIPPED_ESTIMATORS = (
    Estimator(
        COMPLEMENTARY,
        ComplementarySettings,
        complementary.update,
        _begin_complementary,
        memory=(
            *(State(f"{kind}_seen", "1") for kind in ("gps", "barometer", "magnetometer")),
            State("gps_age", "s"),
            *(State(f"gps_p_{axis}", "m") for axis in "xyz"),
            *(State(f"gps_v_{axis}", "m/s") for axis in "xyz"),
            State("barometer_height", "m"),
        ),
    ),
    Estimator(
        EKF,
        EkfSettings,
        ekf.update,
        _begin_ekf,
        ekf_state.covariance_of,
        _ekf_innovations,
    ),
)


def find_estimator(name: str) -> Estimator | None:
    """Return an estimator by name, None for the truth.

    A file's code runs, with the rights of whoever calls this.

    Args:
        name: one of `ESTIMATORS`; the path of a file that ends in .py; or the name of an
            importable module, with a dot in it.

    Raises:
        WorkbenchError: naming file and line of what is wrong.
    """
    if name == TRUTH:
        return None
    for each in _SHIPPED_ESTIMATORS:
        if each.name == name:
            return each
    path = find_user_file(name, "estimator")
    if path is None:
        raise unknown_name("estimator", name, ESTIMATORS)
    return _from_text(path.stem, path.resolve(), read_user_file(path, "estimator"))


@lru_cache(maxsize=32)
def _from_text(name: str, file: Path, text: str) -> Estimator:
    """Return the estimator of a text; the same one for the same text.

    Raises:
        WorkbenchError: naming file and line of what is wrong.
    """
    if name in ESTIMATORS:
        raise WorkbenchError(f"{file}: has the name of the shipped {name}: give it another name")
    module = run_user_file("estimator", name, file, text)
    own = vars(module)
    update = read_update(file, own, ESTIMATOR_ARGUMENTS["update"])
    rows = tuple(replace(row, system=USER_ESTIMATOR) for row in read_parameters(file, own))
    names = [row.name for row in rows]
    check_names(file, "parameter", names)
    memory = read_memory(file, own)
    begin, covariance = (optional_function(file, own, each) for each in ("begin", "covariance"))
    # without it, machine code does not check indices
    mark_functions(module, boundscheck=True)
    initial = np.array([each.initial for each in memory])

    def begun(
        state: np.ndarray, mounting: Mounting, drawn: np.ndarray, known: InitialDeviations
    ) -> np.ndarray:
        if begin is None:
            return np.concatenate([ekf.nominal(state, mounting.p_BI), initial])
        with user_code_errors(file, "begin"):
            return checked_array(file, "begin", begin(state, mounting, drawn, known), size)

    def checked_covariance(memory: np.ndarray) -> np.ndarray:
        assert covariance
        with user_code_errors(file, "covariance"):
            return checked_array(
                file, "covariance", covariance(memory), ekf_state.ERRORS, ekf_state.ERRORS
            )

    size = ekf_state.NOMINAL + len(memory)
    estimator = Estimator(
        name=name,
        settings=user_record_type("Settings", names, [row.default for row in rows]),
        update=update,
        begin=begun,
        error_covariance=checked_covariance if covariance else None,
        memory=memory,
        parameters=rows,
        file=file,
        text=text,
    )
    with user_code_errors(file, "update"), limit_executed_lines(file):
        _check_estimator_by_trial(estimator)
    return estimator


def _check_estimator_by_trial(estimator: Estimator) -> None:
    """Run a file's functions with plain numbers: at rest in hover, and in motion.

    Raises:
        WorkbenchError: if a result is not what the interface requires.
    """
    file, update = estimator.file, estimator.update
    assert file
    where = f"{file}:{update.__code__.co_firstlineno}"
    mounting, settings = Mounting(), np.array(estimator.settings(), dtype=float)
    still = np.array([1.0, *[0.0] * 12])
    moves = np.array([0.97, 0.1, -0.2, 0.1, 1.0, 2.0, 3.0, 0.1, -0.2, 0.3, 0.5, -0.4, 0.2])
    for state, w, f in (
        (still, (0.0, 0.0, 0.0), (0.0, 0.0, GRAVITY)),
        (moves, (0.1, -0.2, 0.3), (0.5, -0.4, 1.1 * GRAVITY)),
    ):
        memory = estimator.begin(state, mounting, np.zeros(ekf_state.ERRORS), InitialDeviations())
        silent = np.zeros(SAMPLE_ARRAY_SIZE)
        silent[:6] = *w, *f
        complete = silent.copy()
        complete[[GPS, BAROMETER, MAGNETOMETER, RANGE_FINDER]] = 1.0
        complete[GPS + 2 : GPS + 8] = *state[4:7], *state[10:13]
        complete[BAROMETER + 1] = complete[RANGE_FINDER + 1] = state[6]
        complete[MAGNETOMETER + 1 : MAGNETOMETER + 4] = list(mounting.m_W)
        for z, dt in (
            (silent, 0.0),
            (complete, ESTIMATOR_TRIAL_PERIOD_S),
            (silent, ESTIMATOR_TRIAL_PERIOD_S),
        ):
            with np.errstate(all="ignore"):
                found = update(memory, z.copy(), settings, mounting.packed(), dt)
            if found is not None:
                raise WorkbenchError(
                    f"{where}: update returns {found!r:.60}: let it change memory in place, and "
                    "return nothing"
                )
            _check_finite(where, estimator, memory)
        estimator.deviations(memory)


def _check_finite(where: str, estimator: Estimator, memory: np.ndarray) -> None:
    """Refuse a memory in which a number is not finite."""
    if np.isfinite(memory).all():
        return
    place = int(np.flatnonzero(~np.isfinite(memory))[0])
    names = [*NOMINAL_NAMES, *(state.name for state in estimator.memory)]
    raise WorkbenchError(
        f"{where}: update leaves {memory[place]} in memory[{place}], {names[place]}: let it be a "
        "finite number"
    )


def checked_update(estimator: Estimator) -> Callable[..., None]:
    """Return the update of an estimator.

    That of a user's own file raises a `WorkbenchError` for any error, and for a number that is not
    finite.
    """
    file, update = estimator.file, estimator.update
    if file is None:
        return update

    def checked(
        memory: np.ndarray, z: np.ndarray, settings: np.ndarray, mounting: np.ndarray, dt: float
    ) -> None:
        before = memory.copy()
        divides = np.errstate(divide="raise", over="ignore", invalid="ignore")
        with user_code_errors(file, "update"), divides:
            update(memory, z.copy(), settings, mounting, dt)
            if not np.isfinite(memory).all():
                with locate_non_finite(file, "update"):
                    update(before, z, settings, mounting, dt)
        _check_finite(str(file), estimator, memory)

    return checked


def known_motion(memory: np.ndarray, rates: np.ndarray, p_BI: Numbers) -> np.ndarray:
    """Return the estimated motion of the base origin (13).

    Args:
        memory: of an estimator.
        rates: angular velocity of the gyro in B, first (3) [rad/s].
        p_BI: of the IMU (3) [m].

    Returns:
        q_WB, p_WB [m], w_WB_W [rad/s] and v_WB_W [m/s].
    """
    motion = ekf.motion_estimate(ekf_state.nominal_of(memory), rates.tolist(), p_BI)
    w_WB = into_world(rotation(motion[:4]), motion[7:10])
    return np.array([*motion[:7], *w_WB, *motion[10:]])
