"""A world as records: obstacles that stand, obstacles that move, and where on the earth it lies."""

from collections.abc import Iterable
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from pydrake.geometry import GeometryInstance
from pydrake.math import RigidTransform, RollPitchYaw

from workbench.common.errors import unknown_name
from workbench.plant.home import Home
from workbench.plant.remarks import Remark
from workbench.plant.worlds.outline import Course

GROUND = "ground"
"""The name of the half space below z = 0, which no obstacle may have."""


@dataclass(frozen=True)
class Obstacle:
    """A rigid thing O that stands still.

    Attributes:
        name: unique in its world; `model::link` where it is a model's.
        X_WO: where it stands.
        collisions: geometries to bump into, named `OBSTACLE::SHAPE`, with poses in O.
        visuals: geometries that are drawn and that sensors see, likewise.
    """

    name: str
    X_WO: RigidTransform
    collisions: tuple[GeometryInstance, ...]
    visuals: tuple[GeometryInstance, ...]


@dataclass(frozen=True)
class MovingObstacle:
    """A shape O that follows a path whatever it meets; it stays upright.

    Attributes:
        name: unique in its world.
        geometry: touchable for signed distances, drawn, and seen by sensors; centred on O.
        times: of the corners of the path [s], from 0 on, growing.
        corners: x, y, z [m] and yaw [rad] at these times; it moves straight and evenly between.
        repeat: whether it begins again at the end, where it is as it began; else it stays there.
    """

    name: str
    geometry: GeometryInstance
    times: tuple[float, ...]
    corners: tuple[tuple[float, float, float, float], ...]
    repeat: bool

    def pose(self, time: float) -> RigidTransform:
        """Return X_WO at a time of the flight [s]."""
        x, y, z, yaw = Course(self.times, self.corners, self.repeat).at(time)
        return RigidTransform(RollPitchYaw(0.0, 0.0, yaw), np.array([x, y, z]))


@dataclass(frozen=True)
class World:
    """What is around the drone, with flat ground at z = 0 unless it says otherwise.

    Attributes:
        source: the file that was read.
        name: the file's, without its ending.
        title: what people call it.
        ground: whether there is ground.
        obstacles: those that stand still.
        moving: those that move.
        home: where on the earth its origin lies, None where it does not say.
        remarks: what was assumed, missing or left unused.
    """

    source: Path
    name: str
    title: str = ""
    ground: bool = True
    obstacles: tuple[Obstacle, ...] = ()
    moving: tuple[MovingObstacle, ...] = ()
    home: Home | None = None
    remarks: tuple[Remark, ...] = ()

    @property
    def names(self) -> tuple[str, ...]:
        """The names of all obstacles; the first are those that stand."""
        return (*(each.name for each in self.obstacles), *(each.name for each in self.moving))

    def pose(self, name: str, time: float) -> RigidTransform:
        """Return X_WO of an obstacle at a time of the flight [s].

        Raises:
            WorkbenchError: if there is none of the name.
        """
        for obstacle in self.obstacles:
            if obstacle.name == name:
                return obstacle.X_WO
        for moving in self.moving:
            if moving.name == name:
                return moving.pose(time)
        raise unknown_name("obstacle", name, self.names)


EMPTY = World(source=Path("empty"), name="empty")
"""Nothing but the ground."""


def obstacle_of(geometry: str) -> str:
    """Return the obstacle that a geometry's name in the scene graph belongs to, or `GROUND`."""
    return geometry.rpartition("::")[0] or geometry


def first_twice(names: Iterable[str]) -> str | None:
    """Return the first name that came before, if one did."""
    seen: set[str] = set()
    for name in names:
        if name in seen:
            return name
        seen.add(name)
    return None
