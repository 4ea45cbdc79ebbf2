"""The gyro: it samples the angular velocity at its own rate, through a notch and a low-pass.

Each axis of the body has both filters in series. A sample is taken at the start of a physics step,
and one at each control update.
"""

from typing import NamedTuple

from workbench.common.jitable import register_jitable
from workbench.common.vectors import Numbers, Vector3
from workbench.dynamics.rigid_body import into_body, rotation
from workbench.estimation.filters import (
    filter_is_on,
    lowpass,
    notch,
    section_output,
    section_states,
)

GYRO_STATE_COUNT = 12
"""For each axis x, y, z of B: two states of the notch and two of the low-pass."""
GYRO_COEFFICIENT_COUNT = 18
"""Those of the notch, then those of the low-pass; see `filters`."""


class GyroSettings(NamedTuple):
    """Live parameters of gyro and accelerometer; see `workbench params`."""

    gyro_rate: float = 0.0
    gyro_lowpass: float = 0.0
    gyro_lowpass_order: float = 2.0
    gyro_notch: float = 0.0
    gyro_notch_width: float = 20.0
    accel_lowpass: float = 0.0
    accel_lowpass_order: float = 2.0


@register_jitable
def sample_steps(rate: float, step: float, steps: int) -> int:
    """Return the number of physics steps between gyro samples: a divisor of the control period.

    Args:
        rate: smallest requested rate [1/s]; 0 for a sample every step.
        step: of physics [s].
        steps: of physics in a control period.
    """
    if rate == 0.0:
        return 1
    for each in range(steps, 1, -1):
        if steps % each == 0 and each * step * rate <= 1.0 + 1e-9:
            return each
    return 1


def filters_gyro(settings: GyroSettings, period: float) -> bool:
    """Return whether any filter works at samples every `period` [s]."""
    return filter_is_on(settings.gyro_lowpass, period) or filter_is_on(settings.gyro_notch, period)


def gyro_filter(settings: GyroSettings, period: float) -> tuple[float, ...]:
    """Return the coefficients (18) of both filters for samples every `period` [s]."""
    return notch(settings.gyro_notch, settings.gyro_notch_width, period) + lowpass(
        settings.gyro_lowpass, settings.gyro_lowpass_order, period
    )


@register_jitable(forceinline=True)
def state_body_rates(state: Numbers) -> Vector3:
    """Return the angular velocity w_WB in B [rad/s] of a state of the body (13)."""
    return into_body(rotation(state[0:4]), state[7:10])


@register_jitable(forceinline=True)
def filtered_axis(coefficients: Numbers, x: Numbers, w: float) -> float:
    """Return the output of both filters on an axis with states x (4) for a rate [rad/s]."""
    between = section_output(coefficients[0:9], x[0], x[1], w)
    return section_output(coefficients[9:18], x[2], x[3], between)


@register_jitable(forceinline=True)
def stepped_axis(coefficients: Numbers, x: Numbers, w: float) -> tuple[float, float, float, float]:
    """Return the states (4) of an axis after a rate [rad/s]."""
    between = section_output(coefficients[0:9], x[0], x[1], w)
    return section_states(coefficients[0:9], x[0], x[1], w) + section_states(
        coefficients[9:18], x[2], x[3], between
    )


@register_jitable
def filtered_rates(coefficients: Numbers, x: Numbers, w_B: Numbers) -> Vector3:
    """Return the outputs (3) of the filters with states x (12) for angular velocities in B."""
    return (
        filtered_axis(coefficients, x[0:4], w_B[0]),
        filtered_axis(coefficients, x[4:8], w_B[1]),
        filtered_axis(coefficients, x[8:12], w_B[2]),
    )


@register_jitable
def stepped_filters(coefficients: Numbers, x: Numbers, w_B: Numbers) -> tuple[float, ...]:
    """Return the states of the filters (12) after angular velocities in B (3)."""
    return (
        stepped_axis(coefficients, x[0:4], w_B[0])
        + stepped_axis(coefficients, x[4:8], w_B[1])
        + stepped_axis(coefficients, x[8:12], w_B[2])
    )


@register_jitable(forceinline=True)
def steady_gyro_states(w_B: Numbers) -> tuple[float, ...]:
    """Return the states of the filters (12) for a constant angular velocity in B."""
    x, y, z = w_B
    zero = 0.0 * x
    return zero, x, zero, x, zero, y, zero, y, zero, z, zero, z


@register_jitable(forceinline=True)
def with_sensed_rates(state: Numbers, w_B: Numbers) -> tuple[float, ...]:
    """Return a state of the body (13) with another angular velocity, given in B (3) [rad/s]."""
    R = rotation(state[0:4])
    x, y, z = w_B
    return (
        state[0],
        state[1],
        state[2],
        state[3],
        state[4],
        state[5],
        state[6],
        R[0] * x + R[1] * y + R[2] * z,
        R[3] * x + R[4] * y + R[5] * z,
        R[6] * x + R[7] * y + R[8] * z,
        state[10],
        state[11],
        state[12],
    )
