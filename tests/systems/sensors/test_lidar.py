"""Scans of walls whose distances are known by hand; noise by its mean and deviation."""

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
    MakePhongIllustrationProperties,
    PerceptionProperties,
    SceneGraph,
    Sphere,
)
from pydrake.math import RigidTransform, RollPitchYaw
from pydrake.systems.analysis import Simulator
from pydrake.systems.framework import DiagramBuilder, LeafSystem

from workbench.common.errors import WorkbenchError
from workbench.plant.faults import Fault
from workbench.plant.sensors import Lidar as LidarRecord
from workbench.plant.sensors import Noise, ScanAxis
from workbench.systems.casting.caster import Caster
from workbench.systems.casting.scene import collect_scene
from workbench.systems.sensors.lidar import LIDAR_DEVIATION_M, LidarSensor
from workbench.systems.sensors.readings import LidarScan

PERIOD = 1 / 16
HOUSE = Box(20.0, 12.0, 8.0)
"""Its walls are seen from within."""


@pytest.fixture
def scene_graph():
    return SceneGraph()


def show(scene_graph, source, frame, shape, X_FG=None, *, seen=True):
    """Fix a shape to a frame, for cameras to see or only drawn."""
    instance = GeometryInstance(X_FG or RigidTransform(), shape, f"shape {id(shape)}")
    if seen:
        instance.set_perception_properties(PerceptionProperties())
    else:
        instance.set_illustration_properties(MakePhongIllustrationProperties(np.ones(4)))
    return scene_graph.RegisterGeometry(source, frame, instance)


@pytest.fixture
def house(scene_graph):
    """Return a caster of the house."""
    source = scene_graph.RegisterSource("house")
    show(scene_graph, source, scene_graph.world_frame_id(), HOUSE)
    return Caster(collect_scene(scene_graph.model_inspector()))


@pytest.fixture
def make_lidar(record, house):
    """Return what makes a lidar in the house, with settings of its record and of the system."""

    def make(caster=None, *, period=PERIOD, latency=0.0, seed=0, mounting=None, **settings):
        settings = {
            "horizontal": ScanAxis(9, -math.pi, math.pi),
            "min_range": 0.1,
            "max_range": 30.0,
        } | settings
        return LidarSensor(
            sensor=LidarRecord(**record(rate=16.0, **(mounting or {})), **settings),
            caster=caster or house,
            period=period,
            latency=latency,
            seed=seed,
        )

    return make


def standing(p_WB=(0.0, 0.0, 0.0), turn=(0.0, 0.0, 0.0)):
    """Return the state of a plant at rest."""
    q_WB = RollPitchYaw(*turn).ToQuaternion().wxyz()
    return np.concatenate([q_WB, p_WB, np.zeros(6)])


def test_rays_go_round_from_the_first_angle_to_the_last(bench, make_lidar):
    on_bench = bench(make_lidar(), state=standing())
    on_bench.settle()
    scan = on_bench.reading()
    corner = 6.0 * math.sqrt(2.0)
    expected = [10.0, corner, 6.0, corner, 10.0, corner, 6.0, corner, 10.0]
    np.testing.assert_allclose(scan.ranges, [expected], atol=1e-12)
    np.testing.assert_allclose(scan.pattern.azimuths, np.arange(-4, 5) * math.pi / 4)
    assert scan.stamp == 0.0
    assert scan.frame == "it_link"


def test_layers_are_counted_from_the_lowest_and_a_positive_one_looks_up(bench, make_lidar):
    lidar = make_lidar(horizontal=ScanAxis(2, 0.0, 0.1), vertical=ScanAxis(3, -1.5, 1.5))
    on_bench = bench(lidar, state=standing([0.0, 0.0, 1.0]))
    on_bench.settle()
    scan = on_bench.reading()
    assert scan.ranges.shape == (3, 2)
    below, level, above = scan.ranges[:, 0]
    assert below == pytest.approx(5.0 / math.sin(1.5))
    assert level == pytest.approx(10.0)
    assert above == pytest.approx(3.0 / math.sin(1.5))


