"""Loads that fly freely and hang on cables: what they touch, and what a hook reaches."""

import dataclasses
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from pydrake.multibody.plant import MultibodyPlant
from pydrake.multibody.tree import QuaternionFloatingJoint, RigidBody
from pydrake.systems.framework import Context

from workbench.common.errors import WorkbenchError
from workbench.plant.description import Description
from workbench.plant.formats.values import shortened_text
from workbench.plant.gravity import GRAVITY
from workbench.plant.loading import ground_clearance
from workbench.plant.model import FREE_JOINT_KIND, Joint
from workbench.plant.reach import ReachSphere, reach_sphere
from workbench.plant.tree import links_below
from workbench.plant.vehicle import Vehicle
from workbench.systems.cables import CableRow


@dataclass(frozen=True)
class FreeLoad:
    """A load that flies freely.

    Attributes:
        body: of its first link L in the plant.
        joint: Drake's, of its motion relative to the drone.
        p_LC: centre of the sphere around all that it can touch with, in L (3) [m].
        radius: of that sphere [m].
        depth: of its lowest point below the origin of L, upright [m].
    """

    body: RigidBody
    joint: QuaternionFloatingJoint
    p_LC: tuple[float, float, float]
    radius: float
    depth: float

    def sphere(self, plant: MultibodyPlant, context: Context) -> tuple[np.ndarray, float, float]:
        """Return the centre in W (3) [m], the radius [m] and the speed [m/s] of the load."""
        X_WL = plant.EvalBodyPoseInWorld(context, self.body)
        V_WL = plant.EvalBodySpatialVelocityInWorld(context, self.body)
        turning = float(np.linalg.norm(V_WL.rotational())) * self.radius
        speed = float(np.linalg.norm(V_WL.translational())) + turning
        return X_WL.multiply(np.array(self.p_LC)), self.radius, speed

    def lift_above_ground(self, plant: MultibodyPlant, context: Context) -> None:
        """Let it lie on the ground if it would be in it."""
        low = plant.EvalBodyPoseInWorld(context, self.body).translation()[2] - self.depth
        if low >= 0.0:
            return
        move_in_world(context, self.joint, np.array([0.0, 0.0, -low]))


def free_loads(plant: MultibodyPlant, description: Description) -> tuple[FreeLoad, ...]:
    """Return the loads of a description in its finalised plant."""
    return tuple(
        _free_load(plant, description, joint) for joint in description.model.joints if joint.is_free
    )


def _free_load(plant: MultibodyPlant, description: Description, joint: Joint) -> FreeLoad:
    drone = plant.GetBodyByName(description.base_link).model_instance()
    below = links_below(description.model, joint.child)
    alone = dataclasses.replace(
        description.model,
        links=tuple(link for link in description.model.links if link.name in below),
        joints=tuple(each for each in description.model.joints if each.parent in below),
    )
    shapes = [shape for link in alone.links for shape in link.shapes]
    around = reach_sphere(alone, joint.child, ()) if shapes else ReachSphere((0.0, 0.0, 0.0), 0.0)
    return FreeLoad(
        body=plant.GetFrameByName(joint.child, drone).body(),
        joint=plant.GetJointByName(joint.name, drone),
        p_LC=around.p_BC,
        radius=around.radius,
        depth=ground_clearance(alone, joint.child),
    )


def hang_loads(
    plant: MultibodyPlant, context: Context, rows: Sequence[CableRow], vehicle: Vehicle
) -> None:
    """Bring loads below the upper ends of slack cables, so low that these bear them.

    Without tension nothing would hold a load across its cable, and a search for a trim goes astray.

    Args:
        plant: with the vehicle.
        context: of the plant.
        rows: the cables.
        vehicle: with its joints.
    """
    for joint in vehicle.joints:
        if joint.kind != FREE_JOINT_KIND:
            continue
        load = plant.GetBodyByName(f"{joint.child}::{joint.name}")
        holding = [row for row in rows if row.bodies[1] == load.index()]
        if not holding:  # it hangs on nothing
            continue
        ends = [_end_positions(plant, context, row) for row in holding]
        aside = np.mean([first - second for first, second in ends], axis=0) * (1.0, 1.0, 0.0)
        move_in_world(context, plant.GetJointByName(joint.name), aside)
        ways = [_slack_way(plant, context, row) for row in holding]
        stretch = joint.mass * GRAVITY / sum(row.stiffness for row in holding)
        down = np.array([0.0, 0.0, -min(ways) - stretch])
        move_in_world(context, plant.GetJointByName(joint.name), down)


def move_in_world(context: Context, joint: QuaternionFloatingJoint, way: np.ndarray) -> None:
    """Move what a free joint carries by a way in W (3) [m]."""
    R_WJ = joint.frame_on_parent().CalcPoseInWorld(context).rotation()
    moved = joint.get_translation(context) + R_WJ.inverse().multiply(way)
    joint.SetTranslation(context, moved)


def _slack_way(plant: MultibodyPlant, context: Context, row: CableRow) -> float:
    """Return how far the lower end of a cable can sink until it is taut [m]."""
    first, second = _end_positions(plant, context, row)
    across = float(np.hypot(*(second - first)[:2]))
    return float(second[2] - first[2] + max(row.length**2 - across**2, 0.0) ** 0.5)


def _end_positions(
    plant: MultibodyPlant, context: Context, row: CableRow
) -> tuple[np.ndarray, np.ndarray]:
    first, second = (
        plant.EvalBodyPoseInWorld(context, plant.get_body(body)).multiply(np.array(p))
        for body, p in zip(row.bodies, row.places, strict=True)
    )
    return first, second


def refuse_out_of_reach(plant: MultibodyPlant, context: Context, row: CableRow) -> None:
    """Refuse to close the hook of a cable that does not reach its load.

    Raises:
        WorkbenchError: with the distance.
    """
    first, second = _end_positions(plant, context, row)
    distance = float(np.linalg.norm(second - first))
    if distance > row.length:
        raise WorkbenchError(
            f"the cable '{shortened_text(row.name)}' is {row.length:.4g} m long, and its load is "
            f"{distance:.2f} m away: fly closer before its hook is closed"
        )
