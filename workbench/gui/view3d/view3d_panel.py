"""The 3-D view beside any screen: Meshcat's page of the present flight."""

import json
import math
import time
from collections.abc import Callable, Mapping
from functools import partial
from typing import Any

import numpy as np
from PyQt6.QtCore import QEvent, QObject, Qt, QTimer, QUrl
from PyQt6.QtGui import (
    QAction,
    QDesktopServices,
    QHideEvent,
    QImage,
    QShowEvent,
)
from PyQt6.QtWidgets import (
    QStackedLayout,
    QToolButton,
    QWidget,
)

from workbench.common.errors import WorkbenchError
from workbench.gui.cloud_rays import CloudRays, find_rays, newest_points
from workbench.gui.flow_layout import FlowLayout
from workbench.gui.labels import Label
from workbench.gui.layout import NO_MARGINS, button, label, menu_button, named, vbox
from workbench.gui.style import with_class
from workbench.gui.view3d.plain_view import PlainView
from workbench.gui.view3d.web_engine import FORCE_GBM_VARIABLE, load_web_view
from workbench.gui.workspace import Workspace
from workbench.live.messages import Phase
from workbench.live.orders import ShowPrediction
from workbench.live.view import LiveView

MIN_VIEW3D_WIDTH_PX = 240
VIEW_WAITING_TEXT = "The 3-D view comes with the flight."
NOT_DRAWN_TEXT = (
    "This flight is not drawn. Switch the 3-D view on in Settings, then open the scenario again."
)
SLOW_VIEW_DELAY_S = 4.0
"""Wall time of a slow flight beside the picture before the user is told [s]."""
VIEW_ENDED_TEXT = "The flight has ended, and its 3-D view with it."
VIEW_LOADING_TEXT = "Loading the 3-D view ..."
PAGE_FAULT_TEXTS = {
    "webgl": "The 3-D view cannot draw here: its web engine finds no WebGL, as OpenGL has no "
    "driver that works. Install one (on Debian and Ubuntu `libgl1-mesa-dri`, which draws with the "
    "processor) and start again, or open the view in a browser.",
    "lost": "The 3-D view has lost its graphics memory. Try again, or open it in a browser.",
    "ended": "The process that draws the 3-D view has ended. Try again, or open it in a browser.",
    "silent": "The 3-D view does not answer. Try again, or open it in a browser.",
}
"""Message in place of a page, by kind of fault."""
BLANK_VIEW_TEXT = (
    "The 3-D view draws, but nothing is visible: start the app with "
    f"{FORCE_GBM_VARIABLE}=0 set, or open the view in a browser."
)
MAX_LOG_PATH_POINTS = 2000
"""Largest number of drawn points of a log's path."""
PAGE_POLL_MS = 1000
"""Period between checks of the page [ms]."""
PAGE_TIMEOUT_S = 20.0
"""Largest time for which a page may be silent, or draw nothing visible [s]."""
CAMERA_VIEWS = ("follow", "top", "side", "free", "reset")
HIDABLE_PARTS = {"trail_3d": "trail", "arrows_3d": "arrows", "lidar_3d": "lidar"}
"""Parts that can be hidden in Meshcat, by the action that hides them."""
REPLAY_PERIOD_MS = 33
"""Period between poses of a replayed log [ms]."""
DRAWN_SHAPES_PATH = ("drake", "visualizer")
"""Meshcat's path of the objects that Drake draws."""
LOG_REPLAYED_TEXT = "{name}: the pale drone flies the log, and the camera follows it."
LOG_NOT_REPLAYED_TEXT = "{name} has no position, so the log is not shown here: this is the flight."
BLANK_PAGE_URL = "about:blank"
PAGE_STATE_SCRIPT = "window.workbench?.state()"
"""Calls the script in the page, which exists only once the page is loaded."""
BLANK_CHECK_PIXELS = 16
"""Number of sampled pixels along a side of a picture, to see whether it is blank."""


