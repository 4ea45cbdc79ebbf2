"""The app: one window and its shared services, from the first paint to the last process."""

import gc
import signal
import sys
import threading
import traceback
from collections.abc import Iterator
from contextlib import contextmanager
from types import TracebackType

from PyQt6 import sip
from PyQt6.QtCore import QCoreApplication, QMargins, QObject, Qt, QTimer, pyqtSignal
from PyQt6.QtWidgets import QApplication

from workbench.common.errors import WorkbenchError
from workbench.control.mode import FlightMode
from workbench.gui.first_flight import DEFAULT_APP_SCENARIO, first_flight
from workbench.gui.flight_model import FlightModel
from workbench.gui.home.route import REFERENCE_PLACE_SLICE
from workbench.gui.main_window import MainWindow
from workbench.gui.notices import Notice, Notices, Severity
from workbench.gui.style import apply_style
from workbench.gui.workspace import Workspace, make_workspace
from workbench.live.choice import Choice
from workbench.live.messages import Phase
from workbench.live.view import LiveView
from workbench.scenario.scenario import Action, Scenario

DEMO_SCENARIO = "network"
"""Scenario of the demo: a drone on the ground between obstacles."""
DEMO_WAYPOINTS_M = ((4.0, 0.0, 1.5), (3.0, 5.0, 2.0), (-3.5, 3.0, 1.5), (-2.0, -3.0, 1.8))
"""Waypoints in W, each at least 2 m from any obstacle [m]."""
WAYPOINT_INTERVAL_S = 7.0
"""Simulated time between waypoints [s]."""
DEMO_ORDER_DELAY_S = 0.2
"""Time after an order until mode and command show it [s]."""
ORGANISATION_NAME, APPLICATION_NAME = "drake-drone-workbench", "workbench"
TITLE_BAR_PX = 40
"""Height of the title bar that a desktop adds to a window [px]."""
INTERRUPT_POLL_MS = 200
"""Period between checks for Ctrl-C in the terminal [ms]."""
CRASH_REMEDY = "The app continues. Reset the flight (Ctrl+R) if it looks wrong; copy the details."
MAX_ERROR_CHARACTERS = 200
"""Largest length of an exception's message in the banner [characters]."""


class CrashGuard(QObject):
    """Turns unhandled exceptions of all threads into notices, while it is installed.

    Otherwise one in a slot would end the process.

    Args:
        notices: takes the report.
    """

    interrupted = pyqtSignal()
    """Ctrl-C was pressed in the terminal."""
    _caught = pyqtSignal(object)

    def __init__(self, notices: Notices) -> None:
        super().__init__()
        self._notices = notices
        queued = Qt.ConnectionType.QueuedConnection  # in whatever thread it happened
        self._caught.connect(self._tell, queued)  # pyrefly: ignore[bad-argument-count]
        self._before = (sys.excepthook, threading.excepthook)

    def install(self) -> None:
        """Install the handlers."""
        self._before = (sys.excepthook, threading.excepthook)
        sys.excepthook = self.catch
        threading.excepthook = self._catch_in_thread

    def uninstall(self) -> None:
        """Restore the former handlers."""
        sys.excepthook, threading.excepthook = self._before

    def catch(
        self, kind: type[BaseException], error: BaseException, trace: TracebackType | None
    ) -> None:
        """Report an exception; Ctrl-C closes the app."""
        if issubclass(kind, KeyboardInterrupt):
            self.interrupted.emit()
            return
        details = "".join(traceback.format_exception(kind, error, trace))
        print(details, file=sys.stderr)
        words = " ".join(str(error).split())[:MAX_ERROR_CHARACTERS]
        where = _exception_place(trace)
        what = f"something went wrong in the app: {kind.__name__}: {words}{where}"
        self._caught.emit(Notice(Severity.FAILURE, what, CRASH_REMEDY, details))

    def _catch_in_thread(self, caught: threading.ExceptHookArgs) -> None:
        if caught.exc_value is not None and not issubclass(caught.exc_type, SystemExit):
            self.catch(caught.exc_type, caught.exc_value, caught.exc_traceback)

    def _tell(self, notice: Notice) -> None:
        self._notices.told.emit(notice)


def _exception_place(trace: TracebackType | None) -> str:
    """Return file and line of the exception."""
    frames = traceback.extract_tb(trace)
    if not frames:
        return ""
    last = frames[-1]
    return f" ({last.filename.rpartition('/')[2]}:{last.lineno})"


