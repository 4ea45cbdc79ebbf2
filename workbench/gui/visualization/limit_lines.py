"""The limits that a spec sets on signals, as lines of the charts."""

import math
from collections.abc import Iterator, Sequence

import numpy as np

from workbench.common.series import Series
from workbench.design.metrics import ALL_METRICS
from workbench.design.response_metrics import crossing_time
from workbench.design.step_metrics import SETTLED_LAST_SHARE, SETTLING_BAND
from workbench.design.step_responses import LoggedStep
from workbench.gui.visualization.spec_limits import CaseLimits, SpecContents

_VECTOR_SIGNALS = {
    "v": "velocity_data.v",
    "p": "position_data",
    "w": "velocity_data.w",
    "a": "acceleration_data.vdot",
    "force": "force_torque_data.force",
}
_IMU_SIGNALS = {"f": "specific_force", "w": "angular_velocity"}
_SCALAR_SIGNALS = {
    "yaw_rate": "velocity_data.w_z",
    "roll": "position_data.roll",
    "pitch": "position_data.pitch",
    "yaw": "position_data.yaw",
    "charge": "drone_state.charge",
}
_LEVEL_STATISTICS = ("maximum", "minimum", "final", "mean")
"""Statistics of a signal that are levels of the signal itself."""
_METRIC_UNITS = {row.name: row.unit_for("") for row in ALL_METRICS}
BASELINE_COMMAND_TOLERANCE = 0.02
"""Tolerance of a step's command, as a share of the case's, for a comparison with its baseline."""


def chart_signal(name: str) -> str:
    """Return the charts' name for a signal of a spec; "" without one."""
    if name in _SCALAR_SIGNALS:
        return _SCALAR_SIGNALS[name]
    sensor, _, channel = name.rpartition(".")
    quantity, _, part = channel.rpartition("_")
    if sensor:
        known = sensor == "imu" and quantity in _IMU_SIGNALS and part in "xyz"
        return f"imu.{_IMU_SIGNALS[quantity]}.{'xyz'.index(part)}" if known else ""
    if quantity in ("speed", "thrust") and part.isdecimal():
        return f"rotors.{quantity}.{int(part) - 1}"
    if quantity in _VECTOR_SIGNALS and part in ("x", "y", "z"):
        return f"{_VECTOR_SIGNALS[quantity]}{'.' if quantity == 'p' else '_'}{part}"
    return ""


def lines_over_time(spec: SpecContents, signal: str) -> list[tuple[str, float]]:
    """Return label and value of each level that a spec sets for a signal of the charts."""
    found = []
    for case in spec.cases:
        for metric, ends in case.limits.items():
            statistic, _, of = metric.partition(" of ")
            judged = chart_signal(of or case.signal)
            if metric == "peak_speed":
                statistic, judged = "maximum", "derived.speed"
            if statistic in _LEVEL_STATISTICS and judged == signal:
                found += _limit_levels(f"{case.name}: {statistic}", *ends)
    return found


def _limit_levels(label: str, least: float, most: float) -> list[tuple[str, float]]:
    ends = ((f"{label} ≥", least), (f"{label} ≤", most))
    return [(text, value) for text, value in ends if math.isfinite(value)]


def limits_of_step(spec: SpecContents, signal: str, step: LoggedStep) -> Sequence[Series]:
    """Return the limits of the case for a step of a signal of the charts.

    It is the case whose command is nearest to the flown one, with the same sign; its limits are
    scaled to the flown amplitude. The band around a baseline is drawn as recorded, and only if its
    amplitude is the flown one.
    """
    cases = [
        each
        for each in spec.cases
        if chart_signal(each.signal) == signal and each.command * step.amplitude > 0.0
    ]
    if not cases:
        return ()
    case = min(cases, key=lambda each: abs(each.command - step.amplitude))
    near = abs(case.command - step.amplitude) <= BASELINE_COMMAND_TOLERANCE * abs(case.command)
    return [*_step_limit_lines(case, step), *(_baseline_lines(case) if near else ())]


def _step_limit_lines(case: CaseLimits, step: LoggedStep) -> Iterator[Series]:
    by, end = step.amplitude, float(step.time[-1])
    tenth = crossing_time(step.time, step.response, 0.1 * by)

    def level(label: str, value: float, since: float = 0.0, until: float = end) -> Series:
        time = np.array([since, 0.5 * (since + until), until])
        return Series(label, "", time, np.full(3, value))

    for metric, ends in case.limits.items():
        unit = _METRIC_UNITS.get(metric, "")
        for sign, value in zip("≥≤", ends, strict=True):
            least, label = sign == "≥", f"{metric} {sign} {value:g} {unit}".strip()
            if not math.isfinite(value) or (least and value <= 0.0):
                continue
            match metric:
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
                        yield level(label, wrong, (1.0 - SETTLED_LAST_SHARE) * end)
                case "settling_time" if not least and value < end:
                    for side in (-1.0, 1.0):
                        yield level(label, by * (1.0 + side * SETTLING_BAND), value)
                case "rise_time" if math.isfinite(tenth) and tenth + value < end:
                    edge = tenth + value
                    begin, until = (0.0, edge) if least else (edge, end)
                    yield level(label, 0.9 * by, begin, until)
                case "t90" if value < end:
                    begin, until = (0.0, value) if least else (value, end)
                    yield level(label, 0.9 * by, begin, until)


def _baseline_lines(case: CaseLimits) -> Iterator[Series]:
    for signal, (time, low, high) in case.bands.items():
        if chart_signal(signal) == chart_signal(case.signal):
            yield Series("baseline", "", time, low)
            yield Series("baseline", "", time, high)
