"""What a page or a card of sensors that are off shows: why, and a button that flies with them."""

import copy
from collections.abc import Iterable

from PyQt6.QtCore import Qt
from PyQt6.QtWidgets import QAbstractButton, QWidget

from workbench.gui.flight_absence import NOTHING_FLIES_TEXT
from workbench.gui.home.sensor_state import SensorHealth, kind_word, silent_state
from workbench.gui.layout import NO_MARGINS, button, hbox, named, tool_button
from workbench.gui.workspace import Workspace
from workbench.live.view import LiveView


class SensorOffer(QWidget):
    """Offers another flight with kinds of sensors; visible if the first is off, or all are.

    Args:
        workspace: its flight.
        kinds: of the sensors, as `depth_camera`.
        small: whether the button is for the heading of a card.

    Attributes:
        said: why there is nothing of the first kind, as a sentence; "" if it measures.
        button: starts the other flight.
    """

    def __init__(self, workspace: Workspace, *kinds: str, small: bool = False) -> None:
        super().__init__()
        self._workspace, self._kinds, self._off = workspace, kinds, kinds
        self.said = NOTHING_FLIES_TEXT
        self.button: QAbstractButton
        if small:
            self.button = tool_button("Fly with it", self._fly, "tight")
        else:
            self.button = button(f"Fly with the {_kind_words(kinds)}", self._fly, "primary")
        hbox((self.button, Qt.AlignmentFlag.AlignHCenter), of=self, margins=NO_MARGINS)
        self.hide()

    def begin(self, view: LiveView) -> None:
        """Say why a flight that begins has no such sensor, if it has none."""
        sensors = () if view.snapshot is None else view.snapshot.sensors
        flown = {each.kind for each in sensors}
        states = {kind: silent_state(view, kind) for kind in self._kinds if kind not in flown}
        self.said = states[self._kinds[0]].advice if self._kinds[0] in states else ""
        self._off = tuple(
            kind for kind, state in states.items() if state.health is not SensorHealth.ABSENT
        )
        words = _kind_words(self._off)
        help = f"End this flight, and start the same one with the {words} on."
        named(self.button, f"Fly with the {words}", help)
        none = not flown.intersection(self._kinds)
        self.setVisible(self._kinds[0] in self._off or (none and bool(self._off)))

    def _fly(self) -> None:
        flight = self._workspace.flight
        if flight.view.scenario is None:
            return
        scenario = copy.deepcopy(flight.view.scenario)
        scenario.sensors.use = [*scenario.sensors.use, *self._off]
        flight.fly(scenario, draw=self._workspace.preferences.switch("draw_3d"))


def _kind_words(kinds: Iterable[str]) -> str:
    return " and the ".join(map(kind_word, kinds))
