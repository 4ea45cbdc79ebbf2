"""Numbers of flown responses: to a step, to a load, and to any setpoint.

Those of a step, of one response or of many at once, are by python-control's definitions.

They equal `control.step_info`, which takes one response at a time, and which comes with all of
scipy.signal: half a second to load.

The definitions hold for a step that begins at rest and settles, flown with parameters that do not
change; `why_withheld` names the condition that a step does not meet, and `withheld` takes away the
numbers that depend on it.

A step has settled if it stays within the settling band for the last fifth of its time, and if the
transient of the linear closed loop has decayed by its end, see `linear_step.decay_time`. The
response alone does not tell: with integral action it peaks flat long before it settles.
`step_duration` is how long a step is flown unless the user says otherwise, so all who measure the
same step get the same numbers.

Those of a load are of x, the deviation from where the drone was before it. The peak is the largest
|x|, the settling time that from which on x stays within 5 % of the peak of its steady state, and
the steady-state error what then is left of x. A law with integral action leaves nothing: there the
settling time is that until the drone is back within 5 % of the peak.
"""

import dataclasses
import math
from dataclasses import dataclass

import numpy as np

LOWER, UPPER = 0.1, 0.9
"""Shares of the steady state between which the response rises."""
SETTLED = 0.02
"""It has settled within this share of the steady state."""
LAST_PART = 0.2
"""It has settled if it stays there for this last share of the time flown, at least.

`control.step_info` takes the last sample for the steady state, whatever comes before it. With this
share a first-order response that counts as settled is within 2 % of where it would end; one that
is flown for three time constants is 5 % away, and does not count.
"""
DECAYED = 0.02 * SETTLED
"""Share of the steady state below which the transient of the linear closed loop has decayed.

The last sample is the steady state, so what is left of a slow mode then is its error, and that of
the settling time is this share of the band over the mode's rate.
"""
USUAL_DURATION, LONGEST_DURATION = 5.0, 120.0
"""Usual and longest time for which a step is flown without a duration of the user's [s]."""
_WHOLE = 0.5
"""Such a time is a multiple of this [s]."""
NO_PEAK = 0.1
"""A response with less overshoot rises to its steady state, and has no peak [%]."""
FROM_REST = ("rise_time", "settling_time", "overshoot", "undershoot")
"""Numbers that depend on where the response begins, and on its steady state."""
AT_THE_END = ("steady_state_value", "steady_state_error")
"""Numbers that depend on the steady state alone."""
BACK = 0.05
"""Share of the peak within which it has settled."""
LAGS = np.arange(0.0, 1.2, 0.01)
"""That a position may have [s]."""
NOISE_FROM = 20.0
"""What of a signal is faster is noise [Hz]: the rate loops of the shipped drones end below it."""
_EDGE = 0.1
"""Of a stretch, that the filter needs to begin and to end [s]."""


@dataclass(frozen=True)
class ResponseMetrics:
    """What `StepMetrics` has of one response, for N of them; (N) each.

    NaN for a response that does not reach the end; its peak is infinite, as python-control has it.

    Attributes:
        rise_time: from 10 % to 90 % of the steady state [s].
        settling_time: until it stays within 2 % of the steady state [s].
        overshoot: above the steady state [% of it].
        undershoot: to the wrong side of where it began [% of the steady state].
        peak: largest absolute value.
        peak_time: when [s].
        steady_state_value: value at the end.
        steady_state_error: of the steady state against the command [% of it].
        t90: when it first reaches 90 % of the command [s]; NaN if it never does.
        start: value at time 0.
    """

    rise_time: np.ndarray
    settling_time: np.ndarray
    overshoot: np.ndarray
    undershoot: np.ndarray
    peak: np.ndarray
    peak_time: np.ndarray
    steady_state_value: np.ndarray
    steady_state_error: np.ndarray
    t90: np.ndarray
    start: np.ndarray

    def settled(self, duration: float, decay: float | np.ndarray = 0.0) -> np.ndarray:
        """Return which stay within 2 % of their last value for the last fifth of a time [s].

        Args:
            duration: flown from time 0 on [s].
            decay: time by which the transient of the linear closed loop has decayed [s], for all or
                for each (N); 0 if unknown.
        """
        with np.errstate(invalid="ignore"):
            stays = self.settling_time <= (1.0 - LAST_PART) * duration
        return np.asarray(stays & _decayed(duration, decay))

    def at_rest(self, command: float) -> np.ndarray:
        """Return which begin within 2 % of the command from 0."""
        with np.errstate(invalid="ignore"):
            return np.asarray(np.abs(self.start) <= SETTLED * abs(command))

    def withheld(
        self, duration: float, command: float, decay: float | np.ndarray = 0.0
    ) -> "ResponseMetrics":
        """Return them with NaN for the numbers that mean nothing.

        Args:
            duration: flown from time 0 on [s].
            command: as for `response_metrics`.
            decay: as for `settled`.
        """
        settled, at_rest = self.settled(duration, decay), self.at_rest(command)
        kept = dict.fromkeys(FROM_REST, settled & at_rest) | dict.fromkeys(AT_THE_END, settled)
        with np.errstate(invalid="ignore"):
            kept["peak_time"] = settled & (self.overshoot > NO_PEAK)
        return dataclasses.replace(
            self,
            **{name: np.where(keep, getattr(self, name), np.nan) for name, keep in kept.items()},
        )


