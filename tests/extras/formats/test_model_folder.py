"""A Gazebo model's folder stands for the description in it."""

import pytest

from workbench.common.errors import WorkbenchError
from workbench.plant.formats.model_folder import description_file


def config(*files: tuple[str, str]) -> str:
    lines = "".join(f'<sdf version="{version}">{name}</sdf>' for version, name in files)
    return f"<model><name>m</name>{lines}</model>"


def fill(folder, **texts: str):
    for name, text in texts.items():
        (folder / name.replace("__", ".")).write_text(text)
    return folder


def test_a_file_is_itself(tmp_path):
    assert description_file(tmp_path / "a.sdf") == tmp_path / "a.sdf"


def test_the_newest_version_counts_not_the_last(tmp_path):
    files = (("1.4", "a.sdf"), ("1.10", "c.sdf"), ("1.9", "b.sdf"))
    fill(tmp_path, model__config=config(*files), a__sdf="", b__sdf="", c__sdf="")
    assert description_file(tmp_path).name == "c.sdf"


@pytest.mark.parametrize(
    ("names", "chosen"),
    [
        (["model.sdf", "model-1_4.sdf"], "model.sdf"),
        (["drone.urdf"], "drone.urdf"),
        (["drone.urdf.xacro", "motor.xacro", "frame.xacro"], "drone.urdf.xacro"),
    ],
)
def test_without_a_config_the_plain_choice_is_taken(tmp_path, names, chosen):
    for name in names:
        (tmp_path / name).touch()
    assert description_file(tmp_path).name == chosen


@pytest.mark.parametrize(
    ("texts", "said"),
    [
        ({}, "no model.config"),
        ({"a__urdf": "", "b__urdf": ""}, "name one of a.urdf, b.urdf"),
        ({"model__config": config(("1.6", "gone.sdf"))}, "gone.sdf does not exist"),
        ({"model__config": config()}, "does not name an <sdf> file"),
        ({"model__config": "<model>"}, "not XML"),
    ],
)
def test_no_plain_choice_is_a_sentence(tmp_path, texts, said):
    with pytest.raises(WorkbenchError, match=said):
        description_file(fill(tmp_path, **texts))
