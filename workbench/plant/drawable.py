"""Make the meshes of a model usable by Drake: convert them, or replace them by simple shapes."""

import contextlib
import dataclasses
import math
import tempfile
import time
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Literal

import numpy as np
from pydrake.math import RigidTransform

from workbench.common.cache import cache_folder
from workbench.common.errors import WorkbenchError
from workbench.ipc.limited import LimitedError, run_limited
from workbench.plant.formats.values import shortened_text
from workbench.plant.meshes.job import (
    MeshJob,
    Rgba,
    is_sealed,
    read_reason,
    reason_file,
    write_whole,
)
from workbench.plant.meshes.side_files import refused_names, side_files
from workbench.plant.model import Inertial, Link, LinkShape, Model
from workbench.plant.packages import exists
from workbench.plant.remarks import Remarks
from workbench.plant.rotors import Rotor
from workbench.plant.shapes import Box, Cylinder, GeometryShape, Mesh

MAX_MESH_FILE_BYTES = 100_000_000
"""Size limit of a mesh file [bytes]."""
_MESH_CHILD_MODULE = "workbench.plant.meshes.child"
_MESH_BASE_CPU_S, _MESH_CPU_S_PER_TASK, _MESH_CPU_S_PER_MB = 2.0, 1.0, 0.3
_MESH_BASE_MEMORY_MB = 560
_MESH_MEMORY_PER_FILE_MB = 14
"""Limits of the child process by the size of the files.

Its libraries take 1 s and 300 MB of address space. A megabyte of STL takes 0.1 s and 11 MB, other
formats take less.
"""
_MESH_TIMEOUT_S = 30.0
"""Time after which no other process is started for the meshes that one left over [s]."""
_MESH_RETRY_DELAY_S = 600.0
"""Time before another attempt at a mesh that could not be converted [s]."""
_SUBSTITUTE_RGBA = (0.55, 0.57, 0.6, 1.0)
_MIN_SUBSTITUTE_SIDE_M, _MAX_SUBSTITUTE_SIDE_M = 0.02, 0.6
"""Limits of the sides of a substitute shape [m]."""
_DISC_RADIUS_SHARE = 0.45
"""Radius of a propeller over the distance to the nearest rotor, so that discs do not overlap."""


MeshPurpose = Literal["visual", "collision"]
_Task = tuple[MeshJob, Path]
"""A conversion and its destination."""


@dataclass(frozen=True)
class MeshUse:
    """A mesh and its use.

    For drawing it becomes a .gltf file with colours and pictures included. Its vertices account for
    COLLADA units, the transforms in the scene of the file, the scale, and the choice and centring
    of a submesh: draw it at scale 1 with its z along that of the visual. For contact it becomes an
    .obj file of its convex hull, at least a millimetre thick.

    Attributes:
        mesh: with its path.
        use: `visual` for drawing, `collision` for contact.
        rgba: colour 0 .. 1 for drawing if the file has none; light grey if None.
    """

    mesh: Mesh
    use: MeshPurpose
    rgba: Rgba | None = None


ConvertedFiles = Mapping[MeshUse, Path | WorkbenchError]
"""The converted file of each use, or the reason why there is none."""


def convert_meshes(uses: Iterable[MeshUse]) -> dict[MeshUse, Path | WorkbenchError]:
    """Return the converted file of each use, or the reason why there is none.

    One process converts all meshes that are not in the cache, as it takes a second to start.

    Args:
        uses: may contain duplicates.
    """
    found: dict[MeshUse, Path | WorkbenchError] = {}
    tasks: dict[MeshUse, _Task] = {}
    for use in dict.fromkeys(uses):
        try:
            tasks[use] = _task(use)
        except WorkbenchError as error:
            found[use] = error
    known = {task: _outcome(task) for task in dict.fromkeys(tasks.values())}
    reasons = _convert_tasks([task for task, reason in known.items() if reason is None])
    for use, task in tasks.items():
        reason = known[task] or reasons.get(task, "")
        found[use] = WorkbenchError(f"{use.mesh.path}: {reason}") if reason else task[1]
    return found


