"""Oracle: the records' poses, which numpy interpolates, and a drone that feels nothing."""

import gc

import numpy as np
import pytest
from pydrake.geometry import Role
from pydrake.math import RigidTransform
from pydrake.systems.analysis import Simulator
from pydrake.systems.framework import DiagramBuilder

from workbench.common.resources import find_world
from workbench.plant.multibody import add_plant
from workbench.plant.shapes import Box, Sphere
from workbench.plant.worlds.geometry import solid_geometry
from workbench.plant.worlds.outline import ObstaclePath
from workbench.plant.worlds.reading import read_world
from workbench.plant.worlds.world import EMPTY_WORLD, MovingObstacle, World
from workbench.systems.moving_obstacles import MOTION_END_S, add_moving_obstacles

STEP = 1 / 1024


BALL_SHAPE = Sphere(0.5)


def moving(name, rows, *, repeat=False, shape=BALL_SHAPE) -> MovingObstacle:
    times, *columns = np.transpose(np.array(rows, dtype=float))
    corners = tuple(tuple(corner) for corner in np.transpose(columns).tolist())
    geometry = solid_geometry(f"{name}::shape", shape, None)
    return MovingObstacle(name, geometry, ObstaclePath(tuple(times.tolist()), corners, repeat))


BALL = moving("ball", [[0, 1, 2, 3, 0], [0.7, 2, 2, 3, 1], [1.9, 1, 2, 3, 0]], repeat=True)
CART = moving("cart", [[0, 9, 0, 1, 0], [4, 9, 8, 2, 3]], shape=Box((1, 2, 3)))
THROUGH = moving("wave", [[0, 3, 0, 5, 0], [2, -3, 0, 5, 0], [4, 3, 0, 5, 0]], repeat=True)


class Flight:
    """A drone let go at 0, 0, 5 m in a world."""

    def __init__(self, description, *obstacles, p_WB=(0.0, 0.0, 5.0)):
        self.world = World(EMPTY_WORLD.source, "test", moving=obstacles)
        builder = DiagramBuilder()
        self.plant, self.scene_graph = add_plant(builder, description, time_step=STEP)
        add_moving_obstacles(builder, self.scene_graph, self.world)
        self.simulator = Simulator(builder.Build())
        self.base = self.plant.GetBodyByName(description.base_link)
        self.plant.SetFreeBodyPose(self.context, self.base, RigidTransform(np.array(p_WB)))

    @property
    def context(self):
        return self.plant.GetMyMutableContextFromRoot(self.simulator.get_mutable_context())

    def geometries(self, role=Role.kPerception):
        """Those of the moving obstacles, in the order of the world."""
        inspector = self.scene_graph.model_inspector()
        named = {inspector.GetName(each): each for each in inspector.GetAllGeometryIds(role)}
        return [named[f"{each.name}::shape"] for each in self.world.moving]

    def frame(self, index):
        """The frame of a moving obstacle."""
        return self.scene_graph.model_inspector().GetFrameId(self.geometries()[index])

    @property
    def query(self):
        context = self.scene_graph.GetMyContextFromRoot(self.simulator.get_context())
        return self.scene_graph.get_query_output_port().Eval(context)


@pytest.fixture(scope="module")
def still(description):
    """A flight that is not flown, to look at poses."""
    return Flight(description, BALL, CART)


TIMES = [0.0, 0.35, 0.7, 1.8999, 1.9, 1.9001, 64 * 1.9 - 0.01, 64 * 1.9 + 0.01, 3600.4, 1e5 + 0.3]


@pytest.mark.parametrize("time", TIMES)
@pytest.mark.parametrize("index", [0, 1])
def test_the_scene_has_them_where_the_world_says(still, time, index):
    still.simulator.get_mutable_context().SetTime(time)
    X_WO = still.query.GetPoseInWorld(still.frame(index))
    expected = still.world.pose(still.world.moving[index].name, time)
    assert X_WO.IsNearlyEqualTo(expected, 1e-9)


