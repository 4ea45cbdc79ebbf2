"""Linear models of drones with joints, against equations derived by hand."""

import gc
import math
import weakref
from dataclasses import replace
from pathlib import Path

import control
import numpy as np
import pytest

from tests.jointed import SPHERE, drone, joint, link
from workbench.common.errors import WorkbenchError
from workbench.design.judge.loop_response import loop_responses
from workbench.design.linear.operating_point import HOLDING_POINT
from workbench.design.linear.study import LinearStudy
from workbench.plant.gravity import GRAVITY
from workbench.scenario.scenario import Scenario, VehicleConfig
from workbench.setup import make_setup

BASE, INERTIA, LOAD, LENGTH, DEPTH = 1.0, 0.012, 0.3, 0.6, 0.1
SPRING, DAMPING = 0.4, 0.03
"""Of the joint [N m/rad, N m s/rad]."""


@pytest.fixture(scope="module")
def study(tmp_path_factory):
    """Return the study of a quadrotor with a load that swings about y."""
    parts = link("load", LOAD, (0.0, 0.0, -LENGTH)) + joint(
        "swing",
        "continuous",
        "base",
        "load",
        (0.0, 0.0, -DEPTH),
        more=f'<dynamics damping="{DAMPING}" stiffness="{SPRING}"/>',
    )
    model = drone(tmp_path_factory.mktemp("loaded"), parts, BASE, (0.01, INERTIA, 0.02))
    return LinearStudy(Scenario(vehicle=VehicleConfig(model=model)))


def test_a_planar_quadrotor_with_a_load_has_the_eigenvalues_of_its_equations(study):
    """Of x, the pitch a and the load's angle b, both about y, with the load at the depth d + l:

    load's position x - d a - l b, its height -d cos a - l cos b, thrust (M + m) g along body z, and
    the joint's angle b - a. So M q'' + D q' + K q = 0 with the matrices of kinetic energy, of the
    joint's damping, and of potential energy, spring and the thrust's component along x.
    """
    M, m, d, l, g = BASE, LOAD, DEPTH, LENGTH, GRAVITY  # noqa: E741
    mass = np.array(
        [
            [M + m, -m * d, -m * l],
            [-m * d, INERTIA + m * d * d, m * d * l],
            [-m * l, m * d * l, SPHERE + m * l * l],
        ]
    )
    across = np.outer([0.0, -1.0, 1.0], [0.0, -1.0, 1.0])
    stiffness = np.diag([0.0, m * g * d, m * g * l]) + SPRING * across
    stiffness[0, 1] = -(M + m) * g
    rates = [np.linalg.solve(mass, each) for each in (stiffness, DAMPING * across)]
    whole = np.block([[np.zeros((3, 3)), np.eye(3)], [-rates[0], -rates[1]]])
    moving = [value for value in np.linalg.eigvals(whole) if abs(value) > 1e-2]
    assert len(moving) == 2
    model = study.bare_vehicle()
    found = np.linalg.eigvals(model.A)
    for value in moving:
        assert np.abs(found - value).min() < 1e-6
    assert model.state_names[-2:] == ("swing_q", "swing_w")


def test_the_sampled_loop_has_the_swing_and_is_that_of_the_continuous_one(study):
    model, continuous = study.sampled(), study.continuous()
    values = np.linalg.eigvals(model.A).astype(complex)
    poles = np.log(values[np.abs(values) > 0.1]) / model.period
    swing = max(
        (value for value in np.linalg.eigvals(continuous.A) if 3.0 < value.imag < 10.0),
        key=lambda value: value.real,
    )
    assert np.abs(poles - swing).min() < 0.05 * abs(swing)
    assert {"swing_q", "swing_w"} <= {signal.name for signal in model.outputs}


def test_a_trim_hangs_the_joints(tmp_path):
    """A load beside its hinge hangs below it, and a spring holds one up: k (q - rest) = m g r."""
    spring = '<dynamics stiffness="2.0" rest="0.0"/>'
    parts = (
        link("load", LOAD, (0.1, 0.0, -0.2))
        + joint("swing", "continuous", "base", "load", (0.0, 0.0, -DEPTH))
        + link("tray", 0.05, (0.1, 0.0, 0.0))
        + joint("spring", "continuous", "base", "tray", (0.0, 0.0, 0.0), (0, 1, 0), spring)
    )
    model = drone(tmp_path, parts, BASE)
    trim = LinearStudy(Scenario(vehicle=VehicleConfig(model=model))).trim()
    pitch = 2.0 * np.arcsin(trim.q_WB[2])
    swing, tray = trim.joints
    assert swing + pitch == pytest.approx(np.arctan2(0.1, 0.2), abs=1e-6)
    assert 2.0 * tray == pytest.approx(0.05 * GRAVITY * 0.1 * np.cos(tray + pitch), abs=1e-8)