class View3d(QWidget):
    """Meshcat's page of the present flight, or why there is none; the web engine is loaded last.

    A hidden view has no page, because a page costs the machine as much as a visible one.

    Args:
        workspace: has the flight.
        actions: actions of the camera and the trail, shown above the picture.
        load: returns the factory of web views.
    """

    def __init__(
        self,
        workspace: Workspace,
        actions: Mapping[str, QAction],
        load: Callable[[], Callable[[], Any]] = load_web_view,
    ) -> None:
        super().__init__()
        self.setAccessibleName("3-D view of the flight")
        self.setMinimumWidth(MIN_VIEW3D_WIDTH_PX)
        self._workspace, self._actions, self._load = workspace, actions, load
        self._web: Any = None
        self._missing = self._fault = ""
        self._url = self._open_url = ""
        self._way = "reset"
        self._pictures = 0
        self._heard = self._seen = 0.0
        self._is_blank = False
        self._slow_since = math.inf
        self._told_slow = False
        self._lay_out()
        self._timer = QTimer(self)
        self._timer.setInterval(PAGE_POLL_MS)
        self._timer.timeout.connect(self._look_at_page)
        self._rays: CloudRays | None = None
        workspace.flight.begun.connect(self._begin)
        workspace.flight.viewed.connect(self._follow)
        workspace.look.changed.connect(self.show_ground)
        self._replay_timer = QTimer(self)
        self._replay_timer.setSingleShot(True)
        self._replay_timer.setInterval(REPLAY_PERIOD_MS)
        self._replay_timer.timeout.connect(self._show_replay)
        workspace.scene.log_changed.connect(self.show_log)
        workspace.scene.replayed.connect(self._replay)
        workspace.scene.foreseen.connect(self._foresee)
        self._show()

    @property
    def said(self) -> str:
        """Text in place of the picture, or above it; "" without a problem."""
        if self._layout.currentWidget() is self._page:
            return self._words.text()
        return "" if self._strip.isHidden() else self._strip.text()

    def browse(self) -> None:
        """Open the page in the browser."""
        if not self._url:
            self._workspace.notices.warn("there is no 3-D view yet", VIEW_WAITING_TEXT)
        elif not QDesktopServices.openUrl(QUrl(self._url)):
            self._workspace.notices.warn(
                "no browser could be opened", f"Open {self._url} in one by hand."
            )

    def look(self, way: str) -> None:
        """Let the camera follow the drone, look from the top or a side, or reset it."""
        self._way = way
        self.plain.look(way)
        if way == "reset" and self._fault:
            self.reload()
        else:
            self._run(f"window.workbench?.look({json.dumps(way)})")

    def show_parts(self) -> None:
        """Show or hide the flown path and other parts, by the actions' check marks."""
        shown = {part: self._actions[name].isChecked() for name, part in HIDABLE_PARTS.items()}
        self.plain.show_parts({part for part, checked in shown.items() if checked})
        for part, checked in shown.items():
            self._run(f"window.workbench?.show({json.dumps(part)}, {json.dumps(checked)})")

    def show_log(self) -> None:
        """Show the drone of a replayed log, or none."""
        scene = self._workspace.scene
        track, vehicle = scene.track, self._workspace.flight.view.vehicle
        self.plain.show_track(track)
        words = LOG_NOT_REPLAYED_TEXT if track is None else LOG_REPLAYED_TEXT
        self._log_line.setText(words.format(name=scene.log))
        self._log_line.setVisible(bool(scene.log))
        if track is not None and vehicle is not None:
            thinned = track.p_WB[:: 1 + len(track.p_WB) // MAX_LOG_PATH_POINTS]
            names = f"{vehicle.name}::{vehicle.base_link}".split("::")
            shape = json.dumps([*DRAWN_SHAPES_PATH, *names])
            places = json.dumps(thinned.round(3).ravel().tolist())
            self._run(f"window.workbench?.log({shape}, {places})")
        self._show_replay()

    def _replay(self) -> None:
        """Show a log's time soon, together with later requests."""
        if not self._replay_timer.isActive():
            self._replay_timer.start()

    def _show_replay(self) -> None:
        scene = self._workspace.scene
        pose = None if scene.track is None else scene.track.at(scene.time)
        self.plain.show_replay(pose)
        columns = None if pose is None else pose.T.round(5).ravel().tolist()
        self._run(f"window.workbench?.replay({json.dumps(columns)})")

    def _foresee(self, ends: float, places: np.ndarray) -> None:
        """Show a predicted path in all pages of the flight, and in the plain view."""
        self.plain.foresee(ends, places)
        if self._workspace.flight.live is not None and self._workspace.flight.view.url:
            self._workspace.flight.do(ShowPrediction(ends, places))

    def show_ground(self) -> None:
        """Give the page the theme's brightness."""
        colours = [self._workspace.look.colour(name) for name in ("field", "card")]
        parts = json.dumps([[c.redF(), c.greenF(), c.blueF()] for c in colours])
        self._run(f"window.workbench?.background(...{parts})")

    def reload(self) -> None:
        """Reload the page."""
        self._fault = ""
        self._open_url = ""
        self._open()
        self._show()

    def wake(self) -> None:
        """Load the web engine if it is needed now; the window is blocked meanwhile."""
        if self._missing or not self._url or not self.isVisible():
            return
        if self._web is None:
            try:
                self._web = web = self._load()()
            except WorkbenchError as error:
                self._missing = str(error)
            else:
                web.setAccessibleName("Meshcat")
                web.setAcceptDrops(False)  # the window opens files; the page would show them
                web.setFocusPolicy(Qt.FocusPolicy.NoFocus)
                web.setContextMenuPolicy(Qt.ContextMenuPolicy.NoContextMenu)
                web.renderProcessTerminated.connect(lambda *_: self._fail("ended"))
                self._layout.addWidget(web)
        self._open()
        self._show()

    def close_view(self) -> None:
        """Close the web engine's page."""
        self._timer.stop()
        web, self._web = self._web, None
        if web is not None:
            self._layout.removeWidget(web)
            web.close()
            web.deleteLater()

    def showEvent(self, event: QShowEvent | None) -> None:
        QTimer.singleShot(0, self.wake)  # once the window is painted

    def hideEvent(self, event: QHideEvent | None) -> None:
        self._open()

    def eventFilter(self, watched: QObject | None, event: QEvent | None) -> bool:
        """Keep keys from the page: they fly the drone, and some have another meaning there."""
        kinds = (QEvent.Type.KeyPress, QEvent.Type.KeyRelease)
        if event is not None and event.type() in kinds:
            event.ignore()  # for the window around the page
            return True
        return super().eventFilter(watched, event)

    def _follow(self, view: LiveView) -> None:
        """Show the page of another flight; report if drawing slows the flight."""
        self.plain.show_view(view, self._cloud() if self.plain.isVisible() else None)
        self._watch_pace(view)
        url = "" if view.phase is Phase.ENDED else view.url
        words = self._words_for(view)
        if url == self._url and words == self._words.text():
            return
        if url != self._url:
            self._fault = ""
        self._url = url
        self._open()
        self._show()
        QTimer.singleShot(0, self.wake)

    def _cloud(self) -> np.ndarray | None:
        """Return the points of the lidar's returns, in W (N, 3) [m]; None without a lidar."""
        workspace = self._workspace
        if self._rays is None or not self._actions["lidar_3d"].isChecked():
            return None
        return newest_points(workspace.signals, self._rays)

    def _begin(self, view: LiveView) -> None:
        """Note the flight's lidar, and the replayed drone."""
        self._rays = find_rays(view.topics)
        if self._workspace.scene.log:
            self.show_log()

    def _watch_pace(self, view: LiveView) -> None:
        slow = view.pace is not None and view.pace.too_slow and view.phase is Phase.FLYING
        if not slow or self._web is None or not self.isVisible():
            self._slow_since = math.inf
            return
        now = time.monotonic()
        self._slow_since = min(self._slow_since, now)
        if now - self._slow_since > SLOW_VIEW_DELAY_S and not self._told_slow:
            self._told_slow = True  # once only, as some users want it slow
            self._workspace.notices.warn(
                "the flight is slower than real time while its 3-D view is drawn here",
                "Hide the 3-D view (Ctrl+0), or open it in the browser.",
            )

    def _open(self) -> None:
        """Load the page that should be visible now."""
        if self._web is None:
            return
        url = self._url if self.isVisible() and self._url else BLANK_PAGE_URL
        if url == self._open_url:
            return
        self._open_url = url
        self._pictures = 0
        self._heard = self._seen = time.monotonic()
        self._is_blank = False
        self._web.setUrl(QUrl(url))
        if url == BLANK_PAGE_URL:
            self._timer.stop()
        else:
            self._timer.start()

    def _run(self, code: str, answered: Callable[[Any], None] = lambda answer: None) -> None:
        """Run a line of JavaScript in the page, if there is one."""
        if self._web is not None and self._open_url != BLANK_PAGE_URL:
            self._web.page().runJavaScript(code, answered)

    def _look_at_page(self) -> None:
        """Ask the page for its state; a page that hangs does not answer."""
        proxy = self._web.focusProxy() if self._web is not None else None
        if proxy is not None:  # the page replaces it now and then
            proxy.setFocusPolicy(Qt.FocusPolicy.NoFocus)
            proxy.installEventFilter(self)
        if time.monotonic() - self._heard > PAGE_TIMEOUT_S:
            self._fail("silent")
        self._run(PAGE_STATE_SCRIPT, partial(self._hear, self._open_url))

    def _hear(self, url: str, answer: object) -> None:
        """Handle the page's state."""
        if url != self._open_url or not isinstance(answer, str) or not answer or self._web is None:
            return
        state = json.loads(answer)
        self._heard = time.monotonic()
        if state["fault"]:
            self._fail(state["fault"])
            return
        if self._fault == "silent":
            self._fault = ""
            self._show()
        began = state["connected"] and not self._pictures
        if state["connected"]:
            self._pictures = state["pictures"]
        if began:
            self._run(f"window.workbench?.look({json.dumps(self._way)})")
            self.show_parts()
            self.show_ground()
            if self._workspace.scene.log:
                self.show_log()
        self._see()
        self._show()

    def _see(self) -> None:
        """Check repeatedly whether the page's picture is visible, until it is."""
        if (
            not self._pictures
            or self._seen == math.inf
            or self._layout.currentWidget() is self._page
        ):
            return
        if not is_blank(self._web.grab().toImage()):
            self._seen = math.inf
        self._is_blank = time.monotonic() - self._seen > PAGE_TIMEOUT_S

    def _fail(self, fault: str) -> None:
        """Show a fault in place of the page."""
        if fault != self._fault:
            self._fault = fault
            self._show()

    def _show(self) -> None:
        self._words.setText(self._words_for(self._workspace.flight.view))
        self._address.setText(self._url)
        self._address.setVisible(bool(self._url))
        self._browse.setVisible(bool(self._url))
        self._again.setVisible(bool(self._fault))
        self._strip.setVisible(self._is_blank)
        shown = self._web if self._web is not None and self._url and not self._fault else self._page
        self._layout.setCurrentWidget(shown)
        view = self._workspace.flight.view
        flies = view.snapshot is not None and view.phase is not Phase.ENDED
        instead = flies and (not view.url or bool(self._missing or self._fault))
        instead &= shown is self._page
        self.plain.setVisible(instead)
        self._bar.setVisible(shown is not self._page or instead)

    def _words_for(self, view: LiveView) -> str:
        if view.phase is Phase.ENDED:
            return VIEW_ENDED_TEXT
        if view.snapshot is None:
            return VIEW_WAITING_TEXT
        if not view.url:
            return NOT_DRAWN_TEXT
        return self._missing or PAGE_FAULT_TEXTS.get(self._fault, VIEW_LOADING_TEXT)

    def _lay_out(self) -> None:
        self._words, self._address = label(kind="muted", wraps=True), Label()
        for line in (self._words, self._address):
            line.setAlignment(Qt.AlignmentFlag.AlignCenter)
            line.setTextInteractionFlags(Qt.TextInteractionFlag.TextSelectableByMouse)
        self._again = button("&Try again", self.reload)
        self._browse = button("Open in the &browser", self.browse)
        self.plain = PlainView(self._workspace.look, self._workspace.preferences)
        self._page = QWidget()
        vbox(
            (self.plain, 4),
            1,
            self._words,
            self._address,
            (self._again, Qt.AlignmentFlag.AlignHCenter),
            (self._browse, Qt.AlignmentFlag.AlignHCenter),
            1,
            of=self._page,
            margins=(12, 12, 12, 12),
        )
        self._bar = QWidget()
        bar = FlowLayout(self._bar, spacing=2)
        bar.setContentsMargins(4, 2, 4, 2)
        shown = menu_button(
            "Show \N{BLACK DOWN-POINTING SMALL TRIANGLE}",
            "What is shown besides the drone",
            lambda menu: menu.addActions(self._actions[name] for name in HIDABLE_PARTS),
        )
        named(shown, "Show trail, arrows or lidar points")
        ways = {way: QToolButton() for way in CAMERA_VIEWS}
        for way, each in ways.items():
            each.setDefaultAction(self._actions[f"look_{way}"])
        for each in (*ways.values(), shown):
            with_class(each, "quiet compact").setFocusPolicy(Qt.FocusPolicy.TabFocus)
            bar.addWidget(each)
        self._strip = label(BLANK_VIEW_TEXT, "warning", wraps=True)
        self._strip.setTextInteractionFlags(Qt.TextInteractionFlag.TextSelectableByMouse)
        self._strip.hide()
        self._log_line = label(kind="muted", wraps=True)
        self._log_line.setContentsMargins(8, 2, 8, 2)
        self._log_line.hide()
        stack = QWidget()
        self._layout = QStackedLayout(stack)
        self._layout.setContentsMargins(0, 0, 0, 0)
        self._layout.addWidget(self._page)
        vbox(
            self._bar,
            self._strip,
            self._log_line,
            (stack, 1),
            of=self,
            margins=NO_MARGINS,
            spacing=0,
        )


def is_blank(image: QImage) -> bool:
    """Return whether a picture has a single colour."""
    small = image.scaled(BLANK_CHECK_PIXELS, BLANK_CHECK_PIXELS)
    return (
        len(
            {
                small.pixel(x, y)
                for x in range(BLANK_CHECK_PIXELS)
                for y in range(BLANK_CHECK_PIXELS)
            }
        )
        <= 1
    )
