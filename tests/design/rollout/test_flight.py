"""Oracle: the same steps on the full diagram; for gains, faults, air, delays see test_agreement."""

from pathlib import Path

import numpy as np
import pytest

from tests.installed import readable
from workbench.design.rollout.engine import RolloutEngine
from workbench.design.rollout.lanes import make_lane_workspace
from workbench.design.step_response import STEP_EDGE_S, fly_step
from workbench.scenario.configured import configured_vehicle
from workbench.scenario.scenario import Rates, Scenario, VehicleConfig
from workbench.session.recording import Recording

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


def assert_agrees(rollouts, flown: Recording, peak_rotor_use: float):
    assert rollouts.time == pytest.approx(flown.time - STEP_EDGE_S)
    assert np.isnan(rollouts.diverged_at).all()
    assert rollouts.velocity_W[0] == pytest.approx(flown.v_WB, abs=CLOSE)
    assert rollouts.angular_velocity_W[0] == pytest.approx(flown.w_WB, abs=CLOSE)
    assert rollouts.peak_rotor_use[0] == pytest.approx(peak_rotor_use, abs=CLOSE)


def compare(config: VehicleConfig, axis: str, amplitude: float, rates: Rates | None = None):
    """Fly a step in both ways."""
    rates = rates or Rates()
    scenario = Scenario(vehicle=config, rates=rates)
    step = fly_step(axis, amplitude, duration=DURATION, scenario=scenario)
    vehicle = configured_vehicle(config)
    engine = RolloutEngine(vehicle, rates, config.variation)
    rollouts = engine.fly([{}], axis, amplitude, duration=DURATION)
    assert rollouts.response[0] == pytest.approx(step.response, abs=CLOSE)
    assert_agrees(rollouts, step.recording.between(STEP_EDGE_S, np.inf), step.peak_rotor_use)


@pytest.mark.slow
@pytest.mark.parametrize(
    ("axis", "amplitude"), [("x", 8.0), ("y", -8.0), ("z", -3.0), ("yaw", 0.4)]
)
def test_a_step_is_that_of_the_diagram(axis, amplitude):
    """The large ones run into the limits of tilt and rotors."""
    compare(VehicleConfig(), axis, amplitude)


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
    ("name", "args"),
    [
        ("tilted_quad", {"forward": "5"}),
        ("low_mass_quad", {}),
        pytest.param("coaxial_x8", {}, marks=pytest.mark.slow),  # eight rotors compile anew
    ],
)
def test_so_it_is_with_drones_of_other_layouts(name, args):
    compare(VehicleConfig(str(TESTS / f"drones/{name}.urdf.xacro"), args), "x", 2.0)


@pytest.mark.parametrize("path", readable(PUBLISHED))
def test_so_it_is_with_a_published_description(path):
    if not SHARED.is_dir():
        pytest.skip("put the published descriptions into ../shared/models to try them")
    compare(VehicleConfig(str(SHARED / path), PUBLISHED[path]), "y", -2.0)


def test_vectors_of_lanes_begin_at_cache_lines():
    """64 bytes, of x86 and ARM; numpy alone places arrays at multiples of 16."""
    for rotors in (3, 4, 8):
        for array in make_lane_workspace(rotors):
            assert array.ctypes.data % 64 == 0, array.dtype
            assert all(stride % 64 == 0 for stride in array.strides[:-1])
            assert array.dtype.fields is None or array.dtype.itemsize % 64 == 0
            assert not array.view(np.uint8).any()
