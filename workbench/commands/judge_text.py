"""How a judgement reads: tables for people, and plain data for JSON."""

import math
from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

from workbench.commands.printing import print_table

if TYPE_CHECKING:
    from workbench.design.judge.margins import LoopMargins
    from workbench.design.judge.modes import Mode
    from workbench.design.judge.operating_map import Direction, OperatingMap
    from workbench.design.judge.report import Judgement
    from workbench.design.judge.sampled_stability import SlowestRate
    from workbench.design.judge.sensitivity import Sensitivity
    from workbench.design.response_metrics import StepMetrics

_HEAD = (
    "loop",
    "gain margin",
    "down to",
    "phase",
    "delay",
    "disk",
    "Ms",
    "bandwidth",
    "crossover",
)
_UNITS = ("", "[factor]", "[factor]", "[deg]", "[ms]", "[1]", "[1]", "[rad/s]", "[rad/s]")
_FAINT = 0.005
"""Gains that change no metric by this much are left out [% per %]."""

_NOTHING = 1e-6
"""A metric that is smaller, in its unit or percent, is rounding."""


def result(found: "Judgement") -> dict[str, Any]:
    """Return a judgement as JSON has it; angles in rad."""
    return {
        "vehicle": found.vehicle,
        "point": found.point.label,
        "period": found.period,
        "stable": not found.unstable,
        "unstable_loops": found.unstable,
        "loops": found.loops,
        "plant_input": found.plant_input,
        "plant_input_holding": found.plant_input_holding,
        "modes": found.modes,
        "modes_holding": found.modes_holding,
        "steps": [
            {
                "axis": step.axis,
                "amplitude": step.amplitude,
                "linear": step.linear,
                "flown": step.flown,
                "difference": step.difference,
                "broken": step.broken,
            }
            for step in found.steps
        ],
        "slowest": found.slowest,
        "phase": found.phase,
        "noise": found.noise,
    }


def print_judgement(found: "Judgement", cut: str) -> None:
    """Print the loops, a row each, then modes, steps and rates."""
    law = found.steering.controller
    how = "" if law is None or law.derivatives == "AutoDiff" else f", by {law.derivatives}"
    print(f"{found.vehicle} at {found.point.label}, law at {1.0 / found.period:g} Hz{how}")
    print(f"\nloops, opened at the {cut}:")
    rows: list[tuple[str, ...]] = [_HEAD, _UNITS]
    rows += [(loop.loop, *_cells(getattr(loop, cut))) for loop in found.loops]
    print_table(rows)
    _print_phase(found)
    _print_plant_input(found)
    _print_noise(found)
    if not found.holding:
        print("loops of the position and steps are left out: a place is held in hover only")
    _print_modes("modes while the pilot steers", found.modes, found.period)
    if found.modes_holding:
        slow = found.modes_holding[:4]
        _print_modes("slowest modes while the place is held", slow, found.period)
    _print_steps(found)
    print(f"\nthe law runs at {1.0 / found.period:g} Hz; {_rates(found.slowest)}")


def _print_phase(found: "Judgement") -> None:
    """Print what turned the phase of each loop at its crossover."""
    from workbench.design.judge.phase_budget import PARTS  # it loads Drake

    if not found.phase:
        return
    parts = [part for part in PARTS if any(abs(getattr(each, part)) > 1e-9 for each in found.phase)]
    print("\nwhere the phase went, at the crossover [deg]:")
    rows = [("loop", "at [rad/s]", "at [Hz]", *parts, "phase of L")]
    for each in found.phase:
        turned = (math.degrees(getattr(each, part)) for part in parts)
        at = (f"{each.crossover:.3g}", f"{each.crossover / (2.0 * math.pi):.3g}")
        rows.append(
            (each.loop, *at, *(f"{x:.1f}" for x in turned), f"{math.degrees(each.phase):.1f}")
        )
    print_table(rows)


