"""Joints of MJCF against MuJoCo itself: mass matrix and weight's forces at random positions."""

import math

import numpy as np
import pytest
from pydrake.systems.framework import DiagramBuilder

from workbench.common.errors import WorkbenchError
from workbench.plant.description import read_description
from workbench.plant.formats.urdf_writer import stored_files
from workbench.plant.gathered import merged_model
from workbench.plant.multibody import add_plant
from workbench.systems.joint_forces import joint_rows, servo_effort

mujoco = pytest.importorskip("mujoco")

MODEL = """<mujoco><compiler angle="degree"/><option gravity="0 0 -9.81"/>
  <worldbody><body name="hull"><freejoint/>
    <geom type="box" size=".1 .1 .03" mass="1"/>{sites}
    <body name="arm" pos=".1 0 -.05" euler="10 20 30">
      <joint name="first" axis="0 1 0" pos="0 .01 0" damping=".1" range="-50 70" ref="15"/>
      <joint name="second" axis="1 0 .2" pos="0 0 .02" armature=".003" frictionloss=".2"/>
      <geom type="capsule" size=".02" fromto="0 0 0 .2 0 0" mass=".2"/>
      <body name="rod" pos=".2 0 0">
        <joint name="slider" type="slide" axis="0 0 1" stiffness="5" springref=".1" range="-1 1"/>
        <geom type="sphere" size=".03" pos="0 .05 0" mass=".1"/>
        <body name="finger"><joint name="finger" axis="0 1 0"/>
          <geom type="sphere" size=".02" pos=".04 0 0" mass=".05"/></body>
      </body></body></body></worldbody>
  <equality>{equality}</equality>
  <actuator>{motors}<position joint="finger" kp="3" kv=".1" gear="2" armature=".002"
    damping=".01"/></actuator></mujoco>"""
FOLLOWS = '<joint joint1="finger" joint2="first" polycoef=".1 -.5 0 0 0"/>'
NAMES = ("first", "second", "slider", "finger")


def write(tmp_path, equality: str = FOLLOWS):
    """Write the model, and return its path."""
    places = [(0.1, 0.1), (0.1, -0.1), (-0.1, 0.1), (-0.1, -0.1)]
    sites = "".join(f'<site name="s{i}" pos="{x} {y} 0"/>' for i, (x, y) in enumerate(places))
    motors = "".join(
        f'<motor site="s{i}" ctrlrange="0 8" gear="0 0 1 0 0 {0.02 if x * y > 0 else -0.02}"/>'
        for i, (x, y) in enumerate(places)
    )
    path = tmp_path / "armed.xml"
    path.write_text(MODEL.format(sites=sites, motors=motors, equality=equality))
    return path


def test_joints_have_the_mass_matrix_and_the_weight_of_mujoco(tmp_path):
    path = write(tmp_path)
    model = mujoco.MjModel.from_xml_path(str(path))
    data = mujoco.MjData(model)
    plant, _ = add_plant(DiagramBuilder(), read_description(path), time_step=0.0)
    context = plant.CreateDefaultContext()
    joints = [plant.GetJointByName(name) for name in NAMES]
    assert plant.num_velocities() == model.nv == 10
    generator = np.random.default_rng(1)
    for _ in range(5):
        q = generator.uniform(-0.5, 0.5, 4)
        data.qpos[7:] = q + model.qpos0[7:]
        mujoco.mj_forward(model, data)
        full = np.zeros((model.nv, model.nv))
        mujoco.mj_fullM(model, data, full)
        positions = np.zeros(plant.num_positions())
        positions[0] = 1.0
        for joint, value in zip(joints, q, strict=True):
            positions[joint.position_start()] = value
        plant.SetPositions(context, positions)
        places = [joint.velocity_start() for joint in joints]
        assert (
            np.abs(plant.CalcMassMatrix(context)[np.ix_(places, places)] - full[6:, 6:]).max()
            < 1e-9
        )
        weight = plant.CalcGravityGeneralizedForces(context)[places]
        assert np.abs(weight + data.qfrc_bias[6:]).max() < 1e-9


