"""MJCF: poses and inertias as Drake's own parser has them, rotors as MuJoCo's manual says.

Masses, inertias and thrusts as MuJoCo's compiler has them: `test_mjcf_mujoco.py`.
"""

import math

import numpy as np
import pytest
from pydrake.multibody.parsing import Parser
from pydrake.multibody.plant import MultibodyPlant

from workbench.common.errors import WorkbenchError
from workbench.plant.description import read_description
from workbench.plant.loading import load_vehicle, make_vehicle

ROTOR = '<site name="at_{0}" pos="{1} {2} 0.02"/>'
MOTOR = '<motor class="rotor" name="motor_{0}" site="at_{0}" gear="0 0 1 0 0 {1}"/>'
PLACES = ((0.1, 0.1, -0.02), (-0.1, 0.1, 0.02), (-0.1, -0.1, -0.02), (0.1, -0.1, 0.02))
SITES = "".join(ROTOR.format(i, x, y) for i, (x, y, _) in enumerate(PLACES))
MOTORS = "".join(MOTOR.format(i, turn) for i, (_, _, turn) in enumerate(PLACES))
DRONE = """<mujoco model="sparrow">
  <compiler {compiler}/>
  <default>
    <geom rgba="0.2 0.4 0.6 1"/>
    <default class="arm"><geom type="capsule" density="500"/></default>
    <default class="rotor"><motor ctrlrange="0 5"/></default>
  </default>
  <worldbody>
    <body name="hull" pos="1 2 3">
      <freejoint/>
      {hull}
      {sites}
    </body>
  </worldbody>
  <actuator>{motors}</actuator>
  {more}
</mujoco>"""
HULL = '<geom type="box" size="0.06 0.05 0.02" mass="0.6"/>'
PARTS = """
  <geom name="box" type="box" size="0.06 0.05 0.02" pos="0.01 0 0.01" euler="10 20 30"/>
  <geom class="arm" size="0.01" fromto="0 0 0 0.1 0.1 0.02"/>
  <geom class="arm" type="cylinder" size="0.012 0.1" axisangle="1 1 0 40" contype="0"
        conaffinity="0"/>
  <geom type="ellipsoid" size="0.03 0.02 0.01" mass="0.05" zaxis="0 1 1" group="3"/>
  <geom type="sphere" size="0.02" pos="0 0 -0.05" mass="0"/>
  <body name="mast" pos="0 0 0.1" quat="1 0 0 1">
    <joint name="hinge" type="hinge" axis="0 1 0" pos="0 0 0.01"/>
    <inertial pos="0.01 0 0" quat="1 1 0 0" mass="0.1" diaginertia="1e-4 2e-4 2.5e-4"/>
    <geom type="box" size="0.1 0.1 0.1" density="10"/>
    <body name="tip" pos="0.05 0 0" xyaxes="0 1 0 -1 0 0">
      <inertial pos="0 0 0.01" mass="0.02" fullinertia="3e-5 4e-5 5e-5 1e-6 2e-6 -3e-6"/>
    </body>
  </body>"""
"""Every way of saying where something is, and what it weighs."""


SAME_SIDE = "".join(
    MOTOR.format(i, 0.02 * (1 if y > 0 else -1)) for i, (_, y, _) in enumerate(PLACES)
)
"""As menagerie's Skydio X2: both left rotors turn one way, both right ones the other."""


@pytest.fixture
def drone(write):
    """Write a drone with some parts replaced."""

    def write_drone(
        name="sparrow.xml", hull=HULL, sites=SITES, motors=MOTORS, compiler="", more=""
    ):
        text = DRONE.format(hull=hull, sites=sites, motors=motors, compiler=compiler, more=more)
        return write(text, name)

    return write_drone


def fault(path) -> str:
    with pytest.raises(WorkbenchError) as caught:
        make_vehicle(read_description(path))
    said = str(caught.value)
    assert "\n" not in said
    assert said.startswith(str(path.parent))
    return said


