"""Sampling, noise and faults of the camera, in front of a picture that is made up."""

import copy
import gc
import math
import weakref
from dataclasses import replace

import numpy as np
import pytest
from pydrake.common.value import Value
from pydrake.math import RigidTransform
from pydrake.systems.analysis import Simulator
from pydrake.systems.framework import DiagramBuilder, LeafSystem
from pydrake.systems.sensors import ImageDepth32F, ImageRgba8U

from workbench.common.errors import WorkbenchError
from workbench.plant.faults import Fault
from workbench.plant.sensors import DepthCamera, Noise
from workbench.systems.sensors.depth_camera import DepthCameraSystem
from workbench.systems.sensors.readings import DepthImage

PERIOD = 64 / 1024
WIDTH, HEIGHT = 320, 240
EYE = ((1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0))
SENSOR = DepthCamera(
    name="camera",
    type="rgbd_camera",
    frame="camera_link",
    link="base_link",
    rate=15.0,
    p_BS=(0.0, 0.0, 0.0),
    R_BS=EYE,
    width=WIDTH,
    height=HEIGHT,
    horizontal_fov=1.047,
    near=0.1,
    far=10.0,
)
NOISY = replace(SENSOR, noise=Noise(mean=0.02, stddev=0.01))


class MadeUpPicture(LeafSystem):
    """A wall at 2 m and a bit more each second; nothing left of it, too near in the first row."""

    def __init__(self):
        super().__init__()
        self.rendered = 0
        for name, calc, value in (
            ("depth", self._depth, ImageDepth32F(WIDTH, HEIGHT)),
            ("colour", self._colour, ImageRgba8U(WIDTH, HEIGHT)),
            ("pose", self._pose, RigidTransform()),
        ):
            self.DeclareAbstractOutputPort(name, lambda value=value: Value(value), calc)

    def _depth(self, context, output):
        self.rendered += 1
        data = output.get_mutable_value().mutable_data
        data[:] = 2.0 + context.get_time()
        data[:, : WIDTH // 2] = np.inf
        data[0] = 0.0

    def _colour(self, context, output):
        red = 1 + round(context.get_time() / PERIOD)
        output.get_mutable_value().mutable_data[:] = [red, 2, 3, 255]

    def _pose(self, context, output):
        output.set_value(RigidTransform([context.get_time(), 0.0, 1.0]))


class Setup:
    def __init__(self, sensor=SENSOR, **arguments):
        builder = DiagramBuilder()
        self.picture = builder.AddSystem(MadeUpPicture())
        arguments = {"period": PERIOD} | arguments
        self.camera = builder.AddSystem(DepthCameraSystem(sensor=sensor, **arguments))
        builder.Connect(self.picture.GetOutputPort("depth"), self.camera.depth_input)
        builder.Connect(self.picture.GetOutputPort("pose"), self.camera.pose_input)
        if self.camera.colour_input is not None:
            builder.Connect(self.picture.GetOutputPort("colour"), self.camera.colour_input)
        self.simulator = Simulator(builder.Build())
        self.simulator.Initialize()
        self.root = self.simulator.get_mutable_context()
        self.context = self.camera.GetMyMutableContextFromRoot(self.root)

    def order(self, fault):
        self.context.get_mutable_numeric_parameter(0).SetFromVector([float(fault)])

    def at(self, time):
        """Return what is delivered just after `time`."""
        self.simulator.AdvanceTo(time + 1 / 1024)
        return self.camera.reading(self.context)


def test_pictures_are_taken_once_a_period_and_stamped_then():
    setup = Setup()
    assert setup.camera.reading(setup.context) is None
    assert math.isnan(setup.camera.image_output.Eval(setup.context).stamp)
    stamps = [setup.at(n * PERIOD).stamp for n in range(17)]
    assert stamps == [n * PERIOD for n in range(17)]
    assert setup.camera.samples_taken(setup.context) == 17


@pytest.mark.parametrize("kind", ["rgbd", "depth"])
def test_the_port_of_pictures_is_declared_with_a_picture(kind):
    # Drake from 1.58 on takes no None in a port, and others connect to it by the model's type.
    camera = Setup(replace(SENSOR, type=kind)).camera
    model = camera.image_output.Allocate().get_value()
    assert isinstance(model, DepthImage) and math.isnan(model.stamp)
    assert model.depth.shape == (HEIGHT, WIDTH) and np.isnan(model.depth).all()
    assert len(model.points_W()) == 0
    assert (model.colour is None) == (kind == "depth")


def test_a_picture_shows_the_truth_at_its_stamp():
    image = Setup().at(3 * PERIOD)
    assert image.depth[5, -1] == np.float32(2.0 + 3 * PERIOD)
    np.testing.assert_allclose(image.p_WS, [3 * PERIOD, 0.0, 1.0])
    assert (image.frame, image.depth.shape) == ("camera_link", (HEIGHT, WIDTH))


def test_it_is_delivered_when_the_latency_is_over():
    latency = 2.5 * PERIOD
    setup = Setup(latency=latency)
    assert setup.at(2.25 * PERIOD) is None
    for time in (2.5, 3.0, 3.25, 7.0, 7.5):
        assert setup.at(time * PERIOD).stamp == np.floor(time - 2.5) * PERIOD


def test_nothing_is_rendered_between_samples_nor_while_silent():
    setup = Setup()
    for step in range(16 * 8):
        setup.at(step * PERIOD / 8)
        setup.camera.image_output.Eval(setup.context)
    assert setup.picture.rendered == 16
    setup.order(Fault.SILENT)
    setup.at(32 * PERIOD)
    assert setup.picture.rendered == 16


def test_out_of_range_is_infinite():
    image = Setup(NOISY).at(0.0)
    assert (image.depth[0] == -np.inf).all()
    assert (image.depth[1:, : WIDTH // 2] == np.inf).all()
    assert np.isfinite(image.depth[1:, WIDTH // 2 :]).all()
    assert image.points().shape == ((HEIGHT - 1) * WIDTH // 2, 3)


@pytest.mark.parametrize(
    ("noise", "fault", "mean", "stddev"),
    [
        (Noise(mean=0.02, stddev=0.01), Fault.NONE, 0.02, 0.01),
        (Noise(mean=0.02, stddev=0.01), Fault.NOISY, 0.02, 0.1),
        (Noise(stddev=0.02, bias_mean=-0.1), Fault.NONE, -0.1, 0.02),
        (Noise(), Fault.NOISY, 0.0, 0.1),
    ],
)
def test_noise_has_the_mean_and_deviation_that_were_asked(noise, fault, mean, stddev):
    setup = Setup(replace(SENSOR, noise=noise))
    setup.order(fault)
    errors = []
    for n in range(4):
        image = setup.at(n * PERIOD)
        errors.append(image.depth[1:, WIDTH // 2 :].astype(float) - 2.0 - n * PERIOD)
    assert np.mean(errors) == pytest.approx(mean, abs=max(1e-6, 0.02 * stddev))
    assert np.std(errors) == pytest.approx(stddev, rel=0.02, abs=1e-6)


def test_a_bias_is_drawn_once():
    setup = Setup(replace(SENSOR, noise=Noise(bias_stddev=0.1)), seed=5)
    errors = [setup.at(n * PERIOD).depth[1:, -9:] - 2.0 - n * PERIOD for n in range(3)]
    assert np.ptp(errors) < 1e-6
    other = Setup(replace(SENSOR, noise=Noise(bias_stddev=0.1)), seed=6)
    assert abs(other.at(0.0).depth[5, -1] - 2.0 - errors[0][0, 0]) > 1e-3


def test_depth_is_rounded_to_its_precision():
    depth = Setup(replace(SENSOR, noise=Noise(stddev=0.1, precision=0.25))).at(0.0).depth
    assert set(np.unique(depth[np.isfinite(depth)])) == {1.5, 1.75, 2.0, 2.25, 2.5}


def test_measured_depth_stays_within_range():
    depth = Setup(replace(SENSOR, noise=Noise(stddev=50.0))).at(0.0).depth
    seen = depth[np.isfinite(depth)]
    assert (seen.min(), seen.max()) == (np.float32(0.1), np.float32(10.0))


def test_equal_seeds_give_equal_pictures_and_others_do_not():
    one, same, other = Setup(NOISY, seed=7), Setup(NOISY, seed=7), Setup(NOISY, seed=8)
    for n in range(3):
        first, second, third = (setup.at(n * PERIOD).depth for setup in (one, same, other))
        np.testing.assert_array_equal(first, second)
        assert (first != third)[5, WIDTH // 2 :].mean() > 0.9


def test_no_two_samples_have_the_same_noise():
    setup = Setup(NOISY)
    first, second = (setup.at(n * PERIOD).depth - n * PERIOD for n in range(2))
    assert abs(np.corrcoef(first[1:, -99:].ravel(), second[1:, -99:].ravel())[0, 1]) < 0.03


def test_a_frozen_camera_sends_its_last_picture_with_new_stamps():
    setup = Setup(NOISY)
    last = setup.at(PERIOD)
    setup.order(Fault.FROZEN)
    frozen = setup.at(3 * PERIOD)
    assert frozen.stamp == 3 * PERIOD
    np.testing.assert_array_equal(frozen.depth, last.depth)
    np.testing.assert_array_equal(frozen.colour, last.colour)
    np.testing.assert_array_equal(frozen.p_WS, last.p_WS)
    setup.order(Fault.NONE)
    assert setup.at(4 * PERIOD).depth[5, -1] != last.depth[5, -1]


def test_a_camera_frozen_from_the_start_has_one_picture():
    setup = Setup()
    setup.order(Fault.FROZEN)
    assert setup.at(0.0).depth[5, -1] == setup.at(3 * PERIOD).depth[5, -1] == 2.0


def test_a_silent_camera_sends_nothing_new():
    setup = Setup()
    last = setup.at(PERIOD)
    setup.order(Fault.SILENT)
    assert setup.at(5 * PERIOD) is last
    assert setup.camera.samples_taken(setup.context) == 2
    setup.order(Fault.NONE)
    assert setup.at(6 * PERIOD).stamp == 6 * PERIOD


def test_a_picture_never_changes_and_is_never_copied():
    setup = Setup()
    image = setup.at(0.0)
    for array in (image.depth, image.colour, image.p_WS, image.R_WS):
        assert not array.flags.writeable
    assert copy.deepcopy(image) is image
    clone = setup.camera.GetMyContextFromRoot(setup.root.Clone())
    assert setup.camera.reading(clone) is image
    assert setup.camera.image_output.Eval(setup.context) is image
    depth, colour = image.depth.copy(), image.colour.copy()
    setup.at(5 * PERIOD)
    np.testing.assert_array_equal(image.depth, depth)
    np.testing.assert_array_equal(image.colour, colour)
    np.testing.assert_array_equal(image.p_WS, [0.0, 0.0, 1.0])


def test_a_picture_ends_with_the_flight_that_took_it():
    setup = Setup()
    image = weakref.ref(setup.at(0.0))
    setup.simulator = setup.root = setup.context = None  # as a reset leaves them
    gc.collect()
    assert image() is None


@pytest.mark.parametrize(
    ("kind", "has_colour"),
    [("rgbd", True), ("rgbd_camera", True), ("depth", False), ("depth_camera", False)],
)
def test_the_type_decides_whether_there_is_colour(kind, has_colour):
    image = Setup(replace(SENSOR, type=kind)).at(0.0)
    assert (image.colour is not None) == has_colour
    if has_colour:
        assert image.colour.shape == (HEIGHT, WIDTH, 3)
        assert image.colour[7, 7].tolist() == [1, 2, 3]


@pytest.mark.parametrize("fov", [0.0, 3.15, 6.0])
def test_an_angle_of_view_that_no_pinhole_has_is_refused(fov):
    with pytest.raises(WorkbenchError, match="sensor 'camera': horizontal_fov .* between 0 and pi"):
        DepthCameraSystem(sensor=replace(SENSOR, horizontal_fov=fov), period=PERIOD)


def test_a_picture_that_no_memory_holds_is_refused():
    with pytest.raises(WorkbenchError, match="16384 x 16384: give it up to 4000000 pixels"):
        DepthCameraSystem(sensor=replace(SENSOR, width=16384, height=16384), period=PERIOD)


@pytest.mark.parametrize("far", [1e-3, 1e-6])
def test_a_clip_that_ends_before_anything_is_drawn_is_refused(far):
    with pytest.raises(WorkbenchError, match=f"sensor 'camera': its clip ends at {far:g} m"):
        DepthCameraSystem(sensor=replace(SENSOR, near=0.0, far=far), period=PERIOD)
