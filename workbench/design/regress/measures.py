"""The measurement of each metric that a spec can limit."""

import math
from collections.abc import Callable
from enum import Enum
from functools import partial
from typing import NamedTuple

import numpy as np

from workbench.common.errors import find_named_row
from workbench.design.metrics import find_metric
from workbench.design.regress.case_log import JudgedLog
from workbench.design.regress.flight import CaseFlight, MissingInputError
from workbench.design.regress.signals import ROTOR_USE_INPUT, SENSOR_SEPARATOR
from workbench.design.regress.spec import STATISTIC_SEPARATOR
from workbench.design.reproduce import mean_until
from workbench.design.response_metrics import NOISE_FROM_HZ, crossing_time, noise_rms, response_lag
from workbench.design.step_metrics import FROM_REST_NUMBERS, STEADY_STATE_NUMBERS, STEP_NUMBERS
from workbench.design.step_response import axis_force, coupling
from workbench.scenario.axes import AXIS_NAMES, find_axis
from workbench.session.recording import Recording

HOVER_WINDOW_S = 0.5
"""Time before the edge for means [s]."""
SATURATED_COMMAND_SHARE = 0.995
"""Share of a rotor's speed limit from which on a command counts as saturated."""
MIN_LAG_SAMPLES = 8
MAX_LAG_STEPS = 300
"""Smallest number of samples of a response, and largest number of lags tried."""
MIN_NOISE_RATE_HZ = NOISE_FROM_HZ / 0.45
"""Smallest sampling rate to measure noise [Hz]."""
LOOP_LOG_METRICS = ("measured_rise_time", "measured_overshoot", "measured_final")
"""Metrics from the step response of a loop over a whole log."""
_WHY_NAN = "the setpoint does not move, or the response follows it too late or not at all"


class Need(Enum):
    """The requirements of a metric on a case."""

    NOTHING = ""
    SIGNAL = "a signal"
    COMMAND = "a signal and a command, or a log and a loop"
    LOOP = "an axis, or a log and a loop"
    LOG = "a log and a loop"
    AXIS = "an axis"
    HOVER = "an edge, half a second or more after the flight's begin"


class Measure(NamedTuple):
    """The measurement of one metric.

    Attributes:
        name: of the metric.
        need: requirements on the case.
        of: returns its value in a flight.
        reads: arrays of the recording used, which a log may lack.
        signal: the one measured; "" for the judged one.
    """

    name: str
    need: Need
    of: Callable[..., float]
    reads: tuple[str, ...] = ()
    signal: str = ""

    def measured(self, flight: CaseFlight) -> tuple[float, str]:
        """Return its value in a flight, and why that means little, else "".

        Raises:
            UnknownError: if the flight is from a log without the inputs.
        """
        reads = self.reads
        if self.need in (Need.SIGNAL, Need.COMMAND) or self.signal:
            name = self.signal or flight.signal
            reads = (name,) if SENSOR_SEPARATOR in name else flight.find_signal(name).reads
        known = flight.knowing(reads)
        value = self.of(known)
        if self.need is Need.LOOP and math.isnan(value):
            raise MissingInputError(_WHY_NAN)
        doubts = (
            flight.doubt if self.name in (*FROM_REST_NUMBERS, *STEADY_STATE_NUMBERS) else "",
            known.known,
        )
        return value, "; ".join(filter(None, doubts))

    def unit_of(self, flight: CaseFlight) -> str:
        """Return the unit in a flight."""
        if self.name == "mean_force":
            return find_axis(flight.axis).force_unit.replace("·", " ")
        name = self.signal or flight.signal
        unit = flight.find_signal(name).unit if name else ""
        return find_metric(self.name.partition(STATISTIC_SEPARATOR)[0]).unit_for(unit)


def find_measure(name: str) -> Measure:
    """Return the measurement of a named metric; `mean of imu.f_z` works for any signal.

    Raises:
        WorkbenchError: if the name is unknown.
    """
    statistic, of, signal = name.partition(STATISTIC_SEPARATOR)
    if not of:
        return find_named_row("metric", name, METRIC_MEASURES)
    statistics = [measure for measure in METRIC_MEASURES if measure.need is Need.SIGNAL]
    found = find_named_row("statistic of a signal", statistic, statistics)
    return Measure(name, Need.NOTHING, partial(found.of, signal=signal), signal=signal)


def _t90(flight: CaseFlight) -> float:
    assert flight.command is not None
    return crossing_time(flight.time, flight.response, 0.9 * flight.command)


def _mean_acceleration(flight: CaseFlight) -> float:
    assert flight.command is not None
    return (0.9 * flight.command - float(flight.response[0])) / _t90(flight)


def _mean_force(flight: CaseFlight) -> float:
    end = _t90(flight)
    if math.isnan(end):
        return math.nan
    return mean_until(flight.time, axis_force(flight.judged, flight.axis), end)


def _step(flight: CaseFlight, name: str) -> float:
    return float(getattr(flight.loaded if flight.load else flight.step, name))


def _of_signal(flight: CaseFlight, of: Callable[[np.ndarray], float], signal: str = "") -> float:
    values = flight.curve(signal or flight.signal).values
    with np.errstate(invalid="ignore"):  # a range may be infinite: some become NaN
        return float(of(values))


def _signal_noise(flight: CaseFlight, signal: str = "") -> float:
    curve = flight.curve(signal or flight.signal)
    found = noise_rms(curve.time, curve.values)
    if math.isnan(found):
        raise MissingInputError(
            f"{signal or flight.signal} has no half second without a gap at {MIN_NOISE_RATE_HZ:g} "
            "Hz or more"
        )
    return found


