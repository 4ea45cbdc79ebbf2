"""Oracle: heights and slopes by hand, over a plane and a table that is carried about."""

import math

import numpy as np
import pytest
from pydrake.common.value import Value
from pydrake.geometry import (
    Box,
    FramePoseVector,
    GeometryFrame,
    GeometryInstance,
    HalfSpace,
    PerceptionProperties,
    SceneGraph,
)
from pydrake.math import RigidTransform, RollPitchYaw
from pydrake.systems.analysis import Simulator
from pydrake.systems.framework import DiagramBuilder, LeafSystem

from workbench.plant.faults import FAULT_NOISE_FACTOR, Fault
from workbench.plant.multibody import add_plant
from workbench.plant.sensors import NO_NOISE, Noise, RangeFinder
from workbench.systems.casting.caster import Caster
from workbench.systems.casting.scene import anchored_frames, collect_scene
from workbench.systems.sensors import noisy_sensor as module
from workbench.systems.sensors.readings import RangeReading

PERIOD = 20 / 1024
DOWN = RollPitchYaw(0.0, math.pi / 2, 0.0).ToRotationMatrix().matrix()


def state(height, roll=0.0, pitch=0.0, x=0.0):
    q_WB = RollPitchYaw(roll, pitch, 1.0).ToQuaternion().wxyz()
    return [*q_WB, x, 0.0, height, *[0.0] * 6]


def show(scene_graph, source, frame, shape, X_FG=None):
    instance = GeometryInstance(X_FG or RigidTransform(), shape, f"shape {id(shape)}")
    instance.set_perception_properties(PerceptionProperties())
    scene_graph.RegisterGeometry(source, frame, instance)


@pytest.fixture(scope="module")
def plane():
    scene_graph = SceneGraph()
    source = scene_graph.RegisterSource("plane")
    show(scene_graph, source, scene_graph.world_frame_id(), HalfSpace())
    return Caster(collect_scene(scene_graph.model_inspector()))


@pytest.fixture
def finder(record, plane):
    def make(
        noise=NO_NOISE, resolution=0.0, caster=None, latency=0.0, p_BS=(0.0, 0.0, 0.0), R_BS=DOWN
    ):
        place = record(rate=50.0, p_BS=p_BS, R_BS=R_BS)
        limits = {"min_range": 0.05, "max_range": 20.0, "resolution": resolution}
        sensor = RangeFinder(**place, **limits, noise=noise)
        caster = caster or plane
        return module.NoisySensor(
            module.range_finder_instrument(sensor, caster), period=PERIOD, latency=latency
        )

    return make


@pytest.mark.parametrize("height", [0.2, 1.0, 7.5, 20.0])
def test_it_measures_the_height_of_the_sensor_over_the_ground(bench, finder, height):
    found = bench(finder(p_BS=(0.3, 0.0, -0.1)), state=state(height))
    found.settle()
    reading = found.reading()
    assert reading.distance == pytest.approx(height - 0.1, abs=1e-9)
    assert reading == RangeReading(0.0, "it_link", reading.distance, 0.05, 20.0)


@pytest.mark.parametrize(("roll", "pitch"), [(0.4, 0.0), (0.0, -0.6), (0.3, 0.5)])
def test_a_tilt_makes_the_way_longer(bench, finder, roll, pitch):
    found = bench(finder(), state=state(3.0, roll, pitch))
    found.settle()
    wanted = 3.0 / (math.cos(roll) * math.cos(pitch))
    assert found.reading().distance == pytest.approx(wanted, abs=1e-9)


def test_it_looks_along_its_x(bench, finder):
    """Without a turn of its own it looks forward, and sees the ground when the nose is down."""
    found = bench(finder(R_BS=np.eye(3)), state=state(3.0, pitch=0.5))
    found.settle()
    assert found.reading().distance == pytest.approx(3.0 / math.sin(0.5), abs=1e-9)


@pytest.mark.parametrize(
    ("height", "roll", "distance"),
    [(20.1, 0.0, math.inf), (3.0, math.pi, math.inf), (0.04, 0.0, -math.inf)],
)
def test_what_is_not_in_range_is_infinitely_far_or_near(bench, finder, height, roll, distance):
    found = bench(finder(Noise(stddev=0.01), resolution=0.1), state=state(height, roll))
    found.settle()
    assert found.reading().distance == distance


def test_noise_has_the_mean_and_the_deviation_asked_for(bench, finder):
    found = bench(finder(Noise(mean=0.2, stddev=0.02)), state=state(5.0))
    distances = found.measurements(3000)[:, 1]
    assert np.mean(distances) == pytest.approx(5.2, abs=0.0015)
    assert np.std(distances) == pytest.approx(0.02, rel=0.05)


