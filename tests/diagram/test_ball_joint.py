"""A drone with a load on a string: its plant has a ball joint; its session is like any other."""

import math

import numpy as np
import pytest

from workbench.plant.description import read_description
from workbench.plant.loading import make_vehicle
from workbench.plant.reach import reach
from workbench.scenario.scenario import Scenario, Start, VehicleConfig
from workbench.session.session import Session

MASS, LOAD, LENGTH, RADIUS = 30.0, 0.1, 0.8, 0.05
ROTOR = """
    <plugin filename="gz-sim-multicopter-motor-model-system" name="m{i}">
      <jointName>j{i}</jointName><linkName>r{i}</linkName><motorNumber>{i}</motorNumber>
      <turningDirection>{turn}</turningDirection><motorConstant>2e-4</motorConstant>
      <momentConstant>0.02</momentConstant><maxRotVelocity>1000</maxRotVelocity>
      <timeConstantUp>0.02</timeConstantUp><timeConstantDown>0.02</timeConstantDown></plugin>
    <link name="r{i}"><pose>{x} {y} 0.05 0 0 0</pose>
      <inertial><mass>0.01</mass><inertia><ixx>1e-5</ixx><iyy>1e-5</iyy><izz>2e-5</izz></inertia>
      </inertial></link>
    <joint name="j{i}" type="continuous"><parent>body</parent><child>r{i}</child>
      <axis><xyz>0 0 1</xyz></axis></joint>"""
PLACES = ((0.5, 0.5), (-0.5, 0.5), (-0.5, -0.5), (0.5, -0.5))
SDF = f"""<?xml version="1.0"?>
<sdf version="1.9"><model name="carrier">
    <link name="body"><inertial><mass>{MASS}</mass>
      <inertia><ixx>2.0</ixx><iyy>2.0</iyy><izz>3.0</izz></inertia></inertial></link>
    <link name="load"><pose>0 0 {-LENGTH} 0 0 0</pose><inertial><mass>{LOAD}</mass>
      <inertia><ixx>{0.4 * LOAD * RADIUS**2}</ixx><iyy>{0.4 * LOAD * RADIUS**2}</iyy>
        <izz>{0.4 * LOAD * RADIUS**2}</izz></inertia></inertial>
      <collision name="ball"><geometry><sphere><radius>{RADIUS}</radius></sphere></geometry>
      </collision></link>
    <joint name="string" type="ball"><pose>0 0 {LENGTH} 0 0 0</pose>
      <parent>body</parent><child>load</child></joint>
    {
    "".join(
        ROTOR.format(i=i, x=x, y=y, turn=("ccw", "ccw", "cw", "cw")[i])
        for i, (x, y) in ((0, PLACES[0]), (1, PLACES[2]), (2, PLACES[1]), (3, PLACES[3]))
    )
}
</model></sdf>"""


@pytest.fixture(scope="module")
def carrier(tmp_path_factory):
    """Return the description's path."""
    path = tmp_path_factory.mktemp("carrier") / "carrier.sdf"
    path.write_text(SDF)
    return path


@pytest.fixture
def scenario(carrier):
    """Return a hover high above the ground."""
    return Scenario(
        vehicle=VehicleConfig(model=str(carrier)), start=Start(position=[0.0, 0.0, 10.0])
    )


def pull(session, angle: float) -> None:
    """Turn the string about x by an angle [rad]."""
    plant = session._bench.airframe.plant
    context = plant.GetMyMutableContextFromRoot(session._live.simulator.get_mutable_context())
    plant.GetJointByName("string").set_angles(context, [angle, 0.0, 0.0])


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
    rises = np.flatnonzero((angle[:-1] < 0.0) & (angle[1:] >= 0.0))
    crossed = time[rises] - angle[rises] * (time[rises + 1] - time[rises]) / (
        angle[rises + 1] - angle[rises]
    )
    inertia = LOAD * LENGTH**2 + 0.4 * LOAD * RADIUS**2
    expected = 2.0 * math.pi * math.sqrt(inertia / (LOAD * 9.81 * LENGTH))
    assert len(crossed) >= 4
    assert np.diff(crossed).mean() == pytest.approx(expected, rel=0.005)
    assert np.abs(session.state()[4:7] - [0.0, 0.0, 10.0]).max() < 0.01


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
    (remark,) = (each for each in description.remarks if "string" in each.element)
    assert "moves freely" in remark.text
    around = reach(description.model, "body", description.rotors)
    highest = around.p_BC[2]  # the string turned upwards, and the ball beyond it
    assert around.radius == pytest.approx(abs(highest) + LENGTH + RADIUS)