def _tracking_error(flight: CaseFlight) -> float:
    followed = flight.followed
    judged = followed.time >= flight.edge - 1e-9
    return float(np.sqrt(np.mean((followed.setpoint - followed.response)[judged] ** 2)))


def _least_error_lag(flight: CaseFlight) -> float:
    """Return the lag with the smallest error on a grid, with parabolic interpolation."""
    time, setpoint, response, longest = flight.followed
    if len(time) < MIN_LAG_SAMPLES or np.ptp(setpoint) < 1e-9:
        return math.nan
    step = max(float(np.median(np.diff(time))), longest / MAX_LAG_STEPS)
    lags = np.arange(0.0, longest + step, step)
    found = response_lag(time, setpoint, response, lags)
    return found if found < lags[-1] else math.nan


def _loop_log_metric(flight: JudgedLog, name: str) -> float:
    return flight.measured[name]


def _saturation(flight: CaseFlight) -> float:
    limits = np.array([rotor.max_rot_velocity for rotor in flight.recording.vehicle.rotors])
    full = (flight.judged.commanded_speeds >= SATURATED_COMMAND_SHARE * limits).any(axis=1)
    return 100.0 * float(full.mean())


def _rotor_uses(flight: CaseFlight) -> np.ndarray:
    """Return the mean share of the speed limit of each rotor, (n)."""
    limits = np.array([rotor.max_rot_velocity for rotor in flight.recording.vehicle.rotors])
    return np.asarray(flight.judged.rotor_speeds.mean(axis=0) / limits)


def _coupling(flight: CaseFlight, axis: str) -> float:
    return float(getattr(coupling(flight.judged, flight.axis), axis))


def _peak_speed(flight: CaseFlight) -> float:
    return float(np.linalg.norm(flight.judged.v_WB, axis=1).max())


def _hover_before_edge(flight: CaseFlight) -> Recording:
    """Return the half second before the edge."""
    hover = flight.before.between(flight.edge - HOVER_WINDOW_S, flight.edge)
    if not len(hover.time) or hover.time[-1] - hover.time[0] < 0.9 * HOVER_WINDOW_S:
        raise MissingInputError(
            f"the log does not include the {HOVER_WINDOW_S:g} s before {flight.edge:.4g} s: name "
            "a span that"
            " begins later"
        )
    return hover


def _hover_speeds(flight: CaseFlight) -> np.ndarray:
    """Return the mean speed of each rotor before the edge [rad/s]."""
    return np.asarray(_hover_before_edge(flight).rotor_speeds.mean(axis=0))


def _hover_thrust(flight: CaseFlight) -> float:
    return float(_hover_before_edge(flight).total_thrust.mean())


METRIC_MEASURES: tuple[Measure, ...] = (
    *(Measure(name, Need.COMMAND, partial(_step, name=name)) for name in STEP_NUMBERS),
    Measure("t90", Need.COMMAND, _t90),
    Measure("mean_acceleration", Need.COMMAND, _mean_acceleration),
    Measure("mean_force", Need.AXIS, _mean_force),
    Measure("minimum", Need.SIGNAL, partial(_of_signal, of=np.min)),
    Measure("maximum", Need.SIGNAL, partial(_of_signal, of=np.max)),
    Measure("mean", Need.SIGNAL, partial(_of_signal, of=np.mean)),
    Measure("standard_deviation", Need.SIGNAL, partial(_of_signal, of=np.std)),
    Measure("rms", Need.SIGNAL, partial(_of_signal, of=lambda values: np.sqrt(np.mean(values**2)))),
    Measure("final", Need.SIGNAL, partial(_of_signal, of=lambda values: values[-1])),
    Measure("noise", Need.SIGNAL, _signal_noise),
    Measure("tracking_error", Need.LOOP, _tracking_error),
    Measure("lag", Need.LOOP, _least_error_lag),
    Measure("steps", Need.LOOP, lambda flight: float(len(flight.parts))),
    *(
        Measure(name, Need.LOG, partial(_loop_log_metric, name=name), (name,))
        for name in LOOP_LOG_METRICS
    ),
    *(
        Measure(f"coupling_{axis}", Need.NOTHING, partial(_coupling, axis=axis), reads)
        for axis, reads in zip(AXIS_NAMES, (*3 * [("p_WB",)], ("q_WB",)), strict=True)
    ),
    Measure(
        "peak_rotor_use",
        Need.NOTHING,
        lambda flight: float(flight.judged.rotor_use.max()),
        (ROTOR_USE_INPUT,),
    ),
    Measure(
        "mean_rotor_use",
        Need.NOTHING,
        lambda flight: float(_rotor_uses(flight).mean()),
        (ROTOR_USE_INPUT,),
    ),
    Measure("saturation", Need.NOTHING, _saturation, ("commanded_speeds",)),
    Measure(
        "trim", Need.NOTHING, lambda flight: float(np.ptp(_rotor_uses(flight))), (ROTOR_USE_INPUT,)
    ),
    Measure(
        "peak_thrust",
        Need.NOTHING,
        lambda flight: float(flight.judged.total_thrust.max()),
        ("thrusts",),
    ),
    Measure("peak_tilt", Need.NOTHING, lambda flight: float(flight.judged.tilt.max()), ("q_WB",)),
    Measure("peak_speed", Need.NOTHING, _peak_speed, ("v_WB",)),
    Measure("hover_thrust", Need.HOVER, _hover_thrust, ("thrusts",)),
    Measure(
        "hover_rotor_speed",
        Need.HOVER,
        lambda flight: float(_hover_speeds(flight).mean()),
        ("rotor_speeds",),
    ),
    Measure(
        "hover_rotor_spread",
        Need.HOVER,
        lambda flight: float(np.ptp(_hover_speeds(flight))),
        ("rotor_speeds",),
    ),
)
