"""Oracle: where a session puts the plant."""

from pathlib import Path

import pytest

from workbench.design.rollout.starts import start_state
from workbench.scenario.scenario import Scenario, Start, VehicleConfig
from workbench.session.session import Session

TILTED = Path(__file__).resolve().parents[2] / "drones/tilted_quad.urdf.xacro"
THROWN = Start(
    position=[1.0, 2.0, 30.0],
    roll_pitch_yaw=[2.5, -0.4, 1.0],
    velocity=[1.0, -2.0, 3.0],
    angular_velocity=[0.5, 4.0, -1.0],
)


@pytest.mark.parametrize(
    "config", [VehicleConfig(), VehicleConfig(str(TILTED), {"forward": "5"})], ids=["own", "tilted"]
)
def test_a_start_is_the_sessions(config):
    session = Session(Scenario(vehicle=config, start=THROWN, duration=1.0))
    session.tick(session.scenario.rates.control_period)
    first = session.recording()
    state = start_state(session.vehicle, THROWN)
    assert state[:4] == pytest.approx(first.q_WB[0], abs=1e-12)
    assert state[4:7].tolist() == first.p_WB[0].tolist()
    assert state[7:10].tolist() == first.w_WB[0].tolist()
    assert state[10:].tolist() == first.v_WB[0].tolist()


def test_without_a_position_it_is_where_steps_begin():
    vehicle = Session(Scenario()).vehicle
    assert start_state(vehicle, Start()).tolist() == [1.0] + [0.0] * 5 + [10.0] + [0.0] * 6
