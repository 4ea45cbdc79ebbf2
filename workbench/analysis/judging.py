"""Stability of the hover with given gains, and the gains of one loop for a margin or a pole.

Margins, poles, and stable ranges of gains describe the stability. The gains of a loop come with a
sentence about what limits them.
"""

import math
from collections.abc import Callable, Iterator, Mapping

import numpy as np

from workbench.analysis.questions import (
    DrawFrequency,
    FindRanges,
    Judge,
    JudgePlantInput,
    MovePole,
    PlanMeasurement,
    ShapeLoop,
)
from workbench.analysis.replies import Judged, JudgedLoop, LoopShaped, PoleMoved
from workbench.analysis.subject import Subject
from workbench.analysis.work import Work, Working
from workbench.control.controller import Controller, Loop
from workbench.design.judge.gang_of_four import gang_of_four
from workbench.design.judge.loop_judgement import growing_loops, hover_margins, opened_to_steer
from workbench.design.judge.loop_measurement import loop_injection
from workbench.design.judge.loop_response import INTEGRATOR, closed_poles, growth_rate
from workbench.design.judge.loop_shaping import LoopShaper, Shaped
from workbench.design.judge.margins import LoopMargins, Robustness
from workbench.design.judge.modes import natural_poles
from workbench.design.judge.multiloop import multiloop_margin
from workbench.design.judge.noise import noise_effects
from workbench.design.judge.phase_budget import PARTS
from workbench.design.judge.pole_placing import Placed, PolePlacer, state_shares
from workbench.design.judge.step_pair import saturating_step
from workbench.design.linear.model import LinearModel
from workbench.design.linear.operating_point import HOLDING, HOVER
from workbench.scenario.axes import find_axis
from workbench.scenario.parameters import Parameter

COARSE = 8
"""Number of values tried between a gain's own and each limit."""
Turned = tuple[tuple[str, float], ...]
"""Phase by the name of its cause [rad]."""
LEAST = 1e-3
"""Smallest value tried, as a share of the limit; 0 has no logarithm."""
EXACT = 2e-3
"""Relative accuracy of a range's ends."""
Search = Iterator[tuple[float, float] | None]
FORGOTTEN = 0.05
"""A smaller sampled pole is left out: it decays within two samples, and rounding moves it."""
UNSTABLE_MARGINS = {Robustness.PHASE: math.radians(45.0), Robustness.DISK: 0.7}
"""Margins for which the limits of an unstable loop are shown: phase [rad], disk."""
NEAR_SATURATION = 2.0
"""A step that saturates is reported up to this multiple of the usual step."""
NOISY = 0.002
"""Noise that moves commands by less is not reported."""
CAUSES = {
    "filters": "filters",
    "estimator": "the estimator",
    "delay": "delays",
    "hold": "the hold between updates",
    "rotors": "rotor lag",
}
"""Parts of a `PhaseBudget` that no gain changes, in words."""
HOLDERS = (
    (("speed_",), "rotor lag"),
    (("command_",), "delay"),
    (("filtered_", "derivative_lowpass", "setpoint_lowpass", "gyro_", "accel_"), "filters"),
    (("imu_", "wdot_", "vdot_"), "the hold between updates"),
    (("estimated_",), "the estimator"),
)
"""Prefixes of state names, and the part of the system in words."""


def find_ranges(subject: Subject, question: FindRanges, work: Work) -> Working:
    """Compute the stable range of each gain, by the eigenvalues of the closed loop.

    A gain without a stable value within its limits is left out. If its own value is unstable, the
    range is the nearest stable one that a coarse search finds.
    """
    gains, names = subject.gains(question.gains), subject.asked_names(question.gains)
    found: dict[str, tuple[float, float]] = {}
    loops = subject.table.controller.loops
    # parameters that affect the loops' stability
    for name in dict.fromkeys(name for loop in loops for name in loop.gains):
        row = subject.table.find(name)
        for span in _stable_span(row, gains[name], _test(subject, gains, name)):
            work.check()
            if span is not None:
                found[names.get(name, name)] = span
            yield None
    yield found


def is_stable(holding: LinearModel) -> bool:
    """Return whether a closed loop is stable, both while it holds a place and while steered."""
    return all(
        growth_rate(closed_poles(model), model.period) < INTEGRATOR
        for model in (opened_to_steer(holding), holding)
    )