def test_one_ray_looks_along_its_only_angle(bench, make_lidar):
    lidar = make_lidar(horizontal=ScanAxis(1, math.pi / 2, math.pi / 2))
    on_bench = bench(lidar, state=standing())
    on_bench.settle()
    assert on_bench.reading().ranges == pytest.approx(6.0)


def test_points_lie_on_the_walls_from_any_mounting_and_pose(bench, make_lidar):
    mounting = {
        "p_BS": (0.3, -0.2, 0.1),
        "R_BS": RollPitchYaw(0.4, -1.1, 2.0).ToRotationMatrix().matrix(),
    }
    lidar = make_lidar(
        mounting=mounting,
        horizontal=ScanAxis(60, -3.0, 3.0),
        vertical=ScanAxis(7, -0.5, 0.5),
    )
    state = standing([2.0, -1.0, 0.5], (0.5, -0.3, 1.2))
    state[:4] *= 1.001  # as the discrete plant has it
    on_bench = bench(lidar, state=state)
    on_bench.settle()
    scan = on_bench.reading()
    X_WB = RigidTransform(RollPitchYaw(0.5, -0.3, 1.2), [2.0, -1.0, 0.5])
    np.testing.assert_allclose(scan.p_WS, X_WB.multiply(np.array(mounting["p_BS"])), atol=1e-12)
    np.testing.assert_allclose(scan.R_WS, X_WB.rotation().matrix() @ mounting["R_BS"], atol=1e-12)
    points = scan.points_W()
    assert len(points) == scan.returns == 420
    on_wall = np.abs(np.abs(points) - [10.0, 6.0, 4.0]).min(axis=1)
    assert on_wall.max() < 1e-9
    assert (np.abs(points) < np.array([10.0, 6.0, 4.0]) + 1e-9).all()
    np.testing.assert_allclose(
        np.linalg.norm(scan.points_S(), axis=1), scan.ranges.ravel(), atol=1e-12
    )


def test_nothing_in_range_is_inf_and_too_near_is_minus_inf(bench, make_lidar):
    on_bench = bench(make_lidar(min_range=7.0, max_range=9.0), state=standing())
    on_bench.settle()
    scan = on_bench.reading()
    corner = pytest.approx(6.0 * math.sqrt(2.0))
    inf = math.inf
    expected = [inf, corner, -inf, corner, inf, corner, -inf, corner, inf]
    assert scan.ranges[0].tolist() == expected
    assert scan.returns == 4
    assert len(scan.points_S()) == 4


def test_the_summary_is_of_the_nearest_return(bench, make_lidar):
    on_bench = bench(make_lidar(min_range=1.0), state=standing([0.0, 5.5, 0.0]))
    on_bench.settle()
    scan = on_bench.reading()
    # the wall half a metre away is too near
    assert scan.nearest == pytest.approx(10.0)
    assert scan.nearest_direction == pytest.approx((-1.0, 0.0, 0.0))
    nothing = bench(make_lidar(max_range=1.0), state=standing())
    nothing.settle()
    assert nothing.reading().returns == 0
    assert nothing.reading().nearest == math.inf
    assert nothing.reading().nearest_direction == (0.0, 0.0, 0.0)


def test_ports_say_what_the_reading_says(bench, make_lidar):
    on_bench = bench(make_lidar(latency=0.25 * PERIOD), state=standing())
    sensor, context = on_bench.sensor, on_bench.context
    on_bench.settle()
    blank = sensor.scan_output.Eval(context)
    assert on_bench.reading() is None and math.isnan(blank.stamp)
    assert np.isnan(blank.ranges).all() and (blank.returns, len(blank.points_W())) == (0, 0)
    assert np.isnan(sensor.ranges_output.Eval(context)).all()
    on_bench.run(0.5 * PERIOD)
    scan = sensor.scan_output.Eval(context)
    np.testing.assert_array_equal(sensor.ranges_output.Eval(context), scan.ranges.ravel())
    np.testing.assert_array_equal(on_bench.measurement()[1:10], scan.ranges.ravel())
    np.testing.assert_array_equal(sensor.truth_output.Eval(context)[:9], scan.ranges.ravel())
    for array in (scan.ranges, scan.p_WS, scan.R_WS, scan.pattern.directions_S):
        with pytest.raises(ValueError, match="read-only"):
            array[0] = 0.0


