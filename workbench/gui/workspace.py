"""What all screens share."""

from dataclasses import dataclass

from workbench.gui.analysis import Analysis
from workbench.gui.flight_model import FlightModel
from workbench.gui.notices import Notices
from workbench.gui.preferences import Preferences
from workbench.gui.signals import Signals
from workbench.gui.theme import Look


@dataclass(frozen=True)
class Workspace:
    """The parts of the app that outlive a screen.

    Attributes:
        flight: what flies.
        signals: what was flown, as series over time.
        analysis: what the process that judges gains knows.
        preferences: kept between starts.
        notices: where anything that went wrong is told.
        look: colours and sizes, light or dark.
    """

    flight: FlightModel
    signals: Signals
    analysis: Analysis
    preferences: Preferences
    notices: Notices
    look: Look