def test_at_last_they_stand_still(still):
    still.simulator.get_mutable_context().SetTime(2 * MOTION_END_S)
    X_WO = still.query.GetPoseInWorld(still.frame(0))
    assert X_WO.IsNearlyEqualTo(still.world.pose("ball", MOTION_END_S), 1e-6)


def test_sensors_and_pictures_have_them(still):
    seen = still.geometries()
    assert still.geometries(Role.kProximity) == still.geometries(Role.kIllustration) == seen
    inspector = still.scene_graph.model_inspector()
    assert [inspector.GetName(still.frame(index)) for index in (0, 1)] == ["ball", "cart"]


def test_the_plant_keeps_its_states(still):
    assert (still.plant.num_positions(), still.plant.num_velocities()) == (7, 6)


def test_a_drone_flies_through_them_and_feels_nothing(description):
    """It falls as freely as with nothing there, and distances to it become negative.

    The ball passes x = 0 at 1 s, when the drone that fell from 10 m is at 5.1 m, as the ball is.
    """
    flight, free = (Flight(description, *w, p_WB=(0, 0, 10.0)) for w in ((THROUGH,), ()))
    (ball,) = flight.geometries()
    touched = [
        geometry
        for index in flight.plant.GetBodyIndices(flight.base.model_instance())
        for geometry in flight.plant.GetCollisionGeometriesForBody(flight.plant.get_body(index))
    ]
    distances = []
    for time in (0.5, 0.9, 1.0, 1.1, 1.3):
        for each in (flight, free):
            each.simulator.AdvanceTo(time)
        states = [
            each.plant.GetPositionsAndVelocities(each.context).tobytes() for each in (flight, free)
        ]
        assert states[0] == states[1]
        pairs = [
            flight.query.ComputeSignedDistancePairClosestPoints(each, ball) for each in touched
        ]
        distances.append(min(pair.distance for pair in pairs))
        p_WB = flight.plant.GetPositions(flight.context)[4:]
        found = [
            each
            for each in flight.query.ComputeSignedDistanceToPoint(p_WB, 50.0)
            if each.id_G == ball
        ]
        p_WO = flight.world.pose("wave", time).translation()
        assert found[0].distance == pytest.approx(np.linalg.norm(p_WB - p_WO) - 0.5, abs=1e-9)
    assert distances[0] > 1.0
    assert distances[2] < -0.1
    assert distances[-1] > 0.5


def test_one_that_stands_in_the_drone_does_not_push_it(description):
    flight = Flight(description, moving("cloud", [[0, 0, 0, 5, 0], [9, 0, 0, 5, 0]]))
    flight.simulator.AdvanceTo(0.1)
    (found,) = [
        each
        for each in flight.query.ComputeSignedDistanceToPoint([0, 0, 5.0], 50.0)
        if each.id_G == flight.geometries()[0]
    ]
    assert found.distance == pytest.approx(-0.5)
    v_WB = flight.plant.GetVelocities(flight.context)
    np.testing.assert_allclose(v_WB, [0, 0, 0, 0, 0, -9.81 * 0.1], atol=0.01)


def test_the_diagram_keeps_alive_what_it_needs(description):
    flight = Flight(description, BALL)
    frame = flight.frame(0)
    gc.collect()
    flight.simulator.AdvanceTo(0.35)
    X_WO = flight.query.GetPoseInWorld(frame)
    np.testing.assert_allclose(X_WO.translation(), [1.5, 2, 3], atol=1e-9)


def test_the_shipped_world_keeps_clear_of_the_start():
    world = read_world(find_world("moving_obstacle"))
    for name in world.names:
        places = [world.pose(name, time).translation()[:2] for time in np.arange(0.0, 60.0, 0.1)]
        assert min(map(np.linalg.norm, places)) > 1.5
