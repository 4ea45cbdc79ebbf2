"""Contact with what stands still: Drake's discrete plant, asked where a vehicle may touch."""

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
"""No vehicle speeds up by more than this [m/s²]: a bound on how soon it can be near."""
FARTHEST = 1000.0
"""What is farther than this is not looked for [m]."""


class Contact:
    """A discrete plant of the vehicle in its world, in a diagram and a Context of its own.

    Drake's contact solver steps the vehicle while it touches. It is of first order, which contact
    asks for: what hits something has no second derivative.

    Args:
        description: what flies, without its payload, see `carry`.
        world: where.
        step: of the physics [s].

    Attributes:
        above_ground: middle in B and radius of the sphere that holds the vehicle (4) [m], where
            there is nothing but the ground, at z = 0; None where there is more.
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
        """Let the vehicle carry a payload; it has mass and no shape, so it touches nothing."""
        if payload == self._payload:
            return
        self._payload = payload
        # from the bare one each time: what it carried before must leave no rounding behind
        whole = copy.copy(self._drone.default_spatial_inertia())
        if payload.payload_mass > 0.0:
            box = payload.inertial
            moments = RotationalInertia(*box.moments)
            whole += SpatialInertia.MakeFromCentralInertia(
                box.mass, box.X_LI.translation(), moments
            )
        self._drone.SetSpatialInertiaInBodyFrame(self._context, whole)

    def steps_away(self, state: np.ndarray) -> float:
        """Return for how many steps a vehicle touches nothing for sure, infinite where nothing is.

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
            acceleration: angular, and of the origin, in W (6), that it would have if it touched
                nothing [rad/s², m/s²].
        """
        self._load(state, acceleration)
        after = self._plant.EvalUniquePeriodicDiscreteUpdate(self._context)
        found = after.value().copy()
        found[:4] /= np.linalg.norm(found[:4])
        return found

    def _place(self, state: np.ndarray) -> None:
        """Put the body there; what Drake has worked out for the same state stays."""
        if not np.array_equal(state, self._at):
            self._plant.SetPositionsAndVelocities(self._context, state)
            self._at = state.copy()

    def _load(self, state: np.ndarray, acceleration: np.ndarray) -> None:
        """Let the body be in a state, under the forces that give it the acceleration."""
        self._place(state)
        gravity = MultibodyForces(self._plant)
        self._plant.CalcForceElementsContribution(self._context, gravity)
        forces = self._plant.CalcInverseDynamics(self._context, acceleration, gravity)
        self._forces.FixValue(self._context, forces)

    def _distance(self, state: Sequence[float]) -> float:
        """Return how far the sphere that holds the vehicle is from what stands still [m]."""
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
    """Return the middle of a sphere in W (3) [m].

    Args:
        state: of the body (13).
        p_BC: that middle in B (3) [m].
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
    """Return for how many steps a vehicle gets nowhere at a distance for sure.

    Args:
        distance: from the sphere that holds it [m].
        state: of the body (13).
        p_BC: middle of that sphere in B (3) [m].
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
