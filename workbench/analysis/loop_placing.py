"""Gains for a wanted bandwidth of a loop, or for a wanted place of a pole."""

import math
from collections.abc import Mapping

import numpy as np

from workbench.analysis.queries import MovePole, SampleReach, ShapeLoop
from workbench.analysis.replies import LoopShaped, PoleMoved, ReachSampled
from workbench.analysis.subject import AnalysedVehicle
from workbench.analysis.work import Work, Working
from workbench.control.controller import Controller
from workbench.control.loop import Loop, loop_label
from workbench.design.judge.affine_loop import AffineLoop
from workbench.design.judge.loop_judgement import hover_margins, opened_to_steer
from workbench.design.judge.loop_shaping import LoopShaper, ShapedLoop
from workbench.design.judge.margins import RobustnessMeasure
from workbench.design.judge.noise import noise_effects
from workbench.design.judge.pole_placing import PlacedPole, PolePlacer, state_shares
from workbench.design.judge.step_pair import saturating_step
from workbench.design.linear.model import LinearModel
from workbench.design.linear.operating_point import HOVER_POINT
from workbench.scenario.axes import find_axis

UNSTABLE_MARGINS = {RobustnessMeasure.PHASE: math.radians(45.0), RobustnessMeasure.DISK: 0.7}
"""Margins for which the limits of an unstable loop are shown: phase [rad], disk."""
MAX_REPORTED_STEP_RATIO = 2.0
"""A step that saturates is reported up to this multiple of the usual step."""
REACH_SAMPLES = 17
"""Number of bandwidths, and of margins, for which the other loops are judged, too."""
MIN_REPORTED_NOISE = 0.002
"""Noise that moves commands by less is not reported."""
FIXED_PHASE_CAUSES = {
    "filters": "filters",
    "estimator": "the estimator",
    "delay": "delays",
    "hold": "the hold between updates",
    "rotors": "rotor lag",
}
"""Parts of a `PhaseBudget` that no gain changes, in words."""
STATE_PREFIX_PARTS = (
    (("speed_",), "rotor lag"),
    (("command_",), "delay"),
    (("filtered_", "derivative_lowpass", "setpoint_lowpass", "gyro_", "accel_"), "filters"),
    (("imu_", "wdot_", "vdot_"), "the hold between updates"),
    (("estimated_",), "the estimator"),
)
"""Prefixes of state names, and the part of the system in words."""


def shape_loop(subject: AnalysedVehicle, question: ShapeLoop, _: Work) -> Working:
    """Find gains with the requested bandwidth and margin, exactly or as nearly as possible."""
    shaper = _shaper(subject, question)
    yield None
    bandwidth, margin, robustness = question.bandwidth, question.margin, question.robustness
    if bandwidth is None or margin is None:
        now = shaper.loop.margins({})
        if bandwidth is None:
            bandwidth = now.bandwidth if now.stable else 1.0
        if margin is None:
            margin = robustness.of(now) if now.stable else UNSTABLE_MARGINS[robustness]
    found = shaper.shape(bandwidth, margin, robustness)
    names = subject.asked_names(question.gains)
    said = [_bandwidth_limit_text(subject, question, found)]
    if question.rests and found.margins.stable:
        yield None
        said += _rotor_load_text(subject, question, found)
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


def sample_reach(subject: AnalysedVehicle, question: SampleReach, work: Work) -> Working:
    """Compute the margins of all loops for some bandwidths and margins that a loop can reach."""
    shaper, robustness = _shaper(subject, question), question.robustness
    now = shaper.loop.margins({})
    if not now.stable:
        yield ReachSampled()
        return
    gains, found = subject.gains(question.gains), []
    for (low, high), is_bandwidth in ((question.bandwidths, True), (question.margins, False)):
        samples = []
        spaced = np.geomspace if is_bandwidth else np.linspace
        for value in spaced(low, high, REACH_SAMPLES).tolist() if high > low > 0.0 else ():
            asked = (value, robustness.of(now)) if is_bandwidth else (now.bandwidth, value)
            shaped = shaper.shape(*asked, robustness)
            work.check()
            yield None
            holding = subject.model({**gains, **shaped.gains})
            samples.append((value, tuple(hover_margins(holding).values())))
            yield None
        found.append(tuple(samples))
    yield ReachSampled(tuple(hover_margins(subject.model(gains))), *found)


def _shaper(subject: AnalysedVehicle, question: ShapeLoop | SampleReach) -> LoopShaper:
    """Return the shaper of the loop; it is kept while only the wishes change."""
    gains = subject.gains(question.gains)
    linked = subject.linked(question.linked)
    loop = subject.controller.loop(question.loop)

    def model_of(values: Mapping[str, float]) -> LinearModel:
        holding = subject.model(values)
        return holding if loop.hold else opened_to_steer(holding)

    made = subject.shaper
    key = (loop, gains, linked)
    if made is None or made[0] != key:
        made = subject.shaper = (
            key,
            LoopShaper(AffineLoop(model_of, loop, gains, subject.table, linked)),
        )
    return made[1]


def _bandwidth_limit_text(subject: AnalysedVehicle, question: ShapeLoop, found: ShapedLoop) -> str:
    """Return what limits the bandwidth, and, with the slider at rest, what consumes the phase."""
    reach = found.bandwidth
    cause = _largest_phase_lag(subject, question, found) if question.rests else ""
    if reach.gain:
        return f"Faster takes more {reach.gain} than its largest value. {cause}".rstrip()
    return cause


