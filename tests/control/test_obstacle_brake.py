"""Ways that braking takes, by bisection; and in flight, with law, mode and nearest obstacle."""

import math

import numpy as np
import pytest
from pydrake.geometry import Box, Cylinder, GeometryInstance, ProximityProperties
from pydrake.math import RigidTransform
from pydrake.systems.analysis import Simulator
from pydrake.systems.framework import DiagramBuilder

from workbench.control.flight_mode import FlightModeSettings, initial_state
from workbench.control.mode import FlightMode
from workbench.control.obstacle_brake import braked
from workbench.diagram.core import add_sampled_core
from workbench.plant.placing import body_state
from workbench.plant.reach import reach_sphere
from workbench.scenario.scenario import Rates, Scenario
from workbench.session.integration import Integration
from workbench.setup import make_setup
from workbench.systems.mode_manager import ModeManager
from workbench.systems.nearest_obstacle import NearestObstacle, drone_and_ground

HEIGHT = 5.0
STOP = 0.5
UNDERSHOOT = 0.02
"""So much nearer than it should the drone may come: the velocity loop lags [m]."""
FLOOR = FlightModeSettings(1.0, 0.4, 0.1)
RATES = Rates()


def wall(n_W, place) -> list[float]:
    return [*(np.array(n_W) / np.linalg.norm(n_W)), place]


def behind(*walls) -> list[float]:
    """Return up to three walls, nearest first, as the law has them."""
    numbers = [number for each in walls for number in each]
    return numbers + [0.0] * (12 - len(numbers))


def allowed(way: float, brake: float, slowing: float) -> float:
    """Return the speed towards a wall, by the way that braking takes: found by bisection."""

    def needed(v):
        at_rate = min(v, slowing / brake)  # below it the speed falls off at the rate `brake`
        return at_rate / brake + (v * v - at_rate * at_rate) / (2.0 * slowing)

    low, high = 0.0, 1000.0
    for _ in range(80):
        middle = 0.5 * (low + high)
        low, high = (middle, high) if needed(middle) < way else (low, middle)
    return low if way > 0.0 else max(brake * way, -0.5)


@pytest.mark.parametrize("way", [-9.0, -0.3, 0.0, 0.2, 3.0, 4.0, 5.0, 20.0])
@pytest.mark.parametrize("brake", [0.1, 1.0, 1.5])
def test_towards_a_wall_only_the_speed_that_stops_in_time_is_left(way, brake):
    n_W = np.array([2.0, -1.0, 2.0]) / 3.0
    across = np.array([1.0, 2.0, 0.0]) / math.sqrt(5.0)
    p_WB = np.array([3.0, 4.0, 5.0])
    walls = behind(wall(n_W, n_W @ p_WB + way))
    found = np.array(braked(*(9000.0 * n_W + 7.0 * across), p_WB.tolist(), brake, walls, 4.0))
    assert n_W @ found == pytest.approx(allowed(way, brake, 4.0), abs=1e-9)
    assert across @ found == pytest.approx(7.0)


def test_along_a_wall_and_away_from_it_nothing_is_changed():
    walls = behind(wall((1, 0, 0), 1.0))
    for v_WB in ((0.0, 3.0, -2.0), (-4.0, 1.0, 0.0), (0.2, 5.0, 1.0)):
        assert braked(*v_WB, [0.5, 0.0, 0.0], 1.0, walls, 4.0) == v_WB


def test_in_a_corner_every_wall_counts():
    walls = behind(wall((1, 0, 0), 0.1), wall((0, 1, 0), 0.2), wall((0, 0, 1), 0.3))
    assert braked(5.0, 5.0, 5.0, [0, 0, 0], 1.0, walls, 4.0) == pytest.approx((0.1, 0.2, 0.3))


def test_where_walls_are_at_odds_the_nearest_has_its_way():
    walls = behind(wall((1, 0, 0), -0.1), wall((-1, 0.2, 0), -0.1))
    assert braked(0.0, 0.0, 0.0, [0, 0, 0], 1.0, walls, 4.0)[0] == pytest.approx(-0.1)


def wall_ahead(x: float):
    """A wall whose face is at x."""
    return RigidTransform([x + 0.5, 0.0, HEIGHT]), Box(1.0, 60.0, 60.0)


