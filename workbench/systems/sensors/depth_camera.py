"""The depth camera: Drake's `RgbdSensor` as truth, sampled, with noise and faults."""

import math
from dataclasses import replace
from typing import Any

import numpy as np
from pydrake.common.value import AbstractValue, Value
from pydrake.geometry import SceneGraph
from pydrake.math import RigidTransform, RotationMatrix
from pydrake.multibody.plant import MultibodyPlant
from pydrake.multibody.tree import RigidBody
from pydrake.systems.framework import BasicVector, Context, DiagramBuilder, LeafSystem, State
from pydrake.systems.sensors import ImageDepth32F, ImageRgba8U, RgbdSensor

from workbench.common.errors import WorkbenchError
from workbench.plant.sensors import DepthCamera
from workbench.systems.sensors.camera_renderer import NEAREST, add_camera_renderer, render_cameras
from workbench.systems.sensors.counted_draws import drawn_bias, sample_draws
from workbench.systems.sensors.faults import NOISE_FACTOR, Fault
from workbench.systems.sensors.pinhole import R_SC, Pinhole, make_pinhole
from workbench.systems.sensors.readings import DepthImage, fixed
from workbench.systems.sensors.sampled_sensor import LATE
from workbench.systems.weak_callback import weakly

MOST_PIXELS = 4_000_000
"""Of a picture; each takes 7 bytes."""

COLOUR_TYPES = ("rgbd", "rgbd_camera")
"""The types of sensor that have a colour picture too."""

USUAL = 0.01
"""Deviation of a common one, from which a fault makes noise where the description has none [m]."""


class DepthCameraSystem(LeafSystem):
    """Takes pictures at the end of each period and delivers them when the latency is over.

    They are abstract state, newest first. That costs other systems nothing: neither their discrete
    updates nor their unrestricted ones copy it, and a `DepthImage` is not copied but shared.
    Pictures are rendered in the update and at no other time.

    Input ports:
        depth: a picture of depth, 32F [m].
        colour: a picture of colour, for cameras that have it.
        pose: X_WC of the optical frame.
    Output port:
        image: the `DepthImage` delivered last, stamp and depth NaN before the first.
    Numeric parameter 0: `faults.Fault`.
    """

    def __init__(
        self, *, sensor: DepthCamera, period: float, latency: float = 0.0, seed: int = 0
    ) -> None:
        """Declare ports, state and sampling.

        Args:
            sensor: what the description says.
            period: between samples [s], a multiple of the physics step.
            latency: from a sample to its delivery [s].
            seed: of the noise, not negative.
        """
        super().__init__()
        self.sensor = sensor
        self.period = period
        self.latency = latency
        self._pinhole = camera_pinhole(sensor)
        self._seed = seed
        self._bias = drawn_bias(sensor.noise, seed)
        self._kept = 1 + math.ceil(latency / period - LATE)
        self.DeclareNumericParameter(BasicVector([float(Fault.NONE)]))
        self.depth_input = self.DeclareAbstractInputPort("depth", Value(ImageDepth32F()))
        self.pose_input = self.DeclareAbstractInputPort("pose", Value(RigidTransform()))
        self.colour_input = None
        if sensor.type in COLOUR_TYPES:
            self.colour_input = self.DeclareAbstractInputPort("colour", Value(ImageRgba8U()))
        self._images = self.DeclareAbstractState(AbstractValue.Make(()))
        self._count = self.DeclareDiscreteState([0.0])
        self._blank = blank = _blank(sensor, self._pinhole)
        self.image_output = self.DeclareAbstractOutputPort(
            "image",
            lambda: AbstractValue.Make(blank),
            weakly(self._calc_image),
            {self.abstract_state_ticket(self._images), self.time_ticket()},
        )
        self.DeclarePeriodicUnrestrictedUpdateEvent(period, 0.0, self._update)

    def reading(self, context: Context) -> DepthImage | None:
        """Return the picture delivered last, None if none was."""
        for image in context.get_abstract_state(int(self._images)).get_value():
            if image.stamp + self.latency <= context.get_time() + LATE:
                return image
        return None

    def samples_taken(self, context: Context) -> int:
        """Return how many samples were taken since the start."""
        return int(context.get_discrete_state(self._count).CopyToVector()[0])

    def _update(self, context: Context, state: State) -> None:
        fault = Fault(int(context.get_numeric_parameter(0).CopyToVector()[0]))
        if fault is Fault.SILENT:
            return
        images = context.get_abstract_state(int(self._images)).get_value()
        if fault is Fault.FROZEN and images:
            image = replace(images[0], stamp=context.get_time())
        else:
            image = self._image(context, NOISE_FACTOR if fault is Fault.NOISY else 1.0)
        kept = (image, *images[: self._kept - 1])
        state.get_mutable_abstract_state(int(self._images)).set_value(kept)
        state.get_mutable_discrete_state(self._count).set_value([self.samples_taken(context) + 1.0])

    def _image(self, context: Context, scale: float) -> DepthImage:
        X_WC = self.pose_input.Eval(context)
        colour = None
        if self.colour_input is not None:
            colour = fixed(self.colour_input.Eval(context).data[:, :, :3].copy())
        return DepthImage(
            stamp=context.get_time(),
            frame=self.sensor.frame,
            p_WS=fixed(X_WC.translation()),
            R_WS=fixed(X_WC.rotation().matrix() @ R_SC.T),
            pinhole=self._pinhole,
            depth=fixed(self._depth(context, scale)),
            colour=colour,
        )

    def _depth(self, context: Context, scale: float) -> np.ndarray:
        """Return depth with noise on its returns, which never leave the sensor's range."""
        depth: np.ndarray = self.depth_input.Eval(context).data[:, :, 0].copy()
        depth[depth == 0.0] = -np.inf
        noise = self.sensor.noise
        deviation = noise.stddev if scale == 1.0 else scale * (noise.stddev or USUAL)
        offset = noise.mean + self._bias
        if deviation == 0.0 and offset == 0.0 and noise.precision == 0.0:
            return depth
        seen = np.isfinite(depth)
        measured: np.ndarray = depth + np.float32(offset)
        if deviation > 0.0:
            number = round(context.get_time() / self.period)
            normal = sample_draws(self._seed, number).standard_normal(depth.shape, np.float32)
            measured += np.float32(deviation) * normal
        if noise.precision > 0.0:
            measured = np.float32(noise.precision) * np.round(measured / noise.precision)
        depth[seen] = np.clip(measured[seen], self.sensor.near, self.sensor.far)
        return depth

    def _calc_image(self, context: Context, output: Any) -> None:
        output.set_value(self.reading(context) or self._blank)