def _print_noise(found: "Judgement") -> None:
    """Print what the noise of each sensor does to attitude and commands."""
    if not found.noise:
        return
    print("\nwhat the noise of sensors does while the place is held, rms:")
    rows: list[tuple[str, ...]] = [
        ("", "roll [deg]", "pitch [deg]", "yaw [deg]", "commands [% of their mean]")
    ]
    for each in found.noise:
        angles = (f"{math.degrees(angle):.2g}" for angle in each.attitude)
        rows.append((each.sensor, *angles, f"{100.0 * each.worst_command:.2g}"))
    print_table(rows)


def _print_plant_input(found: "Judgement") -> None:
    """Print what force and moments bear all at once."""
    print("\nat the plant's input, force and moments all at once:")
    rows = [("", "disk", "gains within", "at [rad/s]", "alone:", *found.plant_input.alone)]
    for what, each in (
        ("while the pilot steers", found.plant_input),
        ("while the place is held", found.plant_input_holding),
    ):
        if each is not None:
            low = (2.0 - each.disk_margin) / (2.0 + each.disk_margin)
            alone = (_number(margin, ".2f") for margin in each.alone.values())
            gains = f"{low:.2f} .. {1.0 / low:.2f}" if 0.0 < each.disk_margin < 2.0 else "-"
            disk, frequency = _number(each.disk_margin, ".2f"), _number(each.frequency, ".3g")
            rows.append((what, disk, gains, frequency, "", *alone))
    print_table(rows)


def print_sensitivities(title: str, found: "tuple[Sensitivity, ...]") -> None:
    """Print what every gain does to every metric."""
    print(f"{title}: percent that a number changes per percent of a gain\n")
    names = [
        name
        for name in found[0].elasticities
        if any(abs(each.elasticities[name]) > _FAINT for each in found)
    ]
    rows = [("", "value", *names)]
    rows += [
        (each.metric, f"{each.value:.4g}", *(_number(each.elasticities[n], "+.2f") for n in names))
        for each in found
    ]
    print_table(rows)
    rest = [name for name in found[0].elasticities if name not in names]
    print(f"\nno part in it: {', '.join(rest) or 'none'}")


def sensitivity_result(
    axis: str, amplitude: float, found: "tuple[Sensitivity, ...]"
) -> dict[str, Any]:
    """Return sensitivities as JSON has them."""
    return {"axis": axis, "amplitude": amplitude, "sensitivities": found}


def print_map(found: "OperatingMap") -> None:
    """Print the weakest place of a map, and the smallest disk margin at every point."""
    first, second = found.first, found.second
    print(f"{found.vehicle}: smallest disk margin, {first.name} across, {second.name} down\n")
    rows = [[f"{second.name} [{second.unit}]", *(f"{x:.3g}" for x in found.first_values)]]
    rows += [
        [f"{value:.3g}", *(_number(x, ".2f") for x in line)]
        for value, line in zip(found.second_values, found.disk_margin.tolist(), strict=True)
    ]
    print_table(rows)
    known = [
        (found.disk_margin[row, column], row, column)
        for row in range(len(found.second_values))
        for column in range(len(found.first_values))
        if math.isfinite(found.disk_margin[row, column])
    ]
    if known:
        disk, row, column = min(known)
        print(
            f"\nweakest: {found.weakest[row][column]} at "
            f"{_place(first, found.first_values[column])} and "
            f"{_place(second, found.second_values[row])}: disk margin {disk:.2f}"
        )
    holes = found.disk_margin.size - len(known)
    if holes:
        print(f"{holes} of {found.disk_margin.size} points cannot be flown")


def map_result(found: "OperatingMap") -> dict[str, Any]:
    """Return a map as JSON has it; angles in rad."""
    return {
        "vehicle": found.vehicle,
        "first": {"name": found.first.name, "unit": found.first.unit},
        "second": {"name": found.second.name, "unit": found.second.unit},
        "first_values": found.first_values.tolist(),
        "second_values": found.second_values.tolist(),
        "phase_margin": found.phase_margin.tolist(),
        "disk_margin": found.disk_margin.tolist(),
        "damping": found.damping.tolist(),
        "weakest_loop": found.weakest,
    }


