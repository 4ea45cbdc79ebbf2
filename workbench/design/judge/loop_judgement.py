"""The margins of every loop, cut at its actuator and at its error."""

from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

from workbench.control.loop import Loop
from workbench.design.judge.loop_response import (
    growing_poles,
    growth_rate,
    growth_rates,
    loop_responses,
)
from workbench.design.judge.margins import LoopMargins, all_margins
from workbench.design.linear.model import LinearModel
from workbench.design.linear.operating_point import HOLDING_POINT, HOVER_POINT

if TYPE_CHECKING:
    from workbench.design.linear.study import LinearStudy

UNSTATED_LOOPS_TEXT = "the law, which states no loops"


@dataclass(frozen=True)
class LoopJudgement:
    """The margins of one loop.

    Attributes:
        loop: its name.
        actuator: margins with the cut at its output to the inner loop. All signals through that
            point are part of the loop, including those of outer loops.
        error: margins with the cut at its error.
    """

    loop: str
    actuator: LoopMargins
    error: LoopMargins


def judge_loops(
    steering: LinearModel, holding: LinearModel | None = None
) -> tuple[LoopJudgement, ...]:
    """Return the margins of all loops, fast enough for updates while a slider moves.

    Args:
        steering: the closed loop while the pilot steers.
        holding: the same while a position is held, for the loops that hold it.
    """
    found = _judge_model_loops(steering, [loop for loop in steering.loops if not loop.hold])
    return found + (
        _judge_model_loops(holding, [loop for loop in steering.loops if loop.hold])
        if holding
        else ()
    )


def _judge_model_loops(model: LinearModel, loops: list[Loop]) -> tuple[LoopJudgement, ...]:
    """Return the judgement of some loops of one model."""
    points = list(dict.fromkeys(p for loop in loops for p in (loop.point("actuator"), loop.error)))
    margins = dict(zip(points, all_margins(model, points), strict=True))
    return tuple(
        LoopJudgement(loop.name, margins[loop.point("actuator")], margins[loop.error])
        for loop in loops
    )


def growing_loops(model: LinearModel) -> tuple[str, ...]:
    """Return the loops that cause a growing mode: opening one halves its growth or ends it.

    If a velocity loop is too fast for its inner tilt loop, both are returned; if the tilt loop is
    unstable by itself, only that one.
    """
    loops = [loop for loop in model.loops if loop.hold == model.trim.point.hold]
    responses = loop_responses(model, [loop.error for loop in loops])
    if responses.stable:
        return ()
    fastest = growth_rate(responses.closed, responses.period)
    closed, *opened = (
        int(
            (
                growing_poles(poles, responses.period)
                & (growth_rates(poles, responses.period) > 0.5 * fastest)
            ).sum()
        )
        for poles in (responses.closed, *responses.opened)
    )
    found = tuple(loop.name for loop, left in zip(loops, opened, strict=True) if left < closed)
    return found or tuple(loop.name for loop in loops) or (UNSTATED_LOOPS_TEXT,)


def opened_to_steer(holding: LinearModel) -> LinearModel:
    """Return a closed loop with its position loops opened, as while a pilot steers."""
    steering = holding.opened([loop.error for loop in holding.loops if loop.hold])
    return replace(steering, trim=replace(steering.trim, point=HOVER_POINT))


@dataclass(frozen=True)
class LiveMargins:
    """The margins of one loop at hover, cut at its actuator."""

    loop: str
    margins: LoopMargins


def live_margins(
    study: "LinearStudy", gains: Mapping[str, float] | None = None
) -> tuple[LiveMargins, ...]:
    """Return the margins of every loop at hover.

    Args:
        study: of the vehicle; reuse it.
        gains: parameter values by name that differ from the scenario's.
    """
    found = hover_margins(study.sampled(HOLDING_POINT, gains))
    return tuple(LiveMargins(loop, margins) for loop, margins in found.items())


def hover_margins(holding: LinearModel) -> dict[str, LoopMargins]:
    """Return the margins of every loop at hover by its name, cut at its actuator.

    Args:
        holding: the closed loop while a position is held; the other loops are judged with its
            position loops opened.
    """
    found: dict[str, LoopMargins] = {}
    for model, held in ((opened_to_steer(holding), False), (holding, True)):
        loops = [loop for loop in model.loops if loop.hold is held]
        margins = all_margins(model, [loop.point("actuator") for loop in loops])
        found |= {loop.name: each for loop, each in zip(loops, margins, strict=True)}
    return found
