"""Drones with joints fly: against closed forms, momentum, and MuJoCo."""

import math
from pathlib import Path

import numpy as np
import pytest
from pydrake.math import RigidTransform, RollPitchYaw
from pydrake.systems.analysis import Simulator
from pydrake.systems.framework import DiagramBuilder
from pydrake.systems.primitives import ConstantVectorSource

from tests.jointed import ARM, crossings, drone, joint, link
from tests.jointed import SPHERE as LINK_MOMENT
from workbench.common.errors import WorkbenchError
from workbench.design.rollout.engine import RolloutEngine
from workbench.design.rollout.sensor_set import why_not_compiled
from workbench.diagram.core import make_open_loop
from workbench.diagram.joint_modes import joint_modes, joint_study
from workbench.diagram.mounting import find_imu
from workbench.plant.description import read_description
from workbench.plant.gathered import merged_model
from workbench.plant.gravity import GRAVITY
from workbench.plant.loading import make_vehicle
from workbench.plant.multibody import add_plant
from workbench.plant.reach import reach_sphere
from workbench.scenario.scenario import (
    Action,
    Rates,
    Scenario,
    ScenarioStart,
    SensorsConfig,
    VehicleConfig,
)
from workbench.session.integration import (
    AIR_INTEGRATOR,
    STIFF_ACCURACY,
    Integration,
    integrator_in_hover,
)
from workbench.session.session import Session
from workbench.setup import make_setup
from workbench.systems.joint_forces import STOP_RATE_RAD_S, joint_rows

RATES = Rates()

MASS, LOAD, LENGTH, RADIUS = 30.0, 0.1, 0.8, 0.05
ROTOR = """
  <link name="r{i}"><inertial><mass value="0.01"/>
    <inertia ixx="1e-5" iyy="1e-5" izz="2e-5" ixy="0" ixz="0" iyz="0"/></inertial></link>
  <joint name="j{i}" type="continuous"><parent link="body"/><child link="r{i}"/>
    <origin xyz="{x} {y} 0.05"/><axis xyz="0 0 1"/></joint>
  <gazebo><plugin filename="gz-sim-multicopter-motor-model-system" name="m{i}">
    <jointName>j{i}</jointName><linkName>r{i}</linkName><motorNumber>{i}</motorNumber>
    <turningDirection>{turn}</turningDirection><motorConstant>2e-4</motorConstant>
    <momentConstant>0.02</momentConstant><maxRotVelocity>1000</maxRotVelocity>
    <timeConstantUp>0.02</timeConstantUp><timeConstantDown>0.02</timeConstantDown></plugin>
  </gazebo>"""
PLACES = ((0.5, 0.5), (-0.5, -0.5), (-0.5, 0.5), (0.5, -0.5))
SPHERE = 0.4 * LOAD * RADIUS**2
BALL = f"""<robot name="carrier">
  <link name="body"><inertial><mass value="{MASS}"/>
    <inertia ixx="2.0" iyy="2.0" izz="3.0" ixy="0" ixz="0" iyz="0"/></inertial></link>
  <link name="load"><inertial><origin xyz="0 0 {-LENGTH}"/><mass value="{LOAD}"/>
    <inertia ixx="{SPHERE}" iyy="{SPHERE}" izz="{SPHERE}" ixy="0" ixz="0" iyz="0"/></inertial>
    <collision name="ball"><origin xyz="0 0 {-LENGTH}"/>
      <geometry><sphere radius="{RADIUS}"/></geometry></collision></link>
  <joint name="string" type="ball"><parent link="body"/><child link="load"/></joint>"""
ROTORS = "".join(
    ROTOR.format(i=i, x=x, y=y, turn=("ccw", "ccw", "cw", "cw")[i])
    for i, (x, y) in enumerate(PLACES)
)


@pytest.fixture(scope="module")
def carrier(tmp_path_factory):
    """Return the description's path."""
    path = tmp_path_factory.mktemp("carrier") / "carrier.urdf"
    path.write_text(f"{BALL}{ROTORS}</robot>")
    return path


@pytest.fixture
def scenario(carrier):
    """Return a hover high above the ground."""
    return Scenario(
        vehicle=VehicleConfig(model=str(carrier)), start=ScenarioStart(position=[0.0, 0.0, 10.0])
    )


