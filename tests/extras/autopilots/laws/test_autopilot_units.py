"""What a unit of torque of each autopilot is worth, beside formulas by hand of a symmetric quad.

With l the rotors' distance from roll's axis, κ torque over thrust, and s the slope of a rotor's
thrust over what the mixer tells it in hover: ArduPilot turns by 2 l s and 2 κ s per unit of roll
and yaw, Betaflight by 4 l s and 4 κ s, PX4 by 2 √2 l s and 4 κ s.
"""

import math
from pathlib import Path

import pytest

from workbench.control.controller_file import load_controller
from workbench.control.flight_law import flight_law
from workbench.control.guidance import Guidance, LawSetpoint, MeasuredMotion, Reference
from workbench.control.law_constants import known_body, known_vehicle, law_constants
from workbench.gains.gain_choice import flight_gains
from workbench.plant.gravity import GRAVITY
from workbench.plant.loading import load_vehicle

DRONE = Path(__file__).parents[3] / "drones/five_inch_quad.urdf.xacro"
MASS, LEVER, KAPPA, MOST, FASTEST = 0.65, 0.11 / math.sqrt(2.0), 0.010, 12.3, 2670.0
HOVER = math.sqrt(MASS * GRAVITY / 4.0 / MOST)
"""Speed in hover over the largest one; thrust goes with its square."""
ROUNDED = 3e-3
"""A rule's throttle in hover has three digits."""


def ardupilot_slope():
    expo, low, high = 0.65, 0.15, 0.95
    ratio = (HOVER - low) / (high - low)
    thrust = expo * ratio**2 + (1.0 - expo) * ratio
    return 2.0 * MOST * HOVER * (high - low) / math.sqrt((1.0 - expo) ** 2 + 4.0 * expo * thrust)


WORTH = {
    "ardupilot": (2.0, 2.0, ardupilot_slope()),
    "betaflight": (4.0, 4.0, 2.0 * MOST * HOVER * (1.0 - 0.055)),
    "px4": (2.0 * math.sqrt(2.0), 4.0, 2.0 * MOST * HOVER * (1.0 - 0.15)),
}


@pytest.fixture(scope="module")
def vehicle():
    return load_vehicle(DRONE)


@pytest.mark.parametrize("name", WORTH)
def test_a_unit_of_torque_turns_as_by_hand(name, vehicle):
    by_roll, by_yaw, slope = WORTH[name]
    law, constants = load_controller(name), law_constants(vehicle)
    values = flight_gains(vehicle, controller=law)
    numbers = law.gains(values, known_vehicle(constants), law.period)
    g, memory = flight_law(law).gains(numbers), flight_law(law).memory(law.initial_memory)
    zero = (0.0, 0.0, 0.0)
    level = (1.0, 0.0, 0.0, 0.0)
    elapsed = tuple(n * law.period for n in law.dividers)
    hover = MeasuredMotion(zero, zero, zero, level, zero, zero, (0.0, *zero), elapsed=elapsed)
    asked = LawSetpoint(Reference(*[0.0] * 8), Guidance(1.0, 1.0, 1.0, *[0.0] * 6), zero)
    count, step = len(law.points), 1e-4

    def wrench(point: str, size: float):
        loops = [*law.closed, *[0.0] * count]
        loops[count + law.point_names.index(point)] = size
        body = known_body(constants)
        return law.update(hover, asked, g, body, memory, law.period, loops)[0]

    assert wrench("torque_x", 0.0)[0] == pytest.approx(MASS * GRAVITY, rel=ROUNDED)
    for point, place, worth in (
        ("torque_x", 1, by_roll * LEVER * slope),
        ("torque_y", 2, by_roll * LEVER * slope),
        ("torque_z", 3, by_yaw * KAPPA * slope),
    ):
        there, back = wrench(point, step)[place], wrench(point, -step)[place]
        assert (there - back) / (2.0 * step) == pytest.approx(worth, rel=ROUNDED), point
