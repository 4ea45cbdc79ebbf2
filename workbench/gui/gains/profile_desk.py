"""Loads and saves profiles of gains without keeping anybody waiting."""

from collections.abc import Callable, Iterable, Mapping
from pathlib import Path

from PyQt6.QtCore import QObject, pyqtSignal

from workbench.gains.profiles import GainFile, load_gains, save_gains
from workbench.gui.answers import Answers
from workbench.gui.errands import Errands
from workbench.gui.gains.profiles import CLIPBOARD, Offer, make_offer, read_own, read_text
from workbench.gui.notices import Notices
from workbench.live.view import LiveView
from workbench.plant.vehicle import Vehicle

AT_START = "Start of the flight"
Values = Mapping[str, float]


class ProfileDesk(QObject):
    """Offers what files have, and writes what flies.

    Args:
        present: tells all values that the flight has.
        adopt: flies values, described in words.
        notices: where refusals are told.
        parent: whose life it shares.

    Attributes:
        name: of the profile that was loaded or saved last.
        offer: what may be taken over, None where nothing is offered.
    """

    offered = pyqtSignal(object)
    """An `Offer`, or None when it is settled."""
    named = pyqtSignal(str)
    """Name of the profile that flies now."""

    def __init__(
        self,
        present: Callable[[], Values],
        adopt: Callable[[Values, str], None],
        notices: Notices,
        parent: QObject | None = None,
    ) -> None:
        super().__init__(parent)
        self._present, self._adopt, self._notices = present, adopt, notices
        self._errands = Errands()
        self._answers = Answers(lambda said: notices.warn(said), self)
        self._vehicle: Vehicle | None = None
        self._start: Values = {}
        self._values: Values = {}
        self.name = ""
        self.offer: Offer | None = None

    @property
    def is_changed(self) -> bool:
        """Whether the flight has other values than the profile that was loaded or saved last."""
        return not self.has(self._present())

    def has(self, values: Values) -> bool:
        """Return whether the profile that was loaded or saved last has these values."""
        return all(values.get(name) == value for name, value in self._values.items())

    @property
    def vehicle(self) -> str:
        """Name of the vehicle that flies, "" before a flight."""
        return self._vehicle.name if self._vehicle else ""

    def begin(self, view: LiveView, start: Values) -> None:
        """Begin with the profile of a new flight's start."""
        self._vehicle = view.vehicle
        self._start = dict(start)
        self._set_name(AT_START, start)
        self.decline()

    def load(self, path: Path) -> None:
        """Offer what a gain file has."""
        self._read(path.stem, lambda: load_gains(path))

    def load_own(self) -> None:
        """Offer the model's own gains."""
        if self._vehicle is None:
            self._notices.warn("nothing flies: open a scenario first")
            return
        source = self._vehicle.source
        start = GainFile(self.vehicle, "as the flight began", self._start)
        self._read(f"{self.vehicle}'s own", lambda: read_own(source, start))

    def paste(self, text: str) -> None:
        """Offer what a text of the clipboard has."""
        self._read(f"the {CLIPBOARD}", lambda: read_text(text))

    def take(self, names: Iterable[str]) -> None:
        """Fly some of what is offered.

        Args:
            names: of those parameters.
        """
        if self.offer is None:
            return
        offer, taken = self.offer, set(names)
        self.decline()
        self._set_name(offer.name, offer.values)
        self._adopt({n: v for n, v in offer.values.items() if n in taken}, offer.name)

    def decline(self) -> None:
        """Take nothing of what is offered."""
        self.offer = None
        self.offered.emit(None)

    def save(
        self, path: Path, origin: str, values: Values, saved: Callable[[], object] | None = None
    ) -> None:
        """Write values to a gain file, which keeps its history.

        Args:
            path: of the file.
            origin: a sentence on where they come from.
            values: by name.
            saved: called once they are written.
        """
        profile = GainFile(self.vehicle, origin, dict(values))

        def tell(written: GainFile) -> None:
            self._saved(path, written)
            if saved is not None:
                saved()

        self._answers.expect(self._errands.run(lambda: save_gains(path, profile)), done=tell)

    def close(self) -> None:
        """Wait for what is being read or written; the last call."""
        self._answers.close()
        self._errands.close()

    def _read(self, name: str, read: Callable[[], GainFile]) -> None:
        self._answers.expect(
            self._errands.run(read), done=lambda file: self._make_offer(name, file)
        )

    def _make_offer(self, name: str, file: GainFile) -> None:
        offer = make_offer(name, file, self.vehicle, self._present())
        if offer.changes:
            self.offer = offer
            self.offered.emit(offer)
            return
        self._set_name(name, offer.values)
        self._notices.inform(f"Nothing differs: the flight has the gains of {name} already.")

    def _saved(self, path: Path, written: GainFile) -> None:
        self._set_name(path.stem, written.gains)
        self._notices.inform(f"Saved {len(written.gains)} values to {path}.")

    def _set_name(self, name: str, values: Values) -> None:
        self.name, self._values = name, dict(values)
        self.named.emit(name)
