"""Oracle: the same steps on the full diagram."""

from pathlib import Path

import numpy as np
import pytest

from workbench.control.controller import load_controller
from workbench.design.rollout.engine import RolloutEngine
from workbench.design.step_response import EDGE, START_HEIGHT, fly_step
from workbench.plant.variation import Variation
from workbench.scenario.configured import configured_vehicle
from workbench.scenario.parameters import parameter_table
from workbench.scenario.scenario import Rates, Scenario, Start, VehicleConfig
from workbench.session.recording import Recording
from workbench.session.session import Session

DURATION = 1.0
CLOSE = 1e-9
"""[m/s]"""
TESTS = Path(__file__).resolve().parents[2]
SHARED = TESTS.parent / "../shared/models"
PUBLISHED = {
    "rotors_description/urdf/hummingbird.xacro": {"namespace": "hummingbird"},
    "gym_pybullet_drones/cf2x.urdf": {},
    "px4_gazebo_models/x500/model.sdf": {},
}
AIR = {"wind_x": 3.0, "wind_y": -2.0, "wind_z": 0.5, "drag_area": 0.03, "air_density": 1.0}
GUST = {"gust_x": 5.0, "gust_start": 0.8, "push_y": 3.0, "push_start": 1.2, "push_at_z": 0.1}
TORQUE = {
    "push_torque_x": 0.1,
    "push_torque_y": -0.2,
    "push_torque_z": 0.02,
    "push_start": 1.2,
    "push_duration": 0.5,
}


def assert_agrees(rollouts, flown: Recording, peak_rotor_use: float, close: float = CLOSE):
    assert rollouts.time == pytest.approx(flown.time - EDGE)
    assert np.isnan(rollouts.diverged_at).all()
    assert rollouts.velocity_W[0] == pytest.approx(flown.v_WB, abs=close)
    assert rollouts.angular_velocity_W[0] == pytest.approx(flown.w_WB, abs=close)
    assert rollouts.peak_rotor_use[0] == pytest.approx(peak_rotor_use, abs=close)


def compare(config: VehicleConfig, axis: str, amplitude: float, rates: Rates | None = None):
    """Fly a step in both ways."""
    rates = rates or Rates()
    scenario = Scenario(vehicle=config, rates=rates)
    step = fly_step(axis, amplitude, duration=DURATION, scenario=scenario)
    vehicle = configured_vehicle(config)
    engine = RolloutEngine(vehicle, rates, config.variation)
    rollouts = engine.fly([{}], axis, amplitude, duration=DURATION)
    assert rollouts.response[0] == pytest.approx(step.response, abs=CLOSE)
    assert_agrees(rollouts, step.recording.between(EDGE, np.inf), step.peak_rotor_use)


@pytest.fixture(scope="module")
def diagram():
    """Return a function that flies a step on one diagram, as `fly_step` does on a new one."""
    start = Start(position=[0.0, 0.0, START_HEIGHT])
    session = Session(Scenario(start=start, duration=EDGE + DURATION))

    def fly(axis: str, amplitude: float, settings: dict[str, float]) -> Recording:
        session.reset()
        for name, value in settings.items():
            session.set(name, value)
        session.tick(EDGE)
        session.command([amplitude * (axis == one) for one in "xyz"], amplitude * (axis == "yaw"))
        session.tick(DURATION)
        return session.recording().between(EDGE, np.inf)

    return fly


@pytest.mark.slow
@pytest.mark.parametrize(
    ("axis", "amplitude"), [("x", 8.0), ("y", -8.0), ("z", -3.0), ("yaw", 0.4)]
)
def test_a_step_is_that_of_the_diagram(axis, amplitude):
    """The large ones run into the limits of tilt and rotors."""
    compare(VehicleConfig(), axis, amplitude)


@pytest.mark.slow
@pytest.mark.parametrize(
    ("axis", "amplitude"), [("x", -1.0), ("y", 1.0), ("z", 8.0), ("yaw", -0.3)]
)
def test_so_it_is_the_other_way(engine, diagram, axis, amplitude):
    after = diagram(axis, amplitude, {})
    rollouts = engine.fly([{}], axis, amplitude, duration=DURATION)
    assert_agrees(rollouts, after, after.rotor_use.max())


@pytest.mark.slow
def test_so_it_is_with_any_gains(engine, diagram):
    rng = np.random.default_rng(3)
    tuned = [row.name for row in load_controller().parameters if row.name.startswith(("kp", "kd"))]
    for index in range(10):
        gains = {}
        for name in tuned:
            row = parameter_table().find(name)
            value = engine.gains[name] * 2.0 ** rng.uniform(-1.0, 1.0)
            gains[name] = float(np.clip(value, row.minimum, row.maximum))
        axis, amplitude = ("x", "y", "z", "yaw")[index % 4], (0.4, -0.3)[index % 2]
        after = diagram(axis, amplitude, gains)
        rollouts = engine.fly([gains], axis, amplitude, duration=DURATION)
        assert_agrees(rollouts, after, after.rotor_use.max())


@pytest.mark.slow
@pytest.mark.parametrize(
    "variation",
    [
        Variation(mass=1.2, inertia=0.7, rotor_lag=1.5),
        Variation(control_delay=1),
        Variation(sensing_delay=0.003, command_delay=0.004),
        Variation(control_delay=1, sensing_delay=0.001, command_delay=7 / 1024),
        Variation(command_delay=0.011),
    ],
    ids=str,
)
def test_so_it_is_with_what_the_law_does_not_know(variation):
    compare(VehicleConfig(variation=variation), "x", 8.0)


@pytest.mark.slow
@pytest.mark.parametrize(
    "settings",
    [{"rotor_2": 0.9}, {"rotor_3": 0.0}, AIR, GUST, TORQUE],
    ids=str,
)
def test_so_it_is_with_faults_and_in_the_wind(engine, diagram, settings):
    after = diagram("z", 2.0, settings)
    rollouts = engine.fly([settings], "z", 2.0, duration=DURATION)
    close = 1e-3 if 0.0 in settings.values() else CLOSE  # with a rotor lost, rounding grows
    assert_agrees(rollouts, after, after.rotor_use.max(), close)


@pytest.mark.parametrize(
    "rates",
    [
        Rates(physics_step=1 / 2048, control_period=1 / 256),
        Rates(physics_step=0.001, control_period=0.006, mode_period=0.12),
    ],
    ids=str,
)
def test_so_it_is_at_other_rates(rates):
    """The second one has no control update at the command's edge."""
    compare(VehicleConfig(), "x", 2.0, rates)


@pytest.mark.parametrize(
    ("name", "args"), [("tilted_quad", {"forward": "5"}), ("low_mass_quad", {}), ("coaxial_x8", {})]
)
def test_so_it_is_with_drones_of_other_layouts(name, args):
    compare(VehicleConfig(str(TESTS / f"drones/{name}.urdf.xacro"), args), "x", 2.0)


@pytest.mark.parametrize("path", PUBLISHED)
def test_so_it_is_with_a_published_description(path):
    if not SHARED.is_dir():
        pytest.skip("put the published descriptions into ../shared/models to try them")
    compare(VehicleConfig(str(SHARED / path), PUBLISHED[path]), "y", -2.0)