def _largest_phase_lag(subject: AnalysedVehicle, question: ShapeLoop, found: ShapedLoop) -> str:
    """Return the largest phase lag at the crossover that no gain of the loop can change."""
    controller = subject.controller
    loop, margins = controller.loop(question.loop), found.margins
    if not margins.stable or math.isnan(margins.crossover):
        return ""
    gains = {**subject.gains(question.gains), **found.gains}
    holding = subject.model(gains)
    model = holding if loop.hold else opened_to_steer(holding)
    asked = subject.linear_gains(gains)
    budgets = subject.phases.budgets(model, {loop.name: margins.crossover}, asked)
    parts = {words: -getattr(budgets[0], part) for part, words in FIXED_PHASE_CAUSES.items()}
    inside = _inner_loop_name(controller, loop)
    if inside:
        parts[f"the {inside} loop inside"] = -budgets[0].law - 0.5 * math.pi
    told = sorted(parts.items(), key=lambda each: -each[1])[:2]
    words = [f"{name} {math.degrees(angle):.0f}°" for name, angle in told if angle > 0.0]
    listed = " and ".join(words)
    return f"At {margins.crossover:.3g} rad/s {listed} of phase." if words else ""


def _rotor_load_text(subject: AnalysedVehicle, question: ShapeLoop, found: ShapedLoop) -> list[str]:
    """Return the rotors' load with these gains: by the step of the loop's axis, and by noise."""
    study = subject.study
    gains = {**subject.linear_gains(question.gains), **found.gains}
    said = []
    axis = subject.controller.loop(question.loop).axis
    if axis:
        reach = saturating_step(study.sampled(HOVER_POINT, gains), axis, study.vehicle)
        row = find_axis(axis)
        if reach < MAX_REPORTED_STEP_RATIO * row.amplitude:
            said.append(f"A step along {axis} of {reach:.2g} {row.unit} saturates the rotors.")
    noise = max(each.worst_command for each in noise_effects(study, HOVER_POINT, gains))
    if noise > MIN_REPORTED_NOISE:
        said.append(f"Noise moves the rotors' commands by {100.0 * noise:.2g} % rms.")
    return said


def _inner_loop_name(controller: Controller, loop: Loop) -> str:
    """Return the name of the next inner loop along a loop's axis; "" for none."""
    names = [each.name for each in controller.loops]
    behind = controller.loops[0 if loop.hold else names.index(loop.name) + 1 :]
    along = (each.name for each in behind if loop.axis and each.axis == loop.axis and not each.hold)
    return next((loop_label(name) for name in along if name != loop.name), "")


def move_pole(subject: AnalysedVehicle, question: MovePole, _: Work) -> Working:
    """Find gains that move the pole to its place, or as near as possible."""
    placer = _placer(subject, question)
    yield None
    found = placer.place(question.place)
    names = subject.asked_names(question.gains)
    yield PoleMoved(
        gains={names.get(name, name): value for name, value in found.gains.items()},
        pole=found.pole,
        reached=found.reached,
        said="" if found.reached else _pole_limit_text(subject, question, found),
    )


def _placer(subject: AnalysedVehicle, question: MovePole) -> PolePlacer:
    """Return the placer of the pole; it is kept while only the requested place changes."""
    gains = subject.gains(question.gains)
    linked = subject.linked(question.linked)
    loop = subject.controller.loop(question.loop)
    made = subject.placer
    key = (loop, gains, linked, question.pole)
    if made is None or made[0] != key:
        placer = PolePlacer(subject.model, loop.gains, gains, subject.table, question.pole, linked)
        made = subject.placer = key, placer
    return made[1]


def _pole_limit_text(subject: AnalysedVehicle, question: MovePole, found: PlacedPole) -> str:
    """Return why a pole cannot move to a place, as a sentence."""
    name = loop_label(question.loop)
    law = subject.controller
    model = subject.model({**subject.gains(question.gains), **found.gains})
    if found.unmoved:
        return (
            f"No gain of {name} moves this pole: it belongs to "
            f"{_dominant_part(law, model, found.pole)}."
        )
    if found.limit:
        row = subject.table.find(found.limit)
        at_least = abs(found.gains[row.name] - row.minimum) < 1e-6 * row.maximum
        end = "smallest" if at_least else "largest"
        return f"The nearest possible: {row.name} is at its {end} value."
    if len(law.loop(question.loop).gains) == 1:
        return f"The nearest possible: {name} has one gain, which moves it along one line."
    holder = _dominant_part(law, model, found.pole)
    return f"The nearest that the gains of {name} can reach: the pole also belongs to {holder}."


def _dominant_part(law: Controller, model: LinearModel, pole: complex) -> str:
    """Return the part of the system with the largest participation in a pole, in words."""
    remembered = {state.name for state in law.memory}
    shares: dict[str, float] = {}
    for name, share in zip(model.state_names, state_shares(model, pole), strict=True):
        words = next(
            (each for begins, each in STATE_PREFIX_PARTS if name.startswith(begins)), "another loop"
        )
        if name in remembered:
            words = "the memory of the law"
        shares[words] = shares.get(words, 0.0) + share
    return max(shares, key=lambda words: shares[words])