def test_joints_have_their_numbers(tmp_path):
    found = read_description(write(tmp_path)).model.joints
    first, second = found[0].freedoms
    (slider,), (finger,) = found[1].freedoms, found[2].freedoms
    assert (first.lower, first.upper) == pytest.approx((math.radians(-65), math.radians(55)))
    assert (first.damping, second.armature, second.friction) == (0.1, 0.003, 0.2)
    assert (slider.kind, slider.stiffness, slider.rest) == ("prismatic", 5.0, 0.1)
    assert finger.damping == pytest.approx(2.0**2 * 0.01)  # of its actuator
    servo = finger.servo
    assert (servo.kind, servo.stiffness, servo.damping) == pytest.approx(("position", 12.0, 0.4))
    assert found[2].mimic.joint == "first"
    assert (found[2].mimic.multiplier, found[2].mimic.offset) == (-0.5, 0.1)


def test_powers_of_damping_and_stiffness_are_said(tmp_path):
    """MuJoCo 4.0 has polynomials; the first number alone acts, as before."""
    path = write(tmp_path)
    text = path.read_text().replace('stiffness="5"', 'stiffness="5 2 0" damping=""')
    path.write_text(text.replace('damping=".1" range', 'damping=".1 .2 .3" range'))
    found = read_description(path)
    first, (slider,) = found.model.joints[0].freedoms[0], found.model.joints[1].freedoms
    assert (first.damping, slider.stiffness, slider.damping) == (0.1, 5.0, 0.0)
    said = {each.element: each.text for each in found.remarks}
    assert said["damping of joint 'first'"] == "'.1 .2 .3': the first number acts alone"
    assert said["stiffness of joint 'slider'"] == "'5 2 0': the first number acts alone"
    assert "damping of joint 'slider'" not in said


def test_a_joint_may_follow_any_of_several_joints_of_a_body(tmp_path):
    path = write(tmp_path, FOLLOWS.replace('joint2="first"', 'joint2="second"'))
    description = read_description(path)
    plant, _ = add_plant(DiagramBuilder(), description, time_step=0.0)
    rows = joint_rows(plant, merged_model(description.model, description.base_link))
    names = [row.name for row in rows]
    assert names[rows[names.index("finger")].leader] == "second"
    wrong = FOLLOWS.replace('joint1="finger"', 'joint1="second"')
    with pytest.raises(WorkbenchError, match="'second' is one of several joints of a body"):
        read_description(write(tmp_path, wrong))


def test_a_weld_between_bodies_that_move_is_refused_by_name(tmp_path):
    path = write(tmp_path, '<weld name="grip" body1="rod" body2="hull"/>')
    with pytest.raises(WorkbenchError, match="<weld grip> between hull, rod closes a loop"):
        read_description(path)


ACTUATORS = """
  <default><position kp="2" kv="0.3"/><default class="soft"><position kp="0.5"/></default></default>
  <actuator>{motors}
    <position class="soft" joint="first" gear="-2" forcerange="-0.2 0.2"/>
    <velocity joint="second" gear="0.3" kv="2" ctrlrange="-1 1"/>
    <general joint="slider" biastype="affine" gainprm="4" biasprm="0.5 -3 -0.2" gear="1.5"/>
    <motor joint="finger" gear="2" ctrlrange="-1 1" forcerange="-0.5 0.5"/></actuator></mujoco>"""


