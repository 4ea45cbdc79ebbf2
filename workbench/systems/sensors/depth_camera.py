"""The depth camera: Drake's `RgbdSensor` as truth, sampled, with noise and faults."""

import logging
import math
from dataclasses import replace

import numpy as np
from pydrake.common.value import AbstractValue, Value
from pydrake.geometry import (
    Box,
    ClippingRange,
    ColorRenderCamera,
    DepthRange,
    DepthRenderCamera,
    GeometryInstance,
    HalfSpace,
    LightParameter,
    MakeRenderEngineVtk,
    RenderCameraCore,
    RenderEngineVtkParams,
    Role,
    SceneGraph,
)
from pydrake.math import RigidTransform, RotationMatrix
from pydrake.multibody.plant import MultibodyPlant
from pydrake.multibody.tree import RigidBody
from pydrake.systems.framework import BasicVector, Context, DiagramBuilder, State
from pydrake.systems.sensors import CameraInfo, ImageDepth32F, ImageRgba8U, RgbdSensor

from workbench.common.errors import WorkbenchError
from workbench.link.picture import Pinhole
from workbench.plant.faults import FAULT_NOISE_FACTOR, Fault
from workbench.plant.sensors import DepthCamera
from workbench.systems.casting.scene import anchored_frames
from workbench.systems.discrete_system import DiscreteSystem
from workbench.systems.noise import drawn_sensor_bias, sample_draws
from workbench.systems.sensors.readings import R_SC, DepthImage, make_pinhole, read_only
from workbench.systems.sensors.sampled_sensor import LATENCY_TOLERANCE_S
from workbench.systems.weak_callback import weakly

CAMERA_RENDERER = "cameras"
"""Name of the cameras' renderer in the scene graph."""
GROUND_SIDE_M = 2000.0
"""Side of the square that represents a half-space [m]."""
COLOUR_RANGE_M = 1000.0
"""Range of colours [m]; the sensor's `far` limits only depth."""
MIN_DRAWN_DEPTH_M = 1e-3
"""Smallest drawn depth [m]."""
_MAX_DRAKE_CHARS = 300
"""Largest number of characters of Drake's message in an error."""
_SKY = (0.72, 0.84, 0.95)
_LIGHTS = (
    # The sun, from the south-west, a little of it from the other side, and a lamp at the camera,
    # so that no face that a camera can see is black.
    LightParameter(frame="world", direction=[0.5, 0.6, -1.0], intensity=0.8),
    LightParameter(frame="world", direction=[-0.6, -0.5, -0.4], intensity=0.2),
    LightParameter(frame="camera", direction=[0.0, 0.0, 1.0], intensity=0.3),
)
MAX_PICTURE_PIXELS = 4_000_000
"""Largest number of pixels of a picture, with 7 bytes each."""
CAMERA_DEVIATION_M = 0.01
"""Deviation of a common camera, for a fault of a camera without noise [m]."""


def add_camera_renderer(plant: MultibodyPlant, scene_graph: SceneGraph, body: RigidBody) -> None:
    """Add a renderer of the scene without the vehicle, once for a scene graph.

    Depths of flat faces are exact to 0.01 mm, those of the ground to 0.2 mm. Spheres and cylinders
    are drawn with facets, which lie up to 0.25 % of the radius inside them. The 5000 triangles of a
    sphere take as long to draw as a dozen boxes.

    Args:
        plant: finalised, with all bodies that have half-spaces.
        scene_graph: to which the renderer is added, if it has none.
        body: the vehicle's base. No renderer draws the shapes that are fixed to it, because a
            housing around a camera would blind it. Lidars do not see their vehicle either.

    Raises:
        WorkbenchError: if the renderer refuses a mesh, such as an OBJ without normals.
    """
    if scene_graph.HasRenderer(CAMERA_RENDERER):
        return
    # EGL by default on Linux: it needs no screen.
    parameters = RenderEngineVtkParams(default_clear_color=_SKY, lights=list(_LIGHTS))
    renderer = MakeRenderEngineVtk(parameters)
    try:
        scene_graph.AddRenderer(CAMERA_RENDERER, renderer)
    except RuntimeError as error:
        reason = " ".join(str(error).split())[:_MAX_DRAKE_CHARS].rstrip(". ")
        raise WorkbenchError(
            f"the camera cannot draw a mesh: {reason}: give the mesh what it lacks (as normals), "
            "or take it out"
        ) from error
    for part in plant.GetBodiesWeldedTo(body):
        frame = plant.GetBodyFrameIdOrThrow(part.index())
        scene_graph.RemoveRole(plant.get_source_id(), frame, Role.kPerception)
    _widen_half_spaces(plant, scene_graph)


