"""A description as records, independent of its file format: links, joints, shapes, poses.

Frames: M of the model, L of a link, J of a joint, S of a shape or a sensor, I of an inertia. Poses
of links and joints are given in M, with all joints at zero.
"""

import math
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
from pydrake.math import RigidTransform

from workbench.common.errors import WorkbenchError
from workbench.common.plain_text import plain_name
from workbench.plant.formats.xml import Element
from workbench.plant.servo import Servo
from workbench.plant.shapes import GeometryShape, Mesh

MAX_MODEL_LINKS = 500
MAX_MODEL_SHAPES = 1000
"""Limit of the number of visuals and collisions together."""
MAX_MODEL_COLLISIONS = 300
"""Limit of the number of collisions: Drake takes time and memory for each two of them."""

MAX_PART_NAME_CHARS = 1000
"""Longest name of a link, joint or frame: one of 100,000 characters ends Drake's parser, and
with it the process."""


def refuse_too_many(source: Path, links: int, shapes: int, collisions: int) -> None:
    """Reject a description with too many parts, before any time is spent on them.

    Raises:
        WorkbenchError: naming the file.
    """
    for count, most, what in (
        (links, MAX_MODEL_LINKS, "links"),
        (shapes, MAX_MODEL_SHAPES, "shapes"),
        (collisions, MAX_MODEL_COLLISIONS, "collision shapes"),
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
    shape: GeometryShape
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
class Freedom:
    """One axis of a joint that moves, all three of a ball, or all six of what flies freely.

    Attributes:
        kind: `revolute`, `prismatic`, `ball` or `free`.
        axis_J: unit vector of rotation or translation in the joint frame, if it has one axis.
        p_J: a point of the axis [m].
        lower: least position [rad or m], -inf without a limit; it does not limit a ball.
        upper: largest position, inf without a limit; of a ball the largest angle from its start.
        damping: torque or force over velocity [N m s/rad or N s/m].
        friction: dry friction [N m or N].
        stiffness: of its spring [N m/rad or N/m].
        rest: position at which the spring has no force [rad or m].
        armature: inertia that turns with the joint's motor [kg m² or kg].
        start: position at which a flight begins [rad or m].
        name: of its own, "" for that of its joint.
        effort: largest of what may drive it [N m or N].
        speed: likewise [rad/s or m/s].
        servo: what drives it, None if nothing does.
    """

    kind: str
    axis_J: tuple[float, float, float] = (0.0, 0.0, 1.0)
    p_J: tuple[float, float, float] = (0.0, 0.0, 0.0)
    lower: float = -math.inf
    upper: float = math.inf
    damping: float = 0.0
    friction: float = 0.0
    stiffness: float = 0.0
    rest: float = 0.0
    armature: float = 0.0
    start: float = 0.0
    name: str = ""
    effort: float = math.inf
    speed: float = math.inf
    servo: Servo | None = None

    @property
    def count(self) -> int:
        """Number of its velocities."""
        return {"ball": 3, "free": 6}.get(self.kind, 1)


FREE_JOINT_KIND = "floating"
"""Kind of a joint that ties its child to nothing."""
FREE_FREEDOMS = (Freedom("free"),)
"""Freedoms of a link that flies freely, relative to its parent."""


@dataclass(frozen=True)
class Mimic:
    """A joint's position: multiplier times that of another joint, plus an offset [rad or m].

    Attributes:
        joint: the other one, or one of its freedoms.
        multiplier: of its position.
        offset: [rad or m].
        axis: which of several freedoms it is, if the joint is named.
    """

    joint: str
    multiplier: float = 1.0
    offset: float = 0.0
    axis: int = 0


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
        freedoms: in which it moves, from the parent on; none if it is held.
        mimic: the joint that it follows, if any.
    """

    name: str
    kind: str
    parent: str
    child: str
    X_MJ: RigidTransform
    axis_J: tuple[float, float, float]
    freedoms: tuple[Freedom, ...] = ()
    mimic: Mimic | None = None
    turned_round: bool = False

    @property
    def moves(self) -> bool:
        """Whether it moves in flight."""
        return bool(self.freedoms)

    @property
    def is_free(self) -> bool:
        """Whether its child flies freely, and hangs on a cable."""
        return self.moves and self.kind == FREE_JOINT_KIND

    @property
    def freedom_names(self) -> tuple[str, ...]:
        """A name for each of its freedoms: its own if it has one."""
        names = [self.name] if len(self.freedoms) == 1 else []
        names = names or [f"{self.name}::{i + 1}" for i in range(len(self.freedoms))]
        return tuple(each.name or name for each, name in zip(self.freedoms, names, strict=True))

    def reversed(self) -> "Joint":
        """Return it from its child to its parent, with the same positions."""
        freedoms = [
            replace(each, axis_J=_opposite(each.axis_J), name=name)
            for each, name in zip(self.freedoms, self.freedom_names, strict=True)
        ]
        return replace(
            self,
            parent=self.child,
            child=self.parent,
            axis_J=_opposite(self.axis_J),
            freedoms=tuple(freedoms[::-1]),
            turned_round=not self.turned_round,
        )

    def place_of(self, axis: int) -> int:
        """Return the place among its freedoms of an axis, as its file counts them."""
        last = len(self.freedoms) - 1
        return last - axis if self.turned_round and axis <= last else axis

    def held(self) -> "Joint":
        """Return it without freedoms."""
        return replace(self, freedoms=(), mimic=None)


def _opposite(axis: tuple[float, float, float]) -> tuple[float, float, float]:
    x, y, z = axis
    return (-x, -y, -z)


@dataclass(frozen=True)
class Cable:
    """A cable between points of two links; it pulls, and goes slack where they come closer.

    Attributes:
        name: of the cable.
        parent: link of its upper end.
        p_parent: the upper end in the frame of that link [m].
        child: link of its lower end.
        p_child: the lower end in the frame of that link [m].
        length: of the cable without tension [m].
        stiffness: of an elastic one [N/m]; 0 for one that hardly stretches.
        damping: of an elastic one [N s/m]; 0 for half of the critical damping.
    """

    name: str
    parent: str
    p_parent: tuple[float, float, float]
    child: str
    p_child: tuple[float, float, float]
    length: float
    stiffness: float = 0.0
    damping: float = 0.0


@dataclass(frozen=True)
class NamedFrame:
    """A `<frame>` of SDF, or a URDF link that Gazebo keeps as a frame: F fixed to a link."""

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
        drives: the elements of a URDF that say how ROS drives joints.
        actuators: those of MJCF that apply a force or moment at a site.
        cables: between links.
        properties: the attributes of gym-pybullet-drones' `<properties>` tag, or empty.
        canonical_link: the link that stands for the model, where joints have no direction, as in
            SDF; "" in other formats.
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
    cables: tuple[Cable, ...] = ()
    drives: tuple[Element, ...] = ()
    canonical_link: str = ""

    @property
    def loads(self) -> tuple[str, ...]:
        """Links that fly freely, and hang on cables."""
        return tuple(joint.child for joint in self.joints if joint.is_free)

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
                if len(name) > MAX_PART_NAME_CHARS:
                    raise WorkbenchError(
                        f"{self.source}: the name of {kind} '{plain_name(name)}' is longer than "
                        f"{MAX_PART_NAME_CHARS:,} characters: shorten it"
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

    def moving_joints_above(self, link: str) -> list[Joint]:
        """Return the joints that move between the root of the tree and a link, from the root on."""
        found: list[Joint] = []
        joint = self.joint_of(link)
        while joint:
            if joint.moves:
                found.insert(0, joint)
            joint = self.joint_of(joint.parent)
        return found