def pull(session, angle: float) -> None:
    """Turn the string about x by an angle [rad]."""
    plant = session._bench.airframe.plant
    context = plant.GetMyMutableContextFromRoot(session._live.simulator.get_mutable_context())
    plant.GetJointByName("string").set_angles(context, [angle, 0.0, 0.0])


@pytest.mark.slow
def test_it_swings_as_a_pendulum_below_a_body_that_hovers(scenario):
    """The body is 300 times as heavy as the load, so it hardly moves: T = 2 pi sqrt(I / (m g L)).

    At 0.05 rad the period of a pendulum is longer by 0.05^2 / 16, which is nothing here.
    """
    session = Session(scenario)
    plant = session._bench.airframe.plant
    assert (plant.num_positions(), plant.num_velocities()) == (10, 9)
    session.tick(0.5)
    pull(session, 0.05)
    session.tick(8.0)
    time, signals = session._live.recorded()
    angle = signals["joints"][:, 0][time > 0.5]
    time = time[time > 0.5]
    crossed = crossings(time, angle)
    inertia = LOAD * LENGTH**2 + 0.4 * LOAD * RADIUS**2
    expected = 2.0 * math.pi * math.sqrt(inertia / (LOAD * 9.81 * LENGTH))
    assert len(crossed) >= 4
    assert np.diff(crossed).mean() == pytest.approx(expected, rel=0.005)
    assert np.abs(session.state()[4:7] - [0.0, 0.0, 10.0]).max() < 0.01


def test_a_spring_in_a_ball_joint_swings_faster_and_a_limit_stops_it(carrier, tmp_path):
    """T = 2 pi sqrt(I / (m g L + k)) within the limit; a load thrown against it turns back there.

    Beyond its limit A the load has the energy of a spring of 100 rad/s, so with the speed w it
    goes at most w / 100 further.
    """
    stiffness, limit, speed = 0.4, 0.6, 3.0
    path = tmp_path / "sprung.urdf"
    more = f'<dynamics stiffness="{stiffness}"/><limit upper="{limit}"/></joint>'
    text = carrier.read_text()
    at = text.index("</joint>", text.index('name="string"'))
    path.write_text(text[:at] + more + text[at + len("</joint>") :])
    start = ScenarioStart(position=[0.0, 0.0, 10.0])
    session = Session(Scenario(vehicle=VehicleConfig(model=str(path)), start=start))
    session.tick(0.5)
    pull(session, 0.05)
    session.tick(4.0)
    time, signals = session._live.recorded()
    crossed = crossings(time[time > 0.5], signals["joints"][:, 0][time > 0.5])
    inertia = LOAD * LENGTH**2 + 0.4 * LOAD * RADIUS**2
    expected = 2.0 * math.pi * math.sqrt(inertia / (LOAD * 9.81 * LENGTH + stiffness))
    assert len(crossed) >= 2
    assert np.diff(crossed).mean() == pytest.approx(expected, rel=0.005)
    plant = session._bench.airframe.plant
    context = plant.GetMyMutableContextFromRoot(session._live.simulator.get_mutable_context())
    string = plant.GetJointByName("string")
    string.set_angles(context, [0.5, 0.0, 0.0])
    string.set_angular_velocity(context, [speed, 0.0, 0.0])
    session.tick(0.25)
    angles = session._live.recorded()[1]["joints"][:, 0][-32:]
    assert limit < angles.max() < limit + speed / 100.0
    assert angles[-1] < limit - 0.02


def test_slices_and_a_checkpoint_fly_the_same_with_a_joint(scenario):
    whole, sliced = Session(scenario), Session(scenario)
    for session in (whole, sliced):
        session.tick(0.25)
        pull(session, 0.5)
    whole.tick(1.0)
    for _ in range(8):
        sliced.tick(0.125)
    assert sliced.state().tolist() == whole.state().tolist()
    checkpoint = whole.checkpoint()
    whole.tick(1.0)
    sliced.begin_from(checkpoint)
    sliced.tick(1.0)
    assert sliced.state().tolist() == whole.state().tolist()