@pytest.fixture
def fly(description, vehicle):
    """Return a function that flies at a velocity among shapes; positions and velocities (N, 3)."""

    def flown(shapes, velocity, settings: FlightModeSettings, duration: float, sees: bool = True):
        builder = DiagramBuilder()
        setup = make_setup(Scenario(rates=RATES), description=description, vehicle=vehicle)
        airframe, computer = add_sampled_core(builder, setup)
        scene_graph, plant = airframe.scene_graph, airframe.plant
        source = scene_graph.RegisterSource("walls")
        for index, (X_WG, shape) in enumerate(shapes):
            geometry = GeometryInstance(X_WG, shape, f"wall{index}")
            geometry.set_proximity_properties(ProximityProperties())
            scene_graph.RegisterAnchoredGeometry(source, geometry)
        modes = ModeManager(
            period=RATES.mode_period,
            settings=settings,
            standing_height=vehicle.ground_clearance,
        )
        builder.AddNamedSystem("modes", modes)
        if sees:
            inspector = scene_graph.model_inspector()
            obstacles = NearestObstacle(
                reach=reach_sphere(description.model, description.base_link, description.rotors),
                not_obstacles=drone_and_ground(plant, inspector, description.base_link),
                period=RATES.mode_period,
                lead=RATES.physics_step,
                warning_distance=1.0,
            )
            builder.AddNamedSystem("obstacles", obstacles)
            builder.Connect(airframe.state, obstacles.GetInputPort("state"))
            builder.Connect(
                scene_graph.get_query_output_port(), obstacles.GetInputPort("geometry_query")
            )
            builder.Connect(obstacles.walls_output, modes.GetInputPort("walls"))
        builder.Connect(airframe.state, modes.GetInputPort("state"))
        builder.Connect(modes.GetOutputPort("guidance"), computer.GetInputPort("guidance"))
        simulator = Simulator(builder.Build())
        root = simulator.get_mutable_context()
        at, still, reference = [0.0, 0.0, HEIGHT], [0.0] * 3, [*velocity, *[0.0] * 5]
        mode_context = modes.GetMyMutableContextFromRoot(root)
        modes.GetInputPort("reference").FixValue(mode_context, reference)
        modes.GetInputPort("request").FixValue(mode_context, still)
        modes.GetInputPort("charge").FixValue(mode_context, [1.0])
        modes.set_mode(mode_context, initial_state(FlightMode.HOVERING, at), at)
        computer_context = computer.GetMyMutableContextFromRoot(root)
        computer.GetInputPort("reference").FixValue(computer_context, reference)
        computer.begin(computer_context, vehicle.hover_speeds, np.zeros(3))
        state = body_state(p_WB=at, roll_pitch_yaw=still, v_WB=still, w_WB=still)
        airframe.place(root, state, vehicle.hover_speeds)
        integration = Integration(simulator, airframe, RATES)
        states = []
        for tick in range(1, int(32 * duration) + 1):
            integration.advance(round(tick / 32 / RATES.physics_step))
            states.append(airframe.body_state(root))
        flight = np.array(states)
        return flight[:, 4:7], flight[:, 10:13]

    return flown


@pytest.fixture
def radius(description):
    return reach_sphere(description.model, description.base_link, description.rotors).radius


@pytest.mark.parametrize(
    ("speed", "brake", "duration"),
    [
        pytest.param(2.0, 0.5, 9.0, marks=pytest.mark.slow),
        pytest.param(2.0, 1.0, 6.0, marks=pytest.mark.slow),
        (2.0, 1.5, 6.0),
        (8.0, 1.5, 5.0),
    ],
)
def test_at_a_wall_it_stops(fly, radius, speed, brake, duration):
    settings = FLOOR._replace(obstacle_brake=brake, stop_distance=STOP)
    distance = 6.0 if speed < 5.0 else 16.0
    p_WB, v_WB = fly([wall_ahead(distance)], (speed, 0.0, 0.0), settings, duration)
    clearance = distance - p_WB[:, 0] - radius
    assert clearance.min() > STOP - UNDERSHOOT
    assert clearance[-1] < STOP + 0.15
    assert v_WB[:, 0].max() > 0.8 * min(speed, 7.0)  # it is no crawl all the way


def test_along_a_wall_it_is_not_slowed(fly, radius):
    wall = [wall_ahead(radius + STOP + 0.3)]
    settings = FLOOR._replace(obstacle_brake=1.0, stop_distance=STOP)
    along, v_WB = fly(wall, (0.0, 2.0, 0.0), settings, 3.0)
    free, v_free = fly([], (0.0, 2.0, 0.0), settings, 3.0)
    assert along == pytest.approx(free, abs=2e-3)
    assert v_WB == pytest.approx(v_free, abs=2e-3)


@pytest.mark.slow
def test_in_a_corner_it_stops_at_both_walls(fly, radius):
    walls = [wall_ahead(4.0), (RigidTransform([0.0, 4.6, HEIGHT]), Box(60.0, 1.0, 60.0))]
    settings = FLOOR._replace(obstacle_brake=1.0, stop_distance=STOP)
    p_WB, _ = fly(walls, (2.0, 2.0, 0.0), settings, 8.0)
    for ahead, face in ((p_WB[:, 0], 4.0), (p_WB[:, 1], 4.1)):
        clearance = face - ahead - radius
        assert clearance.min() > STOP - UNDERSHOOT
        assert clearance[-1] < STOP + 0.1


@pytest.mark.slow
def test_a_post_in_the_way_is_passed_at_its_side(fly, radius):
    post = [(RigidTransform([5.0, 0.05, HEIGHT]), Cylinder(0.4, 60.0))]
    settings = FLOOR._replace(obstacle_brake=1.0, stop_distance=STOP)
    p_WB, _ = fly(post, (2.0, 0.0, 0.0), settings, 12.0)
    clearance = np.hypot(p_WB[:, 0] - 5.0, p_WB[:, 1] - 0.05) - 0.4 - radius
    assert clearance.min() > STOP - UNDERSHOOT
    assert p_WB[-1, 0] > 7.0


def test_what_is_too_near_is_left_gently(fly, radius):
    settings = FLOOR._replace(obstacle_brake=1.5, stop_distance=1.5)
    p_WB, v_WB = fly([wall_ahead(radius + 0.1)], (0.0, 0.0, 0.0), settings, 6.0)
    clearance = radius + 0.1 - p_WB[:, 0] - radius
    assert clearance[-1] == pytest.approx(1.5, abs=0.05)
    assert math.isclose(-v_WB[:, 0].min(), 0.5, abs_tol=0.06)


def test_without_a_brake_the_flight_is_the_same(fly):
    """But for steps of the integrator, which end where the nearest obstacle is searched."""
    settings = FLOOR._replace(obstacle_brake=0.0)
    wall = [wall_ahead(20.0)]
    with_it = fly(wall, (2.0, 1.0, 0.5), settings, 2.0)
    without = fly(wall, (2.0, 1.0, 0.5), settings, 2.0, sees=False)
    for one, other in zip(with_it, without, strict=True):
        assert one == pytest.approx(other, abs=1e-7)
