"""Write parts as one self-contained glTF file, turned for Drake."""

from collections.abc import Sequence
from typing import Any

import numpy as np
import trimesh
from trimesh.visual import TextureVisuals

from workbench.common.errors import WorkbenchError
from workbench.plant.meshes.job import Rgba
from workbench.plant.meshes.materials import make_material, without_pictures
from workbench.plant.meshes.parts import Array, MeshPart

GLTF_GENERATOR = "drake-drone-workbench"
"""Generator in the `asset` of a file, which identifies our files."""
_UNCOLOURED_MESH_RGBA = (0.7, 0.7, 0.7, 1.0)
_MAX_MATERIALS = 1000


def to_z_up() -> Array:
    """Return the (4, 4) turn from glTF's axes (y up) to those of Drake and Gazebo (z up)."""
    return np.array([[1.0, 0, 0, 0], [0, 0, -1.0, 0], [0, 1.0, 0, 0], [0, 0, 0, 1.0]])


def write_gltf(parts: Sequence[MeshPart], rgba: Rgba | None) -> bytes:
    """Return the content of a .gltf file.

    The format is glTF and not OBJ because Drake draws OBJ only with normals, and OBJ has colours
    and pictures in separate files. Drake takes y as up in glTF; Gazebo does not, and would draw the
    file on its side.

    Args:
        parts: z up, joined by `joined`.
        rgba: colour 0 .. 1 of parts without one.

    Raises:
        WorkbenchError: with a clause as message.
    """
    if len(parts) > _MAX_MATERIALS:
        raise WorkbenchError(f"it has more than {_MAX_MATERIALS} materials")
    plain = make_material(_UNCOLOURED_MESH_RGBA if rgba is None else rgba)
    white = make_material((1.0, 1.0, 1.0, 1.0))
    scene = trimesh.Scene()
    for part in parts:
        turned = part.moved(to_z_up().T)
        material = turned.material or (plain if turned.colors is None else white)
        if turned.uv is None:
            material = without_pictures(material)
        looks = TextureVisuals(uv=turned.uv, material=material)
        if turned.colors is not None:
            looks.vertex_attributes["color"] = turned.colors
        scene.add_geometry(
            trimesh.Trimesh(
                turned.vertices,
                turned.faces,
                vertex_normals=turned.normals,
                visual=looks,
                process=False,
                validate=False,
            )
        )
    return bytes(
        scene.export(
            file_type="gltf",
            merge_buffers=True,
            embed_buffers=True,
            tree_postprocessor=_sign,
        )["model.gltf"]
    )


def _sign(tree: dict[str, Any]) -> None:
    tree["asset"]["generator"] = GLTF_GENERATOR
    tree.pop("extras", None)  # used for the seal