def test_it_weighs_all_its_bodies_and_reaches_as_far_as_the_string(carrier):
    description = read_description(carrier)
    vehicle = make_vehicle(description)
    assert vehicle.mass == pytest.approx(MASS + LOAD + 0.04)
    centre = -LOAD * LENGTH / vehicle.mass + 0.04 * 0.05 / vehicle.mass
    assert vehicle.p_BoBcm_B[2] == pytest.approx(centre)
    assert [joint.name for joint in vehicle.joints] == ["string"]
    assert not [each for each in description.remarks if "string" in each.element]
    around = reach_sphere(description.model, "body", description.rotors)
    highest = around.p_BC[2]  # the string turned upwards, and the ball beyond it
    assert around.radius == pytest.approx(abs(highest) + LENGTH + RADIUS)


class OpenLoopFlight:
    """A vehicle with constant rotor speeds, flown as a session integrates."""

    def __init__(self, path: str, speeds: float | None = None) -> None:
        setup = make_setup(Scenario(vehicle=VehicleConfig(model=path), rates=RATES))
        turning = setup.vehicle.hover_speeds if speeds is None else np.full(4, speeds)
        diagram, self.airframe, self._recorder = make_open_loop(
            setup, ConstantVectorSource(turning)
        )
        self.plant = self.airframe.plant
        self.simulator = Simulator(diagram)
        self.root = self.simulator.get_mutable_context()
        self.context = self.plant.GetMyMutableContextFromRoot(self.root)
        state = np.array([1.0, 0.0, 0.0, 0.0, 0.0, 0.0, 50.0, *[0.0] * 6])
        self.airframe.place(self.root, state, turning)
        drag = self.airframe.body_forces.GetMyMutableContextFromRoot(self.root)
        drag.get_mutable_numeric_parameter(0).SetFromVector([0.0, 0.0])
        self._integration = Integration(self.simulator, self.airframe, RATES)

    def set(self, name: str, angle: float, rate: float = 0.0) -> None:
        """Set the position and velocity of a joint."""
        joint = self.plant.GetJointByName(name)
        joint.set_angle(self.context, angle)
        joint.set_angular_rate(self.context, rate)

    def fly(self, duration: float) -> tuple[np.ndarray, dict[str, np.ndarray]]:
        """Fly on, and return times and signals."""
        self.simulator.Initialize()
        self._integration.advance(round(duration / RATES.physics_step))
        return self._recorder.times(self.root), self._recorder.signals(self.root)


@pytest.mark.parametrize("base", [2.0, 1e6])
def test_a_pendulum_swings_at_the_frequency_of_the_reduced_mass(tmp_path, base):
    """Below a body of mass M that keeps its attitude: w² = m g l / (I + l² m M / (m + M)).

    Its moments of inertia keep the attitude; a mass of 1e6 kg clamps it. Thrust carries the weight.
    """
    load, length, angle = 0.3, 0.6, 0.02
    parts = link("load", load, (0.0, 0.0, -length)) + joint(
        "swing", "continuous", "base", "load", (0.0, 0.0, -0.1)
    )
    path = drone(tmp_path, parts, base, (1e6, 1e6, 1e6), thrust=1e-5 * base)
    flight = OpenLoopFlight(path)
    flight.set("swing", angle)
    time, signals = flight.fly(5.0)
    measured = 2.0 * math.pi / np.diff(crossings(time, signals["joints"][:, 0])).mean()
    reduced = load * base / (load + base)
    assert measured == pytest.approx(
        math.sqrt(load * GRAVITY * length / (LINK_MOMENT + reduced * length**2)), rel=1e-3
    )


