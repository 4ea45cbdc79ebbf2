"""What was done in a live flight since its start, in little memory: a pilot may steer for hours."""

import math
from array import array
from collections.abc import Iterator

from workbench.scenario.scenario import Action

WIDTH = 5
"""Numbers of a command: time, velocity, yaw rate."""


class History:
    """Actions in their order, and who wanted them.

    A command, of which there may be a hundred a second, is kept as five numbers; anything else as
    it is.
    """

    def __init__(self) -> None:
        self._numbers = array("d")
        self._others: dict[int, Action] = {}
        self._who = array("I")
        self._names: list[str] = []

    def __len__(self) -> int:
        return len(self._who)

    def __iter__(self) -> Iterator[tuple[Action, str]]:
        for index, who in enumerate(self._who):
            yield self._action(index), self._names[who]

    @property
    def actions(self) -> list[Action]:
        """The actions alone."""
        return [action for action, _ in self]

    def append(self, action: Action, by: str) -> None:
        """Keep an action that came into force at its time."""
        if by not in self._names:
            self._names.append(by)
        if _is_command(action):
            assert action.velocity is not None and action.yaw_rate is not None
            self._numbers.extend((action.at, *action.velocity, action.yaw_rate))
        else:
            self._others[len(self._who)] = action
            self._numbers.extend([math.nan] * WIDTH)
        self._who.append(self._names.index(by))

    def clear(self) -> None:
        """Forget all."""
        del self._numbers[:]
        del self._who[:]
        self._others.clear()
        self._names.clear()

    def _action(self, index: int) -> Action:
        if index in self._others:
            return self._others[index]
        at, x, y, z, yaw_rate = self._numbers[WIDTH * index : WIDTH * (index + 1)]
        return Action(at, velocity=[x, y, z], yaw_rate=yaw_rate)


def _is_command(action: Action) -> bool:
    """Return whether a velocity and a yaw rate are all that an action has."""
    if action.velocity is None or action.yaw_rate is None:
        return False
    return action == Action(action.at, velocity=action.velocity, yaw_rate=action.yaw_rate)