@pytest.mark.parametrize(("height", "limit"), [(0.051, 0.05), (19.999, 20.0)])
def test_noise_does_not_leave_the_range(bench, finder, height, limit):
    found = bench(finder(Noise(stddev=0.02)), state=state(height))
    distances = found.measurements(100)[:, 1]
    assert (np.abs(distances - limit) < 0.2).all()
    assert ((distances >= 0.05) & (distances <= 20.0)).all()
    assert np.any(distances == limit)


def test_distances_come_in_steps_of_the_resolution(bench, finder):
    found = bench(finder(Noise(stddev=0.3), resolution=0.25), state=state(5.0))
    steps = found.measurements(50)[:, 1] / 0.25
    assert (steps == np.round(steps)).all()
    assert len(set(steps)) > 2


def test_equal_seeds_measure_the_same_to_the_bit_and_others_do_not(bench, finder):
    first, second, third = (
        bench(finder(Noise(stddev=0.01)), seed=seed, state=state(2.0)).measurements(20)
        for seed in (1, 1, 2)
    )
    assert first.tobytes() == second.tobytes()
    assert (first[:, 1] != third[:, 1]).all()


def test_a_reading_comes_late_and_says_when_it_was_taken(bench, finder):
    found = bench(finder(latency=1.5 * PERIOD), state=state(1.0))
    found.run(1.4 * PERIOD)
    assert found.reading() is None
    found.run(2.6 * PERIOD)
    assert found.reading().stamp == PERIOD


def test_a_noisy_range_finder_is_so_even_where_the_description_has_no_noise(bench, finder):
    found = bench(finder(), state=state(5.0))
    found.order(Fault.NOISY)
    spread = np.std(found.measurements(1000)[:, 1])
    assert spread == pytest.approx(FAULT_NOISE_FACTOR * 0.01, rel=0.1)


class Carrier(LeafSystem):
    """Carries a frame along x at 2 m/s."""

    def __init__(self, frame):
        super().__init__()
        self._frame = frame
        self.DeclareAbstractOutputPort(
            "poses", lambda: Value(FramePoseVector()), self._calc, {self.time_ticket()}
        )

    def _calc(self, context, output):
        pose = RigidTransform([2.0 * context.get_time(), 0.0, 0.4])
        output.get_mutable_value().set_value(self._frame, pose)


def test_what_passes_below_is_seen_where_it_is(finder):
    """A table 1 m wide, 0.5 m high, comes by under a sensor at x = 1.45 m."""
    builder = DiagramBuilder()
    scene_graph = builder.AddSystem(SceneGraph())
    source = scene_graph.RegisterSource("table")
    frame = scene_graph.RegisterFrame(source, GeometryFrame("table"))
    show(scene_graph, source, frame, Box(1.0, 1.0, 0.2))
    show(scene_graph, source, scene_graph.world_frame_id(), HalfSpace())
    caster = Caster(collect_scene(scene_graph.model_inspector()))
    sensor = builder.AddSystem(finder(caster=caster))
    carrier = builder.AddSystem(Carrier(frame))
    builder.Connect(carrier.get_output_port(), scene_graph.get_source_pose_port(source))
    builder.Connect(scene_graph.get_query_output_port(), sensor.GetInputPort("geometry_query"))
    simulator = Simulator(builder.Build())
    context = sensor.GetMyMutableContextFromRoot(simulator.get_mutable_context())
    sensor.GetInputPort("state").FixValue(context, state(2.0, x=1.45))
    sensor.GetInputPort("noise").FixValue(context, np.zeros(3))
    seen = []
    for quarter in range(6):
        if quarter:
            simulator.AdvanceTo(quarter * 0.25 * 1.024)
        simulator.AdvancePendingEvents()
        seen.append(round(sensor.reading(context).distance, 9))
    assert seen == [2.0, 2.0, 1.5, 1.5, 2.0, 2.0]


def test_on_the_shipped_drone_it_looks_down_past_its_own_body(bench, description, vehicle):
    """Its housing is 0.063 m below the base link's origin, which stands 0.136 m high."""
    builder = DiagramBuilder()
    plant, scene_graph = add_plant(builder, description, time_step=1 / 1024)
    own = {
        plant.GetBodyFrameIdOrThrow(body)
        for body in plant.GetBodyIndices(plant.GetModelInstanceByName("dh_drone"))
    }
    caster = Caster(
        collect_scene(scene_graph.model_inspector(), leave_out=own, anchored=anchored_frames(plant))
    )
    (record,) = (sensor for sensor in vehicle.sensors if sensor.kind == "range_finder")
    for height in (vehicle.ground_clearance, 4.0):
        sensor = module.NoisySensor(module.range_finder_instrument(record, caster), period=PERIOD)
        found = bench(sensor, state=state(height))
        found.settle()
        truth = sensor.truth_output.Eval(found.context)
        assert truth == pytest.approx([height - 0.063], abs=1e-9)
        assert found.reading().distance == pytest.approx(height - 0.063, abs=0.06)