def test_an_arm_that_swings_in_free_fall_keeps_all_momentum(tmp_path):
    upper = link("upper", 0.4, (0.2, 0.0, -0.1), (1e-3, 2e-3, 2e-3))
    lower = link("lower", 0.2, (0.0, 0.05, -0.2), (1e-3, 1e-3, 2e-4))
    parts = (
        upper
        + lower
        + joint("shoulder", "continuous", "base", "upper", (0.05, 0, -0.1))
        + joint("elbow", "continuous", "upper", "lower", (0.4, 0, -0.1), (1, 0, 0))
    )
    flight = OpenLoopFlight(drone(tmp_path, parts), speeds=0.0)
    flight.set("shoulder", 0.3, 4.0)
    flight.set("elbow", -0.5, -6.0)
    plant, context = flight.plant, flight.context

    def momentum() -> np.ndarray:
        """Return angular momentum about the centre of mass, and the linear one."""
        centre = plant.CalcCenterOfMassPositionInWorld(context)
        found = plant.CalcSpatialMomentumInWorldAboutPoint(context, centre)
        return np.concatenate([found.rotational(), found.translational()])

    before, duration = momentum(), 1.5
    flight.fly(duration)
    expected = before.copy()
    expected[5] -= 1.6 * GRAVITY * duration
    turned, moved = momentum() - expected, np.linalg.norm
    assert moved(turned[:3]) < 1e-4 * moved(before[:3])
    assert moved(turned[3:]) < 1e-4 * moved(expected[3:])
    assert abs(plant.GetJointByName("elbow").get_angle(context)) > 1.0


def test_a_joint_rests_on_its_limit_and_starts_within(tmp_path):
    """An arm hangs on a limit: gravity presses it in by (m g l cos q / I) / STOP_RATE²."""
    limits = '<limit lower="-1.2" upper="-0.4" effort="-1" velocity="-1"/>'
    parts = link("arm", 0.1, (0.3, 0.0, 0.0)) + joint(
        "hinge", "revolute", "base", "arm", (0, 0, -0.1), (0, -1, 0), limits
    )
    path = drone(tmp_path, parts, 1e6, (1e6, 1e6, 1e6), thrust=10.0)
    (remark,) = (r for r in read_description(path).remarks if "hinge" in r.element)
    assert remark.text == "zero is outside its limits; it starts at -0.4"
    flight = OpenLoopFlight(path)
    hinge = flight.plant.GetJointByName("hinge")
    assert hinge.get_angle(flight.context) == -0.4
    flight.fly(4.0)
    angle = hinge.get_angle(flight.context)
    deep = 0.1 * GRAVITY * 0.3 * math.cos(angle) / (LINK_MOMENT + 0.1 * 0.3**2)
    assert angle + 1.2 == pytest.approx(-deep / STOP_RATE_RAD_S**2, rel=0.01)


def test_a_follower_keeps_to_its_leader_and_flies_implicitly(tmp_path):
    """One finger of a gripper follows the other within a thousandth of its range."""
    fingers = "".join(link(name, 0.02, (0.0, y, -0.05)) for name, y in (("l", 0.02), ("r", -0.02)))
    limits = '<limit lower="-1.2" upper="1.2" effort="1" velocity="1"/>'
    parts = (
        fingers
        + joint("left", "revolute", "base", "l", (0, 0.02, -0.1), (1, 0, 0), limits)
        + joint(
            "right",
            "revolute",
            "base",
            "r",
            (0, -0.02, -0.1),
            (1, 0, 0),
            limits + '<mimic joint="left" multiplier="-1"/>',
        )
    )
    flight = OpenLoopFlight(drone(tmp_path, parts))
    flight.set("left", 0.5)
    flight.set("right", -0.5)
    _, signals = flight.fly(1.0)
    left, right = signals["joints"][:, 0], signals["joints"][:, 1]
    assert np.abs(left + right).max() < 1e-3 * 2.4
    assert np.ptp(left) > 0.3
    assert flight.simulator.get_integrator().get_target_accuracy() == STIFF_ACCURACY


def test_what_is_too_fast_for_a_step_takes_parts_of_it(tmp_path):
    """Two masses on an elastic cable, under the thrust of hover: an oscillator about m g / k.

    Its frequency is 250 rad/s, and a step of 1/128 s is short for half of that. It is that of the
    reduced mass, and begins at one and a half times its rest, so that the cable remains taut.
    """
    base, load, rate, ratio = 1.0, 0.3, 250.0, 0.01
    reduced = base * load / (base + load)
    spring, damper = reduced * rate**2, 2.0 * ratio * reduced * rate
    rest = load * GRAVITY / spring
    cable = (
        f'<cable name="c" length="0.5" stiffness="{spring}" damping="{damper}">'
        '<parent link="base"/><child link="load"/></cable>'
    )
    free = joint("free", "floating", "base", "load", (0, 0, -0.5 - 1.5 * rest))
    flight = OpenLoopFlight(drone(tmp_path, link("load", load) + free + cable, base))
    modes = flight.airframe.modes
    assert integrator_in_hover(RATES, flight.airframe.vehicle, modes) == AIR_INTEGRATOR
    time, signals = flight.fly(0.25)
    assert len(time) > 30
    damped = rate * math.sqrt(1.0 - ratio**2)
    decay, turn = 0.5 * rest * np.exp(-ratio * rate * time), damped * time
    away = rest + decay * (np.cos(turn) + ratio * rate / damped * np.sin(turn))
    speed = -decay * rate**2 / damped * np.sin(turn)
    expected = spring * away + damper * speed
    assert signals["tensions"][:, 0] == pytest.approx(expected, abs=0.01 * load * GRAVITY)