def test_actuators_of_joints_have_the_forces_of_mujoco(tmp_path):
    """At random states and controls; a setpoint is what the control asks of the joint."""
    path = write(tmp_path)
    text = path.read_text().replace("<mujoco", "<mujoco", 1)
    motors = text[text.index("<actuator>") + 10 : text.index('<position joint="finger"')]
    path.write_text(text[: text.index("<actuator>")] + ACTUATORS.format(motors=motors))
    model = mujoco.MjModel.from_xml_path(str(path))
    data = mujoco.MjData(model)
    found = {
        name: freedom.servo
        for each in read_description(path).model.joints
        for name, freedom in zip(each.freedom_names, each.freedoms, strict=True)
    }
    asked = {  # setpoints over and beside controls, by hand
        "first": (-1.0 / 2.0, 0.0),
        "second": (1.0 / 0.3, 0.0),
        "slider": (4.0 / (3.0 * 1.5), 0.5 / (3.0 * 1.5)),
        "finger": (2.0, 0.0),  # N m
    }
    generator = np.random.default_rng(2)
    for _ in range(20):
        q, v, u = (generator.uniform(-1.0, 1.0, 4) for _ in range(3))
        data.qpos[7:], data.qvel[6:], data.ctrl[4:] = q, v, u
        mujoco.mj_forward(model, data)
        for number, name in enumerate(NAMES):
            scale, offset = asked[name]
            reference = model.qpos0[7 + number]
            wanted = scale * u[number] + offset - (reference if name != "second" else 0.0)
            setpoint = found[name].within(wanted)
            effort = servo_effort(found[name], setpoint, q[number] - reference, v[number])
            assert effort == pytest.approx(data.qfrc_actuator[6 + number], abs=1e-12), name


def test_an_actuator_of_a_tendon_drives_the_joint_that_others_follow(tmp_path):
    """As in grippers: with fingers where the equality has them, MuJoCo's work on both is ours."""
    path = write(tmp_path, '<joint joint1="finger" joint2="second" polycoef="0 -.5"/>')
    tendon = (
        '<tendon><fixed name="split"><joint joint="second" coef=".4"/>'
        '<joint joint="finger" coef=".6"/></fixed></tendon><actuator>'
    )
    grip = '<general tendon="split" gear="2" biastype="affine" gainprm="4" biasprm=".5 -3 -.2"'
    text = path.read_text().replace("<actuator>", tendon, 1)
    path.write_text(text.replace('<position joint="finger" kp="3" kv=".1" gear="2"', grip, 1))
    model = mujoco.MjModel.from_xml_path(str(path))
    data = mujoco.MjData(model)
    servo = read_description(path).model.joint("first").freedoms[1].servo
    generator = np.random.default_rng(3)
    for q, v, u in generator.uniform(-1.0, 1.0, (5, 3)):
        data.qpos[8], data.qpos[10] = q, -0.5 * q
        data.qvel[7], data.qvel[9] = v, -0.5 * v
        data.ctrl[4] = u
        mujoco.mj_forward(model, data)
        work = data.qfrc_actuator[7] - 0.5 * data.qfrc_actuator[9]
        setpoint = (4.0 * u + 0.5) / (3.0 * 2.0 * (0.4 - 0.5 * 0.6))
        assert servo_effort(servo, setpoint, q, v) == pytest.approx(work, abs=1e-12)


def test_a_reference_moves_rest_and_setpoints_as_mujoco_has_it(tmp_path):
    """With ref, a joint of the file has another position than ours, which is 0 at its start."""
    path = write(tmp_path)
    text = path.read_text().replace('ref="15"', 'ref="15" springref="40" stiffness="2"')
    servo = '<position joint="first" kp="3" ctrlrange="-0.5 1"/>'
    path.write_text(text.replace("</actuator>", f"{servo}</actuator>"))
    model = mujoco.MjModel.from_xml_path(str(path))
    data = mujoco.MjData(model)
    freedom = read_description(path).model.joints[0].freedoms[0]
    assert (freedom.lower, freedom.upper) == pytest.approx((math.radians(-65), math.radians(55)))
    for q, u in ((-0.3, 0.2), (0.4, -2.0), (0.1, 3.0)):
        data.qpos[7], data.ctrl[-1] = q + math.radians(15), u
        mujoco.mj_forward(model, data)
        spring = freedom.stiffness * (freedom.rest - q)
        assert spring == pytest.approx(data.qfrc_spring[6], abs=1e-12)
        setpoint = freedom.servo.within(u - math.radians(15))
        effort = servo_effort(freedom.servo, setpoint, q, 0.0)
        assert effort == pytest.approx(data.qfrc_actuator[6], abs=1e-12)


