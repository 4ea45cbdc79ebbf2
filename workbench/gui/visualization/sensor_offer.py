"""What a page of a sensor that is off shows: why, and a button that flies with it."""

import copy

from PyQt6.QtCore import Qt
from PyQt6.QtWidgets import QWidget

from workbench.gui.flight_absence import NOTHING_FLIES_TEXT
from workbench.gui.home.sensor_state import SensorHealth, silent_state
from workbench.gui.layout import NO_MARGINS, button, hbox
from workbench.gui.workspace import Workspace
from workbench.live.view import LiveView


class SensorOffer(QWidget):
    """Offers another flight with a kind of sensor; visible if the drone has it and it is off.

    Args:
        workspace: its flight.
        kind: of the sensor, as `depth_camera`.

    Attributes:
        said: why there is nothing of that kind, as a sentence; "" if it measures.
        button: starts the other flight.
    """

    def __init__(self, workspace: Workspace, kind: str) -> None:
        super().__init__()
        self._workspace, self._kind = workspace, kind
        self.said = NOTHING_FLIES_TEXT
        word = kind.replace("_", " ")
        help = f"End this flight, and start the same one with the {word} on."
        self.button = button(f"Fly with the {word}", self._fly, "primary", help)
        hbox((self.button, Qt.AlignmentFlag.AlignHCenter), of=self, margins=NO_MARGINS)
        self.hide()

    def begin(self, view: LiveView) -> None:
        """Say why a flight that begins has no such sensor, if it has none."""
        sensors = view.snapshot.sensors if view.snapshot is not None else ()
        measures = any(each.kind == self._kind for each in sensors)
        state = silent_state(view, self._kind)
        self.said = "" if measures else state.advice
        self.setVisible(not measures and state.health is SensorHealth.OFF)

    def _fly(self) -> None:
        flight = self._workspace.flight
        if flight.view.scenario is None:
            return
        scenario = copy.deepcopy(flight.view.scenario)
        scenario.sensors.use = [*scenario.sensors.use, self._kind]
        flight.fly(scenario, draw=self._workspace.preferences.switch("draw_3d"))
