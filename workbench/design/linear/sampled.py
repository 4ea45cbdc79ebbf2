"""The exact model of the sampled loop, from one control update to the next.

Between updates the vehicle takes physics steps under held commands; the first still has the old
ones, as the steps of an instant are simultaneous. The period's matrix is the product of the exact
derivatives of the update and of each step along the trimmed flight.
"""

import dataclasses

import numpy as np

from workbench.common.errors import WorkbenchError
from workbench.design.linear.attitude import heading_turn
from workbench.design.linear.derivatives import (
    FILTERED,
    HELD,
    LAST,
    REFERENCE,
    STATE,
    Derivatives,
    Update,
)
from workbench.design.linear.model import LinearModel, Signal, Trim
from workbench.design.linear.names import (
    accelerations,
    filtered,
    memory_of,
    motion,
    numbered,
    outputs,
    points,
    references,
    wrench,
)
from workbench.design.linear.trim import filtered_of, guidance_of, reference_of
from workbench.plant.variation import Delays
from workbench.scenario.scenario import Rates

SAME = 1e-12
"""Attitudes and rates closer than this have the same derivatives of a step."""


def sampled_model(
    derivatives: Derivatives, trim: Trim, rates: Rates, rate: float, delays: Delays
) -> LinearModel:
    """Return the linear model of a control period.

    States are those at an update, before it: the motion, the acceleration in the middle of the
    step before, rotor speeds, commands that act or are still to act, the velocity that the estimate
    remembers, the motions that a delayed controller is still to see, and what the law remembers.
    Outputs are those at the update.

    Args:
        derivatives: of what flies.
        trim: where.
        rates: of physics and control.
        rate: of the acceleration estimate [1/s].
        delays: of sensing and commands.

    Raises:
        WorkbenchError: for a turn with a delay of sensing, which has no such model.
    """
    late, look = delays.seen
    age, since = delays.acting
    waiting = age + 1 if since else age
    if late and trim.point.yaw_rate:
        raise WorkbenchError("a turn cannot be linearised with a delayed controller: leave one out")
    n, k = trim.speeds.size, trim.memory.size
    count = len(derivatives.controller.points)
    update = _update_at(derivatives, trim, rate)
    sizes = (STATE, LAST, n, *[n] * waiting, FILTERED, *[STATE] * late, k)
    at = np.cumsum([0, *sizes])
    size = int(at[-1])
    groups = [slice(int(a), int(b)) for a, b in zip(at[:-1], at[1:], strict=True)]
    s, last, speed = groups[:3]
    commands, velocity, older = groups[3 : 3 + waiting], groups[3 + waiting], groups[4 + waiting :]
    memory = older.pop()
    moving = slice(0, speed.stop)

    inputs = REFERENCE + HELD + count + STATE
    asked, noise = slice(0, REFERENCE + HELD + count), slice(REFERENCE + HELD + count, inputs)
    known = STATE + FILTERED + n
    seen = np.zeros((known + k, size))
    seen[:STATE, older[-1] if late else s] = np.eye(STATE)
    seen[STATE : STATE + FILTERED, velocity] = np.eye(FILTERED)
    seen[STATE + FILTERED : known, commands[0]] = np.eye(n)
    seen[known:, memory] = np.eye(k)

    def of_update(rows: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Return rows of the update by states and by inputs."""
        by_inputs = np.zeros((rows.shape[0], inputs))
        by_inputs[:, asked] = rows[:, known : known + asked.stop]
        by_inputs[:, noise] = rows[:, :STATE]
        return np.hstack([rows[:, :known], rows[:, known + asked.stop :]]) @ seen, by_inputs

    A, B = np.zeros((size, size)), np.zeros((size, inputs))
    whole = np.eye(size)
    now = of_update(update.commands_by)
    # rows of commands by their age in updates, the newest first
    acting = [now, *((whole[each], np.zeros((n, inputs))) for each in commands)]
    A[velocity], B[velocity] = of_update(update.filtered_by)
    if k:
        A[memory], B[memory] = of_update(update.memory_by)
    signals, signals_in = of_update(update.signals_by)
    held = [acting[age if step >= since else age + 1] for step in range(delays.steps)]
    states = _states_of_period(derivatives, trim, update, rates, held)
    A[moving], B[moving] = states[-1]
    for each, (by_state, by_input) in zip(commands, acting, strict=False):
        A[each], B[each] = by_state, by_input
    for each, before in zip(older[1:], older, strict=False):
        A[each] = whole[before]
    if late:
        by_state, by_input = states[look]
        A[older[0]], B[older[0]] = by_state[:STATE], by_input[:STATE]

    turn = np.eye(size)
    angle = trim.point.yaw_rate * rates.control_period
    for vectors, vectors_in in ((s, 4), (last, 2), (velocity, 1)):
        turn[vectors, vectors] = heading_turn(angle, vectors_in)
    A, B = turn @ A, turn @ B
    thrusts = np.zeros((n, size))
    thrusts_by = derivatives.thrusts_by(trim.state, trim.speeds)
    thrusts[:, s], thrusts[:, speed] = thrusts_by[:, :STATE], thrusts_by[:, STATE:]
    C = np.vstack([np.eye(STATE, size), signals, thrusts, whole[speed]])
    D = np.zeros((C.shape[0], inputs))
    D[STATE : STATE + count] = signals_in
    return LinearModel(
        A=A,
        input_matrix=B,
        output_matrix=C,
        feedthrough=D,
        period=rates.control_period,
        states=(*_states(n, waiting, late), *memory_of(derivatives.controller)),
        inputs=(*references(), *points(derivatives.controller), *motion("noise_")),
        outputs=outputs(n, derivatives.controller),
        trim=trim,
        controller=derivatives.controller,
    )


def plant_input_model(
    derivatives: Derivatives, model: LinearModel, rates: Rates, rate: float, delays: Delays
) -> LinearModel:
    """Return a sampled model's closed loop with the plant's input as its inputs and outputs.

    That is the wrench which an update commands: force along z and moment in T. It comes out, and
    what is injected is added on its way to the rotors, where the law does not know of it: so every
    law is judged at the same place, those that look at their own commands, too.

    Args:
        derivatives: of what flies.
        model: from `sampled_model`, with the arguments that follow.
        rates: of physics and control.
        rate: of the acceleration estimate [1/s].
        delays: of sensing and commands.
    """
    trim, size, signals = model.trim, len(model.A), wrench()
    late, look = delays.seen
    age, since = delays.acting
    waiting = age + 1 if since else age
    n = trim.speeds.size
    moving, axes = STATE + LAST + n, len(signals)
    wrench_by, commands_by = derivatives.allocation_at(trim.commands)
    columns, inputs = moving + axes * waiting, np.zeros((n, axes))
    acting = [(np.zeros((n, columns)), commands_by)]
    for before in range(waiting):  # what was injected at updates before is a state
        by_state = np.zeros((n, columns))
        by_state[:, moving + axes * before : moving + axes * (before + 1)] = commands_by
        acting.append((by_state, inputs))
    held = [acting[age if step >= since else age + 1] for step in range(delays.steps)]
    update = _update_at(derivatives, trim, rate)
    states = _states_of_period(derivatives, trim, update, rates, held)
    injected = np.zeros((size, axes * (waiting + 1)))
    both = [np.hstack([by_input, by_state[:, moving:]]) for by_state, by_input in states]
    injected[:moving] = both[-1]
    if late:
        seen = moving + n * waiting + FILTERED
        injected[seen : seen + STATE] = both[look][:STATE]
    angle = trim.point.yaw_rate * rates.control_period
    for first, vectors in ((0, 4), (STATE, 2)):
        rows = slice(first, first + 3 * vectors)
        injected[rows] = heading_turn(angle, vectors) @ injected[rows]
    old = axes * waiting
    A = np.zeros((size + old, size + old))
    A[:size, :size], A[:size, size:] = model.A, injected[:, axes:]
    A[size + axes :, size:-axes] = np.eye(old - axes)
    B = np.vstack([injected[:, :axes], np.eye(old, axes)])
    newest = slice(moving, moving + n)  # commands after the update are the newest of the states
    C = np.hstack([wrench_by @ model.A[newest], np.zeros((axes, old))])
    names = tuple(
        Signal(f"{signal.name}_{before + 1}_before", signal.unit)
        for before in range(waiting)
        for signal in signals
    )
    return dataclasses.replace(
        model,
        A=A,
        input_matrix=B,
        output_matrix=C,
        feedthrough=np.zeros((axes, axes)),
        states=(*model.states, *names),
        inputs=signals,
        outputs=signals,
    )


def _update_at(derivatives: Derivatives, trim: Trim, rate: float) -> Update:
    return derivatives.update(
        trim.state,
        filtered_of(trim, rate),
        trim.commands,
        reference_of(trim),
        guidance_of(trim),
        trim.memory,
    )


def _states_of_period(
    derivatives: Derivatives,
    trim: Trim,
    update: Update,
    rates: Rates,
    held: list[tuple[np.ndarray, np.ndarray]],
) -> list[tuple[np.ndarray, np.ndarray]]:
    """Return rows of motion, acceleration and speeds by states and inputs at the update.

    They are those before each physics step of a control period, and after the last.

    Args:
        derivatives: of what flies.
        trim: where.
        update: at its beginning.
        rates: of physics and control.
        held: rows of the commands that act in each step, by states and by inputs.
    """
    at, speeds = trim.state, trim.speeds
    since = heading_turn(0.5 * trim.point.yaw_rate * rates.physics_step, 2)
    last = since @ np.concatenate([np.zeros(3), trim.vdot_WB])
    step = derivatives.step(at, last, speeds, update.commands)
    count = step.by.shape[0]
    rows, inputs = np.eye(count, held[0][0].shape[1]), np.zeros((count, held[0][1].shape[1]))
    found = [(rows, inputs)]
    for by_state, by_input in held:
        if len(found) > 1 and not _alike(at, step.state):
            at, last = step.state, step.last
            step = derivatives.step(at, last, speeds, update.commands)
        moving, of_commands = step.by[:, :count], step.by[:, count:]
        rows = moving @ rows + of_commands @ by_state
        inputs = moving @ inputs + of_commands @ by_input
        found.append((rows, inputs))
    return found


def _alike(one: np.ndarray, other: np.ndarray) -> bool:
    """Return whether two states of the body (13) have the same derivatives of a step."""
    turning = [0, 1, 2, 3, 7, 8, 9]
    return bool(np.abs(one[turning] - other[turning]).max() < SAME)


def _states(n: int, waiting: int, late: int) -> tuple[Signal, ...]:
    commands = (
        signal
        for age in range(waiting)
        for signal in numbered("command" if age == 0 else f"command_{age}_before", n, "rad/s")
    )
    seen = (signal for age in range(late) for signal in motion(f"seen_{age + 1}_"))
    return (
        *motion(),
        *accelerations(),
        *numbered("speed", n, "rad/s"),
        *commands,
        *filtered(),
        *seen,
    )
