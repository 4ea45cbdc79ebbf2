"""The numbers by which steps, loops, rotors and flights are judged, in one table.

A sweep measures `SWEPT_METRICS`, a wish bounds `WISHED_METRICS`, and a spec limits metrics of steps
and flights.
"""

import math
from dataclasses import dataclass

from workbench.common.errors import WorkbenchError, find_named_row
from workbench.common.quantity import Quantity, display_unit

STEP_KIND, LOOP_KIND, ROTORS_KIND, FLIGHT_KIND = "step", "loop", "rotors", "flight"
"""Kinds of metrics."""
SIGNAL_UNIT = "signal"
"""Placeholder for the unit of the response, or of the signal that a spec judges."""
_TINY = 1e-6


@dataclass(frozen=True)
class Metric(Quantity):
    """One number; its name is that of python-control, if it has one.

    Its unit is SI, "1", %, or `SIGNAL_UNIT`; its limits are those of the bounds of a wish.

    Attributes:
        kind: `STEP_KIND`, `LOOP_KIND`, `ROTORS_KIND` or `FLIGHT_KIND`.
        better: -1 if smaller is better, 1 if larger is, 0 if closer to the command is, or neither.
        scale: a distance from the bound of a wish counts as a share of the bound, or of this if
            larger; 0 for metrics that no wish bounds.
    """

    kind: str = FLIGHT_KIND
    better: int = 0
    scale: float = 0.0

    @property
    def file_name(self) -> str:
        """Name in files, tables and JSON: a margin that is an angle is in degrees there."""
        return f"{self.name}_deg" if self._is_angle else self.name

    @property
    def file_unit(self) -> str:
        """Unit in files, tables and JSON."""
        return "deg" if self._is_angle else self.unit

    @property
    def file_factor(self) -> float:
        """Factor from the unit to that in files, tables and JSON."""
        return display_unit(self.unit).factor if self._is_angle else 1.0

    @property
    def _is_angle(self) -> bool:
        return self.kind == LOOP_KIND and self.unit == "rad"

    def unit_for(self, signal: str) -> str:
        """Return the unit of the metric, given that of the response or the signal."""
        return self.unit.replace(SIGNAL_UNIT, signal)


@dataclass(frozen=True)
class Demand:
    """A measured number with an upper limit.

    Attributes:
        criterion: the one that it is of; in a check of the hover, the flight.
        quantity: its name; of a step, python-control's.
        unit: of value and limit.
        value: the measured one; NaN where it has no meaning.
        limit: the largest value allowed.
        withheld: why it is NaN, else "".
    """

    criterion: str
    quantity: str
    unit: str
    value: float
    limit: float
    withheld: str = ""

    @property
    def met(self) -> bool:
        """Whether the demand is met; a NaN never meets it."""
        return self.value <= self.limit


ALL_METRICS = (
    Metric(
        "rise_time", "s", "from 10 % to 90 % of the steady state", _TINY, 60.0, STEP_KIND, -1, 0.01
    ),
    Metric(
        "settling_time", "s", "until it stays within 2 % of it", _TINY, 60.0, STEP_KIND, -1, 0.01
    ),
    Metric("overshoot", "%", "above the steady state", 0.0, 1000.0, STEP_KIND, -1, 1.0),
    Metric("undershoot", "%", "to the wrong side of where it began", kind=STEP_KIND, better=-1),
    Metric("peak", SIGNAL_UNIT, "largest absolute value", kind=STEP_KIND),
    Metric("peak_time", "s", "when that is", kind=STEP_KIND, better=-1),
    Metric("steady_state_value", SIGNAL_UNIT, "value at the end", kind=STEP_KIND),
    Metric("steady_state_error", "%", "of it against the command", 0.0, 1000.0, STEP_KIND, -1, 1.0),
    Metric(
        "peak_rotor_use", "1", "largest share of a speed limit", _TINY, 1.0, STEP_KIND, -1, 0.01
    ),
    Metric("phase_margin", "rad", "at the actuator", 0.0, math.pi, LOOP_KIND, 1, 0.01),
    Metric("gain_margin", "1", "factor upwards", 1.0, 1e6, LOOP_KIND, 1, 0.01),
    Metric("delay_margin", "s", "further delay to instability", 0.0, 60.0, LOOP_KIND, 1, 1e-4),
    Metric("disk_margin", "1", "of gain and phase together", 0.0, 2.0, LOOP_KIND, 1, 0.01),
    Metric("peak_sensitivity", "1", "largest |1 / (1 + L)|", 1.0, 1e6, LOOP_KIND, -1, 0.01),
    Metric("bandwidth", "rad/s", "of the closed loop", _TINY, 1e4, LOOP_KIND, 1, 0.01),
    Metric("gain_reduction_margin", "1", "factor downwards", kind=LOOP_KIND),
    Metric("crossover", "rad/s", "highest frequency at which |L| is 1", kind=LOOP_KIND),
    Metric(
        "noise_amplification",
        "N·s/rad",
        "rms of a rotor's thrust over that of white noise on the measured body rates",
        _TINY,
        1e9,
        ROTORS_KIND,
        -1,
        1e-6,
    ),
    Metric(
        "command_noise",
        "1",
        "rms of a rotor's command under the described noise of the sensors, over its mean",
        _TINY,
        1e3,
        ROTORS_KIND,
        -1,
        1e-5,
    ),
    Metric("t90", "s", "from the edge to 90 % of the command"),
    Metric("mean_acceleration", "signal/s", "from the edge to 90 % of the command"),
    Metric("mean_force", "N", "along the axis in that time; a yaw's torque in N m"),
    Metric("minimum", SIGNAL_UNIT, "smallest value of the signal"),
    Metric("maximum", SIGNAL_UNIT, "largest value of the signal"),
    Metric("mean", SIGNAL_UNIT, "mean value of the signal"),
    Metric("standard_deviation", SIGNAL_UNIT, "standard deviation of the signal"),
    Metric("rms", SIGNAL_UNIT, "root mean square of the signal"),
    Metric("final", SIGNAL_UNIT, "last value of the signal"),
    Metric("noise", SIGNAL_UNIT, "root mean square of what of the signal is faster than 20 Hz"),
    Metric("tracking_error", SIGNAL_UNIT, "root mean square of setpoint less response"),
    Metric("lag", "s", "by which the response is behind its setpoint"),
    Metric("steps", "1", "of the setpoint that were found"),
    Metric("measured_rise_time", "s", "of the loop's step response out of all of it"),
    Metric("measured_overshoot", "%", "likewise"),
    Metric("measured_final", "1", "value that it settles at"),
    Metric("coupling_x", "m", "farthest from where it was at the edge; 0 of a step's axis"),
    Metric("coupling_y", "m", "likewise"),
    Metric("coupling_z", "m", "likewise"),
    Metric("coupling_yaw", "rad", "likewise"),
    Metric("mean_rotor_use", "1", "share of the speed limit, over rotors and time"),
    Metric("saturation", "%", "of the time in which a rotor gets its largest command"),
    Metric("trim", "1", "mean use of the most used rotor less that of the least used"),
    Metric("peak_thrust", "N", "of all rotors together"),
    Metric("peak_tilt", "rad", "of the body against the vertical"),
    Metric("peak_speed", "m/s", "in any direction"),
    Metric("hover_thrust", "N", "of all rotors before the edge"),
    Metric("hover_rotor_speed", "rad/s", "mean of the rotors before the edge"),
    Metric("hover_rotor_spread", "rad/s", "fastest less slowest rotor before the edge"),
)
_SWEPT_MARGINS = ("phase_margin", "gain_margin", "delay_margin", "disk_margin")
FLOWN_METRICS = tuple(metric for metric in ALL_METRICS if metric.kind == STEP_KIND)
"""Metrics of the flight that a sweep measures."""
MARGIN_METRICS = tuple(metric for metric in ALL_METRICS if metric.name in _SWEPT_MARGINS)
"""Metrics of the loop of the linear model that a sweep measures."""
SWEPT_METRICS = (*FLOWN_METRICS, *MARGIN_METRICS)
WISHED_METRICS = tuple(metric for metric in ALL_METRICS if metric.scale)
"""Metrics that a wish may bound."""


