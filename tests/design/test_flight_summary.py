"""The summary of flights made up by hand."""

import math
from dataclasses import MISSING, fields

import numpy as np
import pytest

from workbench.common.resources import find_model
from workbench.control.mode import FlightMode
from workbench.design.flight_summary import summarise
from workbench.plant.loading import load_vehicle
from workbench.session.recording import Recording


@pytest.fixture(scope="module")
def vehicle():
    return load_vehicle(find_model("dh_drone"))


@pytest.fixture
def made_up(vehicle):
    """Return a recording with positions over time, at rest in everything not given."""

    def make(time, p_WB, **others):
        n, rotors = len(time), len(vehicle.rotors)
        p_WB = np.array(p_WB, dtype=float)
        sizes = {"p_WB": 3, "v_WB": 3, "w_WB": 3, "vdot_WB": 3, "wdot_WB": 3, "reference": 8}
        sizes |= {"wind_W": 3}
        arrays = {name: np.zeros((n, size)) for name, size in sizes.items()}
        arrays |= {
            name: np.zeros((n, rotors)) for name in ("commanded_speeds", "rotor_speeds", "thrusts")
        }
        arrays |= {"mode": np.full(n, float(FlightMode.HOVERING)), "charge": np.ones(n)}
        arrays["clearance"] = np.full(n, math.inf)
        arrays["q_WB"] = np.tile([1.0, 0.0, 0.0, 0.0], (n, 1))
        arrays |= {"time": np.array(time), "p_WB": p_WB}
        arrays["v_WB"] = np.gradient(p_WB, np.array(time), axis=0)
        arrays |= others
        needed = {each.name for each in fields(Recording) if each.default_factory is MISSING}
        assert set(arrays) == needed - {"vehicle"}
        return Recording(vehicle=vehicle, **arrays)

    return make


def test_distance_speed_and_height(made_up):
    time = np.linspace(0.0, 4.0, 401)
    circle = np.stack([np.cos(time), np.sin(time), 2.0 + 0.0 * time], axis=1)
    summary = summarise(made_up(time, circle))
    assert summary.duration == 4.0
    assert summary.distance == pytest.approx(4.0, rel=1e-4)
    assert summary.max_speed == pytest.approx(1.0, rel=1e-3)
    assert summary.max_height == 2.0
    assert summary.final_mode == "hovering"
    assert summary.touch_down_speed is None


def test_the_least_clearance_counts_and_none_where_nothing_stands(made_up):
    places = [[0, 0, 5], [0, 0, 5]]
    assert summarise(made_up([0.0, 1.0], places)).least_clearance is None
    clearance = np.array([math.inf, 0.4])
    assert summarise(made_up([0.0, 1.0], places, clearance=clearance)).least_clearance == 0.4


def test_tilt_rotor_use_and_battery(made_up, vehicle):
    half = 0.25
    turned = np.tile([math.cos(half), math.sin(half), 0.0, 0.0], (2, 1))
    speeds = np.full((2, len(vehicle.rotors)), 100.0)
    speeds[1, 2] = 0.5 * vehicle.rotors[2].max_rot_velocity
    summary = summarise(
        made_up(
            [0.0, 1.0],
            [[0, 0, 5], [0, 0, 5]],
            q_WB=turned,
            rotor_speeds=speeds,
            charge=np.array([0.9, 0.65]),
        )
    )
    assert summary.max_tilt == pytest.approx(0.5)
    assert summary.max_rotor_use == pytest.approx(0.5)
    assert summary.battery_used == pytest.approx(0.25)


def test_lowest_height_end_and_yaw_rate(made_up):
    rates = np.array([[3.0, 0.0, 0.2], [0.0, -3.0, -0.5], [0.0, 0.0, 0.1]])
    summary = summarise(made_up([0.0, 1.0, 2.0], [[0, 0, 5], [1, 2, 3], [4, 5, 6]], w_WB=rates))
    assert (summary.min_height, summary.end) == (3.0, (4.0, 5.0, 6.0))
    assert summary.max_yaw_rate == 0.5


@pytest.mark.parametrize(
    ("tilts", "time"), [([0.1, 1.57], None), ([0.1, 1.58, 3.1, 1.58], 1.0), ([3.1, 0.0], 0.0)]
)
def test_a_drone_turned_over_when_it_first_tilts_beyond_90_degrees(made_up, tilts, time):
    half = 0.5 * np.array(tilts)
    turned = np.stack([np.cos(half), np.sin(half), 0.0 * half, 0.0 * half], axis=1)
    places = np.tile([0.0, 0.0, 5.0], (len(tilts), 1))
    flight = made_up(np.arange(float(len(tilts))), places, q_WB=turned)
    assert summarise(flight).turned_over == time


def test_touch_down_is_the_sinking_speed_before_the_ground(made_up, vehicle):
    time = np.linspace(0.0, 4.0, 513)
    height = np.maximum(1.0 - 0.4 * time, 0.0) + vehicle.ground_clearance
    path = np.stack([0.0 * time, 0.0 * time, height], axis=1)
    assert summarise(made_up(time, path)).touch_down_speed == pytest.approx(0.4, rel=1e-6)


def test_touch_down_is_the_fastest_of_the_last_ten_centimetres(made_up, vehicle):
    """It sinks at 0.8 m/s above 5 cm, and at 0.3 m/s below: 0.8 m/s was in them."""
    time = np.linspace(0.0, 4.0, 513)
    slow = np.maximum(0.05 - 0.3 * (time - 1.1875), 0.0)
    height = np.where(time < 1.1875, 1.0 - 0.8 * time, slow)
    path = np.stack([0.0 * time, 0.0 * time, height + vehicle.ground_clearance], axis=1)
    assert summarise(made_up(time, path)).touch_down_speed == pytest.approx(0.8, rel=1e-6)


def test_who_never_left_the_ground_did_not_land(made_up, vehicle):
    still = np.tile([0.0, 0.0, vehicle.ground_clearance], (3, 1))
    assert summarise(made_up([0.0, 1.0, 2.0], still)).touch_down_speed is None


def test_open_loop_has_neither_mode_nor_battery(made_up):
    nothing = np.full(2, math.nan)
    flight = made_up([0.0, 1.0], [[0, 0, 1], [0, 0, 1]], mode=nothing, charge=nothing)
    assert summarise(flight).final_mode == "open loop"
    assert math.isnan(summarise(flight).battery_used)
