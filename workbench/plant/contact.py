"""Contact with static obstacles: Drake's discrete plant, used near possible contact."""

import copy
import math
from collections.abc import Sequence
from typing import Any

import numpy as np
from pydrake.multibody.plant import MultibodyPlant
from pydrake.multibody.tree import MultibodyForces, RotationalInertia, SpatialInertia
from pydrake.systems.framework import DiagramBuilder

from workbench.common.jitable import register_jitable
from workbench.plant.description import Description
from workbench.plant.multibody import add_plant
from workbench.plant.payload import NO_PAYLOAD, Payload
from workbench.plant.reach import reach
from workbench.plant.worlds.world import World

FASTEST_CHANGE = 1000.0
"""Upper bound of the acceleration of a vehicle [m/s²]; it bounds how soon contact is possible."""
FARTHEST = 1000.0
"""Obstacles farther than this are ignored [m]."""


class Contact:
    """A discrete plant of the vehicle in its world, in its own diagram and Context.

    Drake's contact solver steps the vehicle during contact. It is of first order, as velocities
    jump at an impact.

    Args:
        description: of the vehicle without its payload, see `carry`.
        world: where it flies.
        step: of the physics [s].

    Attributes:
        above_ground: centre in B and radius of the sphere around the vehicle (4) [m] if the ground
            at z = 0 is the only obstacle, else None.
    """

    def __init__(self, description: Description, world: World, step: float) -> None:
        builder = DiagramBuilder()
        plant, scene_graph = add_plant(builder, description.undrawn(), time_step=step, world=world)
        diagram = builder.Build()
        self._plant: MultibodyPlant = plant
        self._step = step
        self._root = diagram.CreateDefaultContext()
        self._context = plant.GetMyMutableContextFromRoot(self._root)
        self._query = scene_graph.get_query_output_port()
        self._in_scene = scene_graph.GetMyContextFromRoot(self._root)
        self._forces = plant.get_applied_generalized_force_input_port()
        around = reach(description.model, description.base_link, description.rotors)
        self._p_BC, self._radius = tuple(map(float, around.p_BC)), around.radius
        self.above_ground: np.ndarray | None = None
        if world.ground and not world.names:
            self.above_ground = np.array([*self._p_BC, self._radius])
        self._drone = plant.GetBodyByName(description.base_link)
        self._at = np.full(13, math.nan)
        self._own = frozenset(plant.GetCollisionGeometriesForBody(self._drone))
        self._payload = NO_PAYLOAD

    def carry(self, payload: Payload) -> None:
        """Add a payload to the vehicle; it has mass and no shape, so it touches nothing."""
        if payload == self._payload:
            return
        self._payload = payload
        # Each time from the bare vehicle, so that an earlier payload leaves no rounding errors.
        whole = copy.copy(self._drone.default_spatial_inertia())
        if payload.payload_mass > 0.0:
            box = payload.inertial
            moments = RotationalInertia(*box.moments)
            whole += SpatialInertia.MakeFromCentralInertia(
                box.mass, box.X_LI.translation(), moments
            )
        self._drone.SetSpatialInertiaInBodyFrame(self._context, whole)

    def steps_away(self, state: np.ndarray) -> float:
        """Return the number of steps certain to be without contact; infinite without obstacles.

        Args:
            state: of the body (13).
        """
        numbers = state.tolist()
        distance = self._distance(numbers)
        return steps_to(distance, numbers, self._p_BC, self._step)

    def touches(self, state: np.ndarray) -> bool:
        """Return whether the vehicle penetrates something."""
        self._place(state)
        return bool(self._query.Eval(self._in_scene).HasCollisions())

    def moved(self, state: np.ndarray, acceleration: np.ndarray) -> np.ndarray:
        """Return the state (13) a step later.

        Args:
            state: of the body (13).
            acceleration: angular, and of the origin, in W (6), without contact [rad/s², m/s²].
        """
        self._load(state, acceleration)
        after = self._plant.EvalUniquePeriodicDiscreteUpdate(self._context)
        found = after.value().copy()
        found[:4] /= np.linalg.norm(found[:4])
        return found

    def _place(self, state: np.ndarray) -> None:
        """Set the state of the body; Drake's cached results stay valid if it is the same."""
        if not np.array_equal(state, self._at):
            self._plant.SetPositionsAndVelocities(self._context, state)
            self._at = state.copy()

    def _load(self, state: np.ndarray, acceleration: np.ndarray) -> None:
        """Set the state of the body, and the forces that cause the acceleration."""
        self._place(state)
        gravity = MultibodyForces(self._plant)
        self._plant.CalcForceElementsContribution(self._context, gravity)
        forces = self._plant.CalcInverseDynamics(self._context, acceleration, gravity)
        self._forces.FixValue(self._context, forces)

    def _distance(self, state: Sequence[float]) -> float:
        """Return the distance of the sphere around the vehicle from static obstacles [m]."""
        centre = sphere_centre(state, self._p_BC)
        if self.above_ground is not None:
            return centre[2] - self._radius
        query = self._query.Eval(self._in_scene)
        found = [
            each.distance
            for each in query.ComputeSignedDistanceToPoint(centre, FARTHEST)
            if each.id_G not in self._own
        ]
        return min(found, default=math.inf) - self._radius


@register_jitable
def sphere_centre(state: Any, p_BC: Any) -> tuple[float, float, float]:
    """Return the centre of a sphere in W (3) [m].

    Args:
        state: of the body (13).
        p_BC: centre in B (3) [m].
    """
    w, x, y, z = state[0:4]
    c_x, c_y, c_z = p_BC
    t_x = y * c_z - z * c_y
    t_y = z * c_x - x * c_z
    t_z = x * c_y - y * c_x
    return (
        state[4] + c_x + 2.0 * (w * t_x + y * t_z - z * t_y),
        state[5] + c_y + 2.0 * (w * t_y + z * t_x - x * t_z),
        state[6] + c_z + 2.0 * (w * t_z + x * t_y - y * t_x),
    )


@register_jitable
def steps_to(distance: float, state: Any, p_BC: Any, step: float) -> float:
    """Return the number of steps in which a vehicle certainly does not cover a distance.

    Args:
        distance: from the sphere around it [m].
        state: of the body (13).
        p_BC: centre of that sphere in B (3) [m].
        step: [s].
    """
    if math.isinf(distance):
        return math.inf
    w_x, w_y, w_z, v_x, v_y, v_z = state[7:13]
    c_x, c_y, c_z = p_BC
    lever = math.sqrt((c_x * c_x + c_y * c_y + c_z * c_z) * (w_x * w_x + w_y * w_y + w_z * w_z))
    speed = math.sqrt(v_x * v_x + v_y * v_y + v_z * v_z) + lever
    root = math.sqrt(speed * speed + 2.0 * FASTEST_CHANGE * max(distance, 0.0))
    return 1.0 * math.floor((root - speed) / FASTEST_CHANGE / step)
