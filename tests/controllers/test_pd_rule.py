"""Oracles: the formulas by hand, the phase of the loop, and what may not matter to gains."""

import dataclasses
import math
from pathlib import Path

import numpy as np
import pytest

from workbench.control.controller_file import load_controller
from workbench.controllers.pd_rule import (
    CONTROL_DELAY,
    spare_angular_acceleration,
    thrust_to_weight,
)
from workbench.gains.gain_choice import rule_gains
from workbench.plant.rotors import Rotor
from workbench.plant.thrust_frame import thrust_frame
from workbench.plant.vehicle import Vehicle
from workbench.scenario.scenario import Rates

ARM = 0.2
MOST = 5.0
"""Largest thrust of a rotor [N]."""


def plus_quad(
    *,
    mass: float = 1.0,
    moments: tuple[float, float, float] = (0.005, 0.005, 0.009),
    lag: float = 0.02 - CONTROL_DELAY,
    com: tuple[float, float, float] = (0.0, 0.0, 0.0),
    scale: float = 1.0,
) -> Vehicle:
    """Return a plus of four rotors, `scale` times as heavy and as strong in everything."""
    rotors = tuple(
        Rotor(
            name=f"r{i}",
            joint="",
            link="",
            p_BR=(
                ARM * round(math.cos(i * math.pi / 2)),
                ARM * round(math.sin(i * math.pi / 2)),
                0,
            ),
            axis_B=(0.0, 0.0, 1.0),
            direction=(1, -1)[i % 2],
            motor_constant=scale * MOST / 1000.0**2,
            moment_constant=0.02,
            time_constant_up=lag,
            time_constant_down=lag,
            max_rot_velocity=1000.0,
        )
        for i in range(4)
    )
    return Vehicle(
        name="plus",
        source=Path("plus.urdf"),
        base_link="base",
        mass=scale * mass,
        p_BoBcm_B=com,
        I_BBcm_B=tuple(
            tuple(scale * moments[i] if i == j else 0.0 for j in range(3)) for i in range(3)
        ),
        rotors=rotors,
        sensors=(),
        frames=(),
        ground_clearance=0.1,
    )


def test_where_rotors_are_strong_their_lag_decides():
    """Lag and delay are 20 ms together; thrust is 20 N against a weight of 9.81 N."""
    assert rule_gains(plus_quad()) == pytest.approx(
        {
            "kd_roll": 25.0,  # 0.5 / 0.02
            "kd_pitch": 25.0,
            "kp_roll": 193.0,  # (25 / 1.8)²
            "kp_pitch": 193.0,
            "kp_velocity_x": 3.47,  # 13.89 / 4
            "kp_velocity_y": 3.47,
            "kp_velocity_z": 4.905,  # g / 2, as 0.25 / 0.02 and 10.19 are more
            "kd_velocity_x": 0.1,
            "kd_velocity_y": 0.1,
            "kd_velocity_z": 0.1,
            "kp_position_xy": 0.868,
            "kp_position_z": 1.23,  # 4.905 / 4
            "kp_yaw_rate": 5.0,  # 0.1 / 0.02
            "spin_up_feedforward": 0.0,
            "max_climb_rate": 6.23,  # 0.75 · 10.19 · 4 / 4.905
            "max_tilt": 0.7,
            "drag_area": 0.01,  # of a litre of water
        },
        rel=2e-3,
    )


def test_where_the_vehicle_is_hard_to_turn_spare_thrust_decides():
    """Two arms of 0.2 m, 2.4025 N to spare on each, 1 and 2 kg·m²: 0.961 and 0.4805 rad/s²."""
    vehicle = plus_quad(moments=(1.0, 2.0, 2.9))
    alphas = spare_angular_acceleration(thrust_frame(vehicle))
    assert alphas[:2] == pytest.approx([0.961, 0.4805])
    assert alphas[2] == pytest.approx(4 * 2.4025 * 0.02 / 2.9)
    gains = rule_gains(vehicle)
    roll, pitch = (4.0 * 9.81 * 0.961) ** (1 / 3), (4.0 * 9.81 * 0.4805) ** (1 / 3)
    assert roll == pytest.approx(3.354, abs=1e-3)
    assert gains["kp_roll"] == pytest.approx(roll**2, rel=5e-3)
    assert gains["kd_roll"] == pytest.approx(1.8 * roll, rel=5e-3)
    assert gains["kp_pitch"] == pytest.approx(pitch**2, rel=5e-3)
    assert gains["kp_velocity_x"] == gains["kp_velocity_y"]
    assert gains["kp_velocity_y"] == pytest.approx(pitch / 4.0, rel=5e-3)
    assert gains["kp_yaw_rate"] == pytest.approx(0.5 * alphas[2] / 0.4, rel=5e-3)


def test_where_thrust_is_scarce_climb_and_tilt_are_small():
    gains = rule_gains(plus_quad(mass=20.0 / 9.81 / 1.25))
    assert gains["kp_velocity_z"] == pytest.approx(0.25 * 9.81, rel=5e-3)
    assert gains["max_tilt"] == pytest.approx(math.acos(1.0 / 1.125), rel=5e-3)
    assert gains["max_climb_rate"] == pytest.approx(0.75 * 4.0, rel=5e-3)


