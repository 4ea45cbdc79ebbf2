"""Distances by hand from single shapes, and what is left out, sampled and warned of."""

import math

import numpy as np
import pytest
from pydrake.geometry import (
    Box,
    Capsule,
    Convex,
    Cylinder,
    Ellipsoid,
    GeometryInstance,
    HalfSpace,
    ProximityProperties,
    SceneGraph,
    Sphere,
)
from pydrake.math import RigidTransform, RollPitchYaw
from pydrake.systems.analysis import Simulator
from pydrake.systems.framework import DiagramBuilder

from workbench.plant.multibody import add_plant
from workbench.plant.reach import ReachSphere
from workbench.systems.nearest_obstacle import OBSTACLE_RANGE_M, NearestObstacle, drone_and_ground

RADIUS = 0.2
PERIOD = 1 / 8
LEAD = 1 / 1024
LEVEL = [1.0, 0.0, 0.0, 0.0]
HERE = [1.0, 2.0, 3.0]


class Scene:
    """Fixed shapes, and the system with its state input fixed, in a simulator."""

    def __init__(self, *shapes, own=(), p_BC=(0.0, 0.0, 0.0), p_WB=HERE, q_WB=LEVEL) -> None:
        builder = DiagramBuilder()
        scene_graph = builder.AddSystem(SceneGraph())
        source = scene_graph.RegisterSource("shapes")
        ids = []
        for X_WG, shape in (*shapes, *own):
            instance = GeometryInstance(X_WG, shape, f"shape{len(ids)}")
            instance.set_proximity_properties(ProximityProperties())
            ids.append(scene_graph.RegisterAnchoredGeometry(source, instance))
        self.system = builder.AddNamedSystem(
            "obstacles",
            NearestObstacle(
                reach=ReachSphere(p_BC, RADIUS),
                not_obstacles=set(ids[len(shapes) :]),
                period=PERIOD,
                lead=LEAD,
                warning_distance=1.0,
            ),
        )
        builder.Connect(
            scene_graph.get_query_output_port(), self.system.GetInputPort("geometry_query")
        )
        self.simulator = Simulator(builder.Build())
        self.context = self.system.GetMyMutableContextFromRoot(self.simulator.get_mutable_context())
        self.place(p_WB, q_WB)
        self.simulator.Initialize()

    def place(self, p_WB, q_WB=LEVEL) -> None:
        state = np.concatenate([q_WB, p_WB, np.zeros(6)])
        self.system.GetInputPort("state").FixValue(self.context, state)

    @property
    def obstacle(self) -> list[float]:
        return self.system.GetOutputPort("obstacle").Eval(self.context).tolist()

    @property
    def walls(self) -> np.ndarray:
        return self.system.GetOutputPort("walls").Eval(self.context).reshape(3, 4)


def at(*place, rpy=(0.0, 0.0, 0.0)) -> RigidTransform:
    return RigidTransform(RollPitchYaw(*rpy), place)


S = math.sqrt(0.5)


@pytest.mark.parametrize(
    ("X_WG", "shape", "distance", "direction"),
    [
        (at(5, 5, 3), Sphere(0.5), 5.0 - 0.5, (0.8, 0.6, 0.0)),
        (at(1, 2, 0), Sphere(1.5), 1.5, (0, 0, -1)),
        (at(4, 2, 3), Box(2.0, 9.0, 9.0), 2.0, (1, 0, 0)),
        (at(5, 6, 3), Box(2.0, 2.0, 9.0), 3 / S, (S, S, 0)),  # to its edge at (4, 5)
        (at(1, 7, 3, rpy=(0, 0, math.pi / 4)), Box(2.0, 2.0, 1.0), 5 - 1 / S, (0, 1, 0)),
        (at(-3, 2, 3), Cylinder(1.0, 4.0), 3.0, (-1, 0, 0)),
        (at(4, 6, 8), Cylinder(2.0, 4.0), math.hypot(3.0, 3.0), (0.6 * S, 0.8 * S, S)),  # to a rim
        (at(1, 2, 8), Cylinder(1.0, 4.0), 3.0, (0, 0, 1)),
        (at(1, 2, 8), Capsule(0.5, 4.0), 2.5, (0, 0, 1)),
        (at(1, 4, 3), Ellipsoid(9.0, 0.5, 7.0), 1.5, (0, 1, 0)),
        (at(0, 0, 1), HalfSpace(), 2.0, (0, 0, -1)),
    ],
)
def test_distance_and_direction_are_those_by_hand(X_WG, shape, distance, direction):
    clearance, *n_W, warning = Scene((X_WG, shape)).obstacle
    assert clearance == pytest.approx(distance - RADIUS, abs=1e-4)
    assert n_W == pytest.approx(direction, abs=1e-4)
    assert warning == 0.0


