"""Servos drive joints: against closed forms, by hand, and on two published descriptions."""

import dataclasses
import math
from pathlib import Path
from types import SimpleNamespace

import control
import numpy as np
import pytest
from pydrake.common.eigen_geometry import Quaternion
from pydrake.math import RollPitchYaw
from scipy.linalg import expm
from scipy.signal import lsim

from tests.jointed import SPHERE, drone, joint, link
from workbench.common.errors import WorkbenchError
from workbench.design.linear.study import LinearStudy
from workbench.design.rollout.engine import RolloutEngine
from workbench.diagram.servos import commanded_joints
from workbench.plant.servo import Servo
from workbench.plant.tilt import Tilt
from workbench.plant.vehicle import VehicleServo
from workbench.scenario.scenario import (
    Action,
    FigureEight,
    Push,
    Scenario,
    ScenarioStart,
    VehicleConfig,
)
from workbench.session.session import Session
from workbench.setup import make_setup

SHARED = Path(__file__).resolve().parents[2].parent / "shared" / "models" / "joints"
needs_published = pytest.mark.skipif(
    not SHARED.is_dir(), reason=f"put published descriptions into {SHARED} to try them"
)
MASS, PERIOD = 1e4, 1 / 128
LAW = """
from workbench.controllers import {imports}pd
PARAMETERS, POINTS, LOOPS, rule = pd.PARAMETERS, pd.POINTS, pd.LOOPS, pd.rule
SERVOS = {servos}

def update(measured, setpoint, g, vehicle, memory, dt, loops):
    wrench, memory = pd.update(measured, setpoint, g, vehicle, memory, dt, loops)
{body}
"""


def position_plugin(stiffness: float, damping: float, most: float = 1000.0) -> str:
    """Return Gazebo's controller of the position of the joint `pan`, without an integral part."""
    return f"""<gazebo><plugin name="gz::sim::systems::JointPositionController"
      filename="gz-sim-joint-position-controller-system"><joint_name>pan</joint_name>
      <p_gain>{stiffness}</p_gain><i_gain>0</i_gain><d_gain>{damping}</d_gain>
      <cmd_max>{most}</cmd_max><cmd_min>{-most}</cmd_min></plugin></gazebo>"""


def panned(folder, drive: str, more: str = "") -> Scenario:
    """Return a hover of a heavy drone with a ball that turns about a vertical axis through it."""
    parts = link("ball", 0.05) + joint(
        "pan", "continuous", "base", "ball", (0, 0, -0.1), (0, 0, 1), more
    )
    path = drone(folder, parts + drive, MASS, (MASS,) * 3, thrust=0.1)
    start = ScenarioStart(position=[0.0, 0.0, 20.0])
    return Scenario(vehicle=VehicleConfig(model=path), start=start)


def turned(session: Session, name: str = "pan_q") -> tuple[np.ndarray, np.ndarray]:
    """Return times and positions of a joint in a flight."""
    names = [each for each, _ in session.vehicle.joint_signals]
    time, signals = session._live.recorded()
    return time, signals["joints"][:, names.index(name)]


def test_a_position_servo_steps_as_its_closed_form(tmp_path):
    """I q'' + d q' + k (q - u) = 0 with w = 20 rad/s and a damping ratio of 0.5."""
    w, ratio, step = 20.0, 0.5, 0.4
    stiffness, damping = SPHERE * w**2, 2.0 * ratio * SPHERE * w
    session = Session(panned(tmp_path, position_plugin(stiffness, damping)))
    session.tick(0.25)
    session.set("servo_pan", step)
    session.tick(0.5)
    time, angle = turned(session)
    t = time[time >= 0.25] - 0.25
    damped = w * math.sqrt(1.0 - ratio**2)
    decay = np.exp(-ratio * w * t)
    swing = np.cos(damped * t) + ratio * w / damped * np.sin(damped * t)
    assert np.abs(angle[time >= 0.25] - step * (1.0 - decay * swing)).max() < 1e-4 * step
    assert np.abs(angle[time < 0.25]).max() < 1e-9


