"""Margins of all loops, quick enough for a screen that shows them while a slider moves."""

from collections.abc import Mapping
from dataclasses import dataclass

from workbench.design.judge.margins import LoopMargins, all_margins
from workbench.design.linear.operating_point import OperatingPoint
from workbench.design.linear.study import LinearStudy

HOLDING = OperatingPoint(hold=True)


@dataclass(frozen=True)
class LiveMargins:
    """The margins of one loop at hover, cut at its actuator."""

    loop: str
    margins: LoopMargins


def live_margins(
    study: LinearStudy, gains: Mapping[str, float] | None = None
) -> tuple[LiveMargins, ...]:
    """Return the margins of every loop at hover.

    It linearises once, with the place held, and opens the position loops: then the pilot steers.

    Args:
        study: of the vehicle, made once.
        gains: parameter values by name that differ from the scenario's.
    """
    loops = study.controller.loops
    holding = study.sampled(HOLDING, gains)
    steering = holding.opened([loop.error for loop in loops if loop.hold])
    points = {loop.name: loop.point("actuator") for loop in loops}
    found: dict[str, LoopMargins] = {}
    for model, held in ((steering, False), (holding, True)):
        names = [loop.name for loop in loops if loop.hold is held]
        margins = all_margins(model, [points[name] for name in names])
        found |= dict(zip(names, margins, strict=True))
    return tuple(LiveMargins(name, margins) for name, margins in found.items())