def _task(use: MeshUse) -> _Task:
    mesh = use.mesh
    folder = cache_folder("meshes")
    if mesh.path is None:
        raise WorkbenchError(f"{mesh.uri}: no such file")
    if not all(map(math.isfinite, mesh.scale)):
        raise WorkbenchError(f"{mesh.path}: its scale is not finite")
    try:
        file = mesh.path.resolve()
        if not file.is_file():
            raise WorkbenchError(f"{mesh.path}: no such file")
        if file.stat().st_size > MAX_MESH_FILE_BYTES:
            raise WorkbenchError(
                f"{mesh.path}: it is larger than {MAX_MESH_FILE_BYTES // 1_000_000} MB"
            )
        rgba = use.rgba if use.use == "visual" else None
        job = MeshJob(str(file), use.use, mesh.scale, mesh.submesh, mesh.center, rgba)
        return job, job.target(folder, file.read_bytes())
    except (OSError, ValueError, RuntimeError) as error:
        raise WorkbenchError(f"{mesh.path}: it cannot be read: {error}") from error


def _outcome(task: _Task) -> str | None:
    """Return why a conversion failed recently, "" if it is done, None if it is still to do."""
    if is_sealed(task[1]):
        return ""
    note = reason_file(task[1])
    try:
        if time.time() - note.stat().st_mtime > _MESH_RETRY_DELAY_S:
            return None
        return read_reason(task[1]) or None
    except OSError:
        return None


def _convert_tasks(tasks: Sequence[_Task]) -> dict[_Task, str]:
    """Convert, and return why that failed, or "".

    If the process dies, that is the fault of the first mesh that it left over, and another process
    converts those after it. So a bad mesh does not affect the others.
    """
    reasons: dict[_Task, str] = {}
    until = time.monotonic() + _MESH_TIMEOUT_S
    while left := [task for task in tasks if task not in reasons]:
        found, death = _run_mesh_process(left)
        reasons |= found
        culprit = next((task for task in left if task not in found), None)
        for task in left:
            if culprit and task[0].file == culprit[0].file:
                reasons.setdefault(task, death)
            elif time.monotonic() > until:
                late = f"the meshes before it took more than {_MESH_TIMEOUT_S:g} s"
                reasons.setdefault(task, late)
    for task, reason in reasons.items():
        if reason:
            with contextlib.suppress(OSError):  # then it is only tried again
                write_whole(reason_file(task[1]), reason.encode("utf-8", "replace"))
    return reasons


def _run_mesh_process(tasks: Sequence[_Task]) -> tuple[dict[_Task, str], str]:
    """Convert in one process, which writes to a folder of its own and not to the cache.

    Returns:
        Why each conversion failed, or "", without those that it left over; and why it died, or "".
    """
    with tempfile.TemporaryDirectory(dir=tasks[0][1].parent, prefix=".") as folder:
        made = {task: Path(folder) / task[1].name for task in tasks}
        reads = {task: [Path(task[0].file), *_side_files(Path(task[0].file))] for task in tasks}
        sizes = {task: sum(map(_megabytes, files)) for task, files in reads.items()}
        seconds = sum(_MESH_CPU_S_PER_TASK + _MESH_CPU_S_PER_MB * size for size in sizes.values())
        death = ""
        try:
            run_limited(
                _MESH_CHILD_MODULE,
                [(dataclasses.asdict(job), str(made[job, target])) for job, target in tasks],
                seconds=_MESH_BASE_CPU_S + seconds,
                megabytes=round(
                    _MESH_BASE_MEMORY_MB + _MESH_MEMORY_PER_FILE_MB * max(sizes.values())
                ),
                reads=[file for files in reads.values() for file in files],
                writes=[folder],
            )
        except LimitedError as error:
            death = str(error)
        found: dict[_Task, str] = {}
        for task, path in made.items():
            if is_sealed(path):
                path.replace(task[1])
                found[task] = ""
            elif (reason := read_reason(path)) is not None:
                found[task] = reason
        if not death and len(found) < len(tasks):
            death = "it was not converted"
        return found, death


