"""What makes a conversion another one, and what a damaged file looks like."""

import dataclasses
import json
import os

import pytest

from workbench.plant.meshes.job import MeshJob, is_sealed, sealed, write_whole


@pytest.fixture
def job(tmp_path):
    """A job on a mesh with a texture."""
    (tmp_path / "a.dae").write_bytes(b"")
    (tmp_path / "skin.png").write_bytes(b"")
    return MeshJob(str(tmp_path / "a.dae"), "visual", (1.0, 1.0, 1.0), "", False, None)


CONTENT = b"<init_from>skin.png</init_from>"


@pytest.mark.parametrize(
    "change",
    [
        {"use": "collision"},
        {"scale": (1.0, 1.0, -1.0)},
        {"submesh": "blade"},
        {"center": True},
        {"rgba": (1.0, 0.0, 0.0, 1.0)},
    ],
)
def test_another_job_has_another_target(job, tmp_path, change):
    other = dataclasses.replace(job, **change)
    assert other.target(tmp_path, CONTENT) != job.target(tmp_path, CONTENT)
    assert job.target(tmp_path, CONTENT) == job.target(tmp_path, CONTENT)


def test_other_content_has_another_target(job, tmp_path):
    assert job.target(tmp_path, b"a") != job.target(tmp_path, b"b")


def test_another_texture_makes_another_target(job, tmp_path):
    before = job.target(tmp_path, CONTENT)
    (tmp_path / "skin.png").write_bytes(b"other")
    after = job.target(tmp_path, CONTENT)
    os.utime(tmp_path / "skin.png", (1, 1))
    assert len({before, after, job.target(tmp_path, CONTENT)}) == 3


@pytest.mark.parametrize(
    "name", ["../../x.dae", ".dae", "a b\n.dae", "x" * 200 + ".dae", "\udcff.dae"]
)
def test_a_target_is_a_plain_name_in_the_folder(tmp_path, name):
    job = MeshJob(name, "visual", (1.0, 1.0, 1.0), "\udcff", False, None)
    target = job.target(tmp_path, b"")
    assert target.parent == tmp_path
    assert target.name.isascii() and target.name.isprintable() and len(target.name) < 90


GLTF = b'{"asset":{"version":"2.0"}}'


def test_a_damaged_file_is_known(case, tmp_path):
    for damage, whole in [
        (lambda data: data, True),
        (lambda data: data[:-1], False),
        (lambda data: data[:10], False),
        (lambda data: b"", False),
        (lambda data: data.replace(b"0", b"1", 1), False),
        (lambda data: data + b" ", False),
        (lambda data: b"\0" * len(data), False),
    ]:
        for suffix, content in [(".gltf", GLTF), (".obj", b"v 0 0 0\n")]:
            with case(damage, whole, suffix, content):
                path = tmp_path / f"a{suffix}"
                path.write_bytes(damage(sealed(content, suffix)))
                assert is_sealed(path) == whole


def test_a_missing_file_is_not_sealed(tmp_path):
    assert not is_sealed(tmp_path / "a.obj")


def test_a_sealed_gltf_is_still_json():
    assert json.loads(sealed(GLTF, ".gltf"))["asset"] == {"version": "2.0"}


def test_a_file_is_written_whole_and_nothing_is_left_over(tmp_path):
    write_whole(tmp_path / "a.obj", b"one")
    write_whole(tmp_path / "a.obj", b"two")
    assert [path.name for path in tmp_path.iterdir()] == ["a.obj"]
    assert (tmp_path / "a.obj").read_bytes() == b"two"


def test_a_failed_write_leaves_the_old_file(tmp_path):
    (tmp_path / "a.obj").mkdir()
    with pytest.raises(OSError):
        write_whole(tmp_path / "a.obj", b"new")
    assert [path.name for path in tmp_path.iterdir()] == ["a.obj"]
