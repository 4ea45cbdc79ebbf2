"""Convert meshes, in a process of its own: the files come from strangers."""

from pathlib import Path
from typing import Any

import numpy as np

from workbench.common.errors import WorkbenchError
from workbench.ipc.limited import one_line, serve
from workbench.plant.meshes.gltf import write_gltf
from workbench.plant.meshes.hull import convex_hull, write_obj
from workbench.plant.meshes.job import MeshJob, sealed, write_whole
from workbench.plant.meshes.parts import MOST_FACES, Part, joined
from workbench.plant.meshes.reading import read_parts


def convert_all(request: Any) -> list[str]:
    """Make the files that are asked for; return for each why it could not be made, or "".

    Args:
        request: pairs of a job's fields and the path to write to.
    """
    return [_reason(MeshJob(**fields), Path(target)) for fields, target in request]


def _reason(job: MeshJob, target: Path) -> str:
    try:
        write_whole(target, sealed(convert(job), target.suffix))
    except WorkbenchError as error:
        return str(error)
    except MemoryError:
        return "it takes more memory than it may"
    except RecursionError:
        return "it is nested too deeply"
    except Exception as error:  # trimesh and pycollada raise anything on broken files
        return f"it cannot be read: {one_line(error)}"
    return ""


def convert(job: MeshJob) -> bytes:
    """Return the content of the converted file.

    Raises:
        WorkbenchError: a clause without the file's name. Other exceptions come from readers.
    """
    parts = [part for part in _placed(job) if len(part.faces)]
    if not parts:
        raise WorkbenchError("it has no faces")
    if sum(len(part.faces) for part in parts) > MOST_FACES:
        raise WorkbenchError(f"it has more than {MOST_FACES} faces")
    if job.use == "collision":
        return write_obj(*convex_hull(np.concatenate([part.vertices for part in parts])))
    return write_gltf(joined(parts), job.rgba)


def _placed(job: MeshJob) -> list[Part]:
    """Return the parts that are used, scaled and centred, checked."""
    scale = np.diag([*job.scale, 1.0])
    parts = [part.moved(scale).checked() for part in read_parts(Path(job.file), job.submesh)]
    if not job.center:
        return parts
    corners = [corner(part.vertices, axis=0) for part in parts for corner in (np.min, np.max)]
    T = np.eye(4)
    T[:3, 3] = -0.5 * (np.min(corners, axis=0) + np.max(corners, axis=0))
    return [part.moved(T) for part in parts]


if __name__ == "__main__":
    serve(convert_all)
