"""The app: one window and what it shares, from the first paint to the last process."""

import signal
import sys
from collections.abc import Iterator
from contextlib import contextmanager

from PyQt6.QtCore import QCoreApplication, Qt, QTimer
from PyQt6.QtWidgets import QApplication

from workbench.common.errors import WorkbenchError
from workbench.gui.crash import CrashGuard
from workbench.gui.demo import DemoPilot
from workbench.gui.first_flight import DEFAULT_SCENARIO, first_flight
from workbench.gui.main_window import MainWindow
from workbench.gui.style import apply_style
from workbench.gui.workspace import Workspace, make_workspace
from workbench.live.choice import Choice

ORGANISATION, NAME = "drake-drone-workbench", "workbench"
BEAT = 200
"""Between two looks whether Ctrl-C was pressed in the terminal [ms]."""


def run(choice: Choice | None, *, screen: str = "", view3d: bool = True, demo: bool = False) -> int:
    """Open the window, fly, and return the exit code once it is closed.

    Args:
        choice: what to fly at first; None for what was set up last, or the default.
        screen: name of the first screen, "" for the one seen last.
        view3d: whether flights are drawn in 3-D.
        demo: whether a pilot shows the drone until somebody else flies.
    """
    app = make_app()
    workspace = make_workspace()
    guard = CrashGuard(workspace.notices)
    guard.install()
    window = MainWindow(workspace, first=screen, view3d=view3d)
    try:
        first = choice or _first(workspace)
        window.control.fly(first)  # its process loads Drake while the window is painted
        apply_style(app, workspace.look)
        window.show()
        guard.interrupted.connect(window.close)
        if demo:
            DemoPilot(workspace.flight, workspace.notices, window)
        with _told_to_close(window):
            return app.exec()
    finally:
        window.close()
        guard.uninstall()


def _first(workspace: Workspace) -> Choice:
    """Return what is flown where nothing was named."""
    try:
        return first_flight(workspace.preferences.store)
    except WorkbenchError as error:
        workspace.notices.warn(str(error), "The default scenario flies instead.")
        return Choice(DEFAULT_SCENARIO)


def make_app() -> QApplication:
    """Return Qt's application, ready for the web engine to be loaded later."""
    present = QApplication.instance()
    if isinstance(present, QApplication):
        return present
    QCoreApplication.setOrganizationName(ORGANISATION)
    QCoreApplication.setApplicationName(NAME)
    QCoreApplication.setAttribute(Qt.ApplicationAttribute.AA_ShareOpenGLContexts)
    app = QApplication(sys.argv[:1])
    app.setApplicationDisplayName("")  # the window's title says it
    return app


@contextmanager
def _told_to_close(window: MainWindow) -> Iterator[None]:
    """Close on Ctrl-C and on a kind end from outside; Qt alone would not look for them."""
    numbers = (signal.SIGINT, signal.SIGTERM)
    before = [signal.signal(number, lambda *_: window.close()) for number in numbers]
    beat = QTimer()
    beat.timeout.connect(lambda: None)  # lets Python look
    beat.start(BEAT)
    try:
        yield
    finally:
        beat.stop()
        for number, handler in zip(numbers, before, strict=True):
            signal.signal(number, handler)
