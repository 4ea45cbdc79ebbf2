"""Scenes made by hand, and meshes on disk."""

import sys
from collections.abc import Callable
from pathlib import Path

import pytest
import trimesh
from pydrake.geometry import GeometryId, Mesh, Shape
from pydrake.math import RigidTransform

from workbench.systems.casting.caster import Caster
from workbench.systems.casting.scene import WORLD_FRAME_NUMBER, CastGeometry, CastScene


@pytest.fixture(scope="session")
def make_caster() -> Callable[..., Caster]:
    """Return what makes a caster of (shape, X_FG, frame) triples with so many moving frames."""

    def make(*parts: tuple[Shape, RigidTransform, int], frames: int = 0) -> Caster:
        geometries = tuple(
            CastGeometry(GeometryId.get_new_id(), f"geometry {number}", shape, frame, X_FG)
            for number, (shape, X_FG, frame) in enumerate(parts)
        )
        return Caster(CastScene((None,) * frames, geometries))

    return make


@pytest.fixture(params=["embree", "all triangles"])
def finder(request, monkeypatch) -> None:
    """Cast with embree, and as where it is not installed."""
    if request.param == "all triangles":
        monkeypatch.setitem(sys.modules, "embreex", None)


@pytest.fixture(scope="session")
def alone(make_caster) -> Callable[[Shape], Caster]:
    """Return what makes a caster of one shape, fixed at the origin of the world."""
    return lambda shape: make_caster((shape, RigidTransform(), WORLD_FRAME_NUMBER))


@pytest.fixture(scope="session")
def stored(tmp_path_factory) -> Callable[..., Mesh]:
    """Return what writes a mesh to a file and gives Drake's shape of it."""
    folder: Path = tmp_path_factory.mktemp("meshes")

    def store(mesh: trimesh.Trimesh, name: str, kind: type = Mesh, scale=(1.0, 1.0, 1.0)):
        path = folder / name
        if path.suffix == ".gltf":
            for file, data in trimesh.exchange.gltf.export_gltf(trimesh.Scene(mesh)).items():
                target = path if file == "model.gltf" else folder / file
                target.write_bytes(data)
        else:
            mesh.export(path)
        return kind(str(path), scale3=list(scale))

    return store