def _side_files(file: Path) -> list[Path]:
    return side_files(file, _content(file))


def _megabytes(file: Path) -> float:
    try:
        return file.stat().st_size / 1e6
    except OSError:  # deleted meanwhile: the child says so
        return 0.0


def _content(file: Path) -> bytes:
    try:
        return file.read_bytes()
    except OSError:  # deleted meanwhile: the child says so
        return b""


def substitute_shapes(
    link: Link, rotors: Sequence[Rotor]
) -> list[tuple[RigidTransform, GeometryShape]]:
    """Return substitute shapes to draw a link, with their poses in it.

    They are its collision shapes if it has any, a disc for a rotor, else the box with the mass and
    moments of inertia of the link.
    """
    collisions = [
        (each.X_LS, each.shape) for each in link.collisions if not isinstance(each.shape, Mesh)
    ]
    if collisions:
        return [*collisions]
    radius = rotor_disc_radius(link.name, rotors)
    if radius:
        return [(RigidTransform(), Cylinder(radius, 0.004))]
    if link.inertial:
        return [(link.inertial.X_LI, inertia_box(link.inertial))]
    return [
        (
            RigidTransform(),
            Box((_MIN_SUBSTITUTE_SIDE_M, _MIN_SUBSTITUTE_SIDE_M, _MIN_SUBSTITUTE_SIDE_M)),
        )
    ]


def without_missing_meshes(
    visuals: Sequence[LinkShape], shapes: Sequence[tuple[RigidTransform, GeometryShape]]
) -> tuple[LinkShape, ...]:
    """Return visuals with all those of missing meshes replaced by substitute shapes."""
    kept = [visual for visual in visuals if not visual.is_missing]
    drawn = [
        LinkShape(f"stand_in_{index}", X_LS, shape, _SUBSTITUTE_RGBA)
        for index, (X_LS, shape) in enumerate(shapes)
    ]
    return (*kept, *drawn)


def rotor_disc_radius(link: str, rotors: Sequence[Rotor]) -> float:
    """Return a radius for a rotor disc that does not touch the next [m], 0 for other links."""
    own = next((rotor for rotor in rotors if rotor.joint and rotor.link == link), None)
    if own is None:
        return 0.0
    gaps = [
        gap
        for rotor in rotors
        if (gap := math.hypot(*np.subtract(rotor.p_BR, own.p_BR)[:2])) > 1e-3
    ]
    return float(
        np.clip(
            _DISC_RADIUS_SHARE * min(gaps, default=0.2),
            _MIN_SUBSTITUTE_SIDE_M,
            _MAX_SUBSTITUTE_SIDE_M / 2.0,
        )
    )


def inertia_box(inertial: Inertial) -> Box:
    """Return the homogeneous box with a mass and moments of inertia, within the size of a drone.

    The square of a side is 6/m times the sum of the other two moments minus its own: the inverse of
    I_xx = m (y² + z²)/12.
    """
    total = sum(inertial.moments)
    x, y, z = (
        float(
            np.clip(
                math.sqrt(max(0.0, 6.0 / inertial.mass * (total - 2.0 * moment))),
                _MIN_SUBSTITUTE_SIDE_M,
                _MAX_SUBSTITUTE_SIDE_M,
            )
        )
        for moment in inertial.moments
    )
    return Box((x, y, z))


def with_bumper(link: Link, rotors: Sequence[Rotor]) -> Link:
    """Return a base link with a box to stand on, as wide as the span of the rotors."""
    reach = [max((abs(rotor.p_BR[axis]) for rotor in rotors), default=0.1) for axis in (0, 1)]
    x, y = (float(np.clip(2.0 * half, _MIN_SUBSTITUTE_SIDE_M, 10.0)) for half in reach)
    bumper = LinkShape("stand_in", RigidTransform(), Box((x, y, 0.1 * max(x, y))))
    return dataclasses.replace(link, collisions=(*link.collisions, bumper))