def test_a_trim_hangs_what_begins_upside_down(tmp_path):
    """Two rods that begin near upright; each hangs with what is on it straight below its hinge.

    A vector (x, z) of a link that turns by a about y points down at a = atan2(x, -z).
    """
    upper, lower, elbow = (0.02, 0.0, 0.1), (-0.05, 0.0, 0.1), (0.05, 0.0, 0.2)
    parts = (
        link("upper", 0.2, upper)
        + joint("first", "continuous", "base", "upper", (0.0, 0.0, -DEPTH))
        + link("lower", 0.1, lower)
        + joint("second", "continuous", "upper", "lower", elbow)
    )
    model = drone(tmp_path, parts, BASE)
    study = LinearStudy(Scenario(vehicle=VehicleConfig(model=model)))
    x, _, z = 0.2 * np.array(upper) + 0.1 * np.array(elbow)
    first, second = study.trim().joints
    assert np.cos(first - np.arctan2(x, -z)) == pytest.approx(1.0, abs=1e-12)
    assert np.cos(first + second - np.arctan2(lower[0], -lower[2])) == pytest.approx(1.0, abs=1e-12)
    assert max(abs(first), abs(second)) < np.pi  # and turns no further than it has to
    poles = np.linalg.eigvals(study.bare_vehicle().A)
    assert poles.real.max() < 0.1  # upright, one would be near sqrt(g / l), 10 rad/s


def test_a_ball_joint_that_hangs_at_a_pitch_of_90_degrees_has_no_trim(tmp_path):
    """And one that hangs at 85° has the frequencies of a pendulum, about both its axes."""
    for angle in (90.0, 85.0):
        out, down = math.sin(math.radians(angle)), math.cos(math.radians(angle))
        parts = link("load", LOAD, (0.5 * out, 0.0, -0.5 * down))
        parts += joint("string", "ball", "base", "load", more='<dynamics damping="1e-6"/>')
        model = drone(tmp_path, parts, 1e6, (1e6, 1e6, 1e6), thrust=10.0)
        study = LinearStudy(Scenario(vehicle=VehicleConfig(model=model)))
        if angle == 90.0:
            with pytest.raises(WorkbenchError, match="'string' rests near a pitch of 90"):
                study.trim()
            continue
        poles = np.linalg.eigvals(study.bare_vehicle().A)
        inertia = SPHERE + LOAD * 0.5**2
        rate = math.sqrt(LOAD * GRAVITY * 0.5 / inertia)
        assert np.sum(np.abs(np.abs(poles) - rate) < 1e-4 * rate) == 4


def test_a_trim_finds_what_leans_on_a_limit_and_what_follows_a_servo(tmp_path):
    """A leg whose weight holds it against a limit, and two fingers, of which a servo opens one."""
    limit = '<limit lower="{}" upper="{}" effort="-1" velocity="-1"/>'
    parts = (
        link("leg", 0.1, (0.0, 0.05, -0.1))
        + joint("gear", "revolute", "base", "leg", (0, 0, -0.05), (1, 0, 0), limit.format(0, 1))
        + link("left", 0.02, (0.0, 0.0, -0.05))
        + joint("left", "revolute", "base", "left", (0.1, 0, 0), more=limit.format(0.1, 0.9))
        + link("right", 0.02, (0.0, 0.0, -0.05))
        + joint("right", "revolute", "base", "right", (0.1, 0, 0), more=limit.format(-0.9, 0.2))
    )
    parts = parts.replace(
        '<child link="left"/>',
        '<child link="left"/><servo stiffness="2" damping="0.05" start="0.4"/>',
    ).replace('<child link="right"/>', '<child link="right"/><mimic joint="left" multiplier="-1"/>')
    model = drone(tmp_path, parts, BASE)
    gear, left, right = LinearStudy(Scenario(vehicle=VehicleConfig(model=model))).trim().joints
    assert -0.01 < gear < 0.0
    # 2 (0.4 - q) holds both fingers up: m g l sin q of each, with the same sign for the leader
    assert 2.0 * (0.4 - left) == pytest.approx(2.0 * 0.02 * GRAVITY * 0.05 * np.sin(left), rel=1e-3)
    assert right == pytest.approx(-left, abs=1e-5)