def _decayed(duration: float, decay: float | np.ndarray) -> np.ndarray:
    """Return whether a time [s] is long enough for transients that need a decay time [s]."""
    return np.asarray(np.asarray(decay) <= duration + 1e-6)


def step_duration(decay: float) -> float:
    """Return how long to fly a step after its edge [s], given the decay time of its transient [s].

    A transient that does not decay within `LONGEST_DURATION` is flown for the usual time: its
    numbers are withheld.
    """
    if not decay <= LONGEST_DURATION:
        return USUAL_DURATION
    return max(USUAL_DURATION, _WHOLE * math.ceil(decay / _WHOLE))


def why_withheld(
    metrics: ResponseMetrics,
    duration: float,
    command: float,
    *,
    decay: float = 0.0,
    changed: bool = False,
) -> str:
    """Return why numbers of the first response mean nothing, as a sentence; "" if they all do.

    Args:
        metrics: as `response_metrics` gives them.
        duration: flown from time 0 on [s].
        command: as for `response_metrics`.
        decay: as for `ResponseMetrics.settled`.
        changed: whether parameters changed while it was flown.
    """
    if changed:
        return "parameters changed during the step; fly it again"
    if math.isinf(decay):
        return (
            "by the linear model, the response does not come to rest within "
            f"{LONGEST_DURATION:g} s; change the gains"
        )
    if not _decayed(duration, decay):
        return (
            f"by the linear model, the step needs {decay:.3g} s to settle, and was flown for "
            f"{duration:.3g} s; fly it for {step_duration(decay):g} s"
        )
    if not metrics.settled(duration)[0]:
        return f"the step has not settled within {duration:.3g} s; fly it for longer"
    if not metrics.at_rest(command)[0]:
        return "the step did not begin at rest; let the drone settle first"
    return ""


def response_metrics(time: np.ndarray, response: np.ndarray, command: float) -> ResponseMetrics:
    """Return the metrics of responses to a command given at time 0.

    Args:
        time: (M) from 0 [s].
        response: (N, M), at rest at 0.
        command: what they should come to, in their unit; not zero.
    """
    steady = response[:, -1]
    ends = np.isfinite(steady)
    sign = np.sign(steady)
    forward = sign[:, None] * response
    with np.errstate(divide="ignore", invalid="ignore"):
        outside = np.abs(response / steady[:, None] - 1.0) >= SETTLED
        above = np.abs(forward.max(axis=1)) - np.abs(steady)
        overshoot = np.where(above > 0.0, np.abs(100.0 * above / steady), 0.0)
        lowest = np.take_along_axis(response, forward.argmin(axis=1)[:, None], axis=1)[:, 0]
        undershoot = np.where(sign * lowest < 0.0, -100.0 * lowest / steady, 0.0)
        peaks = np.abs(response).argmax(axis=1)
        peak = np.abs(np.take_along_axis(response, peaks[:, None], axis=1)[:, 0])
    begin = _first(sign[:, None] * (response - LOWER * steady[:, None]) >= 0.0)
    end = _first(sign[:, None] * (response - UPPER * steady[:, None]) >= 0.0)
    size = len(time)
    settled = np.where(outside.any(axis=1), size - outside[:, ::-1].argmax(axis=1), 0)
    settling = np.where(settled < size, time[np.minimum(settled, size - 1)], np.nan)

    def known(values: np.ndarray, otherwise: float = np.nan) -> np.ndarray:
        return np.where(ends, values, otherwise)

    return ResponseMetrics(
        rise_time=known(time[end] - time[begin]),
        settling_time=known(settling),
        overshoot=known(overshoot),
        undershoot=known(undershoot),
        peak=known(peak, np.inf),
        peak_time=known(time[peaks], np.inf),
        steady_state_value=known(steady),
        steady_state_error=known(100.0 * np.abs(steady - command) / abs(command)),
        t90=crossing_times(time, response, UPPER * command),
        start=response[:, 0],
    )


