"""Why there is no flight to show yet: none was opened, or it starts."""

import math
import time
from collections.abc import Callable

from PyQt6.QtCore import QObject, QSettings, pyqtSignal

from workbench.common.plain_text import plain_name
from workbench.gui.flight_model import FlightModel
from workbench.live.messages import Phase
from workbench.live.view import LiveView

NOTHING_FLIES_TEXT = "Nothing flies yet: open a scenario."
START_SECONDS_KEY = "flight/start_seconds"
"""Where the duration of the last start on this machine is stored."""


class FlightAbsence(QObject):
    """Says why there is no flight yet, and how long one starts: as long as the last one did.

    Args:
        flight: the flight.
        store: storage of the duration of the last start.
        clock: returns a monotonic time [s].

    Attributes:
        text: the reason as a sentence; "" while there is a flight.
    """

    changed = pyqtSignal(str)
    """The text."""

    def __init__(
        self,
        flight: FlightModel,
        store: QSettings,
        clock: Callable[[], float] = time.monotonic,
    ) -> None:
        super().__init__()
        self.text = NOTHING_FLIES_TEXT
        self._flight, self._store, self._clock = flight, store, clock
        self._begun = math.nan
        flight.viewed.connect(self._follow)

    def _follow(self, view: LiveView) -> None:
        starts = self._flight.live is not None and view.phase is Phase.STARTING
        if view.snapshot is not None:
            if math.isfinite(self._begun):
                self._store.setValue(START_SECONDS_KEY, self._clock() - self._begun)
            text = ""
        elif starts:
            self._begun = self._clock() if math.isnan(self._begun) else self._begun
            text = f"Starting{self._usual_duration}: {plain_name(view.said)}."
        else:
            text = NOTHING_FLIES_TEXT
        if not starts:
            self._begun = math.nan
        if text != self.text:
            self.text = text
            self.changed.emit(text)

    @property
    def _usual_duration(self) -> str:
        """How long the last start took, after a comma; "" if that is not known."""
        try:
            seconds = float(str(self._store.value(START_SECONDS_KEY)))
        except ValueError:  # none yet, or written by something else
            return ""
        return f", about {seconds:.0f}\N{NO-BREAK SPACE}s" if seconds >= 0.5 else ""
