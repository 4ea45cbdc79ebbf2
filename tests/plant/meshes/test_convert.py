"""Meshes written here, converted in the real child process where that is the point."""

import dataclasses
import math
import os
import subprocess
import sys
import threading
import time
from pathlib import Path

import numpy as np
import pytest
from pydrake.geometry import Convex

from workbench.common.errors import WorkbenchError
from workbench.ipc.limited import LimitedError
from workbench.plant import drawable as meshes
from workbench.plant.drawable import MeshUse, convert_meshes
from workbench.plant.meshes.job import is_sealed, reason_file, sealed
from workbench.plant.shapes import Mesh

OBJ = "v 0 0 0\nv 1 0 0\nv 0 2 0\nv 0 0 3\nf 1 3 2\nf 1 2 4\nf 1 4 3\nf 2 3 4\n"
"""A tetrahedron."""


@pytest.fixture(autouse=True)
def cache(tmp_path, monkeypatch) -> Path:
    """A cache of the test's own."""
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path / "cache"))
    return tmp_path / "cache" / "drake-drone-workbench" / "meshes"


@pytest.fixture
def tetrahedron(tmp_path) -> Mesh:
    return mesh_of(tmp_path / "tetrahedron.obj", OBJ)


def mesh_of(path: Path, content: str, **more) -> Mesh:
    path.write_text(content)
    return Mesh(path.name, path, **more)


@pytest.fixture
def child(monkeypatch):
    """A stand-in for the child process: counts calls, and dies of meshes called `deadly`."""
    calls = []

    def run_limited(module, request, **bounds):
        calls.append([Path(fields["file"]).stem for fields, _ in request])
        for _, name in request:
            target = Path(name)
            if "deadly" in target.stem:
                raise LimitedError("it took more than 60 s")
            if "bad" in target.stem:
                reason_file(target).write_text("it has no faces")
            else:
                target.write_bytes(sealed(b"{}", target.suffix))

    monkeypatch.setattr(meshes, "run_limited", run_limited)
    return calls


def test_the_child_converts_all_at_once_and_names_what_it_cannot(tmp_path, tetrahedron, cache):
    broken = mesh_of(tmp_path / "broken.obj", "f 1 2 3\n")
    mirrored = dataclasses.replace(tetrahedron, scale=(-1.0, 1.0, 2.0))
    uses = [
        MeshUse(tetrahedron, "visual", (1.0, 0.0, 0.0, 1.0)),
        MeshUse(mirrored, "visual"),
        MeshUse(mirrored, "collision"),
        MeshUse(broken, "visual"),
    ]
    found = convert_meshes(uses)
    assert bounds(found[uses[0]]) == [[0, 0, 0], [1, 2, 3]]
    assert bounds(found[uses[1]]) == bounds(found[uses[2]]) == [[-1, 0, 0], [0, 2, 6]]
    assert {found[use].suffix for use in uses[:2]} == {".gltf"}
    assert found[uses[2]].suffix == ".obj"
    assert str(found[uses[3]]).startswith(f"{broken.path}: it ")
    assert all(path.parent == cache for path in cache.iterdir())


def only(use):
    found = convert_meshes([use])[use]
    if isinstance(found, WorkbenchError):
        raise found
    return found


def visual_mesh(mesh, rgba=None):
    return only(MeshUse(mesh, "visual", rgba))


def collision_mesh(mesh):
    return only(MeshUse(mesh, "collision"))


def bounds(path: Path) -> list[list[float]]:
    """Return the lowest and the highest corner as Drake reads them."""
    hull = Convex(str(path)).GetConvexHull()
    corners = np.array([hull.vertex(i) for i in range(hull.num_vertices())])
    return [corners.min(axis=0).round(5).tolist(), corners.max(axis=0).round(5).tolist()]


def test_two_at_once_do_not_disturb_each_other(tetrahedron):
    found = []
    threads = [
        threading.Thread(target=lambda: found.append(visual_mesh(tetrahedron))) for _ in range(2)
    ]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert found[0] == found[1]
    assert is_sealed(found[0])


def test_what_is_in_the_cache_starts_no_process(tetrahedron, child):
    first = visual_mesh(tetrahedron), collision_mesh(tetrahedron)
    assert (visual_mesh(tetrahedron), collision_mesh(tetrahedron)) == first
    assert child == [["tetrahedron"], ["tetrahedron"]]


def test_equal_uses_are_converted_once(tetrahedron, child):
    twin = dataclasses.replace(tetrahedron, uri="package://other/name.obj")
    found = convert_meshes([MeshUse(tetrahedron, "visual"), MeshUse(twin, "visual")] * 2)
    assert child == [["tetrahedron"]]
    assert len(found) == 2
    assert len(set(found.values())) == 1


def test_a_colour_matters_only_for_drawing(tetrahedron, child):
    red = (1.0, 0.0, 0.0, 1.0)
    assert visual_mesh(tetrahedron, red) != visual_mesh(tetrahedron)
    coloured = MeshUse(tetrahedron, "collision", red)
    assert convert_meshes([coloured])[coloured] == collision_mesh(tetrahedron)


def test_a_changed_mesh_is_converted_anew(tetrahedron, child):
    first = visual_mesh(tetrahedron)
    tetrahedron.path.write_text(OBJ + "# changed\n")
    assert visual_mesh(tetrahedron) != first


@pytest.mark.parametrize("damage", [b"", b"{", None], ids=["empty", "cut", "gone"])
def test_a_damaged_file_is_made_again(tetrahedron, child, damage):
    path = visual_mesh(tetrahedron)
    if damage is None:
        path.unlink()
    else:
        path.write_bytes(damage)
    assert visual_mesh(tetrahedron) == path
    assert is_sealed(path)