def test_a_rotor_acts_on_the_link_that_carries_it(tmp_path):
    """A rotor on an arm that tilts about x: thrust, drag torque and gyroscopic moment by hand."""
    angle, rate, speed, inertia = 0.3, 3.0, 500.0, 2e-5
    limits = '<limit lower="-1" upper="1" effort="1" velocity="1"/>'
    parts = link("arm", 0.05) + joint(
        "tilt", "revolute", "base", "arm", (ARM, -ARM, 0.0), (1, 0, 0), limits
    )
    path = Path(drone(tmp_path, parts))
    rotors = path.with_name("jointed.rotors.yaml")
    beside, on_arm = f"position: [{ARM}, {-ARM}, 0.0]", "link: arm, position: [0, 0, 0]"
    text = rotors.read_text().replace(beside, f"{on_arm}, inertia: {inertia}")
    rotors.write_text(text)
    flight = OpenLoopFlight(str(path), speeds=speed)
    flight.set("tilt", angle, rate)
    system = flight.airframe.rotors
    base, arm = system.GetOutputPort("spatial_forces").Eval(
        system.GetMyContextFromRoot(flight.root)
    )
    thrust = 1e-5 * speed**2
    axis = np.array([0.0, -math.sin(angle), math.cos(angle)])
    assert arm.body_index == flight.plant.GetFrameByName("arm").body().index()
    assert np.abs(arm.F_Bq_W.translational() - thrust * axis).max() < 1e-9
    gyroscopic = -np.cross([rate, 0.0, 0.0], inertia * speed * axis)  # it turns to the left
    assert np.abs(arm.F_Bq_W.rotational() - (gyroscopic - 0.016 * thrust * axis)).max() < 1e-9
    assert np.abs(base.F_Bq_W.translational() - [0.0, 0.0, 3.0 * thrust]).max() < 1e-9


def test_an_imu_on_a_joint_alone_is_none_for_an_estimator(tmp_path):
    parts = link("arm", 0.05) + joint("spin", "continuous", "base", "arm")
    parts += '<gazebo reference="arm"><sensor type="imu" name="imu"/></gazebo>'
    scenario = Scenario(estimator="ekf", vehicle=VehicleConfig(model=drone(tmp_path, parts)))
    with pytest.raises(WorkbenchError, match="has no IMU on a link that no joint moves, and no"):
        Session(scenario)


def test_sensors_frames_and_recordings_move_with_their_links(tmp_path):
    """An IMU on an arm that spins about z feels the joint's rate; the base link's does not."""
    rate = 2.0
    parts = link("arm", 0.05, (0.01, 0.0, 0.0)) + joint(
        "spin", "continuous", "base", "arm", (0.0, 0.0, -0.1), (0, 0, 1)
    )
    parts += "".join(
        f'<gazebo reference="{name}"><sensor type="imu" name="imu_{name}"><update_rate>128'
        "</update_rate></sensor></gazebo>"
        for name in ("arm", "base")
    )
    session = Session(
        Scenario(
            vehicle=VehicleConfig(model=drone(tmp_path, parts)),
            sensors=SensorsConfig(use=["imu_arm", "imu_base"], noise=False),
        )
    )
    plant = session._bench.airframe.plant
    context = plant.GetMyMutableContextFromRoot(session._live.simulator.get_mutable_context())
    plant.GetJointByName("spin").set_angular_rate(context, rate)
    session.tick(0.5)
    angle = plant.GetJointByName("spin").get_angle(context)
    arm, base = session.reading("imu_arm"), session.reading("imu_base")
    spin = arm.angular_velocity[2] - base.angular_velocity[2]
    assert spin == pytest.approx(rate, abs=0.01)
    assert find_imu(session.vehicle, noise=False).name == "imu_base"
    turned = session.pose("base", "arm").rotation().matrix()
    assert math.atan2(turned[1, 0], turned[0, 0]) == pytest.approx(angle, abs=1e-9)
    assert session.snapshot().joints == pytest.approx((angle, rate), abs=0.02)
    recording = session.recording()
    assert recording.joints[-1].tolist() == pytest.approx(session.snapshot().joints)
    recording.write_csv(tmp_path / "flight.csv")
    header = (tmp_path / "flight.csv").read_text().splitlines()[0]
    assert "joint.spin_q [rad]" in header
    assert "joint.spin_w [rad/s]" in header