@pytest.mark.parametrize("compiler", ["", 'angle="degree" eulerseq="ZYX"', 'eulerseq="zxz"'])
def test_mass_inertia_and_poses_are_those_of_drakes_parser(drone, compiler):
    path = drone(hull=PARTS, compiler=compiler)
    description = read_description(path)
    vehicle = make_vehicle(description)
    plant = MultibodyPlant(0.0)
    Parser(plant).AddModels(str(path))
    plant.Finalize()
    context = plant.CreateDefaultContext()
    hull = plant.GetBodyByName("hull")
    bodies = [plant.GetBodyByName(name) for name in ("hull", "mast", "tip")]
    theirs = plant.CalcSpatialInertia(context, hull.body_frame(), [body.index() for body in bodies])
    com = theirs.get_com()
    assert vehicle.mass == pytest.approx(theirs.get_mass(), rel=1e-9)
    assert vehicle.p_BoBcm_B == pytest.approx(com, abs=1e-9)
    inertia = theirs.Shift(com).CalcRotationalInertia().CopyToFullMatrix3()
    assert vehicle.inertia == pytest.approx(inertia, rel=1e-9, abs=1e-12)
    for body in bodies:
        X_BL = body.body_frame().CalcPose(context, hull.body_frame())
        frame = vehicle.frame(body.name())
        assert frame.p_BF == pytest.approx(X_BL.translation(), abs=1e-12)
        assert np.array(frame.R_BF) == pytest.approx(X_BL.rotation().matrix(), abs=1e-12)
    joint = description.model.joint("hinge")
    assert joint and (joint.kind, joint.parent, joint.child) == ("continuous", "hull", "mast")
    assert joint.X_MJ.translation() == pytest.approx([0, 0, 0.11])


def test_a_mesh_that_is_missing_is_an_error_where_it_decides_the_mass(drone):
    """As menagerie's Crazyflie: its shapes are meshes, its inertia is given."""
    mesh = '<geom type="mesh" mesh="hull"/><geom type="mesh" mesh="hull" mass="0.2"/>'
    asset = '<asset><mesh name="hull" file="gone.obj"/></asset>'
    given = '<inertial pos="0 0 0" mass="0.6" diaginertia="1e-3 1e-3 2e-3"/>'
    assert load_vehicle(drone(hull=given + mesh, more=asset)).mass == 0.6
    said = fault(drone(hull=mesh + HULL, more=asset))
    assert "mass of its body is made from the mesh 'hull'" in said
    assert "gone.obj: no such file: give the body an <inertial>" in said


def test_a_mesh_file_weighs_what_its_volume_does(drone, write):
    """A box of 0.12 by 0.1 by 0.04 m, in centimetres and with its origin in a corner."""
    corners = [f"v {x} {y} {z}" for x in (0, 12) for y in (0, 10) for z in (0, 4)]
    faces = "1 3 4 2,5 6 8 7,1 2 6 5,3 7 8 4,1 5 7 3,2 4 8 6".replace(",", "\nf ")
    write("\n".join([*corners, f"f {faces}"]), "box.obj")
    asset = '<asset><mesh file="box.obj" scale=".01 .01 .01"/></asset>'
    hull = '<geom type="mesh" mesh="box" pos="-0.06 -0.05 -0.02"/>'
    vehicle = load_vehicle(drone(hull=hull, more=asset))
    assert vehicle.mass == pytest.approx(1000.0 * 0.12 * 0.1 * 0.04, rel=1e-6)
    assert vehicle.p_BoBcm_B == pytest.approx((0, 0, 0), abs=1e-7)
    moments = [a**2 + b**2 for a, b in ((0.1, 0.04), (0.12, 0.04), (0.12, 0.1))]
    expected = vehicle.mass / 12.0 * np.array(moments)
    assert np.diag(vehicle.inertia) == pytest.approx(expected, rel=1e-5)


def test_what_is_drawn_and_what_touches_is_as_its_words_say(drone):
    (hull, *_) = read_description(drone(hull=PARTS)).model.links
    assert [type(visual.shape).__name__ for visual in hull.visuals] == [
        "Box",
        "Capsule",
        "Cylinder",
        "Sphere",
    ]
    assert [type(each.shape).__name__ for each in hull.collisions] == [
        "Box",
        "Capsule",
        "Ellipsoid",
        "Sphere",
    ]
    assert hull.visuals[0].rgba == (0.2, 0.4, 0.6, 1.0)