def test_the_port_of_scans_is_declared_with_a_scan(make_lidar):
    # Drake from 1.58 on takes no None in a port, and others connect to it by the model's type.
    model = make_lidar().scan_output.Allocate().get_value()
    assert isinstance(model, LidarScan) and model.ranges.shape == model.pattern.shape


def test_only_truth_feeds_through(make_lidar):
    lidar = make_lidar()
    for output in (lidar.measurement_output, lidar.ranges_output, lidar.scan_output):
        assert not lidar.HasDirectFeedthrough(output.get_index())
    truth = lidar.truth_output.get_index()
    for source in (lidar.state_input, lidar.query_input):
        assert lidar.HasDirectFeedthrough(source.get_index(), truth)


@pytest.mark.parametrize("number", [3, 4096])
def test_noise_has_the_mean_and_the_deviation_asked_for(bench, make_lidar, number):
    noise = Noise(mean=0.03, stddev=0.02)
    lidar = make_lidar(noise=noise, horizontal=ScanAxis(250, -3.0, 3.0), seed=number)
    on_bench = bench(lidar, state=standing())
    truth = lidar.truth_output.Eval(on_bench.context)[:250]
    errors = on_bench.measurements(200)[:, 1:251] - truth
    assert errors.mean() == pytest.approx(0.03, rel=0.02)
    assert errors.std() == pytest.approx(0.02, rel=0.02)
    # from ray to ray and from scan to scan it is new
    assert abs(np.corrcoef(errors[:, :-1].ravel(), errors[:, 1:].ravel())[0, 1]) < 0.02
    assert abs(np.corrcoef(errors[:-1].ravel(), errors[1:].ravel())[0, 1]) < 0.02


def test_the_bias_is_drawn_once_a_seed(bench, make_lidar):
    noise = Noise(bias_mean=0.5, bias_stddev=0.1)
    biases = []
    for seed in range(150):
        lidar = make_lidar(noise=noise, seed=seed, horizontal=ScanAxis(2, 0.0, 0.1))
        on_bench = bench(lidar, state=standing())
        rows = on_bench.measurements(2)[:, 1:3]
        errors = rows - lidar.truth_output.Eval(on_bench.context)[:2]
        assert np.ptp(errors) < 1e-12
        biases.append(errors[0, 0])
    assert np.mean(biases) == pytest.approx(0.5, abs=4 * 0.1 / 12)
    assert np.std(biases) == pytest.approx(0.1, rel=0.25)


def test_equal_seeds_measure_the_same_to_the_bit_and_others_do_not(bench, make_lidar):
    noise = Noise(stddev=0.02, bias_stddev=0.1)
    first, again, other = (
        bench(make_lidar(noise=noise, seed=seed), state=standing()).measurements(20)
        for seed in (7, 7, 8)
    )
    np.testing.assert_array_equal(first, again)
    assert (first[:, 1:9] != other[:, 1:9]).all()


def test_noise_does_not_make_returns_or_carry_them_out_of_range(bench, make_lidar):
    settings = {"min_range": 6.0 - 1e-3, "max_range": 6.0 * math.sqrt(2.0) + 1e-3}
    on_bench = bench(make_lidar(noise=Noise(stddev=0.5), **settings), state=standing())
    ranges = on_bench.measurements(50)[:, 1:10]
    assert (ranges[:, [0, 4, 8]] == math.inf).all()
    met = np.delete(ranges, [0, 4, 8], axis=1)
    assert met.min() == settings["min_range"]
    assert met.max() == settings["max_range"]


def test_ranges_come_in_steps_of_the_resolution(bench, make_lidar):
    on_bench = bench(make_lidar(noise=Noise(stddev=0.1), resolution=0.25), state=standing())
    steps = on_bench.measurements(10)[:, 1:10] / 0.25
    np.testing.assert_array_equal(steps, steps.round())


