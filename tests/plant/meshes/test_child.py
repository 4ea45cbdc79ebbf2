"""Small meshes written here; bounds by hand, measured by Drake's own reading of the result."""

import io
import json
import re
import struct
from pathlib import Path

import numpy as np
import pytest
import trimesh
from PIL import Image
from pydrake.geometry import Convex

from workbench.common.errors import WorkbenchError
from workbench.plant.meshes import child, collada, gltf, mesh_file
from workbench.plant.meshes.child import convert_all, converted_content
from workbench.plant.meshes.job import MeshJob, is_sealed, read_reason

CORNERS = ((0, 0, 0), (1, 0, 0), (0, 2, 0), (0, 0, 3))
FACES = ((0, 2, 1), (0, 1, 3), (0, 3, 2), (1, 2, 3))
"""A tetrahedron, its faces seen from outside."""


def stl(corners=CORNERS, name: str = "tetrahedron") -> str:
    """ASCII STL."""
    facets = "".join(
        "facet normal 0 0 0\nouter loop\n"
        + "".join("vertex {} {} {}\n".format(*corners[i]) for i in face)
        + "endloop\nendfacet\n"
        for face in FACES
    )
    return f"solid {name}\n{facets}endsolid {name}\n"


def binary_stl(tail: bytes = b"") -> bytes:
    """Binary STL, perhaps with something after its end."""
    facets = b"".join(
        struct.pack("<12fH", 0, 0, 0, *(x for i in face for x in CORNERS[i]), 0) for face in FACES
    )
    return bytes(80) + struct.pack("<I", len(FACES)) + facets + tail


def obj(head: str = "", before_faces: str = "") -> str:
    """OBJ with texture coordinates."""
    vertices = "".join("v {} {} {}\n".format(*corner) for corner in CORNERS)
    uv = "vt 0 0\nvt 1 0\nvt 0 1\nvt 1 1\n"
    faces = "".join("f " + " ".join(f"{i + 1}/{i + 1}" for i in face) + "\n" for face in FACES)
    return head + vertices + uv + before_faces + faces


def ply(colors: bool) -> str:
    """ASCII PLY, its vertices perhaps half-grey and see-through."""
    color = "".join(f"property uchar {name}\n" for name in ("red", "green", "blue", "alpha"))
    lines = [
        "{} {} {}".format(*corner) + (" 128 128 128 0" if colors else "") for corner in CORNERS
    ]
    lines += ["3 {} {} {}".format(*face) for face in FACES]
    return (
        "ply\nformat ascii 1.0\nelement vertex 4\nproperty float x\nproperty float y\n"
        f"property float z\n{color if colors else ''}element face 4\n"
        "property list uchar int vertex_indices\nend_header\n" + "\n".join(lines) + "\n"
    )


def job(path: Path, use="visual", **changes) -> MeshJob:
    """A job on a file, as it is."""
    given = {"scale": (1.0, 1.0, 1.0), "submesh": "", "center": False, "rgba": None} | changes
    return MeshJob(str(path.resolve()), use, **given)


@pytest.fixture
def written(tmp_path):
    """Write a file and return its path."""

    def write(name: str, content: str | bytes) -> Path:
        path = tmp_path / name
        path.write_bytes(content if isinstance(content, bytes) else content.encode())
        return path

    return write


@pytest.fixture
def bounds(tmp_path):
    """Return what Drake reads of a conversion: its lowest and highest corner."""

    def read(asked: MeshJob) -> list[list[float]]:
        path = tmp_path / ("out.gltf" if asked.use == "visual" else "out.obj")
        path.write_bytes(converted_content(asked))
        hull = Convex(str(path)).GetConvexHull()
        corners = np.array([hull.vertex(i) for i in range(hull.num_vertices())])
        return [corners.min(axis=0).round(5).tolist(), corners.max(axis=0).round(5).tolist()]

    return read


def failure(asked: MeshJob) -> str:
    with pytest.raises(WorkbenchError) as caught:
        converted_content(asked)
    return str(caught.value)


WHOLE = [[0, 0, 0], [1, 2, 3]]

FORMATS = {
    "a.stl": stl(),
    "a.STL": binary_stl(),
    "longer.stl": binary_stl(b"left over"),
    "latin.stl": stl(name="K\xf6rper").encode("latin-1"),
    "a.obj": obj(),
    "latin.obj": obj("# K\xf6rper\n").encode("latin-1"),
    "a.ply": ply(colors=True),
    "plain.ply": ply(colors=False),
    "a.off": "OFF\n4 4 0\n"
    + "".join("{} {} {}\n".format(*corner) for corner in CORNERS)
    + "".join("3 {} {} {}\n".format(*face) for face in FACES),
}