def test_actuators_at_sites_are_rotors(drone):
    """Thrust and moment as their gears say; speeds are assumed, a filter is a lag."""
    vehicle = load_vehicle(drone())
    assert [rotor.name for rotor in vehicle.rotors] == [f"motor_{i}" for i in range(4)]
    for rotor, (x, y, moment) in zip(vehicle.rotors, PLACES, strict=True):
        assert rotor.p_BR == pytest.approx((x, y, 0.02))
        assert rotor.axis_B == (0.0, 0.0, 1.0)
        assert rotor.direction == (1 if moment < 0.0 else -1)
        assert rotor.moment_constant == pytest.approx(0.02)
        assert rotor.max_thrust == pytest.approx(5.0)
    assert vehicle.thrust_to_weight == pytest.approx(20.0 / (0.6 * 9.81))
    for new, most, lag in (
        ('<motor name="m" site="at_0" gear="0 0 2 0 0 -.04" ctrlrange="0 1"/>', 2.0, 0.0125),
        (
            '<general name="m" site="at_0" gear="0 0 1 0 0 -.02" gainprm="3" ctrlrange="0 9" '
            'forcerange="-1 6" dyntype="filter" dynprm="0.03"/>',
            6.0,
            0.03,
        ),
        ('<motor name="m" site="at_0" gear="0 0 1 0 0 -.02"/>', 2 * 0.6 * 9.81 / 4, 0.0125),
    ):
        motors = MOTORS.replace(MOTOR.format(0, -0.02), new)
        first = load_vehicle(drone(motors=motors)).rotors[0]
        assert first.max_thrust == pytest.approx(most)
        assert first.moment_constant == pytest.approx(0.02)
        assert first.time_constant_up == lag


def test_a_site_may_lean(drone):
    leaning = ROTOR.format(0, 0.1, 0.1).replace("/>", ' euler="0 10 0"/>')
    vehicle = load_vehicle(drone(sites=SITES.replace(ROTOR.format(0, 0.1, 0.1), leaning)))
    lean = math.radians(10.0)
    expected = (math.sin(lean), 0.0, math.cos(lean))
    assert vehicle.rotors[0].axis_B == pytest.approx(expected)


def test_thrust_and_moments_of_the_whole_are_no_rotors_and_a_file_of_rotors_helps(drone):
    """As menagerie's Crazyflie has them."""
    motors = (
        '<motor site="at_0" gear="0 0 1 0 0 0"/><motor name="roll" site="at_0" gear="0 0 0 1"/>'
    )
    path = drone(motors=motors)
    assert "no rotors are declared" in fault(path)
    assert "sparrow.rotors.yaml" in fault(path)
    said = [remark.text for remark in read_description(path).remarks]
    assert (
        "actuator_0, roll: thrust and moments of the whole drone, not of rotors; not used" in said
    )
    rows = "".join(
        f"  - {{position: [{x}, {y}, 0], direction: {'cw' if turn > 0 else 'ccw'}}}\n"
        for x, y, turn in PLACES
    )
    path.with_name("sparrow.rotors.yaml").write_text(
        "defaults: {motor_constant: 5.0e-6, moment_constant: 0.02, time_constant_up: 0.02,\n"
        f"  time_constant_down: 0.02, max_rot_velocity: 1000}}\nrotors:\n{rows}"
    )
    assert len(load_vehicle(path).rotors) == 4


WRENCH = "".join(
    f'<motor name="{name}" site="middle" gear="{gear}" ctrlrange="-1 1"/>'
    for name, gear in (
        ("lift", "0 0 1"),
        ("roll", "0 0 0 1"),
        ("pitch", "0 0 0 0 1"),
        ("yaw", "0 0 0 0 0 1"),
    )
)


