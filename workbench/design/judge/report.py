"""The judgement of a vehicle with its gains: loops, modes and steps."""

import dataclasses
from collections.abc import Callable, Mapping
from dataclasses import dataclass

from workbench.design.judge.loop_judgement import LoopJudgement, growing_loops, judge_loops
from workbench.design.judge.modes import Mode, modes
from workbench.design.judge.multiloop import MultiloopMargin, multiloop_margin
from workbench.design.judge.noise import NoiseEffect, noise_effects
from workbench.design.judge.phase_budget import PhaseBudget, phase_budgets
from workbench.design.judge.sampled_stability import SlowestRate, slowest_rate
from workbench.design.judge.step_pair import PAPER_STEPS, StepPair, step_pair
from workbench.design.linear.model import LinearModel
from workbench.design.linear.operating_point import HOLDING_POINT, HOVER_POINT, OperatingPoint
from workbench.design.linear.study import LinearStudy
from workbench.design.step_response import step_flier
from workbench.scenario.scenario import Scenario
from workbench.setup import Setup, make_setup


@dataclass(frozen=True)
class Judgement:
    """The judgement of the closed loop at one operating point.

    Attributes:
        vehicle: its name.
        point: the operating point.
        period: of the control law [s].
        loops: in the order of `LOOPS`; those that hold a position at hover only.
        modes: while the pilot steers, the slowest first.
        modes_holding: modes while the position is held; empty away from hover.
        steps: linear and flown; empty away from hover.
        slowest: slowest rates of the law.
        unstable: names of the loops that cause a growing mode.
        steering: the closed loop while the pilot steers.
        holding: the same while the position is held; None away from hover.
        plant_input: margin of force and moments all at once, while the pilot steers. Unlike the
            loops of a law, which may be nested, this point is the same for every law.
        plant_input_holding: the same while the position is held; None away from hover.
        phase: phase budget of each loop; empty for an unstable closed loop.
        noise: effect of the described noise of each sensor, in hover while the position is held;
            empty away from hover, without an IMU, and for an unstable closed loop.
    """

    vehicle: str
    point: OperatingPoint
    period: float
    loops: tuple[LoopJudgement, ...]
    modes: tuple[Mode, ...]
    modes_holding: tuple[Mode, ...]
    steps: tuple[StepPair, ...]
    slowest: SlowestRate
    unstable: tuple[str, ...]
    steering: LinearModel
    holding: LinearModel | None
    plant_input: MultiloopMargin
    plant_input_holding: MultiloopMargin | None
    phase: tuple[PhaseBudget, ...] = ()
    noise: tuple[NoiseEffect, ...] = ()


def judge(
    scenario: Scenario | Setup | None = None,
    *,
    point: OperatingPoint = HOVER_POINT,
    settings: Mapping[str, float] | None = None,
    progress: Callable[[float], None] | None = None,
    modelled: Callable[[LinearModel, LinearModel | None], None] | None = None,
) -> Judgement:
    """Judge the closed loop: margins, modes, steps, and the slowest safe rate.

    Args:
        scenario: its vehicle and rates are used.
        point: where to linearise; steps and position loops are judged at hover only.
        settings: parameter values.
        progress: called with the share done, 0 .. 1.
        modelled: called with `Judgement.steering` and `Judgement.holding` as soon as they are
            known; the rest takes ten times as long.

    Raises:
        WorkbenchError: if the vehicle cannot be read, or cannot fly at the point.
    """
    setup = make_setup(scenario, settings)
    study, gains = LinearStudy(setup), setup.values
    steers = dataclasses.replace(point, hold=False)
    steering = study.sampled(steers, gains)
    at_hover = steers == HOVER_POINT
    holding = study.sampled(HOLDING_POINT, gains) if at_hover else None
    if modelled:
        modelled(steering, holding)
    say = progress or (lambda share: None)
    steps = []
    if at_hover:
        flier = step_flier(setup, flights=len(PAPER_STEPS))
        for index, (axis, amplitude) in enumerate(PAPER_STEPS):

            def show_step(share: float, index: int = index) -> None:
                say((index + share) / (len(PAPER_STEPS) + 1))

            show_step(0.0)
            pair = step_pair(
                steering, axis, amplitude, scenario=setup, flier=flier, progress=show_step
            )
            steps.append(pair)
    loops = judge_loops(steering, holding)
    unstable = growing_loops(steering) or (growing_loops(holding) if holding else ())
    slowest = slowest_rate(point=point, study=study)
    joints = [name for name, _ in study.vehicle.small_joint_signals]
    say(1.0)
    return Judgement(
        vehicle=study.vehicle.name,
        point=point,
        period=steering.period,
        loops=loops,
        modes=modes(steering, joints),
        modes_holding=modes(holding, joints) if holding else (),
        steps=tuple(steps),
        slowest=slowest,
        unstable=unstable,
        steering=steering,
        holding=holding,
        plant_input=multiloop_margin(study.plant_input(steers, gains)),
        plant_input_holding=(
            multiloop_margin(study.plant_input(HOLDING_POINT, gains)) if at_hover else None
        ),
        phase=() if unstable else phase_budgets(study, steering, holding, loops, gains),
        noise=noise_effects(study, HOLDING_POINT, gains)
        if holding and study.vehicle.body_imus and not unstable
        else (),
    )
