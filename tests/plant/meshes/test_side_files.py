"""Folders as packages have them, and names as strangers write them."""

import pytest

from workbench.plant.meshes.side_files import find_side_file, side_files

ADDRESS = "file:" + "///"


@pytest.fixture
def package(tmp_path):
    """`home/drone/meshes/body.dae`, textures in their two usual places, and a secret outside."""
    root = tmp_path.resolve() / "home" / "drone"
    for name in (
        "meshes/body.dae",
        "meshes/skin.png",
        "meshes/two words.png",
        "meshes/deeper/sign.jpg",
        "materials/textures/wood.png",
        "secret.txt",
        "../secret.png",
    ):
        path = root / name
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(name)
    return root


@pytest.mark.parametrize(
    ("name", "found"),
    [
        ("skin.png", "meshes/skin.png"),
        (" ./skin.png\n", "meshes/skin.png"),
        ("two%20words.png", "meshes/two words.png"),
        ("two words.png", "meshes/two words.png"),
        ("deeper\\sign.jpg", "meshes/deeper/sign.jpg"),
        ("../materials/textures/wood.png", "materials/textures/wood.png"),
        ("wood.png", "materials/textures/wood.png"),
        ("model://drone/materials/textures/wood.png", "materials/textures/wood.png"),
        (f"{ADDRESS}C:/textures/skin.png", "meshes/skin.png"),
        ("C:\\Users\\me\\skin.png", "meshes/skin.png"),
        ("/opt/me/skin.png", "meshes/skin.png"),
    ],
)
def test_a_picture_is_found_where_gazebo_looks(package, name, found):
    assert find_side_file(package / "meshes/body.dae", name) == package / found


@pytest.mark.parametrize(
    "name",
    [
        "../../secret.png",
        "../secret.txt",
        "body.dae",
        "/etc/passwd",
        f"{ADDRESS}etc/passwd",
        "http://example.com/a.png",
        "",
        ".",
        "..",
        "a\0b.png",
        "x" * 5000 + ".png",
        "missing.png",
    ],
)
def test_nothing_else_is_found(package, name):
    assert find_side_file(package / "meshes/body.dae", name) is None


def test_a_file_outside_is_not_found_by_its_full_path(package):
    outside = package.parent / "secret.png"
    assert outside.is_file()
    assert find_side_file(package / "meshes/body.dae", str(outside)) is None


def test_a_link_does_not_lead_outside(package):
    (package / "meshes/link.png").symlink_to(package.parent / "secret.png")
    assert find_side_file(package / "meshes/body.dae", "link.png") is None


def test_links_in_a_circle_are_not_followed(package):
    (package / "meshes/round.png").symlink_to("round.png")
    assert find_side_file(package / "meshes/body.dae", "round.png") is None


def test_a_huge_picture_is_not_read(package):
    huge = package / "meshes/huge.png"
    with huge.open("wb") as file:
        file.truncate(65_000_000)
    assert find_side_file(package / "meshes/body.dae", "huge.png") is None


@pytest.mark.parametrize(
    ("mesh", "content"),
    [
        ("a.dae", b"<image><init_from>skin.png</init_from></image>"),
        ("a.dae", b"<image><init_from>\n <ref>skin.png</ref></init_from></image>"),
        ("a.gltf", b'{"images": [{"uri" : "skin.png"}, {"uri": "data:,x"}]}'),
        ("a.ply", b"ply\ncomment TextureFile skin.png\nend_header\n"),
        ("a.STL", b""),
    ],
)
def test_the_files_that_a_mesh_names_are_found_by_words(package, mesh, content):
    wanted = [] if mesh == "a.STL" else [package / "meshes/skin.png"]
    assert side_files(package / "meshes" / mesh, content) == wanted


def test_the_pictures_of_an_obj_are_found_through_its_materials(package):
    materials = package / "meshes/a.mtl"
    materials.write_text("newmtl red\nmap_Kd skin.png\n")
    found = side_files(package / "meshes/a.obj", b"mtllib a.mtl\nv 0 0 0\n")
    assert found == [materials, package / "meshes/skin.png"]
