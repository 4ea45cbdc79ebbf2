"""The measurement of each metric that a spec can limit."""

import math
from collections.abc import Callable
from enum import Enum
from functools import partial
from typing import NamedTuple

import numpy as np

from workbench.common.errors import find_row
from workbench.design.metrics import find_metric
from workbench.design.regress.flight import Flight, JudgedLog, UnknownError
from workbench.design.regress.signals import POINT, USE
from workbench.design.regress.spec import OF
from workbench.design.reproduce import mean_until
from workbench.design.response_metrics import (
    AT_THE_END,
    FROM_REST,
    NOISE_FROM,
    NUMBERS,
    crossing_time,
    lag,
    noise,
)
from workbench.design.step_response import axis_force, coupling
from workbench.scenario.axes import AXES, find_axis
from workbench.session.recording import Recording

HOVER = 0.5
"""Time before the edge for means [s]."""
FULL = 0.995
"""Share of a rotor's speed limit from which on a command counts as saturated."""
LAG_SAMPLES = 8
LAG_STEPS = 300
"""Smallest number of samples of a response, and largest number of lags tried."""
TWICE = NOISE_FROM / 0.45
"""Smallest sampling rate to measure noise [Hz]."""
MEASURED = ("measured_rise_time", "measured_overshoot", "measured_final")
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

    def measured(self, flight: Flight) -> tuple[float, str]:
        """Return its value in a flight, and why that means little, else "".

        Raises:
            UnknownError: if the flight is from a log without the inputs.
        """
        reads = self.reads
        if self.need in (Need.SIGNAL, Need.COMMAND) or self.signal:
            name = self.signal or flight.signal
            reads = (name,) if POINT in name else flight.find_signal(name).reads
        known = flight.knowing(reads)
        value = self.of(known)
        if self.need is Need.LOOP and math.isnan(value):
            raise UnknownError(_WHY_NAN)
        doubts = (flight.doubt if self.name in (*FROM_REST, *AT_THE_END) else "", known.known)
        return value, "; ".join(filter(None, doubts))

    def unit_of(self, flight: Flight) -> str:
        """Return the unit in a flight."""
        if self.name == "mean_force":
            return find_axis(flight.axis).force_unit.replace("·", " ")
        name = self.signal or flight.signal
        unit = flight.find_signal(name).unit if name else ""
        return find_metric(self.name.partition(OF)[0]).unit_for(unit)


def find_measure(name: str) -> Measure:
    """Return the measurement of a named metric; `mean of imu.f_z` works for any signal.

    Raises:
        WorkbenchError: if the name is unknown.
    """
    statistic, of, signal = name.partition(OF)
    if not of:
        return find_row("metric", name, MEASURES)
    statistics = [measure for measure in MEASURES if measure.need is Need.SIGNAL]
    found = find_row("statistic of a signal", statistic, statistics)
    return Measure(name, Need.NOTHING, partial(found.of, signal=signal), signal=signal)


def _t90(flight: Flight) -> float:
    assert flight.command is not None
    return crossing_time(flight.time, flight.response, 0.9 * flight.command)


def _mean_acceleration(flight: Flight) -> float:
    assert flight.command is not None
    return (0.9 * flight.command - float(flight.response[0])) / _t90(flight)


def _mean_force(flight: Flight) -> float:
    end = _t90(flight)
    if math.isnan(end):
        return math.nan
    return mean_until(flight.time, axis_force(flight.judged, flight.axis), end)


def _step(flight: Flight, name: str) -> float:
    if flight.load:
        return float(getattr(flight.loaded, name))
    return float(getattr(flight.step, name)[0])


def _of_signal(flight: Flight, of: Callable[[np.ndarray], float], signal: str = "") -> float:
    values = flight.curve(signal or flight.signal).values
    with np.errstate(invalid="ignore"):  # a range may be infinite: some become NaN
        return float(of(values))


def _noise(flight: Flight, signal: str = "") -> float:
    curve = flight.curve(signal or flight.signal)
    found = noise(curve.time, curve.values)
    if math.isnan(found):
        raise UnknownError(
            f"{signal or flight.signal} has no half second without a gap at {TWICE:g} Hz or more"
        )
    return found


def _tracking_error(flight: Flight) -> float:
    followed = flight.followed
    judged = followed.time >= flight.edge - 1e-9
    return float(np.sqrt(np.mean((followed.setpoint - followed.response)[judged] ** 2)))


