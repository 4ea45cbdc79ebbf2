"""Metrics of a flight that a spec can limit."""

import math
from collections.abc import Callable
from dataclasses import dataclass
from enum import Enum
from functools import partial

import numpy as np

from workbench.common.errors import find_row
from workbench.design.regress.flight import Flight
from workbench.design.regress.signals import find_signal
from workbench.design.reproduce import mean_until
from workbench.design.response_metrics import AT_THE_END, FROM_REST
from workbench.design.step_metrics import crossing_time
from workbench.design.step_response import axis_force, coupling

HOVER = 0.5
"""What is measured before the edge is a mean over so long [s]."""


class Need(Enum):
    """What a case must have for a metric to mean something."""

    NOTHING = ""
    SIGNAL = "a signal"
    COMMAND = "a signal and a command"
    AXIS = "an axis"
    HOVER = "an edge, half a second or more after the flight's begin"


@dataclass(frozen=True)
class Metric:
    """A number of a flight.

    Attributes:
        name: as in a spec's limits.
        unit: its unit; "signal" stands for the judged signal's, "signal/s" for that a second.
        need: of the case.
        of: how it is measured.
        help: what it is.
    """

    name: str
    unit: str
    need: Need
    of: Callable[[Flight], float]
    help: str

    def doubt_of(self, flight: Flight) -> str:
        """Return why the number means little in a flight, "" if it does not."""
        return flight.doubt if self.name in (*FROM_REST, *AT_THE_END) else ""

    def unit_of(self, flight: Flight) -> str:
        """Return the unit in a flight."""
        if self.name == "mean_force":
            return "N m" if flight.axis == "yaw" else "N"
        if "signal" not in self.unit:
            return self.unit
        return self.unit.replace("signal", find_signal(flight.signal).unit)


def find_metric(name: str) -> Metric:
    """Return the metric of a name.

    Raises:
        WorkbenchError: if there is none.
    """
    return find_row("metric", name, METRICS)


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
    return float(getattr(flight.step, name)[0])


def _of_signal(flight: Flight, of: Callable[[np.ndarray], float]) -> float:
    return float(of(find_signal(flight.signal).of(flight.judged)))


def _coupling(flight: Flight, axis: str) -> float:
    return float(getattr(coupling(flight.judged, flight.axis), axis))


def _hover_speeds(flight: Flight) -> np.ndarray:
    """Return the mean speed of each rotor before the edge [rad/s]."""
    hover = flight.before.between(flight.edge - HOVER, flight.edge)
    return np.asarray(hover.rotor_speeds.mean(axis=0))


def _hover_thrust(flight: Flight) -> float:
    return float(flight.before.between(flight.edge - HOVER, flight.edge).total_thrust.mean())


_STEP = (
    ("rise_time", "s", "from 10 % to 90 % of the steady state"),
    ("settling_time", "s", "until it stays within 2 % of the steady state"),
    ("overshoot", "%", "above the steady state"),
    ("undershoot", "%", "to the wrong side of where it began"),
    ("peak", "signal", "largest absolute value"),
    ("peak_time", "s", "when that is"),
    ("steady_state_value", "signal", "value at the end"),
    ("steady_state_error", "%", "of the steady state against the command"),
)
_SIGNAL = (
    ("minimum", np.min, "smallest value"),
    ("maximum", np.max, "largest value"),
    ("mean", np.mean, "mean value"),
    ("final", lambda values: values[-1], "last value"),
)

METRICS: tuple[Metric, ...] = (
    *(Metric(n, unit, Need.COMMAND, partial(_step, name=n), help) for n, unit, help in _STEP),
    Metric("t90", "s", Need.COMMAND, _t90, "from the edge to 90 % of the command"),
    Metric(
        "mean_acceleration",
        "signal/s",
        Need.COMMAND,
        _mean_acceleration,
        "from the edge to 90 % of the command",
    ),
    Metric("mean_force", "", Need.AXIS, _mean_force, "along the axis in that time; a yaw's torque"),
    *(
        Metric(
            name,
            "signal",
            Need.SIGNAL,
            partial(_of_signal, of=of),
            f"{help} of the signal",
        )
        for name, of, help in _SIGNAL
    ),
    *(
        Metric(
            f"coupling_{axis}",
            "rad" if axis == "yaw" else "m",
            Need.NOTHING,
            partial(_coupling, axis=axis),
            "farthest from where it was at the edge; 0 of a step's own axis",
        )
        for axis in ("x", "y", "z", "yaw")
    ),
    Metric(
        "peak_rotor_use",
        "1",
        Need.NOTHING,
        lambda flight: float(flight.judged.rotor_use.max()),
        "largest share of its speed limit at which a rotor ran",
    ),
    Metric(
        "peak_thrust",
        "N",
        Need.NOTHING,
        lambda flight: float(flight.judged.total_thrust.max()),
        "of all rotors together",
    ),
    Metric(
        "peak_tilt",
        "rad",
        Need.NOTHING,
        lambda flight: float(flight.judged.tilt.max()),
        "of the body against the vertical",
    ),
    Metric(
        "peak_speed",
        "m/s",
        Need.NOTHING,
        lambda flight: float(np.linalg.norm(flight.judged.v_WB, axis=1).max()),
        "in any direction",
    ),
    Metric("hover_thrust", "N", Need.HOVER, _hover_thrust, "of all rotors before the edge"),
    Metric(
        "hover_rotor_speed",
        "rad/s",
        Need.HOVER,
        lambda flight: float(_hover_speeds(flight).mean()),
        "mean of the rotors before the edge",
    ),
    Metric(
        "hover_rotor_spread",
        "rad/s",
        Need.HOVER,
        lambda flight: float(np.ptp(_hover_speeds(flight))),
        "fastest less slowest rotor before the edge",
    ),
)