@pytest.mark.parametrize(
    ("wrench", "unused"),
    [
        (WRENCH, "lift, roll, pitch, yaw"),
        (WRENCH[WRENCH.index("<motor", 1) :], "roll, pitch, yaw"),
        ('<motor name="lift" site="middle" gear="0 0 30"/>', "lift"),
        (
            '<motor name="gust_x" site="nose" gear="1"/><motor name="gust_z" site="nose" '
            'gear="0 0 1"/>',
            "gust_x, gust_z",
        ),
    ],
)
def test_rotors_count_beside_a_wrench_of_the_whole_drone(drone, wrench, unused):
    sites = SITES + '<site name="middle"/><site name="nose" pos="0.1 0 0"/>'
    for motors in (wrench + MOTORS, MOTORS + wrench):
        description = read_description(drone(sites=sites, motors=motors))
        assert [rotor.name for rotor in description.rotors] == [f"motor_{i}" for i in range(4)]
        said = [remark.text for remark in description.remarks]
        text = f"{unused}: thrust and moments of the whole drone, not of rotors; not used"
        assert text in said


def test_a_scene_includes_its_drone(drone, write):
    drone()
    floor = '<worldbody><geom name="floor" type="plane" size="1 1 1"/><light/></worldbody>'
    scene = write(f'<mujoco><include file="sparrow.xml"/>{floor}</mujoco>', "scene.xml")
    description = read_description(scene)
    assert make_vehicle(description).mass == pytest.approx(0.6)
    said = {remark.element: remark.text for remark in description.remarks}
    assert said["objects of the world"] == "'hull' flies; left out are 1 geoms"


def test_what_is_not_used_is_said(drone):
    more = '<option density="1.2" timestep="0.01"/><keyframe><key ctrl="1"/></keyframe>'
    more += '<sensor><gyro site="at_0"/></sensor><tendon><spatial/></tendon>'
    hull = HULL.replace("/>", ' friction="1"/><camera name="c" pos="0 0 1"/>')
    motors = MOTORS.replace("/>", ' actearly="true"/>', 1) + '<position name="servo" joint="j"/>'
    found = read_description(drone(hull=hull, more=more, motors=motors)).remarks
    said = [remark.element for remark in found if remark.kind == "ignored"]
    for element in (
        "element <option> (density timestep)",
        "element <keyframe>",
        "element <sensor>",
        "tendon 'tendon_1'",
        "element <camera>",
        "attribute friction of <geom>",
        "attribute actearly of <motor>",
        "actuator 'servo'",
    ):
        assert element in said