def _blank(sensor: DepthCamera, pinhole: Pinhole) -> DepthImage:
    """Return what the port holds before the first picture: it shows nothing and takes no memory."""
    pixels = (sensor.height, sensor.width)
    has_colour = sensor.type in COLOUR_TYPES
    return DepthImage(
        stamp=math.nan,
        frame=sensor.frame,
        p_WS=fixed(np.full(3, math.nan)),
        R_WS=fixed(np.full((3, 3), math.nan)),
        pinhole=pinhole,
        depth=np.broadcast_to(np.float32(math.nan), pixels),
        colour=np.broadcast_to(np.uint8(0), (*pixels, 3)) if has_colour else None,
    )


def add_depth_camera(
    builder: DiagramBuilder,
    plant: MultibodyPlant,
    scene_graph: SceneGraph,
    body: RigidBody,
    sensor: DepthCamera,
    *,
    name: str,
    period: float,
    latency: float = 0.0,
    seed: int = 0,
) -> DepthCameraSystem:
    """Add a depth camera, and the renderer it sees with if there is none yet.

    Args:
        builder: of the diagram.
        plant: finalised.
        scene_graph: of the plant.
        body: the vehicle's base, on which the sensor's pose is given.
        sensor: what the description says.
        name: of its system in the diagram.
        period: between samples [s], a multiple of the physics step.
        latency: from a sample to its delivery [s].
        seed: of the noise, not negative.

    Raises:
        WorkbenchError: if no pinhole camera sees what is asked.
    """
    add_camera_renderer(plant, scene_graph, body)
    depth, colour = render_cameras(camera_pinhole(sensor), sensor.near, sensor.far)
    X_BC = RigidTransform(
        RotationMatrix(np.array(sensor.R_BS)) @ RotationMatrix(R_SC), np.array(sensor.p_BS)
    )
    frame = plant.GetBodyFrameIdOrThrow(body.index())
    truth = builder.AddNamedSystem(f"{name}_truth", RgbdSensor(frame, X_BC, colour, depth))
    system = builder.AddNamedSystem(
        name,
        DepthCameraSystem(sensor=sensor, period=period, latency=latency, seed=seed),
    )
    builder.Connect(scene_graph.get_query_output_port(), truth.query_object_input_port())
    builder.Connect(truth.depth_image_32F_output_port(), system.depth_input)
    builder.Connect(truth.body_pose_in_world_output_port(), system.pose_input)
    if system.colour_input is not None:
        builder.Connect(truth.color_image_output_port(), system.colour_input)
    return system


def camera_pinhole(sensor: DepthCamera) -> Pinhole:
    """Return the intrinsics that a description means.

    Raises:
        WorkbenchError: if no pinhole camera sees so much or so near, or no memory holds it.
    """
    if not 0.0 < sensor.horizontal_fov < math.pi:
        raise WorkbenchError(
            f"sensor '{sensor.name}': horizontal_fov of {sensor.horizontal_fov:g} rad: "
            "give it an angle between 0 and pi"
        )
    if sensor.width * sensor.height > MOST_PIXELS:
        raise WorkbenchError(
            f"sensor '{sensor.name}': pictures of {sensor.width} x {sensor.height}: "
            f"give it up to {MOST_PIXELS} pixels"
        )
    if sensor.far <= NEAREST:
        raise WorkbenchError(
            f"sensor '{sensor.name}': its clip ends at {sensor.far:g} m: give it a far end beyond "
            f"the {NEAREST:g} m from which on it is drawn"
        )
    return make_pinhole(sensor.width, sensor.height, sensor.horizontal_fov)
