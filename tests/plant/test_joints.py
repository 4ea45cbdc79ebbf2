"""Joints of descriptions: as published files have them, and five of these with right values."""

import json
import math
from pathlib import Path

import numpy as np
import pytest
from pydrake.systems.framework import DiagramBuilder

from tests.docs.test_pages import blocks
from tests.jointed import drone, joint, link
from workbench.common.errors import WorkbenchError
from workbench.design.linear.study import LinearStudy
from workbench.plant.description import read_description
from workbench.plant.formats.urdf_writer import stored_files
from workbench.plant.loading import make_vehicle
from workbench.plant.multibody import add_plant
from workbench.plant.rotor_sources.mount import body_pose
from workbench.scenario.scenario import Scenario, VehicleConfig

SHARED = Path(__file__).resolve().parents[2].parent / "shared" / "models" / "joints"
PUBLISHED = ("f450_pendulum", "hexa_arm", "x500_gimbal")
needs_published = pytest.mark.skipif(
    not SHARED.is_dir(), reason=f"put published descriptions into {SHARED} to try them"
)
LIMIT = '<limit lower="{}" upper="{}" effort="-1" velocity="-1"/>'


def arm(kind: str, more: str = "") -> str:
    """Return a link on a joint named `hinge`."""
    return link("arm", 0.1, (0.1, 0.0, 0.0)) + joint(
        "hinge", kind, "base", "arm", (0, 0, -0.1), (0, 1, 0), more
    )


def freedoms(path: str) -> int:
    """Return the number of velocities of a description's plant, less those of the base link."""
    plant, _ = add_plant(DiagramBuilder(), read_description(path), time_step=0.0)
    return plant.num_velocities() - 6


@pytest.mark.parametrize(
    ("kind", "more", "count"),
    [
        ("revolute", LIMIT.format(-1.0, 1.0), 1),
        ("revolute", LIMIT.format(-1e16, 1e16), 1),
        ("revolute", LIMIT.format(0, 0), 0),
        ("continuous", "", 1),
        ("prismatic", LIMIT.format(-0.1, 0.1), 1),
        ("planar", "", 3),
        ("universal", "", 2),
        ("ball", "", 3),
        ("fixed", "", 0),
        ("floating", "", 0),
    ],
)
def test_each_kind_of_joint_has_its_freedoms(tmp_path, kind, more, count):
    path = drone(tmp_path, arm(kind, more))
    assert freedoms(path) == count
    held = [each for each in read_description(path).remarks if each.kind == "held"]
    assert bool(held) == (count == 0 and kind != "fixed")


def test_the_load_on_the_page_swings_about_two_axes(tmp_path):
    block = next(each for each in blocks("joints.md") if each.language == "xml")
    assert freedoms(drone(tmp_path, block.text.replace("base_link", "base"))) == 2


def test_screws_and_loops_are_refused_by_name(tmp_path):
    with pytest.raises(WorkbenchError, match="joint 'hinge' is a screw joint"):
        read_description(drone(tmp_path, arm("screw")))
    with pytest.raises(WorkbenchError, match="has the type 'Revolute', which URDF does not have"):
        read_description(drone(tmp_path, arm("Revolute")))
    loop = joint("second", "revolute", "base", "arm", more=LIMIT.format(-1, 1))
    with pytest.raises(WorkbenchError, match="link 'arm' is the child of two joints"):
        read_description(drone(tmp_path, arm("continuous") + loop))


@pytest.mark.parametrize(("mass", "body"), [(0.1, "base"), (2.0, "camera")])
def test_a_root_that_is_lighter_than_what_carries_the_rotors_is_not_the_body(tmp_path, mass, body):
    """A camera above the drone in the file: the vehicle is that with the camera below its base."""
    camera = link("camera", mass, (0.0, 0.01, 0.0))
    (tmp_path / "down").mkdir()
    paths = [
        Path(drone(tmp_path, camera + joint("tilt", "continuous", "camera", "base", (0, 0, 0.1)))),
        Path(
            drone(
                tmp_path / "down",
                camera + joint("tilt", "continuous", "base", "camera", (0, 0, -0.1), (0, -1, 0)),
            )
        ),
    ]
    rotors = paths[0].with_name("jointed.rotors.yaml")
    rotors.write_text(rotors.read_text().replace("position:", "link: base, position:"))
    up, down = map(read_description, paths)
    assert up.base_link == body
    assert [each.element for each in up.remarks].count("base link") == (body == "base")
    if body == "camera":
        return
    found, expected = make_vehicle(up), make_vehicle(down)
    assert found.p_BoBcm_B == pytest.approx(expected.p_BoBcm_B, abs=1e-12)
    assert found.inertia == pytest.approx(expected.inertia, abs=1e-12)
    assert [each.p_BR for each in found.rotors] == [each.p_BR for each in expected.rotors]