def _cells(margins: "LoopMargins") -> tuple[str, ...]:
    """Return a loop's numbers as texts."""
    if not margins.stable:
        return ("unstable", *["-"] * 7)
    return (
        _number(margins.gain_margin, ".3g"),
        _number(margins.gain_reduction_margin or math.nan, ".3g"),
        _number(math.degrees(margins.phase_margin), ".1f"),
        _number(1e3 * margins.delay_margin, ".1f"),
        _number(margins.disk_margin, ".2f"),
        _number(margins.peak_sensitivity, ".2f"),
        _number(margins.bandwidth, ".3g"),
        _number(margins.crossover, ".3g"),
    )


def _print_modes(title: str, found: "tuple[Mode, ...]", period: float) -> None:
    """Print poles in the words of python-control's `damp`, without those faster than sampling."""
    print(f"\n{title}:")
    shown = [mode for mode in found if not mode.gone_after(period)]
    print_modes(shown)
    if len(shown) < len(found):
        print(f"{len(found) - len(shown)} more die out within a sample")


def print_modes(shown: "Sequence[Mode]") -> None:
    """Print a table of modes in the words of python-control's `damp`."""
    rows = [("pole [1/s]", "damping", "frequency [rad/s]", "time constant [s]")]
    rows += [
        (
            f"{mode.real:.4g}" + (f" ± {mode.imaginary:.4g}i" if mode.imaginary else ""),
            _number(mode.damping, ".3f"),
            f"{mode.frequency:.4g}",
            _number(mode.time_constant, ".3g"),
        )
        for mode in shown
    ]
    print_table(rows, left=())


def _print_steps(found: "Judgement") -> None:
    """Print linear and flown metrics side by side."""
    from workbench.design.response_metrics import NUMBERS

    if not found.steps:
        return
    print("\nsteps from hover, linear and flown:")
    rows = [("", *(word for step in found.steps for word in (f"{step.axis} linear", "flown")))]
    for name in NUMBERS:
        pairs = [metrics for step in found.steps for metrics in (step.linear, step.flown)]
        rows.append((name, *(_metric(metrics, name) for metrics in pairs)))
    print_table(rows)
    if any(step.linear is None for step in found.steps):
        print("a growing mode has no step: no numbers of the linear model")
    for step in found.steps:
        if step.broken:
            print(f"the {step.axis} step has no numbers: {step.broken}")
        for kind, metrics in (("linear", step.linear), ("flown", step.flown)):
            if metrics is not None and metrics.withheld:
                print(f"{step.axis} {kind}: numbers shown as - are withheld: {metrics.withheld}")


def _metric(metrics: "StepMetrics | None", name: str) -> str:
    """Return a metric as text; rounding counts as 0."""
    value = math.nan if metrics is None else getattr(metrics, name)
    return _number(0.0 if abs(value) < _NOTHING else value, ".4g")


def _number(value: float, form: str) -> str:
    return format(value, form) if math.isfinite(value) else "-"


def _place(direction: "Direction", value: float) -> str:
    unit = "" if direction.unit == "1" else f" {direction.unit}"
    return f"{direction.name} {value:.3g}{unit}"


def _rates(slowest: "SlowestRate") -> str:
    """Say down to which rates the law may run."""
    if not math.isfinite(slowest.stable_period):
        fastest = 1.0 / slowest.samples[0].period
        return f"with these gains a mode grows even at {fastest:g} Hz, at every physics step"
    limit = ", the slowest there is," if slowest.at_limit else ""
    stable = f"it is stable down to {1.0 / slowest.stable_period:.1f} Hz{limit}"
    if not math.isfinite(slowest.safe_period):
        return f"{stable} but has 30 deg of phase margin at no rate"
    return f"{stable} and keeps 30 deg of phase margin down to {1.0 / slowest.safe_period:.1f} Hz"
