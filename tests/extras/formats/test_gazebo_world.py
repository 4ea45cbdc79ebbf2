"""Oracle: Drake's own SDF parser where it takes the world; else the files' numbers, by hand."""

import math
from dataclasses import replace

import pytest
from pydrake.geometry import Convex
from pydrake.multibody.parsing import Parser
from pydrake.multibody.plant import MultibodyPlant
from pydrake.multibody.tree import BodyIndex

from workbench.plant.home import DEFAULT_HOME, Home
from workbench.plant.worlds.reading import read_world

BALL = "<geometry><sphere><radius>0.5</radius></sphere></geometry>"
LINK = f'<link name="link"><collision name="c">{BALL}</collision></link>'
STATIC = "<static>true</static>"
MOTOR = '<plugin filename="libgazebo_motor_model.so" name="m"/>'
PLANE = (
    '<link name="link"><pose>0 0 {} 0 {} 0</pose>'
    '<collision name="c"><geometry><plane><normal>0 0 1</normal></plane></geometry></collision>'
    '<visual name="v"><geometry><plane><normal>0 0 1</normal><size>9 9</size></plane></geometry>'
    "</visual></link>"
)


def world(content: str, version: str = "1.9") -> str:
    return f'<sdf version="{version}"><world name="town">{content}</world></sdf>'


def model(name: str, inside: str = STATIC + LINK) -> str:
    return f'<model name="{name}">{inside}</model>'


@pytest.fixture
def town(read):
    return lambda content, **more: read(world(content), "town.sdf", **more)


POSES = (
    '<frame name="corner"><pose>1 2 3 0.1 0.2 0.3</pose></frame>'
    '<frame name="square" attached_to="corner"><pose>4 0 0 0 0 1</pose></frame>'
    + model("a", f"{STATIC}<pose>1 2 3 0.4 0.5 0.6</pose>{LINK}")
    + model("b", f'{STATIC}<pose relative_to="square">0 1 0 0.1 0 0</pose>{LINK}')
    + model("c", f'{STATIC}<pose relative_to="a::link">0 0 2 0 0 1</pose>{LINK}')
    + f'<model name="d" placement_frame="tip">{STATIC}<pose relative_to="b">7 0 0 0 1 0</pose>'
    + LINK
    + '<link name="tip"><pose relative_to="link">0 0.3 0 1 0 0</pose></link>'
    + model("inner", f"<pose>0 0 5 0 0 0.7</pose>{LINK}")
    + "</model>"
    + "<include><uri>model://shed/model.sdf</uri><name>e</name>"
    + '<pose relative_to="d">1 1 1 0 0 1</pose></include>'
    + "<include><uri>model://shed/model.sdf</uri><pose>-9 0 0 0 0 0</pose></include>"
)


def test_models_stand_where_drake_puts_them(town, write, tmp_path):
    nested = model("yard", f"<pose>3 0 0 0.2 0 0</pose>{LINK}")
    config = '<model><name>shed</name><sdf version="1.9">model.sdf</sdf></model>'
    write(config, "shed/model.config")
    write(f'<sdf version="1.9">{model("shed", STATIC + LINK + nested)}</sdf>', "shed/model.sdf")
    # a ball on every link, so that each is an obstacle
    text = POSES.replace('<link name="tip">', f'<link name="tip"><visual name="v">{BALL}</visual>')
    found = town(text)
    plant = MultibodyPlant(0.0)
    parser = Parser(plant)
    parser.package_map().Add("shed", str(tmp_path / "shed"))
    parser.AddModels(str(tmp_path / "town.sdf"))
    plant.Finalize()
    context = plant.CreateDefaultContext()
    bodies = [plant.get_body(BodyIndex(index)) for index in range(1, plant.num_bodies())]
    drakes = {body.scoped_name().get_full(): body for body in bodies}
    assert set(found.names) == set(drakes)
    assert len(found.names) == 10
    for obstacle in found.obstacles:
        X_WO = plant.EvalBodyPoseInWorld(context, drakes[obstacle.name])
        assert obstacle.X_WO.IsNearlyEqualTo(X_WO, 1e-10), obstacle.name
    assert found.remarks == ()


def test_lights_plugins_and_physics_are_left_out_without_a_word(town):
    found = town(
        '<physics type="ode"/><light name="sun"/><gui/><scene/><gravity>0 0 -9</gravity>'
        '<plugin filename="x" name="y"/><atmosphere type="adiabatic"/><wind/>' + model("box")
    )
    assert found.remarks == ()
    assert (found.name, found.title, found.names) == ("town", "town", ("box::link",))


