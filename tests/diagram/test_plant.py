"""Drake's plant in the flown diagram: it owns the state, and touches the ground as by hand."""

import math

import numpy as np
import pytest
from pydrake.multibody.plant import CoulombFriction, MultibodyPlant
from pydrake.systems.analysis import Simulator
from pydrake.systems.primitives import ConstantVectorSource

from workbench.diagram.core import make_open_loop
from workbench.plant.description import read_description
from workbench.plant.gravity import GRAVITY
from workbench.plant.worlds import geometry
from workbench.scenario.scenario import Rates, Scenario
from workbench.session.integration import Integration
from workbench.session.session import Session
from workbench.setup import make_setup

FRICTION = 0.6
GROUND = FRICTION / (2.0 - FRICTION)
"""With this coefficient of the ground, Drake's combination with the feet's 1 is FRICTION."""
HALF_TRACK, FOOT, HEIGHT = 0.17, 0.02, 0.12
"""Of the sledge below [m]: friction does not tip it, as FRICTION HEIGHT is below HALF_TRACK."""
MASS = 1.2
RATES = Rates()


def sledge(tmp_path, flat: bool = False) -> str:
    """Write a quadrotor on four feet, or on a flat box, and return its path."""
    corners = [(x, y) for x in (HALF_TRACK, -HALF_TRACK) for y in (HALF_TRACK, -HALF_TRACK)]
    feet = "".join(
        f'<collision><origin xyz="{x} {y} {FOOT - HEIGHT}"/>'
        f'<geometry><sphere radius="{FOOT}"/></geometry></collision>'
        for x, y in corners
    )
    if flat:
        size = f"{2 * HALF_TRACK} {2 * HALF_TRACK} {2 * HEIGHT}"
        feet = f'<collision><geometry><box size="{size}"/></geometry></collision>'
    joints = "".join(
        f'<link name="rotor_{i}"><inertial><mass value="1e-6"/>'
        '<inertia ixx="1e-12" iyy="1e-12" izz="1e-12" ixy="0" ixz="0" iyz="0"/></inertial></link>'
        f'<joint name="rotor_{i}" type="continuous"><parent link="base_link"/>'
        f'<child link="rotor_{i}"/><origin xyz="{x} {y} 0"/><axis xyz="0 0 1"/></joint>'
        for i, (x, y) in enumerate(corners)
    )
    path = tmp_path / "sledge.urdf"
    path.write_text(
        f'<robot name="sledge"><link name="base_link"><inertial><mass value="{MASS}"/>'
        '<inertia ixx="0.012" iyy="0.012" izz="0.02" ixy="0" ixz="0" iyz="0"/></inertial>'
        f"{feet}</link>{joints}</robot>"
    )
    rows = "".join(
        f"  - {{joint: rotor_{i}, direction: {'ccw' if x * y < 0 else 'cw'}}}\n"
        for i, (x, y) in enumerate(corners)
    )
    path.with_name("sledge.rotors.yaml").write_text(
        "defaults: {motor_constant: 8.0e-06, moment_constant: 0.016, max_rot_velocity: 1000.0,\n"
        "  time_constant_up: 0.0125, time_constant_down: 0.025}\n"
        f"rotors:\n{rows}"
    )
    return str(path)


class Dropped:
    """A vehicle without thrust and drag."""

    def __init__(self, path: str, world: str = "empty") -> None:
        scenario = Scenario(rates=RATES, world=world)
        setup = make_setup(scenario, description=read_description(path))
        self.vehicle = setup.vehicle
        still = ConstantVectorSource(np.zeros(len(self.vehicle.rotors)))
        diagram, self.airframe, _ = make_open_loop(setup, still)
        self.simulator = Simulator(diagram)
        self.root = self.simulator.get_mutable_context()
        forces = self.airframe.body_forces.GetMyMutableContextFromRoot(self.root)
        forces.get_mutable_numeric_parameter(0).SetFromVector([0.0, 0.0])
        self._integration = Integration(self.simulator, self.airframe, RATES)

    def fly(self, state, duration) -> np.ndarray:
        """Return the states at 64 Hz (N, 13) from a state (13) on, and keep `energies` [J]."""
        self.airframe.place(self.root, np.array(state), np.zeros(len(self.vehicle.rotors)))
        found, self.energies = [], []
        for number in range(1, round(64 * duration) + 1):
            self._integration.advance(number * 16)
            found.append(self.airframe.body_state(self.root))
            plant = self.airframe.plant
            context = plant.GetMyContextFromRoot(self.root)
            parts = plant.EvalKineticEnergy(context), plant.EvalPotentialEnergy(context)
            self.energies.append(sum(parts))
        return np.array(found)


def energy(states: np.ndarray, inertia: np.ndarray) -> np.ndarray:
    """Return kinetic and potential energy [J]; the body is nearly a sphere to its inertia."""
    turning = 0.5 * inertia.max() * (states[:, 7:10] ** 2).sum(axis=1)
    moving = 0.5 * MASS * (states[:, 10:13] ** 2).sum(axis=1)
    return turning + moving + MASS * GRAVITY * states[:, 6]


def test_drakes_plant_is_one_of_the_systems_and_owns_the_state():
    session = Session(Scenario())
    systems = {each.get_name(): each for each in session.diagram.GetSystems()}
    plant = systems["plant"]
    assert isinstance(plant, MultibodyPlant) and plant.time_step() == 0.0
    assert {"rotors", "body_forces", "wind", "push", "flight_imu", "controller"} <= set(systems)
    states = {name: each.num_continuous_states() for name, each in systems.items()}
    assert {name: count for name, count in states.items() if count} == {"plant": 13, "rotors": 4}


