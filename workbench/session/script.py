"""The script of a scenario, step by step, and its path."""

import dataclasses
import math
from collections.abc import Iterable, Iterator, Mapping, Sequence

from pydrake.trajectories import PiecewisePolynomial

from workbench.scenario.scenario import Action, Scenario
from workbench.systems.reference import figure_eight, path_acceleration


class Script:
    """Returns actions at the first physics step at or after their time."""

    def __init__(self, actions: Iterable[Action], physics_step: float) -> None:
        self._actions = sorted(actions, key=lambda action: action.at)
        self._physics_step = physics_step
        self._done = 0

    @property
    def next_step(self) -> int | float:
        """The step of the next action, infinite where there is none."""
        if self._done == len(self._actions):
            return math.inf
        return math.ceil(self._actions[self._done].at / self._physics_step - 1e-6)

    def due(self, step: int) -> Iterator[Action]:
        """Yield what is to be done at a step or was before it; each action once."""
        while self.next_step <= step:
            self._done += 1
            yield self._actions[self._done - 1]

    @property
    def done(self) -> int:
        """Number of actions returned so far."""
        return self._done

    @property
    def actions_done(self) -> list[Action]:
        """The actions returned so far."""
        return self._actions[: self._done]

    def rewind(self, done: int = 0) -> None:
        """Begin again, at the start or after this number of actions."""
        self._done = done


def scenario_path(scenario: Scenario) -> PiecewisePolynomial | None:
    """Return the path that a scenario flies beside its script, None where it has none."""
    eight = scenario.figure_eight
    if eight is None:
        return None
    return figure_eight(eight.center, eight.length, eight.width, eight.period, eight.laps)


def scenario_feedforward(scenario: Scenario) -> PiecewisePolynomial | None:
    """Return the acceleration along a scenario's path, None where the law is not to hear of it."""
    path = scenario_path(scenario)
    fed = scenario.figure_eight is not None and scenario.figure_eight.feedforward
    return path_acceleration(path) if path is not None and fed else None


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
