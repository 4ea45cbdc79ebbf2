"""The tree of frames of a drone in a world: links as they hang, sensors on them, parts around."""

from collections.abc import Iterable

import numpy as np
from pydrake.math import RigidTransform, RotationMatrix

from workbench.plant.frame_tree import (
    WORLD,
    BaseFrame,
    FixedFrame,
    FrameTree,
    Motion,
    MovingFrame,
    TreeFrame,
)
from workbench.plant.model import Model
from workbench.plant.sensors import Sensor, SensorFrames, free_name, sensor_frames
from workbench.plant.vehicle import Vehicle
from workbench.plant.worlds.world import World

X_SO = RigidTransform(RotationMatrix(np.array([[0.0, 0, 1], [-1, 0, 0], [0, -1, 0]])))
"""Optical frame of a camera (z forward, x right, y down) in the sensor's own (x forward, z up)."""


def frame_tree(
    vehicle: Vehicle,
    model: Model,
    fixed: Iterable[tuple[str, RigidTransform]] = (),
    moving: Iterable[tuple[str, Motion]] = (),
) -> FrameTree:
    """Return all frames of a drone and of the world around it.

    Links and frames of the description have their names. A sensor has its own where that is free,
    and else NAME_sensor; a depth camera has an optical frame besides. Where a sensor's readings
    are labelled with a frame that the description does not have, that is another name for the
    sensor's. What is left without a free name gets a number.

    Args:
        vehicle: whose frames, sensors and base link these are.
        model: its links and joints, which tell what hangs on what.
        fixed: parts F of the world that stay, by name, with X_WF.
        moving: parts of the world that move, by name, with X_WF over time.
    """
    frames = _Frames(vehicle.base_link)
    poses = {
        frame.name: RigidTransform(RotationMatrix(np.array(frame.R_BF)), np.array(frame.p_BF))
        for frame in vehicle.frames
    }
    _add_links(frames, model, poses, vehicle.base_link)
    for named in model.frames:
        if named.link in poses and named.name not in frames.taken:
            frames.add(FixedFrame(named.name, named.link, named.X_LF))
    names = sensor_frames(vehicle.sensors, frames.taken)
    for sensor, named_so in zip(vehicle.sensors, names, strict=True):
        _add_sensor(frames, sensor, named_so, poses[sensor.link])
    for name, X_WF in fixed:
        frames.add(FixedFrame(free_name(frames.taken, name), WORLD, X_WF))
    for name, motion in moving:
        frames.add(MovingFrame(free_name(frames.taken, name), motion))
    return FrameTree(tuple(frames.found))


def frames_in_world(vehicle: Vehicle, model: Model, world: World) -> FrameTree:
    """Return all frames of a drone in a world, obstacles included; see `frame_tree`."""
    return frame_tree(
        vehicle,
        model,
        fixed=[(obstacle.name, obstacle.X_WO) for obstacle in world.obstacles],
        moving=[(moving.name, moving.pose) for moving in world.moving],
    )


class _Frames:
    """Frames found so far, and the names they have taken."""

    def __init__(self, base_link: str) -> None:
        self.found: list[TreeFrame] = []
        self.taken = {WORLD}
        self.add(BaseFrame(base_link))

    def add(self, frame: TreeFrame) -> None:
        self.found.append(frame)
        self.taken.add(frame.name)


def _add_links(
    frames: _Frames, model: Model, poses: dict[str, RigidTransform], base_link: str
) -> None:
    """Add the links, each after the one that it hangs on; the model is a tree below its base."""
    todo = [base_link]
    while todo:
        parent = todo.pop(0)
        children = [joint.child for joint in model.joints if joint.parent == parent]
        for child in children:
            X_PC = poses[parent].InvertAndCompose(poses[child])
            frames.add(FixedFrame(child, parent, X_PC))
        todo += children


def _add_sensor(frames: _Frames, sensor: Sensor, names: SensorFrames, X_BL: RigidTransform) -> None:
    """Add a sensor's frame S on its link L, and those that go with it."""
    X_BS = RigidTransform(RotationMatrix(np.array(sensor.R_BS)), np.array(sensor.p_BS))
    frames.add(FixedFrame(names.own, sensor.link, X_BL.InvertAndCompose(X_BS)))
    if names.optical:
        frames.add(FixedFrame(names.optical, names.own, X_SO))
    if names.alias:
        frames.add(FixedFrame(names.alias, names.own, RigidTransform()))