def with_drawable_meshes(
    model: Model, base_link: str, rotors: Sequence[Rotor], remarks: Remarks
) -> Model:
    """Return a model with meshes that Drake can use, and a shape for contact with the ground.

    Args:
        model: as read.
        base_link: gets a box to stand on if no link has a collision shape.
        rotors: determine the size of substitute shapes.
        remarks: receives remarks on meshes that were not found or could not be read.
    """
    links = tuple(
        _with_substitute_shapes(link, rotors)
        for link in with_converted_meshes(model, remarks, "something simple is drawn")
    )
    if not any(link.collisions for link in links):
        text = (
            "no link has a collision shape; a box as wide as the distance of the rotors is used "
            "instead"
        )
        remarks.add(
            "assumed", model.source, f"collision of link '{shortened_text(base_link)}'", text
        )
        links = tuple(
            with_bumper(link, rotors) if link.name == base_link else link for link in links
        )
    return dataclasses.replace(model, links=links)


def with_converted_meshes(model: Model, remarks: Remarks, fate: str) -> tuple[Link, ...]:
    """Return the links of a model with meshes that Drake can use, and hulls for contact.

    A collision shape without a usable mesh is left out; a visual keeps a mesh without a path.

    Args:
        model: as read.
        remarks: receives remarks on meshes that were not found or could not be read.
        fate: a clause that says what happens to such visuals.
    """
    files = convert_meshes(use for link in model.links for use in _mesh_uses(link))
    return tuple(_drawable(model, link, files, remarks, fate) for link in model.links)


def _with_substitute_shapes(link: Link, rotors: Sequence[Rotor]) -> Link:
    """Return a link with substitute shapes for its missing visual meshes."""
    if not any(each.is_missing for each in link.visuals):
        return link
    visuals = without_missing_meshes(link.visuals, substitute_shapes(link, rotors))
    return dataclasses.replace(link, visuals=visuals)


def _mesh_uses(link: Link) -> Iterator[MeshUse]:
    """Yield every use of a mesh that was found in a link."""
    parts: tuple[tuple[MeshPurpose, tuple[LinkShape, ...]], ...] = (
        ("visual", link.visuals),
        ("collision", link.collisions),
    )
    for use, shapes in parts:
        for each in shapes:
            if isinstance(each.shape, Mesh) and each.shape.path:
                yield MeshUse(each.shape, use, each.rgba)


def _drawable(model: Model, link: Link, files: ConvertedFiles, remarks: Remarks, fate: str) -> Link:
    """Return a link with its meshes converted, and hulls for contact."""

    def converted(use: MeshPurpose, shape: LinkShape, fate: str) -> LinkShape:
        """Return a shape with its converted mesh, or without a file if there is none."""
        mesh = shape.shape
        if not isinstance(mesh, Mesh):
            return shape
        element = f"{use} '{shortened_text(shape.name)}' of link '{shortened_text(link.name)}'"
        if mesh.path is None:
            uri = shortened_text(mesh.uri) or "without a name"
            there = exists(model.source.parent / mesh.uri.strip().removeprefix("file://"))
            place = "outside of the description's folder and its packages"
            text = f"the mesh {uri} is {place if there else 'not found'}; {fate}"
            remarks.add("missing", model.source, element, text)
            return shape
        file = files[MeshUse(mesh, use, shape.rgba)]
        if isinstance(file, WorkbenchError):
            remarks.add("ignored", model.source, element, f"{file}; {fate}")
            return dataclasses.replace(shape, shape=dataclasses.replace(mesh, path=None))
        for name in refused_names(mesh.path, _content(mesh.path)) if use == "visual" else ():
            text = f"{mesh.path}: it names '{shortened_text(name)}' outside of its folder; not read"
            remarks.add("ignored", model.source, element, text)
        return dataclasses.replace(shape, shape=Mesh(mesh.uri, file), rgba=None)

    visuals = tuple(converted("visual", each, fate) for each in link.visuals)
    touching = [converted("collision", each, "left out") for each in link.collisions]
    collisions = tuple(each for each in touching if not each.is_missing)
    return dataclasses.replace(link, visuals=visuals, collisions=collisions)
