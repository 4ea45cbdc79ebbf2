"""Oracle: the numbers in the files, by hand."""

import math

import numpy as np
import pytest
from pydrake.geometry import Box, Capsule, Cylinder, Rgba, Sphere

from workbench.common.errors import WorkbenchError
from workbench.plant.home import Home
from workbench.plant.worlds.reading import read_world

POST = "{name: post, shape: {cylinder: [0.2, 3]}"
BALL = "{name: ball, shape: {sphere: 0.4}, path: "
PATH = "[[0, 1, 2, 3], [2, 1, 4, 3]]"


def test_a_file_with_nothing_but_a_title_is_an_empty_world(read, write):
    world = read("title: a field\n", "field.yaml")
    assert (world.name, world.title, world.ground) == ("field", "a field", True)
    assert (world.obstacles, world.moving, world.home, world.remarks) == ((), (), None, ())
    assert world.source == write("title: a field\n", "field.yaml")


def test_an_obstacle_is_touched_drawn_and_seen_where_it_stands(read):
    world = read(
        "obstacles:\n"
        f"  - {POST}, position: [1, 2, 3], roll_pitch_yaw: [0, 1.5707963267948966, 0]}}\n"
    )
    (post,) = world.obstacles
    assert post.name == "post"
    assert post.X_WO.translation().tolist() == [1.0, 2.0, 3.0]
    np.testing.assert_allclose(post.X_WO.rotation().matrix()[:, 2], [1, 0, 0], atol=1e-15)
    (collision,), (visual,) = post.collisions, post.visuals
    for geometry in (collision, visual):
        assert (geometry.shape().radius(), geometry.shape().length()) == (0.2, 3.0)
        assert geometry.pose().IsExactlyIdentity()
    assert collision.proximity_properties().HasProperty("material", "coulomb_friction")
    assert visual.illustration_properties() and visual.perception_properties()


@pytest.mark.parametrize(
    ("words", "expected"),
    [
        ("box: [1, 2, 3]", Box(1, 2, 3)),
        ("sphere: 2", Sphere(2)),
        ("cylinder: [1, 2]", Cylinder(1, 2)),
        ("capsule: [1, 2]", Capsule(1, 2)),
    ],
)
def test_shapes_are_those_that_are_written(read, words, expected):
    (obstacle,) = read(f"obstacles: [{{name: a, shape: {{{words}}}}}]").obstacles
    assert repr(obstacle.collisions[0].shape()) == repr(expected)


@pytest.mark.parametrize(
    ("color", "expected"),
    [("[1, 0, 0.5]", Rgba(1, 0, 0.5, 1)), ("[0.1, 0.2, 0.3, 0.4]", Rgba(0.1, 0.2, 0.3, 0.4))],
)
def test_colours_are_those_that_are_written(read, color, expected):
    (obstacle,) = read(f"obstacles: [{POST}, color: {color}}}]").obstacles
    properties = obstacle.visuals[0].perception_properties()
    assert properties.GetProperty("phong", "diffuse") == expected


def test_a_moving_obstacle_has_all_roles_and_its_path(read):
    (ball,) = read(f"moving: [{BALL}{PATH}}}]").moving
    assert (ball.course.times, ball.course.repeat) == ((0.0, 2.0), False)
    assert ball.pose(1.0).translation().tolist() == [1.0, 3.0, 3.0]
    geometry = ball.geometry
    assert geometry.proximity_properties() and geometry.illustration_properties()
    assert geometry.perception_properties()
    (turning,) = read(
        f"moving: [{BALL}[[0, 0, 0, 0, 0], [1, 0, 0, 0, 6.283185307179586]], repeat: true}}]"
    ).moving
    assert turning.pose(1.5).rotation().matrix()[0, 0] == pytest.approx(-1.0)


def test_home_is_in_degrees_as_gazebo_has_it(read):
    home = read("home: {latitude_deg: 45, longitude_deg: -90, elevation: 12}").home
    assert home == Home(math.pi / 4, -math.pi / 2, 12.0)


def test_a_home_may_state_its_magnetic_field(read):
    home = read("home: {latitude_deg: 45, magnetic_field: [1.0e-6, 2.0e-5, -4.0e-5]}").home
    assert home == Home(math.pi / 4, 0.0, 0.0, (1e-6, 2e-5, -4e-5))