RIG = """<mujoco><compiler angle="degree"/><worldbody>
  <frame pos="1 2 3" euler="0 0 90"><frame pos="0 0 1" euler="0 15 0">
    <body name="hull" pos=".1 0 0" euler="0 0 30"><freejoint/>
      <geom type="box" size=".1 .1 .03" mass="1"/>{sites}{parts}
      <site name="hook" pos="0 0 -.03"/></body></frame>
    <body name="load" pos=".1 0 -1"><freejoint/>
      <geom type="box" size=".05 .02 .01" mass=".2"/><site name="eye" pos="0 0 .05"/></body>
  </frame></worldbody>
  <tendon><spatial name="rope" range="0 1"><site site="hook"/><site site="eye"/></spatial></tendon>
  {more}<actuator>{motors}{actuators}</actuator></mujoco>"""


def rig(tmp_path, parts: str = "", more: str = "", actuators: str = ""):
    """Write a drone in frames of the world, with a load on a tendon, and return its path."""
    text = write(tmp_path).read_text()
    sites = text[text.index("<site") : text.index('<body name="arm"')]
    motors = text[text.index("<motor") : text.index('<position joint="finger"')]
    path = tmp_path / "rig.xml"
    path.write_text(
        RIG.format(sites=sites, parts=parts, more=more, motors=motors, actuators=actuators)
    )
    return path


def test_bodies_in_frames_of_the_world_have_the_poses_of_mujoco(tmp_path):
    path = rig(tmp_path)
    model = mujoco.MjModel.from_xml_path(str(path))
    data = mujoco.MjData(model)
    mujoco.mj_forward(model, data)
    hull, load = (data.body(name) for name in ("hull", "load"))
    R = hull.xmat.reshape(3, 3)
    found = read_description(path).model.link("load").X_ML
    assert found.translation() == pytest.approx(R.T @ (load.xpos - hull.xpos), abs=1e-12)
    wanted = R.T @ load.xmat.reshape(3, 3)
    assert np.abs(found.rotation().matrix() - wanted).max() < 1e-12


@pytest.mark.parametrize("turned", [False, True])
def test_a_load_hangs_on_the_lower_end_of_its_cable(tmp_path, turned):
    """Whichever site the tendon names first."""
    path = rig(tmp_path)
    if turned:
        ends = ('<site site="hook"/>', '<site site="eye"/>')
        path.write_text(path.read_text().replace("".join(ends), "".join(reversed(ends))))
    (cable,) = read_description(path).model.cables
    assert (cable.parent, cable.child) == ("hull", "load")
    assert (cable.p_parent, cable.p_child) == ((0.0, 0.0, -0.03), (0.0, 0.0, 0.05))


def test_a_cable_has_the_length_of_its_class(tmp_path):
    path = rig(tmp_path)
    classes = '<default><default class="rope"><tendon range="0 .7"/></default></default>'
    text = path.read_text().replace("<worldbody>", f"{classes}<worldbody>", 1)
    path.write_text(text.replace('name="rope" range="0 1"', 'name="rope" class="rope"'))
    found = mujoco.MjModel.from_xml_path(str(path))
    (cable,) = read_description(path).model.cables
    assert cable.length == found.tendon_range[0][1] == 0.7


