"""The 3-D view beside any screen, and a plain one drawn by Qt where no 3-D engine works."""

import importlib
import json
import math
import os
import re
import time
from collections import deque
from collections.abc import Callable, Iterable, Mapping, MutableMapping, Set
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
from PyQt6.QtCore import QEvent, QObject, QPointF, QSize, Qt, QTimer, QUrl
from PyQt6.QtGui import (
    QAction,
    QColor,
    QDesktopServices,
    QHideEvent,
    QImage,
    QPainter,
    QPaintEvent,
    QPen,
    QPolygonF,
    QShowEvent,
    QWheelEvent,
)
from PyQt6.QtWidgets import (
    QSizePolicy,
    QStackedLayout,
    QToolButton,
    QWidget,
)

from workbench.common.errors import WorkbenchError
from workbench.common.system_libraries import remedy
from workbench.gui.cloud_rays import CloudRays, find_rays, newest_points
from workbench.gui.labels import Label
from workbench.gui.layout import NO_MARGINS, FlowLayout, button, label, menu_button, named, vbox
from workbench.gui.poses import Viewpoint, rotation_of
from workbench.gui.style import dressed
from workbench.gui.theme import Look
from workbench.gui.view3d.scene import Track
from workbench.gui.workspace import Workspace
from workbench.live.arrows import STILL, arrows, disc_radius
from workbench.live.messages import Phase
from workbench.live.view import LiveView
from workbench.plant.vehicle import Vehicle
from workbench.plant.worlds.outline import Outline
from workbench.session.snapshot import Snapshot

PERIOD = 1 / 15
"""Period between pictures [s of wall]: the flight has priority."""
TRAIL_TIME = 30.0
"""Length of the drawn path [s]."""
SPANS = (1.0, 100.0)
"""Smallest and largest visible height [m]."""
MOST_POINTS = 1000
"""Largest number of drawn points of a cloud or a path."""
MOST_EDGES = 6
"""Largest number of drawn vertical edges of an obstacle."""
GRID_LINES = 10
"""Number of ground lines on each side of the drone."""
ROUND = np.linspace(0.0, 2.0 * math.pi, 17)
HEAD = 5.0
"""Length of an arrow's head [px]."""
ELEVATION = math.radians(20.0)


