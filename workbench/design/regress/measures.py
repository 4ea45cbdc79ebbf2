"""How each metric that a spec can limit is measured of a flight."""

import math
from collections.abc import Callable
from enum import Enum
from functools import partial
from typing import NamedTuple

import numpy as np

from workbench.common.errors import find_row
from workbench.design.metrics import find_metric
from workbench.design.regress.flight import Flight
from workbench.design.regress.spec import OF
from workbench.design.reproduce import mean_until
from workbench.design.response_metrics import AT_THE_END, FROM_REST, NUMBERS, crossing_time
from workbench.design.step_response import axis_force, coupling
from workbench.scenario.axes import AXES, find_axis

HOVER = 0.5
"""What is measured before the edge is a mean over so long [s]."""


class Need(Enum):
    """What a case must have for a metric to mean something."""

    NOTHING = ""
    SIGNAL = "a signal"
    COMMAND = "a signal and a command"
    AXIS = "an axis"
    HOVER = "an edge, half a second or more after the flight's begin"


class Measure(NamedTuple):
    """How one metric is measured.

    Attributes:
        name: of the metric.
        need: of the case.
        of: its value in a flight.
        signal: that it is of; "" for the judged one.
    """

    name: str
    need: Need
    of: Callable[..., float]
    signal: str = ""

    def doubt_of(self, flight: Flight) -> str:
        """Return why the number means little in a flight, "" if it does not."""
        return flight.doubt if self.name in (*FROM_REST, *AT_THE_END) else ""

    def unit_of(self, flight: Flight) -> str:
        """Return the unit in a flight."""
        if self.name == "mean_force":
            return find_axis(flight.axis).force_unit.replace("·", " ")
        name = self.signal or flight.signal
        unit = flight.find_signal(name).unit if name else ""
        return find_metric(self.name.partition(OF)[0]).unit_for(unit)


def find_measure(name: str) -> Measure:
    """Return how the metric of a name is measured; `mean of imu.f_z` is of any signal.

    Raises:
        WorkbenchError: if a spec knows none of that name.
    """
    statistic, of, signal = name.partition(OF)
    if not of:
        return find_row("metric", name, MEASURES)
    statistics = [measure for measure in MEASURES if measure.need is Need.SIGNAL]
    found = find_row("statistic of a signal", statistic, statistics)
    return Measure(name, Need.NOTHING, partial(found.of, signal=signal), signal)


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
    values = flight.find_signal(signal or flight.signal).of(flight.judged)
    with np.errstate(invalid="ignore"):  # a range may be infinite; then some of it is no number
        return float(of(values))


def _coupling(flight: Flight, axis: str) -> float:
    return float(getattr(coupling(flight.judged, flight.axis), axis))


def _peak_speed(flight: Flight) -> float:
    return float(np.linalg.norm(flight.judged.v_WB, axis=1).max())


def _hover_speeds(flight: Flight) -> np.ndarray:
    """Return the mean speed of each rotor before the edge [rad/s]."""
    hover = flight.before.between(flight.edge - HOVER, flight.edge)
    return np.asarray(hover.rotor_speeds.mean(axis=0))


def _hover_thrust(flight: Flight) -> float:
    return float(flight.before.between(flight.edge - HOVER, flight.edge).total_thrust.mean())


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
    *(Measure(f"coupling_{axis}", Need.NOTHING, partial(_coupling, axis=axis)) for axis in AXES),
    Measure("peak_rotor_use", Need.NOTHING, lambda flight: float(flight.judged.rotor_use.max())),
    Measure("peak_thrust", Need.NOTHING, lambda flight: float(flight.judged.total_thrust.max())),
    Measure("peak_tilt", Need.NOTHING, lambda flight: float(flight.judged.tilt.max())),
    Measure("peak_speed", Need.NOTHING, _peak_speed),
    Measure("hover_thrust", Need.HOVER, _hover_thrust),
    Measure("hover_rotor_speed", Need.HOVER, lambda flight: float(_hover_speeds(flight).mean())),
    Measure("hover_rotor_spread", Need.HOVER, lambda flight: float(np.ptp(_hover_speeds(flight)))),
)