def _test(subject: Subject, gains: Mapping[str, float], name: str) -> Callable[[float], bool]:
    """Return a function that tells whether the loop is stable with a value of a gain."""
    return lambda value: is_stable(subject.model({**gains, name: value}))


def _stable_span(row: Parameter, own: float, stable: Callable[[float], bool]) -> Search:
    """Yield None for each value tried, then the range of stable values, if there is one."""
    values = [own, *_spread(row, own)]
    looked: dict[float, bool] = {}
    for value in values:
        looked[value] = stable(value)
        yield None
    grid = sorted(looked)
    inside = [value for value in grid if looked[value]]
    if not inside:
        return
    start = grid.index(min(inside, key=lambda value: abs(_place(row, value) - _place(row, own))))
    first = last = start
    while first > 0 and looked[grid[first - 1]]:
        first -= 1
    while last < len(grid) - 1 and looked[grid[last + 1]]:
        last += 1
    ends = []
    for inner, outer in ((first, first - 1), (last, last + 1)):
        good = grid[inner]
        if 0 <= outer < len(grid):
            bad = grid[outer]
            while abs(bad - good) > EXACT * max(good, LEAST * row.maximum):
                middle = 0.5 * (good + bad)
                good, bad = (middle, bad) if stable(middle) else (good, middle)
                yield None
        ends.append(good)
    yield ends[0], ends[1]


def _spread(row: Parameter, own: float) -> list[float]:
    """Return the first values to try, from limit to limit, evenly spaced in their logarithm."""
    least = max(row.minimum, LEAST * row.maximum)
    middle = min(max(own, least), row.maximum)
    below = np.geomspace(least, middle, COARSE + 1)
    above = np.geomspace(middle, row.maximum, COARSE + 1)
    return [row.minimum, *below[:-1].tolist(), *above[1:-1].tolist(), row.maximum]


def _place(row: Parameter, value: float) -> float:
    """Return a value's position on a logarithmic slider."""
    return math.log(max(value, LEAST * row.maximum))


def judge(subject: Subject, question: Judge, _: Work) -> Working:
    """Compute the stability with given gains.

    Poles are those of the sampled loop that flies, in continuous terms, s = ln(z) / period, while
    the place is held: then every gain affects some of them.
    """
    holding = subject.model(subject.gains(question.gains))
    steering = opened_to_steer(holding)
    margins = hover_margins(holding)
    stable = all(each.stable for each in margins.values())
    steered = () if stable else growing_loops(steering)
    held = () if stable or steered else growing_loops(holding)
    growing = steered + held
    turned = _turned(subject, (steering, holding), margins, question.gains) if stable else {}
    yield Judged(
        loops=tuple(
            JudgedLoop(
                **vars(margins[each.name]),
                name=each.name,
                growing=each.name in growing,
                turned=turned.get(each.name, ()),
            )
            for each in holding.loops
        ),
        poles=shown_poles(holding),
        stable=stable,
        said=_said(steered, held),
    )


def judge_plant_input(subject: Subject, question: JudgePlantInput, _: Work) -> Working:
    """Compute the disk margin of simultaneous force and moments, as `workbench judge` does."""
    gains = subject.linear_gains(question.gains)
    found = []
    for point in (HOVER, HOLDING):
        found.append(multiloop_margin(subject.study.plant_input(point, gains)).disk_margin)
        yield None
    yield tuple(found)


def draw_frequency(subject: Subject, question: DrawFrequency, _: Work) -> Working:
    """Compute the frequency response of one loop, of the model that margins are computed with.

    For a loop that holds a place, the place is held; for all others the pilot steers.
    """
    loop = subject.table.controller.loop(question.loop)
    holding = subject.model(subject.gains(question.gains))
    yield gang_of_four(holding if loop.hold else opened_to_steer(holding), loop, question.cut)


def plan_measurement(subject: Subject, question: PlanMeasurement, _: Work) -> Working:
    """Plan the injection that a loop tolerates, by a model of the flight."""
    loop = subject.table.controller.loop(question.loop)
    gains, point = subject.linear_gains(question.gains), HOLDING if loop.hold else HOVER
    model = subject.study.sampled(point, gains)
    yield loop_injection(model, loop, subject.study.vehicle, question.cut), loop.hold