def test_compiled_flights_refuse_joints_by_name(carrier):
    setup = make_setup(Scenario(vehicle=VehicleConfig(model=str(carrier))))
    with pytest.raises(WorkbenchError, match="string moves in flight, and compiled flights have"):
        RolloutEngine.of(setup)
    reason = why_not_compiled(setup)
    assert reason == "string moves in flight, which is not compiled"


def test_a_drone_stands_on_the_ground_with_a_cardan_joint_below(tmp_path):
    """Its chain of joints has a link between, of next to no mass: CENIC asks for some."""
    load = link("load", 0.1, (0.0, 0.0, -0.05)) + joint(
        "swing", "universal", "base", "load", (0, 0, -0.01)
    )
    path = drone(tmp_path, load, shape='<box size="0.4 0.4 0.2"/>')
    session = Session(Scenario(vehicle=VehicleConfig(model=path), start=ScenarioStart(mode="off")))
    session.tick(0.5)
    assert session.state()[6] == pytest.approx(0.1, abs=2e-3)


@pytest.mark.slow
def test_a_double_pendulum_under_a_flying_drone_moves_as_in_mujoco(tmp_path):
    """Released at 30° and -20°, five seconds, with the same rotor speeds: 1 cm and 0.5°."""
    mujoco = pytest.importorskip("mujoco", reason="install the extra `test` to try it")
    lengths, masses, inertia = (0.4, 0.3), (0.1, 0.15), 1e-4
    small = (inertia,) * 3
    parts = (
        link("upper", masses[0], (0, 0, -lengths[0]), small)
        + link("lower", masses[1], (0, 0, -lengths[1]), small)
        + joint("first", "continuous", "base", "upper", (0, 0, -0.1))
        + joint("second", "continuous", "upper", "lower", (0, 0, -lengths[0]), (1, 0, 0))
    )
    start = ScenarioStart(position=[0.0, 0.0, 20.0])
    config = VehicleConfig(model=drone(tmp_path, parts))
    rates = Rates(record_period=Rates().physics_step)
    session = Session(Scenario(vehicle=config, start=start, rates=rates))
    session.set("drag_area", 0.0)
    plant = session._bench.airframe.plant
    context = plant.GetMyMutableContextFromRoot(session._live.simulator.get_mutable_context())
    angles = math.radians(30.0), math.radians(-20.0)
    for name, angle in zip(("first", "second"), angles, strict=True):
        plant.GetJointByName(name).set_angle(context, angle)
    session.tick(5.0)
    time, signals = session._live.recorded()
    model = mujoco.MjModel.from_xml_string(f"""<mujoco>
      <compiler angle="radian"/><option timestep="1e-4" integrator="RK4" gravity="0 0 -{GRAVITY}"/>
      <worldbody><body pos="0 0 20"><freejoint/>
        <inertial pos="0 0 0" mass="1" diaginertia="0.01 0.012 0.02"/>
        <body pos="0 0 -0.1"><joint axis="0 1 0"/>
          <inertial pos="0 0 -{lengths[0]}" mass="{masses[0]}" diaginertia="1e-4 1e-4 1e-4"/>
          <body pos="0 0 -{lengths[0]}"><joint axis="1 0 0"/>
            <inertial pos="0 0 -{lengths[1]}" mass="{masses[1]}" diaginertia="1e-4 1e-4 1e-4"/>
      </body></body></body></worldbody></mujoco>""")
    data = mujoco.MjData(model)
    data.qpos[7:9] = angles
    mujoco.mj_forward(model, data)
    places = np.array([(x, y, 0.0) for x in (ARM, -ARM) for y in (ARM, -ARM)])
    turns = np.array([-1.0 if x * y > 0.0 else 1.0 for x, y, _ in places])
    for step in range(50_000):
        now = step * 1e-4
        speeds = np.array([np.interp(now, time, column) for column in signals["speeds"].T])
        thrusts = 1e-5 * speeds**2
        moment = np.cross(places, thrusts[:, None] * [0.0, 0.0, 1.0]).sum(axis=0)
        moment[2] -= 0.016 * float(turns @ thrusts)
        R = data.xmat[1].reshape(3, 3)
        data.xfrc_applied[1] = np.concatenate([R[:, 2] * thrusts.sum(), R @ moment])
        mujoco.mj_step(model, data)
    assert np.abs(signals["state"][-1, 4:7] - data.qpos[:3]).max() < 0.01
    assert np.abs(signals["joints"][-1, :2] - data.qpos[7:9]).max() < math.radians(0.5)
    assert np.ptp(signals["joints"][:, 0]) > math.radians(30.0)


