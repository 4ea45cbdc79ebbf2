"""The command of a round as a line with upright edges."""

import numpy as np

from workbench.gui.tuning.rounds import step_parts
from workbench.scenario.excitation import Excitation, Shape

POINTS = 400
"""Of a chirp."""


def command_line(excitation: Excitation, *, again: bool = False) -> tuple[np.ndarray, np.ndarray]:
    """Return times from the edge on [s] and values of what a round asks for.

    Args:
        excitation: what is flown.
        again: whether a round of the same was flown just before.
    """
    length = excitation.round_time
    if excitation.shape is Shape.CHIRP:
        time = np.linspace(0.0, length, POINTS, endpoint=False)
        return time, np.array([excitation.command(float(each)) for each in time])
    times, values = [0.0], [0.0]
    parts = step_parts(excitation, again=again)
    values[0] = parts[0].before
    for part in parts:
        times += [part.begin, part.end]
        values += [part.level, part.level]
    if parts[-1].end < length:
        times += [parts[-1].end, length]
        values += [0.0, 0.0]
    return np.array(times), np.array(values)