@pytest.mark.parametrize("thrust_to_weight_ratio", [1.001, 1.02, 1.1, 1.3, 1.7, 3.0, 20.0])
def test_thrust_is_left_at_the_largest_tilt_and_for_braking(thrust_to_weight_ratio):
    vehicle = plus_quad(mass=20.0 / 9.81 / thrust_to_weight_ratio)
    assert thrust_to_weight(thrust_frame(vehicle)) == pytest.approx(thrust_to_weight_ratio)
    gains = rule_gains(vehicle)
    tilt = math.acos(2.0 / (1.0 + thrust_to_weight_ratio))  # half of the spare thrust is left
    assert gains["max_tilt"] == pytest.approx(np.clip(tilt, 0.05, 0.7), rel=5e-3)
    braking = gains["kp_position_z"] * gains["max_climb_rate"]
    assert braking <= 0.76 * 9.81 * (thrust_to_weight_ratio - 1.0)
    assert gains["max_climb_rate"] >= 1.0


@pytest.mark.parametrize("lag", [1e-4, 1e-3, 0.005, 1 / 60, 0.05, 0.1, 0.3])
def test_the_tilt_loop_keeps_its_phase_margin_at_any_lag(lag):
    """The loop is (kd s + kp) exp(-delay s) / s² / (lag s + 1)."""
    gains = rule_gains(plus_quad(lag=lag, moments=(1e-4, 1e-4, 2e-4)))
    kp, kd = gains["kp_roll"], gains["kd_roll"]
    s = 1j * np.logspace(-2, 4, 100001)
    loop = (kd * s + kp) * np.exp(-CONTROL_DELAY * s) / s**2 / (lag * s + 1.0)
    crossings = np.flatnonzero((np.abs(loop[:-1]) > 1.0) & (np.abs(loop[1:]) <= 1.0))
    assert len(crossings) == 1
    margin = 180.0 + math.degrees(np.unwrap(np.angle(loop))[crossings[0]])
    assert 43.5 <= margin <= 47.0


def test_the_shipped_drones_own_gains_are_near_the_rules():
    """They were found by hand, with the delay left out of account: 27 and 225."""
    gains = rule_gains(plus_quad(lag=1 / 60))
    assert gains["kd_roll"] == pytest.approx(27.0, rel=0.15)
    assert math.sqrt(gains["kp_roll"]) == pytest.approx(15.0, rel=0.15)
    damping = gains["kd_roll"] / math.sqrt(gains["kp_roll"])
    assert damping == pytest.approx(27.0 / 15.0, rel=5e-3)


def test_size_does_not_matter():
    """300 times the mass, inertia and thrust are the same accelerations; only drag differs."""
    large, small = rule_gains(plus_quad(scale=300.0)), rule_gains(plus_quad())
    assert large.pop("drag_area") == pytest.approx(300.0 ** (2 / 3) * small.pop("drag_area"), 1e-2)
    assert large == small


def test_axes_are_treated_alike():
    one = rule_gains(plus_quad(moments=(0.9, 0.5, 1.0)))
    other = rule_gains(plus_quad(moments=(0.5, 0.9, 1.0)))
    assert one["kp_roll"] < one["kp_pitch"]
    assert (one["kp_roll"], one["kd_roll"]) == (other["kp_pitch"], other["kd_pitch"])
    assert one["kp_velocity_x"] == other["kp_velocity_x"]


def test_a_centre_of_mass_far_away_slows_the_level_loop():
    near, far = rule_gains(plus_quad(com=(0, 0, 0.01))), rule_gains(plus_quad(com=(0, 0, -0.5)))
    assert near["kd_velocity_x"] == 0.1
    assert far["kd_velocity_x"] * far["kp_roll"] * 0.5 == pytest.approx(0.2 * 9.81, rel=0.01)
    assert near["kp_velocity_x"] == 3.47
    assert far["kp_velocity_x"] == pytest.approx(0.6 * math.sqrt(9.81 / 0.5), rel=5e-3)


def test_the_slowest_rotor_counts_at_the_mean_of_its_rates():
    vehicle = plus_quad(lag=0.005)
    slow = dataclasses.replace(
        vehicle.rotors[2], time_constant_up=0.01, time_constant_down=0.03
    )  # 100 and 33.3 1/s
    mixed = dataclasses.replace(vehicle, rotors=(*vehicle.rotors[:2], slow, vehicle.rotors[3]))
    assert vehicle.rotor_lag == pytest.approx(0.005)
    assert mixed.rotor_lag == pytest.approx(0.015)


def test_what_the_rule_takes_for_granted_is_so():
    rates = Rates()
    assert rates.control_period / 2 + rates.physics_step == CONTROL_DELAY


def test_the_strangest_vehicle_has_gains_within_the_tables_limits(case):
    for seed in range(60):
        with case(seed):
            rng = np.random.default_rng(seed)
            mass = 10.0 ** rng.uniform(-6, 0.3)
            vehicle = plus_quad(
                mass=mass,
                moments=tuple(10.0 ** rng.uniform(-12, 6, 3)),
                lag=10.0 ** rng.uniform(-9, 6),
                com=(0.0, 0.0, rng.choice([0.0, 1e-9, 100.0])),
                scale=10.0 ** rng.uniform(-9, 9),
            )
            for name, value in rule_gains(vehicle).items():
                row = load_controller().table.find(name)
                assert row.minimum <= value <= row.maximum, name
            assert rule_gains(vehicle).keys() <= load_controller().table.defaults().keys()
