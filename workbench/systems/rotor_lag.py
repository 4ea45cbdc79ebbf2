"""Rotor speed follows its command with a lag, faster up than down, as Gazebo's motor model has it.

Composed of Drake's own systems, because it runs at every physics step.
"""

import math

import numpy as np
from pydrake.symbolic import Expression, Variable, sqrt
from pydrake.systems.framework import Diagram, DiagramBuilder
from pydrake.systems.primitives import Saturation, SymbolicVectorSystem

from workbench.plant.rotors import Rotor

_BLEND = 1.0
"""The two time constants blend over about this speed difference [rad/s], to be differentiable."""


def make_rotor_lag(rotors: tuple[Rotor, ...], *, time_step: float) -> Diagram:
    """Return a diagram from commanded rotor speeds (n) [rad/s] to thrusts (n) [N].

    Commands are limited to 0 .. max_rot_velocity. The speed w follows the command u with
    dw/dt = (u - w) / time constant; at u = w, where the two meet, the rate is their mean.
    Thrust is motor_constant w².

    Args:
        rotors: whose constants to use.
        time_step: 0 for a continuous lag; else its exact discrete equivalent at that step [s].
    """
    n = len(rotors)
    speeds = [Variable(f"w{i}") for i in range(n)]
    commands = [Variable(f"u{i}") for i in range(n)]
    lag = SymbolicVectorSystem(
        state=speeds,
        input=commands,
        dynamics=[
            _dynamics(w, u, rotor, time_step)
            for w, u, rotor in zip(speeds, commands, rotors, strict=True)
        ],
        output=[rotor.motor_constant * w * w for w, rotor in zip(speeds, rotors, strict=True)],
        time_period=time_step,
    )
    builder = DiagramBuilder()
    limits = builder.AddNamedSystem(
        "speed_limits", Saturation(np.zeros(n), np.array([r.max_rot_velocity for r in rotors]))
    )
    builder.AddNamedSystem("speeds", lag)
    builder.Connect(limits.get_output_port(), lag.get_input_port())
    builder.ExportInput(limits.get_input_port(), "commanded_speeds")
    builder.ExportOutput(lag.get_output_port(), "thrusts")
    diagram = builder.Build()
    diagram.set_name("rotor_lag")
    return diagram


def _dynamics(w: Variable, u: Variable, rotor: Rotor, time_step: float) -> Expression:
    """Return dw/dt, or w after one step of exact integration under a constant command."""
    if time_step == 0.0:
        return _approach(w, u, 1.0 / rotor.time_constant_up, 1.0 / rotor.time_constant_down)
    up = -math.expm1(-time_step / rotor.time_constant_up)
    down = -math.expm1(-time_step / rotor.time_constant_down)
    return w + _approach(w, u, up, down)


def _approach(w: Variable, u: Variable, up: float, down: float) -> Expression:
    """Return up (u - w) for u > w and down (u - w) for u < w, smooth in between."""
    error = u - w
    mean = (up + down) / 2.0
    half_difference = (up - down) / 2.0
    return mean * error + half_difference * (sqrt(error * error + _BLEND**2) - _BLEND)