def test_a_force_range_of_0_to_0_is_none_as_in_mujoco(tmp_path):
    leg = (
        '<body name="leg" pos=".1 0 0"><joint name="hip" axis="0 1 0" actuatorfrcrange="0 0"/>'
        '<geom type="capsule" size=".01" fromto="0 0 0 .1 0 0" mass=".05"/></body>'
    )
    path = rig(tmp_path, leg)
    model = mujoco.MjModel.from_xml_path(str(path))
    assert not model.jnt_actfrclimited[model.joint("hip").id]
    (freedom,) = read_description(path).model.joint("hip").freedoms
    assert freedom.effort == math.inf


def test_copies_of_joints_have_the_servos_and_leaders_of_mujoco(tmp_path):
    path = rig(
        tmp_path,
        '<replicate count="3" euler="0 0 120"><body name="leg" pos=".1 0 0">'
        '<joint name="hip" axis="0 1 0" range="0 0" actuatorfrcrange="-.5 .5"/>'
        '<geom type="capsule" size=".01" fromto="0 0 0 .1 0 0" mass=".05"/>'
        '<body name="foot" pos=".1 0 0"><joint name="knee" axis="0 1 0"/>'
        '<geom type="capsule" size=".01" fromto="0 0 0 0 0 -.1" mass=".05"/></body></body>'
        "</replicate>",
        '<equality><joint joint1="knee" joint2="hip" polycoef="0 -1"/></equality>',
        '<position name="drive" jointinparent="hip" kp="2" kv=".1" ctrlrange="-1 1"/>',
    )
    model = mujoco.MjModel.from_xml_path(str(path))
    driven = {model.joint(int(model.actuator_trnid[i, 0])).name for i in range(4, model.nu)}
    pairs = {
        (model.joint(int(a)).name, model.joint(int(b)).name)
        for a, b in zip(model.eq_obj1id, model.eq_obj2id, strict=True)
    }
    description = read_description(path)
    joints = [joint for joint in description.model.joints if joint.child != "load"]
    servos = {joint.name: joint.freedoms[0].servo for joint in joints if joint.freedoms[0].servo}
    assert set(servos) == driven == {"hip0", "hip1", "hip2"}
    assert {(each.stiffness, each.max_effort) for each in servos.values()} == {(2.0, 0.5)}
    assert {(joint.name, joint.mimic.joint) for joint in joints if joint.mimic} == pairs
    limits = {(joint.freedoms[0].lower, joint.freedoms[0].upper) for joint in joints}
    assert not model.jnt_limited.any() and limits == {(-math.inf, math.inf)}
    assert not [each for each in description.remarks if "drive" in each.element]


def test_a_ball_joint_has_spring_friction_and_limit_and_no_armature(tmp_path):
    ball = (
        '<body name="bob" pos="0 0 -.1"><joint name="socket" type="ball" damping=".01" '
        'stiffness=".5" frictionloss=".1" range="0 60" armature=".002"/>'
        '<geom type="sphere" size=".03" mass=".1"/></body>'
    )
    description = read_description(rig(tmp_path, ball))
    (freedom,) = description.model.joint("socket").freedoms
    assert (freedom.damping, freedom.stiffness, freedom.friction) == (0.01, 0.5, 0.1)
    assert (freedom.upper, freedom.armature) == (pytest.approx(math.pi / 3.0), 0.0)
    (remark,) = [each for each in description.remarks if each.element == "joint 'socket'"]
    assert remark.text == "armature of a ball joint: taken as 0"
    (path, content), *_ = stored_files(description)
    (tmp_path / path).write_bytes(content)
    again = read_description(tmp_path / path).model.joint("socket").freedoms[0]
    for name in ("upper", "damping", "stiffness", "friction"):
        assert getattr(again, name) == getattr(freedom, name)


