"""Read and convert untrusted mesh files of common formats, in a child process."""

from pathlib import Path
from typing import Any

import numpy as np

from workbench.common.errors import WorkbenchError
from workbench.ipc.limited import one_line_message, serve_one_request
from workbench.plant.meshes.gltf import write_gltf
from workbench.plant.meshes.hull import convex_hull, write_obj
from workbench.plant.meshes.job import MeshJob, reason_file, sealed
from workbench.plant.meshes.mesh_file import read_parts
from workbench.plant.meshes.parts import MeshPart, joined_parts


def convert_all(request: Any) -> None:
    """Write the requested files one after the other, or files with the reasons for failures.

    Args:
        request: pairs of the fields of a job and the path to write to.
    """
    for fields, path in request:
        target = Path(path)
        if reason := _conversion_error(MeshJob(**fields), target):
            reason_file(target).write_bytes(reason.encode("utf-8", "replace"))


def _conversion_error(job: MeshJob, target: Path) -> str:
    try:
        target.write_bytes(sealed(converted_content(job), target.suffix))
    except WorkbenchError as error:
        return str(error)
    except MemoryError:
        return "it needs too much memory"
    except RecursionError:
        return "it is nested too deeply"
    except Exception as error:  # trimesh and pycollada raise any exception on broken files
        return f"it cannot be read: {one_line_message(error)}"
    return ""


def converted_content(job: MeshJob) -> bytes:
    """Return the content of the converted file.

    Raises:
        WorkbenchError: with a clause as message. Readers raise other exceptions.
    """
    parts = [part for part in _placed_parts(job) if len(part.faces)]
    if not parts:
        raise WorkbenchError("it has no faces")
    if job.use == "collision":
        return write_obj(*convex_hull(np.concatenate([part.vertices for part in parts])))
    return write_gltf(joined_parts(parts), job.rgba)


def _placed_parts(job: MeshJob) -> list[MeshPart]:
    """Return the parts in use, scaled, centred and checked."""
    scale = np.diag([*job.scale, 1.0])
    parts = [part.moved(scale).checked() for part in read_parts(Path(job.file), job.submesh)]
    if not job.center:
        return parts
    corners = [corner(part.vertices, axis=0) for part in parts for corner in (np.min, np.max)]
    T = np.eye(4)
    T[:3, 3] = -0.5 * (np.min(corners, axis=0) + np.max(corners, axis=0))
    return [part.moved(T) for part in parts]


if __name__ == "__main__":
    serve_one_request(convert_all)
