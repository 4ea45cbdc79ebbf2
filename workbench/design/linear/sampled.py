"""The exact model of the sampled loop, from one control update to the next.

Between updates the plant takes physics steps under held thrusts; the first still has the old ones,
as the steps of an instant are simultaneous. The period's matrix is the product of the exact
derivatives of the update and of each step along the trimmed flight.
"""

import numpy as np

from workbench.design.linear.attitude import heading_turn
from workbench.design.linear.derivatives import (
    HELD,
    REFERENCE,
    STATE,
    WRENCH,
    Derivatives,
    Step,
    Update,
)
from workbench.design.linear.model import LinearModel, Signal, Trim
from workbench.design.linear.names import (
    filtered,
    motion,
    numbered,
    outputs,
    points,
    references,
    wrench,
)
from workbench.design.linear.trim import guidance_of, memory_of, reference_of
from workbench.errors import WorkbenchError
from workbench.scenario import Rates
from workbench.systems.loop_points import COUNT

SAME = 1e-12
"""Attitudes and rates closer than this have the same derivatives of a step."""


def sampled_model(
    derivatives: Derivatives, trim: Trim, rates: Rates, rate: float, delay: int = 0
) -> LinearModel:
    """Return the linear model of a control period.

    States are those at an update, before it: the motion, the thrusts of the period that ends,
    rotor speeds, held commands, the estimate's memory, the drag that is held, and the motions that
    a delayed controller is still to see. Outputs are those at the update, thrusts those after it.

    Args:
        derivatives: of what flies.
        trim: where.
        rates: of physics and control.
        rate: of the acceleration estimate [1/s].
        delay: control periods by which the law sees the motion late.

    Raises:
        WorkbenchError: for a turn with a delay, which has no such model.
    """
    if delay and trim.point.yaw_rate:
        raise WorkbenchError("a turn cannot be linearised with a delayed controller: leave one out")
    n = trim.speeds.size
    memory = memory_of(trim, rate)
    update = derivatives.update(trim.state, memory, reference_of(trim), guidance_of(trim))
    size = STATE + n + memory.size + WRENCH + STATE * delay
    at = np.cumsum([0, STATE, n, memory.size, WRENCH, STATE * delay])
    s, thrust, mem, drag, late = (slice(a, b) for a, b in zip(at[:-1], at[1:], strict=True))

    inputs = REFERENCE + HELD + COUNT + STATE
    asked, noise = slice(0, REFERENCE + HELD + COUNT), slice(REFERENCE + HELD + COUNT, inputs)
    seen = np.zeros((STATE + memory.size, size))
    seen[:STATE, slice(size - STATE, size) if delay else s] = np.eye(STATE)
    seen[STATE:, mem] = np.eye(memory.size)
    true = seen.copy()
    true[:STATE] = np.eye(STATE, size)

    def of_update(rows: np.ndarray, sees: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Return rows of the update by states and by inputs."""
        known = STATE + memory.size
        by_inputs = np.zeros((rows.shape[0], inputs))
        by_inputs[:, asked] = rows[:, known:]
        by_inputs[:, noise] = rows[:, :STATE]
        return rows[:, :known] @ sees, by_inputs

    A, B = np.zeros((size, size)), np.zeros((size, inputs))
    A[thrust], B[thrust] = of_update(update.thrusts_by, seen)
    A[mem], B[mem] = of_update(update.memory_by, seen)
    A[drag], _ = of_update(update.wrench_by, true)
    signals, signals_in = of_update(update.signals_by, seen)
    A[s], B[s] = _steps(derivatives, trim, update, rates, A, B, (s, thrust, drag))
    if delay:
        A[late] = np.eye(STATE * delay, size, at[4] - STATE)
        A[late][:STATE] = np.eye(STATE, size)

    turn = _turn(size, trim.point.yaw_rate * rates.control_period, mem, n)
    A, B = turn @ A, turn @ B
    C = np.vstack([np.eye(STATE, size), signals, A[thrust], np.eye(size)[mem][:n]])
    D = np.zeros((C.shape[0], inputs))
    D[STATE : STATE + COUNT] = signals_in
    D[STATE + COUNT : STATE + COUNT + n] = B[thrust]
    return LinearModel(
        A=A,
        input_matrix=B,
        output_matrix=C,
        feedthrough=D,
        period=rates.control_period,
        states=_states(n, delay),
        inputs=(*references(), *points(), *motion("noise_")),
        outputs=outputs(n),
        trim=trim,
    )


def _steps(
    derivatives: Derivatives,
    trim: Trim,
    update: Update,
    rates: Rates,
    A: np.ndarray,
    B: np.ndarray,
    places: tuple[slice, slice, slice],
) -> tuple[np.ndarray, np.ndarray]:
    """Return the rows of the motion (12) after all physics steps of a period."""
    s, thrust, drag = places
    n = trim.speeds.size
    at = trim.state
    step = derivatives.step(at, update.thrusts, update.wrench)
    by_state = np.zeros((STATE, A.shape[0]))
    by_state[:, s], by_state[:, thrust], by_state[:, drag] = _parts(step, n)
    by_input = np.zeros((STATE, B.shape[1]))
    for _ in range(round(rates.control_period / rates.physics_step) - 1):
        if not _alike(at, step.state):
            at = step.state
            step = derivatives.step(at, update.thrusts, update.wrench)
        by_motion, by_thrust, by_drag = _parts(step, n)
        by_state = by_motion @ by_state + by_thrust @ A[thrust] + by_drag @ A[drag]
        by_input = by_motion @ by_input + by_thrust @ B[thrust] + by_drag @ B[drag]
    return by_state, by_input


def _parts(step: Step, n: int) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return a step's derivatives by motion, thrusts and drag."""
    return step.by[:, :STATE], step.by[:, STATE : STATE + n], step.by[:, STATE + n :]


def _alike(one: np.ndarray, other: np.ndarray) -> bool:
    """Return whether two plant states (13) have the same derivatives of a step."""
    turning = [0, 1, 2, 3, 7, 8, 9]
    return bool(np.abs(one[turning] - other[turning]).max() < SAME)


def _turn(size: int, angle: float, memory: slice, n: int) -> np.ndarray:
    """Return the matrix that gives the states in axes that have turned by an angle."""
    turn = np.eye(size)
    turn[:STATE, :STATE] = heading_turn(angle, 4)
    place = slice(memory.start + 2 * n, memory.stop)
    turn[place, place] = heading_turn(angle, 1)
    return turn


def _states(n: int, delay: int) -> tuple[Signal, ...]:
    seen = (signal for age in range(delay) for signal in motion(f"seen_{age + 1}_"))
    return (
        *motion(),
        *numbered("thrust", n, "N"),
        *numbered("speed", n, "rad/s"),
        *numbered("command", n, "rad/s"),
        *filtered(),
        *wrench(),
        *seen,
    )
