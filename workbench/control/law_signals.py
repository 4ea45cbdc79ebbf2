"""Signals before and after a control law: filters, smoothed setpoints and rotor speeds."""

import math
from typing import NamedTuple

from workbench.common.jitable import register_jitable
from workbench.common.vectors import Numbers, Quaternion, Vector3
from workbench.control.guidance import LawSetpoint
from workbench.estimation.filters import Section, section_output
from workbench.estimation.filters import section_states as section_after

FILTER_STATE_COUNT = 10
"""Number of the filters' states, see `FilterStates`."""


class FilterStates(NamedTuple):
    """States of the filters before a law.

    Attributes:
        velocity: of the estimate of the acceleration, in W (3) [m/s].
        acceleration: of the low-pass after it (3) [m/s²].
        setpoint: of the low-pass on velocity and yaw rate (4) [m/s, rad/s].
    """

    velocity: Numbers
    acceleration: Numbers
    setpoint: Numbers


@register_jitable(forceinline=True)
def filter_states(numbers: Numbers) -> FilterStates:
    """Return states from a vector of all of them (10)."""
    return FilterStates(numbers[0:3], numbers[3:6], numbers[6:10])


def steady_filters(velocity: Numbers) -> list[float]:
    """Return all states (10) in steady flight at a velocity in W (3) [m/s], without turning."""
    return [*velocity, 0.0, 0.0, 0.0, *velocity, 0.0]


@register_jitable(forceinline=True)
def estimated_acceleration(
    velocity: Numbers, filtered: Numbers, estimate: tuple[float, float]
) -> tuple[Vector3, Vector3]:
    """Return the acceleration (3) [m/s²] and the filtered velocity (3) [m/s] after an update.

    Args:
        velocity: in W (3) [m/s].
        filtered: the same, filtered (3).
        estimate: share and rate, see `acceleration_estimate`.
    """
    share, rate = estimate
    f_x, f_y, f_z = filtered
    e_x = velocity[0] - f_x
    e_y = velocity[1] - f_y
    e_z = velocity[2] - f_z
    after = (f_x + share * e_x, f_y + share * e_y, f_z + share * e_z)
    return (rate * e_x, rate * e_y, rate * e_z), after


@register_jitable(forceinline=True)
def lowpassed_vector(section: Section, x: Numbers, u: Numbers) -> tuple[Vector3, Vector3]:
    """Return the outputs (3) and next states (3) of first-order low-passes for inputs (3)."""
    x_x, x_y, x_z = x
    u_x, u_y, u_z = u
    out = (
        section_output(section, 0.0, x_x, u_x),
        section_output(section, 0.0, x_y, u_y),
        section_output(section, 0.0, x_z, u_z),
    )
    after = (
        section_after(section, 0.0, x_x, u_x)[1],
        section_after(section, 0.0, x_y, u_y)[1],
        section_after(section, 0.0, x_z, u_z)[1],
    )
    return out, after


@register_jitable(forceinline=True)
def smoothed_setpoint(
    section: Section, x: Numbers, setpoint: LawSetpoint
) -> tuple[LawSetpoint, Quaternion]:
    """Return a setpoint with low-passed velocity and yaw rate, and the filters' next states (4).

    Args:
        section: of the low-pass.
        x: its states (4).
        setpoint: see `guidance.LawSetpoint`.
    """
    v_x, v_y, v_z, yaw_rate, p_x, p_y, p_z, follow = setpoint.reference
    (v_x, v_y, v_z), after = lowpassed_vector(section, (x[0], x[1], x[2]), (v_x, v_y, v_z))
    turned = section_after(section, 0.0, x[3], yaw_rate)[1]
    yaw_rate = section_output(section, 0.0, x[3], yaw_rate)
    reference = (v_x, v_y, v_z, yaw_rate, p_x, p_y, p_z, follow)
    return LawSetpoint(reference, setpoint.guidance, setpoint.a_WBcm), after + (turned,)


@register_jitable(forceinline=True)
def quantized_speed(speed: float, full: float, steps: float) -> float:
    """Return a commanded speed, rounded to the resolution of commands [rad/s].

    Args:
        speed: to be rounded.
        full: largest speed.
        steps: number of steps from 0 to the largest speed.
    """
    return full / steps * math.floor(steps * speed / full + 0.5)