@pytest.mark.parametrize("use", ["visual", "collision"])
@pytest.mark.parametrize("name", FORMATS)
def test_each_format_is_read(written, bounds, name, use):
    assert bounds(job(written(name, FORMATS[name]), use)) == WHOLE


@pytest.mark.parametrize("suffix", [".glb", ".gltf"])
def test_gltf_of_others_keeps_its_axes_as_in_gazebo(written, bounds, suffix):
    scene = trimesh.Scene([trimesh.Trimesh(CORNERS, FACES)])
    if suffix == ".glb":
        content = scene.export(file_type="glb")
    else:
        content = scene.export(file_type="gltf", embed_buffers=True)["model.gltf"]
    assert bounds(job(written(f"a{suffix}", content))) == WHOLE


def test_gltf_written_here_is_read_as_it_was_meant(written, bounds):
    once = written("once.gltf", converted_content(job(written("a.stl", stl()))))
    assert bounds(job(once)) == WHOLE


@pytest.mark.parametrize("use", ["visual", "collision"])
@pytest.mark.parametrize(
    ("scale", "low", "high"),
    [
        ((2.0, 1.0, 0.5), [0, 0, 0], [2, 2, 1.5]),
        ((-1.0, 1.0, 1.0), [-1, 0, 0], [0, 2, 3]),
        ((-1.0, -2.0, -0.001), [-1, -4, -0.003], [0, 0, 0]),
    ],
)
def test_scale_is_in_the_vertices(written, bounds, use, scale, low, high):
    assert bounds(job(written("a.stl", stl()), use, scale=scale)) == [low, high]


def normals_file(written) -> Path:
    """An OBJ with normals: those of a sphere about the tetrahedron's centre."""
    lines = ["v {} {} {}".format(*corner) for corner in CORNERS]
    lines += ["vn {} {} {}".format(*np.subtract(corner, (0.25, 0.5, 0.75))) for corner in CORNERS]
    lines += ["f " + " ".join(f"{i + 1}//{i + 1}" for i in face) for face in FACES]
    return written("normals.obj", "\n".join(lines))


@pytest.mark.parametrize("scale", [(1, 1, 1), (-1, 1, 1), (-2, -1, 1), (-1, -3, -1)])
def test_faces_and_normals_look_outward_after_mirroring(written, scale):
    path = normals_file(written)
    data = converted_content(job(path, scale=tuple(map(float, scale))))
    [mesh] = load(data).geometry.values()
    assert mesh.volume == pytest.approx(abs(np.prod(scale)))  # negative when inside out
    outward = np.einsum("ij,ij->i", mesh.vertex_normals, mesh.vertices - mesh.center_mass)
    assert (outward > 0).all()


def test_normals_stay_perpendicular_to_what_is_stretched(written):
    # The slope z = x has the normal (-1, 0, 1); stretched to z = 2x it is (-2, 0, 1).
    lines = ["v 0 0 0", "v 1 0 1", "v 0 1 0", "vn -1 0 1", "f 1//1 2//1 3//1"]
    path = written("slope.obj", "\n".join(lines))
    [mesh] = load(converted_content(job(path, scale=(1.0, 1.0, 2.0)))).geometry.values()
    x, y, z = np.array([-2, 0, 1]) / np.sqrt(5)
    assert mesh.vertex_normals[0] == pytest.approx([x, z, -y], abs=1e-6)  # y up in glTF


def test_a_flat_mesh_is_drawn_without_thickness_and_touches_with_a_millimetre(written, bounds):
    path = written("a.stl", stl())
    [mesh] = load(converted_content(job(path, scale=(1.0, 1.0, 0.0)))).geometry.values()
    assert mesh.bounds.tolist() == [[0, 0, -2], [1, 0, 0]]  # y up in glTF
    assert bounds(job(path, "collision", scale=(1.0, 1.0, 0.0))) == [
        [0, 0, -0.0005],
        [1, 2, 0.0005],
    ]


def load(data: bytes) -> trimesh.Scene:
    """Read a glTF without process: vertices as they stand."""
    return trimesh.load_scene(io.BytesIO(data), file_type="gltf", process=False)


def materials(data: bytes) -> list[dict]:
    return json.loads(data)["materials"]


def color(data: bytes) -> list[float]:
    [material] = materials(data)
    return material["pbrMetallicRoughness"]["baseColorFactor"]