def test_a_bad_mesh_is_not_tried_again_for_a_while(tmp_path, child):
    bad = mesh_of(tmp_path / "bad.obj", "")
    for _ in range(3):
        with pytest.raises(WorkbenchError, match=r"bad\.obj: it has no faces$"):
            visual_mesh(bad)
    assert child == [["bad"]]


def test_a_bad_mesh_is_tried_again_later_and_when_it_has_changed(tmp_path, child, cache):
    bad = mesh_of(tmp_path / "bad.obj", "")
    convert_meshes([MeshUse(bad, "visual")])
    [note] = cache.iterdir()
    an_hour_ago = time.time() - 3600.0
    os.utime(note, (an_hour_ago, an_hour_ago))
    convert_meshes([MeshUse(bad, "visual")])
    assert len(child) == 2
    bad.path.write_text("# changed")
    convert_meshes([MeshUse(bad, "visual")])
    assert len(child) == 3


def test_a_deadly_mesh_does_not_spoil_the_others(tmp_path, child):
    names = ("one", "bad", "deadly", "two")
    uses = [MeshUse(mesh_of(tmp_path / f"{name}.obj", name), "visual") for name in names]
    one, bad, deadly, two = convert_meshes(uses).values()
    assert is_sealed(one) and is_sealed(two)
    assert str(deadly) == f"{tmp_path}/deadly.obj: it took more than 60 s"
    assert str(bad) == f"{tmp_path}/bad.obj: it has no faces"
    # What was done before the process died is not done again, nor is what it died of.
    assert child == [["one", "bad", "deadly", "two"], ["two"]]


def test_a_deadly_mesh_is_tried_once_for_all_its_uses(tmp_path, child):
    mesh = mesh_of(tmp_path / "deadly.obj", "")
    found = convert_meshes(MeshUse(mesh, use) for use in ("visual", "collision"))
    assert child == [["deadly", "deadly"]]
    assert {str(error) for error in found.values()} == {f"{mesh.path}: it took more than 60 s"}


def test_many_deadly_meshes_end_in_bounded_time(tmp_path, child, monkeypatch):
    monkeypatch.setattr(meshes, "_MESH_TIMEOUT_S", -1.0)
    uses = [MeshUse(mesh_of(tmp_path / f"deadly{i}.obj", str(i)), "visual") for i in range(5)]
    first, *others = convert_meshes(uses).values()
    assert len(child) == 1
    assert "it took more than 60 s" in str(first)
    assert all("the meshes before it took more than" in str(error) for error in others)


@pytest.mark.parametrize("scale", [math.nan, math.inf, -math.inf])
def test_a_scale_that_is_no_number_is_refused(tetrahedron, scale):
    wild = dataclasses.replace(tetrahedron, scale=(1.0, scale, 1.0))
    with pytest.raises(WorkbenchError, match=r"tetrahedron\.obj: its scale is not finite$"):
        collision_mesh(wild)


@pytest.mark.parametrize("name", ["missing.obj", "", "x" * 5000, "a\0b.obj", "round.obj"])
def test_what_is_no_file_is_refused(tmp_path, name):
    (tmp_path / "round.obj").symlink_to("round.obj")
    path = tmp_path / name
    with pytest.raises(WorkbenchError) as caught:
        visual_mesh(Mesh(name, path))
    assert str(caught.value).startswith(f"{path}: "[:1000])


def test_a_mesh_that_was_not_found_is_refused_by_its_uri():
    with pytest.raises(WorkbenchError, match=r"^model://x/a\.dae: no such file$"):
        visual_mesh(Mesh("model://x/a.dae", None))


def test_a_huge_file_is_refused_unread(tmp_path):
    path = tmp_path / "huge.stl"
    with path.open("wb") as file:
        file.truncate(100_000_001)
    with pytest.raises(WorkbenchError, match=r"huge\.stl: it is larger than 100 MB$"):
        visual_mesh(Mesh("huge.stl", path))


def test_no_mesh_library_is_loaded_here():
    code = "import sys, workbench.plant.meshes; print(*sys.modules)"
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert not {"trimesh", "collada", "numpy", "scipy", "PIL"} & set(done.stdout.split())


FETCHED = Path(__file__).resolve().parents[4] / "shared" / "models"


@pytest.mark.slow
@pytest.mark.skipif(
    not FETCHED.is_dir(), reason="put the published descriptions into ../shared/models to try them"
)
def test_published_meshes_are_all_converted():
    files = [path for path in sorted(FETCHED.rglob("*")) if path.suffix in (".dae", ".stl")]
    assert len(files) >= 7
    uses = [
        MeshUse(Mesh(path.name, path), use) for path in files for use in ("visual", "collision")
    ]
    for use, path in convert_meshes(uses).items():
        assert isinstance(path, Path), str(path)
        if use.use == "collision":
            twin = convert_meshes([MeshUse(use.mesh, "visual")])[MeshUse(use.mesh, "visual")]
            assert np.subtract(bounds(path), bounds(twin)) == pytest.approx(0.0, abs=2e-5)


# Rotor discs lie across z, whatever <up_axis> says: thin along z, long along y.
@pytest.mark.slow
@pytest.mark.skipif(
    not FETCHED.is_dir(), reason="put the published descriptions into ../shared/models to try them"
)
def test_a_published_propeller_lies_in_the_plane_of_its_disc():
    for name in ("propeller_cw.dae", "propeller_ccw.dae"):
        path = FETCHED / "rotors_description" / "meshes" / name
        low, high = bounds(visual_mesh(Mesh(name, path)))
        x, y, z = np.subtract(high, low)
        assert y > 8 * x > 8 * z > 0
