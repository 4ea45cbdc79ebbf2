"""Gains of one law as those of another: loops by linear models, units by closed forms."""

import math
from functools import cache
from pathlib import Path

import numpy as np
import pytest

from workbench.common.errors import WorkbenchError
from workbench.control.controller_file import load_controller
from workbench.control.installed_laws import installed_laws
from workbench.design.linear.study import LinearStudy
from workbench.design.translate.forms import form_of
from workbench.design.translate.loop_difference import gains_alone
from workbench.design.translate.translation import law_effects, translate
from workbench.scenario.scenario import Scenario, VehicleConfig

DRONES = Path(__file__).parents[3] / "drones"
QUAD, CRAZYFLIE = str(DRONES / "five_inch_quad.urdf.xacro"), str(DRONES / "crazyflie.urdf")
LIMIT = 0.01
QUICK, LOSSLESS = 35, 130
"""Loops of all pairs of which nothing is lost, at least."""


@cache
def study(law: str, model: str = "dh_drone") -> LinearStudy:
    return LinearStudy(Scenario(vehicle=VehicleConfig(model=model), controller=law))


def without_slopes(law: str, values: dict[str, float]) -> dict[str, float]:
    """Return values with nothing on accelerations, which laws measure in different ways."""
    rows = form_of(load_controller(law)).rows
    return values | {row.name: 0.0 for row in rows if row.part == "slope"}


def held_together(case, pairs) -> int:
    """Hold loops of two laws together wherever nothing is lost; return how many.

    The measure is |L2 / L1 - 1| at the plant's input, from a thirtieth of the crossover up to it.
    """
    told = 0
    for old, new in pairs:
        one, other = study(old), study(new)
        for values in (dict(one.gains), without_slopes(old, dict(one.gains))):
            found = translate(one, other, values, dict(other.gains))
            for each in gains_alone(one, other, values, found.values):
                if found.exact and not found.lost_in(each.channel):
                    with case(old, new, each):
                        told += 1
                        assert each.largest < LIMIT
                        assert each.other == pytest.approx(each.crossover, rel=LIMIT)
    return told


def test_loops_are_the_same_where_nothing_is_lost(case):
    pairs = (
        ("pd", "px4"),
        ("pid", "px4"),
        ("px4", "crazyflie"),
        ("ardupilot", "px4"),
        ("pid", "betaflight"),
        ("px4", "betaflight"),
        ("betaflight", "ardupilot"),  # each has a version of its own
        ("mellinger", "crazyflie"),
    )
    assert held_together(case, pairs) >= QUICK


@pytest.mark.slow
def test_loops_of_all_pairs_are_the_same_where_nothing_is_lost(case):
    laws = [name for name in installed_laws() if name != "lqi"]
    pairs = [(old, new) for old in laws for new in laws if old != new]
    assert held_together(case, pairs) >= LOSSLESS


def test_gains_come_back(case):
    """There and back again, where the other law has all parts."""
    for old, new in (("pd", "px4"), ("pid", "px4"), ("pd", "pid"), ("pid", "betaflight")):
        with case(old, new):
            one, other = study(old), study(new)
            there = translate(one, other, dict(one.gains), dict(other.gains))
            back = translate(other, one, there.values, dict(one.gains))
            lost = {each.axis for each in there.lost} | {each.axis for each in back.lost}
            kept = [row.name for row in form_of(one.controller).rows if row.axis not in lost]
            assert kept
            for name in kept:
                assert back.values[name] == pytest.approx(one.gains[name], rel=6e-3), name


def test_a_unit_of_torque_makes_what_the_reference_says(case):
    """On a symmetric quad in X: px4 2√2 l s, ardupilot 2 l s, betaflight 4 l s, and 4 κ s, 2 κ s.

    s is the slope of a rotor's thrust over the signal in hover, by hand from its constants.
    """
    vehicle = study("px4", QUAD).vehicle
    rotor = vehicle.rotors[0]
    l_x, l_y = (abs(rotor.p_BR[axis] - vehicle.p_BoBcm_B[axis]) for axis in (0, 1))
    hover = math.sqrt(vehicle.mass * 9.80665 / 4.0 / rotor.motor_constant)
    slope = 2.0 * rotor.motor_constant * hover
    kappa = rotor.moment_constant
    j_x, j_y, j_z = np.diagonal(vehicle.inertia)
    for law, about, yaw, span in (
        ("px4", 2.0 * math.sqrt(2.0), 4.0, lambda g: g["SIM_GZ_EC_MAX"] - g["SIM_GZ_EC_MIN"]),
        ("ardupilot", 2.0, 2.0, _of_ardupilot(hover)),
        ("betaflight", 4.0, 4.0, lambda g: g["motor_speed"] * (1.0 - g["motor_idle"] / 1e4)),
    ):
        with case(law):
            gains = dict(study(law, QUAD).gains)
            found = law_effects(study(law, QUAD), gains)
            s = slope * span(gains)
            both = (min(l_x, l_y),) * 2 if law == "px4" else (l_y, l_x)
            assert found["roll"] == pytest.approx(about * both[0] * s / j_x, rel=2e-3)
            assert found["pitch"] == pytest.approx(about * both[1] * s / j_y, rel=2e-3)
            assert found["yaw"] == pytest.approx(yaw * kappa * s / j_z, rel=2e-3)


def _of_ardupilot(hover: float):
    """Return speed per share of thrust: a signal's slope over it is 1 / (2 e r + 1 - e)."""

    def span(g: dict[str, float]) -> float:
        width = g["MOT_SPIN_MAX"] - g["MOT_SPIN_MIN"]
        r = (hover / g["motor_speed"] - g["MOT_SPIN_MIN"]) / width
        e = g["MOT_THST_EXPO"]
        return width * g["motor_speed"] / (2.0 * e * r + 1.0 - e)

    return span


def test_a_crazyflies_unit_makes_what_the_reference_says():
    """2 (arm / √2) thrust_max / 65535 for roll, 4000 thrust_max / 65535 / m for climbing."""
    found = study("crazyflie", CRAZYFLIE)
    vehicle, gains = found.vehicle, dict(found.gains)
    rotor = vehicle.rotors[0]
    lever = abs(rotor.p_BR[1] - vehicle.p_BoBcm_B[1])
    by = law_effects(found, gains)
    roll = 2.0 * lever * gains["thrust_max"] / 65535.0 / vehicle.inertia[0, 0]
    assert by["roll"] == pytest.approx(roll, rel=1e-3)
    climb = 4000.0 * gains["thrust_max"] / 65535.0 / vehicle.mass
    assert by["z"] == pytest.approx(climb, rel=1e-3)


def test_what_cannot_be_is_said():
    with pytest.raises(WorkbenchError, match="lqi has weights"):
        translate(study("lqi"), study("px4"), dict(study("lqi").gains), dict(study("px4").gains))
    rate_mode = dict(study("betaflight").gains) | {"acro": 1.0}
    with pytest.raises(WorkbenchError, match="flies with acro"):
        translate(study("betaflight"), study("pd"), rate_mode, dict(study("pd").gains))
