"""Which model of a world flies."""

from pathlib import Path

import pytest

from workbench.common.errors import WorkbenchError
from workbench.extras.formats.sdf import read_sdf
from workbench.plant.packages import PackageFinder
from workbench.plant.remarks import DescriptionRemark, Remarks

MOTORS = (
    'filename="gz-sim-multicopter-motor-model-system" name="gz::sim::systems::Multicopter"',
    'filename="x" name="gz::sim::systems::MulticopterMotorModel"',
    'filename="librotors_gazebo_motor_model.so" name="m"',
    'filename="libgazebo_motor_model.so" name="m"',
)


def box(name: str, inside: str = "") -> str:
    return f'<model name="{name}"><link name="l"/>{inside}</model>'


def drone(name: str, motor: str = MOTORS[0]) -> str:
    return box(name, f"<plugin {motor}/>")


STATIC = "<static>true</static>"


def read(folder: Path, content: str) -> tuple[str, list[DescriptionRemark]]:
    """Return the name of the model that was chosen, and what was said of that."""
    path = folder / "world.sdf"
    path.write_text(f'<sdf version="1.9"><world name="w">\n{content}</world></sdf>')
    remarks = Remarks()
    name = read_sdf(path, PackageFinder(path), remarks).name
    return name, [remark for remark in remarks.found if "models" in remark.element]


def fault(folder: Path, content: str) -> str:
    with pytest.raises(WorkbenchError) as caught:
        read(folder, content)
    return str(caught.value)


def test_the_only_model_flies(tmp_path):
    name, remarks = read(tmp_path, box("crate"))
    assert name == "crate"
    assert remarks == []


@pytest.mark.parametrize("motor", MOTORS)
def test_the_one_with_motors_flies_and_the_others_are_noted(tmp_path, motor):
    name, remarks = read(tmp_path, box("crate") + drone("x3", motor) + box("floor", STATIC))
    assert name == "x3"
    (remark,) = remarks
    assert remark.kind == "ignored"
    assert remark.text == "'x3' flies; left out are 'crate', 'floor'"


def test_where_none_has_motors_the_one_that_can_move_flies(tmp_path):
    name, _ = read(tmp_path, box("floor", STATIC) + box("x3") + box("wall", STATIC))
    assert name == "x3"


def test_a_model_that_says_in_its_own_file_that_it_is_static_does_not_fly(tmp_path):
    (tmp_path / "town.sdf").write_text(f'<sdf version="1.9">{box("town", STATIC)}</sdf>')
    town = "<include><uri>town.sdf</uri></include>"
    assert read(tmp_path, town + box("x3"))[0] == "x3"
    moving = "<include><uri>town.sdf</uri><static>false</static></include>"
    assert "'town', 'x3'" in fault(tmp_path, moving + box("x3"))
    assert "all its models are static" in fault(tmp_path, town + box("wall", STATIC))


def test_several_with_motors_are_listed(tmp_path):
    said = fault(tmp_path, drone("x3") + box("crate") + drone("x4"))
    assert "several of its models could be the drone: 'x3', 'x4': give" in said


def test_several_that_can_move_are_listed(tmp_path):
    said = fault(tmp_path, "".join(box(f"crate_{index}") for index in range(12)))
    assert "'crate_0', 'crate_1'" in said
    assert "'crate_9' and 2 more" in said


def test_models_that_stand_still_do_not_fly(tmp_path):
    assert "static" in fault(tmp_path, box("floor", STATIC) + box("wall", STATIC))


def test_a_world_without_models_is_refused(tmp_path):
    assert "there is no <model> in it" in fault(tmp_path, '<light name="sun"/>')


def test_an_include_is_a_model_and_may_bring_the_motors(tmp_path):
    (tmp_path / "x3.sdf").write_text(f'<sdf version="1.9">{box("x3")}</sdf>')
    include = f"<include><uri>x3.sdf</uri><name>mine</name><plugin {MOTORS[0]}/></include>"
    name, remarks = read(tmp_path, box("crate") + include)
    assert name == "mine"
    assert "'crate'" in remarks[0].text


def test_scenery_that_is_not_at_hand_does_not_matter_to_a_drone_with_motors(tmp_path):
    scenery = "<include><uri>https://fuel.gazebosim.org/1.0/o/models/Forest/2</uri></include>"
    name, remarks = read(tmp_path, scenery + drone("x3"))
    assert name == "x3"
    assert "left out are 'Forest'" in remarks[0].text


def test_what_gazebo_brings_along_is_never_the_drone(tmp_path):
    scenery = "".join(
        f"<include><uri>{uri}</uri></include>"
        for uri in (
            "model://sun",
            "model://ground_plane",
            "https://fuel.gazebosim.org/1.0/OpenRobotics/models/Ground Plane",
        )
    )
    assert read(tmp_path, scenery + box("x3"))[0] == "x3"


def test_an_include_that_says_it_is_static_need_not_be_at_hand(tmp_path):
    scenery = "<include><uri>model://town</uri><static>1</static></include>"
    assert read(tmp_path, scenery + box("x3"))[0] == "x3"


def test_without_motors_what_is_missing_could_be_the_drone(tmp_path):
    includes = "<include><uri>model://x3</uri></include><include><uri>model://x4</uri></include>"
    said = fault(tmp_path, box("crate") + includes)
    assert "world.sdf:2: <include> of 'model://x3' is not found" in said
    assert said.endswith("(and so with 1 more models)")


def test_models_side_by_side_without_a_world_are_chosen_from_too(tmp_path):
    path = tmp_path / "models.sdf"
    path.write_text(f'<sdf version="1.5">{box("crate")}{drone("x3")}</sdf>')
    assert read_sdf(path, PackageFinder(path), Remarks()).name == "x3"


def test_a_world_of_thousands_is_refused(tmp_path):
    assert "more than 1000 models" in fault(tmp_path, box("crate") * 1001)


def test_where_a_model_stands_in_the_world_does_not_move_its_links(tmp_path):
    path = tmp_path / "world.sdf"
    path.write_text(
        '<sdf version="1.9"><world name="w"><frame name="far"><pose>9 9 9 0 0 0</pose></frame>'
        '<model name="x3"><pose relative_to="far">1 1 1 1 1 1</pose><link name="l"/></model>'
        "</world></sdf>"
    )
    (link,) = read_sdf(path, PackageFinder(path), Remarks()).links
    assert link.X_ML.IsExactlyIdentity()
