"""Elements that only Drake's parsers read act as in Drake, get a remark, or are refused by name."""

import re
from pathlib import Path

import numpy as np
import pytest
from pydrake.multibody.parsing import Parser
from pydrake.multibody.plant import MultibodyPlant
from pydrake.systems.framework import DiagramBuilder

from tests.jointed import drone
from tests.plant.made_up import SDF
from workbench.common.errors import WorkbenchError
from workbench.plant.description import read_description
from workbench.plant.multibody import add_plant

INERTIA = '<inertia ixx="2e-3" iyy="3e-3" izz="4e-3" ixy="0" ixz="0" iyz="0"/>'
ARM = f"""<link name="arm"><inertial><origin xyz="0.1 0 0"/><mass value="0.2"/>{INERTIA}</inertial>
  <!-- more --></link>"""
ELBOW = """<joint name="elbow" type="continuous"><parent link="base"/><child link="arm"/>
  <axis xyz="0 1 0"/></joint>"""
MOTOR = """<transmission name="t"><type>transmission_interface/SimpleTransmission</type>
  <joint name="elbow"/><actuator name="m"><drake:rotor_inertia value="2e-4"/>
  <drake:gear_ratio value="12"/></actuator></transmission>"""
PLANAR = """<drake:joint name="slide" type="planar"><parent link="base"/><child link="arm"/>
  <axis xyz="{}"/><dynamics damping="1 2 3"/></drake:joint>"""
SDF_ARM = """<link name="arm"><inertial><mass>0.2</mass><inertia><ixx>2e-3</ixx><iyy>3e-3</iyy>
  <izz>4e-3</izz></inertia></inertial></link>
  <joint name="elbow" type="revolute"><parent>body</parent><child>arm</child>
  <axis><xyz>0 1 0</xyz></axis>{joint}</joint>{model}"""
BUSHING = "<drake:linear_bushing_rpy/>"


def sdf_drone(folder: Path, joint: str = "", model: str = "") -> Path:
    """Write an SDF with more in its joint `elbow` and its model; return its path."""
    path = folder / "drone.sdf"
    more = SDF_ARM.format(joint=joint, model=model)
    path.write_text(SDF.replace("</model>\n</sdf>", f"{more}</model>\n</sdf>"))
    return path


def drakes_plant(links: str) -> MultibodyPlant:
    """Return Drake's own plant of links on a welded `base`."""
    plant = MultibodyPlant(0.0)
    text = f'<robot name="r" xmlns:drake="d"><link name="base"/>{links}</robot>'
    Parser(plant).AddModelsFromString(text, "urdf")
    plant.WeldFrames(plant.world_frame(), plant.GetFrameByName("base"))
    plant.Finalize()
    return plant


def test_motors_of_transmissions_have_the_reflected_inertia_of_drake(tmp_path, case):
    """Drake reads them in the `<actuator>` of a SimpleTransmission."""
    inertia = '<drake:rotor_inertia value="2e-4"/>'
    outside = MOTOR.replace(inertia, "").replace("</transmission>", f"{inertia}</transmission>")
    for motor, acts in (
        (MOTOR, True),
        (MOTOR.replace("SimpleTransmission", "DifferentialTransmission"), False),
        (outside, False),
    ):
        drakes = drakes_plant(ARM + ELBOW + motor)
        expected = drakes.CalcMassMatrix(drakes.CreateDefaultContext())[0, 0]
        description = read_description(drone(tmp_path, ARM + ELBOW + motor))
        plant, _ = add_plant(DiagramBuilder(), description, time_step=0.0)
        place = plant.GetJointByName("elbow").velocity_start()
        found = plant.CalcMassMatrix(plant.CreateDefaultContext())[place, place]
        noted = "element <drake:rotor_inertia>" in {each.element for each in description.remarks}
        with case(motor):
            assert found == pytest.approx(expected, rel=1e-12)
            assert (expected > 12**2 * 2e-4, noted) == (acts, not acts)


def test_a_motor_adds_to_the_armature_of_its_joint(tmp_path):
    elbow = ELBOW.replace("</joint>", '<dynamics armature="1e-3"/></joint>')
    joints = read_description(drone(tmp_path, ARM + elbow + MOTOR)).model.joints
    (freedom,) = next(each.freedoms for each in joints if each.name == "elbow")
    assert freedom.armature == pytest.approx(1e-3 + 12**2 * 2e-4)


def test_what_plugins_have_of_drake_is_not_refused(tmp_path):
    block = f'<gazebo><plugin name="p" filename="f">{BUSHING}</plugin></gazebo>'
    assert read_description(drone(tmp_path, ARM + ELBOW + block)).model.links


