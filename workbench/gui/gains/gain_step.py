"""A change of proposed gains, as one step of undo."""

from collections.abc import Callable

from PyQt6.QtGui import QUndoCommand

from workbench.gui.gains.flown_gains import GainValues


class GainStep(QUndoCommand):
    """A change of proposed values, as one step of undo; it is already made when it is pushed.

    Args:
        restore: proposes values, flies them if told to, and returns whether they fly.
        what: the change in words, as "Speed x".
        before: values before, by name.
        after: values after, of the same names.
        flown: whether it has reached the flight.
        edit: changes of the same gains with the same number are one step, `SEPARATE_EDIT` for none.
    """

    def __init__(
        self,
        restore: Callable[[GainValues, bool], bool],
        what: str,
        before: GainValues,
        after: GainValues,
        flown: bool,
        edit: int,
    ) -> None:
        super().__init__(what)
        self._restore, self._edit = restore, edit
        self._before, self._after = dict(before), dict(after)
        self.flown = flown
        self._is_new = True

    def id(self) -> int:
        return self._edit

    def mergeWith(self, other: QUndoCommand | None) -> bool:
        """Merge a later change of the same edit; a step without an effect is removed."""
        if not isinstance(other, GainStep) or other.text() != self.text():
            return False
        if other._before.keys() != self._before.keys():
            return False
        self._after, self.flown = other._after, other.flown
        self.setObsolete(self._before == self._after)
        return True

    def undo(self) -> None:
        flown = self.flown
        self._restore(self._before, flown)
        self.flown = flown  # this step does not, whatever flies now

    def redo(self) -> None:
        if self._is_new:
            self._is_new = False
        else:
            self.flown = self._restore(self._after, self.flown) or self.flown