def test_the_given_colour_is_used_where_a_file_has_none(written):
    # 0.5 on a screen is 0.214 of the light (IEC 61966-2-1).
    data = converted_content(job(written("a.stl", stl()), rgba=(1.0, 0.5, 0.0, 1.0)))
    assert color(data) == pytest.approx([1.0, 0.214, 0.0, 1.0], abs=0.003)
    assert materials(data)[0]["alphaMode"] == "OPAQUE"


def test_a_given_colour_may_be_translucent(written):
    data = converted_content(job(written("a.stl", stl()), rgba=(1.0, 1.0, 1.0, 0.5)))
    assert color(data)[3] == pytest.approx(0.5, abs=0.003)
    assert materials(data)[0]["alphaMode"] == "BLEND"


@pytest.mark.parametrize("rgba", [(np.nan, 2.0, -1.0, np.inf), (1e308, 0.0, 0.0, -np.inf)])
def test_a_colour_that_is_none_is_bounded(written, rgba):
    assert all(
        0.0 <= value <= 1.0
        for value in color(converted_content(job(written("a.stl", stl()), rgba=rgba)))
    )


def test_an_obj_has_its_own_colour(written):
    written("a.mtl", "newmtl red\nKd 1 0 0\nd 0.5\n")
    path = written("a.obj", obj("mtllib a.mtl\n", "usemtl red\n"))
    data = converted_content(job(path, rgba=(0.0, 0.0, 1.0, 1.0)))
    assert color(data) == pytest.approx([1.0, 0.0, 0.0, 0.5], abs=0.003)


@pytest.mark.parametrize("head", ["", "mtllib missing.mtl\n", "mtllib ../../secret.mtl\n"])
def test_an_obj_without_colour_gets_the_given_one(written, head):
    path = written("a.obj", obj(head, "usemtl red\n"))
    assert color(converted_content(job(path, rgba=(0.0, 0.0, 1.0, 1.0)))) == pytest.approx(
        [0, 0, 1, 1]
    )


def test_colours_of_vertices_are_kept_and_opaque(written):
    data = converted_content(job(written("a.ply", ply(colors=True)), rgba=(1.0, 0.0, 0.0, 1.0)))
    [mesh] = load(data).geometry.values()
    assert mesh.visual.vertex_attributes["color"].tolist() == [[55, 55, 55, 255]] * 4
    assert color(data) == [1, 1, 1, 1]


def picture(kind: str = "PNG", size=(2, 2), mode: str = "RGB", value=(255, 0, 0)) -> bytes:
    content = io.BytesIO()
    Image.new(mode, size, value).save(content, format=kind)
    return content.getvalue()


def textured(written, content: bytes, name: str = "skin.png") -> Path:
    written("skin.png", content)
    written("a.mtl", f"newmtl skin\nKd 0.2 0.2 0.2\nmap_Kd {name}\n")
    return written("a.obj", obj("mtllib a.mtl\n", "usemtl skin\n"))


def images(data: bytes) -> list[Image.Image]:
    """The pictures in a glTF file."""
    return [
        mesh.visual.material.baseColorTexture
        for mesh in load(data).geometry.values()
        if getattr(mesh.visual, "material", None) and mesh.visual.material.baseColorTexture
    ]


def test_a_picture_is_in_the_file_and_where_it_belongs(written):
    data = converted_content(job(textured(written, picture())))
    [image] = images(data)
    assert image.convert("RGB").getpixel((0, 0)) == (255, 0, 0)
    [mesh] = load(data).geometry.values()
    by_corner = {
        tuple(corner): tuple(uv) for corner, uv in zip(mesh.vertices, mesh.visual.uv, strict=True)
    }
    assert by_corner == {
        (0, 0, 0): (0, 0),
        (1, 0, 0): (1, 0),
        (0, 0, -2): (0, 1),
        (0, 3, 0): (1, 1),
    }
    assert color(data) == [1, 1, 1, 1]
    assert '"uri":"data:' in data.decode() and "skin.png" not in data.decode()


@pytest.mark.parametrize(
    "content",
    [
        b"",
        b"no picture",
        picture()[:40],
        b"%!PS-Adobe-3.0 EPSF-3.0\n%%BoundingBox: 0 0 9 9\n%%EndComments\n",
        picture(size=(9000, 9000), mode="1", value=0),
    ],
    ids=["empty", "text", "cut", "PostScript, for which Pillow starts a program", "huge"],
)
def test_a_picture_that_cannot_be_read_is_left_out(written, content):
    data = converted_content(job(textured(written, content), rgba=(0.0, 1.0, 0.0, 1.0)))
    assert images(data) == []


