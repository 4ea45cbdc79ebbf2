"""Oracle: what Drake says of the plant itself."""

import pytest
from pydrake.systems.framework import DiagramBuilder

from workbench.common.errors import WorkbenchError
from workbench.plant.description import read_description
from workbench.plant.multibody import add_plant

ARM = """
  <link name="{0}"><inertial><mass value="0.1"/>
    <inertia ixx="0.001" iyy="0.001" izz="0.001" ixy="0" ixz="0" iyz="0"/></inertial></link>
  <joint name="{0}_joint" type="{1}"><parent link="base"/><child link="{0}"/>
    <axis xyz="1 0 0"/><limit lower="-1" upper="1" effort="1" velocity="1"/></joint>
</robot>"""


def built(description, time_step=0.0):
    return add_plant(DiagramBuilder(), description, time_step=time_step)


def fault(path) -> str:
    with pytest.raises(WorkbenchError) as caught:
        built(read_description(path))
    said = str(caught.value)
    assert said.startswith(str(path))
    assert "\n" not in said
    return said


@pytest.mark.parametrize("time_step", [0.0, 1 / 1024])
def test_a_drone_is_one_free_body(dh_drone, time_step):
    plant, scene_graph = built(dh_drone, time_step)
    assert plant.is_finalized()
    assert (plant.num_positions(), plant.num_velocities()) == (7, 6)
    assert plant.time_step() == time_step
    assert plant.GetBodyByName("base_link").is_floating_base_body()
    assert plant.geometry_source_is_registered()
    assert scene_graph.get_name() == "scene_graph"


def test_gravity_points_down(dh_drone):
    plant, _ = built(dh_drone)
    assert plant.gravity_field().gravity_vector().tolist() == [0.0, 0.0, -9.81]


@pytest.mark.parametrize("kind", ["revolute", "continuous", "prismatic"])
def test_a_joint_that_is_no_rotor_moves(quad, write, kind):
    description = read_description(write(quad.replace("</robot>", ARM.format("gripper", kind))))
    assert built(description)[0].num_positions() == 8


def test_a_fixed_joint_may_stay(quad, write):
    description = read_description(write(quad.replace("</robot>", ARM.format("box", "fixed"))))
    assert built(description)[0].num_positions() == 7


@pytest.mark.parametrize(
    ("old", "new", "word"),
    [
        ('<link name="rotor_0"/>', '<link name="rotor_0"/><link name="rotor_0"/>', "rotor_0"),
        ('ixx="0.01"', 'ixx="abc"', "ixx"),
        ("</inertial>", '</inertial><visual><geometry><box size="1"/></geometry></visual>', "size"),
    ],
)
def test_what_drake_refuses_becomes_a_sentence(broken_quad, old, new, word):
    assert word in fault(broken_quad(old, new))


def test_a_drone_nailed_to_the_world_is_refused_with_sense(quad, write):
    nail = '<link name="world"/><joint name="nail" type="fixed"><parent link="world"/>'
    nail += '<child link="base"/></joint></robot>'
    said = fault(write(quad.replace("</robot>", nail)))
    assert "the base link 'world' is fixed to the world" in said


@pytest.mark.parametrize("uri", ["propeller.obj", "package://quad/propeller.obj"])
def test_a_mesh_beside_the_description_is_found(broken_quad, write, uri):
    """As files made for Gazebo have it: relative, or in the package that the file belongs to."""
    write("v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n", "propeller.obj")
    write('<package format="2"><name>quad</name></package>', "package.xml")
    mesh = f'<visual><geometry><mesh filename="{uri}"/></geometry></visual>'
    path = broken_quad("</inertial>", f"</inertial>{mesh}")
    assert built(read_description(path))[0].num_positions() == 7