def test_a_mass_that_changes_in_the_context_changes_the_flight():
    """By hand: the thrust of hover accelerates 1.25 times the mass by g / 1.25 - g.

    It does so until commands change: those of the first period are of hover.
    """
    session = Session(Scenario())
    airframe, root = session._bench.airframe, session._live.simulator.get_mutable_context()
    context = airframe.plant.GetMyMutableContextFromRoot(root)
    airframe.body.SetMass(context, 1.25 * session.vehicle.mass)
    session.tick(RATES.control_period)
    sinking = (GRAVITY / 1.25 - GRAVITY) * RATES.control_period
    assert session.state()[12] == pytest.approx(sinking, rel=1e-6)  # the rest is drag


@pytest.mark.slow
@pytest.mark.parametrize("flat", [False, True])
@pytest.mark.parametrize(("speed", "sink"), [(2.0, 0.0), (4.0, 0.0), (8.0, 0.0), (2.0, 0.5)])
def test_a_sliding_touch_down_stops_where_friction_says(tmp_path, monkeypatch, speed, sink, flat):
    """By hand: the shock of a sink rate w takes µ w, then friction stops it in v² / 2µg."""
    monkeypatch.setattr(geometry, "CoulombFriction", lambda *_: CoulombFriction(GROUND, GROUND))
    flown = Dropped(sledge(tmp_path, flat))
    start = [1.0, *[0.0] * 5, HEIGHT, 0.0, 0.0, 0.0, speed, 0.0, -sink]
    states = flown.fly(start, 2.5)
    wanted = (speed - FRICTION * sink) ** 2 / (2.0 * FRICTION * GRAVITY)
    assert states[-1, 4] == pytest.approx(wanted, rel=0.05)
    assert np.abs(states[-1, 7:]).max() < 1e-3
    if sink == 0.0:
        assert states[:, 6].max() < HEIGHT + 1e-3


@pytest.mark.slow
@pytest.mark.parametrize("flat", [False, True])
def test_what_tumbles_over_the_ground_loses_energy_and_comes_to_rest(tmp_path, flat):
    flown = Dropped(sledge(tmp_path, flat))
    states = flown.fly([0.9, 0.3, -0.2, 0.1, 0.0, 0.0, 1.0, 9.0, -7.0, 15.0, 3.0, -1.0, 0.0], 5.0)
    assert (states[:, 6] < 0.3).any()
    moments = flown.vehicle.inertia
    least = energy(states, moments)
    assert (np.diff(least) < 0.05 * least[0]).all()  # as its moments of inertia differ
    assert least[-1] < 0.2 * least[0]
    assert np.abs(states[-1, 7:]).max() < 1e-3


SLOPE = """obstacles:
- {name: slope, shape: {box: [4, 4, 0.2]}, position: [0, 0, 0.6], roll_pitch_yaw: [0, 0.17, 0]}
"""
WEDGE = """obstacles:
- {name: left, shape: {box: [1, 2, 0.6]}, position: [-0.65, 0, 0.3], roll_pitch_yaw: [0, 0.35, 0]}
- {name: right, shape: {box: [1, 2, 0.6]}, position: [0.65, 0, 0.3], roll_pitch_yaw: [0, -0.35, 0]}
"""


@pytest.mark.parametrize(
    ("shapes", "least"),
    [
        pytest.param(SLOPE, 0.7, id="slope"),
        pytest.param(WEDGE, 0.2, id="wedge", marks=pytest.mark.slow),
    ],
)
def test_dropped_on_a_slope_or_between_boxes_it_comes_to_rest_there(tmp_path, shapes, least):
    """What it falls onto gives back what it has stored of the shock, and no more."""
    (tmp_path / "world.yaml").write_text(shapes)
    flown = Dropped(sledge(tmp_path), str(tmp_path / "world.yaml"))
    states = flown.fly([1.0, *[0.0] * 5, 1.0, *[0.0] * 6], 3.0)
    assert np.abs(states[-1, 7:]).max() < 1e-3
    assert states[-1, 6] > least
    assert max(flown.energies) < (1.0 + 1e-9) * flown.energies[0]


def test_a_free_body_keeps_energy_and_angular_momentum(tmp_path):
    flown = Dropped(sledge(tmp_path))
    w = np.array([9.0, 9.0, 12.0])
    assert np.linalg.norm(w) == pytest.approx(17.5, abs=0.01)
    states = flown.fly([1.0, *[0.0] * 5, 500.0, *w, 0.0, 0.0, 0.0], 5.0)
    inertia = flown.vehicle.inertia
    momentum, turning = [], []
    for state in states:
        q_w, q_x, q_y, q_z = state[:4] / np.linalg.norm(state[:4])
        R = np.array(
            [
                [
                    1 - 2 * (q_y**2 + q_z**2),
                    2 * (q_x * q_y - q_w * q_z),
                    2 * (q_x * q_z + q_w * q_y),
                ],
                [
                    2 * (q_x * q_y + q_w * q_z),
                    1 - 2 * (q_x**2 + q_z**2),
                    2 * (q_y * q_z - q_w * q_x),
                ],
                [
                    2 * (q_x * q_z - q_w * q_y),
                    2 * (q_y * q_z + q_w * q_x),
                    1 - 2 * (q_x**2 + q_y**2),
                ],
            ]
        )
        L = R @ inertia @ R.T @ state[7:10]
        momentum.append(L)
        turning.append(0.5 * state[7:10] @ L)
    size = np.linalg.norm(momentum[0])
    assert np.abs(np.array(momentum) - momentum[0]).max() < 1e-6 * size
    assert np.ptp(turning) < 1e-6 * turning[0]
    assert math.isclose(states[-1, 12], -GRAVITY * 5.0, rel_tol=1e-9)
