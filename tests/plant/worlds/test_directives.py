"""Oracle: poses by hand, and that a plant of Drake's own would move where a weld is missing."""

import logging

import numpy as np
import pytest
from pydrake.geometry import MakeRenderEngineVtk, RenderEngineVtkParams, Role, SceneGraph

BOX_SDF = """<sdf version="1.9"><model name="box"><link name="base_link">{}</link></model></sdf>"""
TOUCHED = '<collision name="c"><geometry><box><size>1 2 3</size></box></geometry></collision>'
ADD = "- add_model: {name: crate, file: box.sdf}\n"
WELD = "- add_weld: {parent: world, child: crate::base_link}\n"


def test_a_welded_model_stands_where_it_was_put(read, box):
    world = read(
        f"directives:\n{ADD}"
        "- add_weld:\n    parent: world\n    child: crate::base_link\n"
        "    X_PC: {translation: [1, 2, 3], rotation: !Rpy {deg: [0, 0, 90]}}\n"
    )
    (crate,) = world.obstacles
    assert crate.name == "crate::base_link"
    assert crate.X_WO.translation().tolist() == [1.0, 2.0, 3.0]
    turn = [[0, -1, 0], [1, 0, 0], [0, 0, 1]]
    np.testing.assert_allclose(crate.X_WO.rotation().matrix(), turn, atol=1e-15)
    (collision,), (visual,) = crate.collisions, crate.visuals
    assert (collision.name(), visual.name()) == ("crate::base_link::c", "crate::base_link::v")
    assert collision.proximity_properties() and visual.perception_properties()
    assert visual.shape().size().tolist() == [1.0, 2.0, 3.0]


@pytest.mark.parametrize("how", ["sdf", "urdf"])
def test_what_touches_and_is_not_drawn_is_seen_by_its_collision_shape(read, write, how):
    if how == "sdf":
        write(BOX_SDF.format(TOUCHED), "box.sdf")
    else:
        inside = TOUCHED.replace("<size>1 2 3</size></box>", "</box>")
        inside = inside.replace("<box>", '<box size="1 2 3">')
        write(f'<robot name="box"><link name="base_link">{inside}</link></robot>', "box.urdf")
    (crate,) = read(f"directives:\n{ADD}{WELD}".replace("box.sdf", f"box.{how}")).obstacles
    (visual,) = crate.visuals
    assert visual.shape().size().tolist() == [1.0, 2.0, 3.0]
    assert visual.perception_properties() and visual.illustration_properties()


@pytest.mark.parametrize("how", ["sdf", "urdf"])
def test_what_is_drawn_is_seen(read, write, how):
    visual = '<visual name="v"><geometry>{}</geometry></visual>'
    if how == "sdf":
        text = BOX_SDF.format(visual.format("<sphere><radius>2</radius></sphere>"))
    else:
        visual = visual.format('<sphere radius="2"/>')
        text = f'<robot name="box"><link name="base_link">{visual}</link></robot>'
    write(text, f"box.{how}")
    (crate,) = read(f"directives:\n{ADD}{WELD}".replace("box.sdf", f"box.{how}")).obstacles
    assert crate.collisions == ()
    assert crate.visuals[0].perception_properties()


@pytest.mark.parametrize("where", ["sub/box.sdf", "a folder/box.sdf", "../box.sdf"])
def test_files_are_found_relative_to_the_world(read, write, where):
    name = f"worlds/{where}" if not where.startswith("..") else "box.sdf"
    write(BOX_SDF.format(TOUCHED), name)
    text = f"directives:\n{ADD}{WELD}".replace("box.sdf", where)
    assert len(read(text, "worlds/world.yaml").obstacles) == 1


def test_packages_are_those_given_and_those_around(read, write, tmp_path):
    write(BOX_SDF.format(TOUCHED), "elsewhere/box.sdf")
    text = f"directives:\n{ADD}{WELD}".replace("box.sdf", "package://shed/box.sdf")
    assert len(read(text, shed=tmp_path / "elsewhere").obstacles) == 1
    write(BOX_SDF.format(TOUCHED), "shed/box.sdf")
    assert len(read(text).obstacles) == 1