class PlainView(QWidget):
    """Shows drone, ground, obstacles, trail, thrusts, wind and lidar in parallel projection.

    It also shows a predicted path, and a replayed log beside the flight, which the picture then
    follows.

    Args:
        look: source of colours.
    """

    def __init__(self, look: Look) -> None:
        super().__init__()
        self.setAccessibleName("Plain view of the flight")
        self.setSizePolicy(QSizePolicy.Policy.Expanding, QSizePolicy.Policy.Expanding)
        self.setMinimumHeight(120)
        self._look = look
        self._way = self._turn = "reset"
        self._span = 4.0
        self._parts = {"trail", "arrows", "lidar"}
        self._outlines: tuple[Outline, ...] = ()
        self._cloud: np.ndarray | None = None
        self._track: Track | None = None
        self._replayed: np.ndarray | None = None
        self._ahead, self._ahead_ends = np.empty((0, 3)), -math.inf
        self._middle, self._yaw = np.zeros(3), 0.0
        self._vehicle: Vehicle | None = None
        self._now: Snapshot | None = None
        self._trail: deque[tuple[float, tuple[float, float, float]]] = deque()
        self._drawn = 0.0
        look.changed.connect(self.update)

    def sizeHint(self) -> QSize:
        """Return a comfortable size."""
        return QSize(360, 300)

    def show_view(self, view: LiveView, cloud: np.ndarray | None = None) -> None:
        """Show a view; drawn about fifteen times a second.

        Args:
            view: view of the flight.
            cloud: points of the lidar's returns, in W (N, 3) [m]; None without a lidar.
        """
        now = view.snapshot
        if now is None or view.vehicle is None:
            return
        if self._now is not None and now.time < self._now.time:
            self._trail.clear()
        self._vehicle, self._now = view.vehicle, now
        self._outlines, self._cloud = view.outlines, cloud
        self._stand()
        if not self._trail or now.time - self._trail[-1][0] >= PERIOD:
            self._trail.append((now.time, now.p_WB))
        while self._trail[0][0] < now.time - TRAIL_TIME:
            self._trail.popleft()
        wall = time.monotonic()
        if self.isVisible() and wall - self._drawn >= PERIOD:
            self._drawn = wall
            self.update()

    def look(self, way: str) -> None:
        """Look from behind the drone (follow), from the top, from the south (side), or obliquely.

        With "free" the picture does not follow the drone; the wheel zooms.
        """
        self._turn = self._turn if way == "free" else way
        self._way = way
        self._stand()
        if way == "reset":
            self._span = 4.0
        self.update()

    def show_parts(self, parts: Set[str]) -> None:
        """Show some of trail, arrows and lidar."""
        self._parts = set(parts)
        self.update()

    def show_track(self, track: Track | None) -> None:
        """Show the path of a log, or none."""
        self._track = track
        self.update()

    def show_replay(self, pose: np.ndarray | None) -> None:
        """Show the drone of a log at a pose in W (4, 4) [m], and follow it; None hides it."""
        self._replayed = pose
        self._stand()
        self.update()

    def foresee(self, ends: float, places: np.ndarray) -> None:
        """Show a predicted path (N, 3) [m], until its end [s]."""
        self._ahead_ends, self._ahead = ends, places
        self.update()

    def _stand(self) -> None:
        """Centre the picture on the followed drone."""
        if self._way == "free":
            return
        if self._replayed is not None:
            self._middle = self._replayed[:3, 3]
            self._yaw = math.atan2(self._replayed[1, 0], self._replayed[0, 0])
        elif self._now is not None:
            self._middle = np.array(self._now.p_WB)
            self._yaw = self._now.roll_pitch_yaw[2]

    def axes(self) -> np.ndarray:
        """Return the picture's right and up directions, as rows in W (2, 3)."""
        quarter = 0.5 * math.pi
        turn, tilt = {
            "top": (quarter, quarter),
            "side": (quarter, 0.0),
            "follow": (self._yaw, ELEVATION),
        }.get(self._turn, (math.radians(50.0), ELEVATION))
        return Viewpoint(turn, tilt).axes()[:2]

    def points(self, p_W: np.ndarray) -> list[QPointF]:
        """Return the positions of points in W (N, 3) in the widget."""
        scale = self.height() / self._span
        x, y = self.axes() @ (np.asarray(p_W, dtype=float) - self._middle).T * scale
        middle = QPointF(self.width() / 2.0, self.height() / 2.0)
        return [middle + QPointF(float(a), -float(b)) for a, b in zip(x, y, strict=True)]

    def wheelEvent(self, event: QWheelEvent | None) -> None:
        """Zoom in or out."""
        assert event is not None
        factor = 0.8 if event.angleDelta().y() > 0 else 1.25
        self._span = min(max(self._span * factor, SPANS[0]), SPANS[1])
        self.update()
        event.accept()

    def paintEvent(self, event: QPaintEvent | None) -> None:
        """Paint everything."""
        painter = QPainter(self)
        painter.fillRect(self.rect(), self._look.colour("field"))
        if self._now is None or self._vehicle is None:
            return
        painter.setRenderHint(QPainter.RenderHint.Antialiasing)
        self._paint_ground(painter, self._now)
        for outline in self._outlines:
            self._paint_obstacle(painter, outline.at(self._now.time))
        if "lidar" in self._parts and self._cloud is not None and len(self._cloud):
            painter.setPen(QPen(self._look.colour("bad"), 2.0))
            thinned = self._cloud[:: 1 + len(self._cloud) // MOST_POINTS]
            painter.drawPoints(QPolygonF(self.points(thinned)))
        if "trail" in self._parts:
            self._paint_way(painter, np.array([p for _, p in self._trail]), self._look.curve(0))
        if self._now.time <= self._ahead_ends:
            self._paint_way(painter, self._ahead, self._look.colour("command"))
        if self._replayed is not None and self._track is not None:
            self._paint_replayed(painter, self._replayed, self._track, self._vehicle)
        self._paint_drone(painter, self._now, self._vehicle)
        self._paint_words(painter, self._now)

    def _paint_way(self, painter: QPainter, places: np.ndarray, colour: QColor) -> None:
        if len(places) > 1:
            painter.setPen(QPen(colour, 1.5))
            painter.drawPolyline(QPolygonF(self.points(places)))

    def _paint_obstacle(self, painter: QPainter, outline: Outline) -> None:
        """Draw its upper and lower edges, and the vertical edges between them."""
        corners = np.array(outline.corners)
        rims = [
            self.points(np.column_stack([corners, np.full(len(corners), height)]))
            for height in (outline.low, outline.high)
        ]
        painter.setBrush(Qt.BrushStyle.NoBrush)
        painter.setPen(QPen(self._look.colour("muted"), 1.0))
        for rim in rims:
            painter.drawPolygon(QPolygonF(rim))
        step = 1 + len(corners) // MOST_EDGES
        for below, above in zip(rims[0][::step], rims[1][::step], strict=True):
            painter.drawLine(below, above)

    def _paint_replayed(
        self, painter: QPainter, pose: np.ndarray, track: Track, vehicle: Vehicle
    ) -> None:
        """Draw a log's path, and the rotor discs of its drone."""
        colour = QColor(self._look.colour("warning"))
        self._paint_way(painter, track.p_WB[:: 1 + len(track.p_WB) // MOST_POINTS], colour)
        R_WB, p_WB = pose[:3, :3], pose[:3, 3]
        hubs = np.array([rotor.p_BR for rotor in vehicle.rotors]) @ R_WB.T + p_WB
        for hub in hubs:
            painter.drawLine(*self.points(np.array([p_WB, hub])))
            painter.drawPolygon(QPolygonF(self.points(hub + _disc(vehicle) @ R_WB.T)))

    def _paint_ground(self, painter: QPainter, now: Snapshot) -> None:
        """Draw lines on the ground, and the drone's height above it."""
        painter.setPen(QPen(self._look.colour("line"), 1.0))
        step = 10.0 ** math.floor(math.log10(self._span))
        x, y = (step * round(each / step) for each in now.p_WB[:2])
        reach = GRID_LINES * step
        for index in range(-GRID_LINES, GRID_LINES + 1):
            way = index * step
            for ends in (
                ((x + way, y - reach, 0.0), (x + way, y + reach, 0.0)),
                ((x - reach, y + way, 0.0), (x + reach, y + way, 0.0)),
            ):
                painter.drawLine(*self.points(np.array(ends)))
        painter.setPen(QPen(self._look.colour("muted"), 1.0, Qt.PenStyle.DotLine))
        below = (now.p_WB[0], now.p_WB[1], 0.0)
        painter.drawLine(*self.points(np.array([now.p_WB, below])))

    def _paint_drone(self, painter: QPainter, now: Snapshot, vehicle: Vehicle) -> None:
        R_WB = rotation_of(now.q_WB)
        hubs = np.array([rotor.p_BR for rotor in vehicle.rotors]) @ R_WB.T + now.p_WB
        centre = R_WB @ np.asarray(vehicle.p_BoBcm_B) + now.p_WB
        disc = _disc(vehicle) @ R_WB.T
        ink = self._look.colour("ink")
        for hub in hubs:
            painter.setBrush(Qt.BrushStyle.NoBrush)
            painter.setPen(QPen(ink, 2.5))
            painter.drawLine(*self.points(np.array([centre, hub])))
            painter.setPen(QPen(self._look.colour("accent"), 1.5))
            painter.drawPolygon(QPolygonF(self.points(hub + disc)))
        nose = centre + R_WB[:, 0] * 2.0 * disc_radius(vehicle)
        painter.setPen(QPen(self._look.colour("bad"), 2.5))
        painter.drawLine(*self.points(np.array([centre, nose])))
        if "arrows" in self._parts:
            *thrusts, wind = zip(*arrows(vehicle, now), strict=True)
            for ends in thrusts:
                self._paint_arrow(painter, *ends, self._look.colour("good"))
            self._paint_arrow(painter, *wind, self._look.colour("warning"))

    def _paint_arrow(
        self, painter: QPainter, tail: np.ndarray, tip: np.ndarray, colour: QColor
    ) -> None:
        start, end = self.points(np.array([tail, tip]))
        way = end - start
        length = math.hypot(way.x(), way.y())
        painter.setPen(QPen(colour, 1.8))
        painter.drawLine(start, end)
        if length > HEAD:
            along = way * (HEAD / length)
            for side in (-0.5, 0.5):
                across = QPointF(-along.y(), along.x()) * side
                painter.drawLine(end, end - along + across)

    def _paint_words(self, painter: QPainter, now: Snapshot) -> None:
        east, north, up = (round(each, 1) + 0.0 for each in now.p_WB)  # no minus before 0.0
        wind = float(np.linalg.norm(now.wind))
        said = f"east {east:.1f} m, north {north:.1f} m, height {up:.1f} m"
        if wind > STILL:
            said += f", wind {wind:.1f} m/s"
        box = self.rect().adjusted(8, 6, -8, -6)
        how = Qt.AlignmentFlag.AlignLeft | Qt.AlignmentFlag.AlignBottom | Qt.TextFlag.TextWordWrap
        plate = painter.boundingRect(box, int(how), said)
        painter.fillRect(plate.adjusted(-4, -2, 4, 2), self._look.colour("field"))
        painter.setPen(self._look.colour("muted"))
        painter.drawText(box, int(how), said)


def _disc(vehicle: Vehicle) -> np.ndarray:
    """Return the edge of a rotor's disc around its hub, in B (N, 3) [m]."""
    circle = np.column_stack([np.cos(ROUND), np.sin(ROUND), np.zeros_like(ROUND)])
    rim: np.ndarray = disc_radius(vehicle) * circle
    return rim


FLAGS = "QTWEBENGINE_CHROMIUM_FLAGS"
NO_SANDBOX = "--no-sandbox"
"""Chromium refuses to run as root without this option."""
ANY_GPU = "--ignore-gpu-blocklist"
"""Without this option a machine without a graphics processor shows nothing instead of slow
pictures."""
SMALL_HEAP = "--js-flags=--initial-old-space-size=16"
"""Size [MB] up to which JavaScript's heap grows before its first garbage collection.

V8's default is hundreds: each message to the page and each picture leave garbage, and the page grew
by 40 MB a minute. This is not a limit: a heap with more data grows further.
"""
GBM = "QTWEBENGINE_FORCE_USE_GBM"
RENDER_NODES = Path("/dev/dri")
MODULE = "PyQt6.QtWebEngineWidgets"
CORE = "PyQt6.QtWebEngineCore"
SCRIPT = Path(__file__).with_name("page.js")
_LIBRARY = re.compile(r"(lib\S+?\.so[.\d]*)")
NARROWEST = 240
WAITING = "The 3-D view comes with the flight."
NOT_DRAWN = (
    "This flight is not drawn. Switch the 3-D view on in Settings, then open the scenario again."
)
TOO_SLOW = 4.0
"""Wall time of a slow flight beside the picture before the user is told [s]."""
ENDED = "The flight has ended, and its 3-D view with it."
LOADING = "Loading the 3-D view ..."
FAULTS = {
    "webgl": "The 3-D view cannot draw here: its web engine finds no WebGL, as OpenGL has no "
    "driver that works. Install one (on Debian and Ubuntu `libgl1-mesa-dri`, which draws with the "
    "processor) and start again, or open the view in a browser.",
    "lost": "The 3-D view has lost its graphics memory. Try again, or open it in a browser.",
    "ended": "The process that draws the 3-D view has ended. Try again, or open it in a browser.",
    "silent": "The 3-D view does not answer. Try again, or open it in a browser.",
}
"""Message in place of a page, by kind of fault."""
BLANK = (
    "The 3-D view draws, but nothing is visible: start the app with "
    f"{GBM}=0 set, or open the view in a browser."
)
MOST_PLACES = 2000
"""Largest number of drawn points of a log's path."""
TICK = 1000
"""Period between checks of the page [ms]."""
PATIENCE = 20.0
"""Largest time for which a page may be silent, or draw nothing visible [s]."""
LOOKS = ("follow", "top", "side", "free", "reset")
PARTS = {"trail_3d": "trail", "arrows_3d": "arrows", "lidar_3d": "lidar"}
"""Parts that can be hidden in Meshcat, by the action that hides them."""
REPLAY_PERIOD = 33
"""Period between poses of a replayed log [ms]."""
SHAPES = ("drake", "visualizer")
"""Meshcat's path of the objects that Drake draws."""
REPLAYED = "{name}: the pale drone flies the log, and the camera follows it."
NOT_REPLAYED = "{name} has no position, so the log is not shown here: this is the flight."
NO_PAGE = "about:blank"
STATE = "window.workbench?.state()"
"""Calls the script in the page, which exists only once the page is loaded."""
GRID = 16
"""Number of sampled pixels along a side of a picture, to see whether it is blank."""


def load_web_view() -> Callable[[], Any]:
    """Return the factory of web views, whose pages run our script.

    Raises:
        WorkbenchError: if it is not installed, or a system library that it needs is missing.
    """
    prepare(os.environ, is_root=os.geteuid() == 0, draws=can_draw(RENDER_NODES.glob("renderD*")))
    try:
        module = importlib.import_module(MODULE)
        core = importlib.import_module(CORE)
    except ModuleNotFoundError as error:
        raise WorkbenchError(
            "The 3-D view needs PyQt6-WebEngine, which is not installed: run "
            "`python -m pip install PyQt6-WebEngine`, then start again."
        ) from error
    except ImportError as error:
        raise WorkbenchError(missing_library(str(error))) from error

    def make() -> Any:
        view = module.QWebEngineView()
        script = core.QWebEngineScript()
        script.setSourceCode(SCRIPT.read_text(encoding="utf-8"))
        script.setInjectionPoint(core.QWebEngineScript.InjectionPoint.DocumentCreation)
        script.setWorldId(core.QWebEngineScript.ScriptWorldId.MainWorld)
        view.page().scripts().insert(script)
        return view

    return make


def prepare(environment: MutableMapping[str, str], *, is_root: bool, draws: bool) -> None:
    """Prepare the environment for the web engine, before it is loaded; the user's values stay.

    Without a graphics processor, as in Xvfb, containers and most virtual machines, Qt still assumes
    that buffers can be shared with one (GBM) if OpenGL works, and the page stays white. With the
    right setting it draws with the processor alone.

    Args:
        environment: environment of this process.
        is_root: whether it runs as root.
        draws: whether there is a graphics processor.
    """
    flags = environment.get(FLAGS, "").split()
    names = {flag.partition("=")[0] for flag in flags}
    wanted = [ANY_GPU, SMALL_HEAP, *([NO_SANDBOX] if is_root else [])]
    environment[FLAGS] = " ".join(
        [*flags, *(each for each in wanted if each.partition("=")[0] not in names)]
    )
    if not draws:
        environment.setdefault(GBM, "0")


def can_draw(nodes: Iterable[Path]) -> bool:
    """Return whether one of these graphics devices can be used."""
    return any(os.access(node, os.R_OK | os.W_OK) for node in nodes)


def missing_library(said: str) -> str:
    """Return a sentence about the library that the system lacks, from the linker's message."""
    found = _LIBRARY.search(said)
    if not found:
        return f"The 3-D view cannot be loaded: {said}."
    return (
        f"The 3-D view needs the system library {found[1]}, which is missing: "
        f"{remedy([found[1]])}, then start again."
    )


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
        self.setMinimumWidth(NARROWEST)
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
        self._timer.setInterval(TICK)
        self._timer.timeout.connect(self._look_at_page)
        self._rays: CloudRays | None = None
        workspace.flight.begun.connect(self._begin)
        workspace.flight.viewed.connect(self._follow)
        workspace.look.changed.connect(self.show_ground)
        self._replay_timer = QTimer(self)
        self._replay_timer.setSingleShot(True)
        self._replay_timer.setInterval(REPLAY_PERIOD)
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
            self._workspace.notices.warn("there is no 3-D view yet", WAITING)
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
        shown = {part: self._actions[name].isChecked() for name, part in PARTS.items()}
        self.plain.show_parts({part for part, checked in shown.items() if checked})
        for part, checked in shown.items():
            self._run(f"window.workbench?.show({json.dumps(part)}, {json.dumps(checked)})")

    def show_log(self) -> None:
        """Show the drone of a replayed log, or none."""
        scene = self._workspace.scene
        track, vehicle = scene.track, self._workspace.flight.view.vehicle
        self.plain.show_track(track)
        words = NOT_REPLAYED if track is None else REPLAYED
        self._log_line.setText(words.format(name=scene.log))
        self._log_line.setVisible(bool(scene.log))
        if track is not None and vehicle is not None:
            thinned = track.p_WB[:: 1 + len(track.p_WB) // MOST_PLACES]
            names = f"{vehicle.name}::{vehicle.base_link}".split("::")
            shape = json.dumps([*SHAPES, *names])
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
        flight = self._workspace.flight
        if flight.live is not None and flight.view.url:
            flight.order(lambda live: live.foresee(ends, places))

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
        if now - self._slow_since > TOO_SLOW and not self._told_slow:
            self._told_slow = True  # once only, as some users want it slow
            self._workspace.notices.warn(
                "the flight is slower than real time while its 3-D view is drawn here",
                "Hide the 3-D view (Ctrl+0), or open it in the browser.",
            )

    def _open(self) -> None:
        """Load the page that should be visible now."""
        if self._web is None:
            return
        url = self._url if self.isVisible() and self._url else NO_PAGE
        if url == self._open_url:
            return
        self._open_url = url
        self._pictures = 0
        self._heard = self._seen = time.monotonic()
        self._is_blank = False
        self._web.setUrl(QUrl(url))
        if url == NO_PAGE:
            self._timer.stop()
        else:
            self._timer.start()

    def _run(self, code: str, answered: Callable[[Any], None] = lambda answer: None) -> None:
        """Run a line of JavaScript in the page, if there is one."""
        if self._web is not None and self._open_url != NO_PAGE:
            self._web.page().runJavaScript(code, answered)

    def _look_at_page(self) -> None:
        """Ask the page for its state; a page that hangs does not answer."""
        proxy = self._web.focusProxy() if self._web is not None else None
        if proxy is not None:  # the page replaces it now and then
            proxy.setFocusPolicy(Qt.FocusPolicy.NoFocus)
            proxy.installEventFilter(self)
        if time.monotonic() - self._heard > PATIENCE:
            self._fail("silent")
        self._run(STATE, partial(self._hear, self._open_url))

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
        self._is_blank = time.monotonic() - self._seen > PATIENCE

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
            return ENDED
        if view.snapshot is None:
            return WAITING
        if not view.url:
            return NOT_DRAWN
        return self._missing or FAULTS.get(self._fault, LOADING)

    def _lay_out(self) -> None:
        self._words, self._address = label(kind="muted", wraps=True), Label()
        for line in (self._words, self._address):
            line.setAlignment(Qt.AlignmentFlag.AlignCenter)
            line.setTextInteractionFlags(Qt.TextInteractionFlag.TextSelectableByMouse)
        self._again = button("&Try again", self.reload)
        self._browse = button("Open in the &browser", self.browse)
        self.plain = PlainView(self._workspace.look)
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
            lambda menu: menu.addActions(self._actions[name] for name in PARTS),
        )
        named(shown, "Show trail, arrows or lidar points")
        ways = {way: QToolButton() for way in LOOKS}
        for way, each in ways.items():
            each.setDefaultAction(self._actions[f"look_{way}"])
        for each in (*ways.values(), shown):
            dressed(each, "quiet compact").setFocusPolicy(Qt.FocusPolicy.TabFocus)
            bar.addWidget(each)
        self._strip = label(BLANK, "warning", wraps=True)
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
    small = image.scaled(GRID, GRID)
    return len({small.pixel(x, y) for x in range(GRID) for y in range(GRID)}) <= 1
