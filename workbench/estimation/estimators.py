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
import inspect
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import lru_cache
from pathlib import Path
from typing import Any

import numpy as np

from workbench.common.errors import WorkbenchError, unknown_name
from workbench.common.jitable import mark_functions
from workbench.common.own_file import (
    at_most_lines,
    check_names,
    find_own,
    non_finite_named,
    own_errors,
    read_own,
    record,
    run_own,
    stated_memory,
    stated_parameters,
    stated_update,
)
from workbench.common.parameter import Parameter, State
from workbench.dynamics.rigid_body import into_world, rotation
from workbench.estimation import complementary, ekf
from workbench.estimation.ekf import InitialDeviations
from workbench.estimation.samples import (
    BAROMETER,
    GPS,
    MAGNETOMETER,
    RANGE_FINDER,
    SAMPLES,
    Mounting,
)
from workbench.estimation.settings import (
    COMPLEMENTARY,
    EKF,
    ESTIMATORS,
    OWN,
    TRUTH,
    ComplementarySettings,
    EkfSettings,
)
from workbench.plant.gravity import GRAVITY

ARGUMENTS = {
    "update": ("memory", "z", "settings", "mounting", "dt"),
    "begin": ("state", "mounting", "drawn", "known"),
    "covariance": ("memory",),
}
"""Arguments of the functions of a file, in this order."""
TRIAL_PERIOD = 1 / 128
"""Time between two updates in the trial of a file's functions [s]."""
TRIANGLE = np.triu_indices(9)
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
            the others, see `ekf.CHANNELS`; None if it has none.
        memory: its states after the nominal state; empty for the EKF, because linear models use its
            settled covariance.
        parameters: rows of the parameter table; empty for a shipped one, as are the next two.
        file: of a user's own estimator.
        text: of the file.
    """

    name: str
    settings: Any = field(repr=False)
    update: Callable[..., None] = field(repr=False)
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
        """Name for machine code, see `jitable.unique`."""
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
        """Return the covariance of attitude, position and velocity, see `TRIANGLE` (45)."""
        found: np.ndarray = self._covariance(memory)[TRIANGLE]
        return found

    def innovations(self, memory: np.ndarray) -> np.ndarray:
        """Return innovations and variances of the measurements of this update, see `measured`."""
        return self.measured(memory) if self.measured else np.full(2 * ekf.CHANNELS, np.nan)

    def _covariance(self, memory: np.ndarray) -> np.ndarray:
        if self.error_covariance is None:
            return np.full((ekf.ERRORS, ekf.ERRORS), np.nan)
        return self.error_covariance(memory)


def _begin_ekf(
    state: np.ndarray, mounting: Mounting, drawn: np.ndarray, known: InitialDeviations
) -> np.ndarray:
    """Return the initial memory, with errors of the standard deviations that the filter assumes."""
    memory = ekf.initial(state, mounting.p_BI, known)
    errors = np.repeat(np.array(known), 3) * drawn
    errors[9:] = 0.0  # estimated biases start at 0, because the true ones are unknown
    memory[: ekf.NOMINAL] = ekf.corrected(memory[: ekf.NOMINAL], errors)
    return memory


def _ekf_innovations(memory: np.ndarray) -> np.ndarray:
    return ekf.innovations_of(memory).ravel()


def _begin_complementary(
    state: np.ndarray, mounting: Mounting, drawn: np.ndarray, known: InitialDeviations
) -> np.ndarray:
    return complementary.initial(state, mounting.p_BI)


_KNOWN = (
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
        ekf.covariance_of,
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
    for each in _KNOWN:
        if each.name == name:
            return each
    path = find_own(name, "estimator")
    if path is None:
        raise unknown_name("estimator", name, ESTIMATORS)
    return _from_text(path.stem, path.resolve(), read_own(path, "estimator"))


@lru_cache(maxsize=32)
def _from_text(name: str, file: Path, text: str) -> Estimator:
    """Return the estimator of a text; the same one for the same text.

    Raises:
        WorkbenchError: naming file and line of what is wrong.
    """
    if name in ESTIMATORS:
        raise WorkbenchError(f"{file}: has the name of the shipped {name}: give it another name")
    module = run_own("estimator", name, file, text)
    own = vars(module)
    update = stated_update(file, own, ARGUMENTS["update"])
    rows = tuple(replace(row, system=OWN) for row in stated_parameters(file, own))
    names = [row.name for row in rows]
    check_names(file, "parameter", names)
    memory = stated_memory(file, own)
    begin, covariance = (_optional(file, own, each) for each in ("begin", "covariance"))
    # without it, machine code does not check indices
    mark_functions(module, boundscheck=True)
    initial = np.array([each.initial for each in memory])

    def begun(
        state: np.ndarray, mounting: Mounting, drawn: np.ndarray, known: InitialDeviations
    ) -> np.ndarray:
        if begin is None:
            return np.concatenate([ekf.nominal(state, mounting.p_BI), initial])
        with own_errors(file, "begin"):
            return _array(file, "begin", begin(state, mounting, drawn, known), size)

    def checked_covariance(memory: np.ndarray) -> np.ndarray:
        assert covariance
        with own_errors(file, "covariance"):
            return _array(file, "covariance", covariance(memory), ekf.ERRORS, ekf.ERRORS)

    size = ekf.NOMINAL + len(memory)
    estimator = Estimator(
        name=name,
        settings=record("Settings", names, [row.default for row in rows]),
        update=update,
        begin=begun,
        error_covariance=checked_covariance if covariance else None,
        memory=memory,
        parameters=rows,
        file=file,
        text=text,
    )
    with own_errors(file, "update"), at_most_lines(file):
        _tried(estimator)
    return estimator


def _optional(file: Path, own: Mapping[str, Any], name: str) -> Callable[..., Any] | None:
    """Return an optional function of a file, None without it.

    Raises:
        WorkbenchError: if it is not a function, or has other arguments.
    """
    function, wanted = own.get(name), ARGUMENTS[name]
    if function is None:
        return None
    if not inspect.isfunction(function) or tuple(inspect.signature(function).parameters) != wanted:
        raise WorkbenchError(
            f"{file}: {name} is not a function of ({', '.join(wanted)}): write def "
            f"{name}({', '.join(wanted)}), or leave it out"
        )
    return function


def _array(file: Path, what: str, found: Any, *shape: int) -> np.ndarray:
    """Return the result of a function of a file, which must be an array of finite numbers.

    Args:
        file: of the function.
        what: name of the function.
        found: its result.
        shape: required shape.

    Raises:
        WorkbenchError: if the result is anything else.
    """
    wanted = " x ".join(map(str, shape))
    if not isinstance(found, np.ndarray) or found.shape != shape:
        has = "x".join(map(str, found.shape)) if isinstance(found, np.ndarray) else repr(found)
        rule = ""
        if what == "begin":
            rule = f": {ekf.NOMINAL} of the nominal state, and one for each row of MEMORY"
        raise WorkbenchError(
            f"{file}: {what} returns {has:.60}: let it be an array of {wanted} numbers{rule}"
        )
    if not np.isfinite(found).all():
        raise WorkbenchError(f"{file}: {what} returns numbers that are not finite: correct it")
    return found.astype(float)


def _tried(estimator: Estimator) -> None:
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
        memory = estimator.begin(state, mounting, np.zeros(ekf.ERRORS), InitialDeviations())
        silent = np.zeros(SAMPLES)
        silent[:6] = *w, *f
        heard = silent.copy()
        heard[[GPS, BAROMETER, MAGNETOMETER, RANGE_FINDER]] = 1.0
        heard[GPS + 2 : GPS + 8] = *state[4:7], *state[10:13]
        heard[BAROMETER + 1] = heard[RANGE_FINDER + 1] = state[6]
        heard[MAGNETOMETER + 1 : MAGNETOMETER + 4] = mounting.m_W
        for z, dt in ((silent, 0.0), (heard, TRIAL_PERIOD), (silent, TRIAL_PERIOD)):
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
        with own_errors(file, "update"), divides:
            update(memory, z.copy(), settings, mounting, dt)
            if not np.isfinite(memory).all():
                with non_finite_named(file, "update"):
                    update(before, z, settings, mounting, dt)
        _check_finite(str(file), estimator, memory)

    return checked


def known_motion(memory: np.ndarray, rates: np.ndarray, p_BI: Sequence[float]) -> np.ndarray:
    """Return the estimated motion of the base origin (13).

    Args:
        memory: of an estimator.
        rates: angular velocity of the gyro in B, first (3) [rad/s].
        p_BI: of the IMU (3) [m].

    Returns:
        q_WB, p_WB [m], w_WB_W [rad/s] and v_WB_W [m/s].
    """
    motion = ekf.estimate(ekf.nominal_of(memory), rates.tolist(), p_BI)
    w_WB = into_world(rotation(motion[:4]), motion[7:10])
    return np.array([*motion[:7], *w_WB, *motion[10:]])
