"""What is to be seen of the gains that are being tuned."""

from collections.abc import Iterable, Mapping
from enum import Enum

from PyQt6.QtCore import QObject, pyqtSignal

from workbench.gains.difference import GainChange
from workbench.gui.gains.gain_book import GainBook, Values
from workbench.gui.gains.gain_judge import GainJudge
from workbench.gui.gains.gain_slots import GainSlots
from workbench.gui.gains.undo_stack import UndoStack
from workbench.gui.preferences import Preferences
from workbench.scenario.parameters import Parameter

AT_ONCE = "at once"


class Mark(Enum):
    """How a parameter stands, in words."""

    KEPT = "kept"
    TRIED = "tried, not kept"
    PROPOSED = "proposed, not flown"


class GainState(QObject):
    """The state of tuning, and what tells that it has changed; `GainDesk` changes it.

    Args:
        book: what is proposed, flown and kept.
        judge: what is known to be stable.
        preferences: whether what is proposed flies at once, or on Enter.
        parent: whose life it shares.

    Attributes:
        linked: whether gains of x and y move together.
        doubt: why what is proposed is not flown without a confirmation, "" where it is.
    """

    proposed_changed = pyqtSignal(str)
    """Name of a parameter that is proposed with another value now."""
    flown_changed = pyqtSignal(object)
    """Mapping of what the flight has otherwise now."""
    doubt_raised = pyqtSignal(str)
    """Why what is proposed is not flown without `confirm`, a sentence."""
    doubt_cleared = pyqtSignal()
    """There is nothing to confirm any more."""
    complained = pyqtSignal(str, str)
    """Name of a parameter, and why it may not have the value that was asked for; "" when it may."""
    ranges_changed = pyqtSignal()
    """Stable ranges are others, or older, now."""
    state_changed = pyqtSignal()
    """Anything else: kept, slots, undo, links, profile, or the rows themselves."""

    def __init__(
        self,
        book: GainBook,
        judge: GainJudge,
        preferences: Preferences,
        parent: QObject | None = None,
    ) -> None:
        super().__init__(parent)
        self._book, self._judge, self._preferences = book, judge, preferences
        self._undo = UndoStack()
        self._slots = GainSlots()
        self.linked = False
        self.doubt = ""
        self._complaints: set[str] = set()
        judge.ranges_changed.connect(self.ranges_changed)
        preferences.changed.connect(self._tell)

    @property
    def rows(self) -> tuple[Parameter, ...]:
        """Rows of the parameter table that the flight has."""
        return self._book.rows

    @property
    def profile_names(self) -> tuple[str, ...]:
        """Names of those rows that are kept, reverted, stored and saved."""
        return self._book.profile_names

    @property
    def proposed(self) -> Values:
        """Values that the sliders show, of every row."""
        return self._book.proposed

    @property
    def flown(self) -> Values:
        """Values that the flight has, of every row."""
        return self._book.flown.values

    @property
    def start(self) -> Values:
        """Values of the flight's start."""
        return self._book.flown.start

    @property
    def kept(self) -> Values:
        """Values of the profile that `revert` brings back."""
        return self._book.kept

    @property
    def slots(self) -> Mapping[str, Values]:
        """What was stored, by the slot's letter."""
        return self._slots.stored

    @property
    def is_at_once(self) -> bool:
        """Whether what is proposed flies at once, and not on Enter."""
        return self._preferences.text("apply_gains") == AT_ONCE

    @property
    def unflown(self) -> tuple[str, ...]:
        """Names that are proposed with other values than are ordered or flown."""
        return self._book.unflown

    @property
    def tried(self) -> tuple[str, ...]:
        """Names of the profile that are flown with other values than were kept."""
        return self._book.tried

    def mark(self, name: str) -> Mark:
        """Return how a parameter stands: proposed, flown or kept."""
        wanted = self._book.wanted(name)
        if self.proposed[name] != wanted:
            return Mark.PROPOSED
        return Mark.TRIED if self.kept.get(name, wanted) != wanted else Mark.KEPT

    @property
    def next_undo(self) -> str:
        """What `undo` would take back, in words; "" for nothing."""
        return self._undo.next_undo

    @property
    def next_redo(self) -> str:
        """What `redo` would make again, in words; "" for nothing."""
        return self._undo.next_redo

    @property
    def ranges_fresh(self) -> bool:
        """Whether the stable ranges were found with the gains that fly."""
        return self._judge.is_fresh(self.flown)

    def stable_range(self, name: str) -> tuple[float, float] | None:
        """Return the stable values of a gain, the others as they were; None if none is known."""
        return self._judge.ranges.stable.get(name) if self._judge.ranges else None

    @property
    def _is_undecided(self) -> bool:
        """Whether something is entered that is judged still, or doubted."""
        return bool(self.doubt) or self._judge.is_asking

    def difference(self) -> tuple[GainChange, ...]:
        """Return what is proposed otherwise than it was kept, from the kept values on."""
        return self._book.difference()

    def _tell(self, name: str) -> None:
        self.state_changed.emit()

    def said(self) -> str:
        """Return in words what is proposed, tried and kept."""
        if not self.rows:
            return "Nothing flies"
        proposed, tried = len(self.unflown), len(self.tried)
        said = []
        if proposed:
            said.append(f"{_count(proposed)} proposed, not flown")
        if tried:
            said.append(f"{_count(tried)} tried, not kept")
        return "; ".join(said) or "Flown = kept"

    def _put(self, values: Values, what: str, flown: bool = False) -> list[str]:
        """Propose values as a step of undo; return the names of those that are others now."""
        before = {name: self._book.proposed[name] for name in values}
        self._undo.push(what, before, values, flown)
        return self._set(values)

    def _set(self, values: Values) -> list[str]:
        """Propose values, and tell nobody but who had complained; return what has changed."""
        changed = [name for name, value in values.items() if self.proposed[name] != value]
        self._book.proposed.update(values)
        self._forgive(values)
        return changed

    def _tell_proposed(self, names: Iterable[str]) -> None:
        for name in names:
            self.proposed_changed.emit(name)
        self.state_changed.emit()

    def _complain(self, name: str, said: str) -> None:
        self._complaints.add(name)
        self.complained.emit(name, said)

    def _forgive(self, names: Iterable[str]) -> None:
        for name in self._complaints.intersection(names):
            self._complaints.discard(name)
            self.complained.emit(name, "")

    def _raise_doubt(self, said: str) -> None:
        self.doubt = said
        self.doubt_raised.emit(said)
        self.state_changed.emit()

    def _clear_doubt(self) -> None:
        self._judge.drop()
        if self.doubt:
            self.doubt = ""
            self.doubt_cleared.emit()


def _count(number: int) -> str:
    return "1 gain" if number == 1 else f"{number} gains"
