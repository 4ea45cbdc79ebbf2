"""The tree of all frames: world, drone, links, sensors and parts of the world."""

import math
from collections.abc import Callable, Iterable, Iterator, Mapping
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from pydrake.math import RigidTransform, RollPitchYaw, RotationMatrix

from workbench.common.errors import WorkbenchError, unknown_name
from workbench.common.plain_text import plain_name
from workbench.plant.model import Model
from workbench.plant.sensors import free_name, sensor_frames
from workbench.plant.vehicle import Vehicle
from workbench.plant.worlds.world import World

WORLD_FRAME_NAME = "world"
"""Name of the frame at the root."""

PoseOverTime = Callable[[float], RigidTransform]
"""X_WF of a moving part F of the world at a time [s]."""
X_SO = RigidTransform(RotationMatrix(np.array([[0.0, 0, 1], [-1, 0, 0], [0, -1, 0]])))
"""Optical frame of a camera (z forward, x right, y down) in the sensor's own (x forward, z up)."""


@dataclass(frozen=True)
class TreeFrame:
    """A frame F in its parent P.

    Attributes:
        name: of the frame.
        parent: name of the frame that it is given in.
        X_PF: its pose, over time [s] of a part of the world that moves; None of the drone's base
            link, which flies.
        on_joint: whether a joint moves it in its parent; its pose then is that at the joint's zero.
    """

    name: str
    parent: str
    X_PF: RigidTransform | PoseOverTime | None
    on_joint: bool = False

    @property
    def motion(self) -> str:
        """Its kind of motion in words."""
        if self.X_PF is None:
            return ", flies"
        return ", moves" if self.on_joint or not isinstance(self.X_PF, RigidTransform) else ""

    def pose(self, X_WB: RigidTransform, time: float) -> RigidTransform:
        """Return X_PF at a time [s] and a pose of the base link."""
        if self.X_PF is None:
            return X_WB
        return self.X_PF if isinstance(self.X_PF, RigidTransform) else self.X_PF(time)


@dataclass(frozen=True)
class Transform:
    """Pose of a child frame in its parent's: position [m] and unit quaternion w, x, y, z."""

    parent: str
    child: str
    p: tuple[float, float, float]
    q: tuple[float, float, float, float]


@dataclass(frozen=True)
class FrameTree:
    """Frames by name, each after its parent, without the world itself.

    Attributes:
        frames: all of them.
        optical: names of the optical frames, in the order of the vehicle's depth cameras.
    """

    frames: tuple[TreeFrame, ...]
    optical: tuple[str, ...] = ()

    def __post_init__(self) -> None:
        known = {WORLD_FRAME_NAME}
        for frame in self.frames:
            if frame.name in known:
                raise WorkbenchError(f"two frames are named '{frame.name}': rename one")
            if frame.parent not in known:
                raise unknown_name(f"parent of frame '{frame.name}',", frame.parent, known)
            known.add(frame.name)

    @property
    def names(self) -> tuple[str, ...]:
        """Names of all frames, the world's first."""
        return (WORLD_FRAME_NAME, *(frame.name for frame in self.frames))

    def X(self, a: str, b: str, X_WB: RigidTransform, time: float = 0.0) -> RigidTransform:
        """Return X_AB, the pose of frame b in frame a.

        The product starts at the lowest common ancestor of both frames, so that relative poses of
        frames on the drone are exact wherever it flies.

        Args:
            a: frame A.
            b: frame B', the pose of which is returned.
            X_WB: pose of the base link.
            time: for parts of the world that move [s].

        Raises:
            WorkbenchError: if a frame does not exist.
        """
        way_a, way_b = self._way_down(a), self._way_down(b)
        shared = 0
        while shared < min(len(way_a), len(way_b)) and way_a[shared] is way_b[shared]:
            shared += 1
        X_CA, X_CB = (_product(way[shared:], X_WB, time) for way in (way_a, way_b))
        return X_CA.InvertAndCompose(X_CB)

    def transforms(self, X_WB: RigidTransform, time: float = 0.0) -> tuple[Transform, ...]:
        """Return every frame's pose in its parent, in the order of `frames`."""
        return tuple(
            still or transform(frame.parent, frame.name, frame.pose(X_WB, time))
            for frame, still in zip(self.frames, self._fixed, strict=True)
        )

    def posed(self, poses: Mapping[str, RigidTransform]) -> "FrameTree":
        """Return the tree with the poses in their parents of frames that joints move, by name."""
        frames = (replace(each, X_PF=poses.get(each.name, each.X_PF)) for each in self.frames)
        return replace(self, frames=tuple(frames))

    def lines(self, X_WB: RigidTransform, time: float = 0.0) -> Iterator[str]:
        """Yield the tree as lines: name, position in its parent [m] and roll, pitch, yaw [°]."""
        yield WORLD_FRAME_NAME
        yield from self._lines_below(WORLD_FRAME_NAME, "", X_WB, time)

    def check(self, name: str) -> None:
        """Raise a WorkbenchError with the nearest name if there is no frame of this name."""
        if name not in self.names:
            raise unknown_name("frame", name, self.names)

    @cached_property
    def _fixed(self) -> tuple[Transform | None, ...]:
        """Transforms of the frames that are fixed to their parents, None for the others."""
        return tuple(
            transform(frame.parent, frame.name, frame.X_PF)
            if isinstance(frame.X_PF, RigidTransform)
            else None
            for frame in self.frames
        )

    def _way_down(self, name: str) -> list[TreeFrame]:
        """Return the frames on the path from the world, without it, down to a name."""
        self.check(name)
        way: list[TreeFrame] = []
        while name != WORLD_FRAME_NAME:
            frame = next(frame for frame in self.frames if frame.name == name)
            way.insert(0, frame)
            name = frame.parent
        return way

    def _lines_below(
        self, parent: str, indent: str, X_WB: RigidTransform, time: float
    ) -> Iterator[str]:
        children = [frame for frame in self.frames if frame.parent == parent]
        for child in children:
            last = child is children[-1]
            place = _pose_in_words(child.pose(X_WB, time)) + child.motion
            yield f"{indent}{'└─ ' if last else '├─ '}{plain_name(child.name)} ({place})"
            below = indent + ("   " if last else "│  ")
            yield from self._lines_below(child.name, below, X_WB, time)


