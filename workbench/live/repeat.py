"""The scenario that flies a live flight again."""

import dataclasses
import math
from collections.abc import Mapping, Sequence

from workbench.scenario import Action, Scenario


def repeated(
    scenario: Scenario, settings: Mapping[str, float], done: Sequence[Action], duration: float
) -> Scenario:
    """Return the scenario of a flight with what the pilot did live in its script.

    At one step a pilot comes before the script, as a script acts when the step is flown. So
    actions of the script move to the step at which they act, and stand after the pilot's.

    Args:
        scenario: that was flown.
        settings: parameter values that the flight was built with.
        done: what the pilot did, at times of whole steps, in order.
        duration: flown [s].
    """
    step = scenario.rates.physics_step
    scripted = [
        dataclasses.replace(action, at=math.ceil(action.at / step - 1e-6) * step)
        for action in scenario.script
    ]
    first = [Action(0.0, set=dict(settings))] if settings else []
    script = sorted([*first, *done, *scripted], key=lambda action: action.at)
    return dataclasses.replace(
        scenario,
        duration=duration or scenario.duration,
        script=[action for action in script if action.at <= (duration or scenario.duration)],
    )