def test_directives_may_add_others_from_a_file(read, write, box, tmp_path):
    more = f"directives:\n{ADD}{WELD}".replace("box.sdf", "package://shed/box.sdf")
    write(more, "more.yaml")
    text = "directives:\n- add_directives: {file: more.yaml}\n"
    (crate,) = read(text, shed=tmp_path).obstacles
    assert crate.name == "crate::base_link"


def test_two_links_of_one_name_have_names_of_their_own(read, box):
    other = (ADD + WELD).replace("crate", "chest")
    world = read(f"directives:\n{ADD}{WELD}{other}")
    assert world.names == ("crate::base_link", "chest::base_link")


def test_a_model_that_could_move_is_refused_with_the_weld_that_it_lacks(fault, box):
    said = fault(f"title: x\ndirectives:\n{ADD}")
    assert said == (
        ":3: the body 'crate::base_link' is not fixed to the world: add_weld it (add_weld: "
        "{parent: world, child: crate::base_link}), or list it under `moving`"
    )


def test_a_door_could_move_too(fault, write):
    door = (
        '<sdf version="1.9"><model name="box"><link name="base_link"/><link name="door"/>'
        '<joint name="j" type="revolute"><parent>base_link</parent><child>door</child>'
        "<axis><xyz>0 0 1</xyz></axis></joint></model></sdf>"
    )
    write(door, "box.sdf")
    assert "the body 'crate::door' is not fixed" in fault(f"directives:\n{ADD}{WELD}")


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("- add_modl: {name: a}", ":2: unknown directive 'add_modl': did you mean 'add_model'"),
        ("- {}", ":2: a directive has one key, as add_model: this has 0"),
        ("- {add_model: {}, add_weld: {}}", "this has 2"),
        ("- add_model", "directives.0 is 'add_model', and should be 'key: value' lines"),
        ("- add_model: {name: a, file: none.sdf}", "the file 'none.sdf' is not found: give it"),
        (
            "- add_model: {name: a, file: 'package://shed/none.sdf'}",
            "is not found: give --package shed=DIR",
        ),
        ("- add_model: {name: a}", ":2: Drake refuses it:"),
        (f"{ADD}{WELD}- add_weld: {{parent: world, child: chest::l}}", ":4: Drake refuses it:"),
        (f"{ADD}{WELD}{ADD}", ":4: Drake refuses it:"),
        (f"{ADD}{WELD}{WELD}", ":4: Drake refuses it:"),
    ],
)
def test_what_is_wrong_is_said_with_file_and_line(fault, box, text, said):
    assert said in fault(f"directives:\n{text}\n")


def test_an_endless_plane_is_refused(fault, write):
    plane = '<collision name="c"><geometry><plane/></geometry></collision>'
    write(BOX_SDF.format(plane), "box.sdf")
    assert (
        ":2: the body 'crate::base_link' has an endless plane as collision shape: use a box"
        in fault(f"directives:\n{ADD}{WELD}")
    )


def test_a_mesh_that_is_too_large_for_drake_is_refused_unread(fault, write, tmp_path):
    shape = "<collision name='c'><geometry><mesh><uri>m.obj</uri></mesh></geometry></collision>"
    path = write(BOX_SDF.format(shape), "box.sdf")
    with (tmp_path / "m.obj").open("wb") as file:
        file.truncate(15_000_001)
    assert f"{path}:1: 'm.obj' is larger than 15 MB" in fault(f"directives:\n{ADD}{WELD}")


def test_a_file_that_is_no_model_is_refused(fault, write):
    path = write("<sdf", "box.sdf")
    assert f":2: {path}:1: not XML" in fault(f"directives:\n{ADD}{WELD}")
    path = write("<robot", "box.urdf")
    text = f"directives:\n{ADD}{WELD}".replace("box.sdf", "box.urdf")
    assert f":2: {path}:1: not XML" in fault(text)
    write("<robot><link/></robot>", "box.urdf")
    assert ":2: Drake refuses it:" in fault(text)


