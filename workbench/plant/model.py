"""A description as records, whatever format it came in: links, joints, shapes, poses.

Frames: M is the model's own frame, L a link's, J a joint's, S that of a shape or a sensor,
I that of an inertia. Poses of links and joints are given in M and hold while all
joints are at zero.
"""

from dataclasses import dataclass
from pathlib import Path

from pydrake.math import RigidTransform

from workbench.plant.formats.xml import Element
from workbench.plant.shapes import Mesh, Shape


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


@dataclass(frozen=True)
class LinkShape:
    """A shape that is drawn, or that touches, on its link.

    Attributes:
        name: of the visual or collision.
        X_LS: where it is.
        shape: in its own frame.
        rgba: 0 .. 1, of what is drawn; None where the description gives no colour.
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
    """A rigid part; without an inertial it is a frame with shapes."""

    name: str
    X_ML: RigidTransform
    inertial: Inertial | None
    visuals: tuple[LinkShape, ...]
    collisions: tuple[LinkShape, ...]

    @property
    def shapes(self) -> tuple[LinkShape, ...]:
        """All of them, those that are drawn first."""
        return (*self.visuals, *self.collisions)


@dataclass(frozen=True)
class Joint:
    """How a child link hangs on its parent.

    Attributes:
        name: of the joint.
        kind: as the description has it: fixed, continuous, revolute, prismatic, ...
        parent: link name, or `world`.
        child: link name.
        X_MJ: pose of the joint's frame.
        axis_J: unit vector of turning or sliding; z where there is none.
    """

    name: str
    kind: str
    parent: str
    child: str
    X_MJ: RigidTransform
    axis_J: tuple[float, float, float]


@dataclass(frozen=True)
class NamedFrame:
    """An SDF `<frame>`, or a URDF link that Gazebo would know by name: F fixed to a link."""

    name: str
    link: str
    X_LF: RigidTransform


@dataclass(frozen=True)
class DeclaredSensor:
    """A `<sensor>` element, in SDF's words in every format, and where it is mounted."""

    file: Path
    link: str
    X_LS: RigidTransform
    element: Element


@dataclass(frozen=True)
class DeclaredPlugin:
    """A `<plugin>` element of the model (not of a sensor or the world)."""

    file: Path
    element: Element


@dataclass(frozen=True)
class DeclaredActuator:
    """An actuator of MJCF at a site S of a link.

    Attributes:
        name: of the actuator.
        link: that it pushes.
        X_LS: where.
        force_S: on the link, over the control.
        moment_S: likewise.
        most: the largest control, None where there is no limit.
        time_constant: of a first-order filter before it [s], None where there is none.
    """

    name: str
    link: str
    X_LS: RigidTransform
    force_S: tuple[float, float, float]
    moment_S: tuple[float, float, float]
    most: float | None
    time_constant: float | None


@dataclass(frozen=True)
class Model:
    """What a description file says, before anything is made of it.

    Attributes:
        source: the file that was asked for.
        name: the robot's or model's name.
        links: in the file's order.
        joints: in the file's order.
        frames: SDF frames.
        sensors: all `<sensor>` elements.
        plugins: all `<plugin>` elements.
        actuators: those of MJCF that push or turn a site.
        properties: the attributes of gym-pybullet-drones' `<properties>` tag, or empty.
    """

    source: Path
    name: str
    links: tuple[Link, ...]
    joints: tuple[Joint, ...]
    frames: tuple[NamedFrame, ...]
    sensors: tuple[DeclaredSensor, ...]
    plugins: tuple[DeclaredPlugin, ...]
    properties: tuple[tuple[str, str], ...] = ()
    actuators: tuple[DeclaredActuator, ...] = ()

    def link(self, name: str) -> Link | None:
        """Return the link of a name, if there is one."""
        return next((link for link in self.links if link.name == name), None)

    def joint(self, name: str) -> Joint | None:
        """Return the joint of a name, if there is one."""
        return next((joint for joint in self.joints if joint.name == name), None)

    def joint_of(self, child: str) -> Joint | None:
        """Return the joint that a link hangs on, if it hangs on one."""
        return next((joint for joint in self.joints if joint.child == child), None)