def shown_poles(model: LinearModel) -> np.ndarray:
    """Return a closed loop's poles in continuous terms [1/s], except those that decay at once.

    Poles on the negative real axis of z appear at half the sampling rate.
    """
    poles = closed_poles(model)
    return natural_poles(poles[np.abs(poles) > FORGOTTEN], model.period)


def _turned(
    subject: Subject,
    models: tuple[LinearModel, LinearModel],
    margins: Mapping[str, LoopMargins],
    asked: Mapping[str, float],
) -> dict[str, Turned]:
    """Return the causes of phase lag and lead of each loop."""
    crossovers = {name: each.crossover for name, each in margins.items()}
    gains = subject.linear_gains(asked)
    return {
        budget.loop: tuple((part, getattr(budget, part)) for part in PARTS)
        for model in models
        for budget in subject.phases.budgets(model, crossovers, gains)
    }


def _said(steered: tuple[str, ...], held: tuple[str, ...]) -> str:
    """Return a sentence about what is unstable, "" if all is stable."""
    if steered:
        return f"unstable: a mode grows through {_listed(steered)}"
    return f"holding the position is unstable: a mode grows through {_listed(held)}" if held else ""


def _listed(names: tuple[str, ...]) -> str:
    words = [name.replace("_", " ") for name in names]
    return " and ".join([", ".join(words[:-1]), words[-1]] if len(words) > 1 else words)


def shape_loop(subject: Subject, question: ShapeLoop, _: Work) -> Working:
    """Find gains with the requested bandwidth and margin, exactly or as nearly as possible."""
    shaper = _shaper(subject, question)
    yield None
    bandwidth, margin, robustness = question.bandwidth, question.margin, question.robustness
    if bandwidth is None or margin is None:
        now = shaper.margins({})
        if bandwidth is None:
            bandwidth = now.bandwidth if now.stable else 1.0
        if margin is None:
            margin = robustness.of(now) if now.stable else UNSTABLE_MARGINS[robustness]
    found = shaper.shape(bandwidth, margin, robustness)
    names = subject.asked_names(question.gains)
    said = [_shape_said(subject, question, found)]
    if question.rests and found.margins.stable:
        yield None
        said += _rotors_said(subject, question, found)
    yield LoopShaped(
        gains={names.get(name, name): value for name, value in found.gains.items()},
        bandwidth=found.margins.bandwidth,
        phase_margin=found.margins.phase_margin,
        disk_margin=found.margins.disk_margin,
        reached=found.reached,
        bandwidths=(found.bandwidth.low, found.bandwidth.high),
        reach=(found.robustness.low, found.robustness.high),
        said=" ".join(filter(None, said)),
    )


def _shaper(subject: Subject, question: ShapeLoop) -> LoopShaper:
    """Return the shaper of the loop; it is kept while only the wishes change."""
    gains = subject.gains(question.gains)
    linked = subject.linked(question.linked)
    loop = subject.table.controller.loop(question.loop)

    def model_of(values: Mapping[str, float]) -> LinearModel:
        holding = subject.model(values)
        return holding if loop.hold else opened_to_steer(holding)

    made = subject.shaper
    key = (loop, gains, linked)
    if made is None or made[0] != key:
        made = subject.shaper = key, LoopShaper(model_of, loop, gains, subject.table, linked)
    return made[1]


def _shape_said(subject: Subject, question: ShapeLoop, found: Shaped) -> str:
    """Return what limits the bandwidth, and, with the slider at rest, what consumes the phase."""
    reach = found.bandwidth
    cause = _cause(subject, question, found) if question.rests else ""
    if reach.gain:
        return f"Faster takes more {reach.gain} than its largest value. {cause}".rstrip()
    return cause


def _cause(subject: Subject, question: ShapeLoop, found: Shaped) -> str:
    """Return the largest phase lag at the crossover that no gain of the loop can change."""
    controller = subject.table.controller
    loop, margins = controller.loop(question.loop), found.margins
    if not margins.stable or math.isnan(margins.crossover):
        return ""
    gains = {**subject.gains(question.gains), **found.gains}
    holding = subject.model(gains)
    model = holding if loop.hold else opened_to_steer(holding)
    asked = subject.linear_gains(gains)
    budgets = subject.phases.budgets(model, {loop.name: margins.crossover}, asked)
    parts = {words: -getattr(budgets[0], part) for part, words in CAUSES.items()}
    inside = _inside(controller, loop)
    if inside:
        parts[f"the {inside} loop inside"] = -budgets[0].law - 0.5 * math.pi
    told = sorted(parts.items(), key=lambda each: -each[1])[:2]
    words = [f"{name} {math.degrees(angle):.0f}°" for name, angle in told if angle > 0.0]
    listed = " and ".join(words)
    return f"At {margins.crossover:.3g} rad/s {listed} of phase." if words else ""


