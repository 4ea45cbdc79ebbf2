"""Read a world from YAML or Gazebo's SDF."""

import math
from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np
from pydrake.math import RigidTransform, RollPitchYaw

from workbench.common.errors import WorkbenchError
from workbench.common.yaml_files import (
    Keys,
    YamlFile,
    as_record,
    check_schema,
    dotted,
    read_yaml,
    tagged_loader,
)
from workbench.plant.formats.values import LARGEST, shortened
from workbench.plant.home import STRONGEST_FIELD, Home, Triple
from workbench.plant.packages import PackageFinder
from workbench.plant.shapes import Box, Capsule, Cylinder, Shape, Sphere
from workbench.plant.worlds.geometry import Colour, collision, solid, visual
from workbench.plant.worlds.outline import Course
from workbench.plant.worlds.world import MovingObstacle, Obstacle, World, first_twice

MOST_SHAPES = 1000
"""Largest number of shapes; a flight is then slower than real time, and its start takes 10 s."""
LONGEST_NAME = 100
_RESERVED = ("ground", "world")
MOST_MOVING = 100
SHORTEST = 0.01
"""Shortest time between two rows of a path [s]."""
_SAME = 1e-9
"""Smallest difference of positions and angles that counts [m, rad]."""


def read_world(path: Path | str, packages: Mapping[str, Path | str] | None = None) -> World:
    """Read a world: a YAML file of our own, or a Gazebo world (.sdf or .world).

    Args:
        path: the file.
        packages: folders of ROS packages and Gazebo models by name, in addition to those found
            near the file and through the environment.

    Raises:
        WorkbenchError: with file and line if known.
    """
    path = Path(path)
    if path.is_dir():
        raise WorkbenchError(f"{path}: is a folder: give the world's file in it")
    if path.suffix in (".yaml", ".yml"):
        world = read_world_yaml(path, packages or {})
    elif path.suffix in (".sdf", ".world"):
        from workbench.plant.worlds.gazebo_world import read_gazebo_world

        world = read_gazebo_world(path, packages or {})
    else:
        raise WorkbenchError(f"{path}: a world is a .yaml file, or a .sdf or .world of Gazebo")
    shapes = sum(max(len(each.visuals), len(each.collisions)) for each in world.obstacles)
    if shapes > MOST_SHAPES:
        raise WorkbenchError(
            f"{path}: has {shapes} shapes, more than {MOST_SHAPES}: leave some out"
        )
    return world


@dataclass
class ShapeWords:
    """One shape: sides of a box, a radius, or radius and length along z; all in m."""

    box: list[float] | None = None
    sphere: float | None = None
    cylinder: list[float] | None = None
    capsule: list[float] | None = None


@dataclass
class ObstacleWords:
    """A static obstacle: a shape at a position [m], with roll, pitch and yaw [rad]."""

    name: str = ""
    shape: ShapeWords = field(default_factory=ShapeWords)
    position: list[float] = field(default_factory=lambda: [0.0, 0.0, 0.0])
    roll_pitch_yaw: list[float] = field(default_factory=lambda: [0.0, 0.0, 0.0])
    color: list[float] | None = None


@dataclass
class MovingWords:
    """A moving obstacle: rows of time [s], x, y, z [m] and optionally yaw [rad]."""

    name: str = ""
    shape: ShapeWords = field(default_factory=ShapeWords)
    path: list[list[float]] = field(default_factory=list)
    repeat: bool = False
    color: list[float] | None = None


@dataclass
class HomeWords:
    """The position of the origin on the earth, in Gazebo's terms: degrees, metres and tesla."""

    latitude_deg: float = 0.0
    longitude_deg: float = 0.0
    elevation: float = 0.0
    magnetic_field: list[float] | None = None


@dataclass
class WorldWords:
    """A world file."""

    title: str = ""
    ground: bool = True
    home: HomeWords | None = None
    directives: list[dict[str, dict[str, object]]] = field(default_factory=list)
    obstacles: list[ObstacleWords] = field(default_factory=list)
    moving: list[MovingWords] = field(default_factory=list)


def read_name(file: YamlFile, keys: Keys, name: str) -> str:
    """Return the name of an obstacle.

    Raises:
        WorkbenchError: if it is invalid.
    """
    if not name:
        raise WorkbenchError(f"{file.where(*keys)}{dotted(keys)} has no name: add one")
    if name in _RESERVED:
        raise _fault(file, (*keys, "name"), f"is '{name}', which is not an obstacle's: rename it")
    if len(name) > LONGEST_NAME or not name.isprintable():
        text = shortened(ascii(name)[1:-1])
        reason = f"is '{text}': give it up to {LONGEST_NAME} printable characters"
        raise _fault(file, (*keys, "name"), reason)
    return name


def read_shape(file: YamlFile, keys: Keys, words: ShapeWords) -> Shape:
    """Return a shape.

    Raises:
        WorkbenchError: if there is none or several, or a size is not positive.
    """
    given = [kind for kind, value in vars(words).items() if value is not None]
    if len(given) != 1:
        found = f"has {' and '.join(given)}" if given else "is missing"
        reason = f"{found}: give one of {', '.join(vars(words))}"
        raise _fault(file, keys, reason)
    keys = (*keys, given[0])
    if words.box is not None:
        x, y, z = _positive(file, keys, words.box, 3)
        return Box((x, y, z))
    if words.sphere is not None:
        return Sphere(*_positive(file, keys, [words.sphere], 1))
    if words.cylinder is not None:
        return Cylinder(*_positive(file, keys, words.cylinder, 2))
    assert words.capsule is not None
    return Capsule(*_positive(file, keys, words.capsule, 2))