def test_springs_in_gazebos_blocks_of_joints_act(tmp_path):
    """As sdformat turns them into <spring_stiffness> and <spring_reference> of the axis."""
    block = "<springStiffness>300</springStiffness><springReference>-0.02</springReference>"
    leg = arm("prismatic", LIMIT.format(-0.05, 0.05)) + (
        f'<gazebo reference="hinge">{block}<stopKd>1</stopKd></gazebo>'
    )
    description = read_description(drone(tmp_path, leg))
    (freedom,) = description.model.joint("hinge").freedoms
    assert (freedom.stiffness, freedom.rest) == (300.0, -0.02)
    unused = [each.element for each in description.remarks if "<gazebo>" in each.element]
    assert unused == ["element <stopKd> of <gazebo>"]
    with pytest.raises(WorkbenchError, match="block of 'hinge' has <springStiffness>soft<"):
        read_description(drone(tmp_path, leg.replace("300", "soft")))
    lost = read_description(drone(tmp_path, leg.replace('reference="hinge"', 'reference="hing"')))
    assert "<springStiffness> of 'hing'" in [each.element for each in lost.remarks]


@pytest.mark.parametrize(
    ("limit", "largest"),
    [
        ("", math.inf),
        ('<limit effort="1" velocity="2"/>', math.inf),
        ('<limit lower="-1" effort="1" velocity="2"/>', math.inf),
        ('<limit lower="0.2" upper="0.5" effort="1" velocity="2"/>', 0.5),
        ('<limit upper="1e16" effort="1" velocity="2"/>', math.inf),
    ],
)
def test_only_a_stated_upper_limit_is_the_largest_angle_of_a_ball_joint(tmp_path, limit, largest):
    description = read_description(drone(tmp_path, arm("ball", limit)))
    (freedom,) = description.model.joint("hinge").freedoms
    assert freedom.upper == largest and freedom.lower <= 0.0


def test_both_axes_of_a_universal_joint_have_its_numbers(tmp_path):
    more = '<dynamics damping="0.1" friction="0.2" stiffness="3" rest="0.4" armature="0.5"/>'
    path = drone(tmp_path, arm("universal", more + '<limit effort="6" velocity="7"/>'))
    first, second = read_description(path).model.joint("hinge").freedoms
    assert (first.axis_J, second.axis_J) == ((1.0, 0.0, 0.0), (0.0, 1.0, 0.0))
    for each in (first, second):
        assert (each.damping, each.friction, each.stiffness) == (0.1, 0.2, 3.0)
        assert (each.rest, each.armature, each.effort, each.speed) == (0.4, 0.5, 6.0, 7.0)
        assert (each.lower, each.upper) == (-math.inf, math.inf)
    limited = read_description(drone(tmp_path, arm("universal", LIMIT.format(-0.5, 0.7))))
    for each in limited.model.joint("hinge").freedoms:
        assert (each.lower, each.upper) == (-0.5, 0.7)
    assert freedoms(drone(tmp_path, arm("universal", LIMIT.format(0, 0)))) == 0


def test_a_world_above_a_floating_joint_is_no_body(tmp_path):
    parts = '<link name="world"/>' + joint("free", "floating", "world", "base")
    description = read_description(drone(tmp_path, parts))
    assert description.base_link == "base"
    assert make_vehicle(description).mass == pytest.approx(1.0)


def test_what_has_no_inertia_about_its_axis_is_held(tmp_path):
    parts = link("bead", 0.1, (0, 0, 0), (0.0, 0.0, 0.0)) + joint(
        "hinge", "continuous", "base", "bead"
    )
    path = drone(tmp_path, parts)
    (remark,) = (each for each in read_description(path).remarks if each.kind == "held")
    assert remark.text.startswith("nothing below has a moment of inertia about its axis")
    assert freedoms(path) == 0