@pytest.mark.parametrize(("stddev", "expected"), [(0.004, 0.04), (0.0, 10.0 * LIDAR_DEVIATION_M)])
def test_a_noisy_lidar_has_ten_times_the_deviation(bench, make_lidar, stddev, expected):
    lidar = make_lidar(noise=Noise(stddev=stddev), horizontal=ScanAxis(250, -3.0, 3.0))
    on_bench = bench(lidar, state=standing())
    on_bench.order(Fault.NOISY)
    truth = lidar.truth_output.Eval(on_bench.context)[:250]
    errors = on_bench.measurements(40)[:, 1:251] - truth
    assert errors.std() == pytest.approx(expected, rel=0.03)


class Mover(LeafSystem):
    """Moves frames along x, 4 m/s each, beginning at their own y."""

    def __init__(self, frames):
        super().__init__()
        self._frames = frames
        self.DeclareAbstractOutputPort(
            "poses", lambda: Value(FramePoseVector()), self._calc, {self.time_ticket()}
        )

    def _calc(self, context, output):
        poses = output.get_mutable_value()
        for y, frame in enumerate(self._frames):
            poses.set_value(frame, RigidTransform([4.0 * context.get_time(), 5.0 * y, 0.0]))


def test_moving_bodies_are_seen_where_they_are_and_the_own_one_is_not(make_lidar):
    """A ball that moves away, another beside it, and a third around the sensor itself."""
    builder = DiagramBuilder()
    scene_graph = builder.AddSystem(SceneGraph())
    source = scene_graph.RegisterSource("balls")
    frames = [
        scene_graph.RegisterFrame(source, GeometryFrame(name))
        for name in ("own", "beside", "ahead")
    ]
    own, beside, ahead = frames
    show(scene_graph, source, own, Sphere(0.5))
    show(scene_graph, source, beside, Sphere(0.5), RigidTransform([0.0, 0.0, 0.0]))
    show(scene_graph, source, ahead, Sphere(0.5), RigidTransform([3.0, -10.0, 0.0]))
    show(scene_graph, source, ahead, Sphere(0.5), RigidTransform([1.0, -10.0, 0.0]), seen=False)
    show(scene_graph, source, scene_graph.world_frame_id(), HalfSpace(), RigidTransform([0, 0, -2]))
    caster = Caster(collect_scene(scene_graph.model_inspector(), leave_out={own}))
    lidar = builder.AddSystem(make_lidar(caster, horizontal=ScanAxis(2, 0.0, math.pi / 2)))
    mover = builder.AddSystem(Mover(frames))
    builder.Connect(mover.get_output_port(), scene_graph.get_source_pose_port(source))
    builder.Connect(scene_graph.get_query_output_port(), lidar.query_input)
    simulator = Simulator(builder.Build())
    context = lidar.GetMyMutableContextFromRoot(simulator.get_mutable_context())
    lidar.state_input.FixValue(context, standing())
    seen = []
    for _ in range(3):
        simulator.AdvancePendingEvents()
        seen.append(lidar.reading(context).ranges[0].tolist())
        simulator.AdvanceTo(simulator.get_context().get_time() + 0.5)
    assert seen == [[2.5, 4.5], [4.5, math.inf], [6.5, math.inf]]


@pytest.mark.parametrize(
    ("settings", "said"),
    [
        ({"min_range": -1.0}, "it.*-1 to 30 m"),
        ({"min_range": 30.0}, "30 to 30 m"),
        ({"max_range": math.nan}, "nan"),
        ({"horizontal": ScanAxis(0, 0.0, 1.0)}, "horizontal scan has 0 samples"),
        ({"vertical": ScanAxis(3, 0.0, math.inf)}, "vertical scan.*finite"),
        ({"vertical": ScanAxis(10_000_000, 0.0, 1.0)}, "1000000 at most"),
    ],
)
def test_an_impossible_lidar_is_a_sentence(make_lidar, settings, said):
    with pytest.raises(WorkbenchError, match=said):
        make_lidar(**settings)