def test_a_hull_of_a_mesh_counts(tmp_path):
    path = tmp_path / "cube.obj"
    corners = [(x, y, z) for x in (0, 1) for y in (0, 1) for z in (0, 1)]
    faces = "f 1 2 4 3\nf 5 7 8 6\nf 1 5 6 2\nf 3 4 8 7\nf 1 3 7 5\nf 2 6 8 4\n"
    path.write_text("".join(f"v {x} {y} {z}\n" for x, y, z in corners) + faces)
    clearance, *n_W, _ = Scene((at(3.0, 1.5, 2.5), Convex(str(path), 1.0))).obstacle
    assert clearance == pytest.approx(2.0 - RADIUS)
    assert n_W == pytest.approx((1, 0, 0))


def test_from_inside_the_direction_is_the_one_deeper_in():
    clearance, *n_W, warning = Scene((at(1.8, 2, 3), Sphere(1.0))).obstacle
    assert clearance == pytest.approx(-0.2 - RADIUS)
    assert n_W == pytest.approx((1, 0, 0))
    assert warning == 1.0


def test_the_middle_turns_with_the_drone_and_its_quaternion_may_have_any_length():
    q_WB = 1.1 * RollPitchYaw(0, 0, math.pi / 2).ToQuaternion().wxyz()
    scene = Scene((at(1, 6, 3), Sphere(1.0)), p_BC=(0.5, 0.0, 0.0), q_WB=q_WB)
    assert scene.obstacle[0] == pytest.approx(2.5 - RADIUS)


def test_of_many_the_nearest_counts_and_what_is_left_out_does_not():
    scene = Scene(
        (at(1, 8, 3), Sphere(1.0)),
        (at(1, 2, -1), Box(1, 1, 1)),
        own=[(at(*HERE), Box(0.2, 0.2, 0.2)), (at(0, 0, 2.5), HalfSpace())],
    )
    clearance, *n_W, _ = scene.obstacle
    assert clearance == pytest.approx(3.5 - RADIUS)
    assert n_W == pytest.approx((0, 0, -1))


def test_out_of_range_there_is_nothing():
    nothing = [math.inf, 0.0, 0.0, 0.0, 0.0]
    assert Scene().obstacle == nothing
    assert Scene((at(1, 2.1 + OBSTACLE_RANGE_M, 3.0), Sphere(0.05))).obstacle == nothing
    assert Scene((at(1, 2.1 + OBSTACLE_RANGE_M, 3.0), Sphere(0.15))).obstacle != nothing
    assert Scene().walls.tolist() == 3 * [[0.0, 0.0, 0.0, math.inf]]


def test_it_warns_below_the_live_warning_distance():
    scene = Scene((at(4, 2, 3), Sphere(1.0)))  # 2 m to the surface
    flags = []
    for step, distance in enumerate((1.0, 1.79, 1.81, 5.0)):
        scene.context.get_mutable_numeric_parameter(0).SetFromVector([distance])
        scene.simulator.AdvanceTo((step + 1) * PERIOD)
        flags.append(scene.obstacle[4])
    assert flags == [0.0, 0.0, 1.0, 1.0]


