"""The numbers by which steps, loops, rotors and flights are judged, in one table.

A sweep measures `SWEPT`, a wish bounds `WISHED`, and a spec limits metrics of steps and flights.
"""

import math
from dataclasses import dataclass

from workbench.common.errors import WorkbenchError, find_row

STEP, LOOP, ROTORS, FLIGHT = "step", "loop", "rotors", "flight"
"""Kinds of metrics."""
SIGNAL = "signal"
"""Placeholder for the unit of the response, or of the signal that a spec judges."""
_TINY = 1e-6


@dataclass(frozen=True)
class Metric:
    """One number.

    Attributes:
        name: that of python-control, if it has one.
        kind: `STEP`, `LOOP`, `ROTORS` or `FLIGHT`.
        unit: of its values: SI, "1", %, or `SIGNAL`.
        help: what it is.
        better: -1 if smaller is better, 1 if larger is, 0 if closer to the command is, or neither.
        minimum: smallest bound that a wish may set.
        maximum: largest bound that a wish may set.
        scale: a distance from the bound of a wish counts as a share of the bound, or of this if
            larger; 0 for metrics that no wish bounds.
    """

    name: str
    kind: str
    unit: str
    help: str
    better: int = 0
    minimum: float = math.nan
    maximum: float = math.nan
    scale: float = 0.0

    def unit_for(self, signal: str) -> str:
        """Return the unit of the metric, given that of the response or the signal."""
        return self.unit.replace(SIGNAL, signal)


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


METRICS = (
    Metric("rise_time", STEP, "s", "from 10 % to 90 % of the steady state", -1, _TINY, 60.0, 0.01),
    Metric("settling_time", STEP, "s", "until it stays within 2 % of it", -1, _TINY, 60.0, 0.01),
    Metric("overshoot", STEP, "%", "above the steady state", -1, 0.0, 1000.0, 1.0),
    Metric("undershoot", STEP, "%", "to the wrong side of where it began", -1),
    Metric("peak", STEP, SIGNAL, "largest absolute value"),
    Metric("peak_time", STEP, "s", "when that is", -1),
    Metric("steady_state_value", STEP, SIGNAL, "value at the end"),
    Metric("steady_state_error", STEP, "%", "of it against the command", -1, 0.0, 1000.0, 1.0),
    Metric("peak_rotor_use", STEP, "1", "largest share of a speed limit", -1, _TINY, 1.0, 0.01),
    Metric("phase_margin", LOOP, "rad", "at the actuator", 1, 0.0, math.pi, 0.01),
    Metric("gain_margin", LOOP, "1", "factor upwards", 1, 1.0, 1e6, 0.01),
    Metric("delay_margin", LOOP, "s", "further delay to instability", 1, 0.0, 60.0, 1e-4),
    Metric("disk_margin", LOOP, "1", "of gain and phase together", 1, 0.0, 2.0, 0.01),
    Metric("peak_sensitivity", LOOP, "1", "largest |1 / (1 + L)|", -1, 1.0, 1e6, 0.01),
    Metric("bandwidth", LOOP, "rad/s", "of the closed loop", 1, _TINY, 1e4, 0.01),
    Metric("gain_reduction_margin", LOOP, "1", "factor downwards"),
    Metric("crossover", LOOP, "rad/s", "highest frequency at which |L| is 1"),
    Metric(
        "noise_amplification",
        ROTORS,
        "N·s/rad",
        "rms of a rotor's thrust over that of white noise on the measured body rates",
        -1,
        _TINY,
        1e9,
        1e-6,
    ),
    Metric(
        "command_noise",
        ROTORS,
        "1",
        "rms of a rotor's command under the described noise of the sensors, over its mean",
        -1,
        _TINY,
        1e3,
        1e-5,
    ),
    Metric("t90", FLIGHT, "s", "from the edge to 90 % of the command"),
    Metric("mean_acceleration", FLIGHT, "signal/s", "from the edge to 90 % of the command"),
    Metric("mean_force", FLIGHT, "N", "along the axis in that time; a yaw's torque in N m"),
    Metric("minimum", FLIGHT, SIGNAL, "smallest value of the signal"),
    Metric("maximum", FLIGHT, SIGNAL, "largest value of the signal"),
    Metric("mean", FLIGHT, SIGNAL, "mean value of the signal"),
    Metric("standard_deviation", FLIGHT, SIGNAL, "standard deviation of the signal"),
    Metric("rms", FLIGHT, SIGNAL, "root mean square of the signal"),
    Metric("final", FLIGHT, SIGNAL, "last value of the signal"),
    Metric("noise", FLIGHT, SIGNAL, "root mean square of what of the signal is faster than 20 Hz"),
    Metric("tracking_error", FLIGHT, SIGNAL, "root mean square of setpoint less response"),
    Metric("lag", FLIGHT, "s", "by which the response is behind its setpoint"),
    Metric("steps", FLIGHT, "1", "of the setpoint that were found"),
    Metric("measured_rise_time", FLIGHT, "s", "of the loop's step response out of all of it"),
    Metric("measured_overshoot", FLIGHT, "%", "likewise"),
    Metric("measured_final", FLIGHT, "1", "value that it settles at"),
    Metric("coupling_x", FLIGHT, "m", "farthest from where it was at the edge; 0 of a step's axis"),
    Metric("coupling_y", FLIGHT, "m", "likewise"),
    Metric("coupling_z", FLIGHT, "m", "likewise"),
    Metric("coupling_yaw", FLIGHT, "rad", "likewise"),
    Metric("mean_rotor_use", FLIGHT, "1", "share of the speed limit, over rotors and time"),
    Metric("saturation", FLIGHT, "%", "of the time in which a rotor gets its largest command"),
    Metric("trim", FLIGHT, "1", "mean use of the most used rotor less that of the least used"),
    Metric("peak_thrust", FLIGHT, "N", "of all rotors together"),
    Metric("peak_tilt", FLIGHT, "rad", "of the body against the vertical"),
    Metric("peak_speed", FLIGHT, "m/s", "in any direction"),
    Metric("hover_thrust", FLIGHT, "N", "of all rotors before the edge"),
    Metric("hover_rotor_speed", FLIGHT, "rad/s", "mean of the rotors before the edge"),
    Metric("hover_rotor_spread", FLIGHT, "rad/s", "fastest less slowest rotor before the edge"),
)
_SWEPT_MARGINS = ("phase_margin", "gain_margin", "delay_margin", "disk_margin")
FLOWN = tuple(metric for metric in METRICS if metric.kind == STEP)
"""Metrics of the flight that a sweep measures."""
MARGINS = tuple(metric for metric in METRICS if metric.name in _SWEPT_MARGINS)
"""Metrics of the loop of the linear model that a sweep measures."""
SWEPT = (*FLOWN, *MARGINS)
WISHED = tuple(metric for metric in METRICS if metric.scale)
"""Metrics that a wish may bound."""