def _widen_half_spaces(plant: MultibodyPlant, scene_graph: SceneGraph) -> None:
    """Add a slab under each fixed half-space, because the renderer draws only 100 m of it.

    The renderer uses single precision: a slab of 2 km has a depth error of 0.2 mm, one of 10 km of
    1 mm.
    """
    inspector = scene_graph.model_inspector()
    anchored = anchored_frames(plant) | {scene_graph.world_frame_id(): RigidTransform()}
    source = scene_graph.RegisterSource("ground_in_pictures")
    thickness = 1.0
    for id in inspector.GetAllGeometryIds(Role.kPerception):
        frame = inspector.GetFrameId(id)
        if not isinstance(inspector.GetShape(id), HalfSpace) or frame not in anchored:
            continue
        X_WH = anchored[frame] @ inspector.GetPoseInFrame(id)
        X_WG = X_WH @ RigidTransform([0.0, 0.0, -thickness / 2.0])
        name = f"{inspector.GetName(id)}_{id.get_value()}"
        slab = GeometryInstance(X_WG, Box(GROUND_SIDE_M, GROUND_SIDE_M, thickness), name)
        slab.set_perception_properties(inspector.GetPerceptionProperties(id))
        scene_graph.RegisterAnchoredGeometry(source, slab)


def render_cameras(
    pinhole: Pinhole, near: float, far: float
) -> tuple[DepthRenderCamera, ColorRenderCamera]:
    """Return Drake's cameras for depths from `near` to `far` [m].

    They also draw nearer surfaces, which are reported as too near.
    """
    # Drake warns that depths above 65 m do not fit into its 16-bit picture, which is not used.
    logging.getLogger("drake").addFilter(_not_about_16_bits)
    # Drake's documentation has pixels' centres at whole numbers; its renderer has them at halves.
    # Measured on oblique planes: depths are exact to 0.01 mm with this shift, to 0.1 m without.
    info = CameraInfo(
        pinhole.width, pinhole.height, pinhole.fx, pinhole.fy, pinhole.cx + 0.5, pinhole.cy + 0.5
    )
    nearest = max(near, MIN_DRAWN_DEPTH_M)
    clipping = ClippingRange(nearest / 4.0, max(COLOUR_RANGE_M, 2.0 * far))
    core = RenderCameraCore(CAMERA_RENDERER, info, clipping, RigidTransform())
    return DepthRenderCamera(core, DepthRange(nearest, far)), ColorRenderCamera(core)


def _not_about_16_bits(record: logging.LogRecord) -> bool:
    return "depth_image_16u" not in record.getMessage()


