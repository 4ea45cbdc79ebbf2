"""Print the judgement, the sensitivities and the map of a loop as tables."""

import math
from collections.abc import Sequence
from typing import TYPE_CHECKING

from workbench.commands.printing import print_table
from workbench.common.plain_text import plain_name

if TYPE_CHECKING:
    from workbench.design.judge.margins import LoopMargins
    from workbench.design.judge.modes import Mode
    from workbench.design.judge.operating_map import MapDirection, OperatingMap
    from workbench.design.judge.report import Judgement
    from workbench.design.judge.sampled_stability import SlowestRate
    from workbench.design.judge.sensitivity import Sensitivity
    from workbench.design.step_metrics import StepMetrics


_LOOP_TABLE_HEAD = (
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
_LOOP_TABLE_UNITS = (
    "",
    "[factor]",
    "[factor]",
    "[deg]",
    "[ms]",
    "[1]",
    "[1]",
    "[rad/s]",
    "[rad/s]",
)
_MIN_SENSITIVITY = 0.005
"""Gains that change no metric by this much are left out [% per %]."""
_METRIC_ROUNDING = 1e-6
"""Smaller values of a metric, in its unit or percent, are rounding errors."""


def print_judgement(found: "Judgement", cut: str) -> None:
    """Print the loops, with a row for each, then modes, steps and rates."""
    law = found.steering.controller
    how = "" if law is None or law.derivatives == "AutoDiff" else f", by {law.derivatives}"
    print(f"{found.vehicle} at {found.point.label}, law at {1.0 / found.period:g} Hz{how}")
    if found.loops:
        print(f"\nloops, opened at the {cut}:")
        rows: list[tuple[str, ...]] = [_LOOP_TABLE_HEAD, _LOOP_TABLE_UNITS]
        rows += [(loop.loop, *_cells(getattr(loop, cut))) for loop in found.loops]
        print_table(rows)
    _print_phase(found)
    _print_plant_input(found)
    _print_noise(found)
    if not found.holding:
        print("position loops and steps are left out: the position is held in hover only")
    _print_modes("modes while the pilot steers", found.modes, found.period)
    if found.modes_holding:
        every = found.modes_holding
        slow = tuple(mode for mode in every if mode in every[:4] or mode.joint)
        title = "slowest modes while the position is held"
        _print_modes(
            f"{title}, and those of joints" if slow != every[:4] else title, slow, found.period
        )
    _print_steps(found)
    print(f"\nthe law runs at {1.0 / found.period:g} Hz; {_rates(found.slowest)}")


def _print_phase(found: "Judgement") -> None:
    """Print the phase budget of each loop at its crossover."""
    from workbench.design.judge.phase_budget import PHASE_BUDGET_PARTS  # it loads Drake

    if not found.phase:
        return
    parts = [
        part
        for part in PHASE_BUDGET_PARTS
        if any(abs(getattr(each, part)) > 1e-9 for each in found.phase)
    ]
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
    """Print the effect of the noise of each sensor on attitude and commands."""
    if not found.noise:
        return
    print("\nwhat the noise of sensors does while the position is held, rms:")
    rows: list[tuple[str, ...]] = [
        ("", "roll [deg]", "pitch [deg]", "yaw [deg]", "commands [% of their mean]")
    ]
    for each in found.noise:
        angles = (f"{math.degrees(angle):.2g}" for angle in each.attitude)
        rows.append((each.sensor, *angles, f"{100.0 * each.worst_command:.2g}"))
    print_table(rows)


def _print_plant_input(found: "Judgement") -> None:
    """Print the margin of force and moments all at once."""
    print("\nat the plant's input, force and moments all at once:")
    rows = [("", "disk", "gains within", "at [rad/s]", "alone:", *found.plant_input.alone)]
    for what, each in (
        ("while the pilot steers", found.plant_input),
        ("while the position is held", found.plant_input_holding),
    ):
        if each is not None:
            low = (2.0 - each.disk_margin) / (2.0 + each.disk_margin)
            alone = (_number(margin, ".2f") for margin in each.alone.values())
            gains = f"{low:.2f} .. {1.0 / low:.2f}" if 0.0 < each.disk_margin < 2.0 else "-"
            disk, frequency = _number(each.disk_margin, ".2f"), _number(each.frequency, ".3g")
            rows.append((what, disk, gains, frequency, "", *alone))
    print_table(rows)


def print_sensitivities(title: str, found: "tuple[Sensitivity, ...]") -> None:
    """Print the sensitivity of every metric to every gain."""
    print(f"{title}: percent that a number changes per percent of a gain\n")
    names = [
        name
        for name in found[0].elasticities
        if any(abs(each.elasticities[name]) > _MIN_SENSITIVITY for each in found)
    ]
    rows = [("", "value", *names)]
    rows += [
        (each.metric, f"{each.value:.4g}", *(_number(each.elasticities[n], "+.2f") for n in names))
        for each in found
    ]
    print_table(rows)
    rest = [name for name in found[0].elasticities if name not in names]
    print(f"\nwithout effect: {', '.join(rest) or 'none'}")


def print_map(found: "OperatingMap") -> None:
    """Print the weakest point of a map, and the smallest disk margin at every point."""
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


def _cells(margins: "LoopMargins") -> tuple[str, ...]:
    """Return the numbers of a loop as texts."""
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
    """Print poles in the terms of python-control's `damp`, without those faster than sampling."""
    print(f"\n{title}:")
    shown = [mode for mode in found if not mode.gone_after(period)]
    print_modes(shown)
    if len(shown) < len(found):
        print(f"{len(found) - len(shown)} more die out within a sample")


def print_modes(shown: "Sequence[Mode]") -> None:
    """Print a table of modes in the terms of python-control's `damp`, with joints that move."""
    head = ("pole [1/s]", "damping", "frequency [rad/s]", "time constant [s]")
    rows = [(*head, "joint") if any(mode.joint for mode in shown) else head]
    rows += [
        (
            f"{mode.real:.4g}" + (f" ± {mode.imaginary:.4g}i" if mode.imaginary else ""),
            _number(mode.damping, ".3f"),
            f"{mode.frequency:.4g}",
            _number(mode.time_constant, ".3g"),
            plain_name(mode.joint),
        )[: len(rows[0])]
        for mode in shown
    ]
    print_table(rows, left=(4,))


def _print_steps(found: "Judgement") -> None:
    """Print linear and flown metrics side by side."""
    from workbench.design.step_metrics import STEP_NUMBERS

    if not found.steps:
        return
    print("\nsteps from hover, linear and flown:")
    rows = [("", *(word for step in found.steps for word in (f"{step.axis} linear", "flown")))]
    for name in STEP_NUMBERS:
        pairs = [metrics for step in found.steps for metrics in (step.linear, step.flown)]
        rows.append((name, *(_metric(metrics, name) for metrics in pairs)))
    print_table(rows)
    if any(step.linear is None for step in found.steps):
        print("a mode grows, so the linear model has no numbers")
    for step in found.steps:
        if step.broken:
            print(f"the {step.axis} step has no numbers: {step.broken}")
        for kind, metrics in (("linear", step.linear), ("flown", step.flown)):
            if metrics is not None and metrics.withheld:
                print(f"{step.axis} {kind}: numbers shown as - are withheld: {metrics.withheld}")


def _metric(metrics: "StepMetrics | None", name: str) -> str:
    """Return a metric as text; rounding errors count as 0."""
    value = math.nan if metrics is None else getattr(metrics, name)
    return _number(0.0 if abs(value) < _METRIC_ROUNDING else value, ".4g")


def _number(value: float, form: str) -> str:
    return format(value, form) if math.isfinite(value) else "-"


def _place(direction: "MapDirection", value: float) -> str:
    unit = "" if direction.unit == "1" else f" {direction.unit}"
    return f"{direction.name} {value:.3g}{unit}"


def _rates(slowest: "SlowestRate") -> str:
    """Print the slowest rates of the law."""
    if not math.isfinite(slowest.stable_period):
        fastest = 1.0 / slowest.samples[0].period
        return f"with these gains a mode grows even at {fastest:g} Hz, at every physics step"
    limit = ", the slowest there is," if slowest.at_limit else ""
    stable = f"it is stable down to {1.0 / slowest.stable_period:.1f} Hz{limit}"
    if not math.isfinite(slowest.safe_period):
        return f"{stable} but no rate has 30 deg of phase margin"
    return f"{stable} and keeps 30 deg of phase margin down to {1.0 / slowest.safe_period:.1f} Hz"