def test_effort_rate_and_delay_are_limited(tmp_path):
    """Full effort turns it by a t² / 2; a setpoint moves at its rate, two periods late."""
    most = 1e-3
    session = Session(panned(tmp_path, position_plugin(1.0, 0.0, most)))
    session.set("servo_pan", 3.0)
    session.tick(0.125)
    _, angle = turned(session)
    assert angle[-1] == pytest.approx(0.5 * most / SPHERE * 0.125**2, rel=1e-6)

    scenario = panned(tmp_path, "")
    sidecar = tmp_path / "jointed.rotors.yaml"
    rate, delay = 2.0, 2 * PERIOD
    sidecar.write_text(
        f"{sidecar.read_text()}servos:\n"
        f"  - {{joint: pan, max_rate: {rate}, delay: {delay}, lower: -1.0, upper: 1.0}}\n"
    )
    session = Session(scenario)
    session.set("servo_pan", 1.0)
    setpoints = []
    servos = session._bench.diagram.GetSubsystemByName("servos")
    for _ in range(6):
        session.tick(PERIOD)
        context = servos.GetMyContextFromRoot(session._live.root)
        setpoints.append(servos.get_output_port().Eval(context)[0])
    steps = rate * PERIOD * np.arange(1, 5)
    assert setpoints == pytest.approx([0.0, 0.0, *steps], abs=1e-12)
    with pytest.raises(WorkbenchError, match="servo_pan is 1.5 rad: keep it within -1 .. 1 rad"):
        session.set("servo_pan", 1.5)


def test_a_checkpoint_a_script_and_slices_have_the_setpoints(tmp_path):
    scenario = panned(tmp_path, position_plugin(0.05, 0.005))
    scenario.script = [Action(0.1, set={"servo_pan": 0.5})]
    whole, sliced = Session(scenario), Session(scenario)
    whole.tick(0.5)
    for _ in range(16):
        sliced.tick(0.03125)
    assert np.array_equal(turned(sliced)[1], turned(whole)[1])
    checkpoint = whole.checkpoint()
    whole.tick(0.25)
    sliced.begin_from(checkpoint)
    assert sliced.get("servo_pan") == 0.5
    sliced.tick(0.25)
    assert sliced.snapshot().joints == whole.snapshot().joints


def test_a_law_hears_and_commands_a_rate_servo_with_the_poles_of_both(tmp_path):
    """The law holds u = -K q for a period, and I w' = d (u - w): poles of the sampled pair."""
    gain, damping = 6.0, 0.004
    scenario = panned(tmp_path, "")
    sidecar = tmp_path / "jointed.rotors.yaml"
    sidecar.write_text(
        f"{sidecar.read_text()}servos:\n  - {{joint: pan, kind: velocity, damping: {damping}}}\n"
    )
    law = tmp_path / "panning.py"
    body = f"    return wrench + ({gain} * (0.3 - measured.joints[0]),), memory"
    law.write_text(LAW.format(imports="", servos='("pan",)', body=body))
    scenario.controller = str(law)
    setup = make_setup(scenario)
    a = damping / SPHERE
    # [q w u]: u is held
    A = expm(np.array([[0.0, 1.0, 0.0], [0.0, -a, a], [0.0, 0.0, 0.0]]) * PERIOD)
    closed = A[:2, :2] - gain * np.outer(A[:2, 2], [1.0, 0.0])
    expected = np.linalg.eigvals(closed)
    model = LinearStudy(setup).sampled()
    values = np.linalg.eigvals(model.A)
    for pole in expected:
        assert np.abs(values - pole).min() < 1e-6
    assert model.trim.joints == pytest.approx([0.3], abs=1e-9)

    session = Session(setup)
    assert "servo_pan" not in session._table
    session.tick(1.0)
    state = np.array([-0.3, 0.0])
    for _ in range(128):
        state = closed @ state
    assert turned(session)[1][-1] - 0.3 == pytest.approx(state[0], abs=1e-5)
    with pytest.raises(WorkbenchError, match="joint"):
        RolloutEngine.of(setup)


