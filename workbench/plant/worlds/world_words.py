"""The keys of a world file, as dataclasses that are its schema, and its plain values checked."""

from dataclasses import dataclass, field

from workbench.common.errors import WorkbenchError
from workbench.common.yaml_files import Keys, YamlFile, dotted
from workbench.plant.formats.values import LARGEST, shortened
from workbench.plant.shapes import Box, Capsule, Cylinder, Shape, Sphere
from workbench.plant.worlds.geometry import Colour

LONGEST_NAME = 100
_RESERVED = ("ground", "world")


@dataclass
class ShapeWords:
    """One shape: sides of a box; a radius; radius and length, along z; all in m."""

    box: list[float] | None = None
    sphere: float | None = None
    cylinder: list[float] | None = None
    capsule: list[float] | None = None


@dataclass
class ObstacleWords:
    """Something that stands still: a shape at a position [m], with roll, pitch and yaw [rad]."""

    name: str = ""
    shape: ShapeWords = field(default_factory=ShapeWords)
    position: list[float] = field(default_factory=lambda: [0.0, 0.0, 0.0])
    roll_pitch_yaw: list[float] = field(default_factory=lambda: [0.0, 0.0, 0.0])
    color: list[float] | None = None


@dataclass
class MovingWords:
    """Something that moves: rows of time [s], x, y, z [m] and perhaps yaw [rad]."""

    name: str = ""
    shape: ShapeWords = field(default_factory=ShapeWords)
    path: list[list[float]] = field(default_factory=list)
    repeat: bool = False
    color: list[float] | None = None


@dataclass
class HomeWords:
    """Where the origin is on the earth, in the words of Gazebo: degrees, and metres."""

    latitude_deg: float = 0.0
    longitude_deg: float = 0.0
    elevation: float = 0.0


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
        WorkbenchError: if it cannot be one.
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
        WorkbenchError: if it is not one, or a size is not positive.
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
    """Return red, green, blue and opacity, None where no colour is given.

    Raises:
        WorkbenchError: if it has not three or four numbers 0 .. 1.
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
        WorkbenchError: if there are more or fewer than one of `counts`, or one is not finite or of
            absurd size.
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


def _fault(file: YamlFile, keys: Keys, reason: str) -> WorkbenchError:
    return WorkbenchError(f"{file.where(*keys)}{dotted(keys)} {reason}")