def test_light_links_between_joints_fly(tmp_path):
    parts = (
        link("light", 1e-8, (0, 0, 0), (1e-16,) * 3)
        + link("load", 0.2, (0, 0, -0.5))
        + joint("one", "continuous", "base", "light", (0, 0, -0.1), (1, 0, 0))
        + joint("two", "continuous", "light", "load", (0, 0, 0), (0, 1, 0))
    )
    assert make_vehicle(read_description(drone(tmp_path, parts))).mass == pytest.approx(1.2)


def test_a_stored_model_has_the_same_joints(tmp_path):
    more = LIMIT.format(-0.3, 0.8) + '<dynamics damping="0.1" friction="0.2" stiffness="3"/>'
    description = read_description(drone(tmp_path, arm("revolute", more) + arm_two()))
    folder = tmp_path / "stored"
    for relative, data in stored_files(description):
        (folder / relative).parent.mkdir(parents=True, exist_ok=True)
        (folder / relative).write_bytes(data)
    again = read_description(folder / "jointed.urdf")
    for one in description.model.joints:
        if one.moves and len(one.freedoms) == 1:
            other = again.model.joint(one.name)
            assert other.freedoms == one.freedoms
            assert other.mimic == one.mimic
    assert len([each for each in again.model.joints if each.moves]) == 4


def arm_two() -> str:
    """Return a link that follows `hinge`, and one on a universal joint."""
    follows = LIMIT.format(-2.0, 2.0) + '<mimic joint="hinge" multiplier="0.5" offset="0.1"/>'
    return (
        link("other", 0.1, (0.1, 0.0, 0.0))
        + joint("follower", "revolute", "base", "other", (0, 0, -0.1), (0, 1, 0), follows)
        + link("load", 0.1, (0.0, 0.0, -0.3))
        + joint("cardan", "universal", "base", "load", (0, 0, -0.1))
    )


def test_a_spinning_propeller_is_no_joint_that_moves(tmp_path):
    """Its rotor is given by its position alone."""
    parts = link("prop", 0.01) + joint(
        "spin", "continuous", "base", "prop", (0.2, 0.2, 0.0), (0, 0, 1)
    )
    description = read_description(drone(tmp_path, parts))
    assert not [each for each in description.model.joints if each.moves]
    assert not [each for each in description.remarks if each.kind == "held"]


def expected_of(name: str) -> tuple[dict, Path]:
    """Return the right values of a published description, and its file."""
    found = json.loads((SHARED / name / "expected.json").read_text())
    return found, SHARED / name / found["file"]


@needs_published
@pytest.mark.parametrize("name", PUBLISHED)
def test_a_published_description_has_its_mass_joints_and_torques(name):
    right, path = expected_of(name)
    description = read_description(path)
    vehicle, model = make_vehicle(description), description.model
    assert vehicle.mass == pytest.approx(right["mass"], rel=1e-8)
    assert np.abs(np.array(vehicle.p_BoBcm_B) - right["com"]).max() < 1e-8
    assert np.abs(vehicle.inertia - right["inertia"]).max() < 1e-8
    assert [each.name for each in vehicle.joints] == right["joints"]
    plant, _ = add_plant(DiagramBuilder(), description, time_step=0.0)
    mimics = sum(each.mimic is not None for each in model.joints)
    assert plant.num_velocities() - mimics == right["dof"]
    context = plant.CreateDefaultContext()
    torques = plant.CalcGravityGeneralizedForces(context)
    mobile = plant.CalcMassMatrix(context)
    X_BM = body_pose(model, description.base_link)
    for detail, moving in zip(right["joint_details"], vehicle.joints, strict=True):
        declared = model.joint(detail["name"])
        X_BJ = X_BM @ declared.X_MJ
        assert moving.mass == pytest.approx(detail["moved_mass"])
        assert np.abs(X_BJ.translation() - detail["position"]).max() < 1e-8
        for number, (freedom, label) in enumerate(
            zip(declared.freedoms, declared.freedom_names, strict=True)
        ):
            axis = X_BJ.rotation().multiply(np.array(freedom.axis_J))
            assert np.abs(axis - detail["axes"][number]).max() < 1e-8
            assert freedom.damping == detail["damping"]
            assert freedom.friction == detail["friction"]
            lower, upper = detail["lower"], detail["upper"]
            assert freedom.lower == (lower if lower > -1e16 else -math.inf)
            assert freedom.upper == (upper if upper < 1e16 else math.inf)
            place = plant.GetJointByName(label).velocity_start()
            assert torques[place] == pytest.approx(detail["gravity_torque"][number], abs=1e-8)
    if "pendulum_rad_s" in right:
        place = plant.GetJointByName(label).velocity_start()
        turned = np.zeros(plant.num_positions())
        turned[0] = 1.0
        turned[plant.GetJointByName(label).position_start()] = 1e-6
        plant.SetPositions(context, turned)
        stiffness = -plant.CalcGravityGeneralizedForces(context)[place] / 1e-6
        clamped = math.sqrt(stiffness / mobile[place, place])
        drift = [3, 4, 5, place]  # its attitude is held, and it drifts
        free = math.sqrt(stiffness * np.linalg.inv(mobile[np.ix_(drift, drift)])[-1, -1])
        assert clamped == pytest.approx(right["pendulum_rad_s"]["clamped"], rel=1e-6)
        assert free == pytest.approx(right["pendulum_rad_s"]["free"], rel=1e-6)


