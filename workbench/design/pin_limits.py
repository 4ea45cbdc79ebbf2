"""Limits and tolerances of a pinned flight, from its measured numbers."""

import math
from collections.abc import Mapping

from workbench.design.regress.signals import AXIS_SIGNALS
from workbench.design.regress.spec import SpecLimit, Tolerance

PIN_SHARES = {"rise_time": 0.12, "peak_tilt": 0.12}
"""Numbers with limits on both sides, at this share of the value."""
PIN_SPANS = {"overshoot": 2.0, "steady_state_error": 0.5, "peak_rotor_use": 0.05}
"""Others, at this distance [%, %, 1]."""
PIN_UPPER_LIMITS = {
    "settling_time": (1.4, 0.0),
    "coupling_z": (1.5, 0.01),
    "coupling_yaw": (1.5, 0.005),
}
"""Numbers with an upper limit only: a factor on the measured value, and an offset."""
PINNED_NUMBERS = (*PIN_SHARES, *PIN_SPANS, *PIN_UPPER_LIMITS)
"""Numbers of a step that get limits."""
PIN_PEAK_SHARE = 0.08
"""Limits of the peak under a load lie this share of its value to both sides."""
PINNED_LOAD_NUMBERS = ("peak", "settling_time", "steady_state_error", "peak_rotor_use")
"""Numbers of a step of a load that get limits."""
LOAD_CURVE_SHARE = 0.02
"""Tolerance of the curve of the response to a load, as a share of its peak."""
PIN_CURVE_TOLERANCES = {
    "x": {"v_x": (0.015, 0.002), "p_x": (0.002, 0.0005)},
    "y": {"v_y": (0.015, 0.002), "p_y": (0.002, 0.0005)},
    "z": {"v_z": (0.02, 0.002), "p_z": (0.0016, 0.0005)},
    "yaw": {"yaw_rate": (0.02, 0.0005), "yaw": (0.003, 0.0002)},
}
"""Tolerances of the curves of an axis: share of the amplitude, and smallest tolerance [SI].

Half and twice the step of the integrator stay within them, 0.7 times a gain does not."""
PIN_CROSSOVER_SHARE = 0.08
"""Tolerance of crossover frequencies to both sides."""
PIN_MARGIN_SHARES = {
    "phase_margin_deg": 0.93,
    "gain_margin": 0.8,
    "delay_margin": 0.85,
    "disk_margin": 0.85,
}
"""Lower limit of margins as a share of the value; twice the integrator step costs as much."""
PIN_DIGITS = 3
MAX_COUNTED_GAIN_MARGIN = 20.0
"""Gain margins count up to this value; larger ones are ample, and depend on the physics step."""
LIMIT_WITHOUT_EFFECT = SpecLimit(min=-1e300)
"""A limit without effect, which only makes a number be measured."""
PIN_LOG_SHARES = {"rise_time": 0.25, "lag": 0.25, "measured_rise_time": 0.25}
"""Numbers of a log with limits on both sides, at this share of the value.

This is the usual difference between flights of one plan: in 34 pairs of real flights of one
trajectory (NanoBench), the second is within each limit of the first in 91 to 100 %."""
PIN_LOG_UPPER_LIMITS = {
    "overshoot": (1.0, 5.0),
    "measured_overshoot": (1.0, 5.0),
    "settling_time": (1.5, 0.0),
    "tracking_error": (1.5, 0.0),
    "mean_rotor_use": (1.0, 0.1),
    "saturation": (1.0, 10.0),
    "trim": (1.0, 0.1),
    "peak_tilt": (1.5, 0.0),
}
"""Numbers of a log with an upper limit only: a factor on the measured value, and an offset."""


def step_limits(measured: Mapping[str, float]) -> dict[str, SpecLimit]:
    """Return limits of those metrics of a step that have a value."""
    found = {}
    for name, value in measured.items():
        if not math.isfinite(value):
            continue
        if name in PIN_SHARES or name == "peak":
            room = PIN_SHARES.get(name, PIN_PEAK_SHARE) * abs(value)
            found[name] = limit_between(value - room, value + room)
        elif name in PIN_SPANS:
            found[name] = limit_between(value - PIN_SPANS[name], value + PIN_SPANS[name])
        else:
            times, more = PIN_UPPER_LIMITS[name]
            found[name] = SpecLimit(max=_rounded_limit(times * value + more, up=True))
    return found


def load_tolerances(load: str, peak: float) -> dict[str, Tolerance]:
    """Return the tolerance of the response to a load."""
    return {
        AXIS_SIGNALS[load]: Tolerance(absolute=_rounded_limit(LOAD_CURVE_SHARE * peak, up=True))
    }


def step_tolerances(axis: str, amplitude: float) -> dict[str, Tolerance]:
    """Return the tolerances of the curves of a step along an axis."""
    return {
        signal: Tolerance(absolute=_rounded_limit(max(share * abs(amplitude), least), up=True))
        for signal, (share, least) in PIN_CURVE_TOLERANCES[axis].items()
    }


def margin_limits(measured: Mapping[str, float]) -> dict[str, SpecLimit]:
    """Return limits of those margins of a loop that have a value."""
    found = {}
    for name, value in measured.items():
        if not math.isfinite(value):
            continue
        if name == "crossover":
            found[name] = limit_between(
                (1.0 - PIN_CROSSOVER_SHARE) * value, (1.0 + PIN_CROSSOVER_SHARE) * value
            )
        elif name in PIN_MARGIN_SHARES and value > 0.0:
            found[name] = SpecLimit(min=_rounded_limit(_lower_margin_limit(name, value), up=False))
    return found


def _lower_margin_limit(name: str, value: float) -> float:
    """Return the lower limit of a margin; a gain margin is a factor above 1."""
    if name == "gain_margin":
        return 1.0 + PIN_MARGIN_SHARES[name] * (min(value, MAX_COUNTED_GAIN_MARGIN) - 1.0)
    return PIN_MARGIN_SHARES[name] * value


def limit_between(low: float, high: float) -> SpecLimit:
    """Return a limit with few digits around a span; its numbers are never below 0."""
    if low <= 0.0:
        return SpecLimit(max=_rounded_limit(high, up=True))
    return SpecLimit(min=_rounded_limit(low, up=False), max=_rounded_limit(high, up=True))


def _rounded_limit(value: float, *, up: bool) -> float:
    """Return a number with few digits, on the safe side."""
    if value == 0.0:
        return 0.0
    unit = 10.0 ** (math.floor(math.log10(abs(value))) + 1 - PIN_DIGITS)
    steps = math.ceil(value / unit) if up else math.floor(value / unit)
    return float(f"{steps * unit:.{PIN_DIGITS + 1}g}")


def log_limit(name: str, values: list[float]) -> SpecLimit:
    """Return the limit of a metric; a log has one value of it, or one for each step."""
    if name in PIN_LOG_SHARES:
        return limit_between(
            (1.0 - PIN_LOG_SHARES[name]) * min(values), (1.0 + PIN_LOG_SHARES[name]) * max(values)
        )
    times, more = PIN_LOG_UPPER_LIMITS[name]
    return limit_between(0.0, times * max(values) + more)
