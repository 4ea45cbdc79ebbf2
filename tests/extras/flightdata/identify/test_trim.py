"""Weights and cut propellers by name, from commands alone."""

import dataclasses
from pathlib import Path

import numpy as np
import pytest
from scipy import stats

from workbench.common.errors import WorkbenchError
from workbench.extras.flightdata.identify.trim import (
    MAX_OPPOSITE_RATIO,
    SHARE_THRUST_EXPONENT,
    _thrust_ratio,
    trim,
)
from workbench.plant.loading import load_vehicle
from workbench.plant.rotors import allocation_matrix

DRONES = Path(__file__).parents[3] / "drones"
FLIGHTS = Path(__file__).parents[5] / "shared" / "flights" / "given" / "crazypad"
ON_M3 = ("add_weight_W1", "add_weight_W3", "cut_propeller", "weight_on_string", "tape")


def hover(thrusts: np.ndarray, gusts: float = 0.0) -> tuple[np.ndarray, np.ndarray]:
    """Return times and commands of ten seconds in the air at thrusts (n), on the ground around.

    In gusts the thrusts differ from second to second by a share.
    """
    rng = np.random.default_rng(1)
    time = np.arange(0.0, 14.0, 0.01)
    flies = (time > 1.0) & (time < 13.0)
    share = (thrusts / thrusts.sum()) ** (1.0 / SHARE_THRUST_EXPONENT)
    commands = share * (1.0 + 0.05 * rng.normal(size=(len(time), 1)))
    commands = commands * np.repeat(np.exp(gusts * rng.normal(size=(14, len(thrusts)))), 100, 0)
    return time, commands * flies[:, None]


def test_an_interval_is_students_over_the_logarithms_of_seconds() -> None:
    """Of scipy's t interval of the mean of n logarithms, with the deviation of a sample."""
    one, other = np.array([1.2, 1.1, 1.3, 1.25]), np.array([1.0, 1.05, 0.95, 1.02])
    ratio, low = _thrust_ratio(one, other)
    assert ratio == pytest.approx(one.sum() / other.sum())
    logarithms = np.log(one / other)
    end = stats.t.interval(0.95, 3, loc=np.log(ratio), scale=stats.sem(logarithms))[0]
    assert low == pytest.approx(np.exp(end))


def test_a_rotor_that_carries_more_is_named() -> None:
    """Thrusts that balance a weight are those of the drone with another centre of mass."""
    vehicle = load_vehicle(DRONES / "crazyflie.urdf")
    third = vehicle.rotors[2]
    weight = 0.06 * np.array(third.p_BR)
    heavy = allocation_matrix(vehicle.rotors, weight)[:, 0]
    even = np.ones(4)
    cut = np.array([1.2, 0.85, 1.25, 0.85])
    for name, thrusts, found in (
        ("normal", even, []),
        ("weight", heavy, ["m3"]),
        ("cut", cut, ["m3"]),
    ):
        rows = trim(vehicle, *hover(thrusts))
        assert [row.name for row in rows if row.finding] == found, name
        for row, share in zip(rows, thrusts / thrusts.mean(), strict=True):
            assert row.share == pytest.approx(share, rel=0.01), name
        pairs = thrusts[:2] + thrusts[2:]  # opposite ones, which turn the same way
        over = pairs / pairs[::-1]
        turned = [row.pair_over_others for row in rows]
        assert turned == pytest.approx([*over, *over], rel=0.01), name
    # in gusts the same weight may be chance: the interval reaches down to what is normal
    rows = trim(vehicle, *hover(heavy, gusts=0.3))
    assert max(row.over_opposite for row in rows) > MAX_OPPOSITE_RATIO
    assert not any(row.finding for row in rows)
    # a motor that stands still is no division by zero
    assert trim(vehicle, *hover(np.array([1.0, 1.0, 0.0, 1.0])))[0].finding


def test_take_off_and_landing_are_no_hover() -> None:
    """A rotor that gives twice as much for the first and the last 1.3 s in the air is normal."""
    vehicle = load_vehicle(DRONES / "crazyflie.urdf")
    time, commands = hover(np.ones(4))
    ends = ((time > 1.0) & (time < 2.3)) | ((time > 11.7) & (time < 13.0))
    commands[ends, 2] *= 2.0 ** (1.0 / SHARE_THRUST_EXPONENT)
    rows = trim(vehicle, time, commands)
    assert not any(row.finding for row in rows)
    for row in rows:
        assert row.share == pytest.approx(1.0, rel=1e-3)


def test_it_refuses_what_it_cannot_tell() -> None:
    vehicle = load_vehicle(DRONES / "crazyflie.urdf")
    time, commands = hover(np.ones(4))
    with pytest.raises(WorkbenchError, match="are the least"):
        trim(vehicle, time[:400], commands[:400])
    three = dataclasses.replace(vehicle, rotors=vehicle.rotors[:3])
    with pytest.raises(WorkbenchError, match="in opposite pairs"):
        trim(three, time, commands[:, :3])


@pytest.mark.slow
@pytest.mark.skipif(not FLIGHTS.is_dir(), reason="put the real flights into ../shared/flights")
def test_real_damages_are_found_in_ten_of_eleven_logs() -> None:
    from workbench.logs.flight_reader import read_flight
    from workbench.logs.motor_commands import motor_commands

    vehicle = load_vehicle(DRONES / "crazyflie.urdf")
    right = 0
    for path in sorted(path for path in FLIGHTS.rglob("E?_log*") if path.is_file()):
        record = read_flight(path)
        try:
            time, commands, _ = motor_commands(record, 4)
        except WorkbenchError:  # the one log without motors, of a normal flight: nothing is found
            rows = []
        else:
            rows = trim(vehicle, time, commands)
        found = [row.name for row in rows if row.finding]
        damaged = any(name in str(path) for name in ON_M3)
        print(path.parent.name, path.name, found)
        if not damaged:
            assert found == [], path
        right += found == (["m3"] if damaged else [])
    assert right >= 10
