"""How much room a pinned flight has around what was measured."""

import math
from collections.abc import Mapping

from workbench.design.regress.spec import Limit, Tolerance

SHARES = {"rise_time": 0.12, "peak_tilt": 0.12}
"""Numbers that are held from both sides, with this share of room."""
SPANS = {"overshoot": 2.0, "steady_state_error": 0.5, "peak_rotor_use": 0.05}
"""Others that are, with so much room [%, %, 1]."""
MOST = {"settling_time": (1.4, 0.0), "coupling_z": (1.5, 0.01), "coupling_yaw": (1.5, 0.005)}
"""Numbers that may not become larger: than so many times what they were, and so much more."""
MEASURED = (*SHARES, *SPANS, *MOST)
"""All that is limited of a step."""
CURVES = {
    "x": {"v_x": (0.015, 0.002), "p_x": (0.002, 0.0005)},
    "y": {"v_y": (0.015, 0.002), "p_y": (0.002, 0.0005)},
    "z": {"v_z": (0.02, 0.002), "p_z": (0.0016, 0.0005)},
    "yaw": {"yaw_rate": (0.02, 0.0005), "yaw": (0.003, 0.0002)},
}
"""Curves of an axis: how far each may be off, as share of the amplitude, and at least [SI].

Half and twice the integrator's step stay within that; a gain of 0.7 times its value does not.
"""
CROSSOVER = 0.08
"""Room of crossover frequencies, to both sides."""
LEAST = {"phase_margin": 0.93, "gain_margin": 0.8, "delay_margin": 0.85, "disk_margin": 0.85}
"""Margins may not become smaller than this share; twice the integrator's step takes as much."""
DIGITS = 3

MUCH = 20.0
"""A larger gain margin is none that a loop is in want of, and follows the physics step."""


def step_limits(measured: Mapping[str, float]) -> dict[str, Limit]:
    """Return limits of a step's metrics, those that have a value."""
    found = {}
    for name, value in measured.items():
        if not math.isfinite(value):
            continue
        if name in SHARES:
            room = SHARES[name] * abs(value)
            found[name] = _between(value - room, value + room)
        elif name in SPANS:
            found[name] = _between(value - SPANS[name], value + SPANS[name])
        else:
            times, more = MOST[name]
            found[name] = Limit(max=_rounded(times * value + more, up=True))
    return found


def step_tolerances(axis: str, amplitude: float) -> dict[str, Tolerance]:
    """Return how far the curves of a step along an axis may be from their baselines."""
    return {
        signal: Tolerance(absolute=_rounded(max(share * abs(amplitude), least), up=True))
        for signal, (share, least) in CURVES[axis].items()
    }


def margin_limits(measured: Mapping[str, float]) -> dict[str, Limit]:
    """Return limits of a loop's margins, those that have a value."""
    found = {}
    for name, value in measured.items():
        if not math.isfinite(value):
            continue
        if name == "crossover":
            found[name] = _between((1.0 - CROSSOVER) * value, (1.0 + CROSSOVER) * value)
        elif name in LEAST and value > 0.0:
            found[name] = Limit(min=_rounded(_less(name, value), up=False))
    return found


def _less(name: str, value: float) -> float:
    """Return the least that a margin may come to; a gain margin is a factor above 1."""
    if name == "gain_margin":
        return 1.0 + LEAST[name] * (min(value, MUCH) - 1.0)
    return LEAST[name] * value


def _between(low: float, high: float) -> Limit:
    """Return a limit with few digits around a span; none of these numbers can be below 0."""
    if low <= 0.0:
        return Limit(max=_rounded(high, up=True))
    return Limit(min=_rounded(low, up=False), max=_rounded(high, up=True))


def _rounded(value: float, *, up: bool) -> float:
    """Return a number with few digits, on the safe side."""
    if value == 0.0:
        return 0.0
    unit = 10.0 ** (math.floor(math.log10(abs(value))) + 1 - DIGITS)
    steps = math.ceil(value / unit) if up else math.floor(value / unit)
    return float(f"{steps * unit:.{DIGITS + 1}g}")
