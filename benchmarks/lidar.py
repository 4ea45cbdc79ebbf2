"""Rays a second of a lidar in a diagram, compared with other ray casters on the same scene.

The scene has 20 shapes, four of them moving, over a ground; a scan has 5,760 rays. Our lidar scans
at every step of a discrete plant, with noise, and the whole step counts: plant, poses, rays, noise,
state. The others are called directly, without a diagram and with fixed poses; trimesh and embree
get the shapes as meshes. Each row is the best of many alternating turns.
"""

import importlib.util
import time
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np
import trimesh
from embreex.mesh_construction import TriangleMesh
from embreex.rtcore_scene import EmbreeScene
from lidar_scene import (
    HEIGHT,
    MOVING,
    RECORD,
    STEP,
    as_meshes,
    lidar_in_a_diagram,
    make_ground,
    make_mesh,
    make_shapes,
)
from pydrake.geometry import Box, Capsule, Cylinder, Sphere
from pydrake.math import RigidTransform
from pydrake.systems.analysis import Simulator

from workbench.systems.casting.caster import Caster
from workbench.systems.sensors.lidar import LidarSensor

SCANS, TURNS, SECONDS = 4, 400, 3.0
"""Scans of the lidar a turn, turns, and how long each way has for all of its turns [s]."""


@dataclass(frozen=True)
class RayRow:
    """Speed of one way to cast rays, and the share of them that met something."""

    name: str
    million_rays_a_second: float
    met: float


@dataclass(frozen=True)
class Missing:
    """What is not compared, and what to do about it."""

    name: str
    reason: str


@dataclass(frozen=True)
class Turn:
    """A way to cast: does some rays and says which share met something."""

    name: str
    rays: int
    cast: Callable[[], float]


def measure() -> list[RayRow | Missing]:
    """Return a row for each way to cast rays."""
    with TemporaryDirectory() as folder:
        turns = list(_ways(Path(folder)))
        ready = [each for each in turns if isinstance(each, Turn)]
        times: dict[str, list[float]] = {each.name: [] for each in ready}
        met = {each.name: each.cast() for each in ready}
        for _ in range(TURNS):
            for each in ready:
                if sum(times[each.name]) > SECONDS:
                    continue
                begin = time.perf_counter()
                each.cast()
                times[each.name].append(time.perf_counter() - begin)
    return [
        RayRow(each.name, each.rays / min(times[each.name]) / 1e6, met[each.name])
        if isinstance(each, Turn)
        else each
        for each in turns
    ]


def show(rows: list[RayRow | Missing]) -> None:
    """Print the table."""
    print("rays against 20 shapes and ground    million a second   met")
    for row in rows:
        if isinstance(row, Missing):
            print(f"{row.name:36s} {row.reason}")
        else:
            print(f"{row.name:36s} {row.million_rays_a_second:16.3g}   {row.met:.3f}")


def _ways(folder: Path) -> Iterator[Turn | Missing]:
    lidar, simulator = lidar_in_a_diagram()
    directions = lidar.pattern.directions_S
    origin = np.array([0.0, 0.0, HEIGHT]) + RECORD.p_BS
    count = len(directions)
    yield Turn("lidar, whole steps of the diagram", SCANS * count, _steps(lidar, simulator))
    scene = lidar.caster.scene
    poses = [RigidTransform()] * MOVING
    yield _caster("our caster, closed forms", lidar.caster, origin, directions, poses)
    meshes = [make_mesh(shape) for shape, _ in make_shapes()]
    of_meshes = as_meshes(scene, meshes, folder)
    yield _caster("our caster, the same as meshes", of_meshes, origin, directions, poses)

    parts = []
    for mesh, (_, X_WG) in zip(meshes, make_shapes(), strict=True):
        parts.append(mesh.copy())
        parts[-1].apply_transform(X_WG.GetAsMatrix4())
    world = trimesh.util.concatenate([*parts, make_ground()])
    yield _embree(world, origin, directions)
    yield _trimesh_embree(world, origin, directions)
    yield _trimesh_native(world, origin, directions[::100])
    yield _mujoco(origin, directions)


