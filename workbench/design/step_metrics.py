"""Numbers of responses to a step of a command.

Those of one response, or of many at once, by python-control's definitions. They equal
`control.step_info`, which takes one response at a time, and which comes with all of scipy.signal:
half a second to load. A search for gains takes the same numbers between samples
(`tune/flight_numbers.py`); `judge/sensitivity.py` takes them with their derivatives by gains.

The definitions hold for a step that begins at rest and settles, flown with parameters that do not
change; `why_withheld` names the condition that a step does not meet, and `step_metrics` withholds
the numbers that depend on it.

A step has settled if it stays within the settling band for the last fifth of its time, and if the
transient of the linear closed loop has decayed by its end, see `linear_step.decay_time`. The
response alone does not tell: with integral action it peaks flat long before it settles.
`step_duration` is how long a step is flown unless the user says otherwise, so all who measure the
same step get the same numbers.
"""

import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from workbench.design.metrics import FLOWN_METRICS

RISE_SHARES = (0.1, 0.9)
"""Shares of the steady state between which the response rises."""
SETTLING_BAND = 0.02
"""It has settled within this share of the steady state."""
SETTLED_LAST_SHARE = 0.2
"""It has settled if it stays there for this last share of the time flown, at least.

`control.step_info` takes the last sample for the steady state, whatever comes before it. With this
share a first-order response that counts as settled is within 2 % of where it would end; one that
is flown for three time constants is 5 % away, and does not count.
"""
DECAYED_SHARE = 0.02 * SETTLING_BAND
"""Share of the steady state below which the transient of the linear closed loop has decayed.

The last sample is the steady state, so what is left of a slow mode then is its error, and that of
the settling time is this share of the band over the mode's rate.
"""
USUAL_STEP_S, MAX_AUTO_STEP_S = 5.0, 120.0
"""Usual and longest time for which a step is flown without a duration of the user's [s]."""
_DURATION_STEP_S = 0.5
"""Such a time is a multiple of this [s]."""
MIN_PEAK_OVERSHOOT_PCT = 0.1
"""A response with less overshoot rises to its steady state, and has no peak [%]."""
FROM_REST_NUMBERS = ("rise_time", "settling_time", "overshoot", "undershoot")
"""Numbers that depend on where the response begins, and on its steady state."""
STEADY_STATE_NUMBERS = ("steady_state_value", "steady_state_error")
"""Numbers that depend on the steady state alone."""
STEP_NUMBERS = tuple(row.name for row in FLOWN_METRICS if row.name != "peak_rotor_use")
"""Names of what is measured of a response: all but the rotors' use."""


@dataclass(frozen=True)
class StepMetrics:
    """The numbers of a step: floats of one response, arrays (N) of N.

    NaN for what depends on beginning at rest or on settling, where the step did not, and for what
    was not measured.

    Attributes:
        rise_time: from 10 % to 90 % of the steady state [s].
        settling_time: until it stays within 2 % of the steady state [s].
        overshoot: above the steady state [% of it].
        undershoot: to the wrong side of where it began [% of the steady state].
        peak: largest absolute value; infinite for a response that does not reach the end.
        peak_time: when [s]; NaN for a response that rises to its steady state without a peak.
        steady_state_value: value at the end.
        steady_state_error: of the steady state against the command [% of it].
        peak_rotor_use: largest share of its speed limit at which any rotor ran, 0 .. 1.
        withheld: why some of one response are NaN, as a sentence; "" if none is for such a reason.
    """

    rise_time: Any = math.nan
    settling_time: Any = math.nan
    overshoot: Any = math.nan
    undershoot: Any = math.nan
    peak: Any = math.nan
    peak_time: Any = math.nan
    steady_state_value: Any = math.nan
    steady_state_error: Any = math.nan
    peak_rotor_use: Any = math.nan
    withheld: str = ""

    @property
    def numbers(self) -> dict[str, Any]:
        """The numbers of the response by name."""
        return {name: getattr(self, name) for name in STEP_NUMBERS}

    def to_json(self) -> dict[str, float | str]:
        """Return the numbers for JSON, by the names of python-control's `step_info`."""
        return step_info_json(self.numbers, self.withheld)


def step_info_json(numbers: Mapping[str, float], withheld: str) -> dict[str, float | str]:
    """Return numbers by the names that python-control's `step_info` has, such as RiseTime.

    The steady-state error, which it does not have, gets a name of the same form.
    """
    named = {"".join(map(str.capitalize, name.split("_"))): numbers[name] for name in numbers}
    return named | {"withheld": withheld}


