"""Looks after parameters that the flight's own script changes; the flight tells nobody of those."""

import math
from collections.abc import Sequence

from PyQt6.QtCore import QObject

from workbench.gui.flight_model import FlightModel
from workbench.gui.gains.gain_orders import Confirmed
from workbench.live.view import LiveView
from workbench.scenario.parameters import PARAMETERS
from workbench.scenario.scenario import Action

LATER = 0.05
"""A script acts at the next whole step; it is looked after a little later [s]."""


class ScriptWatch(QObject):
    """Asks the flight for a parameter once its script has changed it.

    Args:
        flight: is asked.
        confirmed: hears what is flown.
        parent: whose life it shares.
    """

    def __init__(self, flight: FlightModel, confirmed: Confirmed, parent: QObject) -> None:
        super().__init__(parent)
        self._flight, self._confirmed = flight, confirmed
        self._actions: list[tuple[float, tuple[str, ...]]] = []
        self._time = 0.0
        flight.viewed.connect(self._look)

    def begin(self, script: Sequence[Action]) -> None:
        """Begin with a flight that has this script."""
        acts = [(action.at + LATER, changed_names(action)) for action in script]
        self._actions = [each for each in acts if each[1]]
        self._time = 0.0

    def _look(self, view: LiveView) -> None:
        if not self._actions or view.snapshot is None:
            return
        before, self._time = self._time, view.snapshot.time
        for at, names in self._actions:
            if before < at <= self._time:
                for name in names:
                    self._ask(name)

    def _ask(self, name: str) -> None:
        self._flight.order(
            lambda live: live.get(name),
            done=lambda value: self._confirmed({name: value}, math.inf),  # it is the present one
        )


def changed_names(action: Action) -> tuple[str, ...]:
    """Return the names of all parameters that an action of a script changes."""
    kinds = [kind for kind in ("gust", "push") if getattr(action, kind) is not None]
    blown = [row.name for row in PARAMETERS for kind in kinds if row.name.startswith(f"{kind}_")]
    return (*action.set, *blown)
