"""Ball joints that turn over the top, where roll, pitch and yaw have no rates."""

import math

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from tests.diagram.test_joints import OpenLoopFlight
from tests.jointed import drone, joint, link
from workbench.common.errors import FlightBrokenError
from workbench.plant.gravity import GRAVITY
from workbench.scenario.scenario import Scenario, ScenarioStart, VehicleConfig
from workbench.session.session import Session

LOAD, LENGTH, MOMENT, STIFFNESS = 0.1, 0.8, 0.02, 0.4
SPRING = f'<dynamics stiffness="{STIFFNESS}"/>'


def hung(folder, more: str = "", base: float = 1e6) -> str:
    """Return a drone with a load on a ball joint; a base of 1e6 kg clamps it."""
    parts = link("load", LOAD, (0.0, 0.0, -LENGTH), (MOMENT,) * 3)
    parts += joint("string", "ball", "base", "load", more=more)
    return drone(folder, parts, base, (base,) * 3, thrust=1e-5 * base)


def throw(flight: OpenLoopFlight, angles, rates) -> None:
    """Turn the load to roll, pitch and yaw, and let it turn at rates [rad/s]."""
    string = flight.plant.GetJointByName("string")
    string.set_angles(flight.context, angles)
    string.set_angular_velocity(flight.context, rates)


@pytest.mark.parametrize(
    ("more", "angles", "rates"),
    [
        ("", (0.0, 0.3, 0.0), (0.4, 9.0, 1.0)),
        # through a pitch of 90° in its plane, and with a spring
        pytest.param("", (0.0, 0.3, 0.0), (0.0, 9.0, 0.0), marks=pytest.mark.slow),
        pytest.param(SPRING, (0.4, 1.5, 1.0), (0.4, 1.0, 2.0), marks=pytest.mark.slow),
    ],
)
def test_a_load_that_is_thrown_over_the_top_moves_as_in_mujoco(tmp_path, more, angles, rates):
    """For five seconds, in which it turns up to six times; it keeps its energy without a spring."""
    mujoco = pytest.importorskip("mujoco", reason="install the extra `test` to try it")
    flight = OpenLoopFlight(hung(tmp_path, more))
    throw(flight, angles, rates)
    time, signals = flight.fly(5.0)
    spring = f'stiffness="{STIFFNESS}"' if more else ""
    model = mujoco.MjModel.from_xml_string(f"""<mujoco>
      <option timestep="{2.0**-12}" integrator="RK4" gravity="0 0 -{GRAVITY}"/>
      <worldbody><body><joint type="ball" {spring}/>
        <inertial pos="0 0 -{LENGTH}" mass="{LOAD}" diaginertia="{MOMENT} {MOMENT} {MOMENT}"/>
      </body></worldbody></mujoco>""")
    data = mujoco.MjData(model)
    start = Rotation.from_euler("xyz", angles)
    data.qpos[:] = start.as_quat(scalar_first=True)
    data.qvel[:] = start.inv().apply(rates)  # in the child
    joints = signals["joints"]
    turned = Rotation.from_euler("xyz", joints[:, :3])
    worst = 0.0
    for now, R in zip(time, turned, strict=True):
        while data.time < now:
            mujoco.mj_step(model, data)
        expected = Rotation.from_quat(data.qpos, scalar_first=True)
        worst = max(worst, (R.inv() * expected).magnitude())
    assert worst < 1e-5
    assert math.radians(80.0) < np.abs(joints[:, 1]).max() <= math.radians(90.0)
    base = flight.plant.GetFrameByName("base")
    child = flight.plant.GetFrameByName("load").CalcRotationMatrix(flight.context, base)
    assert (turned[-1].inv() * Rotation.from_matrix(child.matrix())).magnitude() < 1e-7
    if not more:
        w, axis = joints[:, 3:6], turned.as_matrix()[:, :, 2]
        along = (w * axis).sum(axis=1) ** 2
        across = (w**2).sum(axis=1) - along
        moving = 0.5 * (MOMENT + LOAD * LENGTH**2) * across + 0.5 * MOMENT * along
        energy = moving - LOAD * GRAVITY * LENGTH * axis[:, 2]
        assert np.ptp(energy) < 1e-6 * LOAD * GRAVITY * LENGTH


def test_slices_and_a_checkpoint_fly_the_same_over_the_top(tmp_path):
    scenario = Scenario(
        vehicle=VehicleConfig(model=hung(tmp_path, base=30.0)),
        start=ScenarioStart(position=[0.0, 0.0, 10.0]),
    )
    whole, sliced, continued = Session(scenario), Session(scenario), Session(scenario)
    for session in (whole, sliced):
        plant = session._bench.airframe.plant
        root = session._live.simulator.get_mutable_context()
        string = plant.GetJointByName("string")
        string.set_angular_velocity(plant.GetMyMutableContextFromRoot(root), [0.3, 9.0, 0.0])
    whole.tick(0.5)
    checkpoint = whole.checkpoint()
    whole.tick(0.5)
    for _ in range(32):
        sliced.tick(1 / 32)
    assert sliced.snapshot().joints == whole.snapshot().joints
    continued.begin_from(checkpoint)
    continued.tick(0.5)
    assert continued.snapshot().joints == whole.snapshot().joints
    assert continued.state().tolist() == whole.state().tolist()


def test_one_that_turns_too_fast_ends_the_flight_with_a_sentence(tmp_path):
    flight = OpenLoopFlight(hung(tmp_path))
    throw(flight, (0.0, 0.0, 0.0), (90.0, 110.0, 0.0))
    with pytest.raises(FlightBrokenError, match=r"ball joint 'string' turns by more than 60° in"):
        flight.fly(0.25)


@pytest.mark.parametrize("kind", ["ball", "floating"])
@pytest.mark.parametrize("word", ["frame", "turned"])
def test_a_link_may_have_any_name_beside_a_loose_joint(tmp_path, kind, word):
    """The plant's own frames have other names than a body, and than a link that is none."""
    parts = link("load", LOAD, (0.0, 0.0, -LENGTH), (MOMENT,) * 3)
    parts += joint("string", kind, "base", "load")
    parts += link(f"string_{word}", 0.01) + joint("arm", "continuous", "base", f"string_{word}")
    parts += f'<link name="string_{word}_2"/>'
    parts += joint("fixed", "fixed", "load", f"string_{word}_2")
    if kind == "floating":
        ends = '<parent link="base"/><child link="load"/>'
        parts += f'<cable name="rope" length="{LENGTH}">{ends}</cable>'
    session = Session(Scenario(vehicle=VehicleConfig(model=drone(tmp_path, parts))))
    session.tick(0.05)
    assert session.time == pytest.approx(0.05, abs=0.01)