def test_a_world_without_models_is_empty(town):
    found = town("")
    assert (found.obstacles, found.moving, found.ground, found.home) == ((), (), True, None)


def test_models_without_a_world_are_taken_too(read):
    text = f'<sdf version="1.9">{model("a")}{model("b")}</sdf>'
    assert read(text, "models.world").names == ("a::link", "b::link")


def test_sun_and_ground_need_not_be_at_hand(town):
    scenery = "".join(
        f"<include><uri>{uri}</uri></include>"
        for uri in (
            "model://sun",
            "model://ground_plane",
            "https://x.org/1.0/o/models/Ground Plane",
        )
    )
    assert town(scenery).remarks == ()


def test_the_ground_plane_is_the_ground_of_every_world(town):
    found = town(model("ground", STATIC + PLANE.format(0, 0)))
    assert (found.obstacles, found.remarks, found.ground) == ((), (), True)


@pytest.mark.parametrize(("height", "pitch"), [(2, 0), (0, 0.5), (0, math.pi)])
def test_other_planes_touch_nothing_and_are_drawn(town, height, pitch):
    found = town(model("wall", STATIC + PLANE.format(height, pitch)))
    (wall,) = found.obstacles
    assert wall.collisions == ()
    assert wall.visuals[0].shape().size()[:2].tolist() == [9.0, 9.0]
    (remark,) = found.remarks
    assert remark.kind == "ignored"
    assert str(remark).endswith(
        f"an endless plane that is not the ground at z = 0 (here {height} m); left out"
    )


def test_what_is_missing_is_a_remark(town):
    found = town(
        "\n<include><uri>model://nohouse</uri></include>"
        "<include><uri>https://x.org/1.0/o/models/Tree</uri><name>oak</name></include>"
        + model("box")
        + model("near", f'{STATIC}<pose relative_to="nohouse">1 0 0 0 0 0</pose>{LINK}')
        + model("nearer", f'{STATIC}<pose relative_to="near::link">1 0 0 0 0 0</pose>{LINK}')
    )
    assert found.names == ("box::link",)
    said = [f"{remark.kind} {remark.element}: {remark.text}" for remark in found.remarks]
    assert said[0] == (
        "missing model 'nohouse': <include> of 'model://nohouse' is not found: give --package "
        "nohouse=DIR; left out"
    )
    assert said[1].startswith("missing model 'oak': <include> of 'https://x.org")
    assert said[2:] == [
        "missing model 'near': its pose is relative to 'nohouse', which is left out; left out",
        "missing model 'nearer': its pose is relative to 'near', which is left out; left out",
    ]


def test_a_package_may_be_given(town, write, tmp_path):
    write(f'<sdf version="1.6">{model("hut")}</sdf>', "far/model.sdf")
    include = "<include><uri>model://house</uri></include>"
    assert town(include, house=tmp_path / "far").names == ("hut::link",)


def test_what_could_move_stands_still_and_is_named(town):
    found = town(model("cart", LINK) + model("wall") + model("cup", LINK))
    assert found.names == ("cart::link", "wall::link", "cup::link")
    (remark,) = found.remarks
    assert (remark.kind, remark.text) == (
        "assumed",
        "'cart', 'cup' could move, but stand still here",
    )


def test_a_drone_is_left_out(town):
    found = town(model("x3", LINK + MOTOR) + model("wall"))
    assert found.names == ("wall::link",)
    assert [(remark.kind, remark.element) for remark in found.remarks] == [
        ("ignored", "model 'x3'")
    ]


def test_a_second_model_of_one_name_gets_a_number(town):
    found = town(model("box") + model("box", f"{STATIC}<pose>5 0 0 0 0 0</pose>{LINK}"))
    assert found.names == ("box::link", "box_1::link")
    assert found.pose("box_1::link", 0.0).translation()[0] == 5.0


def test_what_touches_and_is_not_drawn_is_seen_all_the_same(town):
    (box,) = town(model("box")).obstacles
    assert box.visuals[0].perception_properties()
    assert box.visuals[0].shape().radius() == 0.5