TWIST, DAMPING = 1e-9, 1e-3
"""Of a light link about its length [kg m²], and of each of its joints [N m s/rad]."""


def hanging_chain(folder, links: int, load: float = 0.15):
    """Return a drone with a load on a chain of light links of 0.1 m on damped ball joints."""
    damped = f'<dynamics damping="{DAMPING}"/>'
    parts, above, place = "", "base", 0.0
    for number in range(links):
        name, last = f"link_{number}", number == links - 1
        mass, moments = (load, (2e-4, 2e-4, 2e-4)) if last else (4e-4, (3e-7, 3e-7, TWIST))
        parts += link(name, mass, (0, 0, -0.05), moments)
        parts += joint(f"ball_{number}", "ball", above, name, (0, 0, place), more=damped)
        above, place = name, -0.1
    return read_description(drone(folder, parts))


def test_a_link_hangs_as_a_pendulum_and_stands_as_an_unstable_one(tmp_path):
    """Below a base that is heavy: w² = m g l / (J + m l²), and the same growth rate above it."""
    mass, length = 0.2, 0.3
    rate = math.sqrt(mass * GRAVITY * length / (2e-4 + mass * length**2))
    for side, expected in ((-1.0, [1j * rate]), (1.0, [-rate, rate])):
        parts = link("bob", mass, (0.0, 0.0, side * length))
        parts += joint("hinge", "continuous", "base", "bob")
        path = drone(tmp_path, parts, mass=1e4, moments=(1e4, 1e4, 1e4))
        modes, _, _ = joint_study(read_description(path))
        found = sorted((mode.eigenvalue for mode in modes), key=lambda each: each.real)
        assert found == pytest.approx(expected, rel=1e-3, abs=1e-6)
        assert {mode.joint for mode in modes} == {"hinge"}


def test_a_follower_moves_along_or_opposite_and_the_base_with_it_or_not(tmp_path):
    """Two sliders of m on a base of M and one spring k: together w² = k (1 / 2m + 1 / M), and
    opposite k / 2m, as the base then stays."""
    mass, base, spring = 0.2, 1.0, 40.0
    limit = '<limit lower="-1" upper="1" effort="100" velocity="100"/>'
    for multiplier, rate in (
        (1.0, math.sqrt(spring * (0.5 / mass + 1.0 / base))),
        (-1.0, math.sqrt(spring * 0.5 / mass)),
    ):
        follows = f'{limit}<mimic joint="lead" multiplier="{multiplier}"/>'
        parts = link("one", mass) + link("other", mass)
        parts += joint("lead", "prismatic", "base", "one", axis=(1, 0, 0), more=limit)
        parts += joint("tail", "prismatic", "base", "other", axis=(1, 0, 0), more=follows)
        description = read_description(drone(tmp_path, parts, mass=base))
        plant, _ = add_plant(DiagramBuilder(), description.undrawn(), time_step=0.0)
        rows = joint_rows(plant, merged_model(description.model, "base"))
        assert [row.name for row in rows] == ["lead", "tail"]
        held = tuple(row._replace(stiffness=spring if row.name == "lead" else 0.0) for row in rows)
        slowest = min(joint_modes(plant, held), key=lambda mode: mode.rate)
        assert slowest.eigenvalue.imag == pytest.approx(rate, rel=0.02)


