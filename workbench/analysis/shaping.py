"""Finds the gains of one loop for a bandwidth and a margin or a pole, and what limits them."""

import math
from collections.abc import Mapping

from workbench.analysis.judging import opened_to_steer
from workbench.analysis.questions import MovePole, ShapeLoop
from workbench.analysis.replies import LoopShaped, PoleMoved
from workbench.analysis.subject import Subject
from workbench.analysis.work import Work, Working
from workbench.control.controller import Controller, Loop
from workbench.design.judge.loop_shaping import End, LoopShaper, Shaped
from workbench.design.judge.margins import Robustness
from workbench.design.judge.noise import noise_effects
from workbench.design.judge.pole_placing import Placed, PolePlacer, state_shares
from workbench.design.judge.step_pair import saturating_step
from workbench.design.linear.model import LinearModel
from workbench.design.linear.operating_point import HOVER
from workbench.scenario.axes import find_axis

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


def shape_loop(subject: Subject, question: ShapeLoop, _: Work) -> Working:
    """Answer which gains do it exactly, or as nearly as possible."""
    shaper = _shaper(subject, question)
    yield None
    bandwidth, margin, robustness = question.bandwidth, question.margin, question.robustness
    if bandwidth is None or margin is None:
        now = shaper.margins({})
        if bandwidth is None:
            bandwidth = now.bandwidth if now.stable else 1.0
        if margin is None:
            margin = robustness.of(now) if now.stable else UNSTABLE_MARGINS[robustness]
    shape = shaper.shape_disk if robustness is Robustness.DISK else shaper.shape
    found = shape(bandwidth, margin)
    names = subject.asked_names(question.gains)
    said = [_said(subject, question, found)]
    if question.rests and found.margins.stable:
        yield None
        said += _rotors_said(subject, question, found)
    yield LoopShaped(
        asked=question,
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


def _said(subject: Subject, question: ShapeLoop, found: Shaped) -> str:
    """Return what limits the bandwidth, and, with the slider at rest, what consumes the phase."""
    reach = found.bandwidth
    cause = _cause(subject, question, found) if question.rests else ""
    if reach.end is End.LARGEST:
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
    """Answer which gains move the pole there, or as near as possible."""
    placer = _placer(subject, question)
    yield None
    found = placer.place(question.place)
    names = subject.asked_names(question.gains)
    yield PoleMoved(
        asked=question,
        gains={names.get(name, name): value for name, value in found.gains.items()},
        pole=found.pole,
        reached=found.reached,
        said="" if found.reached else _pole_said(subject, question, found),
    )


def _placer(subject: Subject, question: MovePole) -> PolePlacer:
    """Return the placer of the pole; it is kept while only the wanted place changes."""
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
        return f"No gain of {name} moves this pole: it is of {_holder(law, model, found.pole)}."
    if found.limit:
        row = subject.table.find(found.limit)
        at_least = abs(found.gains[row.name] - row.minimum) < 1e-6 * row.maximum
        end = "smallest" if at_least else "largest"
        return f"As near as it goes: {row.name} is at its {end} value."
    if len(law.loop(question.loop).gains) == 1:
        return f"As near as it goes: {name} has one gain, which moves it along one line."
    holder = _holder(law, model, found.pole)
    return f"As near as the gains of {name} bring it: it is of {holder}, too."


def _holder(law: Controller, model: LinearModel, pole: complex) -> str:
    """Return the part of the system with the largest participation in a pole, in words."""
    remembered = {state.name for state in law.memory}
    shares: dict[str, float] = {}
    for name, share in zip(model.state_names, state_shares(model, pole), strict=True):
        words = next((each for begins, each in HOLDERS if name.startswith(begins)), "another loop")
        if name in remembered:
            words = "what the law remembers"
        shares[words] = shares.get(words, 0.0) + share
    return max(shares, key=lambda words: shares[words])
