"""Put what stands still into the plant that the drone flies in."""

import copy

import numpy as np
from pydrake.geometry import GeometryInstance
from pydrake.math import RigidTransform
from pydrake.multibody.plant import MultibodyPlant
from pydrake.multibody.tree import RigidBody, SpatialInertia, UnitInertia

from workbench.plant.worlds.world import World

MOST_BESIDE_THE_GROUND = 13
"""So many shapes may be fixed to the world itself where there is ground.

What is fixed to the world is in one tree of boxes, built once. When the tree is higher than the
logarithm of its number of leaves by 10, Drake 1.51 balances it anew, and with the endless box of a
half space among the leaves that ends in a segmentation fault (the sizes that it compares are all
infinite). A tree of 14 leaves cannot be so high, however it grew.
"""
_BODY = "_obstacles"


def add_obstacles(plant: MultibodyPlant, world: World) -> None:
    """Add the shapes of a world's obstacles to a plant, before it is finalised.

    They get no bodies of their own, as each body takes time at every step: 24 obstacles as 24
    welded bodies double a step of 20 µs. Fixed to the world's body they cost nearly nothing (1000
    shapes 3 µs), but see `MOST_BESIDE_THE_GROUND`; where they are more, one body that is welded
    to the world has them, whose boxes Drake places anew at every step (24 shapes 14 µs, 200 70 µs).

    Raises:
        RuntimeError, ValueError: from Drake, if it does not take a geometry.
    """
    count = sum(len(obstacle.collisions) for obstacle in world.obstacles)
    is_many = world.ground and count > MOST_BESIDE_THE_GROUND
    touched = _welded_body(plant) if is_many else plant.world_body()
    for obstacle in world.obstacles:
        for geometry in obstacle.collisions:
            plant.RegisterCollisionGeometry(
                touched,
                obstacle.X_WO @ geometry.pose(),
                geometry.shape(),
                geometry.name(),
                geometry.proximity_properties(),
            )
        for geometry in obstacle.visuals:
            plant.RegisterVisualGeometry(plant.world_body(), _placed(geometry, obstacle.X_WO))


def _welded_body(plant: MultibodyPlant) -> RigidBody:
    """Return a new body whose frame is the world's."""
    inertia = SpatialInertia(1.0, np.zeros(3), UnitInertia.SolidSphere(1.0))  # of no effect
    body = plant.AddRigidBody(_BODY, plant.AddModelInstance(_BODY), inertia)
    plant.WeldFrames(plant.world_frame(), body.body_frame())
    return body


def _placed(geometry: GeometryInstance, X_WO: RigidTransform) -> GeometryInstance:
    """Return a copy of an obstacle's geometry with its pose in the world."""
    placed = copy.copy(geometry)
    placed.set_pose(X_WO @ geometry.pose())
    return placed
