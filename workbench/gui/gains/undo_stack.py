"""What was changed, to be taken back and made again."""

from collections.abc import Mapping
from dataclasses import dataclass, replace

MOST_CHANGES = 500
"""Then the oldest can no longer be taken back."""


@dataclass(frozen=True)
class Change:
    """One step of undo.

    Attributes:
        what: in words, as "Speed x".
        before: values by name.
        after: values of the same names.
        flown: whether it has reached the flight.
    """

    what: str
    before: Mapping[str, float]
    after: Mapping[str, float]
    flown: bool = False


class UndoStack:
    """Changes in their order; a change that goes on is one step until it is settled."""

    def __init__(self) -> None:
        self._done: list[Change] = []
        self._undone: list[Change] = []
        self._open = False

    @property
    def next_undo(self) -> str:
        """What an undo would take back, in words; "" for nothing."""
        return self._done[-1].what if self._done else ""

    @property
    def next_redo(self) -> str:
        """What a redo would make again, in words; "" for nothing."""
        return self._undone[-1].what if self._undone else ""

    def grasp(self) -> None:
        """Let what follows be one step, until `settle`."""
        self.settle()
        self._open = True

    def settle(self) -> None:
        """End a step; if it has come back to where it began, there was none."""
        self._open = False
        if self._done and self._done[-1].before == self._done[-1].after:
            self._done.pop()

    def push(
        self,
        what: str,
        before: Mapping[str, float],
        after: Mapping[str, float],
        flown: bool = False,
    ) -> None:
        """Take note of a change, as a step of its own or as part of the one that goes on."""
        if dict(before) == dict(after):
            return
        self._undone.clear()
        last = self._done[-1] if self._done else None
        if self._open and last and last.what == what and set(last.before) == set(before):
            self._done[-1] = replace(last, after=dict(after), flown=flown)
            return
        self._done.append(Change(what, dict(before), dict(after), flown))
        del self._done[:-MOST_CHANGES]

    def fly(self) -> None:
        """Take note that all that was done has reached the flight."""
        index = len(self._done) - 1
        while index >= 0 and not self._done[index].flown:
            self._done[index] = replace(self._done[index], flown=True)
            index -= 1

    def undo(self) -> Change | None:
        """Return the change that is taken back, None where there is none."""
        self.settle()
        if not self._done:
            return None
        self._undone.append(self._done.pop())
        return self._undone[-1]

    def redo(self) -> Change | None:
        """Return the change that is made again, None where there is none."""
        if not self._undone:
            return None
        self._done.append(self._undone.pop())
        return self._done[-1]

    def clear(self) -> None:
        """Forget all."""
        self._done.clear()
        self._undone.clear()
        self._open = False
