"""Refusals of a server, gathered: the server tells the last ones only."""

from collections import deque
from collections.abc import Mapping, Sequence

LONGEST = 300
"""Lines that are kept."""


class RefusalLog:
    """The last refusals in words, with the time at which they were heard of.

    Attributes:
        lines: oldest first.
    """

    def __init__(self) -> None:
        self.lines: deque[str] = deque(maxlen=LONGEST)
        self._total = 0

    def begin(self) -> None:
        """Take what a new server tells as new."""
        self._total = 0

    def hear(self, told: Sequence[str], counts: Mapping[str, int], clock: str) -> list[str]:
        """Take what a server tells, and return the lines that are new.

        Args:
            told: its last refusals, newest last.
            counts: how often something was refused since its start, by code.
            clock: the time of the day, as text.
        """
        total = sum(counts.values())
        fresh = total - self._total
        self._total = total
        if fresh <= 0:
            return []
        new = [f"{clock}  {said}" for said in told[-fresh:]]
        if fresh > len(told):
            new.insert(0, f"{clock}  … {fresh - len(told)} more, too many to be told")
        self.lines.extend(new)
        return new


def say_counts(counts: Mapping[str, int]) -> str:
    """Return how often something was refused, as a sentence."""
    if not counts:
        return "Nothing was refused."
    often = sorted(counts.items(), key=lambda pair: -pair[1])
    said = ", ".join(f"{code.replace('_', ' ')} {count}×" for code, count in often)
    return f"Refused since the server's start: {said}."