def test_a_joint_that_nothing_keeps_at_rest_is_named(tmp_path):
    """The drag torque of a rotor turns its free arm for ever."""
    arm = link("arm", 0.1) + joint("turret", "continuous", "base", "arm", (0, 0, 0), (0, 0, 1))
    path = Path(drone(tmp_path, arm, BASE))
    sidecar = path.with_name("jointed.rotors.yaml")
    sidecar.write_text(sidecar.read_text().replace("name: r0,", "name: r0, link: arm,"))
    study = LinearStudy(Scenario(vehicle=VehicleConfig(model=str(path))))
    with pytest.raises(WorkbenchError, match="no position keeps 'turret' at rest"):
        study.trim()


def test_a_law_knows_the_inertia_of_what_swings_not_with_the_body(study):
    """By hand: the load pulls at its hinge, at the depth d, with the mass that it has there.

    A force at the hinge across a free load of mass m, length l and moment I meets the mass
    m I / (I + m l²), so the body has the moment J + M m' d² / (M + m') about its own centre of
    mass, raised by the share of m' in the centre.
    """
    vehicle = study.vehicle
    held = LOAD * SPHERE / (SPHERE + LOAD * LENGTH**2)
    expected = INERTIA + BASE * held * DEPTH**2 / (BASE + held)
    assert vehicle.turned.I_BBcm_B[1][1] == pytest.approx(expected, rel=1e-9)
    assert vehicle.inertia[1, 1] > 4.0 * expected
    # about x and z the load turns with the body, and its weight pulls at the hinge
    assert vehicle.turned.p_BoBcm_B[:2] == pytest.approx((0.0, 0.0))


def test_a_load_on_an_arm_that_a_servo_holds_out_has_a_trim(tmp_path):
    """The arm sinks by k (q - r) = (m_a l / 2 + m l) g cos q; the load hangs below its tip.

    On the way there a search that goes too far finds the cable slack, and nothing that pulls.
    """
    length, arm, load, cable, stiffness, setpoint = 0.3, 0.05, 0.25, 0.1, 4.0, 0.9
    servo = f'<servo kind="position" stiffness="{stiffness}" damping="0.1"/>'
    limits = '<limit lower="-2" upper="2" effort="-1" velocity="-1"/>'
    parts = (
        link("arm", arm, (0.5 * length, 0.0, 0.0))
        + joint("shoulder", "revolute", "base", "arm", (0, 0, -DEPTH), more=limits + servo)
        + link("ball", load)
        + joint("free", "floating", "base", "ball", (length, 0.0, -DEPTH - cable))
        + f'<cable name="sling" length="{cable}" stiffness="1e4">'
        f'<parent link="arm" xyz="{length} 0 0"/>'
        '<child link="ball"/></cable>'
    )
    model = drone(tmp_path, parts, BASE)
    scenario = Scenario(vehicle=VehicleConfig(model=model))
    trim = LinearStudy(make_setup(scenario, {"servo_shoulder": setpoint})).trim()
    q = trim.joints[0]
    torque = (0.5 * arm + load) * length * GRAVITY * np.cos(q)
    assert stiffness * (q - setpoint) == pytest.approx(torque, rel=1e-6)
    place = trim.joints[4:7] + (length, 0.0, -DEPTH - cable)
    assert place[0] == pytest.approx(length * np.cos(q), abs=1e-6)
    depth = DEPTH + length * np.sin(q) + cable + load * GRAVITY / 1e4
    assert place[2] == pytest.approx(-depth, abs=1e-6)


def armed(folder) -> str:
    """Return a quadrotor with an arm on a servo."""
    arm = link("arm", 0.2, (0.0, 0.0, -0.3)) + joint(
        "shoulder",
        "revolute",
        "base",
        "arm",
        more='<limit lower="-2" upper="2" effort="-1" velocity="-1"/>'
        '<servo kind="position" stiffness="4.0" damping="0.1"/>',
    )
    return drone(folder, arm, BASE)


