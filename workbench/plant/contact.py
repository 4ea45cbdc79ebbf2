"""Contact with what stands still: Drake's discrete plant, asked where a vehicle may touch."""

import copy
import math

import numpy as np
from pydrake.multibody.plant import MultibodyPlant
from pydrake.multibody.tree import MultibodyForces, RotationalInertia, SpatialInertia
from pydrake.systems.framework import DiagramBuilder

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
        self._p_BC, self._radius = np.array(around.p_BC), around.radius
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
        distance = self._distance(state)
        if math.isinf(distance):
            return math.inf
        speed = float(np.linalg.norm(state[10:13]))
        speed += float(np.linalg.norm(self._p_BC)) * float(np.linalg.norm(state[7:10]))
        root = math.sqrt(speed * speed + 2.0 * FASTEST_CHANGE * max(distance, 0.0))
        return math.floor((root - speed) / FASTEST_CHANGE / self._step)

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

    def _distance(self, state: np.ndarray) -> float:
        """Return how far the sphere that holds the vehicle is from what stands still [m]."""
        w, x, y, z = state[:4]
        axis = np.array([x, y, z])
        turn = np.cross(axis, self._p_BC)
        centre = state[4:7] + self._p_BC + 2.0 * (w * turn + np.cross(axis, turn))
        query = self._query.Eval(self._in_scene)
        found = [
            each.distance
            for each in query.ComputeSignedDistanceToPoint(centre, FARTHEST)
            if each.id_G not in self._own
        ]
        return min(found, default=math.inf) - self._radius