def find_metric(name: str, among: tuple[Metric, ...] = ALL_METRICS) -> Metric:
    """Return the metric of a name, or of a name in files.

    Raises:
        WorkbenchError: if there is none.
    """
    for metric in among:
        if name == metric.file_name:
            return metric
    return find_named_row("metric", name, among)


_UNIT_FACTORS: dict[str, dict[str, float]] = {
    "s": {"": 1.0, "s": 1.0, "ms": 1e-3},
    "%": {"": 1.0, "%": 1.0},
    "1": {"": 1.0, "%": 0.01},
    "rad": {"": 1.0, "rad": 1.0, "deg": math.radians(1.0), "°": math.radians(1.0)},
    "rad/s": {"": 1.0, "rad/s": 1.0, "Hz": 2.0 * math.pi},
    "N·s/rad": {"": 1.0, "N·s/rad": 1.0, "N*s/rad": 1.0, "N/(rad/s)": 1.0},
}
"""Factor on a value, by the unit of its metric and the unit as written."""
_SHOWN_UNITS = {"s": ("ms",), "1": ("%",), "rad/s": ("Hz",)}
"""Further units that a user may choose, by the unit of the metric."""


def units_of_bounds(metric: Metric) -> tuple[str, ...]:
    """Return the units in which a bound of a metric can be written, the usual one first.

    "" is that of a plain ratio.
    """
    if metric.name == "gain_margin":
        return ("dB", "")
    if metric.unit == "rad":
        return ("deg", "rad")
    own = "" if metric.unit == "1" else metric.unit
    return tuple(dict.fromkeys((own, *_SHOWN_UNITS.get(metric.unit, ()))))


def si_value(metric: Metric, number: float, unit: str) -> float:
    """Return a bound of a metric in the metric's own unit.

    Args:
        metric: the bounded one.
        number: as written.
        unit: as written, "" for the metric's own; a gain margin may be in dB.

    Raises:
        WorkbenchError: if the unit does not fit, or the value is impossible.
    """
    if metric.name == "gain_margin" and unit == "dB":
        value = 10.0 ** (number / 20.0) if abs(number) < 1000.0 else math.inf
    else:
        factors = _UNIT_FACTORS[metric.unit]
        if unit not in factors:
            known = ", ".join(name for name in factors if name) or "none"
            raise WorkbenchError(f"{metric.name} is not in '{unit}': its units are {known}")
        value = number * factors[unit]
    if not metric.minimum <= value <= metric.maximum:
        least, most = metric.text(metric.minimum), metric.text(metric.maximum)
        hint = ", or say deg" if metric.unit == "rad" and not unit else ""
        own = unit or ("" if metric.unit == "1" else metric.unit)
        raise WorkbenchError(
            f"{metric.name} of {f'{number:g} {own}'.strip()} is not possible: keep it within "
            f"{least} .. {most}{hint}"
        )
    return value