def test_delay_and_lowpass_of_a_servo_are_in_the_linear_model_as_they_fly(tmp_path):
    """The law asks for u = K (0.3 - q); the servo takes u two periods later, through a low-pass.

    Poles and steps are python-control's, for I w' = d (r - w) under a hold, and the low-pass at the
    instants of updates, at which it follows at once: z times that under a hold.
    """
    gain, damping, late, lag = 4.0, 0.004, 2, 0.03
    scenario = panned(tmp_path, "")
    sidecar = tmp_path / "jointed.rotors.yaml"
    sidecar.write_text(
        f"{sidecar.read_text()}servos:\n  - {{joint: pan, kind: velocity, damping: {damping}, "
        f"delay: {late * PERIOD}, time_constant: {lag}}}\n"
    )
    law = tmp_path / "panning.py"
    body = f"    return wrench + ({gain} * (0.3 - measured.joints[0]),), memory"
    law.write_text(LAW.format(imports="", servos='("pan",)', body=body))
    scenario.controller = str(law)
    setup = make_setup(scenario)
    a = damping / SPHERE
    ball = control.c2d(control.tf([a], [1.0, a, 0.0]), PERIOD)
    held = control.c2d(control.tf([1.0], [lag, 1.0]), PERIOD)
    (share,), (_, pole) = held.num[0][0], held.den[0][0]
    servo = control.tf([share], [1.0, pole, *[0.0] * (late - 1)], PERIOD)
    closed = control.feedback(gain * ball * servo, 1.0)
    model = LinearStudy(setup).sampled()
    values = np.linalg.eigvals(model.A)
    assert len(closed.poles()) == 4
    for pole in closed.poles():
        assert np.abs(values - pole).min() < 1e-6
    with pytest.raises(WorkbenchError, match="low-passes of servos are sampled"):
        LinearStudy(setup).continuous()

    session = Session(setup)
    session.tick(0.75)
    time, angle = turned(session)
    steps = PERIOD * np.arange(97)
    expected = 0.3 * control.step_response(closed, steps).outputs
    assert np.abs(np.interp(steps, time, angle) - expected).max() < 2e-5
    assert np.ptp(expected) > 0.3
    setpoints = session.recording().joint_setpoints[:, 0]
    assert not setpoints[time < late * PERIOD].any()
    assert setpoints.max() > 0.5


def test_a_law_may_command_only_servos_that_are_there(tmp_path):
    scenario = panned(tmp_path, position_plugin(0.05, 0.005))
    law = tmp_path / "wrong.py"
    law.write_text(
        LAW.format(imports="", servos='("tilt",)', body="    return wrench + (0.0,), memory")
    )
    scenario.controller = str(law)
    with pytest.raises(WorkbenchError, match=r"SERVOS has 'tilt', .* it has pan"):
        Session(scenario)
    law.write_text(LAW.format(imports="", servos='("pan",)', body="    return wrench, memory"))
    with pytest.raises(WorkbenchError, match=r"tuple of 5 numbers, F, m_x, m_y, m_z, pan"):
        Session(scenario)


@needs_published
def test_a_published_gimbal_keeps_its_camera_level_as_far_as_its_servos_can(tmp_path):
    """With the angle b of the body the camera's c is I c'' + D (c' - b') + k c = 0

    The setpoint is -b, so the servo lags: its bandwidth is k / D = 6.7 rad/s.
    """
    law = tmp_path / "level.py"
    body = """    R = attitude_matrix(measured.q_WT)
    roll = arctan2(R[7], R[8])
    pitch = arctan2(-R[6], (R[7] * R[7] + R[8] * R[8]) ** 0.5)
    return wrench + (-roll, pitch), memory"""
    servos = '("cgo3_horizontal_arm_joint", "cgo3_camera_joint")'
    law.write_text(LAW.format(imports="arctan2, attitude_matrix, ", servos=servos, body=body))
    session = Session(
        Scenario(
            vehicle=VehicleConfig(model=str(SHARED / "x500_gimbal" / "x500_gimbal" / "model.sdf")),
            controller=str(law),
            figure_eight=FigureEight(laps=1),
        )
    )
    session.tick(6.0)
    time, signals = session._live.recorded()
    attitudes = np.array(
        [RollPitchYaw(Quaternion(q / np.linalg.norm(q))).vector() for q in signals["state"][:, :4]]
    )
    for name, axis, sense, inertia, damping in (
        ("cgo3_horizontal_arm_joint", 0, 1.0, 0.002, 0.02),
        ("cgo3_camera_joint", 1, -1.0, 0.001, 0.015),
    ):
        body_angle = attitudes[:, axis]
        camera = body_angle + sense * turned(session, f"{name}_q")[1]
        whole = damping + 0.1
        _, expected, _ = lsim(([whole, 0.0], [inertia, whole, 0.8]), body_angle, time)
        assert np.ptp(body_angle) > 0.1
        assert np.linalg.norm(camera - expected) < 0.05 * np.linalg.norm(expected)