def find_metric(name: str, among: tuple[Metric, ...] = METRICS) -> Metric:
    """Return the metric of a name.

    Raises:
        WorkbenchError: if there is none.
    """
    return find_row("metric", name, among)


_UNITS: dict[str, dict[str, float]] = {
    "s": {"": 1.0, "s": 1.0, "ms": 1e-3},
    "%": {"": 1.0, "%": 1.0},
    "1": {"": 1.0, "%": 0.01},
    "rad": {"": 1.0, "rad": 1.0, "deg": math.radians(1.0), "°": math.radians(1.0)},
    "rad/s": {"": 1.0, "rad/s": 1.0, "Hz": 2.0 * math.pi},
    "N·s/rad": {"": 1.0, "N·s/rad": 1.0, "N*s/rad": 1.0, "N/(rad/s)": 1.0},
}
"""Factor on a value, by the unit of its metric and the unit as written."""


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
        factors = _UNITS[metric.unit]
        if unit not in factors:
            known = ", ".join(name for name in factors if name) or "none"
            raise WorkbenchError(f"{metric.name} is not in '{unit}': its units are {known}")
        value = number * factors[unit]
    if not metric.minimum <= value <= metric.maximum:
        least, most = shown(metric, metric.minimum), shown(metric, metric.maximum)
        hint = ", or say deg" if metric.unit == "rad" and not unit else ""
        own = unit or ("" if metric.unit == "1" else metric.unit)
        raise WorkbenchError(
            f"{metric.name} of {f'{number:g} {own}'.strip()} is not possible: keep it within "
            f"{least} .. {most}{hint}"
        )
    return value


def for_people(unit: str) -> tuple[float, str]:
    """Return the factor and the unit to show a value in; angles are shown in degrees."""
    if unit == "rad":
        return math.degrees(1.0), "deg"
    return 1.0, "" if unit == "1" else unit


def shown(metric: Metric, value: float) -> str:
    """Return a value with its unit as text; angles in degrees."""
    if math.isnan(value):
        return "—"
    scale, unit = for_people(metric.unit)
    return f"{scale * value:.3g} {unit}".rstrip()
