"""The script of a scenario, step by step."""

import dataclasses
import logging
import math
from collections.abc import Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager

import numpy as np

from workbench.common.errors import FlightBrokenError, WorkbenchError
from workbench.common.plain_text import plain_name
from workbench.control.mode import FlightMode, ModeRequest
from workbench.dynamics.air.settings import gust_settings, push_settings
from workbench.scenario.scenario import Action, Rates, Scenario


def acting_step(at: float, rates: Rates) -> int:
    """Return the physics step of the first control update at or after a time [s]."""
    return rates.control_steps * math.ceil(at / rates.control_period - 1e-6)


def disturbance_settings(action: Action, start: float) -> dict[str, float]:
    """Return the parameters that an action's gust and push set if they begin at a time [s]."""
    settings: dict[str, float] = {}
    if (gust := action.gust) is not None:
        settings |= gust_settings(gust.velocity, start, gust.duration)
    if (push := action.push) is not None:
        settings |= push_settings(push.force, push.point, start, push.duration, push.torque)
    return settings


class Script:
    """Returns each action at the first control update at or after its time.

    Attributes:
        done: number of returned actions.
        ended: whether it returns no more until it starts again.
    """

    def __init__(self, actions: Iterable[Action], rates: Rates) -> None:
        ordered = sorted(enumerate(actions), key=lambda each: each[1].at)
        self._places = [place for place, _ in ordered]
        self._actions = [action for _, action in ordered]
        self._rates = rates
        self.done, self.ended = 0, False
        self._noted = False

    @property
    def next_step(self) -> int | float:
        """The step of the next action, infinite without one."""
        action = self.next_action
        return math.inf if action is None else acting_step(action.at, self._rates)

    @property
    def next_action(self) -> Action | None:
        """The next action, None without one."""
        left = self.done < len(self._actions) and not self.ended
        return self._actions[self.done] if left else None

    def due(self, step: int) -> Iterator[Action]:
        """Yield the actions that are due at a step, each once."""
        while self.next_step <= step:
            self.done += 1
            yield self._actions[self.done - 1]

    @contextmanager
    def refusals(self, title: str) -> Iterator[None]:
        """Have a refusal of the last returned action say which one of a scenario's script it is."""
        try:
            yield
        except FlightBrokenError:
            raise
        except WorkbenchError as error:
            raise WorkbenchError(
                f"{self._place(title)}: {error}; change that action or remove it, as a reset flies "
                "the same script"
            ) from error

    def note_mode(self, title: str, mode: FlightMode, waiting: ModeRequest) -> None:
        """Log, once a flight, that the last returned action has no effect because the drone is off.

        Args:
            title: of the scenario.
            mode: the flight mode.
            waiting: what is requested of it, see `ObservedFlight.waiting_request`.
        """
        if self._noted or mode is not FlightMode.OFF or waiting is ModeRequest.TAKE_OFF:
            return
        action = self._actions[self.done - 1]
        moves = [
            name
            for name in ("velocity", "yaw_rate", "go_to")
            if np.any(getattr(action, name) or 0.0)
        ]
        if moves or action.request == "land":
            self._noted = True
            said = " and ".join(moves or ["land"])
            later = " before a take_off" if moves else ""
            logging.getLogger("workbench").warning(
                "%s: the drone is off and does not follow %s%s", self._place(title), said, later
            )

    def _place(self, title: str) -> str:
        """Return where the last returned action stands in the script of a scenario."""
        action, place = self._actions[self.done - 1], self._places[self.done - 1]
        scenario = f"the scenario '{plain_name(title)}'" if title else "the scenario"
        return f"script.{place} of {scenario}, at {action.at:g} s"

    @property
    def first_values(self) -> dict[str, float]:
        """Values that the first actions set at time 0, before another controller takes over."""
        found: dict[str, float] = {}
        for action in self._actions:
            if action.controller is not None or acting_step(action.at, self._rates) > 0:
                break
            found |= action.set
        return found

    @property
    def actions_done(self) -> list[Action]:
        """The returned actions."""
        return self._actions[: self.done]

    def rewind(self, done: int = 0, *, ended: bool = False) -> None:
        """Start again, at the beginning or after this number of actions, or stay ended."""
        self.done, self.ended = done, ended
        self._noted = False

    def end(self) -> None:
        """Return no more actions until the script starts again."""
        self.ended = True


def repeat_scenario(
    scenario: Scenario, settings: Mapping[str, float], done: Sequence[Action], duration: float
) -> Scenario:
    """Return the scenario of a flight, with the pilot's live actions in its script.

    It has no action of the script after one that ended the script.

    At one control update the pilot's actions precede the script's, because a script acts when the
    flight goes on. So actions of the script move to the update at which they act, and stand after
    the pilot's.

    Args:
        scenario: the flown scenario.
        settings: parameter values that the flight was built with.
        done: the pilot's actions, at times of control updates, in order.
        duration: flown time [s].
    """
    rates = scenario.rates
    scripted = [
        dataclasses.replace(action, at=acting_step(action.at, rates) * rates.physics_step)
        for action in scenario.script
    ]
    # in a log an action that ended the script says so: in earlier versions not every hold did
    ended = min((action.at for action in done if action.end_script), default=math.inf)
    scripted = [action for action in scripted if action.at < ended]
    live = [dataclasses.replace(action, end_script=None) for action in done]
    # a flight begins with what its script sets at 0, although that was ended then
    values = Script(scenario.script, rates).first_values if ended <= 0.0 else {}
    first = [Action(0.0, set=dict(each)) for each in (settings, values) if each]
    script = sorted([*first, *live, *scripted], key=lambda action: action.at)
    return dataclasses.replace(
        scenario,
        duration=duration or scenario.duration,
        script=[action for action in script if action.at <= (duration or scenario.duration)],
    )
