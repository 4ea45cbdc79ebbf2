"""The 3-D view beside any screen."""

import math
import time
from collections.abc import Callable

from PyQt6.QtCore import Qt, QTimer, QUrl
from PyQt6.QtGui import QDesktopServices
from PyQt6.QtWidgets import QLabel, QPushButton, QStackedLayout, QVBoxLayout, QWidget

from workbench.errors import WorkbenchError
from workbench.gui.style import dressed
from workbench.gui.view3d.web_engine import load_web_view
from workbench.gui.workspace import Workspace
from workbench.live.messages import Phase
from workbench.live.view import LiveView

NARROWEST = 260
WAITING = "The 3-D view comes with the flight."
NOT_DRAWN = (
    "This flight is not drawn. Switch the 3-D view on in Settings, then open the scenario again."
)
TOO_SLOW = 4.0
"""Wall time for which a flight beside the picture is too slow until the user is told [s]."""
ENDED = "The flight has ended, and its 3-D view with it."


class View3d(QWidget):
    """Meshcat's page of the present flight, or why there is none; the web engine is loaded last.

    Args:
        workspace: whose flight is shown.
        load: returns the class of web views.
        parent: in which it stands.
    """

    def __init__(
        self,
        workspace: Workspace,
        load: Callable[[], Callable[[], QWidget]] = load_web_view,
        parent: QWidget | None = None,
    ) -> None:
        super().__init__(parent)
        self.setAccessibleName("3-D view of the flight")
        self.setMinimumWidth(NARROWEST)
        self._workspace, self._load = workspace, load
        self._web: QWidget | None = None
        self._missing = ""
        self._url = ""
        self._slow_since = math.inf
        self._told_slow = False
        self._words = dressed(QLabel(), "muted")
        self._words.setWordWrap(True)
        self._words.setAlignment(Qt.AlignmentFlag.AlignCenter)
        self._words.setTextInteractionFlags(Qt.TextInteractionFlag.TextSelectableByMouse)
        self._browse = QPushButton("Open in the &browser")
        self._browse.clicked.connect(self.browse)
        self._page = QWidget()
        page = QVBoxLayout(self._page)
        page.setContentsMargins(24, 24, 24, 24)
        page.addStretch(1)
        page.addWidget(self._words)
        page.addWidget(self._browse, 0, Qt.AlignmentFlag.AlignHCenter)
        page.addStretch(1)
        self._layout = QStackedLayout(self)
        self._layout.setContentsMargins(0, 0, 0, 0)
        self._layout.addWidget(self._page)
        workspace.flight.viewed.connect(self._follow)
        self._show()

    @property
    def url(self) -> str:
        """Of the page that is shown, or would be."""
        return self._url

    @property
    def said(self) -> str:
        """What stands where the picture would be, "" while it is there."""
        return "" if self._layout.currentWidget() is not self._page else self._words.text()

    def browse(self) -> None:
        """Open the page in the browser."""
        if not self._url:
            self._workspace.notices.warn("there is no 3-D view yet", WAITING)
        elif not QDesktopServices.openUrl(QUrl(self._url)):
            self._workspace.notices.warn(
                "no browser could be opened", f"Open {self._url} in one by hand."
            )

    def wake(self) -> None:
        """Load the web engine, if it is needed by now; the window stands still for that."""
        if self._web is not None or self._missing or not self._url or not self.isVisible():
            return
        try:
            self._web = self._load()()
        except WorkbenchError as error:
            self._missing = str(error)
        else:
            self._web.setAccessibleName("Meshcat")
            self._web.setAcceptDrops(False)  # files are for the window; the page would show them
            self._layout.addWidget(self._web)
            self._open()
        self._show()

    def close_view(self) -> None:
        """End the web engine's page."""
        web, self._web = self._web, None
        if web is not None:
            self._layout.removeWidget(web)
            web.close()
            web.deleteLater()

    def showEvent(self, event: object) -> None:
        QTimer.singleShot(0, self.wake)  # once the window is painted

    def _follow(self, view: LiveView) -> None:
        """Show the page of another flight; tell where the picture costs it its time."""
        self._watch_pace(view)
        url = "" if view.phase is Phase.ENDED else view.url
        words = self._words_for(view)
        if url == self._url and words == self._words.text():
            return
        self._url = url
        self._open()
        self._show()
        QTimer.singleShot(0, self.wake)

    def _watch_pace(self, view: LiveView) -> None:
        slow = view.pace is not None and view.pace.too_slow and view.phase is Phase.FLYING
        if not slow or self._web is None or not self.isVisible():
            self._slow_since = math.inf
            return
        now = time.monotonic()
        self._slow_since = min(self._slow_since, now)
        if now - self._slow_since > TOO_SLOW and not self._told_slow:
            self._told_slow = True  # once, as some like it slow
            self._workspace.notices.warn(
                "the flight is slower than real time while its 3-D view is drawn here",
                "Hide the 3-D view (Ctrl+0), or open it in the browser.",
            )

    def _open(self) -> None:
        if self._web is not None:
            self._web.setUrl(QUrl(self._url or "about:blank"))  # type: ignore[attr-defined]

    def _show(self) -> None:
        self._words.setText(self._words_for(self._workspace.flight.view))
        self._browse.setVisible(bool(self._url))
        shown = self._web if self._web is not None and self._url else self._page
        self._layout.setCurrentWidget(shown)

    def _words_for(self, view: LiveView) -> str:
        if view.phase is Phase.ENDED:
            return ENDED
        if view.snapshot is None:
            return WAITING
        if not view.url:
            return NOT_DRAWN
        return self._missing or "Loading the 3-D view ..."
