"""The tree of frames of a drone in a world: links as they hang, sensors on them, parts around."""

from collections.abc import Iterable

import numpy as np
from pydrake.math import RigidTransform, RotationMatrix

from workbench.plant.frame_tree import (
    WORLD,
    FrameTree,
    Motion,
    TreeFrame,
)
from workbench.plant.model import Model
from workbench.plant.sensors import free_name, sensor_frames
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
    frames = [TreeFrame(vehicle.base_link, WORLD, None)]
    poses = {
        frame.name: RigidTransform(RotationMatrix(np.array(frame.R_BF)), np.array(frame.p_BF))
        for frame in vehicle.frames
    }
    _add_links(frames, model, poses, vehicle.base_link)
    taken = {WORLD, *(frame.name for frame in frames)}

    def add(name: str, parent: str, X_PF: RigidTransform | Motion) -> None:
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
        add(free_name(taken, name), WORLD, X_WF)
    return FrameTree(tuple(frames))


def frames_in_world(vehicle: Vehicle, model: Model, world: World) -> FrameTree:
    """Return all frames of a drone in a world, obstacles included; see `frame_tree`."""
    return frame_tree(
        vehicle,
        model,
        fixed=[(obstacle.name, obstacle.X_WO) for obstacle in world.obstacles],
        moving=[(moving.name, moving.pose) for moving in world.moving],
    )


def _add_links(
    frames: list[TreeFrame], model: Model, poses: dict[str, RigidTransform], base_link: str
) -> None:
    """Add the links, each after the one that it hangs on; the model is a tree below its base."""
    todo = [base_link]
    while todo:
        parent = todo.pop(0)
        children = [joint.child for joint in model.joints if joint.parent == parent]
        for child in children:
            X_PC = poses[parent].InvertAndCompose(poses[child])
            frames.append(TreeFrame(child, parent, X_PC))
        todo += children