class DepthCameraSystem(DiscreteSystem):
    """Takes a picture at the end of each period, and delivers it after the latency.

    Pictures are abstract state, newest first. Other systems have no cost from it, because a
    `DepthImage` is shared and not copied. Pictures are rendered only in the update.

    Input ports:
        depth: a picture of depth, 32F [m].
        colour: a picture of colour, for cameras that have it.
        pose: X_WC of the optical frame.
    Output port:
        image: the last delivered `DepthImage`; stamp and depth are NaN before the first.
    Numeric parameter 0: `faults.Fault`.
    """

    def __init__(
        self, *, sensor: DepthCamera, period: float, latency: float = 0.0, seed: int = 0
    ) -> None:
        """Declare ports, state and sampling.

        Args:
            sensor: the description's record.
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
        self._bias = drawn_sensor_bias(sensor.noise, seed)
        self._kept = 1 + math.ceil(latency / period - LATENCY_TOLERANCE_S)
        self.DeclareNumericParameter(BasicVector([float(Fault.NONE)]))
        self.depth_input = self.DeclareAbstractInputPort("depth", Value(ImageDepth32F()))
        self.pose_input = self.DeclareAbstractInputPort("pose", Value(RigidTransform()))
        self.colour_input = None
        if sensor.has_colour:
            self.colour_input = self.DeclareAbstractInputPort("colour", Value(ImageRgba8U()))
        self._images = self.DeclareAbstractState(AbstractValue.Make(()))
        self._count = self.DeclareDiscreteState([0.0])
        self._blank = blank = _blank_picture(sensor, self._pinhole)
        self.image_output = self.DeclareAbstractOutputPort(
            "image",
            lambda: AbstractValue.Make(blank),
            weakly(self._calc_image),
            {self.abstract_state_ticket(self._images), self.time_ticket()},
        )
        self.DeclarePeriodicUnrestrictedUpdateEvent(period, 0.0, self._update)

    def reading(self, context: Context) -> DepthImage | None:
        """Return the last delivered picture, None if there is none."""
        for image in context.get_abstract_state(int(self._images)).get_value():
            if image.stamp + self.latency <= context.get_time() + LATENCY_TOLERANCE_S:
                return image
        return None

    def samples_taken(self, context: Context) -> int:
        """Return the number of samples taken since the start."""
        return int(context.get_discrete_state(self._count).CopyToVector()[0])

    def _update(self, context: Context, state: State) -> None:
        fault = Fault(int(context.get_numeric_parameter(0).CopyToVector()[0]))
        if fault is Fault.SILENT:
            return
        images = context.get_abstract_state(int(self._images)).get_value()
        if fault is Fault.FROZEN and images:
            image = replace(images[0], stamp=context.get_time())
        else:
            image = self._image(context, FAULT_NOISE_FACTOR if fault is Fault.NOISY else 1.0)
        kept = (image, *images[: self._kept - 1])
        state.get_mutable_abstract_state(int(self._images)).set_value(kept)
        state.get_mutable_discrete_state(self._count).set_value([self.samples_taken(context) + 1.0])

    def _image(self, context: Context, scale: float) -> DepthImage:
        X_WC = self.pose_input.Eval(context)
        colour = None
        if self.colour_input is not None:
            colour = read_only(self.colour_input.Eval(context).data[:, :, :3].copy())
        return DepthImage(
            stamp=context.get_time(),
            frame=self.sensor.frame,
            p_WS=read_only(X_WC.translation().copy()),  # a view would keep the Context alive
            R_WS=read_only(X_WC.rotation().matrix() @ R_SC.T),
            pinhole=self._pinhole,
            depth=read_only(self._depth(context, scale)),
            colour=colour,
        )

    def _depth(self, context: Context, scale: float) -> np.ndarray:
        """Return depth with noise; returns stay within the sensor's range."""
        depth: np.ndarray = self.depth_input.Eval(context).data[:, :, 0].copy()
        depth[depth == 0.0] = -np.inf
        noise = self.sensor.noise
        deviation = noise.stddev if scale == 1.0 else scale * (noise.stddev or CAMERA_DEVIATION_M)
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

    def _calc_image(self, context: Context, output: AbstractValue) -> None:
        output.set_value(self.reading(context) or self._blank)


def _blank_picture(sensor: DepthCamera, pinhole: Pinhole) -> DepthImage:
    """Return the value of the port before the first picture; its arrays take no memory."""
    pixels = (sensor.height, sensor.width)
    return DepthImage(
        stamp=math.nan,
        frame=sensor.frame,
        p_WS=read_only(np.full(3, math.nan)),
        R_WS=read_only(np.full((3, 3), math.nan)),
        pinhole=pinhole,
        depth=np.broadcast_to(np.float32(math.nan), pixels),
        colour=np.broadcast_to(np.uint8(0), (*pixels, 3)) if sensor.has_colour else None,
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
    """Add a depth camera, and its renderer if there is none yet.

    Args:
        builder: of the diagram.
        plant: finalised.
        scene_graph: of the plant.
        body: the vehicle's base, in whose frame the sensor's pose is given.
        sensor: the description's record.
        name: of its system in the diagram.
        period: between samples [s], a multiple of the physics step.
        latency: from a sample to its delivery [s].
        seed: of the noise, not negative.

    Raises:
        WorkbenchError: see `camera_pinhole`.
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
    """Return the intrinsics of a described camera.

    Raises:
        WorkbenchError: if the angle of view, the number of pixels or the range is not possible.
    """
    if not 0.0 < sensor.horizontal_fov < math.pi:
        raise WorkbenchError(
            f"sensor '{sensor.name}': horizontal_fov of {sensor.horizontal_fov:g} rad: "
            "give it an angle between 0 and pi"
        )
    if sensor.width * sensor.height > MAX_PICTURE_PIXELS:
        raise WorkbenchError(
            f"sensor '{sensor.name}': pictures of {sensor.width} x {sensor.height}: "
            f"give it up to {MAX_PICTURE_PIXELS} pixels"
        )
    if sensor.far <= MIN_DRAWN_DEPTH_M:
        raise WorkbenchError(
            f"sensor '{sensor.name}': its clip ends at {sensor.far:g} m: give it a far end beyond "
            f"{MIN_DRAWN_DEPTH_M:g} m, where the picture begins"
        )
    return make_pinhole(sensor.width, sensor.height, sensor.horizontal_fov)