def _first(true: np.ndarray) -> np.ndarray:
    """Return the index of the first true value of each row."""
    return true.argmax(axis=1)


def crossing_times(time: np.ndarray, response: np.ndarray, level: float) -> np.ndarray:
    """Return when responses (N, M) first reach a level (either sign), (N) [s], NaN if never."""
    reached = response * np.sign(level) >= abs(level)
    index = reached.argmax(axis=1)
    before = np.maximum(index - 1, 0)
    rows = np.arange(len(response))
    low, high = response[rows, before], response[rows, index]
    with np.errstate(divide="ignore", invalid="ignore"):
        part = np.where(index > 0, (level - low) / (high - low), 0.0)
    crossed = time[before] + part * (time[index] - time[before])
    return np.where(reached.any(axis=1), crossed, np.nan)


@dataclass(frozen=True)
class StepMetrics:
    """What `control.step_info` says of a response, and its distance from the command.

    NaN for what depends on beginning at rest or on settling, where the step did not.

    Attributes:
        rise_time: from 10 % to 90 % of the steady state [s].
        settling_time: until it stays within 2 % of the steady state [s].
        overshoot: above the steady state [% of it].
        undershoot: to the wrong side of where it began [% of the steady state].
        peak: largest absolute value.
        peak_time: when [s]; NaN for a response that rises to its steady state without a peak.
        steady_state_value: value at the end.
        steady_state_error: of the steady state against the command [% of it].
        withheld: why some are NaN, as a sentence; "" if none is for such a reason.
    """

    rise_time: float
    settling_time: float
    overshoot: float
    undershoot: float
    peak: float
    peak_time: float
    steady_state_value: float
    steady_state_error: float
    withheld: str = ""

    @property
    def numbers(self) -> dict[str, float]:
        """The numbers by name."""
        return {name: getattr(self, name) for name in NUMBERS}


NUMBERS = tuple(field.name for field in dataclasses.fields(StepMetrics))[:-1]
"""Names of what `StepMetrics` measures."""


def step_metrics(
    time: np.ndarray,
    response: np.ndarray,
    command: float,
    *,
    decay: float = 0.0,
    changed: bool = False,
) -> StepMetrics:
    """Return the metrics of a response to a command given at time 0.

    Args:
        time: (N) from 0 [s].
        response: (N), at rest at 0.
        command: what it should come to, in the response's unit; not zero.
        decay: as for `ResponseMetrics.settled`.
        changed: whether parameters changed while it was flown; then there are no numbers.
    """
    many = response_metrics(time, np.asarray(response, dtype=float)[None, :], command)
    duration = float(time[-1])
    kept = many.withheld(duration, command, decay)
    return StepMetrics(
        **{name: math.nan if changed else float(getattr(kept, name)[0]) for name in NUMBERS},
        withheld=why_withheld(many, duration, command, decay=decay, changed=changed),
    )


def number(value: float, form: str) -> str:
    """Return a number in a format such as ".3f", a dash where there is none."""
    return "—" if math.isnan(value) else format(value, form)