@needs_published
def test_published_tilting_rotors_have_their_servos():
    """<velocity gear="0.3">: torque 0.3 (u - 0.3 w), |u| <= 1; the rotors alone have rank 3."""
    right, path = expected_of("tiltrotor_plus")
    description = read_description(path)
    vehicle = make_vehicle(description)
    assert vehicle.mass == pytest.approx(right["mass"], rel=1e-8)
    assert np.abs(vehicle.inertia - right["inertia"]).max() < 1e-8
    declared = [each for each in description.model.joints if each.moves]
    assert [each.name for each in declared] == right["joints"]
    for each, detail in zip(declared, right["joint_details"], strict=True):
        (freedom,) = each.freedoms
        assert freedom.armature == detail["armature"]
        assert freedom.damping == 0.0
        assert (freedom.lower, freedom.upper) == pytest.approx((detail["lower"], detail["upper"]))
        assert freedom.servo.damping == pytest.approx(0.3**2)
        assert freedom.servo.max_rate == pytest.approx(1.0 / 0.3)
    assert sorted(tilt.joint for tilt in vehicle.tilts) == sorted(right["joints"])


@needs_published
def test_a_published_load_hangs_on_its_string():
    """The string is an MJCF tendon between two free bodies, as long as they are apart."""
    right, path = expected_of("quad_tendon_load")
    description = read_description(path)
    vehicle, model = make_vehicle(description), description.model
    assert vehicle.mass == pytest.approx(right["mass"], rel=1e-9)
    assert np.abs(np.array(vehicle.p_BoBcm_B) - right["com"]).max() < 1e-8
    assert np.abs(vehicle.inertia - right["inertia"]).max() < 1e-8
    assert [description.base_link, *model.loads] == right["free_bodies"]
    plant, _ = add_plant(DiagramBuilder(), description, time_step=0.0)
    assert plant.num_velocities() == right["dof"]
    (cable,) = model.cables
    assert [cable.parent, cable.child] == right["tendon"]["ends"]
    assert cable.length == right["tendon"]["range"][1]
    study = LinearStudy(Scenario(vehicle=VehicleConfig(model=str(path))))
    values = np.linalg.eigvals(study.bare_vehicle().A)
    swing = right["pendulum_rad_s"]["free"]
    assert np.abs(values - 1j * swing).min() < 0.005 * swing


def test_what_holds_a_load_and_is_no_straight_cable_is_refused_by_name(tmp_path):
    """A tendon that also pushes, one over three sites, and a free body without any."""
    for tendon, words in (
        ('<spatial name="rod" range="0.5 1" limited="true">{}</spatial>', "'rod': its range"),
        ('<spatial name="bar" stiffness="9" springlength="1">{}</spatial>', "'bar': its spring"),
        (
            '<spatial name="pulley" range="0 1" limited="true">{}<site site="c"/></spatial>',
            "'pulley': it does not run straight",
        ),
        ("", r"several bodies move freely: .* tendon: quad, load"),
    ):
        path = tmp_path / "quad.xml"
        ends = tendon.format('<site site="a"/><site site="b"/>')
        path.write_text(
            '<mujoco><worldbody><body name="quad"><freejoint/><inertial pos="0 0 0" mass="1" '
            'diaginertia="1e-2 1e-2 2e-2"/><site name="a"/><site name="c"/></body>'
            '<body name="load" pos="0 0 -1"><freejoint/><inertial pos="0 0 0" mass="0.1" '
            'diaginertia="1e-4 1e-4 1e-4"/><site name="b"/></body></worldbody>'
            f"<tendon>{ends}</tendon></mujoco>"
        )
        with pytest.raises(WorkbenchError, match=words):
            read_description(path)


