"""Read a world from a YAML file of our own."""

import math
from collections.abc import Mapping
from pathlib import Path

import numpy as np
from pydrake.math import RigidTransform, RollPitchYaw

from workbench.common.errors import WorkbenchError
from workbench.common.yaml_files import Keys, YamlFile, check_schema, dotted, read_yaml
from workbench.plant.home import Home
from workbench.plant.packages import PackageFinder
from workbench.plant.worlds.directives import read_directives
from workbench.plant.worlds.geometry import collision, solid, visual
from workbench.plant.worlds.tagged import TaggedLoader
from workbench.plant.worlds.world import MovingObstacle, Obstacle, World, first_twice
from workbench.plant.worlds.world_words import (
    HomeWords,
    MovingWords,
    ObstacleWords,
    ShapeWords,
    WorldWords,
    read_colour,
    read_name,
    read_numbers,
    read_shape,
)

MOST_MOVING = 100
SHORTEST = 0.01
"""Time between two rows of a path [s]."""
_SAME = 1e-9
"""Places and angles that differ by less are the same [m, rad]."""


def read_world_yaml(path: Path, packages: Mapping[str, Path | str]) -> World:
    """Return the world of a YAML file.

    Args:
        path: the file.
        packages: folders by name, besides those that are found.

    Raises:
        WorkbenchError: naming file and line of what is wrong.
    """
    file = read_yaml(path, TaggedLoader)
    check_schema(file, WorldWords)
    words = _words(file)
    if len(words.moving) > MOST_MOVING:
        where = file.where("moving")
        raise WorkbenchError(f"{where}moving has more than {MOST_MOVING}: leave some out")
    standing = [
        _obstacle(file, ("obstacles", index), each) for index, each in enumerate(words.obstacles)
    ]
    if words.directives:
        standing += read_directives(file, PackageFinder(path, packages))
    moving = [read_moving(file, ("moving", index), each) for index, each in enumerate(words.moving)]
    world = World(
        source=path,
        name=path.stem,
        title=words.title,
        ground=words.ground,
        obstacles=tuple(standing),
        moving=tuple(moving),
        home=_home(file, words.home),
    )
    twice = first_twice(world.names)
    if twice:
        raise WorkbenchError(f"{path}: two obstacles are called '{twice}': rename one")
    return world


def _words(file: YamlFile) -> WorldWords:
    """Return a file's content, which has the schema, as dataclasses."""
    content = dict(file.data)
    if content.get("home") is not None:
        content["home"] = HomeWords(**content["home"])
    for key, kind in (("obstacles", ObstacleWords), ("moving", MovingWords)):
        content[key] = [
            kind(**(item | {"shape": ShapeWords(**item.get("shape", {}))}))
            for item in content.get(key, [])
        ]
    return WorldWords(**content)


def _obstacle(file: YamlFile, keys: Keys, words: ObstacleWords) -> Obstacle:
    """Return something that stands still."""
    name = read_name(file, keys, words.name)
    shape = read_shape(file, (*keys, "shape"), words.shape)
    colour = read_colour(file, keys, words.color)
    position = read_numbers(file, (*keys, "position"), words.position, 3)
    rpy = read_numbers(file, (*keys, "roll_pitch_yaw"), words.roll_pitch_yaw, 3)
    return Obstacle(
        name=name,
        X_WO=RigidTransform(RollPitchYaw(np.array(rpy)), np.array(position)),
        collisions=(collision(f"{name}::shape", RigidTransform(), shape),),
        visuals=(visual(f"{name}::shape", RigidTransform(), shape, colour),),
    )


def _home(file: YamlFile, words: HomeWords | None) -> Home | None:
    """Return where on the earth the origin is."""
    if words is None:
        return None
    for key, most in (("latitude_deg", 90.0), ("longitude_deg", 180.0), ("elevation", 1e5)):
        value = getattr(words, key)
        if not abs(value) <= most:
            where = file.where("home", key)
            raise WorkbenchError(f"{where}home.{key} is {value!r}: give it one within ±{most:g}")
    latitude, longitude = math.radians(words.latitude_deg), math.radians(words.longitude_deg)
    return Home(latitude, longitude, float(words.elevation))


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