TILTED = SHARED / "tiltrotor_plus" / "tiltrotor_plus_hover.xml"


@needs_published
def test_a_published_tilt_rotor_trims_and_turns_by_its_tilts():
    """Its rotors alone have rank 3 of 4. Forces on its arms by hand, at the angles flown."""
    setup = make_setup(Scenario(vehicle=VehicleConfig(model=str(TILTED))))
    model = LinearStudy(setup).sampled()
    assert model.trim.joints == pytest.approx([0.0] * 4, abs=1e-9)
    weight = 0.28 * 9.81 / 4.0
    assert model.trim.speeds == pytest.approx([math.sqrt(weight / 1e-6)] * 4, rel=1e-3)
    values = np.linalg.eigvals(model.A)
    assert np.abs(values).max() < 1.0 + 1e-9

    session = Session(setup)
    session.tick(0.25)
    session.do(Action(push=Push(torque=[0.0, 0.0, 0.05], duration=0.2)))
    session.tick(0.4)
    airframe, root = session._bench.airframe, session._live.root
    state = airframe.body_state(root)
    assert np.abs(session.snapshot().joints[:4]).min() > 0.01
    rotors = airframe.rotors
    context = rotors.GetMyContextFromRoot(root)
    forces = rotors.GetOutputPort("spatial_forces").Eval(context)
    thrusts = rotors.GetOutputPort("static_thrusts").Eval(context)
    order = ("tilt_front", "tilt_left", "tilt_back", "tilt_right")
    names = [each for each, _ in session.vehicle.joint_signals]
    R = Quaternion(state[:4] / np.linalg.norm(state[:4])).rotation()
    senses = (-0.1, -0.1, 0.1, 0.1)  # moment over thrust, of the gear
    for number, (name, sense) in enumerate(zip(order, senses, strict=True)):
        angle = session.snapshot().joints[names.index(f"{name}_q")]
        about = (1.0, 0.0, 0.0) if number % 2 == 0 else (0.0, 1.0, 0.0)
        axis = np.cross(about, [0.0, 0.0, 1.0]) * math.sin(angle)
        axis = R @ (axis + [0.0, 0.0, math.cos(angle)])
        force = forces[number + 1].F_Bq_W
        assert np.abs(force.translational() - thrusts[number] * axis).max() < 1e-9
        arm = 0.0175 * axis  # the line of its thrust
        out = R @ (0.01 * np.array(((1, 0, 0), (0, 1, 0), (-1, 0, 0), (0, -1, 0))[number]))
        moment = np.cross(arm + out, thrusts[number] * axis) + sense * thrusts[number] * axis
        assert np.abs(force.rotational() - moment).max() < 1e-9
    session.do(Action(yaw_rate=0.3))
    session.tick(3.0)
    assert session.state()[9] == pytest.approx(0.3, abs=0.03)
    assert np.abs(session.state()[4:7] - [0.0, 0.0, 1.5]).max() < 0.05


def test_a_law_commands_its_servos_behind_those_that_tilt_rotors(tmp_path):
    """Allocation has the first places behind the rotors, whatever the order of the vehicle."""
    plain = make_setup(panned(tmp_path, position_plugin(0.05, 0.005))).vehicle
    vehicle = dataclasses.replace(
        plain,
        servos=tuple(VehicleServo(name, False, Servo()) for name in ("pan", "tail", "roll")),
        tilts=(Tilt("tail", -1.0, 1.0, ()),),
    )
    law = SimpleNamespace(file="law.py", servos=("roll", "pan"))
    assert commanded_joints(vehicle, law) == ["tail", "roll", "pan"]
