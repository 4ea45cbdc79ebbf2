"""The linear model of a control update, also of a law with parts that run in every n-th one.

Between two runs of such a part (`DIVIDERS` of a controller file) its outputs are held. On average
over the n updates in which it may run, what the rest of the law reads is the mean of what the part
returns in the last n updates, and what a run changes by d changes by d / n in each update. So the
model has the phase that the hold costs. It leaves out the aliases of the part's sampling.

Source: the zeroth harmonic of a linear system that varies periodically.
"""

import math
from collections.abc import Callable, Iterable
from dataclasses import dataclass

import numpy as np


@dataclass(frozen=True)
class ControlUpdate:
    """A control update: commands of the rotors, and derivatives.

    Columns are the state seen by the law (12), the states of the stages before the law (10), the
    previous commands (n), commanded velocity and yaw rate (4), position held (3), injections (one
    for each loop point), the memory of the law (k), and what slow parts returned earlier (h).

    Attributes:
        commands: of the rotors (n) [rad/s].
        commands_by: their derivatives.
        filtered_by: of the states of the stages before the law, after the update.
        memory: of the law after the update (k).
        memory_by: derivatives of the memory, and of what slow parts returned earlier (k + h).
        signals_by: of the signals at loop points.
        earlier: for each of what slow parts returned earlier, its place in the memory, and how many
            updates ago (h).
    """

    commands: np.ndarray
    commands_by: np.ndarray
    filtered_by: np.ndarray
    memory: np.ndarray
    memory_by: np.ndarray
    signals_by: np.ndarray
    earlier: tuple[tuple[int, int], ...] = ()


def averaged_update(
    updated: Callable[[float], ControlUpdate], dividers: Iterable[int]
) -> ControlUpdate:
    """Return an update of a law with slow parts, as it is on average.

    Args:
        updated: returns the update after a number of others, with the parts that run in that one.
        dividers: of the parts.
    """
    slowest_first = sorted({n for n in dividers if n > 1}, reverse=True)
    whole = updated(float(math.lcm(*slowest_first)))
    n, k = len(whole.commands_by), len(whole.memory)
    memory = slice(n + len(whole.filtered_by), n + len(whole.filtered_by) + k)
    rows = _update_rows(whole)
    first = rows.shape[1] - k
    before = np.eye(k, rows.shape[1], first)
    older = rows[:0]
    earlier: list[tuple[int, int]] = []
    slower = np.zeros(k, dtype=bool)
    for divider in slowest_first:
        # an update in which quicker parts run, but not this one nor slower ones
        runs = math.lcm(*(each for each in slowest_first if each < divider))
        without = _update_rows(updated(float(runs if runs % divider else 1)))
        held = (without[memory, first:] == np.eye(k)).all(axis=1) & ~slower
        held &= ~without[memory, :first].any(axis=1)
        slower |= held
        others = np.ones(len(rows), dtype=bool)
        others[memory] = ~held
        is_read = without[others, first:].any(axis=0)
        outputs, states = np.flatnonzero(held & is_read), np.flatnonzero(held & ~is_read)

        # columns of what the part returned two and more updates ago; one ago is in the memory
        shape = divider - 2, len(outputs)
        rows, before, older = (
            np.pad(each, ((0, 0), (0, math.prod(shape)))) for each in (rows, before, older)
        )
        columns = rows.shape[1]
        ago = np.eye(math.prod(shape), columns, columns - math.prod(shape))
        past = np.concatenate([before[None, outputs], ago.reshape(*shape, columns)])
        older = np.vstack([older, past[:-1].reshape(-1, columns)])
        earlier += [(int(place), age) for age in range(2, divider) for place in outputs]

        new = rows[memory][outputs]
        mean = (new + past.sum(axis=0)) / divider
        rows[others] += without[others][:, first + outputs] @ (mean - new)
        changed = memory.start + states
        rows[changed] = before[states] + (rows[changed] - before[states]) / divider
    return ControlUpdate(
        commands=whole.commands,
        commands_by=rows[:n],
        filtered_by=rows[n : memory.start],
        memory=whole.memory,
        memory_by=np.vstack([rows[memory], older]),
        signals_by=rows[memory.stop :],
        earlier=tuple(earlier),
    )


def _update_rows(update: ControlUpdate) -> np.ndarray:
    """Return the rows of an update, one below the other."""
    return np.vstack([update.commands_by, update.filtered_by, update.memory_by, update.signals_by])