def test_a_held_position_has_a_trim_and_loops_above_an_arm_that_sags(tmp_path):
    """The arm of mass m and length l hangs at q: K (r - q) = m g l sin q, which pulls at the body.

    The law knows an arm that hangs straight, of the inertia I. Its rotors give the moment for an
    error of pitch 2 sin(a / 2) = m g l sin q / (I kp_pitch), so its force leans by a, though the
    body is level. For that the setpoint is ahead: kp_position kp_velocity (x_sp - x) = g tan a.
    """
    stiffness, setpoint, mass, length = 4.0, 0.9, 0.2, 0.3
    study = LinearStudy(
        make_setup(
            Scenario(vehicle=VehicleConfig(model=armed(tmp_path))), {"servo_shoulder": setpoint}
        )
    )
    trim, g = study.trim(HOLDING_POINT), study.gains
    q = trim.joints[0]
    moment = mass * GRAVITY * length * np.sin(q)
    assert stiffness * (setpoint - q) == pytest.approx(moment, rel=1e-6)
    known = 0.012 + SPHERE + BASE * mass / (BASE + mass) * length**2
    lean = 2.0 * np.arcsin(0.5 * moment / (known * g["kp_pitch"]))
    ahead = GRAVITY * np.tan(lean) / (g["kp_position_xy"] * g["kp_velocity_x"])
    assert ahead > 0.05
    offset = trim.p_WB_setpoint - trim.p_WB
    assert offset == pytest.approx([ahead, 0.0, 0.0], rel=1e-6, abs=1e-9)
    assert trim.reference == pytest.approx(np.zeros(4), abs=1e-9)
    # a held position asks for a velocity, as a pilot does; loops of other axes are open here
    holding = study.sampled(HOLDING_POINT).opened(["position_y_error", "position_z_error"])
    steered = study.sampled().matrices(["reference_v_x"], ["p_x"])
    frequency = np.geomspace(0.05, 20.0, 12)
    response = control.frequency_response(steered.state_space(), frequency)
    expected = g["kp_position_xy"] * response.complex
    found = loop_responses(holding, ["position_x_error"]).at(frequency)[0]
    np.testing.assert_allclose(found, expected, rtol=1e-5)


@pytest.mark.parametrize("model", [LinearStudy.bare_vehicle, LinearStudy.continuous])
def test_models_hold_servos_at_the_setpoints_that_are_asked_for(tmp_path, model):
    """They equal those of a study whose own setpoint it is; the arm is elsewhere with another."""
    scenario = Scenario(vehicle=VehicleConfig(model=armed(tmp_path)))
    study, held = LinearStudy(scenario), {"servo_shoulder": 0.9}
    own = LinearStudy(make_setup(scenario, held))
    before = model(study).A
    found = model(study, gains=held).A
    assert found == pytest.approx(model(own).A, abs=1e-9)
    assert np.abs(found - before).max() > 0.01


def test_studies_share_a_plant_whatever_their_gains_but_not_what_is_built_in(tmp_path):
    scenario = Scenario(vehicle=VehicleConfig(model=armed(tmp_path)))
    study = LinearStudy(scenario)

    def like(settings) -> LinearStudy:
        return study.like(study.setup.with_settings(settings))

    plant = study._derivatives.plant
    stiff = like({"kp_velocity_x": 2.0 * study.gains["kp_velocity_x"], "drag_area": 0.5})
    other = study.like(replace(scenario, controller="lqi"))
    for each in (stiff, other):
        assert each._derivatives.plant is plant
    alone = LinearStudy(stiff.setup).bare_vehicle()
    np.testing.assert_allclose(stiff.bare_vehicle().A, alone.A, rtol=0.0, atol=1e-12)
    for settings in ({"servo_shoulder": 0.9}, {"payload_mass": 0.1}):
        assert like(settings)._derivatives.plant is not plant


def test_a_study_does_not_keep_those_before_it(tmp_path):
    scenario = Scenario(vehicle=VehicleConfig(model=armed(tmp_path)))
    study = LinearStudy(scenario)
    before = weakref.ref(study._derivatives)
    study = study.like(scenario)
    gc.collect()
    assert before() is None
    assert study.trim().joints.size == 1
