"""The geometries that rays can meet, which are those that the scene's cameras see, as records."""

from collections.abc import Collection, Mapping
from dataclasses import dataclass

from pydrake.geometry import FrameId, GeometryId, Role, SceneGraphInspector, Shape
from pydrake.math import RigidTransform
from pydrake.multibody.plant import MultibodyPlant

WORLD_FRAME_NUMBER = 0
"""The number of the world among the frames of a scene."""


@dataclass(frozen=True)
class CastGeometry:
    """One geometry, fixed to a frame F.

    Attributes:
        id: in the scene graph.
        name: in the scene graph.
        shape: as the scene graph has it.
        frame: `WORLD_FRAME_NUMBER`, or 1 + its frame's place in `CastScene.frames`.
        X_FG: its pose in the frame.
    """

    id: GeometryId
    name: str
    shape: Shape
    frame: int
    X_FG: RigidTransform


@dataclass(frozen=True)
class CastScene:
    """Everything that rays can meet.

    Attributes:
        frames: those that may move, whose poses are asked for at each cast.
        geometries: what is fixed to them or to the world.
    """

    frames: tuple[FrameId, ...]
    geometries: tuple[CastGeometry, ...]


def collect_scene(
    inspector: SceneGraphInspector,
    *,
    leave_out: Collection[FrameId] = (),
    anchored: Mapping[FrameId, RigidTransform] | None = None,
) -> CastScene:
    """Return all geometries with the perception role.

    Args:
        inspector: of the scene graph, with everything in it.
        leave_out: frames whose geometries are not seen, as those of the sensor's own vehicle.
        anchored: X_WF of frames that never move, see `anchored_frames`.
    """
    anchored = anchored or {}
    frames: list[FrameId] = []
    geometries = []
    for id in inspector.GetAllGeometryIds(Role.kPerception):
        frame, X_FG = inspector.GetFrameId(id), inspector.GetPoseInFrame(id)
        if frame in leave_out or inspector.IsDeformableGeometry(id):
            continue
        if frame == inspector.world_frame_id():
            place = WORLD_FRAME_NUMBER
        elif frame in anchored:
            place, X_FG = WORLD_FRAME_NUMBER, anchored[frame] @ X_FG
        else:
            if frame not in frames:
                frames.append(frame)
            place = 1 + frames.index(frame)
        # Copies: what an inspector lends keeps the scene graph alive.
        shape, X_FG = inspector.GetShape(id).Clone(), RigidTransform(X_FG)
        geometries.append(CastGeometry(id, inspector.GetName(id), shape, place, X_FG))
    return CastScene(tuple(frames), tuple(geometries))


def anchored_frames(plant: MultibodyPlant) -> dict[FrameId, RigidTransform]:
    """Return X_WF of every frame of a finalised plant whose body is welded to the world.

    The scene graph counts these among the frames that move.
    """
    context = plant.CreateDefaultContext()
    bodies = plant.GetBodiesWeldedTo(plant.world_body())
    ids = [(plant.GetBodyFrameIdIfExists(body.index()), body) for body in bodies]
    return {
        id: plant.EvalBodyPoseInWorld(context, body)
        for id, body in ids
        if id is not None and body.index() != plant.world_body().index()
    }
