"""Controllers that could fly in place of the one that does."""

from pathlib import Path

from workbench.control.controller import SHIPPED
from workbench.gui.flight_model import FlightModel


class OtherControllers:
    """Shipped controllers, and files that have flown since the window is there.

    Args:
        flight: whose controller is not among them.
    """

    def __init__(self, flight: FlightModel) -> None:
        self._flight = flight
        self._files: list[str] = []

    @property
    def present(self) -> str:
        """The one that flies: a shipped one's name, or a file's path."""
        scenario = self._flight.view.scenario
        return scenario.controller if scenario is not None else SHIPPED[0]

    @property
    def all(self) -> tuple[str, ...]:
        """All that are known, in an order that stays."""
        return (*SHIPPED, *self._files)

    @property
    def names(self) -> tuple[str, ...]:
        """All but the one that flies."""
        present = self.present
        return tuple(name for name in self.all if name != present)

    def note_flight(self) -> None:
        """Take note of what flies now."""
        if self.present not in self.all:
            self._files.append(self.present)


def controller_label(name: str) -> str:
    """Return how a controller is called: a shipped one's name, or that of its file."""
    return Path(name).stem if name.endswith(".py") else name