@pytest.mark.parametrize(("length", "said"), [(0.5, True), (0.79, False)])
def test_a_cable_that_begins_far_too_short_is_said(tmp_path, length, said):
    parts = link("crate", 0.2) + joint("free", "floating", "base", "crate", (0.0, 0.0, -0.8))
    parts += (
        f'<cable name="sling" length="{length}"><parent link="base"/><child link="crate"/></cable>'
    )
    remarks = read_description(drone(tmp_path, parts)).remarks
    texts = [each.text for each in remarks if each.element == "cable 'sling'"]
    assert texts == ["0.8 m between its ends: it is too short, and pulls at once"] * said


def test_whether_a_cable_is_too_short_is_said_of_where_joints_begin(tmp_path, case):
    """An arm of 1 m that begins 60° down, then slid out by 0.5 m, below a mimic of the latter."""
    turned = '<limit lower="1.0471975511965976" upper="2" effort="1" velocity="1"/>'
    slid = '<limit lower="0.5" upper="0.9" effort="1" velocity="1"/>'
    parts = link("arm", 0.1, (0.5, 0.0, 0.0)) + joint(
        "elbow", "revolute", "base", "arm", axis=(0, 1, 0), more=turned
    )
    parts += link("hand", 0.1) + joint(
        "slide", "prismatic", "arm", "hand", (1, 0, 0), (1, 0, 0), slid
    )
    follows = '<limit lower="-1" upper="1" effort="1" velocity="1"/><mimic joint="slide"/>'
    parts += link("tip", 0.1) + joint(
        "more", "prismatic", "hand", "tip", axis=(0, 0, 1), more=follows
    )
    parts += link("crate", 0.2) + joint("free", "floating", "base", "crate", (0.0, 0.0, -2.0))
    down, half = math.sqrt(0.75), 0.5
    for end, place in (
        ("base", (0.0, 0.0)),
        ("arm", (0.0, 0.0)),
        ("hand", (1.5 * half, -1.5 * down)),
        ("tip", (1.5 * half + 0.5 * down, -1.5 * down + 0.5 * half)),
    ):
        apart = math.hypot(place[0], place[1] + 2.0)
        for length, said in ((apart / 1.04, False), (apart / 1.06, True)):
            with case(end, length):
                ends = f'<parent link="{end}"/><child link="crate"/>'
                cable = f'<cable name="sling" length="{length}">{ends}</cable>'
                remarks = read_description(drone(tmp_path, parts + cable)).remarks
                texts = [each.text for each in remarks if each.element == "cable 'sling'"]
                assert (
                    texts
                    == [f"{apart:.3g} m between its ends: it is too short, and pulls at once"]
                    * said
                )


def test_a_stored_load_hangs_on_the_same_cable(tmp_path):
    hung = (
        link("ball", 0.2)
        + joint("free", "floating", "base", "ball", (0.1, 0.0, -0.8))
        + '<cable name="sling" length="0.9"><parent link="base" xyz="0.1 0 0"/>'
        '<child link="ball" xyz="0 0 0.05"/></cable>'
    )
    description = read_description(drone(tmp_path, hung))
    assert not [each for each in description.remarks if each.kind == "held"]
    folder = tmp_path / "stored"
    for relative, data in stored_files(description):
        (folder / relative).parent.mkdir(parents=True, exist_ok=True)
        (folder / relative).write_bytes(data)
    again = read_description(folder / "jointed.urdf")
    assert again.model.cables == description.model.cables
    assert again.model.loads == ("ball",)
    assert make_vehicle(again).p_BoBcm_B == pytest.approx(make_vehicle(description).p_BoBcm_B)
