"""Read the path of a moving obstacle."""

import math

from workbench.common.errors import WorkbenchError
from workbench.common.yaml_files import Keys, YamlFile, dotted
from workbench.plant.worlds.geometry import solid
from workbench.plant.worlds.world import MovingObstacle
from workbench.plant.worlds.world_words import (
    MovingWords,
    read_colour,
    read_name,
    read_numbers,
    read_shape,
)

SHORTEST = 0.01
"""Time between two rows of a path [s]."""
_SAME = 1e-9
"""Places and angles that differ by less are the same [m, rad]."""


def read_moving(file: YamlFile, keys: Keys, words: MovingWords) -> MovingObstacle:
    """Return a moving obstacle.

    Raises:
        WorkbenchError: naming file and line of what makes it none.
    """
    name = read_name(file, keys, words.name)
    shape = read_shape(file, (*keys, "shape"), words.shape)
    colour = read_colour(file, keys, words.color)
    keys = (*keys, "path")
    rows = [read_numbers(file, (*keys, index), row, 4, 5) for index, row in enumerate(words.path)]
    if len(rows) < 2:
        raise _fault(file, keys, "has fewer than two rows: give it rows [t, x, y, z], or with yaw")
    if rows[0][0] != 0.0:
        raise _fault(file, (*keys, 0), "does not begin at time 0: let it")
    for index, (before, row) in enumerate(zip(rows, rows[1:], strict=False), start=1):
        if row[0] - before[0] < SHORTEST:
            reason = f"is at {row[0]:g} s, not {SHORTEST:g} s or more after the row before"
            raise _fault(file, (*keys, index), reason)
    corners = tuple((x, y, z, yaw) for x, y, z, yaw in ((*row[1:], 0.0)[:4] for row in rows))
    if words.repeat and not _alike(corners[0], corners[-1]):
        raise _fault(file, keys, "repeats, but does not end where it begins: let it")
    return MovingObstacle(
        name=name,
        geometry=solid(f"{name}::shape", shape, colour),
        times=tuple(row[0] for row in rows),
        corners=corners,
        repeat=words.repeat,
    )


def _alike(first: tuple[float, ...], last: tuple[float, ...]) -> bool:
    """Return whether two corners are one place, with yaws that look alike."""
    apart = [a - b for a, b in zip(first[:3], last[:3], strict=True)]
    return max(map(abs, (*apart, math.remainder(first[3] - last[3], math.tau)))) < _SAME


def _fault(file: YamlFile, keys: Keys, reason: str) -> WorkbenchError:
    return WorkbenchError(f"{file.where(*keys)}{dotted(keys)} {reason}")
