"""The nearest obstacle: distance and direction, from the scene's signed distances."""

import math
from collections.abc import Sequence, Set

import numpy as np
from pydrake.common.eigen_geometry import Quaternion
from pydrake.common.value import Value
from pydrake.geometry import GeometryId, QueryObject, SceneGraphInspector
from pydrake.math import RotationMatrix
from pydrake.multibody.plant import MultibodyPlant
from pydrake.systems.framework import BasicVector, Context, DiscreteValues

from workbench.control.obstacle_brake import MAX_WALLS
from workbench.plant.reach import ReachSphere
from workbench.plant.worlds.world import GROUND_NAME, obstacle_of
from workbench.systems.discrete_system import DiscreteSystem

OBSTACLE_RANGE_M = 30.0
"""Largest distance from the drone's centre at which obstacles are found [m]."""
SAME_WALL_COSINE = 0.9
"""If directions n and m of two obstacles have n · m above this, only the nearer one is a wall."""
MAX_SEARCH_STEP_M = 0.5
"""Longest step of the search along a free way [m]."""
MIN_SEARCH_STEP_M = 0.005
"""Shortest step of that search; a shorter one ends the free way [m]."""


class NearestObstacle(DiscreteSystem):
    """Measures once a period, and stores the result, so that reading it is free.

    Clearance is the distance from the centre of the sphere around the drone, minus its radius. The
    drone is never nearer than that, at any attitude. It is exact to rounding, 3e-5 m for
    ellipsoids. Convex and .obj meshes count; Drake silently ignores others (glTF), as it does for
    contact.

    Input ports:
        state (13): of the plant.
        geometry_query: of the scene.
    Output ports, both of them state:
        obstacle (5): clearance [m], unit vector in W to its nearest point (from inside it: the
            one deeper into it), warning 0 or 1; infinite, zero and 0 where nothing is in range.
        walls (12): direction in W and clearance of up to three obstacles in directions that
            differ, nearest first, as a limit of speed needs them; zero and infinite where
            there are fewer.
    Numeric parameter 0: warning distance [m].
    """

    def __init__(
        self,
        *,
        reach: ReachSphere,
        not_obstacles: Set[GeometryId],
        period: float,
        lead: float,
        warning_distance: float,
    ) -> None:
        """Declare ports, state and sampling.

        Args:
            reach: of the drone.
            not_obstacles: geometries of the drone and of the ground.
            period: between measurements [s].
            lead: time from a measurement to the next multiple of the period, at which others read
                it: one physics step [s].
            warning_distance: clearance below which there is a warning [m].
        """
        super().__init__()
        self._p_BC = np.array(reach.p_BC)
        self._radius = reach.radius
        self._not_obstacles = frozenset(not_obstacles)
        self.DeclareNumericParameter(BasicVector([warning_distance]))
        self._state = self.DeclareVectorInputPort("state", 13)
        self._query = self.DeclareAbstractInputPort("geometry_query", Value(QueryObject()))
        self._obstacle_index = self.DeclareDiscreteState(_obstacle([], 0.0))
        self._walls_index = self.DeclareDiscreteState(_walls([]))
        self.obstacle_output = self.DeclareStateOutputPort("obstacle", self._obstacle_index)
        self.walls_output = self.DeclareStateOutputPort("walls", self._walls_index)
        self.DeclareInitializationDiscreteUpdateEvent(self._update)
        self.DeclarePeriodicDiscreteUpdateEvent(period, period - lead, self._update)

    def nearest(self, root_context: Context) -> tuple[str, float, float] | None:
        """Return the nearest obstacle now, None if none is in range.

        The result is its name, the drone's clearance [m], and the distance from it to the centre of
        the drone's sphere [m], negative inside.
        """
        context = self.GetMyContextFromRoot(root_context)
        found = self._found(context)
        if not found:
            return None
        clearance, _, id = min(found, key=lambda each: each[0])
        name = self._query.Eval(context).inspector().GetName(id)
        return obstacle_of(name), clearance, clearance + self._radius

    def free_way(
        self, root_context: Context, direction_W: Sequence[float], most: float
    ) -> tuple[float, str]:
        """Return how far the drone can fly straight on now, at any attitude [m].

        Obstacles that it leaves or passes do not count. One ahead is behind the plane through its
        nearest point, so the path to that plane is free.

        Args:
            root_context: of the diagram.
            direction_W: unit vector in W.
            most: largest distance [m].

        Returns:
            The free distance, at most `most`, and the name of the obstacle there, or "".
        """
        context = self.GetMyContextFromRoot(root_context)
        query = self._query.Eval(context)
        p_WC, direction, way = self._middle(context), np.array(direction_W), 0.0
        while way < most:
            step, ahead = min(MAX_SEARCH_STEP_M, most - way), ""
            for clearance, n_W, id in self._around(
                query, p_WC + way * direction, MAX_SEARCH_STEP_M
            ):
                towards = float(direction @ np.array(n_W))
                if towards > 0.0 and max(0.0, clearance) < step * towards:
                    step = max(0.0, clearance) / towards
                    ahead = obstacle_of(query.inspector().GetName(id))
            way += step
            if ahead and step < MIN_SEARCH_STEP_M:
                return way, ahead
        return most, ""

    def _update(self, context: Context, discrete_state: DiscreteValues) -> None:
        found: list[ObstacleVector] = sorted(
            (clearance, *n_W) for clearance, n_W, _ in self._found(context)
        )
        warning_distance = float(context.get_numeric_parameter(0).CopyToVector()[0])
        discrete_state.set_value(self._obstacle_index, _obstacle(found, warning_distance))
        discrete_state.set_value(self._walls_index, _walls(found))

    def _found(self, context: Context) -> list[tuple[float, tuple[float, ...], GeometryId]]:
        """Return clearance [m], direction in W and geometry of every obstacle in range."""
        return self._around(
            self._query.Eval(context), self._middle(context), OBSTACLE_RANGE_M - self._radius
        )

    def _middle(self, context: Context) -> np.ndarray:
        """Return the centre of the sphere around the drone, in W (3) [m]."""
        state = self._state.Eval(context)
        R_WB = RotationMatrix(Quaternion(state[0:4] / np.linalg.norm(state[0:4])))
        p_WC: np.ndarray = state[4:7] + R_WB @ self._p_BC
        return p_WC

    def _around(
        self, query: QueryObject, p_WC: np.ndarray, most: float
    ) -> list[tuple[float, tuple[float, ...], GeometryId]]:
        """Return the same for the drone's centre at another position, up to a distance [m]."""
        return [
            (each.distance - self._radius, tuple((-each.grad_W).tolist()), each.id_G)
            for each in query.ComputeSignedDistanceToPoint(p_WC, most + self._radius)
            if each.id_G not in self._not_obstacles
        ]


