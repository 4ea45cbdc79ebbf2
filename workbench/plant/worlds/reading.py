"""Read a world from YAML, or from a format that an installed package adds."""

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
from workbench.plant.formats.values import MAX_URDF_NUMBER, shortened_text
from workbench.plant.home import MAX_FIELD_T, Home, WorldVector
from workbench.plant.packages import PackageFinder
from workbench.plant.readers import WorldFormat, missing_reader, world_formats
from workbench.plant.shapes import Box, Capsule, Cylinder, GeometryShape, Sphere
from workbench.plant.worlds.geometry import ObstacleRgba, collision, solid_geometry, visual
from workbench.plant.worlds.outline import ObstaclePath
from workbench.plant.worlds.world import MovingObstacle, StaticObstacle, World, first_duplicate

MAX_WORLD_SHAPES = 1000
"""Largest number of shapes; a flight is then slower than real time, and its start takes 10 s."""
MAX_OBSTACLE_NAME_CHARS = 100
_GAZEBO_SUFFIXES = (".sdf", ".world")
_RESERVED_NAMES = ("ground", "world")
MAX_MOVING_OBSTACLES = 100
MIN_PATH_STEP_S = 0.01
"""Shortest time between two rows of a path [s]."""
_POSE_TOLERANCE = 1e-9
"""Smallest difference of positions and angles that counts [m, rad]."""


def read_world(path: Path | str, packages: Mapping[str, Path | str] | None = None) -> World:
    """Read a world: a YAML file of our own, or one that an installed package reads, as Gazebo's.

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
    else:
        world = _added_format(path).read(path, packages or {})
    shapes = sum(max(len(each.visuals), len(each.collisions)) for each in world.obstacles)
    if shapes > MAX_WORLD_SHAPES:
        raise WorkbenchError(
            f"{path}: has {shapes} shapes, more than {MAX_WORLD_SHAPES}: leave some out"
        )
    return world


def _added_format(path: Path) -> WorldFormat:
    """Return the format of a world that is not YAML.

    Raises:
        WorkbenchError: if no installed package reads it.
    """
    formats = world_formats()
    for each in formats:
        if path.suffix in each.suffixes:
            return each
    if path.suffix in _GAZEBO_SUFFIXES:
        raise missing_reader(path, "a world of Gazebo")
    others = "".join(f", or a {' or '.join(each.suffixes)} of {each.owner}" for each in formats)
    raise WorkbenchError(f"{path}: a world is a .yaml file{others}")


@dataclass
class ShapeEntry:
    """One shape: sides of a box, a radius, or radius and length along z; all in m."""

    box: list[float] | None = None
    sphere: float | None = None
    cylinder: list[float] | None = None
    capsule: list[float] | None = None


@dataclass
class ObstacleEntry:
    """A static obstacle: a shape at a position [m], with roll, pitch and yaw [rad]."""

    name: str = ""
    shape: ShapeEntry = field(default_factory=ShapeEntry)
    position: list[float] = field(default_factory=lambda: [0.0, 0.0, 0.0])
    roll_pitch_yaw: list[float] = field(default_factory=lambda: [0.0, 0.0, 0.0])
    color: list[float] | None = None


@dataclass
class MovingObstacleEntry:
    """A moving obstacle: rows of time [s], x, y, z [m] and optionally yaw [rad]."""

    name: str = ""
    shape: ShapeEntry = field(default_factory=ShapeEntry)
    path: list[list[float]] = field(default_factory=list)
    repeat: bool = False
    color: list[float] | None = None


@dataclass
class HomeEntry:
    """The position of the origin on the earth, in Gazebo's terms: degrees, metres and tesla."""

    latitude_deg: float = 0.0
    longitude_deg: float = 0.0
    elevation: float = 0.0
    magnetic_field: list[float] | None = None


@dataclass
class WorldEntry:
    """A world file."""

    title: str = ""
    ground: bool = True
    home: HomeEntry | None = None
    directives: list[dict[str, dict[str, object]]] = field(default_factory=list)
    obstacles: list[ObstacleEntry] = field(default_factory=list)
    moving: list[MovingObstacleEntry] = field(default_factory=list)


def read_name(file: YamlFile, keys: Keys, name: str) -> str:
    """Return the name of an obstacle.

    Raises:
        WorkbenchError: if it is invalid.
    """
    if not name:
        raise WorkbenchError(f"{file.where(*keys)}{dotted(keys)} has no name: add one")
    if name in _RESERVED_NAMES:
        raise _world_error(
            file, (*keys, "name"), f"is '{name}', which is not an obstacle's: rename it"
        )
    if len(name) > MAX_OBSTACLE_NAME_CHARS or not name.isprintable():
        text = shortened_text(ascii(name)[1:-1])
        reason = f"is '{text}': give it up to {MAX_OBSTACLE_NAME_CHARS} printable characters"
        raise _world_error(file, (*keys, "name"), reason)
    return name


def read_shape(file: YamlFile, keys: Keys, words: ShapeEntry) -> GeometryShape:
    """Return a shape.

    Raises:
        WorkbenchError: if there is none or several, or a size is not positive.
    """
    given = [kind for kind, value in vars(words).items() if value is not None]
    if len(given) != 1:
        found = f"has {' and '.join(given)}" if given else "is missing"
        reason = f"{found}: give one of {', '.join(vars(words))}"
        raise _world_error(file, keys, reason)
    keys = (*keys, given[0])
    if words.box is not None:
        x, y, z = _positive_sizes(file, keys, words.box, 3)
        return Box((x, y, z))
    if words.sphere is not None:
        return Sphere(*_positive_sizes(file, keys, [words.sphere], 1))
    if words.cylinder is not None:
        return Cylinder(*_positive_sizes(file, keys, words.cylinder, 2))
    assert words.capsule is not None
    return Capsule(*_positive_sizes(file, keys, words.capsule, 2))