def test_drake_says_no_more_than_a_sentence(fault, write):
    pose = f"<pose relative_to='{'x' * 1000}'/>"
    write(BOX_SDF.format(TOUCHED.replace("<geometry>", f"{pose}<geometry>")), "box.sdf")
    said = fault(f"directives:\n{ADD}{WELD}")
    assert ":2: Drake refuses it:" in said
    assert "xxx" in said
    assert len(said) < 400


def test_drake_logs_nothing_while_it_reads(fault, write, caplog):
    write(BOX_SDF.format("<pose>nan 0 0 0 0 0</pose>"), "box.sdf")
    assert ":2: Drake refuses it:" in fault(f"directives:\n{ADD}{WELD}")
    assert not caplog.records
    logging.getLogger("drake").warning("heard")
    assert [record.message for record in caplog.records] == ["heard"]


def test_no_more_than_a_thousand_directives(fault, box):
    assert fault("directives:\n" + ADD * 1001) == ":1: there are more than 1000: leave some out"


@pytest.mark.parametrize(
    ("place", "said"),
    [
        ("translation: [.nan, 0, 0]", "'crate::base_link' has no finite position"),
        ("translation: [0, .inf, 0]", "'crate::base_link' has no finite position"),
        (
            "translation: [0, 0, -1.1e6]",
            "'crate::base_link' has no finite position, or is more than 1e+06 m away",
        ),
    ],
)
def test_an_obstacle_stands_somewhere(fault, box, place, said):
    weld = WELD.replace("}", f", X_PC: {{{place}}}}}")
    assert f":2: {said}" in fault(f"directives:\n{ADD}{weld}")


@pytest.mark.parametrize(
    ("shape", "said"),
    [
        ("<box><size>1 2e6 3</size></box>", "has a box with 1, 2e+06, 3: give it"),
        ("<sphere><radius>2e6</radius></sphere>", "has a sphere with 2e+06"),
        ("<capsule><radius>1</radius><length>2e6</length></capsule>", "capsule with 1, 2e+06"),
        ("<cylinder><radius>2e6</radius><length>1</length></cylinder>", "cylinder with 2e+06, 1"),
        ("<ellipsoid><radii>1 2 2e6</radii></ellipsoid>", "an ellipsoid with 1, 2, 2e+06"),
    ],
)
def test_an_obstacle_has_a_size(fault, write, shape, said):
    text = TOUCHED.replace("<box><size>1 2 3</size></box>", shape)
    write(BOX_SDF.format(text), "box.sdf")
    assert said.removeprefix("an ") in fault(f"directives:\n{ADD}{WELD}")


def test_nothing_is_fetched_from_the_internet(fault, write):
    """Drake knows packages of its own that it would fetch when they are named."""
    write("directives:\n- add_model: {name: a, file: 'package://drake_models/a.sdf'}", "more.yaml")
    said = fault("directives:\n- add_directives: {file: more.yaml}")
    assert "refers to unknown package 'drake_models'" in said


BARE = "v 3 -1 0\nv 3 1 0\nv 4 0 0\nv 3.5 0 3\nf 1 3 2\nf 1 2 4\nf 1 4 3\nf 2 3 4\n"


@pytest.mark.parametrize("part", ["visual", "collision"])
def test_a_camera_draws_an_obj_without_normals(read, write, part):
    """Drake's renderer refuses such a file; without a visual, the collision shape is drawn."""
    write(BARE, "rock.obj")
    write(
        f"""<sdf version="1.9"><model name="rock"><static>true</static><link name="l">
        <{part} name="v"><geometry><mesh><uri>rock.obj</uri><scale>1 2 1</scale></mesh></geometry>
        </{part}></link></model></sdf>""",
        "rock.sdf",
    )
    (rock,) = read("directives:\n- add_model: {name: rock, file: rock.sdf}\n").obstacles
    (drawn,) = rock.visuals
    assert drawn.shape().scale3().tolist() == [1.0, 2.0, 1.0]
    scene_graph = SceneGraph()
    scene_graph.AddRenderer("cameras", MakeRenderEngineVtk(RenderEngineVtkParams()))
    source = scene_graph.RegisterSource("world")
    geometry = scene_graph.RegisterAnchoredGeometry(source, drawn)
    assert scene_graph.model_inspector().GetProperties(geometry, Role.kPerception)
