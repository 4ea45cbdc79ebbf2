"""Drones of every layout fly at once, on the gains that the rule gives them.

Those in `drones` are written for these tests; published ones are read where they are at hand.
"""

import math
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np
import pytest
from pydrake.systems.primitives import Linearize

from tests.installed import readable
from workbench.control.guidance import Guidance
from workbench.control.mode import FlightMode
from workbench.controllers.pd_rule import thrust_to_weight
from workbench.design.hover_check import check_hover
from workbench.diagram.core import make_flight_core
from workbench.gains.gain_choice import choose_gains
from workbench.plant.description import read_description
from workbench.plant.loading import make_vehicle
from workbench.plant.thrust_frame import thrust_frame
from workbench.scenario.scenario import Action, Scenario, ScenarioStart, VehicleConfig
from workbench.session.session import Session
from workbench.setup import make_setup

HERE = Path(__file__).parent
HEIGHT = 10.0
LEAST_DAMPING = 0.5


@dataclass(frozen=True)
class Drone:
    """A drone of the tests, and what its file says of it; angles in degrees."""

    name: str
    mass: float
    rotors: int
    thrust_to_weight: float
    com: tuple[float, float, float] = (0.0, 0.0, 0.0)
    lean: float = 0.0
    args: dict[str, str] = field(default_factory=dict)

    def __str__(self) -> str:
        return "-".join([self.name, *self.args])

    @property
    def path(self) -> Path:
        return HERE / "drones" / f"{self.name}.urdf.xacro"

    @property
    def config(self) -> VehicleConfig:
        return VehicleConfig(model=str(self.path), args=dict(self.args))

    def read(self):
        description = read_description(self.path, self.args)
        return description, make_vehicle(description)


UPRIGHT = 4 * 8.0 / (1.5 * 9.81)
"""Thrust-to-weight of the 1.5 kg quadrotor: 8 N a rotor."""
INWARD = UPRIGHT * math.cos(math.radians(10.0))
AHEAD = 0.23 / math.sqrt(2.0)
"""Its rotors are so far ahead of the middle, and behind it [m]."""
FORWARD = UPRIGHT / (1.0 + 0.03 * math.tan(math.radians(5.0)) / AHEAD)
"""Leaning 3 cm above the centre of mass, they pitch it: one pair must carry more."""
BESIDE = UPRIGHT / (1.0 + 0.01 / AHEAD)
"""With the centre of mass 1 cm ahead, the front pair carries more."""
REAR = 8.0 / (0.5 * 0.22 / 0.38 * 1.7 * 9.81)
"""Of the H frame: rear rotors 16 cm behind carry more than front ones 22 cm ahead."""
DRONES = (
    Drone("palm_quad", 0.03, 4, 4 * 2.2e-8 * 2700**2 / (0.03 * 9.81)),
    Drone("h_quad", 1.7, 4, REAR),
    Drone("tilted_quad", 1.5, 4, INWARD),
    Drone("tilted_quad", 1.5, 4, INWARD, args={"sideways": "10", "inward": "0"}),
    Drone("tilted_quad", 1.5, 4, FORWARD, lean=5.0, args={"forward": "5"}),
    Drone("high_mass_quad", 1.5, 4, UPRIGHT, com=(0.0, 0.0, 0.08)),
    Drone("low_mass_quad", 1.5, 4, BESIDE, com=(0.01, 0.0, -0.08)),
    Drone("feet_quad", 1.5, 4, UPRIGHT, com=(0.0, 0.0, 0.2)),
    Drone("sluggish_quad", 12.0, 4, 1.3),
    Drone("hexacopter", 8.0, 6, 6 * 7e-5 * 600**2 / (8.0 * 9.81)),
    Drone("octocopter", 5.0, 8, 8 * 1.8e-5 * 850**2 / (5.0 * 9.81)),
    Drone("coaxial_x8", 6.0, 8, 8 * 2e-5 * 900**2 / (6.0 * 9.81)),
)
ODD = [d for d in DRONES if d.lean or any(d.com) or d.name in ("sluggish_quad", "coaxial_x8")]
each_drone = pytest.mark.parametrize("drone", DRONES, ids=str)


def flown_drones(drones):
    """Return drones; flights of all but the strangest are slow tests."""
    strangest = ("tilted_quad-forward",)
    return [
        drone if str(drone) in strangest else pytest.param(drone, marks=pytest.mark.slow)
        for drone in drones
    ]


SHARED = HERE.parent / "../shared/models"
PUBLISHED = {
    "rotors_description/urdf/hummingbird_base.xacro": {
        "namespace": "hummingbird",
        "enable_mavlink_interface": "false",
        "enable_ground_truth": "true",
        "enable_logging": "false",
        "log_file": "hummingbird",
        "wait_to_record_bag": "false",
    },
    "rotors_description/urdf/hummingbird.xacro": {"namespace": "hummingbird"},
    "gym_pybullet_drones/cf2x.urdf": {},
    "px4_gazebo_models/x500/model.sdf": {},
}


def flown(config: VehicleConfig, **scenario):
    session = Session(Scenario(vehicle=config, **scenario))
    session.run()
    return session.recording()


