"""A description as records, independent of its file format: links, joints, shapes, poses.

Frames: M of the model, L of a link, J of a joint, S of a shape or a sensor, I of an inertia. Poses
of links and joints are given in M, with all joints at zero.
"""

from dataclasses import dataclass
from pathlib import Path

import numpy as np
from pydrake.math import RigidTransform

from workbench.common.errors import WorkbenchError
from workbench.common.plain_text import plain_name
from workbench.plant.formats.xml import Element
from workbench.plant.shapes import Mesh, Shape

MOST_LINKS = 500
MOST_SHAPES = 1000
"""Limit of the number of visuals and collisions together."""
MOST_COLLISIONS = 300
"""Limit of the number of collisions: Drake takes time and memory for each two of them."""

LONGEST_NAME = 1000
"""Longest name of a link, joint or frame: one of 100,000 characters ends Drake's parser, and
with it the process."""


def refuse_too_many(source: Path, links: int, shapes: int, collisions: int) -> None:
    """Reject a description with too many parts, before any time is spent on them.

    Raises:
        WorkbenchError: naming the file.
    """
    for count, most, what in (
        (links, MOST_LINKS, "links"),
        (shapes, MOST_SHAPES, "shapes"),
        (collisions, MOST_COLLISIONS, "collision shapes"),
    ):
        if count > most:
            raise WorkbenchError(
                f"{source}: it has {count} {what}, more than {most}: give the file of one drone"
            )


@dataclass(frozen=True)
class Inertial:
    """Mass [kg], and moments of inertia about the centre of mass in I [kg·m²].

    Attributes:
        mass: of the link.
        X_LI: I's origin is the centre of mass.
        moments: ixx, iyy, izz.
        products: ixy, ixz, iyz.
    """

    mass: float
    X_LI: RigidTransform
    moments: tuple[float, float, float]
    products: tuple[float, float, float]

    @property
    def matrix(self) -> np.ndarray:
        """Moments and products of inertia (3, 3) [kg·m²]."""
        (xx, yy, zz), (xy, xz, yz) = self.moments, self.products
        return np.array([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]])


def inertial_of(mass: float, X_LI: RigidTransform, matrix: np.ndarray) -> Inertial:
    """Return mass and inertia with moments and products of inertia in a matrix (3, 3) [kg·m²]."""
    (xx, xy, xz), (_, yy, yz), (_, _, zz) = matrix.tolist()
    return Inertial(mass, X_LI, (xx, yy, zz), (xy, xz, yz))


@dataclass(frozen=True)
class LinkShape:
    """A visual or collision shape on its link.

    Attributes:
        name: of the visual or collision.
        X_LS: its pose.
        shape: in its own frame.
        rgba: colour of a visual, 0 .. 1; None if the description states none.
    """

    name: str
    X_LS: RigidTransform
    shape: Shape
    rgba: tuple[float, float, float, float] | None = None

    @property
    def is_missing(self) -> bool:
        """Whether it is a mesh whose file was not found."""
        return isinstance(self.shape, Mesh) and self.shape.path is None


@dataclass(frozen=True)
class Link:
    """A rigid body; without an inertial it is a frame with shapes."""

    name: str
    X_ML: RigidTransform
    inertial: Inertial | None
    visuals: tuple[LinkShape, ...]
    collisions: tuple[LinkShape, ...]

    @property
    def shapes(self) -> tuple[LinkShape, ...]:
        """All shapes, visuals first."""
        return (*self.visuals, *self.collisions)


@dataclass(frozen=True)
class Joint:
    """The joint between a child link and its parent.

    Attributes:
        name: of the joint.
        kind: as in the description: fixed, continuous, revolute, prismatic, ...
        parent: link name, or `world`.
        child: link name.
        X_MJ: pose of the joint frame.
        axis_J: unit vector of rotation or translation; z if there is none.
    """

    name: str
    kind: str
    parent: str
    child: str
    X_MJ: RigidTransform
    axis_J: tuple[float, float, float]


MOVING = ("ball",)
"""Kinds of joints that move in flight; the links of all others fly as if welded."""


@dataclass(frozen=True)
class NamedFrame:
    """An SDF `<frame>`, or a URDF link that Gazebo keeps as a frame: F fixed to a link."""

    name: str
    link: str
    X_LF: RigidTransform


@dataclass(frozen=True)
class DeclaredSensor:
    """A `<sensor>` element in SDF's terms, for every format, and its mounting."""

    link: str
    X_LS: RigidTransform
    element: Element


@dataclass(frozen=True)
class DeclaredActuator:
    """An actuator of MJCF at a site S of a link.

    Attributes:
        name: of the actuator.
        link: the one it acts on.
        X_LS: pose of the site.
        force_S: force on the link per unit of gain times control plus bias.
        moment_S: moment on the link per unit of it.
        least: the least gain times control plus bias, -inf without a limit.
        most: the largest, inf without a limit.
        time_constant: of a first-order filter at its input [s], None without a filter.
    """

    name: str
    link: str
    X_LS: RigidTransform
    force_S: tuple[float, float, float]
    moment_S: tuple[float, float, float]
    least: float
    most: float
    time_constant: float | None


@dataclass(frozen=True)
class Model:
    """The content of a description file, before interpretation.

    Attributes:
        source: the requested file.
        name: the robot's or model's name.
        links: in file order.
        joints: in file order.
        frames: SDF frames.
        sensors: all `<sensor>` elements.
        plugins: all `<plugin>` elements of the model (not of sensors or the world).
        actuators: those of MJCF that apply a force or moment at a site.
        properties: the attributes of gym-pybullet-drones' `<properties>` tag, or empty.
    """

    source: Path
    name: str
    links: tuple[Link, ...]
    joints: tuple[Joint, ...]
    frames: tuple[NamedFrame, ...]
    sensors: tuple[DeclaredSensor, ...]
    plugins: tuple[Element, ...]
    properties: tuple[tuple[str, str], ...] = ()
    actuators: tuple[DeclaredActuator, ...] = ()

    def refuse_long_names(self) -> None:
        """Reject names that Drake cannot read.

        Raises:
            WorkbenchError: naming the file and the part.
        """
        shapes = [shape for link in self.links for shape in link.shapes]
        for kind, parts in (
            ("link", self.links),
            ("joint", self.joints),
            ("frame", self.frames),
            ("shape", shapes),
        ):
            for name in (part.name for part in parts):
                if len(name) > LONGEST_NAME:
                    raise WorkbenchError(
                        f"{self.source}: the name of {kind} '{plain_name(name)}' is longer than "
                        f"{LONGEST_NAME:,} characters: shorten it"
                    )

    def link(self, name: str) -> Link | None:
        """Return the link with a name, or None."""
        return next((link for link in self.links if link.name == name), None)

    def joint(self, name: str) -> Joint | None:
        """Return the joint with a name, or None."""
        return next((joint for joint in self.joints if joint.name == name), None)

    def joint_of(self, child: str) -> Joint | None:
        """Return the joint to the parent of a link, or None."""
        return next((joint for joint in self.joints if joint.child == child), None)