@pytest.mark.parametrize(
    ("actuator", "used", "said"),
    [
        ('<motor name="a" joint="socket" gear="1 0 0"/>', False, "its joint is a ball, which"),
        ('<intvelocity name="a" joint="socket" actrange="-1 1"/>', False, "its joint is a ball"),
        ('<general name="a" joint="socket" gaintype="user"/>', False, "its joint is a ball, whi"),
        (
            '<general name="a" joint="pivot" dyntype="integrator" gainprm="5" biastype="affine" '
            'biasprm="0 -5 -1" actrange="-1 2" ctrlrange="-9 9" ctrllimited="true"/>',
            True,
            "it takes a position in place of a velocity",
        ),
        ('<general name="a" joint="pivot" dyntype="integrator"/>', False, "not gain times"),
        ('<general name="a" joint="pivot" dyntype="muscle" dynprm="1 1"/>', False, "not gain"),
        ('<general name="a" joint="pivot" gaintype="user"/>', False, "not gain times control"),
        (
            '<general name="a" joint="pivot" gaintype="affine" gainprm="1 2 0"/>',
            False,
            "not gain times control",
        ),
        ('<general name="a" joint="pivot" gaintype="affine" gainprm="1 0 0"/>', True, ""),
        (
            '<general name="a" joint="pivot" biastype="affine" biasprm="0 -5 0"/>',
            True,
            "",
        ),
    ],
)
def test_an_actuator_with_another_force_than_that_of_a_servo_is_said(
    tmp_path, actuator, used, said
):
    """Never a servo with other numbers, as MuJoCo has it: its force depends on more."""
    ball = (
        '<body name="bob" pos="0 0 -.1"><joint name="socket" type="ball"/>'
        '<geom type="sphere" size=".03" mass=".1" pos="0 0 -.1"/></body>'
    )
    path = rig(tmp_path, ROD + ball, actuators=actuator)
    mujoco.MjModel.from_xml_path(str(path))
    description = read_description(path)
    servo = description.model.joint("pivot").freedoms[0].servo
    assert (servo is not None) == used
    remarks = [each.text for each in description.remarks if each.element == "actuator 'a'"]
    assert len(remarks) == bool(said) and all(said in each for each in remarks)
    if "integrator" in actuator and servo:
        assert (servo.stiffness, servo.lower, servo.upper) == (5.0, -1.0, 2.0)


ROD = (
    '<body name="rod"><joint name="pivot" axis="0 1 0"/><site name="tip" pos=".1 0 0"/>'
    '<geom type="capsule" size=".01" fromto="0 0 0 .1 0 0" mass=".1"/>'
    '<body name="cup" pos=".1 0 0"><geom type="sphere" size=".01" mass=".01"/></body></body>'
)


@pytest.mark.parametrize(
    ("ends", "names"),
    [
        ('body1="cup" body2="hull"', "cup, hull"),  # the cup is a part of the rod
        ('body1="cup"', "the world, cup"),
        ('site1="tip" site2="s0"', "hull, rod"),
        ('body1="cup" body2="rod"', ""),
        ('body1="hull"', ""),  # a handle for the mouse in MuJoCo's viewer
    ],
)
def test_equalities_close_loops_also_from_bodies_that_move_along(tmp_path, ends, names):
    path = rig(tmp_path, ROD, f'<equality><connect name="pin" {ends} anchor="0 0 0"/></equality>')
    if "site1" in ends:
        path.write_text(path.read_text().replace(' anchor="0 0 0"', ""))
    if not names:
        assert [each.name for each in read_description(path).model.joints if each.moves]
        return
    with pytest.raises(WorkbenchError, match=f"<connect pin> between {names} closes a loop"):
        read_description(path)


def test_damping_of_a_free_joint_is_said(tmp_path):
    """A default class for hinges gives it to the drone, too; MuJoCo then holds it in the air."""
    path = rig(tmp_path)
    text = path.read_text().replace("<freejoint/>", '<joint name="root" type="free"/>', 1)
    damped = '<default><joint damping=".3"/></default><worldbody>'
    path.write_text(text.replace("<worldbody>", damped, 1))
    (remark,) = [each for each in read_description(path).remarks if each.element == "joint 'root'"]
    assert remark.text.startswith("damping of a free joint: not used")


