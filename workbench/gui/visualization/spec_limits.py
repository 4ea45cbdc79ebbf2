"""Limits of a spec as lines on the charts that show what they judge."""

import math
from collections.abc import Iterator, Sequence

import numpy as np

from workbench.design.response_metrics import LAST_PART, SETTLED, crossing_time
from workbench.design.step_responses import StepResponse
from workbench.gui.charts.step_chart import LimitLine
from workbench.gui.visualization.log_messages import CaseLimits, SpecContents

_LINEAR = {
    "v": "velocity_data.v",
    "p": "position_data",
    "w": "velocity_data.w",
    "a": "acceleration_data.vdot",
    "force": "force_torque_data.force",
}
_SENSORS = {"f": "specific_force", "w": "angular_velocity"}
_OTHERS = {
    "yaw_rate": "velocity_data.w_z",
    "roll": "position_data.roll",
    "pitch": "position_data.pitch",
    "yaw": "position_data.yaw",
    "charge": "drone_state.charge",
}
_BOUNDS = ("maximum", "minimum", "final", "mean")
"""Statistics of a signal that are values of it."""
_UNITS = dict.fromkeys(("overshoot", "undershoot", "steady_state_error"), "%") | dict.fromkeys(
    ("rise_time", "settling_time", "t90"), "s"
)
NEAR = 0.02
"""Share of a case's command that a step may be off, and be judged by its baseline."""
FARTHEST = 4.0 * 3600.0
"""Time that lines over time reach to [s]."""


def chart_signal(name: str) -> str:
    """Return the name that charts have for a signal of a spec; "" where they have none."""
    if name in _OTHERS:
        return _OTHERS[name]
    sensor, _, channel = name.rpartition(".")
    quantity, _, part = channel.rpartition("_")
    if sensor:
        known = sensor == "imu" and quantity in _SENSORS and part in "xyz"
        return f"imu.{_SENSORS[quantity]}.{'xyz'.index(part)}" if known else ""
    if quantity in ("speed", "thrust") and part.isdecimal():
        return f"rotors.{quantity}.{int(part) - 1}"
    if quantity in _LINEAR and part in ("x", "y", "z"):
        return f"{_LINEAR[quantity]}{'.' if quantity == 'p' else '_'}{part}"
    return ""


def lines_over_time(spec: SpecContents, signal: str) -> list[tuple[str, float]]:
    """Return label and value of each level that a spec sets for a signal of the charts."""
    found = []
    for case in spec.cases:
        for limit in case.limits:
            statistic, _, of = limit.metric.partition(" of ")
            judged = chart_signal(of or case.signal)
            if limit.metric == "peak_speed":
                statistic, judged = "maximum", "derived.speed"
            if statistic in _BOUNDS and judged == signal:
                found += _levels(f"{case.name}: {statistic}", limit.least, limit.most)
    return found


def _levels(label: str, least: float, most: float) -> list[tuple[str, float]]:
    ends = ((f"{label} ≥", least), (f"{label} ≤", most))
    return [(text, value) for text, value in ends if math.isfinite(value)]


def limits_of_step(spec: SpecContents, signal: str, step: StepResponse) -> Sequence[LimitLine]:
    """Return the limits of the case that judges such a step of a signal of the charts.

    It is the case whose command is nearest to the flown one, of the same sign if there is one; its
    limits are drawn at the flown amplitude. The band around a baseline is drawn as it was recorded,
    where that is the flown amplitude.
    """
    cases = [
        each
        for each in spec.cases
        if chart_signal(each.signal) == signal and each.command * step.amplitude > 0.0
    ]
    if not cases:
        return ()
    case = min(cases, key=lambda each: abs(each.command - step.amplitude))
    near = abs(case.command - step.amplitude) <= NEAR * abs(case.command)
    return [*_lines(case, step), *(_bands(case) if near else ())]


def _lines(case: CaseLimits, step: StepResponse) -> Iterator[LimitLine]:
    by, end = step.amplitude, float(step.time[-1])
    tenth = crossing_time(step.time, step.response, 0.1 * by)

    def level(label: str, value: float, since: float = 0.0, until: float = end) -> LimitLine:
        time = np.array([since, 0.5 * (since + until), until])
        return LimitLine(label, time, np.full(3, value))

    for limit in case.limits:
        unit = _UNITS.get(limit.metric, "")
        for sign, value in (("≥", limit.least), ("≤", limit.most)):
            least, label = sign == "≥", f"{limit.metric} {sign} {value:g} {unit}".strip()
            if not math.isfinite(value) or (least and value <= 0.0):
                continue
            match limit.metric:
                case "overshoot":
                    yield level(label, by * (1.0 + 0.01 * value))
                case "undershoot":
                    yield level(label, -0.01 * value * by)
                case "peak":
                    yield level(label, math.copysign(value, by))
                case "steady_state_value" | "final" | "maximum" | "minimum" | "mean":
                    yield level(label, value)
                case "steady_state_error" if not least:
                    for side in (-1.0, 1.0):
                        wrong = by * (1.0 + 0.01 * side * value)
                        yield level(label, wrong, (1.0 - LAST_PART) * end)
                case "settling_time" if not least and value < end:
                    for side in (-1.0, 1.0):
                        yield level(label, by * (1.0 + side * SETTLED), value)
                case "rise_time" if math.isfinite(tenth) and tenth + value < end:
                    edge = tenth + value
                    begin, until = (0.0, edge) if least else (edge, end)
                    yield level(label, 0.9 * by, begin, until)
                case "t90" if value < end:
                    begin, until = (0.0, value) if least else (value, end)
                    yield level(label, 0.9 * by, begin, until)


def _bands(case: CaseLimits) -> Iterator[LimitLine]:
    for band in case.bands:
        if chart_signal(band.signal) == chart_signal(case.signal):
            yield LimitLine("baseline", band.time, band.low)
            yield LimitLine("baseline", band.time, band.high)