def _product(way: list[TreeFrame], X_WB: RigidTransform, time: float) -> RigidTransform:
    """Return the pose of the last frame of a path in the parent of its first frame."""
    X = RigidTransform()
    for frame in way:
        X = X @ frame.pose(X_WB, time)
    return X


def transform(parent: str, child: str, X_PC: RigidTransform) -> Transform:
    """Return a pose as a `Transform`."""
    p_x, p_y, p_z = X_PC.translation().tolist()
    w, x, y, z = X_PC.rotation().ToQuaternion().wxyz().tolist()
    return Transform(parent, child, (p_x, p_y, p_z), (w, x, y, z))


def roll_pitch_yaw(X: RigidTransform) -> list[float]:
    """Return the roll, pitch and yaw of a pose [rad]."""
    angles = RollPitchYaw(X.rotation()).vector()
    return [0.0 if abs(angle) < 1e-12 else float(angle) for angle in angles]


def _pose_in_words(X_PF: RigidTransform) -> str:
    """Return the pose of a frame in its parent in words."""
    place = _listed_values(X_PF.translation())
    angles = [math.degrees(angle) for angle in roll_pitch_yaw(X_PF)]
    return f"{place}; rpy {_listed_values(np.array(angles))}" if any(angles) else place


def _listed_values(values: np.ndarray) -> str:
    return " ".join(f"{value:.4g}" if abs(value) >= 5e-7 else "0" for value in values)


def frame_tree(
    vehicle: Vehicle,
    model: Model,
    fixed: Iterable[tuple[str, RigidTransform]] = (),
    moving: Iterable[tuple[str, PoseOverTime]] = (),
) -> FrameTree:
    """Return all frames of a drone and of the world around it.

    Links and frames of the description keep their names. A sensor keeps its name if it is free, and
    else becomes NAME_sensor. A depth camera also has an optical frame. If the readings of a sensor
    are labelled with a frame that is not in the description, that is an alias of the sensor frame.
    Any name still taken gets a number.

    Args:
        vehicle: has the frames, sensors and base link.
        model: its links and joints, which define parents.
        fixed: static parts F of the world, by name, with X_WF.
        moving: moving parts F of the world, by name, with X_WF over time.
    """
    frames = [TreeFrame(vehicle.base_link, WORLD_FRAME_NAME, None)]
    poses = {
        frame.name: RigidTransform(RotationMatrix(np.array(frame.R_BF)), np.array(frame.p_BF))
        for frame in vehicle.frames
    }
    _add_links(frames, model, poses, vehicle.base_link)
    taken = {WORLD_FRAME_NAME, *(frame.name for frame in frames)}

    def add(name: str, parent: str, X_PF: RigidTransform | PoseOverTime) -> None:
        frames.append(TreeFrame(name, parent, X_PF))
        taken.add(name)

    for named in model.frames:
        if named.link in poses and named.name not in taken:
            add(named.name, named.link, named.X_LF)
    names = sensor_frames(vehicle.sensors, taken)
    for sensor, (own, optical, alias) in zip(vehicle.sensors, names, strict=True):
        X_BS = RigidTransform(RotationMatrix(np.array(sensor.R_BS)), np.array(sensor.p_BS))
        add(own, sensor.link, poses[sensor.link].InvertAndCompose(X_BS))
        if optical:
            add(optical, own, X_SO)
        if alias:
            add(alias, own, RigidTransform())
    for name, X_WF in (*fixed, *moving):
        add(free_name(taken, name), WORLD_FRAME_NAME, X_WF)
    return FrameTree(tuple(frames), tuple(optical for _, optical, _ in names if optical))


def frames_in_world(vehicle: Vehicle, model: Model, world: World) -> FrameTree:
    """Return all frames of a drone in a world with its obstacles, see `frame_tree`."""
    return frame_tree(
        vehicle,
        model,
        fixed=[(obstacle.name, obstacle.X_WO) for obstacle in world.obstacles],
        moving=[(moving.name, moving.pose) for moving in world.moving],
    )


def _add_links(
    frames: list[TreeFrame], model: Model, poses: dict[str, RigidTransform], base_link: str
) -> None:
    """Add the links, each after its parent; the model is a tree below its base."""
    todo = [base_link]
    while todo:
        parent = todo.pop(0)
        joints = [joint for joint in model.joints if joint.parent == parent]
        children = [joint.child for joint in joints]
        for joint in joints:
            X_PC = poses[parent].InvertAndCompose(poses[joint.child])
            frames.append(TreeFrame(joint.child, parent, X_PC, joint.moves))
        todo += children