def read_colour(file: YamlFile, keys: Keys, color: list[float] | None) -> Colour | None:
    """Return red, green, blue and opacity, or None without a colour.

    Raises:
        WorkbenchError: if it is not three or four numbers 0 .. 1.
    """
    if color is None:
        return None
    if len(color) not in (3, 4) or not all(0.0 <= number <= 1.0 for number in color):
        raise _fault(file, (*keys, "color"), f"is {color}: give three or four numbers 0 .. 1")
    red, green, blue, alpha = (*map(float, color), 1.0)[:4]
    return (red, green, blue, alpha)


def read_numbers(file: YamlFile, keys: Keys, numbers: list[float], *counts: int) -> list[float]:
    """Return numbers as floats.

    Raises:
        WorkbenchError: if their number is none of `counts`, or one is not finite or too large.
    """
    if len(numbers) not in counts or not all(abs(number) <= LARGEST for number in numbers):
        wanted = " or ".join(map(str, counts))
        many = "number" if counts == (1,) else "numbers"
        raise _fault(file, keys, f"is {numbers}: give it {wanted} {many} within ±{LARGEST:g}")
    return [float(number) for number in numbers]


def _positive(file: YamlFile, keys: Keys, sizes: list[float], count: int) -> list[float]:
    found = read_numbers(file, keys, sizes, count)
    if min(found) <= 0.0:
        raise _fault(file, keys, f"is {sizes}: give it sizes above 0")
    return found


def read_world_yaml(path: Path, packages: Mapping[str, Path | str]) -> World:
    """Return the world in a YAML file.

    Args:
        path: the file.
        packages: folders by name, in addition to those that are found.

    Raises:
        WorkbenchError: naming file and line, for invalid content.
    """
    file = read_yaml(path, tagged_loader())
    check_schema(file, WorldWords)
    words: WorldWords = as_record(file.data, WorldWords)
    if len(words.moving) > MOST_MOVING:
        where = file.where("moving")
        raise WorkbenchError(f"{where}moving has more than {MOST_MOVING}: leave some out")
    standing = [
        _obstacle(file, ("obstacles", index), each) for index, each in enumerate(words.obstacles)
    ]
    if words.directives:
        from workbench.plant.worlds.directives import read_directives  # slow to load

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
        raise WorkbenchError(f"{path}: two obstacles have the name '{twice}': rename one")
    return world


def _obstacle(file: YamlFile, keys: Keys, words: ObstacleWords) -> Obstacle:
    """Return a static obstacle."""
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
    """Return the position of the origin on the earth."""
    if words is None:
        return None
    for key, most in (("latitude_deg", 90.0), ("longitude_deg", 180.0), ("elevation", 1e5)):
        value = getattr(words, key)
        if not abs(value) <= most:
            where = file.where("home", key)
            raise WorkbenchError(f"{where}home.{key} is {value!r}: give it one within ±{most:g}")
    latitude, longitude = math.radians(words.latitude_deg), math.radians(words.longitude_deg)
    field = words.magnetic_field
    return Home(
        latitude,
        longitude,
        float(words.elevation),
        None if field is None else _magnetic_field(file, field),
    )


def _magnetic_field(file: YamlFile, numbers: list[float]) -> Triple:
    """Return the magnetic field of a home: east, north and up [T]."""
    keys = ("home", "magnetic_field")
    east, north, up = read_numbers(file, keys, numbers, 3)
    if max(abs(east), abs(north), abs(up)) > STRONGEST_FIELD:
        reason = f"is {numbers}: give it in tesla, within ±{STRONGEST_FIELD:g}"
        raise _fault(file, keys, reason)
    return (east, north, up)


def read_moving(file: YamlFile, keys: Keys, words: MovingWords) -> MovingObstacle:
    """Return a moving obstacle.

    Raises:
        WorkbenchError: naming file and line, for invalid content.
    """
    name = read_name(file, keys, words.name)
    shape = read_shape(file, (*keys, "shape"), words.shape)
    colour = read_colour(file, keys, words.color)
    keys = (*keys, "path")
    rows = [read_numbers(file, (*keys, index), row, 4, 5) for index, row in enumerate(words.path)]
    if len(rows) < 2:
        raise _fault(file, keys, "has fewer than two rows: give it rows [t, x, y, z], or with yaw")
    if rows[0][0] != 0.0:
        raise _fault(file, (*keys, 0), "does not begin at time 0: add a row at 0")
    for index, (before, row) in enumerate(zip(rows, rows[1:], strict=False), start=1):
        if row[0] - before[0] < SHORTEST:
            reason = f"is at {row[0]:g} s, not {SHORTEST:g} s or more after the row before"
            raise _fault(file, (*keys, index), reason)
    corners = tuple((x, y, z, yaw) for x, y, z, yaw in ((*row[1:], 0.0)[:4] for row in rows))
    if words.repeat and not _alike(corners[0], corners[-1]):
        raise _fault(file, keys, "repeats, but does not end where it begins: end it there")
    return MovingObstacle(
        name=name,
        geometry=solid(f"{name}::shape", shape, colour),
        course=Course(tuple(row[0] for row in rows), corners, words.repeat),
    )


def _alike(first: tuple[float, ...], last: tuple[float, ...]) -> bool:
    """Return whether two corners have the same position and equivalent yaws."""
    apart = [a - b for a, b in zip(first[:3], last[:3], strict=True)]
    return max(map(abs, (*apart, math.remainder(first[3] - last[3], math.tau)))) < _SAME


def _fault(file: YamlFile, keys: Keys, reason: str) -> WorkbenchError:
    return WorkbenchError(f"{file.where(*keys)}{dotted(keys)} {reason}")