def test_a_large_picture_is_made_smaller(written):
    [image] = images(converted_content(job(textured(written, picture("JPEG", (5000, 100))))))
    assert image.size == (2048, 41)
    assert image.format == "JPEG"


def test_a_picture_with_alpha_is_translucent(written):
    data = converted_content(job(textured(written, picture(mode="RGBA", value=(255, 0, 0, 100)))))
    assert materials(data)[0]["alphaMode"] == "BLEND"


def test_a_picture_outside_of_the_package_is_not_read(tmp_path):
    (tmp_path / "secret.png").write_bytes(picture())
    folder = tmp_path / "drone" / "meshes"
    folder.mkdir(parents=True)
    (folder / "a.mtl").write_text("newmtl skin\nmap_Kd ../../secret.png\n")
    (folder / "a.obj").write_text(obj("mtllib a.mtl\n", "usemtl skin\n"))
    assert images(converted_content(job(folder / "a.obj"))) == []


def split_gltf(written, folder: str = "") -> Path:
    """A glTF with its buffer in a file of its own, which it names in some folder."""
    files = trimesh.Scene([trimesh.Trimesh(CORNERS, FACES)]).export(
        file_type="gltf", merge_buffers=True
    )
    written("gltf_buffer.bin", files["gltf_buffer.bin"])
    text = files["model.gltf"].decode().replace("gltf_buffer", folder + "gltf_buffer")
    return written("a.gltf", text)


def test_a_buffer_beside_a_gltf_is_read(written, bounds):
    assert bounds(job(split_gltf(written))) == WHOLE


def test_a_buffer_outside_of_the_package_is_not_read(written, tmp_path):
    path = split_gltf(written, "../../")
    inside = tmp_path / "drone" / "meshes"
    inside.mkdir(parents=True)
    moved = path.rename(inside / "a.gltf")
    with pytest.raises(FileNotFoundError):
        converted_content(job(moved))


def two_objects() -> str:
    """OBJ of a tetrahedron `left`, and the same 10 m further, `right`."""
    lines = ["v {} {} {}".format(*corner) for corner in CORNERS]
    lines += [f"v {x + 10} {y} {z}" for x, y, z in CORNERS]
    lines += ["o left", *("f " + " ".join(f"{i + 1}" for i in face) for face in FACES)]
    lines += ["g right", *("f " + " ".join(f"{i + 5}" for i in face) for face in FACES)]
    return "\n".join(lines)


def two_nodes() -> bytes:
    """GLB of the same."""
    scene = trimesh.Scene()
    for name, x in (("left", 0.0), ("right", 10.0)):
        mesh = trimesh.Trimesh(np.add(CORNERS, (x, 0, 0)), FACES)
        scene.add_geometry(mesh, geom_name=f"mesh of {name}", node_name=name)
    return scene.export(file_type="glb")


TWO = {
    "a.obj": two_objects(),
    "a.glb": two_nodes(),
    "a.stl": stl(name="left") + stl([(x + 10, y, z) for x, y, z in CORNERS], "right"),
}


@pytest.mark.parametrize("name", TWO)
def test_a_submesh_is_chosen_by_name(written, bounds, name):
    path = written(name, TWO[name])
    assert bounds(job(path)) == [[0, 0, 0], [11, 2, 3]]
    assert bounds(job(path, submesh="left")) == WHOLE
    assert bounds(job(path, submesh="right")) == [[10, 0, 0], [11, 2, 3]]
    assert bounds(job(path, "collision", submesh="right")) == [[10, 0, 0], [11, 2, 3]]


@pytest.mark.parametrize("name", TWO)
def test_an_unknown_submesh_is_refused_with_those_there_are(written, name):
    said = failure(job(written(name, TWO[name]), submesh="top"))
    assert said == "it has no part 'top': it has left, right"


@pytest.mark.parametrize("use", ["visual", "collision"])
def test_a_centred_submesh_lies_about_the_origin(written, bounds, use):
    path = written("a.obj", TWO["a.obj"])
    low, high = [-1, -1, -1.5], [1, 1, 1.5]
    assert bounds(job(path, use, submesh="right", center=True, scale=(2.0, 1.0, 1.0))) == [
        low,
        high,
    ]