def _steps(lidar: LidarSensor, simulator: Simulator) -> Callable[[], float]:
    context = lidar.GetMyContextFromRoot(simulator.get_context())

    def fly() -> float:
        simulator.AdvanceTo(simulator.get_context().get_time() + SCANS * STEP)
        scan = lidar.reading(context)
        return scan.returns / scan.ranges.size if scan else 0.0

    return fly


def _caster(
    name: str,
    caster: Caster,
    origin: np.ndarray,
    directions: np.ndarray,
    poses: list[RigidTransform],
) -> Turn:
    def cast() -> float:
        ranges = caster.cast(origin, directions, poses, RECORD.max_range)
        return float(np.isfinite(ranges).mean())

    return Turn(name, len(directions), cast)


def _embree(world: trimesh.Trimesh, origin: np.ndarray, directions: np.ndarray) -> Turn:
    scene = EmbreeScene(robust=True)
    TriangleMesh(scene, world.triangles.astype(np.float32))
    rays = directions.astype(np.float32)
    origins = np.tile(origin.astype(np.float32), (len(rays), 1))

    def cast() -> float:
        reach = np.full(len(rays), RECORD.max_range, dtype=np.float32)
        return float((scene.run(origins, rays, dists=reach, output=1)["primID"] >= 0).mean())

    return Turn("embree directly, single precision", len(rays), cast)


def _trimesh_embree(world: trimesh.Trimesh, origin: np.ndarray, directions: np.ndarray) -> Turn:
    from trimesh.ray.ray_pyembree import RayMeshIntersector

    return _trimesh("trimesh over embree", RayMeshIntersector(world), origin, directions)


def _trimesh_native(
    world: trimesh.Trimesh, origin: np.ndarray, directions: np.ndarray
) -> Turn | Missing:
    name = "trimesh without embree"
    if importlib.util.find_spec("rtree") is None:
        return Missing(name, "not compared: pip install rtree")
    from trimesh.ray.ray_triangle import RayMeshIntersector

    return _trimesh(name, RayMeshIntersector(world), origin, directions)


def _trimesh(name: str, caster: object, origin: np.ndarray, directions: np.ndarray) -> Turn:
    origins = np.tile(origin, (len(directions), 1))

    def cast() -> float:
        points, rays, _ = caster.intersects_location(origins, directions, multiple_hits=False)  # type: ignore[attr-defined]
        near = np.linalg.norm(points - origins[rays], axis=1) <= RECORD.max_range
        return float(near.sum() / len(directions))

    return Turn(name, len(directions), cast)


def _mujoco(origin: np.ndarray, directions: np.ndarray) -> Turn | Missing:
    name = "MuJoCo, mj_multiRay"
    if importlib.util.find_spec("mujoco") is None:
        return Missing(name, "not compared: pip install mujoco")
    import mujoco

    geoms = ['<geom type="plane" size="100 100 1"/>']
    for shape, X_WG in make_shapes():
        match shape:
            case Box():
                kind, size = "box", 0.5 * shape.size()
            case Sphere():
                kind, size = "sphere", [shape.radius()]
            case Cylinder():
                kind, size = "cylinder", [shape.radius(), 0.5 * shape.length()]
            case Capsule():
                kind, size = "capsule", [shape.radius(), 0.5 * shape.length()]
        words = [
            " ".join(map(str, row))
            for row in (size, X_WG.translation(), X_WG.rotation().ToQuaternion().wxyz())
        ]
        geoms.append(f'<geom type="{kind}" size="{words[0]}" pos="{words[1]}" quat="{words[2]}"/>')
    text = f"<mujoco><worldbody>{''.join(geoms)}</worldbody></mujoco>"
    model = mujoco.MjModel.from_xml_string(text)
    data = mujoco.MjData(model)
    mujoco.mj_forward(model, data)
    count = len(directions)
    rays = directions.ravel().copy()
    numbers, ranges = np.zeros(count, dtype=np.int32), np.zeros(count)

    def cast() -> float:
        mujoco.mj_multiRay(
            model, data, origin, rays, None, 1, -1, numbers, ranges, None, count, RECORD.max_range
        )
        # of a plane it also gives ranges beyond the cutoff
        return float(((numbers >= 0) & (ranges <= RECORD.max_range)).mean())

    return Turn(name, count, cast)


if __name__ == "__main__":
    show(measure())