ObstacleVector = tuple[float, ...]
"""Clearance [m] and direction in W of an obstacle."""


def _obstacle(found: list[ObstacleVector], warning_distance: float) -> list[float]:
    """Return the value of `obstacle`; `found` is sorted."""
    if not found:
        return [math.inf, 0.0, 0.0, 0.0, 0.0]
    clearance, *n_W = found[0]
    return [clearance, *n_W, float(clearance < warning_distance)]


def _walls(found: list[ObstacleVector]) -> list[float]:
    """Return the value of `walls`; `found` is sorted."""
    walls: list[ObstacleVector] = []
    for clearance, *n_W in found:
        alike = any(
            sum(a * b for a, b in zip(n_W, wall, strict=False)) > SAME_WALL_COSINE for wall in walls
        )
        if not alike and len(walls) < MAX_WALLS:
            walls.append((*n_W, clearance))
    walls += [(0.0, 0.0, 0.0, math.inf)] * (MAX_WALLS - len(walls))
    return [number for wall in walls for number in wall]


def drone_and_ground(
    plant: MultibodyPlant, inspector: SceneGraphInspector, base_link: str
) -> set[GeometryId]:
    """Return the geometries in a plant that are not obstacles: those of drone and ground."""
    drone = plant.GetBodyByName(base_link).model_instance()
    ids = {
        geometry
        for body in plant.GetBodyIndices(drone)
        for geometry in plant.GetCollisionGeometriesForBody(plant.get_body(body))
    }
    anchored = plant.GetCollisionGeometriesForBody(plant.world_body())
    return ids | {geometry for geometry in anchored if inspector.GetName(geometry) == GROUND_NAME}