def test_meshes_are_drawn_and_touch_as_hulls(town, write, tmp_path, monkeypatch):
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path / "cache"))
    write("v 0 0 0\nv 1 0 0\nv 0 2 0\nv 0 0 3\nf 1 3 2\nf 1 2 4\nf 1 4 3\nf 2 3 4\n", "rock.obj")
    mesh = "<geometry><mesh><uri>{}</uri><scale>2 2 2</scale></mesh></geometry>"
    link = '<link name="link"><{0} name="{0}">{1}</{0}><visual name="other">{2}</visual></link>'
    rock, missing = mesh.format("rock.obj"), mesh.format("stone.obj")
    found = town(
        model("rock", STATIC + link.format("collision", rock, rock))
        + model("stone", STATIC + link.format("collision", missing, missing))
        + model("pebble", STATIC + link.format("collision", BALL, missing))
    )
    assert found.names == ("rock::link", "pebble::link")
    stone, pebble = found.obstacles
    assert isinstance(stone.collisions[0].shape(), Convex)
    hull = stone.collisions[0].shape().GetConvexHull()
    assert max(hull.vertex(i)[2] for i in range(hull.num_vertices())) == pytest.approx(6.0)
    assert stone.visuals[0].shape().extension() == ".gltf"
    assert pebble.visuals[0].shape().radius() == 0.5  # what it touches by stands for its mesh
    texts = [str(remark) for remark in found.remarks]
    assert sum("the mesh stone.obj is not found; left out" in text for text in texts) == 3
    assert any("1 of them use their convex hulls" in text for text in texts)


def test_home_is_where_gazebo_has_it(town):
    place = (
        "<spherical_coordinates><latitude_deg>45</latitude_deg>"
        "<longitude_deg>-90</longitude_deg><elevation>12</elevation>{}</spherical_coordinates>"
    )
    found = town(place.format(""))
    assert (found.home, found.remarks) == (Home(math.pi / 4, -math.pi / 2, 12.0), ())
    (remark,) = town(place.format("<heading_deg>90</heading_deg>")).remarks
    assert remark.text == "heading_deg is 90; x is taken to point east"


def test_a_magnetic_field_is_the_homes(town):
    field = "<magnetic_field>5.5e-6 2.3e-5 -4.2e-5</magnetic_field>"
    stated = (5.5e-6, 2.3e-5, -4.2e-5)
    found = town(field)
    assert (found.home, found.remarks) == (replace(DEFAULT_HOME, magnetic_field=stated), ())
    place = "<spherical_coordinates><latitude_deg>45</latitude_deg></spherical_coordinates>"
    assert town(place + field).home == Home(math.pi / 4, 0.0, 0.0, stated)
    assert town(place + "<magnetic_field/>").home == Home(math.pi / 4, 0.0, 0.0)
    in_microtesla = town("<magnetic_field>5.5 23 -42</magnetic_field>")
    assert in_microtesla.home is None
    assert "no component can be beyond 0.001 T" in in_microtesla.remarks[0].text


def test_what_is_not_built_is_said(town):
    found = town('<actor name="walker"/><actor name="runner"/><state world_name="town"/>')
    assert [(remark.element, remark.text) for remark in found.remarks] == [
        ("<actor> of the world", "2 of them; left out"),
        ("<state> of the world", "1 of them; left out"),
    ]


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("<sdf", ":1: not XML"),
        ('<robot name="x"/>', ":1: this is URDF (<robot>)"),
        ("<world/>", ":1: the root element is <world>, an SDF file has <sdf>"),
        ('<sdf version="1.9"><world name="a"/><world name="b"/></sdf>', ": has 2 worlds: leave"),
        (world(model("a", STATIC + LINK.replace("0.5", "-1"))), "give it a positive number"),
        (world(model("a", f"<pose>0 0 x 0 0 0</pose>{LINK}")), "give it 6 numbers"),
        (
            world("<spherical_coordinates><latitude_deg>99</latitude_deg></spherical_coordinates>"),
            "the latitude must be within ±90",
        ),
        (world(model("a") * 5001), ": has more than 5000 models"),
        # Drake's geometries end the process at a name of 100,000 characters
        (world(model("a", STATIC + LINK.replace('"c"', f'"{"x" * 100_000}"'))), "name of shape"),
    ],
)
def test_what_is_wrong_is_said_with_file_and_line(fault, text, said):
    assert said in fault(text, "town.world")


def test_comments_and_templates(write, fault):
    assert "makes this a template" in fault(world("{{ models }}"), "town.sdf")
    assert read_world(write(world("<!-- a -- b -->"), "b.sdf")).obstacles == ()