@pytest.mark.parametrize(
    ("settings", "said"),
    [
        ({"hull": "<geom type='box' size='1 1'/>"}, "a box has 3 positive sizes"),
        ({"hull": "<geom size='x'/>"}, "<geom size='x'>: give it numbers"),
        ({"hull": "<geom size='1' euler='1 2'/>"}, "give it 3 numbers"),
        ({"hull": "<geom size='1' quat='0 0 0 0'/>"}, "give it a direction"),
        ({"hull": "<geom size='1' class='wing'/>"}, "class 'wing'"),
        ({"hull": "<geom type='mesh' mesh='wing'/>"}, "no mesh 'wing'"),
        ({"hull": "<geom size='1' mass='-1'/>"}, "mass or density of 0 or more"),
        ({"hull": "<inertial/>"}, "<inertial> without mass"),
        ({"hull": "<inertial mass='1' fullinertia='1'/>"}, "give it six numbers"),
        ({"hull": HULL + "<body name='hull'/>"}, "two bodies named 'hull'"),
        ({"motors": "<motor site='gone'/>"}, "the site 'gone', which the drone does not have"),
        ({"motors": MOTORS.replace("class=", "ctrlrange='1 0' class=")}, "the smaller first"),
        ({"motors": MOTORS.replace("class=", "ctrlrange='-1 0' class=")}, "positive end"),
        ({"compiler": "eulerseq='abc'"}, "eulerseq='abc'"),
        ({"more": "<include file='gone.xml'/>"}, "<include file='gone.xml'>: no such file"),
        ({"more": "<include file='sparrow.xml'/>"}, "includes itself"),
        ({"more": "<include file='part.xml'/><include file='part.xml'/>"}, "included already"),
        ({"hull": HULL + "<geom size='.1' masss='1'/>"}, "<geom masss='1'>: MuJoCo has no such"),
        ({"hull": HULL + "<attach model='a' prefix='b'/>"}, "<attach> in <body>: it adds bodies"),
        ({"hull": HULL + "<composite type='cable'/>"}, "<composite> in <body>: it adds bodies"),
        ({"hull": HULL + "<wing/>"}, "<wing> in <body>: it is not known, and might decide mass"),
        ({"hull": HULL + "<body gravcomp='1'/>"}, "<body gravcomp='1'>: it carries a share"),
        (
            {"hull": HULL + "<body><joint springdamper='0.1 1'/></body>"},
            "<joint springdamper='0.1 1'>: its spring would depend on all inertia",
        ),
        ({"hull": HULL + "<body><freejoint/></body>"}, "free joints only directly in bodies of"),
        ({"hull": HULL + "<joint type='free' armature='1'/>"}, "adds to mass and inertia of all"),
        ({"hull": HULL + "<inertial mass='1'/><inertial mass='1'/>"}, "a second <inertial>"),
        ({"hull": "<replicate count='x'/>"}, "<replicate count='x'>: give it numbers"),
        ({"hull": "<replicate count='1e6'/>"}, "give it the number of copies"),
        ({"hull": "<replicate count='9999'><body><site/></body></replicate>"}, "than 20000 el"),
        ({"hull": "<replicate counts='2'/>"}, "<replicate counts='2'>: MuJoCo has no such"),
        ({"hull": "<replicate count='2'><inertial mass='1'/></replicate>"}, "<inertial>, which a"),
        ({"hull": "<geom type='hfield' hfield='h'/>"}, "the mass of a hfield is not known"),
        ({"hull": "<geom size='1' fromto='0 0 0 1 0 0'/>"}, "fromto is for a capsule"),
        ({"hull": HULL, "sites": SITES + SITES}, "two sites named 'at_0'"),
        ({"compiler": "coordinate='global'"}, "<compiler coordinate='global'>: use local"),
        ({"compiler": "inertiagrouprange='1'"}, "give it two groups"),
        ({"compiler": "boundmas='1'"}, "<compiler boundmas='1'>: MuJoCo has no such attribute"),
        ({"more": "<option><flag actuation='disable'/></option>"}, "switches all actuators off"),
        ({"more": "<option><flag clampctrl='disable'/></option>"}, "without the limits"),
        ({"more": "<option><flag spring='disable'/></option>"}, "springs would not act"),
        ({"more": "<option><flag damper='disable'/></option>"}, "dampings would not act"),
        ({"more": "<option><flag gravity='disable'/></option>"}, "nothing would have a weight"),
        ({"more": "<option actuatorgroupdisable='0'/>"}, "switches it off: enable it"),
        ({"more": "<default class='wing'/>"}, "class of a top-level <default> is main"),
        ({"more": "<default><default class='arm'/></default>"}, "name that no other"),
        ({"motors": "<velocity name='v' site='at_0'/>"}, "actuator 'v' is a <velocity>"),
        ({"motors": "<general site='at_0' biastype='affine' biasprm='0 0 -1'/>"}, "is gain times"),
        ({"motors": "<general site='at_0' dyntype='integrator'/>"}, "is gain times control"),
        ({"motors": "<general site='at_0' gaintype='muscle'/>"}, "is gain times control"),
        ({"motors": "<general site='at_0' gainprm='0'/>"}, "its control has no effect"),
        ({"motors": "<motor site='at_0' refsite='at_1'/>"}, "a rotor pushes along its own site"),
        (
            {"compiler": "autolimits='false'"},
            "<motor ctrlrange='0 5'>: without autolimits, MuJoCo asks for ctrllimited: add it",
        ),
        ({"motors": MOTORS.replace("-0.02", "0.02")}, "thrust and yaw go together"),
        ({"motors": SAME_SIDE}, "roll and yaw go together"),
    ],
)
def test_what_cannot_be_is_one_sentence(drone, write, settings, said):
    write("<mujoco><size/></mujoco>", "part.xml")
    assert said in fault(drone(**settings))


def test_a_body_that_is_not_free_is_no_drone(write):
    path = write("<mujoco><worldbody><body name='a'/></worldbody></mujoco>", "a.xml")
    assert "no body in <worldbody> has a <freejoint/>" in fault(path)
    assert "no <body> in <worldbody>" in fault(write("<mujoco/>", "b.xml"))
