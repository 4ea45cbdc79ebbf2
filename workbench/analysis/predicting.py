"""How a step would be flown with gains, and how a flight goes on from a checkpoint."""

from concurrent.futures import wait
from typing import TYPE_CHECKING

import numpy as np

from workbench.analysis.questions import Fork, Gains, LoadStep, Predict, Step
from workbench.analysis.replies import Forked, LoadNumbers, Predicted, StepNumbers
from workbench.analysis.subject import Subject
from workbench.analysis.work import Work, Working
from workbench.common.errors import WorkbenchError
from workbench.design.branches import FlownBranch
from workbench.design.load_metrics import LoadMetrics, load_metrics
from workbench.design.load_step import check_load, predict_load_step
from workbench.design.response_metrics import step_metrics
from workbench.design.step_response import check_duration, check_step
from workbench.scenario.axes import AXES

if TYPE_CHECKING:
    from collections.abc import Generator

    from workbench.design.rollout.engine import RolloutEngine

LONGEST = 20.0
"""A step that is flown while somebody waits [s]."""
PATIENCE = 0.005
"""Between two looks at what loads [s]."""


def fork(subject: Subject, question: Fork, work: Work) -> Working:
    """Answer how the flight goes on from a checkpoint with each branch's values, to the bit."""
    flown = subject.forker.fly(
        question.checkpoint,
        question.branches,
        question.duration,
        question.step,
        lambda: work.stopped,
    )
    work.check()
    yield Forked(flown, tuple(_numbers(question, branch) for branch in flown))


def _numbers(question: Fork, branch: FlownBranch) -> StepNumbers | None:
    """Return the metrics of a branch's step, which goes on top of what was asked for before."""
    step, checkpoint = question.step, question.checkpoint
    if step is None or branch.lost:
        return None
    before = (*checkpoint.velocity, checkpoint.yaw_rate)[AXES.index(step.axis)]
    return step_numbers(
        branch.time - checkpoint.time,
        branch.response(step.axis) - before,
        step.amplitude,
        float(branch.rotor_use.max()),
    )


def predict(subject: Subject, question: Predict, _: Work) -> Working:
    """Answer how a step would be flown from hover with the step's heading.

    The air is as the settings ask for.
    """
    check_short(question.step)
    gains = subject.gains(question.gains)
    engine = yield from ready_engine(subject)
    match question.step:
        case Step() as step:
            yield _predicted_step(engine, gains, question, step)
        case LoadStep() as step:
            yield _predicted_load(engine, gains, question, step)


def _predicted_load(
    engine: "RolloutEngine", gains: Gains, question: Predict, step: LoadStep
) -> Predicted:
    """Return the answer for a step of a load."""
    time, response, use = predict_load_step(
        engine,
        gains,
        step.axis,
        step.amplitude,
        duration=step.duration,
        acts=step.acts,
        heading=step.heading,
    )
    return Predicted(
        gains=question.gains,
        step=step,
        time=time,
        response=response,
        numbers=load_numbers(load_metrics(time, response), use),
        lost=not np.isfinite(response).all(),
    )


def _predicted_step(
    engine: "RolloutEngine", gains: Gains, question: Predict, step: Step
) -> Predicted:
    """Return the answer for a step of a command."""
    flown = engine.fly(
        [gains], step.axis, step.amplitude, duration=step.duration, heading=step.heading
    )
    response = flown.response[0]
    use = float(flown.peak_rotor_use[0])
    return Predicted(
        gains=question.gains,
        step=step,
        time=flown.time,
        response=response,
        numbers=step_numbers(flown.time, response, step.amplitude, use),
        lost=bool(flown.diverged_at[0] == flown.diverged_at[0]),
    )


def step_numbers(
    time: np.ndarray, response: np.ndarray, command: float, peak_rotor_use: float
) -> StepNumbers:
    """Return what a screen shows of a step's metrics, see `step_metrics`."""
    metrics = step_metrics(time, response, command)
    return StepNumbers(
        rise_time=metrics.rise_time,
        settling_time=metrics.settling_time,
        overshoot=metrics.overshoot,
        steady_state_error=metrics.steady_state_error,
        peak_rotor_use=peak_rotor_use,
        withheld=metrics.withheld,
    )


def load_numbers(metrics: LoadMetrics, peak_rotor_use: float) -> LoadNumbers:
    """Return what a screen shows of a load's metrics."""
    return LoadNumbers(
        peak=metrics.peak,
        settling_time=metrics.settling_time,
        steady_state_error=metrics.steady_state_error,
        peak_rotor_use=peak_rotor_use,
        withheld=metrics.withheld,
    )


def ready_engine(subject: Subject) -> "Generator[None, None, RolloutEngine]":
    """Rest until the engine of compiled flights is loaded, and return it."""
    loading = subject.load_engine()
    while not loading.done():
        wait([loading], PATIENCE)
        yield None
    return loading.result()


def check_short(step: Step | LoadStep, longest: float = LONGEST) -> None:
    """Refuse a step that makes no flight, or one too long to wait for.

    Raises:
        WorkbenchError: if it does.
    """
    check = check_load if isinstance(step, LoadStep) else check_step
    check(step.axis, step.amplitude)
    check_duration(step.duration)
    if step.duration > longest:
        raise WorkbenchError(
            f"a step of {step.duration:g} s is too long to be shown at once: give it {longest:g} s "
            "at most"
        )