OTHER = '<general gaintype="muscle" biastype="muscle" dyntype="muscle"/>'
GENERAL = '<general class="x" joint="pivot"/>'


@pytest.mark.parametrize(
    ("default", "actuator", "kind"),
    [
        (OTHER, '<position joint="pivot" kp="5" kv=".1"/>', "position"),
        ('<general dyntype="integrator"/>', '<position joint="pivot" kp="5"/>', "position"),
        ('<general dyntype="integrator"/>', '<velocity joint="pivot" kv="5"/>', "velocity"),
        ('<general gaintype="affine" gainprm="1 2 3"/>', '<velocity joint="pivot"/>', "velocity"),
        ('<velocity kv="3"/>', '<position joint="pivot" kp="5"/>', "position"),
        ('<position kp="3" timeconst=".2"/>', '<velocity joint="pivot"/>', "velocity"),
        ('<position kp="3" kv=".2" timeconst=".4"/>', GENERAL, "position"),
        ('<position kp="3" kv=".2"/>', GENERAL.replace("/>", ' biasprm="1 -2"/>'), "position"),
        ('<position kp="3" kv=".2"/>', GENERAL.replace("/>", ' biastype="none"/>'), "effort"),
        ('<velocity kv="3"/>', GENERAL, "velocity"),
        ('<intvelocity kp="3"/>', GENERAL.replace("/>", ' gainprm="2"/>'), "position"),
        ("<muscle/>", GENERAL.replace("/>", ' gainprm=".5" lengthrange="0 1"/>'), None),
        ('<damper kv="3"/>', GENERAL.replace("/>", ' ctrlrange="0 1"/>'), None),
    ],
)
def test_an_actuator_is_of_its_kind_whatever_its_class_says_as_in_mujoco(
    tmp_path, default, actuator, kind
):
    """With the force of MuJoCo at random states, where it is that of a servo."""
    path = rig(tmp_path, ROD, actuators=actuator.replace(" ", ' name="a" ', 1))
    inner = f"<default>{default}" + f'<default class="x">{default}</default></default>'
    path.write_text(path.read_text().replace("<worldbody>", f"{inner}<worldbody>", 1))
    model = mujoco.MjModel.from_xml_path(str(path))
    data = mujoco.MjData(model)
    description = read_description(path)
    servo = description.model.joint("pivot").freedoms[0].servo
    remarks = [each.text for each in description.remarks if each.element == "actuator 'a'"]
    integrates = model.actuator_dyntype[-1] == mujoco.mjtDyn.mjDYN_INTEGRATOR
    assert len(remarks) == (kind is None or integrates)
    assert (servo and servo.kind) == kind
    if servo is None:
        return
    filtered = model.actuator_dyntype[-1] == mujoco.mjtDyn.mjDYN_FILTEREXACT
    assert servo.time_constant == (model.actuator_dynprm[-1][0] if filtered else 0.0)
    gain, bias = model.actuator_gainprm[-1][0], model.actuator_biasprm[-1]
    over = {"position": -bias[1], "velocity": -bias[2], "effort": 1.0}[kind]
    place = model.joint("pivot").id
    generator = np.random.default_rng(4)
    for q, v, u in generator.uniform(-1.0, 1.0, (5, 3)):
        data.qpos[model.jnt_qposadr[place]], data.qvel[model.jnt_dofadr[place]] = q, v
        (data.act if model.na else data.ctrl)[-1] = u
        mujoco.mj_forward(model, data)
        offset = 0.0 if kind == "effort" else bias[0]
        effort = servo_effort(servo, servo.within((gain * u + offset) / over), q, v)
        assert effort == pytest.approx(data.qfrc_actuator[model.jnt_dofadr[place]], abs=1e-12)
