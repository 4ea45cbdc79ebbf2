"""Includes end: circles, depths, numbers and sizes."""

from pathlib import Path

import pytest

from workbench.common.errors import WorkbenchError
from workbench.plant.formats.sdf import read_sdf
from workbench.plant.model import Model
from workbench.plant.packages import PackageFinder
from workbench.plant.remarks import Remarks


def write(folder: Path, content: str, name: str = "top.sdf") -> Path:
    path = folder / name
    path.parent.mkdir(exist_ok=True)
    path.write_text(f'<sdf version="1.9">\n<model name="top">\n{content}\n</model>\n</sdf>')
    return path


def read(path: Path, **packages: Path) -> Model:
    return read_sdf(path, PackageFinder(path, packages), Remarks())


def fault(path: Path) -> str:
    with pytest.raises(WorkbenchError) as caught:
        read(path)
    said = str(caught.value)
    assert "\n" not in said
    return said


def test_an_include_of_itself_ends(tmp_path):
    said = fault(write(tmp_path, "<include><uri>top.sdf</uri></include>"))
    assert "top.sdf:3: the file includes itself (top.sdf -> top.sdf)" in said


def test_includes_in_a_circle_end(tmp_path):
    write(tmp_path, "<include><uri>b.sdf</uri></include>", "a.sdf")
    write(tmp_path, "<include><uri>a.sdf</uri></include>", "b.sdf")
    said = fault(write(tmp_path, "<include><uri>a.sdf</uri></include>"))
    assert "(top.sdf -> a.sdf -> b.sdf -> a.sdf)" in said


def test_a_circle_through_links_of_the_file_system_ends(tmp_path):
    path = write(tmp_path, "<include><uri>other.sdf</uri></include>")
    (tmp_path / "other.sdf").symlink_to(path)
    assert "includes itself (top.sdf -> other.sdf)" in fault(path)


def test_includes_end_at_a_depth(tmp_path):
    for index in range(30):
        write(tmp_path, f"<include><uri>m{index + 1}.sdf</uri></include>", f"m{index}.sdf")
    assert "levels deep" in fault(tmp_path / "m0.sdf")


def test_a_chain_of_bare_includes_ends_at_a_depth(tmp_path):
    for index in range(30):
        (tmp_path / f"m{index}.sdf").write_text(
            f'<sdf version="1.9"><include><uri>m{index + 1}.sdf</uri></include></sdf>'
        )
    assert "levels deep" in fault(tmp_path / "m0.sdf")


def test_includes_that_multiply_end_at_a_number(tmp_path):
    for index in range(10):
        both = "".join(
            f"<include><name>{side}</name><uri>m{index + 1}.sdf</uri></include>" for side in "abc"
        )
        write(tmp_path, both, f"m{index}.sdf")
    write(tmp_path, '<link name="l"/>', "m10.sdf")
    assert "more than 200 includes" in fault(tmp_path / "m0.sdf")


def test_includes_of_large_files_end_at_a_size(tmp_path):
    filler = "<plugin>" + "<x/>" * 60_000 + "</plugin>"
    write(tmp_path, f'<link name="l"/>{filler}', "large.sdf")
    path = write(
        tmp_path,
        "".join(
            f"<include><name>m{index}</name><uri>large.sdf</uri></include>" for index in range(9)
        ),
    )
    assert "more than 200000 elements" in fault(path)
