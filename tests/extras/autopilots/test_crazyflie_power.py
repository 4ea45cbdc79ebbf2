"""The Crazyflie's power distribution on a drone of another size."""

from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest

from workbench.control.law_constants import known_vehicle, law_constants
from workbench.extras.autopilots.crazyflie_power import (
    FULL_MOTOR_SIGNAL,
    HOVER_MOTOR_SIGNAL,
    MOTOR_EFFECTS,
    larger_motors,
    motor_effects,
    power_distribution,
)
from workbench.plant.gravity import GRAVITY
from workbench.plant.loading import load_vehicle

FIVE_INCH = Path(__file__).parents[2] / "drones" / "five_inch_quad.urdf.xacro"


def test_a_torque_turns_a_larger_drone_as_its_motors_say_and_it_hovers_at_the_usual_signal():
    """By the wrench that the distribution gives, over the moments of inertia.

    A pitch torque lifts the nose, which is a negative moment about y.
    """
    vehicle = load_vehicle(FIVE_INCH)
    motors = larger_motors(vehicle)
    effects = motor_effects(known_vehicle(law_constants(vehicle)).rotors)
    g = SimpleNamespace(
        thrust_max=motors.thrust_max, **dict(zip(MOTOR_EFFECTS, effects, strict=True))
    )
    hover = np.array(power_distribution(HOVER_MOTOR_SIGNAL, (0.0, 0.0, 0.0), g, 4.2))
    assert hover[0] == pytest.approx(vehicle.mass * GRAVITY, rel=1e-6)
    torque = 0.01 * FULL_MOTOR_SIGNAL
    for axis, (name, sign) in enumerate((("roll", 1.0), ("pitch", -1.0), ("yaw", 1.0))):
        wanted = tuple(torque * np.eye(3)[axis])
        turned = np.array(power_distribution(HOVER_MOTOR_SIGNAL, wanted, g, 4.2)) - hover
        per_signal = turned[1 + axis] / vehicle.inertia[axis, axis] / torque
        assert per_signal == pytest.approx(sign * getattr(motors, name), rel=1e-3), name