def crossing_time(time: np.ndarray, response: np.ndarray, level: float) -> float:
    """Return when a response first reaches `level` (either sign) [s], or NaN if it never does."""
    return float(crossing_times(time, np.asarray(response)[None, :], level)[0])


@dataclass(frozen=True)
class LoadMetrics:
    """What is measured of one response to a load; NaN where it has not settled.

    Attributes:
        peak: largest deviation, in the response's unit.
        peak_time: when [s].
        settling_time: until it stays within 5 % of the peak of its steady state [s].
        steady_state_error: deviation at the end [% of the peak].
        withheld: why some are NaN, as a sentence; "" if none is.
    """

    peak: float
    peak_time: float
    settling_time: float
    steady_state_error: float
    withheld: str = ""

    @property
    def numbers(self) -> dict[str, float]:
        """The numbers by name."""
        return {name: getattr(self, name) for name in LOAD_NUMBERS}


LOAD_NUMBERS = tuple(field.name for field in dataclasses.fields(LoadMetrics))[:-1]
"""Names of what `LoadMetrics` measures."""


def load_metrics(time: np.ndarray, response: np.ndarray, *, changed: bool = False) -> LoadMetrics:
    """Return the metrics of a response to a load that begins at time 0.

    Args:
        time: (N) from 0 [s].
        response: (N) deviation from where it was at 0.
        changed: whether parameters changed while it was flown.
    """
    size = np.abs(response)
    place = int(size.argmax())
    peak, duration = float(size[place]), float(time[-1])
    outside = np.flatnonzero(np.abs(response - response[-1]) > BACK * peak)
    first = outside[-1] + 1 if len(outside) else 0
    said = ""
    if changed:
        said = "parameters changed while the load acted; fly it again"
    elif not math.isfinite(peak):
        said = "the drone was lost"
    elif peak == 0.0 or time[first] > (1.0 - LAST_PART) * duration:
        said = f"the drone has not settled within {duration:.3g} s; let the load act for longer"
    return LoadMetrics(
        peak=math.nan if changed else peak,
        peak_time=math.nan if changed else float(time[place]),
        settling_time=math.nan if said else float(time[first]),
        steady_state_error=math.nan if said else 100.0 * float(size[-1]) / peak,
        withheld=said,
    )


def lag(
    time: np.ndarray, setpoint: np.ndarray, response: np.ndarray, lags: np.ndarray = LAGS
) -> float:
    """Return by how much a response (k) is late [s], by least squares with a gain and an offset.

    NaN where less than three samples are left behind the longest lag.

    Args:
        time: (k) [s].
        setpoint: (k).
        response: (k).
        lags: that are tried, rising from 0 [s].
    """
    known = time > time[0] + lags[-1]
    if known.sum() < 3:
        return math.nan
    found = []
    flown = response[known] - response[known].mean()
    for late in lags:
        past = np.interp(time[known] - late, time, setpoint)
        past = past - past.mean()
        power = float(past @ past)
        explained = float(past @ flown) ** 2 / power if power > 0.0 else 0.0
        found.append((-explained, float(late)))
    return min(found)[1]


def noise(time: np.ndarray, values: np.ndarray) -> float:
    """Return the root mean square of what of a signal is faster than `NOISE_FROM`.

    A Butterworth high-pass of order 4, run forwards and backwards over each stretch without a gap.
    NaN where samples come too slowly for that, or no stretch is half a second long.

    Args:
        time: (k), rising [s].
        values: (k).
    """
    from scipy.signal import butter, sosfiltfilt  # slow to load

    if len(time) < 2:
        return math.nan
    period = float(np.median(np.diff(time)))
    if not period < 0.45 / NOISE_FROM:
        return math.nan
    sections = butter(4, NOISE_FROM, "highpass", fs=1.0 / period, output="sos")
    edge = max(1, round(_EDGE / period))
    gaps = np.flatnonzero(np.diff(time) > 1.5 * period) + 1
    rest = [
        sosfiltfilt(sections, stretch)[edge:-edge]
        for stretch in np.split(values, gaps)
        if len(stretch) >= 5 * edge
    ]
    return float(np.sqrt(np.mean(np.concatenate(rest) ** 2))) if rest else math.nan
