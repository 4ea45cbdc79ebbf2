"""Oracles: numbers by hand, and where a session puts the plant."""

from pathlib import Path

import numba
import numpy as np
import pytest

from workbench.common.errors import WorkbenchError
from workbench.control.controller_file import load_controller
from workbench.design.rollout.candidates import make_candidates, start_state
from workbench.dynamics.air.settings import AirSettings
from workbench.scenario.scenario import Scenario, ScenarioStart, VehicleConfig
from workbench.session.session import Session

LAW = load_controller()
GAINS = [row.name for row in LAW.parameters]
OWN = load_controller().table.defaults()
STILL = np.zeros(4)
HOVER = np.array([1.0] + [0.0] * 12)


def test_values_by_name_come_to_their_places():
    candidates = make_candidates(
        LAW, [{"kp_roll": 7.0}, {"wind_y": 3.0, "rotor_2": 0.5}], OWN, 4, STILL, HOVER, [0]
    )
    kp_roll, wind_y = GAINS.index("kp_roll"), AirSettings._fields.index("wind_y")
    assert candidates.gains[:, kp_roll].tolist() == [7.0, OWN["kp_roll"]]
    assert candidates.air[:, wind_y].tolist() == [0.0, 3.0]
    assert candidates.shares.tolist() == [[1.0] * 4, [1.0, 0.5, 1.0, 1.0]]


def test_an_array_has_the_gains_and_all_else_is_the_vehicles():
    gains = np.arange(2.0 * len(GAINS)).reshape(2, -1)
    candidates = make_candidates(
        LAW, gains, {**OWN, "drag_area": 0.5, "rotor_1": 0.8}, 14, STILL, HOVER, [0]
    )
    assert candidates.gains.tolist() == gains.tolist()
    area = AirSettings._fields.index("drag_area")
    assert candidates.air[:, area].tolist() == [0.5, 0.5]
    assert candidates.shares[1].tolist() == [0.8] + [1.0] * 13


def test_none_are_none():
    assert make_candidates(LAW, [], OWN, 4, STILL, HOVER, [0]).gains.shape == (0, len(GAINS))


@pytest.mark.parametrize(
    ("gains", "said"),
    [
        ([{"kp_rol": 1.0}], "unknown parameter 'kp_rol': did you mean 'kp_roll'"),
        ([{}, {"kp_roll": "fast"}], "candidate 2 has a value that is not a number"),
        (np.ones((3, 5)), "the gains are an array of 3 x 5 numbers"),
        (np.ones(18), "the gains are an array of 18 numbers"),
    ],
)
def test_what_makes_no_candidates_is_said(gains, said):
    with pytest.raises(WorkbenchError, match=said):
        make_candidates(LAW, gains, OWN, 4, STILL, HOVER, [0])


def test_candidates_are_laid_out_alike_wherever_they_come_from():
    """Compiled flights are compiled anew, for half a minute, for every layout of an array."""
    gains = np.asfortranarray(np.ones((5, len(GAINS))))
    each = np.asfortranarray(np.ones((5, 13)))
    made = [
        make_candidates(LAW, gains, OWN, 4, STILL, HOVER, [0]),
        make_candidates(LAW, [{}] * 5, OWN, 4, np.ones((5, 4)), each, [0] * 5),
        make_candidates(LAW, [{}], OWN, 4, STILL, HOVER, [0]),
        make_candidates(LAW, [{}] * 40, OWN, 4, STILL, HOVER, [0]).part(16, 32),
    ]
    assert len({str([numba.typeof(column) for column in each]) for each in made}) == 1


TILTED = Path(__file__).resolve().parents[2] / "drones/tilted_quad.urdf.xacro"
THROWN = ScenarioStart(
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
    assert start_state(vehicle, ScenarioStart()).tolist() == [1.0] + [0.0] * 5 + [10.0] + [0.0] * 6
