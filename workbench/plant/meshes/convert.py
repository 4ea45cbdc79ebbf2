"""Meshes as Drake takes them: converted once, and then found in a cache.

Conversion runs in a process of its own with bounds of time and memory; the rest here is quick and
loads no mesh library.
"""

import contextlib
import dataclasses
import math
import time
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Literal

from workbench.common.cache import cache_folder
from workbench.common.errors import WorkbenchError
from workbench.ipc.limited import LimitedError, run_limited
from workbench.plant.meshes.job import MeshJob, Rgba, is_sealed, write_whole
from workbench.plant.shapes import Mesh

MOST_BYTES = 200_000_000
"""Of one mesh file."""
_CHILD = "workbench.plant.meshes.child"
_SECONDS, _MEGABYTES = 60.0, 3000
_PATIENCE = 180.0
"""For all meshes together [s]; what is not begun by then is refused."""
_REFUSED_FOR = 600.0
"""How long a mesh that could not be converted is not tried again [s]."""


@dataclass(frozen=True)
class MeshUse:
    """A mesh and what it is for.

    For drawing it becomes a .gltf file with colours and pictures in it. Units of COLLADA, the
    transforms of the file's scene, the scale, and the choice and centring of a submesh are in its
    vertices: it is to be drawn at scale 1 with its z along the visual's. To touch, it becomes an
    .obj file of its convex hull, at least a millimetre thick.

    Attributes:
        mesh: with its path.
        use: `visual`: to be drawn; `collision`: to touch.
        rgba: colour 0 .. 1 where the file has none, for drawing; light grey if None.
    """

    mesh: Mesh
    use: Literal["visual", "collision"]
    rgba: Rgba | None = None


def convert(uses: Iterable[MeshUse]) -> dict[MeshUse, Path | WorkbenchError]:
    """Return for each use the converted file, or why there is none, beginning with the mesh file.

    One process converts all that are not in the cache: it takes a second to start.

    Args:
        uses: may repeat.
    """
    found: dict[MeshUse, Path | WorkbenchError] = {}
    tasks: dict[MeshUse, _Task] = {}
    for use in dict.fromkeys(uses):
        try:
            tasks[use] = _task(use)
        except WorkbenchError as error:
            found[use] = error
    known = {task: _outcome(task) for task in dict.fromkeys(tasks.values())}
    reasons = _run([task for task, reason in known.items() if reason is None])
    for use, task in tasks.items():
        reason = known[task] or reasons.get(task, "")
        found[use] = WorkbenchError(f"{use.mesh.path}: {reason}") if reason else task.target
    return found


@dataclass(frozen=True)
class _Task:
    """A conversion and where it goes."""

    job: MeshJob
    target: Path


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
        if file.stat().st_size > MOST_BYTES:
            raise WorkbenchError(f"{mesh.path}: it is larger than {MOST_BYTES // 1_000_000} MB")
        rgba = use.rgba if use.use == "visual" else None
        job = MeshJob(str(file), use.use, mesh.scale, mesh.submesh, mesh.center, rgba)
        return _Task(job, job.target(folder, file.read_bytes()))
    except (OSError, ValueError, RuntimeError) as error:
        raise WorkbenchError(f"{mesh.path}: it cannot be read: {error}") from error


def _outcome(task: _Task) -> str | None:
    """Return why a conversion failed a short while ago, "" if it is done, None if it is to do."""
    if is_sealed(task.target):
        return ""
    note = _note(task)
    try:
        if time.time() - note.stat().st_mtime > _REFUSED_FOR:
            return None
        return note.read_bytes()[:1000].decode("utf-8", "replace") or None
    except OSError:
        return None


def _note(task: _Task) -> Path:
    return task.target.with_suffix(f"{task.target.suffix}.refused")


def _run(tasks: Sequence[_Task]) -> dict[_Task, str]:
    """Convert, and return why that failed, "" where it did not.

    Where the process for all of them dies, each has one of its own: one bad mesh does not
    spoil the others, and it is known which one it was.
    """
    if not tasks:
        return {}
    until = time.monotonic() + _PATIENCE
    try:
        reasons = dict(zip(tasks, _ask(tasks), strict=True))
    except LimitedError as error:
        reasons = dict.fromkeys(tasks, str(error))
        for task in tasks if len(tasks) > 1 else ():
            reasons[task] = "" if is_sealed(task.target) else _ask_alone(task, until)
    for task, reason in reasons.items():
        if reason:
            with contextlib.suppress(OSError):  # then it is tried again, that is all
                write_whole(_note(task), reason.encode("utf-8", "replace"))
    return reasons


def _ask_alone(task: _Task, until: float) -> str:
    if time.monotonic() > until:
        return f"the meshes before it took more than {_PATIENCE:g} s"
    try:
        return _ask([task])[0]
    except LimitedError as error:
        return str(error)


def _ask(tasks: Sequence[_Task]) -> list[str]:
    request = [(dataclasses.asdict(task.job), str(task.target)) for task in tasks]
    answer = run_limited(_CHILD, request, seconds=_SECONDS, megabytes=_MEGABYTES)
    return [str(reason) for reason in answer]
