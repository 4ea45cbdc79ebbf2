"""What every loop of the cascade bears, at its actuator and at its error."""

from dataclasses import dataclass

from workbench.control.controller import Loop
from workbench.design.judge.loop_response import growth_rate, growth_rates, loop_responses
from workbench.design.judge.margins import LoopMargins, all_margins
from workbench.design.linear.model import LinearModel

UNSTATED = "the law, which states no loops"


@dataclass(frozen=True)
class LoopJudgement:
    """What one loop bears.

    Attributes:
        loop: its name.
        actuator: margins where it is cut at what it asks of the loop inside it: all that goes
            through that place is in the loop, the loops outside included.
        error: where it is cut at its error.
    """

    loop: str
    actuator: LoopMargins
    error: LoopMargins


def judge_loops(
    steering: LinearModel, holding: LinearModel | None = None
) -> tuple[LoopJudgement, ...]:
    """Return the margins of all loops; a screen may ask for them while a slider moves.

    Args:
        steering: the closed loop while the pilot steers.
        holding: the same while a place is held, for the loops that hold it.
    """
    found = _judged(steering, [loop for loop in steering.loops if not loop.hold])
    return found + (
        _judged(holding, [loop for loop in steering.loops if loop.hold]) if holding else ()
    )


def _judged(model: LinearModel, loops: list[Loop]) -> tuple[LoopJudgement, ...]:
    """Return the judgement of some loops of one model."""
    points = list(dict.fromkeys(p for loop in loops for p in (loop.point("actuator"), loop.error)))
    margins = dict(zip(points, all_margins(model, points), strict=True))
    return tuple(
        LoopJudgement(loop.name, margins[loop.point("actuator")], margins[loop.error])
        for loop in loops
    )


def growing_loops(model: LinearModel) -> tuple[str, ...]:
    """Return the loops through which a mode grows: opening one halves its growth or ends it.

    With a velocity loop too fast for the tilt inside it, both are named; with a tilt that is
    unstable by itself, it alone.
    """
    loops = [loop for loop in model.loops if loop.hold == model.trim.point.hold]
    responses = loop_responses(model, [loop.error for loop in loops])
    if responses.stable:
        return ()
    fastest = growth_rate(responses.closed, responses.period)
    closed, *opened = (
        int((growth_rates(poles, responses.period) > 0.5 * fastest).sum())
        for poles in (responses.closed, *responses.opened)
    )
    found = tuple(loop.name for loop, left in zip(loops, opened, strict=True) if left < closed)
    return found or tuple(loop.name for loop in loops) or (UNSTATED,)