def _rotors_said(subject: Subject, question: ShapeLoop, found: Shaped) -> list[str]:
    """Return the rotors' load with these gains: by the step of the loop's axis, and by noise."""
    study = subject.study
    gains = {**subject.linear_gains(question.gains), **found.gains}
    said = []
    axis = subject.table.controller.loop(question.loop).axis
    if axis:
        reach = saturating_step(study.sampled(HOVER, gains), axis, study.vehicle)
        row = find_axis(axis)
        if reach < NEAR_SATURATION * row.amplitude:
            said.append(f"A step along {axis} of {reach:.2g} {row.unit} saturates the rotors.")
    noise = max(each.worst_command for each in noise_effects(study, HOVER, gains))
    if noise > NOISY:
        said.append(f"Noise moves the rotors' commands by {100.0 * noise:.2g} % rms.")
    return said


def _inside(controller: Controller, loop: Loop) -> str:
    """Return the name of the next inner loop along a loop's axis; "" for none."""
    names = [each.name for each in controller.loops]
    behind = controller.loops[0 if loop.hold else names.index(loop.name) + 1 :]
    along = (each.name for each in behind if loop.axis and each.axis == loop.axis and not each.hold)
    return next((name.replace("_", " ") for name in along if name != loop.name), "")


def move_pole(subject: Subject, question: MovePole, _: Work) -> Working:
    """Find gains that move the pole to its place, or as near as possible."""
    placer = _placer(subject, question)
    yield None
    found = placer.place(question.place)
    names = subject.asked_names(question.gains)
    yield PoleMoved(
        gains={names.get(name, name): value for name, value in found.gains.items()},
        pole=found.pole,
        reached=found.reached,
        said="" if found.reached else _pole_said(subject, question, found),
    )


def _placer(subject: Subject, question: MovePole) -> PolePlacer:
    """Return the placer of the pole; it is kept while only the requested place changes."""
    gains = subject.gains(question.gains)
    linked = subject.linked(question.linked)
    loop = subject.table.controller.loop(question.loop)
    made = subject.placer
    key = (loop, gains, linked, question.pole)
    if made is None or made[0] != key:
        placer = PolePlacer(subject.model, loop.gains, gains, subject.table, question.pole, linked)
        made = subject.placer = key, placer
    return made[1]


def _pole_said(subject: Subject, question: MovePole, found: Placed) -> str:
    """Return why a pole cannot move to a place, as a sentence."""
    name = question.loop.replace("_", " ")
    law = subject.table.controller
    model = subject.model({**subject.gains(question.gains), **found.gains})
    if found.unmoved:
        return (
            f"No gain of {name} moves this pole: it belongs to {_holder(law, model, found.pole)}."
        )
    if found.limit:
        row = subject.table.find(found.limit)
        at_least = abs(found.gains[row.name] - row.minimum) < 1e-6 * row.maximum
        end = "smallest" if at_least else "largest"
        return f"The nearest possible: {row.name} is at its {end} value."
    if len(law.loop(question.loop).gains) == 1:
        return f"The nearest possible: {name} has one gain, which moves it along one line."
    holder = _holder(law, model, found.pole)
    return f"The nearest that the gains of {name} can reach: the pole also belongs to {holder}."


def _holder(law: Controller, model: LinearModel, pole: complex) -> str:
    """Return the part of the system with the largest participation in a pole, in words."""
    remembered = {state.name for state in law.memory}
    shares: dict[str, float] = {}
    for name, share in zip(model.state_names, state_shares(model, pole), strict=True):
        words = next((each for begins, each in HOLDERS if name.startswith(begins)), "another loop")
        if name in remembered:
            words = "the memory of the law"
        shares[words] = shares.get(words, 0.0) + share
    return max(shares, key=lambda words: shares[words])
