"""The renderer that all cameras share: what of the scene they see, and in which light.

Depths of flat faces are right to 0.01 mm, those of the ground to 0.2 mm. Balls and cylinders are
drawn with facets, which lie up to 0.25 % of the radius inside them; a ball's 5000 triangles also
take as long to draw as a dozen boxes.
"""

import logging

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
from pydrake.math import RigidTransform
from pydrake.multibody.plant import MultibodyPlant
from pydrake.multibody.tree import RigidBody
from pydrake.systems.sensors import CameraInfo

from workbench.common.errors import WorkbenchError
from workbench.systems.casting.scene import anchored_frames
from workbench.systems.sensors.pinhole import Pinhole

RENDERER = "cameras"
"""Name of the cameras' renderer in the scene graph."""

GROUND_SIDE = 2000.0
"""Side of the square that stands for a half space [m]."""

HORIZON = 1000.0
"""So far do cameras see colours [m]; the far clip is where depth ends, not the world."""

NEAREST = 1e-3
"""Depths from here on are drawn [m]."""

_MOST_SAID = 300
"""So many characters of what Drake says are passed on."""
_SKY = (0.72, 0.84, 0.95)
_LIGHTS = (
    # The sun, from the south-west, a little of it from the other side, and a lamp at the camera,
    # so that no face that a camera can see is black.
    LightParameter(frame="world", direction=[0.5, 0.6, -1.0], intensity=0.8),
    LightParameter(frame="world", direction=[-0.6, -0.5, -0.4], intensity=0.2),
    LightParameter(frame="camera", direction=[0.0, 0.0, 1.0], intensity=0.3),
)


def add_camera_renderer(plant: MultibodyPlant, scene_graph: SceneGraph, body: RigidBody) -> None:
    """Let cameras see the scene, without the vehicle that carries them; once a scene graph.

    Args:
        plant: finalised, with everything in it that a half space belongs to.
        scene_graph: to which the renderer is added, if it is not there.
        body: the vehicle's base. What is fixed to it is seen no more, by any renderer: a housing
            drawn around its camera would blind it, and the lidar leaves its vehicle out too.

    Raises:
        WorkbenchError: if the renderer does not take a mesh, as an OBJ without normals.
    """
    if scene_graph.HasRenderer(RENDERER):
        return
    # EGL by default on Linux: it needs no screen.
    parameters = RenderEngineVtkParams(default_clear_color=_SKY, lights=list(_LIGHTS))
    renderer = MakeRenderEngineVtk(parameters)
    try:
        scene_graph.AddRenderer(RENDERER, renderer)
    except RuntimeError as error:
        reason = " ".join(str(error).split())[:_MOST_SAID].rstrip(". ")
        raise WorkbenchError(
            f"the camera cannot draw a mesh: {reason}: give the mesh what it lacks (as normals), "
            "or take it out"
        ) from error
    for part in plant.GetBodiesWeldedTo(body):
        frame = plant.GetBodyFrameIdOrThrow(part.index())
        scene_graph.RemoveRole(plant.get_source_id(), frame, Role.kPerception)
    _widen_half_spaces(plant, scene_graph)


def _widen_half_spaces(plant: MultibodyPlant, scene_graph: SceneGraph) -> None:
    """Lay a slab under every fixed half space: the renderer draws no more than 100 m of these.

    A single slab of 2 km costs a fifth of a millimetre of depth, one of 10 km a millimetre (the
    renderer's numbers are single precision).
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
        slab = GeometryInstance(X_WG, Box(GROUND_SIDE, GROUND_SIDE, thickness), name)
        slab.set_perception_properties(inspector.GetPerceptionProperties(id))
        scene_graph.RegisterAnchoredGeometry(source, slab)


def render_cameras(
    pinhole: Pinhole, near: float, far: float
) -> tuple[DepthRenderCamera, ColorRenderCamera]:
    """Return Drake's cameras for depths from `near` to `far` [m].

    They draw what is a little nearer too, as it has to be drawn to be reported as too near.
    """
    # Drake remarks that depths above 65 m do not fit in its 16-bit picture, which nobody reads.
    logging.getLogger("drake").addFilter(_not_about_16_bits)
    # Drake's documentation has pixels' centres at whole numbers; its renderer has them at halves.
    # Measured on oblique planes: with this shift depths are right to 0.01 mm, without to 0.1 m.
    info = CameraInfo(
        pinhole.width, pinhole.height, pinhole.fx, pinhole.fy, pinhole.cx + 0.5, pinhole.cy + 0.5
    )
    nearest = max(near, NEAREST)
    clipping = ClippingRange(nearest / 4.0, max(HORIZON, 2.0 * far))
    core = RenderCameraCore(RENDERER, info, clipping, RigidTransform())
    return DepthRenderCamera(core, DepthRange(nearest, far)), ColorRenderCamera(core)


def _not_about_16_bits(record: logging.LogRecord) -> bool:
    return "depth_image_16u" not in record.getMessage()
