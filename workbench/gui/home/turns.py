"""Whose numbers are due: each card's ten times a second, spread over the frames."""

from collections.abc import Iterable

PERIOD = 0.1
"""Between two looks at the same number: digits that change faster cannot be read [s]."""
MOST = 3
"""So many in one frame, of those that wait longest..."""
LATEST = 0.2
"""...and all that have waited for longer than this [s]."""


class Turns:
    """Tells which of some names are due.

    Args:
        names: that take turns.
    """

    def __init__(self, names: Iterable[str]) -> None:
        self._names = tuple(names)
        self._due: dict[str, float] = {}

    def reset(self) -> None:
        """Let all be due at once."""
        self._due.clear()

    def due(self, time: float) -> list[str]:
        """Return the names that are due at a time [s], which then wait for their next turn."""
        if not self._due:  # and from here on they come one after the other
            share = PERIOD / len(self._names)
            self._due = {n: time + PERIOD + k * share for k, n in enumerate(self._names)}
            return list(self._names)
        waiting = [name for name in self._names if self._due[name] <= time + 1e-9]
        waiting.sort(key=lambda name: self._due[name])
        late = [name for name in waiting if self._due[name] < time - LATEST]
        taken = waiting[: max(MOST, len(late))]
        for name in taken:
            self._due[name] = max(self._due[name] + PERIOD, time + PERIOD / 2)
        return taken