def _lag(flight: Flight) -> float:
    """Return the lag with the smallest error on a grid, with parabolic interpolation."""
    time, setpoint, response, longest = flight.followed
    if len(time) < LAG_SAMPLES or np.ptp(setpoint) < 1e-9:
        return math.nan
    step = max(float(np.median(np.diff(time))), longest / LAG_STEPS)
    lags = np.arange(0.0, longest + step, step)
    found = lag(time, setpoint, response, lags)
    return found if found < lags[-1] else math.nan


def _measured(flight: JudgedLog, name: str) -> float:
    return flight.measured[name]


def _saturation(flight: Flight) -> float:
    limits = np.array([rotor.max_rot_velocity for rotor in flight.recording.vehicle.rotors])
    full = (flight.judged.commanded_speeds >= FULL * limits).any(axis=1)
    return 100.0 * float(full.mean())


def _uses(flight: Flight) -> np.ndarray:
    """Return the mean share of the speed limit of each rotor, (n)."""
    limits = np.array([rotor.max_rot_velocity for rotor in flight.recording.vehicle.rotors])
    return np.asarray(flight.judged.rotor_speeds.mean(axis=0) / limits)


def _coupling(flight: Flight, axis: str) -> float:
    return float(getattr(coupling(flight.judged, flight.axis), axis))


def _peak_speed(flight: Flight) -> float:
    return float(np.linalg.norm(flight.judged.v_WB, axis=1).max())


def _hover(flight: Flight) -> Recording:
    """Return the half second before the edge."""
    hover = flight.before.between(flight.edge - HOVER, flight.edge)
    if not len(hover.time) or hover.time[-1] - hover.time[0] < 0.9 * HOVER:
        raise UnknownError(
            f"the log does not include the {HOVER:g} s before {flight.edge:.4g} s: name a span that"
            " begins later"
        )
    return hover


def _hover_speeds(flight: Flight) -> np.ndarray:
    """Return the mean speed of each rotor before the edge [rad/s]."""
    return np.asarray(_hover(flight).rotor_speeds.mean(axis=0))


def _hover_thrust(flight: Flight) -> float:
    return float(_hover(flight).total_thrust.mean())


MEASURES: tuple[Measure, ...] = (
    *(Measure(name, Need.COMMAND, partial(_step, name=name)) for name in NUMBERS),
    Measure("t90", Need.COMMAND, _t90),
    Measure("mean_acceleration", Need.COMMAND, _mean_acceleration),
    Measure("mean_force", Need.AXIS, _mean_force),
    Measure("minimum", Need.SIGNAL, partial(_of_signal, of=np.min)),
    Measure("maximum", Need.SIGNAL, partial(_of_signal, of=np.max)),
    Measure("mean", Need.SIGNAL, partial(_of_signal, of=np.mean)),
    Measure("standard_deviation", Need.SIGNAL, partial(_of_signal, of=np.std)),
    Measure("rms", Need.SIGNAL, partial(_of_signal, of=lambda values: np.sqrt(np.mean(values**2)))),
    Measure("final", Need.SIGNAL, partial(_of_signal, of=lambda values: values[-1])),
    Measure("noise", Need.SIGNAL, _noise),
    Measure("tracking_error", Need.LOOP, _tracking_error),
    Measure("lag", Need.LOOP, _lag),
    Measure("steps", Need.LOOP, lambda flight: float(len(flight.parts))),
    *(Measure(name, Need.LOG, partial(_measured, name=name), (name,)) for name in MEASURED),
    *(
        Measure(f"coupling_{axis}", Need.NOTHING, partial(_coupling, axis=axis), reads)
        for axis, reads in zip(AXES, (*3 * [("p_WB",)], ("q_WB",)), strict=True)
    ),
    Measure(
        "peak_rotor_use",
        Need.NOTHING,
        lambda flight: float(flight.judged.rotor_use.max()),
        (USE,),
    ),
    Measure("mean_rotor_use", Need.NOTHING, lambda flight: float(_uses(flight).mean()), (USE,)),
    Measure("saturation", Need.NOTHING, _saturation, ("commanded_speeds",)),
    Measure("trim", Need.NOTHING, lambda flight: float(np.ptp(_uses(flight))), (USE,)),
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
