import numba
import numpy as np
import pytest

from workbench.common.errors import WorkbenchError
from workbench.control.controller import load_controller
from workbench.design.rollout.candidates import make_candidates
from workbench.dynamics.air.settings import AirSettings
from workbench.scenario.parameters import parameter_table

LAW = load_controller()
GAINS = [row.name for row in LAW.parameters]
OWN = parameter_table().defaults()
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
        ([{}, {"kp_roll": "fast"}], "candidate 2 has a value that is no number"),
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