def missed(config: VehicleConfig) -> list[str]:
    report = check_hover(Scenario(vehicle=config))
    return [str(demand) for demand in report.demands if not demand.met]


@each_drone
def test_it_is_understood_as_it_was_written(drone):
    _, vehicle = drone.read()
    frame = thrust_frame(vehicle)
    assert vehicle.mass == pytest.approx(drone.mass)
    assert len(vehicle.rotors) == drone.rotors
    assert vehicle.p_BoBcm_B == pytest.approx(drone.com, abs=1e-9)
    assert thrust_to_weight(frame) == pytest.approx(drone.thrust_to_weight, rel=1e-6)
    assert math.degrees(math.acos(min(1.0, frame.R_BT[2, 2]))) == pytest.approx(drone.lean)
    assert {gain.origin for gain in choose_gains(vehicle).values()} == {"default", "rule"}


@pytest.mark.slow
@pytest.mark.parametrize("drone", flown_drones(DRONES), ids=str)
def test_it_hovers_and_answers_steps(drone):
    assert missed(drone.config) == []


@each_drone
def test_its_linear_model_is_stable_and_damped(drone):
    """Exact, of the continuous core in hover with its place held; yaw itself is nobody's to hold.

    The quaternion's length and yaw are the two modes that stay where they are.
    """
    description, vehicle = drone.read()
    core = make_flight_core(make_setup(description=description, vehicle=vehicle))
    root = core.CreateDefaultContext()
    hold = Guidance(1.0, 1.0, 1.0, 0.0, 1.0, 1.0, 0.0, 0.0, HEIGHT)
    core.GetInputPort("reference").FixValue(root, np.zeros(8))
    core.GetInputPort("guidance").FixValue(root, np.array(hold))
    half = 0.5 * math.radians(drone.lean)  # body z leans back where the rotors lean forward
    q_WB = [math.cos(half), 0.0, -math.sin(half), 0.0]
    speeds = thrust_frame(vehicle).hover_speeds
    root.SetContinuousState([*q_WB, 0.0, 0.0, HEIGHT, *[0.0] * 6, *speeds, 0.0, 0.0, 0.0])
    assert np.abs(core.EvalTimeDerivatives(root).CopyToVector()).max() < 1e-9
    reference = core.GetInputPort("reference").get_index()
    modes = np.linalg.eigvals(
        Linearize(core, root, reference, core.GetOutputPort("state").get_index()).A()
    )
    still = np.abs(modes) < 1e-6
    assert still.sum() == 2
    moving = modes[~still]
    assert moving.real.max() < 0.0
    assert (-moving.real / np.abs(moving)).min() >= LEAST_DAMPING


@pytest.mark.parametrize("drone", flown_drones(ODD), ids=str)
def test_it_takes_off_and_lands(drone):
    script = [
        Action(at=0.0, request="take_off", height=1.2),
        Action(at=4.5, request="land"),
    ]
    flight = flown(drone.config, duration=11.0, start=ScenarioStart(mode="off"), script=script)
    up = flight.between(4.0, 4.5)
    assert up.p_WB[:, 2] == pytest.approx(np.full(len(up.time), 1.2), abs=0.1)
    assert flight.mode[-1] == FlightMode.OFF
    assert flight.tilt[-1] < math.radians(2.0)
    assert np.hypot(*flight.p_WB[-1, :2]) < 0.25


def test_rotors_that_lean_forward_hover_leaning_back():
    drone = next(drone for drone in DRONES if drone.lean)
    flight = flown(drone.config, duration=2.0)
    assert flight.z_axis_W[0] == pytest.approx(
        [-math.sin(math.radians(5.0)), 0.0, math.cos(math.radians(5.0))]
    )
    assert np.abs(flight.p_WB - flight.p_WB[0]).max() < 1e-6
    turned = flown(drone.config, duration=2.0, start=ScenarioStart(roll_pitch_yaw=[0.0, 0.0, 1.5]))
    assert turned.tilt[0] == pytest.approx(math.radians(5.0))
    assert np.abs(turned.p_WB - turned.p_WB[0]).max() < 1e-6


@pytest.mark.slow
def test_height_is_kept_at_full_speed_with_little_thrust_to_spare():
    drone = next(drone for drone in DRONES if drone.name == "sluggish_quad")
    flight = flown(
        drone.config,
        duration=14.0,
        start=ScenarioStart(position=[0.0, 0.0, HEIGHT]),
        script=[
            Action(at=0.5, velocity=[8.0, 0.0, 0.0]),
            Action(at=8.0, velocity=[0.0, 0.0, 0.0]),
        ],
    )
    assert np.abs(flight.p_WB[:, 2] - HEIGHT).max() < 0.5
    assert flight.v_WB[:, 0].max() == pytest.approx(8.0, rel=0.05)


@pytest.mark.slow
@pytest.mark.parametrize("path", readable(PUBLISHED))
def test_a_published_description_hovers_and_answers_steps(path):
    if not SHARED.is_dir():
        pytest.skip("put the published descriptions into ../shared/models to try them")
    assert missed(VehicleConfig(model=str(SHARED / path), args=PUBLISHED[path])) == []