def test_ground_can_be_left_out(read):
    assert not read("ground: false").ground


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("titel: x", ":1: unknown key 'titel': did you mean 'title'? known are"),
        ("vehicle: {model: dh_drone}", ":1: unknown key 'vehicle'"),
        ("- a\n- b", ":1: expected 'key: value' lines, found list"),
        ("title: [", "not YAML"),
        ("\nground: 1", ":2: ground is 1, and should be true or false"),
        ("obstacles: {}", ":1: obstacles is {}, and should be a list"),
        (f"obstacles:\n- {POST}}}\n- {{shape: {{sphere: 1}}}}", ":3: obstacles.1 has no name"),
        (f"obstacles: [{POST}}}, {POST}}}]", ": two obstacles have the name 'post': rename one"),
        ("obstacles: [{name: ground, shape: {sphere: 1}}]", "not an obstacle's: rename it"),
        ("obstacles: [{name: a}]", ":1: obstacles.0.shape is missing: give one of box, sphere"),
        (
            "obstacles:\n- name: a\n  shape: {sphere: 1, box: [1, 1, 1]}",
            ":3: obstacles.0.shape has box and sphere: give one of",
        ),
        ("obstacles: [{name: a, shape: {ball: 1}}]", "unknown key 'ball'"),
        (
            "obstacles:\n- name: a\n  shape:\n    sphere: -1",
            ":4: obstacles.0.shape.sphere is [-1]: give it sizes above 0",
        ),
        ("obstacles: [{name: a, shape: {box: [1, 0, 1]}}]", "give it sizes above 0"),
        ("obstacles: [{name: a, shape: {box: [1, 1]}}]", "give it 3 numbers within"),
        ("obstacles: [{name: a, shape: {sphere: .nan}}]", "give it 1 number within ±1e+06"),
        ("obstacles: [{name: a, shape: {sphere: .inf}}]", "give it 1 number within ±1e+06"),
        (f"obstacles: [{POST}, position: [0, 0, .nan]}}]", "position is [0, 0, nan]: give it 3"),
        (f"obstacles: [{POST}, color: [1, 2, 3]}}]", "three or four numbers 0 .. 1"),
        (f"moving: [{BALL}[[0, 0, 0, 0]]}}]", "has fewer than two rows"),
        (f"moving: [{BALL}[[1, 0, 0, 0], [2, 0, 0, 0]]}}]", "path.0 does not begin at time 0"),
        (f"moving: [{BALL}[[0, 0, 0, 0], [0, 1, 0, 0]]}}]", "path.1 is at 0 s, not 0.01 s or more"),
        (f"moving: [{BALL}[[0, 0, 0], [1, 1, 0]]}}]", "give it 4 or 5 numbers"),
        (f"moving: [{BALL}[[0, 0, 0, .nan], [1, 1, 0, 0]]}}]", "give it 4 or 5 numbers within"),
        (f"moving: [{BALL}{PATH}, repeat: true}}]", "repeats, but does not end where it begins"),
        (f"moving: [{BALL}{PATH}, repeat: 3}}]", "repeat is 3, and should be true or false"),
        (
            f"obstacles: [{POST}}}]\nmoving: [{BALL}{PATH}}}, {BALL}{PATH}}}]",
            "have the name 'ball'",
        ),
        ("home: {latitude_deg: 91}", ":1: home.latitude_deg is 91: give it one within ±90"),
        ("home: {latitude_deg: .nan}", "give it one within ±90"),
        ("home: {magnetic_field: [1, 2]}", "home.magnetic_field is [1, 2]: give it 3 numbers"),
        (
            "home:\n  magnetic_field: [5, 22, -42]",
            ":2: home.magnetic_field is [5, 22, -42]: give it in",
        ),
    ],
)
def test_what_is_wrong_is_said_with_file_and_line(fault, text, said):
    assert said in fault(text)


@pytest.mark.parametrize("name", ["world.txt", "drone.urdf"])
def test_other_files_are_no_worlds(fault, name):
    assert fault("x", name).startswith(": a world is a .yaml file")


@pytest.mark.parametrize("name", ["town.sdf", "town.world"])
def test_a_world_that_no_installed_package_reads_is_named(fault, monkeypatch, name):
    monkeypatch.setattr("workbench.plant.worlds.reading.world_formats", lambda: ())
    package = "the package workbench.extras.formats reads"
    assert fault("<sdf/>", name).startswith(f": it looks like a world of Gazebo, which {package}")


def test_a_folder_and_a_missing_file_are_no_worlds(tmp_path):
    with pytest.raises(WorkbenchError, match="is a folder: give the world's file"):
        read_world(tmp_path)
    with pytest.raises(WorkbenchError, match="none.yaml: no such file"):
        read_world(tmp_path / "none.yaml")


def test_a_thousand_shapes_are_enough(fault):
    rows = "".join(f"- {{name: a{i}, shape: {{sphere: 1}}}}\n" for i in range(1001))
    assert "has 1001 shapes, more than 1000" in fault(f"obstacles:\n{rows}")
