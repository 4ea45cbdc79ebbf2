"""The numbers that can be wished for: of a flown step, of a loop, of the rotors."""

import math
from dataclasses import dataclass

from workbench.common.errors import WorkbenchError

STEP, LOOP, ROTORS = "step", "loop", "rotors"
"""What a metric is of."""


@dataclass(frozen=True)
class Metric:
    """One number that a wish may bound.

    Attributes:
        name: as in a wish.
        kind: `STEP`, `LOOP` or `ROTORS`.
        unit: of its values: SI, "1", or %.
        minimum: no wish bounds it by less.
        maximum: no wish bounds it by more.
        larger_is_better: which way a wish that stays away from the limit lies.
        scale: a distance from the limit is counted as a share of the limit, or of this if larger.
        help: what it is.
    """

    name: str
    kind: str
    unit: str
    minimum: float
    maximum: float
    larger_is_better: bool
    scale: float
    help: str


_TINY = 1e-6
METRICS = (
    Metric("rise_time", STEP, "s", _TINY, 60.0, False, 0.01, "from 10 % to 90 %"),
    Metric("settling_time", STEP, "s", _TINY, 60.0, False, 0.01, "until within 2 % for good"),
    Metric("overshoot", STEP, "%", 0.0, 1000.0, False, 1.0, "above the steady state"),
    Metric("steady_state_error", STEP, "%", 0.0, 1000.0, False, 1.0, "against the command"),
    Metric("peak_rotor_use", STEP, "1", _TINY, 1.0, False, 0.01, "largest share of a speed limit"),
    Metric("phase_margin", LOOP, "rad", 0.0, math.pi, True, 0.01, "at the actuator"),
    Metric("gain_margin", LOOP, "1", 1.0, 1e6, True, 0.01, "factor upwards"),
    Metric("delay_margin", LOOP, "s", 0.0, 60.0, True, 1e-4, "further delay that is borne"),
    Metric("disk_margin", LOOP, "1", 0.0, 2.0, True, 0.01, "of gain and phase together"),
    Metric("peak_sensitivity", LOOP, "1", 1.0, 1e6, False, 0.01, "largest |1 / (1 + L)|"),
    Metric("bandwidth", LOOP, "rad/s", _TINY, 1e4, True, 0.01, "of the closed loop"),
    Metric(
        "noise_amplification",
        ROTORS,
        "N·s/rad",
        _TINY,
        1e9,
        False,
        1e-6,
        "rms of a rotor's thrust over that of white noise on the measured body rates",
    ),
)

_UNITS: dict[str, dict[str, float]] = {
    "s": {"": 1.0, "s": 1.0, "ms": 1e-3},
    "%": {"": 1.0, "%": 1.0},
    "1": {"": 1.0, "%": 0.01},
    "rad": {"": 1.0, "rad": 1.0, "deg": math.radians(1.0), "°": math.radians(1.0)},
    "rad/s": {"": 1.0, "rad/s": 1.0, "Hz": 2.0 * math.pi},
    "N·s/rad": {"": 1.0, "N·s/rad": 1.0, "N*s/rad": 1.0, "N/(rad/s)": 1.0},
}
"""What a value is multiplied by, by the unit of its metric and the one that is written."""


def si_value(metric: Metric, number: float, unit: str) -> float:
    """Return a bound of a metric in the metric's own unit.

    Args:
        metric: what is bounded.
        number: as written.
        unit: as written, "" for the metric's own; a gain margin may be in dB.

    Raises:
        WorkbenchError: if the unit does not fit, or no such value is possible.
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


def shown(metric: Metric, value: float) -> str:
    """Return a value with its unit, for people: angles in degrees."""
    if math.isnan(value):
        return "—"
    if metric.unit == "rad":
        return f"{math.degrees(value):.3g} deg"
    return f"{value:.3g} {metric.unit}" if metric.unit != "1" else f"{value:.3g}"
