"""Whatever a file says, there is an answer or a sentence; never another exception."""

import random
from pathlib import Path

import pytest

from workbench.common.errors import WorkbenchError
from workbench.extras.formats.sdf import read_sdf
from workbench.extras.formats.sdf_node import MAX_SDF_NAME_CHARS
from workbench.plant.packages import PackageFinder
from workbench.plant.remarks import Remarks

QUAD = """<?xml version="1.0"?>
<sdf version="1.9">
<model name="quad" canonical_link="base">
  <include merge="true"><uri>part.sdf</uri><pose relative_to="base">0 0 1 0 0 0</pose></include>
  <link name="base">
    <inertial auto="false"><pose>0 0 0 0 0 0</pose><mass>1.5</mass>
      <inertia><ixx>0.1</ixx><iyy>0.2</iyy><izz>0.25</izz></inertia></inertial>
    <visual name="v"><pose relative_to="mast">0 0 0 0 0 0</pose>
      <geometry><mesh><uri>model://quad/a.stl</uri><scale>1 1 1</scale></mesh></geometry>
      <material><script><name>Gazebo/Red</name></script></material></visual>
    <collision name="c"><geometry><box><size>1 1 1</size></box></geometry></collision>
    <sensor name="imu" type="imu"><gz_frame_id>base</gz_frame_id></sensor>
  </link>
  <link name="rotor"><pose degrees="true">0.5 0 0 0 0 90</pose>
    <inertial auto="true"/>
    <collision name="c"><geometry><cylinder><radius>1</radius></cylinder></geometry></collision>
  </link>
  <frame name="mast" attached_to="base">
    <pose rotation_format="quat_xyzw">0 0 3 0 0 0 1</pose></frame>
  <model name="inner" placement_frame="spot"><pose relative_to="mast"/>
    <link name="l"/><frame name="spot" attached_to="l"/></model>
  <joint name="spin" type="revolute"><pose relative_to="rotor"/>
    <parent>base</parent><child>rotor</child>
    <axis><xyz expressed_in="__model__">0 0 1</xyz></axis></joint>
  <joint name="hold" type="fixed"><parent>base</parent><child>inner::l</child></joint>
  <plugin filename="motor_model" name="m"><jointName>spin</jointName></plugin>
</model>
</sdf>
"""
PART = '<sdf version="1.9"><model name="part"><link name="p"/><frame name="q"/></model></sdf>'

NUMBERS = ("nan", "inf", "-1", "1e308", "1e-320", "0", "''", "", " ", "x" * 3 * MAX_SDF_NAME_CHARS)
NAMES = ("::", "__model__", "world", "base", "rotor", "mast", "inner", "inner::l", "spin", "true")
PATHS = ("quad.sdf", "part.sdf", "model://quad", "http://x", ".", "/", "../", "&#0;", "&#1;")
TAGS = ("<a/>", "</link>", "<model name='x'>", "</model>", "<include><uri>part.sdf</uri></include>")
WORDS = (*NUMBERS, *NAMES, *PATHS, *TAGS, "<include><uri>quad.sdf</uri></include>")


def mutate(dice: random.Random, text: str) -> str:
    """Return a text with some of its words exchanged, lost, doubled or replaced."""
    for _ in range(dice.randint(1, 4)):
        start = dice.randrange(len(text))
        end = min(len(text), start + dice.choice([1, 2, 5, 20, 200]))
        match dice.randrange(5):
            case 0:
                text = text[:start] + text[end:]
            case 1:
                text = text[:end] + text[start:]
            case 2:
                text = text[:start] + dice.choice(WORDS) + text[end:]
            case 3:
                old = dice.choice(text.replace("<", " <").replace(">", "> ").split() or [" "])
                text = text.replace(old, dice.choice(WORDS), dice.choice([1, -1]))
            case 4:
                values = dice.choice(["0.1", "rotor", "base", "mast", "1 1 1", "0 0 0", "1.9"])
                text = text.replace(values, dice.choice(WORDS), 1)
        if not text:
            return ""
    return text


@pytest.fixture
def folder(tmp_path) -> Path:
    (tmp_path / "part.sdf").write_text(PART)
    return tmp_path


def refused(path: Path) -> bool:
    """Read a file; return whether a sentence refuses it, and let pytest show anything else."""
    try:
        read_sdf(path, PackageFinder(path), Remarks())
    except WorkbenchError as error:
        said = str(error)
        assert "\n" not in said
        assert len(said) < 1000
        assert str(path.parent) in said
        return True
    return False


def test_the_model_itself_is_read(folder):
    path = folder / "quad.sdf"
    path.write_text(QUAD)
    model = read_sdf(path, PackageFinder(path), Remarks())
    assert [link.name for link in model.links] == ["p", "base", "rotor", "inner::l"]


def test_mutated_files_give_an_answer_or_a_sentence(folder, case):
    path = folder / "quad.sdf"
    refusals = 0
    for seed in range(300):
        with case(seed):
            path.write_text(mutate(random.Random(seed), QUAD))
            refusals += refused(path)
    assert 100 < refusals < 300  # some mutations change nothing that is read


def test_a_file_cut_off_anywhere_gives_a_sentence(folder):
    path = folder / "quad.sdf"
    for end in range(0, len(QUAD.rstrip()), 37):
        path.write_text(QUAD[:end])
        assert refused(path), end


@pytest.mark.parametrize(
    "text",
    [
        '<sdf version="1.9"><model name="m">' + '<link name="l">' * 90,
        '<sdf version="' + "9" * 5000 + '.1"><model name="m"/></sdf>',
        '<sdf version="1.9"><model name="m"><pose>' + "1 " * 100_000 + "</pose></model></sdf>",
        '<sdf version="1.9"><model name="m"><link name="l"><pose>'
        + "1" * 100_000
        + " 0 0 0 0 0</pose></link></model></sdf>",
        '<sdf version="1.9"><world name="w"><world name="v"/></world></sdf>',
    ],
)
def test_what_is_too_much_gives_a_sentence(folder, text):
    path = folder / "quad.sdf"
    path.write_text(text)
    assert refused(path)


def test_placement_frames_that_hang_on_one_another_end(folder):
    (folder / "a.sdf").write_text(PART.replace('"p"', '"pa"').replace('"q"', '"qa"'))
    (folder / "b.sdf").write_text(PART.replace('"p"', '"pb"').replace('"q"', '"qb"'))
    path = folder / "quad.sdf"
    path.write_text(
        '<sdf version="1.9"><model name="m">'
        '<include merge="1"><uri>a.sdf</uri><placement_frame>qb</placement_frame></include>'
        '<include merge="1"><uri>b.sdf</uri><placement_frame>qa</placement_frame></include>'
        "</model></sdf>"
    )
    with pytest.raises(WorkbenchError, match="placement frame"):
        read_sdf(path, PackageFinder(path), Remarks())