class DemoPilot(QObject):
    """Flies until someone else does; restarts after a reset, and ends with another scenario.

    Args:
        flight: the flight to fly.
        notices: takes the notice of its end.
        parent: the Qt parent; this object is deleted with it.
    """

    def __init__(
        self, flight: FlightModel, notices: Notices, parent: QObject | None = None
    ) -> None:
        super().__init__(parent)
        self._flight, self._notices = flight, notices
        self._scenario: Scenario | None = None
        self._prepare()
        flight.begun.connect(self._begin)
        flight.viewed.connect(self._follow)

    def _begin(self, view: LiveView) -> None:
        """Start with the first flight, and again with each one of the same scenario."""
        self._prepare()
        if self._scenario is None:
            self._scenario = view.scenario
        self._over = view.scenario != self._scenario  # the waypoints may be inside obstacles

    def _prepare(self) -> None:
        self._over = self._took_off = self._waits = False
        self._leg = 0
        self._due = self._in_force = 0.0
        self._reference: tuple[float, ...] = ()

    def _follow(self, view: LiveView) -> None:
        if self._over or self._waits or view.phase is not Phase.FLYING or view.snapshot is None:
            return
        mode, now = view.snapshot.mode, view.snapshot.time
        if mode in (FlightMode.ARMED, FlightMode.TAKING_OFF) or now < self._in_force:
            return
        if mode is FlightMode.OFF and not self._took_off:
            self._took_off = self._waits = True
            self._flight.do(Action(request="take_off"), self._go_on)
        elif mode in (FlightMode.OFF, FlightMode.LANDING):
            self._end("the drone lands")
        elif self._is_disturbed(view):
            self._end("somebody else flies")
        elif now >= self._due:
            self._fly_leg(now)

    def _fly_leg(self, now: float) -> None:
        place = DEMO_WAYPOINTS_M[self._leg % len(DEMO_WAYPOINTS_M)]
        self._leg += 1
        self._due = now + WAYPOINT_INTERVAL_S
        self._reference = (*place, 1.0)
        self._waits = True
        self._flight.do(Action(go_to=[*place]), self._go_on)

    def _go_on(self, time: float) -> None:
        self._waits = False
        self._in_force = time + DEMO_ORDER_DELAY_S

    def _is_disturbed(self, view: LiveView) -> bool:
        """Return whether the drone has had a command from anyone else."""
        assert view.snapshot
        return (
            bool(self._reference)
            and view.snapshot.reference[REFERENCE_PLACE_SLICE] != self._reference
        )

    def _end(self, why: str) -> None:
        self._over = True
        self._notices.inform(f"the demo has ended, because {why}; a reset starts it again")


def run(choice: Choice | None, *, screen: str = "", view3d: bool = True, demo: bool = False) -> int:
    """Open the window, fly, and return the exit code after the window is closed.

    Args:
        choice: what to fly first; None for the last setup, or the default.
        screen: name of the first screen, "" for the last one.
        view3d: whether flights are drawn in 3-D.
        demo: whether a demo pilot flies until someone else does.
    """
    app = make_app()
    workspace = make_workspace()
    guard = CrashGuard(workspace.notices)
    guard.install()
    window = MainWindow(workspace, first=screen, view3d=view3d)
    try:
        first = choice or _default_choice(workspace)
        window.control.fly(first)  # its process loads Drake while the window is painted
        apply_style(app, workspace.look)
        _show_window(window)
        guard.interrupted.connect(window.close)
        warn_of_lost_settings(workspace)
        if demo:
            DemoPilot(workspace.flight, workspace.notices, window)
        elif window.guide.wanted and not screen:
            window.begin_with_guide()
        with _close_on_signal(window):
            return app.exec()
    finally:
        window.close()
        guard.uninstall()
        delete_objects()


def _show_window(window: MainWindow) -> None:
    """Show the window; on a screen that is too small for its size, it fills the screen."""
    screen = window.screen()
    needed = window.size().grownBy(QMargins(0, TITLE_BAR_PX, 0, 0))
    if screen is None or needed.boundedTo(screen.availableSize()) == needed:
        window.show()
    else:
        window.showMaximized()


def delete_objects() -> None:
    """Delete all of Qt's objects but the application.

    PyQt does it when Python exits, but it walks a list of objects that it frees meanwhile, and
    crashes now and then. Here a list holds them.
    """
    gc.unfreeze()
    held = [each for each in gc.get_objects() if isinstance(each, QObject)]
    for each in held:
        is_app = isinstance(each, QApplication)
        if not is_app and sip.ispyowned(each) and not sip.isdeleted(each) and not each.parent():
            sip.delete(each)


def _default_choice(workspace: Workspace) -> Choice:
    """Return what to fly if nothing was named."""
    try:
        return first_flight(workspace.preferences.store)
    except WorkbenchError as error:
        workspace.notices.warn(str(error), "The default scenario flies instead.")
        return Choice(DEFAULT_APP_SCENARIO)


def warn_of_lost_settings(workspace: Workspace) -> None:
    """Warn if nothing can be stored for the next start."""
    store = workspace.preferences.store
    if not store.isWritable():
        workspace.notices.warn(
            f"settings and window positions are lost at the end: {store.fileName()} cannot be "
            "written",
            "Make its folder writable, or name another one in XDG_CONFIG_HOME.",
        )


def make_app() -> QApplication:
    """Return Qt's application, prepared for loading the web engine later."""
    present = QApplication.instance()
    if isinstance(present, QApplication):
        return present
    QCoreApplication.setOrganizationName(ORGANISATION_NAME)
    QCoreApplication.setApplicationName(APPLICATION_NAME)
    QCoreApplication.setAttribute(Qt.ApplicationAttribute.AA_ShareOpenGLContexts)
    app = QApplication(sys.argv[:1])
    app.setApplicationDisplayName("")  # the window's title has the name
    return app


@contextmanager
def _close_on_signal(window: MainWindow) -> Iterator[None]:
    """Close on Ctrl-C and on SIGTERM; Qt alone would not check for them."""
    numbers = (signal.SIGINT, signal.SIGTERM)
    before = [signal.signal(number, lambda *_: window.close()) for number in numbers]
    beat = QTimer()
    beat.timeout.connect(lambda: None)  # lets Python handle signals
    beat.start(INTERRUPT_POLL_MS)
    try:
        yield
    finally:
        beat.stop()
        for number, handler in zip(numbers, before, strict=True):
            signal.signal(number, handler)
