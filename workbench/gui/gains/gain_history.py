"""The gains that were kept since the flight began, with notes."""

from collections.abc import Mapping
from dataclasses import dataclass, replace
from datetime import datetime

from PyQt6.QtCore import QObject, pyqtSignal

from workbench.gui.flight_model import FlightModel
from workbench.gui.gains.gain_editor import GainEditor


@dataclass(frozen=True)
class KeptGains:
    """Gains that were kept.

    Attributes:
        time: flight time [s].
        clock: time of day, in the user's time zone.
        gains: values by name.
        note: the user's note.
    """

    time: float
    clock: str
    gains: Mapping[str, float]
    note: str = ""


class GainHistory(QObject):
    """Notes each set of gains that is kept; another flight begins another history.

    Args:
        editor: keeps the gains.
        flight: the flight.
        parent: the Qt parent.

    Attributes:
        entries: the kept gains, oldest first; the first are those of the flight's start.
    """

    changed = pyqtSignal()
    """Another entry, or another note."""

    def __init__(
        self, editor: GainEditor, flight: FlightModel, parent: QObject | None = None
    ) -> None:
        super().__init__(parent)
        self._editor, self._flight = editor, flight
        self.entries: list[KeptGains] = []
        editor.begun.connect(self._begin)
        editor.state_changed.connect(self._look)

    @property
    def note(self) -> str:
        """The note on the gains that were kept last."""
        return self.entries[-1].note if self.entries else ""

    def set_note(self, index: int, note: str) -> None:
        """Change the note on an entry."""
        self.entries[index] = replace(self.entries[index], note=note.strip())
        self.changed.emit()

    def _begin(self) -> None:
        self.entries = []
        self._look()

    def _look(self) -> None:
        """Add the kept gains if they are new."""
        kept = dict(self._editor.kept)
        if not kept or (self.entries and self.entries[-1].gains == kept):
            return
        snapshot = self._flight.view.snapshot
        time = snapshot.time if snapshot is not None else 0.0
        self.entries.append(KeptGains(time, f"{datetime.now():%H:%M:%S}", kept))
        self.changed.emit()
