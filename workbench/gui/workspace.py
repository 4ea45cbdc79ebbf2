"""Services that all screens share."""

from dataclasses import dataclass, field
from functools import partial
from pathlib import Path

from PyQt6.QtCore import QObject, pyqtSignal

from workbench.gui.analysis import Analysis
from workbench.gui.errands import BackgroundTasks, FutureCallbacks
from workbench.gui.flight_absence import FlightAbsence
from workbench.gui.flight_model import FlightModel
from workbench.gui.key_map import KeyMap
from workbench.gui.notices import Notices
from workbench.gui.preferences import Preferences
from workbench.gui.recent_files import RecentFiles
from workbench.gui.signals import Signals, events_in
from workbench.gui.theme import Look
from workbench.gui.view3d.scene import Scene
from workbench.link.backplane import Published
from workbench.live.view import LiveView


class OpenedLog(QObject):
    """The last opened log: charts show it, and it can be flown again.

    Attributes:
        path: its path; None before the first one.
    """

    changed = pyqtSignal()
    """Another log was opened."""
    card_wanted = pyqtSignal(str)
    """The card of the Tuning screen with this title should be shown: it is about the log."""

    def __init__(self) -> None:
        super().__init__()
        self.path: Path | None = None

    def open(self, path: Path) -> None:
        """Set the opened log."""
        self.path = path
        self.changed.emit()


@dataclass(frozen=True)
class Workspace:
    """Parts of the app that outlive a screen.

    Attributes:
        flight: the present flight.
        absence: why there is none yet.
        signals: flown signals over time.
        analysis: asks the analyst, and has its answers as signals.
        preferences: preferences, stored between starts.
        notices: takes errors and other news.
        look: colours and sizes, light or dark.
        keys: keys of all actions.
        recent: files that were opened last.
        answers: calls back when background work is done that outlives a screen.
        errands: file access in the background.
        log: the last opened log.
        scene: additions to the 3-D view.
    """

    flight: FlightModel
    absence: FlightAbsence
    signals: Signals
    analysis: Analysis
    preferences: Preferences
    notices: Notices
    look: Look
    keys: KeyMap
    recent: RecentFiles
    answers: FutureCallbacks
    errands: BackgroundTasks = field(default_factory=BackgroundTasks)
    log: OpenedLog = field(default_factory=OpenedLog)
    scene: Scene = field(default_factory=Scene)

    def close(self) -> None:
        """End everything, and wait until it is gone; must be the last call."""
        self.answers.close()
        self.analysis.close()
        self.flight.close()
        self.errands.close()


def make_workspace(preferences: Preferences | None = None) -> Workspace:
    """Return connected services: signals and analyst follow the flight.

    Args:
        preferences: preferences; by default the user's.
    """
    preferences = preferences or Preferences()
    notices = Notices()
    flight = FlightModel(notices)
    workspace = Workspace(
        flight=flight,
        absence=FlightAbsence(flight, preferences.store),
        signals=Signals(),
        analysis=Analysis(notices),
        preferences=preferences,
        notices=notices,
        look=Look(preferences),
        keys=KeyMap(preferences.store),
        recent=RecentFiles(preferences.store),
        answers=FutureCallbacks(notices.warn),
    )
    workspace.flight.begun.connect(partial(_begin_flight, workspace))
    workspace.flight.taken_over.connect(partial(_begin_analysis, workspace))
    workspace.flight.streamed.connect(workspace.signals.add)
    workspace.flight.streamed.connect(partial(_warn, workspace))
    return workspace


def _begin_flight(workspace: Workspace, view: LiveView) -> None:
    workspace.signals.begin(view.topics, view.vehicle)
    _begin_analysis(workspace, view)


def _begin_analysis(workspace: Workspace, view: LiveView) -> None:
    if view.scenario is not None:
        workspace.analysis.begin(view.scenario, view.values, view.controller)


def _warn(workspace: Workspace, published: list[Published]) -> None:
    """Report the flight's alarms; its failures end it, and are reported with its end."""
    for _, kind, said in events_in(published):
        if kind == "warning":
            what, _, remedy = said.partition(". ")
            workspace.notices.alarm(what, remedy and f"{remedy.rstrip('.')}.")
