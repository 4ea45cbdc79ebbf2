"""What all screens share."""

from dataclasses import dataclass, field
from functools import partial
from pathlib import Path

from PyQt6.QtCore import QObject, pyqtSignal

from workbench.gui.analysis import Analysis
from workbench.gui.errands import Errands
from workbench.gui.flight_model import FlightModel
from workbench.gui.notices import Notices
from workbench.gui.preferences import Preferences
from workbench.gui.signals import Signals
from workbench.gui.theme import Look
from workbench.gui.view3d.scene import Scene
from workbench.gui.visualization.event_list import EventList
from workbench.link.backplane import Published
from workbench.live.view import LiveView


class OpenedLog(QObject):
    """The log that was opened last: charts show it, and it can be flown again.

    Attributes:
        path: of it; None before the first one.
    """

    changed = pyqtSignal()
    """Another one was opened."""
    what_if_wanted = pyqtSignal()
    """It is to be flown again."""

    def __init__(self, parent: QObject | None = None) -> None:
        super().__init__(parent)
        self.path: Path | None = None

    def open(self, path: Path) -> None:
        """Take a log for the one that is opened."""
        self.path = path
        self.changed.emit()


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
        errands: what is written to files in the background.
        log: that was opened last.
        scene: what the 3-D view shows besides the flight.
    """

    flight: FlightModel
    signals: Signals
    analysis: Analysis
    preferences: Preferences
    notices: Notices
    look: Look
    errands: Errands = field(default_factory=Errands)
    log: OpenedLog = field(default_factory=OpenedLog)
    scene: Scene = field(default_factory=Scene)

    def close(self) -> None:
        """End what was started, and wait until it is gone; the last call."""
        self.analysis.close()
        self.flight.close()
        self.errands.close()


def make_workspace(preferences: Preferences | None = None) -> Workspace:
    """Return what the screens share, put together: series and analyst follow the flight.

    Args:
        preferences: those of the user where not given.
    """
    preferences = preferences or Preferences()
    notices = Notices()
    workspace = Workspace(
        flight=FlightModel(notices),
        signals=Signals(),
        analysis=Analysis(notices),
        preferences=preferences,
        notices=notices,
        look=Look(preferences),
    )
    events = EventList()
    workspace.flight.begun.connect(partial(_begin, workspace, events))
    workspace.flight.taken_over.connect(partial(_judge, workspace))
    workspace.flight.streamed.connect(workspace.signals.add)
    workspace.flight.streamed.connect(partial(_warn, workspace, events))
    return workspace


def _begin(workspace: Workspace, events: EventList, view: LiveView) -> None:
    workspace.signals.begin(view.topics)
    events.begin(view.topics)
    _judge(workspace, view)


def _judge(workspace: Workspace, view: LiveView) -> None:
    if view.scenario is not None:
        workspace.analysis.begin(view.scenario, view.values, view.controller)


def _warn(workspace: Workspace, events: EventList, published: list[Published]) -> None:
    """Tell what the flight warns of; its failures end it, and are told with its end."""
    for event in events.add(published):
        if event.kind == "warning":
            what, _, remedy = event.said.partition(". ")
            workspace.notices.warn(what, remedy and f"{remedy}.")
