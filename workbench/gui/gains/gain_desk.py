"""The gains that are being tuned: what is proposed, what flies, and what was kept."""

from collections.abc import Callable, Iterable
from pathlib import Path

from PyQt6.QtCore import QObject

from workbench.common.errors import WorkbenchError
from workbench.gains.profiles import GainFile
from workbench.gui.analysis import Analysis
from workbench.gui.flight_model import FlightModel
from workbench.gui.gains.gain_book import GainBook, Values
from workbench.gui.gains.gain_judge import GainJudge
from workbench.gui.gains.gain_orders import GainOrders
from workbench.gui.gains.gain_rows import gain_label, partner
from workbench.gui.gains.gain_state import GainState
from workbench.gui.gains.profile_desk import ProfileDesk
from workbench.gui.gains.profiles import write_text
from workbench.gui.gains.script_watch import ScriptWatch
from workbench.gui.gains.stability import judged_names, same_loops
from workbench.gui.notices import Notices
from workbench.gui.preferences import Preferences
from workbench.link.backplane import Published
from workbench.live.view import LiveView
from workbench.scenario.parameters import find_parameter

FOREIGN = "a change from elsewhere"


class GainDesk(GainState):
    """Tries gains on the flight, keeps them or brings the kept ones back.

    Sliders show `proposed`; the flight has `flown`; `kept` is what `revert` brings back, at first
    the values of the flight's start. Kept, reverted, stored and saved is what belongs to the
    vehicle, its profile: `profile_names`. The other rows, as wind, faults and modes, are
    conditions: they are set and undone here, and stay as they are when gains come back.

    What would make a loop unstable, or cannot be judged, is not flown until `confirm`; what was
    kept always is.

    Args:
        flight: gets the orders.
        analysis: judges what is proposed.
        preferences: whether what is proposed flies at once, or on Enter.
        notices: where refusals are told.
        parent: whose life it shares.

    Attributes:
        profiles: loads and saves.
    """

    def __init__(
        self,
        flight: FlightModel,
        analysis: Analysis,
        preferences: Preferences,
        notices: Notices,
        parent: QObject | None = None,
    ) -> None:
        self._orders = GainOrders(flight, self._confirmed, self._refused)
        book = GainBook(self._orders)
        judge = GainJudge(analysis, lambda: book.flown.start)
        super().__init__(book, judge, preferences, parent)
        judge.setParent(self)
        self._notices = notices
        self.profiles = ProfileDesk(lambda: self.flown, self.adopt, notices, self)
        self._vehicle: object = None
        self._refusal = ""
        self._script = ScriptWatch(flight, self._confirmed, self)
        flight.streamed.connect(self._hear)
        judge.passed.connect(self._fly_all)
        judge.doubted.connect(self._raise_doubt)
        self.profiles.named.connect(self._tell)

    def begin(self, view: LiveView) -> None:
        """Take note that a flight has begun, or begun anew."""
        if view.vehicle is self._vehicle:
            before = dict(self.flown)
            self._book.flown.reset()
            self._follow(before)
            return
        self._vehicle = view.vehicle
        self._book.begin(view)
        self._script.begin(view.scenario.script if view.scenario else ())
        self._orders.begin()
        self._undo.clear()
        self._slots.clear()
        self._judge.begin()
        self._complaints.clear()
        self._clear_doubt()
        self.profiles.begin(view, self._book.profile(self.start))
        self.state_changed.emit()

    def look(self) -> None:
        """Find the stable ranges of what flies; somebody looks at them."""
        self._judge.look_for_ranges(self.flown)

    def grasp(self) -> None:
        """Let what is proposed from now on be one step of undo: a slider is held."""
        self._undo.grasp()

    def settle(self) -> None:
        """End that step: the slider is let go."""
        self._undo.settle()
        self.state_changed.emit()

    def propose(self, name: str, value: float) -> None:
        """Try a value of a parameter, and of the one that is linked with it.

        It flies at once if the user prefers so and it is known to be stable; otherwise it is
        judged first.

        Args:
            name: of the parameter.
            value: in SI units; one that the table refuses changes nothing but a sentence.
        """
        try:
            value = self._book.check(name, value)
        except WorkbenchError as error:
            self._complain(name, str(error))
            return
        names = [name, partner(name)] if self.linked and partner(name) else [name]
        words = gain_label(find_parameter(name)).text
        changed = self._put({each: value for each in names}, words)
        if self.is_at_once:
            self.apply()  # first of all: to show it takes longer than to order it
        else:
            self._clear_doubt()  # what was entered is not what is proposed any more
        self._tell_proposed(changed)

    def adopt(self, values: Values, what: str) -> None:
        """Try many values in one step, in either mode: a profile, or what a search has found.

        Args:
            values: by name; the others stay.
            what: in words, for undo.

        Raises:
            WorkbenchError: if the table refuses one; then none is taken.
        """
        good = {name: find_parameter(name).check(value) for name, value in values.items()}
        self._undo.settle()
        known = {name: good[name] for name in good if name in self._book.proposed}
        changed = self._put(known, what)
        self.apply()
        self._tell_proposed(changed)

    def apply(self) -> None:
        """Fly what is proposed, once it is known to be stable."""
        self._refusal = ""
        gains = set(judged_names(self.proposed))
        self._fly(name for name in self.unflown if name not in gains)
        if same_loops(self.proposed, self._book.all_wanted):
            self._undo.fly()
            self._clear_doubt()
        elif self._judge.knows(self.proposed) or self._book.proposes_kept:
            self._fly_all()
        else:
            self._judge.ask(self.proposed)

    def confirm(self) -> None:
        """Fly what is proposed although it is doubted."""
        if self.doubt:
            self._fly_all()

    def back(self, names: Iterable[str] = ()) -> None:
        """Propose what is flown again: what is doubted, or not entered yet, is let go.

        Args:
            names: of some parameters; none for all.
        """
        chosen = tuple(names) or self.unflown
        self._undo.settle()
        values = {name: self._book.wanted(name) for name in chosen}
        changed = self._put(values, "back to what flies")
        if not self.unflown:
            self._clear_doubt()
        elif self._is_undecided:
            self.apply()
        self._tell_proposed(changed)

    def keep(self) -> None:
        """Let what flies be what `revert` brings back."""
        self._book.kept = self._wanted
        self._undo.settle()
        self.state_changed.emit()

    def revert(self) -> None:
        """Fly the kept set, whatever else is the matter: nothing is judged, nothing is waited for.

        Every value is ordered, also one that is flown as far as is known here.
        """
        self._refusal = ""
        before = {name: self.proposed[name] for name in self.kept}
        self._book.proposed.update(self.kept)
        self._orders.insist(dict(self.kept))
        self._undo.settle()
        self._undo.push("revert", before, self.kept, flown=True)
        self._clear_doubt()
        self._forgive(before)
        self._tell_proposed(name for name in before if before[name] != self.kept[name])

    def undo(self) -> None:
        """Take the last change back, in the flight too if it had got there."""
        if change := self._undo.undo():
            self._return_to(change.before, change.flown)

    def redo(self) -> None:
        """Make the change again that was taken back last."""
        if change := self._undo.redo():
            self._return_to(change.after, change.flown)

    def store(self, slot: str) -> None:
        """Let a slot have what is proposed."""
        self._slots.store(slot, self._book.profile(self.proposed))
        self.state_changed.emit()

    def recall(self, slot: str) -> None:
        """Fly what a slot has; where that is proposed already, go back to what was before.

        So one key compares the slot with the present.
        """
        if slot not in self.slots:
            self._notices.inform(f"Slot {slot} is empty: store the present gains in it first.")
        elif found := self._slots.recall(slot, self._book.profile(self.proposed)):
            self.adopt(*found)

    def set_linked(self, linked: bool) -> None:
        """Let x and y move together from now on, or no longer; that moves nothing yet."""
        self.linked = linked
        self.state_changed.emit()

    def load(self, path: Path) -> None:
        """Offer what a gain file has, see `profiles.offered`; nothing of it flies yet."""
        self.profiles.load(path)

    def save(self, path: Path, origin: str) -> None:
        """Write what flies to a gain file, with a sentence on where it comes from."""
        self.profiles.save(path, origin, self._wanted)

    def unsaved(self) -> str:
        """Return which gains would be lost with the flight, as a sentence; "" for none.

        What flies, or what was kept, is lost if it is neither as the flight began nor as the
        profile that was loaded or saved last.
        """
        flown, kept = self._is_lost(self._wanted), self._is_lost(self.kept)
        if not flown and not kept:
            return ""
        which = "The gains that fly" if flown else "The gains that you kept"
        said = f"{which} are in no file: they were tuned since the flight began."
        if flown and kept and self.kept != self._wanted:
            return f"{said} Others are kept; Revert flies these, so that they can be saved."
        return said

    def save_unsaved(self, path: Path, saved: Callable[[], object]) -> None:
        """Write what `unsaved` tells of to a gain file, and call back once it is written."""
        values = self._wanted if self._is_lost(self._wanted) else self.kept
        self.profiles.save(path, f"tuned in flight, from {self.profiles.name}", values, saved)

    def as_yaml(self) -> str:
        """Return what flies as a gain file's text."""
        return write_text(GainFile(self.profiles.vehicle, "copied while flying", self._wanted))

    def close(self) -> None:
        """Wait for what is being read or written; the last call."""
        self.profiles.close()

    def _is_lost(self, values: Values) -> bool:
        """Return whether values of the profile are to be had nowhere else."""
        as_begun = values == self._book.profile(self.start) if self.rows else True
        return not as_begun and not self.profiles.has(values)

    @property
    def _wanted(self) -> dict[str, float]:
        return self._book.profile(self._book.all_wanted)

    def _return_to(self, values: Values, flown: bool) -> None:
        """Propose values of the undo stack."""
        known = {name: value for name, value in values.items() if name in self._book.proposed}
        changed = self._set(known)
        if flown or self.is_at_once:
            self.apply()
        else:
            self._clear_doubt()
        self._tell_proposed(changed)

    def _fly(self, names: Iterable[str]) -> None:
        self._orders.give({name: self._book.proposed[name] for name in names})

    def _fly_all(self) -> None:
        self._fly(self.unflown)
        self._undo.fly()
        self._clear_doubt()
        self.state_changed.emit()

    def _confirmed(self, values: Values, time: float) -> None:
        before = dict(self.flown)
        self._book.flown.confirm(values, time)
        self._follow(before)

    def _refused(self, values: Values, said: str) -> None:
        for name in values:
            self._complain(name, said)
        if said != self._refusal:  # a flight that is broken refuses whatever comes
            self._refusal = said
            name, *others = values
            stays = f"{name} stays at {self.flown[name]:g}"
            whole = f"{stays}, and {len(others)} more as they are" if others else stays
            self._notices.warn(f"{whole}: {said}.")
        self.state_changed.emit()

    def _hear(self, published: list[Published]) -> None:
        before = dict(self.flown)
        if self._book.flown.hear(published):
            self._follow(before)

    def _follow(self, before: Values) -> None:
        """Show what the flight has now; what is being tried stays proposed."""
        changed, shown = self._book.follow(before)
        if not changed:
            return
        if shown:
            self._tell_proposed(self._put(shown, FOREIGN, flown=True))
        if judged_names(shown) and self._is_undecided:
            self.apply()  # what is judged or doubted has changed with it
        self.flown_changed.emit(changed)
        if judged_names(changed):
            self._judge.look_for_ranges(self.flown)
            self.ranges_changed.emit()
        self.state_changed.emit()