@pytest.mark.parametrize(
    ("name", "content", "said"),
    [
        ("a.stl", "", "it has no faces"),
        ("a.stl", "solid nothing\nendsolid nothing\n", "it has no faces"),
        ("a.stl", bytes(84), "it has no faces"),
        ("a.stl", stl([(0, 0, 0), (float("nan"), 0, 0), (0, 2, 0), (0, 0, 3)]), "not a number"),
        ("a.obj", obj().replace("v 1 0 0", "v inf 0 0"), "not a number"),
        ("a.obj", obj().replace("v 1 0 0", "v 1e9 0 0"), "it reaches 1e+09 m"),
        ("a.ply", ply(False).replace("3 0 2 1", "3 0 2 9"), "a vertex that is not there"),
        ("a.ply", ply(False).replace("3 0 2 1", "3 0 2 -9"), "a vertex that is not there"),
        ("a.ply", re.sub(r"^3 .*$", "3 0 1 1", ply(False), flags=re.MULTILINE), "it has no faces"),
        ("a.xyz", "0 0 0\n", "'.xyz' cannot be read: convert it to one of .dae, .glb"),
        ("a.3ds", "MM", "'.3ds' cannot be read"),
        ("mesh", "", "'' cannot be read"),
        ("a.obj", "v 0 0 0\nv 1 0 0\nl 1 2\n", "it has no faces"),
    ],
)
def test_what_is_no_mesh_is_refused_in_a_clause(written, name, content, said):
    assert said in failure(job(written(name, content)))


@pytest.mark.parametrize(
    ("name", "content"),
    [
        ("a.stl", stl()),
        ("a.stl", binary_stl()),
        ("a.ply", ply(True)),
        ("a.obj", obj()),
        ("a.off", "OFF\n4 4 6\n"),
    ],
)
def test_too_many_faces_are_refused_before_they_are_read(written, monkeypatch, name, content):
    for reader in (collada, mesh_file):
        monkeypatch.setattr(reader, "MAX_MESH_FACES", 3)
    assert failure(job(written(name, content))) == "it states 4 faces, more than 3"


def test_too_many_faces_of_a_scene_are_refused(written, monkeypatch):
    for reader in (collada, mesh_file):
        monkeypatch.setattr(reader, "MAX_MESH_FACES", 3)
    assert failure(job(written("a.glb", TWO["a.glb"]))) == "it has more than 3 faces"


def test_too_many_nodes_of_a_scene_are_refused(written, monkeypatch):
    for reader in (collada, mesh_file):
        monkeypatch.setattr(reader, "MAX_SCENE_NODES", 1)
    assert failure(job(written("a.glb", TWO["a.glb"]))) == "it has more than 1 nodes"


def test_vertices_that_no_face_uses_do_not_matter(written, bounds):
    path = written(
        "a.ply", ply(False).replace("vertex 4", "vertex 5").replace("3 0 2 1", "nan 9e9 0\n3 0 2 1")
    )
    assert bounds(job(path)) == WHOLE


def test_all_requests_are_answered_and_the_good_ones_written(written, tmp_path):
    good, bad = written("a.stl", stl()), written("b.stl", "solid\xff")
    ugly = written("c.glb", b"glTF")
    requests = [
        (vars(job(path)), str(tmp_path / f"{path.stem}.gltf")) for path in (bad, good, ugly)
    ]
    convert_all(requests)
    b, a, c = (read_reason(Path(target)) for _, target in requests)
    assert a is None
    assert is_sealed(tmp_path / "a.gltf")
    assert b == "it has no faces"
    assert c.startswith("it cannot be read: ") and "\n" not in c
    assert not (tmp_path / "b.gltf").exists()


@pytest.mark.parametrize(
    ("error", "said"),
    [
        (MemoryError(), "it needs too much memory"),
        (RecursionError(), "it is nested too deeply"),
        (KeyError("primitives"), "it cannot be read: 'primitives'"),
    ],
)
def test_whatever_a_reader_raises_is_a_clause(written, tmp_path, monkeypatch, error, said):
    def fail(*_):
        raise error

    monkeypatch.setattr(child, "read_parts", fail)
    path = written("a.stl", stl())
    convert_all([(vars(job(path)), str(tmp_path / "a.gltf"))])
    assert read_reason(tmp_path / "a.gltf") == said


def test_parts_that_look_alike_are_one(written):
    [mesh] = load(converted_content(job(written("a.glb", TWO["a.glb"])))).geometry.values()
    assert mesh.volume == pytest.approx(2.0)
    assert len(mesh.split()) == 2


def test_faces_of_an_stl_share_vertices(written):
    [mesh] = load(converted_content(job(written("a.stl", stl())))).geometry.values()
    assert mesh.vertices.shape == (4, 3)


def test_too_many_looks_are_refused(written, monkeypatch):
    monkeypatch.setattr(gltf, "_MAX_MATERIALS", 0)
    assert failure(job(written("a.stl", stl()))) == "it has more than 0 materials"