def read_colour(file: YamlFile, keys: Keys, color: list[float] | None) -> ObstacleRgba | None:
    """Return red, green, blue and opacity, or None without a colour.

    Raises:
        WorkbenchError: if it is not three or four numbers 0 .. 1.
    """
    if color is None:
        return None
    if len(color) not in (3, 4) or not all(0.0 <= number <= 1.0 for number in color):
        raise _world_error(file, (*keys, "color"), f"is {color}: give three or four numbers 0 .. 1")
    red, green, blue, alpha = (*map(float, color), 1.0)[:4]
    return (red, green, blue, alpha)


def read_numbers(file: YamlFile, keys: Keys, numbers: list[float], *counts: int) -> list[float]:
    """Return numbers as floats.

    Raises:
        WorkbenchError: if their number is none of `counts`, or one is not finite or too large.
    """
    if len(numbers) not in counts or not all(abs(number) <= MAX_URDF_NUMBER for number in numbers):
        wanted = " or ".join(map(str, counts))
        many = "number" if counts == (1,) else "numbers"
        raise _world_error(
            file, keys, f"is {numbers}: give it {wanted} {many} within ±{MAX_URDF_NUMBER:g}"
        )
    return [float(number) for number in numbers]


def _positive_sizes(file: YamlFile, keys: Keys, sizes: list[float], count: int) -> list[float]:
    found = read_numbers(file, keys, sizes, count)
    if min(found) <= 0.0:
        raise _world_error(file, keys, f"is {sizes}: give it sizes above 0")
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
    check_schema(file, WorldEntry)
    words: WorldEntry = as_record(file.data, WorldEntry)
    if len(words.moving) > MAX_MOVING_OBSTACLES:
        where = file.where("moving")
        raise WorkbenchError(f"{where}moving has more than {MAX_MOVING_OBSTACLES}: leave some out")
    standing = [
        _read_obstacle(file, ("obstacles", index), each)
        for index, each in enumerate(words.obstacles)
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
        home=_read_home(file, words.home),
    )
    twice = first_duplicate(world.names)
    if twice:
        raise WorkbenchError(f"{path}: two obstacles have the name '{twice}': rename one")
    return world


def _read_obstacle(file: YamlFile, keys: Keys, words: ObstacleEntry) -> StaticObstacle:
    """Return a static obstacle."""
    name = read_name(file, keys, words.name)
    shape = read_shape(file, (*keys, "shape"), words.shape)
    colour = read_colour(file, keys, words.color)
    position = read_numbers(file, (*keys, "position"), words.position, 3)
    rpy = read_numbers(file, (*keys, "roll_pitch_yaw"), words.roll_pitch_yaw, 3)
    return StaticObstacle(
        name=name,
        X_WO=RigidTransform(RollPitchYaw(np.array(rpy)), np.array(position)),
        collisions=(collision(f"{name}::shape", RigidTransform(), shape),),
        visuals=(visual(f"{name}::shape", RigidTransform(), shape, colour),),
    )


def _read_home(file: YamlFile, words: HomeEntry | None) -> Home | None:
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
        None if field is None else _read_magnetic_field(file, field),
    )


def _read_magnetic_field(file: YamlFile, numbers: list[float]) -> WorldVector:
    """Return the magnetic field of a home: east, north and up [T]."""
    keys = ("home", "magnetic_field")
    east, north, up = read_numbers(file, keys, numbers, 3)
    if max(abs(east), abs(north), abs(up)) > MAX_FIELD_T:
        reason = f"is {numbers}: give it in tesla, within ±{MAX_FIELD_T:g}"
        raise _world_error(file, keys, reason)
    return (east, north, up)


def read_moving(file: YamlFile, keys: Keys, words: MovingObstacleEntry) -> MovingObstacle:
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
        raise _world_error(
            file, keys, "has fewer than two rows: give it rows [t, x, y, z], or with yaw"
        )
    if rows[0][0] != 0.0:
        raise _world_error(file, (*keys, 0), "does not begin at time 0: add a row at 0")
    for index, (before, row) in enumerate(zip(rows, rows[1:], strict=False), start=1):
        if row[0] - before[0] < MIN_PATH_STEP_S:
            reason = f"is at {row[0]:g} s, not {MIN_PATH_STEP_S:g} s or more after the row before"
            raise _world_error(file, (*keys, index), reason)
    corners = tuple((x, y, z, yaw) for x, y, z, yaw in ((*row[1:], 0.0)[:4] for row in rows))
    if words.repeat and not _same_corner(corners[0], corners[-1]):
        raise _world_error(file, keys, "repeats, but does not end where it begins: end it there")
    return MovingObstacle(
        name=name,
        geometry=solid_geometry(f"{name}::shape", shape, colour),
        course=ObstaclePath(tuple(row[0] for row in rows), corners, words.repeat),
    )


def _same_corner(first: tuple[float, ...], last: tuple[float, ...]) -> bool:
    """Return whether two corners have the same position and equivalent yaws."""
    apart = [a - b for a, b in zip(first[:3], last[:3], strict=True)]
    return max(map(abs, (*apart, math.remainder(first[3] - last[3], math.tau)))) < _POSE_TOLERANCE


def _world_error(file: YamlFile, keys: Keys, reason: str) -> WorkbenchError:
    return WorkbenchError(f"{file.where(*keys)}{dotted(keys)} {reason}")
