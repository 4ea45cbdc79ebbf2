"""How far a round picture or a map reaches: in steps, and without going back and forth."""

import math

SLACK = 0.7
"""The content has to fit into this share of a smaller step before that is taken."""
PATIENCE = 2.0
"""For so long [s]."""


def round_reach(reach: float) -> float:
    """Return the least of 1, 2, 5 times a power of ten that is not below a reach."""
    power = 10.0 ** math.floor(math.log10(reach))
    return next(step * power for step in (1.0, 2.0, 5.0, 10.0) if step * power >= reach * 0.999999)


class SteadyScale:
    """Widens at once when the content asks for it, and narrows only after a while.

    Args:
        least: it never reaches less far than this [m].
        most: nor farther.
    """

    def __init__(self, least: float, most: float = math.inf) -> None:
        self._least = least
        self._most = most
        self.reset()

    def reset(self) -> None:
        """Forget the content."""
        self.reach = self._least
        self._since = math.inf

    def take(self, wanted: float, time: float) -> float:
        """Return how far to reach.

        Args:
            wanted: by the content [m].
            time: now, in any seconds that run on.
        """
        wanted = min(self._most, max(self._least, wanted)) if wanted > 0.0 else self._least
        step = min(self._most, round_reach(wanted))
        if step > self.reach:
            self.reach, self._since = step, math.inf
        elif round_reach(wanted / SLACK) < self.reach:
            self._since = min(self._since, time)
            if time - self._since >= PATIENCE:
                self.reach, self._since = max(self._least, round_reach(wanted / SLACK)), math.inf
        else:
            self._since = math.inf
        return self.reach
