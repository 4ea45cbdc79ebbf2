"""How stable the drone hovers with gains: margins of every loop, and the closed loop's poles."""

from dataclasses import replace

import numpy as np

from workbench.analysis.questions import Judge, JudgePlantInput
from workbench.analysis.replies import Judged, JudgedLoop, JudgedPlantInput
from workbench.analysis.subject import Subject
from workbench.analysis.work import Work, Working
from workbench.design.judge.live import HOLDING
from workbench.design.judge.loop_judgement import growing_loops
from workbench.design.judge.loop_response import closed_poles
from workbench.design.judge.margins import LoopMargins, all_margins
from workbench.design.judge.modes import natural_poles
from workbench.design.judge.multiloop import multiloop_margin
from workbench.design.linear.model import LinearModel
from workbench.design.linear.study import HOVER

FORGOTTEN = 0.05
"""A sampled pole no larger than this leaves nothing after two samples: rounding moves it."""


def judge(subject: Subject, question: Judge, _: Work) -> Working:
    """Answer how stable gains are, as `live_margins` does.

    Poles are of the sampled loop that flies, in continuous terms, s = ln(z) / period, while the
    place is held, so that every gain moves some of them.
    """
    holding = subject.models.model(subject.gains(question.gains))
    steering = opened_to_steer(holding)
    margins = _margins(steering, hold=False) | _margins(holding, hold=True)
    stable = all(each.stable for each in margins.values())
    steered = () if stable else growing_loops(steering)
    held = () if stable or steered else growing_loops(holding)
    growing = steered + held
    yield Judged(
        gains=question.gains,
        loops=tuple(
            _loop(each.name, margins[each.name], each.name in growing) for each in holding.loops
        ),
        poles=shown_poles(holding),
        stable=stable,
        said=_said(steered, held),
    )


def judge_plant_input(subject: Subject, question: JudgePlantInput, _: Work) -> Working:
    """Answer how much force and moments bear all at once, as `workbench judge` does."""
    gains = subject.linear_gains(question.gains)
    found = []
    for point in (HOVER, HOLDING):
        found.append(multiloop_margin(subject.study.plant_input(point, gains)).disk_margin)
        yield None
    yield JudgedPlantInput(question.gains, *found)


def opened_to_steer(holding: LinearModel) -> LinearModel:
    """Return a closed loop with its position loops opened: then a pilot steers."""
    steering = holding.opened([loop.error for loop in holding.loops if loop.hold])
    return replace(steering, trim=replace(steering.trim, point=HOVER))


def shown_poles(model: LinearModel) -> np.ndarray:
    """Return a closed loop's poles in continuous terms [1/s], those that die within a sample out.

    Poles on the negative real axis of z lie at half the sampling rate.
    """
    poles = closed_poles(model)
    return natural_poles(poles[np.abs(poles) > FORGOTTEN], model.period)


def _margins(model: LinearModel, *, hold: bool) -> dict[str, LoopMargins]:
    """Return the margins of the loops that are closed only while a place is held, or the others."""
    loops = [loop for loop in model.loops if loop.hold is hold]
    found = all_margins(model, [loop.point("actuator") for loop in loops])
    return {loop.name: margins for loop, margins in zip(loops, found, strict=True)}


def _loop(name: str, margins: LoopMargins, growing: bool) -> JudgedLoop:
    return JudgedLoop(
        name=name,
        gain_margin=margins.gain_margin,
        gain_reduction_margin=margins.gain_reduction_margin,
        phase_margin=margins.phase_margin,
        delay_margin=margins.delay_margin,
        disk_margin=margins.disk_margin,
        crossover=margins.crossover,
        stable=margins.stable,
        growing=growing,
    )


def _said(steered: tuple[str, ...], held: tuple[str, ...]) -> str:
    """Return what is unstable, "" if nothing is."""
    if steered:
        return f"unstable: a swing grows through {_listed(steered)}"
    return f"holding a place is unstable: a swing grows through {_listed(held)}" if held else ""


def _listed(names: tuple[str, ...]) -> str:
    words = [name.replace("_", " ") for name in names]
    return " and ".join([", ".join(words[:-1]), words[-1]] if len(words) > 1 else words)