def test_it_measures_at_the_start_and_shortly_before_each_period_ends():
    scene = Scene((at(1, 2, -8), Sphere(1.0)))
    seen = []
    for tick in range(1, 257):
        scene.place([1.0, 2.0, tick * LEAD])
        scene.simulator.AdvanceTo(tick * LEAD)
        seen.append(scene.obstacle[0])
    clearances = [height + 8.0 - 1.0 - RADIUS for height in (3.0, 128 * LEAD, 256 * LEAD)]
    first, second = seen[126], seen[127]
    assert first == pytest.approx(clearances[0])
    assert second == pytest.approx(clearances[1])
    assert set(seen[:127]) == {first}
    assert set(seen[127:255]) == {second}
    assert not scene.system.HasAnyDirectFeedthrough()


def test_the_nearest_is_named_with_its_distances_at_any_time():
    scene = Scene((at(1, 2, 5.5), Box(2, 2, 2)), (at(4, 2, 3), Sphere(1.0)))
    root = scene.simulator.get_context()
    assert scene.system.nearest(root) == pytest.approx(("shape0", 1.5 - RADIUS, 1.5))
    scene.place([1.0, 2.0, 4.75])  # in the box; nothing was sampled since
    assert scene.system.nearest(root) == pytest.approx(("shape0", -0.25 - RADIUS, -0.25))
    scene.place([1.0, 2.0, 7.0 + OBSTACLE_RANGE_M])
    assert scene.system.nearest(root) is None


def test_walls_are_the_three_nearest_in_directions_that_differ():
    """A tiled wall ahead, one at the left, a ceiling, and something farther behind."""
    tiles = [(at(4.1, 2 + y, 3), Box(0.2, 0.5, 0.5)) for y in (-1.0, -0.5, 0.0, 0.5)]
    scene = Scene(
        *tiles,
        (at(1, 6.1, 3), Box(9.0, 0.2, 9.0)),
        (at(1, 2, 8.1), Box(9.0, 9.0, 0.2)),
        (at(-9, 2, 3), Sphere(1.0)),
    )
    found = [[1, 0, 0, 3.0], [0, 1, 0, 4.0], [0, 0, 1, 5.0]]
    assert scene.walls == pytest.approx(np.array(found) - [0, 0, 0, RADIUS], abs=1e-9)


def test_of_a_plant_the_drone_and_the_ground_are_no_obstacles(description):
    builder = DiagramBuilder()
    plant, scene_graph = add_plant(builder, description, time_step=1 / 1024)
    inspector = scene_graph.model_inspector()
    found = drone_and_ground(plant, inspector, description.base_link)
    shapes = sum(len(link.collisions) for link in description.model.links)
    corners = 8  # spheres by which its box touches the ground
    assert len(found) == shapes + corners + 1
    assert sum(isinstance(inspector.GetShape(each), HalfSpace) for each in found) == 1


def test_a_free_way_ends_at_what_the_drone_flies_towards_and_passes_the_rest():
    """A box ahead, a wall that it flies along, and a sphere that it leaves."""
    x, y, z = HERE
    scene = Scene(
        (RigidTransform([x + 4.0, y, z]), Box(2.0, 2.0, 2.0)),
        (RigidTransform([x, y - 1.3, z]), Box(20.0, 2.0, 2.0)),
        (RigidTransform([x - 0.6, y, z]), Sphere(0.3)),
    )
    root = scene.simulator.get_context()
    assert scene.system.free_way(root, [1.0, 0.0, 0.0], 10.0) == (
        pytest.approx(3.0 - RADIUS, abs=0.01),
        "shape0",
    )
    assert scene.system.free_way(root, [1.0, 0.0, 0.0], 2.0) == (2.0, "")
    way, what = scene.system.free_way(root, [0.0, -1.0, 0.0], 10.0)
    assert (way, what) == (pytest.approx(0.3 - RADIUS, abs=0.01), "shape1")
    assert scene.system.free_way(root, [0.0, 1.0, 0.0], 10.0) == (10.0, "")