def step_info(time: np.ndarray, response: np.ndarray, command: float) -> StepMetrics:
    """Return the numbers of responses to a command given at time 0, none of them withheld.

    Args:
        time: (M) from 0 [s].
        response: (M), or (N, M) of N, at rest at 0.
        command: what they should come to, in their unit; not zero.
    """
    rows = np.atleast_2d(np.asarray(response, dtype=float))
    steady = rows[:, -1]
    ends = np.isfinite(steady)
    sign = np.sign(steady)
    forward = sign[:, None] * rows
    with np.errstate(divide="ignore", invalid="ignore"):
        outside = np.abs(rows / steady[:, None] - 1.0) >= SETTLING_BAND
        above = np.abs(forward.max(axis=1)) - np.abs(steady)
        overshoot = np.where(above > 0.0, np.abs(100.0 * above / steady), 0.0)
        lowest = np.take_along_axis(rows, forward.argmin(axis=1)[:, None], axis=1)[:, 0]
        undershoot = np.where(sign * lowest < 0.0, -100.0 * lowest / steady, 0.0)
        peaks = np.abs(rows).argmax(axis=1)
        peak = np.abs(np.take_along_axis(rows, peaks[:, None], axis=1)[:, 0])
    begin, end = (
        (sign[:, None] * (rows - share * steady[:, None]) >= 0.0).argmax(axis=1)
        for share in RISE_SHARES
    )
    size = len(time)
    settled = np.where(outside.any(axis=1), size - outside[:, ::-1].argmax(axis=1), 0)
    settling = np.where(settled < size, time[np.minimum(settled, size - 1)], np.nan)

    def known(values: np.ndarray, otherwise: float = np.nan) -> Any:
        found = np.where(ends, values, otherwise)
        return found if np.ndim(response) == 2 else float(found[0])

    return StepMetrics(
        rise_time=known(time[end] - time[begin]),
        settling_time=known(settling),
        overshoot=known(overshoot),
        undershoot=known(undershoot),
        peak=known(peak, np.inf),
        peak_time=known(time[peaks], np.inf),
        steady_state_value=known(steady),
        steady_state_error=known(100.0 * np.abs(steady - command) / abs(command)),
    )


def step_metrics(
    time: np.ndarray,
    response: np.ndarray,
    command: float,
    *,
    decay: float | np.ndarray = 0.0,
    changed: bool = False,
    rests: bool = True,
    unsteady: str = "",
    peak_rotor_use: float | np.ndarray = math.nan,
) -> StepMetrics:
    """Return the numbers of responses to a command given at time 0, those that mean something.

    Args:
        time: (M) from 0 [s].
        response: (M), or (N, M) of N, at rest at 0.
        command: what they should come to, in their unit; not zero.
        decay: time by which the transient of the linear closed loop has decayed [s], for all or for
            each (N); 0 if unknown.
        changed: whether parameters changed while it was flown; then there are no numbers.
        rests: whether the drone was at rest before, as far as the response does not tell.
        unsteady: why there is no steady state before or after, as a sentence; "" if there may be.
        peak_rotor_use: largest share of its speed limit at which any rotor ran.
    """
    found = step_info(time, response, command)
    settled = _settled(found, float(time[-1]), decay) & (not unsteady)
    at_rest = _at_rest(response, command) & rests
    means = dict.fromkeys(FROM_REST_NUMBERS, settled & at_rest)
    means |= dict.fromkeys(STEADY_STATE_NUMBERS, settled)
    with np.errstate(invalid="ignore"):
        means["peak_time"] = settled & np.asarray(found.overshoot > MIN_PEAK_OVERSHOOT_PCT)
    one = np.ndim(response) == 1
    numbers = {
        name: np.where(means.get(name, True) & (not changed), value, np.nan)
        for name, value in found.numbers.items()
    }
    return StepMetrics(
        **{name: float(value) if one else value for name, value in numbers.items()},
        peak_rotor_use=peak_rotor_use,
        withheld=unsteady
        or why_withheld(
            found, time, response, command, decay=float(decay), changed=changed, rests=rests
        )
        if one
        else "",
    )


def why_withheld(
    found: StepMetrics,
    time: np.ndarray,
    response: np.ndarray,
    command: float,
    *,
    decay: float = 0.0,
    changed: bool = False,
    rests: bool = True,
) -> str:
    """Return why numbers of one response mean nothing, as a sentence; "" if they all do.

    Args: as for `step_metrics`, and
        found: as `step_info` gives them.
    """
    duration = float(time[-1])
    if changed:
        return "parameters changed during the step; fly it again"
    if math.isinf(decay):
        return (
            "by the linear model, the response does not come to rest within "
            f"{MAX_AUTO_STEP_S:g} s; change the gains"
        )
    if not _decayed(duration, decay):
        return (
            f"by the linear model, the step needs {decay:.3g} s to settle, and was flown for "
            f"{duration:.3g} s; fly it for {step_duration(decay):g} s"
        )
    if not _settled(found, duration, decay):
        return f"the step has not settled within {duration:.3g} s; fly it for longer"
    if not (rests and _at_rest(response, command)):
        return "the step did not begin at rest; let the drone settle first"
    return ""


def _settled(found: StepMetrics, duration: float, decay: float | np.ndarray) -> np.ndarray:
    """Return which stay within 2 % of their last value for the last fifth of a time [s]."""
    with np.errstate(invalid="ignore"):
        stays = np.asarray(found.settling_time <= (1.0 - SETTLED_LAST_SHARE) * duration)
    return stays & _decayed(duration, decay)


def _at_rest(response: np.ndarray, command: float) -> np.ndarray:
    """Return which begin within 2 % of the command from 0."""
    with np.errstate(invalid="ignore"):
        return np.asarray(np.abs(np.asarray(response)[..., 0]) <= SETTLING_BAND * abs(command))


def _decayed(duration: float, decay: float | np.ndarray) -> np.ndarray:
    """Return whether a time [s] is long enough for transients that need a decay time [s]."""
    return np.asarray(np.asarray(decay) <= duration + 1e-6)


def step_duration(decay: float) -> float:
    """Return how long to fly a step after its edge [s], given the decay time of its transient [s].

    A transient that does not decay within `MAX_AUTO_STEP_S` is flown for the usual time: its
    numbers are withheld.
    """
    if not decay <= MAX_AUTO_STEP_S:
        return USUAL_STEP_S
    return max(USUAL_STEP_S, _DURATION_STEP_S * math.ceil(decay / _DURATION_STEP_S))
