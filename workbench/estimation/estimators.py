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

from workbench.common.compiled import compile_cached
from workbench.common.errors import WorkbenchError, unknown_name
from workbench.common.jitable import mark_functions, unique
from workbench.common.own_file import (
    at_most_lines,
    check_names,
    find_own,
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

SOURCES = ("estimation", "estimators.py", "dynamics/rigid_body.py", "plant/gravity.py")
"""What the compiled updates stand in, below `workbench/`."""
ARGUMENTS = {
    "update": ("memory", "z", "settings", "mounting", "dt"),
    "begin": ("state", "mounting", "drawn", "known"),
    "covariance": ("memory",),
}
"""Of the functions of a file, in this order."""
TRIAL_PERIOD = 1 / 128
"""Between two updates with which a file's functions are tried [s]."""
TRIANGLE = np.triu_indices(9)
"""Rows and columns of a covariance's upper triangle (45), of attitude, place and velocity."""
NOMINAL_NAMES = (
    *(f"q_{axis}" for axis in "wxyz"),
    *(f"{name}_{axis}" for name in ("p", "v", "gyro_bias", "accel_bias") for axis in "xyz"),
)
"""Of the nominal state (16)."""


@dataclass(frozen=True, eq=False)
class Estimator:
    """An estimator as pure functions.

    The first 16 numbers of the memory are the nominal state, see `ekf`.

    Attributes:
        name: in scenarios; of a file its stem.
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
        memory: what it remembers behind the nominal state; none of the EKF, whose covariance
            linear models take as settled.
        parameters: rows of its settings, where it is the user's own.
        file: where that stands; None for a shipped one, so the next.
        text: of the file.
    """

    name: str
    settings: Any = field(repr=False)
    update: Callable[..., None] = field(repr=False)
    begin: Callable[[np.ndarray, Mounting, np.ndarray, InitialDeviations], np.ndarray] = field(
        repr=False
    )
    deviations: Callable[[np.ndarray], np.ndarray] = field(repr=False)
    covariance: Callable[[np.ndarray], np.ndarray] = field(repr=False)
    innovations: Callable[[np.ndarray], np.ndarray] = field(repr=False)
    memory: tuple[State, ...] = field(default=(), repr=False)
    parameters: tuple[Parameter, ...] = field(default=(), repr=False)
    file: Path | None = None
    text: str = field(default="", repr=False)

    @property
    def digest(self) -> str:
        """What tells the text of its file from any other (SHA-256)."""
        return hashlib.sha256(self.text.encode()).hexdigest()

    @property
    def key(self) -> str:
        """What tells its functions from those of any other."""
        return f"{self.name}_{self.digest[:12]}" if self.file else self.name

    def __reduce__(self) -> tuple[Any, ...]:
        """Let another process have the same text, whether or not it has the file."""
        if self.file is None:
            return find_estimator, (self.name,)
        return _from_text, (self.name, self.file, self.text)


def _begin_ekf(
    state: np.ndarray, mounting: Mounting, drawn: np.ndarray, known: InitialDeviations
) -> np.ndarray:
    """Return the memory of a filter whose errors are as large as it takes them to be."""
    memory = ekf.initial(state, mounting.p_BI, known)
    errors = np.repeat(np.array(known), 3) * drawn
    errors[9:] = 0.0  # biases of the estimate start at 0, as the true ones are not known
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
        _ekf_deviations,
        _ekf_covariance,
        _ekf_innovations,
    ),
)