def test_the_motor_of_a_joint_of_sdf_has_its_reflected_inertia(tmp_path):
    motor = "<drake:rotor_inertia>2e-4</drake:rotor_inertia><drake:gear_ratio>12</drake:gear_ratio>"
    (joint,) = [
        each
        for each in read_description(sdf_drone(tmp_path, motor)).model.joints
        if each.name == "elbow"
    ]
    assert joint.freedoms[0].armature == pytest.approx(12**2 * 2e-4)


def test_a_joint_of_sdf_follows_by_the_mimic_of_drake(tmp_path):
    mimic = '<drake:mimic joint="pan" multiplier="-2" offset="0.1"/>'
    found = {
        each.name: each.mimic
        for each in read_description(sdf_drone(tmp_path, mimic)).model.joints
        if each.mimic
    }
    assert [found["elbow"].joint, found["elbow"].multiplier] == ["pan", -2.0]
    assert found["elbow"].offset == 0.1


@pytest.mark.parametrize("axis", ["0 0 1", "0 0 -1", "1 2 3", "-1 0 0.2"])
def test_a_planar_joint_has_the_directions_and_dampings_of_drake(tmp_path, axis):
    links = ARM + PLANAR.format(axis)
    drakes = drakes_plant(links)
    (joint,) = [
        each
        for each in read_description(drone(tmp_path, links)).model.joints
        if each.name == "slide"
    ]
    assert [each.damping for each in joint.freedoms] == [1.0, 2.0, 3.0]
    context = drakes.CreateDefaultContext()
    for place, freedom in enumerate(joint.freedoms):
        drakes.SetVelocities(context, np.eye(3)[place])
        velocity = drakes.GetBodyByName("arm").EvalSpatialVelocityInWorld(context)
        moved = velocity.rotational() if place == 2 else velocity.translational()
        assert freedom.axis_J == pytest.approx(moved, abs=1e-12)


def test_two_dampings_of_a_planar_joint_are_refused(tmp_path):
    links = ARM + PLANAR.format("0 0 1").replace("1 2 3", "1 2")
    with pytest.raises(WorkbenchError, match="of a planar joint: give it one number, or three"):
        read_description(drone(tmp_path, links))


@pytest.mark.parametrize(
    ("element", "said"),
    [
        (BUSHING, "<drake:linear_bushing_rpy> is a force between two bodies"),
        ("<drake:linear_spring_damper/>", "<drake:linear_spring_damper> is a force between"),
        ("<drake:ball_constraint/>", "<drake:ball_constraint> closes a loop of bodies"),
        ("<drake:tendon_constraint/>", "<drake:tendon_constraint> closes a loop of bodies"),
    ],
)
def test_forces_and_constraints_of_drake_are_refused_by_name(tmp_path, element, said):
    for path in (drone(tmp_path, ARM + ELBOW + element), sdf_drone(tmp_path, model=element)):
        with pytest.raises(WorkbenchError, match=re.escape(said)) as caught:
            read_description(path)
        assert str(caught.value).startswith(str(path))


def test_a_joint_that_only_drake_has_in_sdf_is_refused_by_name(tmp_path):
    model = '<drake:joint name="slide" type="planar"/>'
    with pytest.raises(WorkbenchError, match="<drake:joint> 'slide' is Drake's own in SDF"):
        read_description(sdf_drone(tmp_path, model=model))


def test_what_drake_reads_and_does_not_act_is_said(tmp_path):
    contact = '<collision name="c"><drake:proximity_properties/></collision>'
    more = """<drake:collision_filter_group name="g"/><drake:newer/>"""
    urdf = ARM.replace("<!-- more -->", contact) + ELBOW.replace(
        "</joint>", '<limit drake:acceleration="1" acceleration="1" jerk="1" efort="2"/></joint>'
    )
    remarks = read_description(drone(tmp_path, urdf + more)).remarks
    said = {each.element: each.text for each in remarks}
    assert said["element <drake:proximity_properties>"].startswith("friction and stiffness")
    assert said["element <drake:collision_filter_group>"].startswith("links of a drone do not")
    assert said["element <drake:newer>"] == "Drake's; not used"
    for name in ("drake:acceleration", "acceleration", "jerk"):
        texts = [each.text for each in remarks if each.element == f"attribute {name} of <limit>"]
        assert texts == ["no joint has such a limit; not used"]
    assert "in <joint> of joint 'elbow'" in said["attribute efort of <limit>"]
    said = {each.element for each in read_description(sdf_drone(tmp_path, model=more)).remarks}
    assert {"element <drake:newer> of <model>"} < said
    assert {"element <drake:collision_filter_group> of <model>"} < said