def test_ball_joints_have_modes_and_choose_the_integrator(tmp_path):
    """A light link between base and load twists against both dampers: I w' = -2 D w."""
    modes, _, _ = joint_study(hanging_chain(tmp_path, 2))
    assert modes[0].joint in ("ball_0", "ball_1")
    assert modes[0].eigenvalue == pytest.approx(-2.0 * DAMPING / TWIST, rel=1e-4)
    # the load's pendulum on the chain, much slower
    assert min(mode.rate for mode in modes if mode.rate > 1.0) < 20.0


def test_a_chain_of_light_links_swings_for_its_law_and_flies(tmp_path):
    """Each joint is strongly damped for the link below, and the chain as a whole is not.

    About x and y the law steers the base alone: the chain pulls at its centre of mass.
    """
    description = hanging_chain(tmp_path, 6)
    vehicle = make_vehicle(description)
    assert vehicle.inertia[0, 0] > 0.03
    assert np.diagonal(vehicle.turned.I_BBcm_B)[:2] == pytest.approx([0.01, 0.012], rel=0.02)
    scenario = Scenario(
        vehicle=VehicleConfig(model=str(description.source)),
        start=ScenarioStart(position=[0.0, 0.0, 20.0]),
    )
    session = Session(scenario)
    session.do(Action(velocity=[1.0, 0.0, 0.0]))
    session.tick(0.125)
    assert np.isfinite(session.state()).all()
    assert 0.0 < session.state()[10] < 1.0


def test_rotors_on_links_with_axes_of_their_own_make_the_wrench_that_the_law_knows(tmp_path):
    """In hover they carry the weight at the centre of mass, however the frames of links are turned.

    The link of two rotors is rolled by 90 degrees and yawed, their axis is its y.
    """
    origin = '<origin xyz="0.1 0.05 -0.05" rpy="-1.5707963267948966 0 0.8"/>'
    limits = '<limit lower="0" upper="1" effort="1" velocity="1"/>'
    hinge = joint("hinge", "revolute", "base", "arm", axis=(1, 0, 0), more=limits)
    parts = link("arm", 0.3) + hinge.replace('<origin xyz="0 0 0"/>', origin)
    path = Path(drone(tmp_path, parts))
    beside = path.with_name("jointed.rotors.yaml")
    text = beside.read_text()
    X_BL = RigidTransform(RollPitchYaw(-0.5 * math.pi, 0.0, 0.8), [0.1, 0.05, -0.05])
    for number, y in ((0, ARM), (1, -ARM)):
        place = X_BL.inverse() @ np.array([ARM, y, 0.0])
        axis = X_BL.rotation().inverse() @ np.array([0.0, 0.0, 1.0])
        text = text.replace(
            f"name: r{number}, position: [{ARM}, {y}, 0.0]",
            f"name: r{number}, link: arm, axis: {axis.tolist()}, position: {place.tolist()}",
        )
    beside.write_text(text)
    scenario = Scenario(vehicle=VehicleConfig(model=str(path)))
    session = Session(scenario)
    airframe, root = session._bench.airframe, session._live.root
    plant, context = airframe.plant, airframe.plant.GetMyContextFromRoot(root)
    rotors = airframe.rotors
    assert len(rotors.bodies) == 2
    forces = rotors.GetOutputPort("spatial_forces").Eval(rotors.GetMyContextFromRoot(root))
    centre = plant.CalcCenterOfMassPositionInWorld(context)
    force, moment = np.zeros(3), np.zeros(3)
    for each in forces:
        X_WL = plant.EvalBodyPoseInWorld(context, plant.get_body(each.body_index))
        arm = X_WL @ each.p_BoBq_B - centre
        force += each.F_Bq_W.translational()
        moment += each.F_Bq_W.rotational() + np.cross(arm, each.F_Bq_W.translational())
    weight = plant.CalcTotalMass(context) * GRAVITY
    assert force == pytest.approx([0.0, 0.0, weight], abs=1e-6 * weight)
    assert moment == pytest.approx(np.zeros(3), abs=1e-6 * weight)