def find_estimator(name: str) -> Estimator | None:
    """Return the estimator of a name, None for the truth.

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
        raise WorkbenchError(f"{file}: is called as the shipped {name}: give it another name")
    module = run_own("estimator", name, file, text)
    own = vars(module)
    update = stated_update(file, own, ARGUMENTS["update"])
    rows = tuple(replace(row, system=OWN) for row in stated_parameters(file, own))
    names = [row.name for row in rows]
    check_names(file, "parameter", names)
    memory = stated_memory(file, own)
    begin, covariance = (_optional(file, own, each) for each in ("begin", "covariance"))
    # machine code does not check indices beyond an array's end
    mark_functions(module, boundscheck=True)
    initial = np.array([each.initial for each in memory])

    def begun(
        state: np.ndarray, mounting: Mounting, drawn: np.ndarray, known: InitialDeviations
    ) -> np.ndarray:
        if begin is None:
            return np.concatenate([ekf.nominal(state, mounting.p_BI), initial])
        with own_errors(file, "begin"):
            return _array(file, "begin", begin(state, mounting, drawn, known), size)

    def whole(memory: np.ndarray) -> np.ndarray:
        if covariance is None:
            return np.full((ekf.ERRORS, ekf.ERRORS), np.nan)
        with own_errors(file, "covariance"):
            return _array(file, "covariance", covariance(memory), ekf.ERRORS, ekf.ERRORS)

    def deviations(memory: np.ndarray) -> np.ndarray:
        found: np.ndarray = np.sqrt(np.maximum(np.diag(whole(memory)), 0.0))
        return found

    def triangle(memory: np.ndarray) -> np.ndarray:
        found: np.ndarray = whole(memory)[TRIANGLE]
        return found

    size = ekf.NOMINAL + len(memory)
    estimator = Estimator(
        name=name,
        settings=record("Settings", names, [row.default for row in rows]),
        update=update,
        begin=begun,
        deviations=deviations,
        covariance=triangle,
        innovations=_no_innovations,
        memory=memory,
        parameters=rows,
        file=file,
        text=text,
    )
    with own_errors(file, "update"), at_most_lines(file):
        _tried(estimator)
    return estimator


def _optional(file: Path, own: Mapping[str, Any], name: str) -> Callable[..., Any] | None:
    """Return a function that a file may state, None where it does not.

    Raises:
        WorkbenchError: if it is no function, or takes other arguments.
    """
    function, wanted = own.get(name), ARGUMENTS[name]
    if function is None:
        return None
    if not inspect.isfunction(function) or tuple(inspect.signature(function).parameters) != wanted:
        raise WorkbenchError(
            f"{file}: {name} is no function of ({', '.join(wanted)}): write def "
            f"{name}({', '.join(wanted)}), or leave it out"
        )
    return function


def _array(file: Path, what: str, found: Any, *shape: int) -> np.ndarray:
    """Return what a function of a file has returned, if it is an array of finite numbers.

    Args:
        file: where the function stands.
        what: its name.
        found: what it returned.
        shape: that it must have.

    Raises:
        WorkbenchError: if it is something else.
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
        raise WorkbenchError(f"{file}: {what} returns numbers that are not finite: mend it")
    return found.astype(float)


def _tried(estimator: Estimator) -> None:
    """Run a file's functions with plain numbers: at rest in hover, and on the move.

    Raises:
        WorkbenchError: if they give other things than the interface says.
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


@lru_cache(maxsize=8)
def compiled_update(estimator: Estimator) -> Callable[..., None]:
    """Return the update of an estimator, compiled at its first call.

    That of a file says in a sentence what goes wrong in it.
    """
    what, file = f"the estimator {estimator.name}", estimator.file
    if file is None:
        return compile_cached(estimator.update, SOURCES, what, parts=40)
    update = estimator.update

    def run(
        memory: np.ndarray, z: np.ndarray, settings: np.ndarray, mounting: np.ndarray, dt: float
    ) -> None:
        update(memory, z, settings, mounting, dt)

    compiled = compile_cached(
        unique(run, estimator.key),
        SOURCES,
        what,
        parts=20,
        text=estimator.text,
        file=str(file),
        page="docs/estimation.md",
    )

    def checked(
        memory: np.ndarray, z: np.ndarray, settings: np.ndarray, mounting: np.ndarray, dt: float
    ) -> None:
        with own_errors(file, "update"):
            compiled(memory, z, settings, mounting, dt)
        _check_finite(str(file), estimator, memory)

    return checked


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
    R = rotation(found[:4].tolist())
    found[7:10] = into_world(R, found[7:10].tolist())
    return found
