"""A workspace with nothing of the user's in it, a flight in a can for it to show, and a mouse."""

import threading
from collections.abc import Callable
from contextlib import contextmanager, nullcontext
from dataclasses import dataclass, replace

import numpy as np
import pytest
from PyQt6.QtCore import QEvent, QPoint, QPointF, QSettings, Qt
from PyQt6.QtGui import QMouseEvent, QWheelEvent
from PyQt6.QtTest import QTest
from PyQt6.QtWidgets import QApplication
from pytestqt.qtbot import QtBot

from workbench.analysis.questions import FlyAgain
from workbench.analysis.replies import FlownAgain
from workbench.gui.charts.chart import Chart
from workbench.gui.main_window import MainWindow
from workbench.gui.preferences import Preferences
from workbench.gui.screen_table import SCREENS
from workbench.gui.style import apply_style
from workbench.gui.workspace import make_workspace
from workbench.link.backplane import Published
from workbench.live.messages import Pace, Phase
from workbench.live.view import LiveView
from workbench.scenario.scenario import Action, Scenario, SensorsConfig
from workbench.session.session import Session
from workbench.systems.bridge import Bridge

INI = QSettings.Format.IniFormat
PATIENCE = 300_000
"""Of tests that wait for something [ms]."""


def workspace_in(folder):
    """Return a workspace whose settings go to a folder."""
    return make_workspace(Preferences(QSettings(str(folder / "settings.ini"), INI)))


def noted(workspace):
    """Return a list that fills with what the workspace tells, but that the machine is slow."""
    notices = []

    def note(notice):
        if "slower than real time" not in notice.what:
            notices.append(notice)

    workspace.notices.told.connect(note)
    return notices


@dataclass(frozen=True)
class Canned:
    """Some seconds of a flight with sensors.

    Attributes:
        views: one a sixtieth of a second.
        published: what was sampled until each of them.
    """

    views: tuple[LiveView, ...]
    published: tuple[tuple[Published, ...], ...]


@pytest.fixture(scope="session")
def canned() -> Canned:
    """3 s: hover, then 2 m/s along x, in a room."""
    scenario = Scenario(
        world="room",
        sensors=SensorsConfig(
            use=["imu", "gps", "lidar", "barometer", "range_finder", "magnetometer"]
        ),
        script=[Action(at=1.0, velocity=[2.0, 0.0, 0.0])],
    )
    bridge = Bridge()
    session = Session(scenario, bridge=bridge)
    bridge.wanted = True
    begun = LiveView(
        phase=Phase.FLYING,
        said="",
        pace=Pace(1.0, 1.0, 0.0, 0.0, False),
        vehicle=session.vehicle,
        values=session.parameters(),
        scenario=scenario,
        topics=session.topics,
    )
    views, published = [], []
    for _ in range(180):
        session.tick(1 / 60)
        views.append(replace(begun, snapshot=session.snapshot()))
        published.append(tuple(each.published for each in session.drain()))
    return Canned(tuple(views), tuple(published))


@pytest.fixture(scope="session")
def fly_again():
    """Returns a question about a logged flight, and an answer: 0.1 m to the side of it."""

    def make(question: FlyAgain, **other) -> tuple[FlyAgain, FlownAgain]:
        time = np.linspace(4.0, 24.0, 400)
        logged = np.column_stack([np.sin(time + phase) for phase in range(6)])
        values = {
            "vehicle": "dh_drone",
            "logged_vehicle": "dh_drone",
            "doubt": "",
            "flown": "pd",
            "flown_gains": {name: question.gains[name] for name in ("kp_pitch", "kp_velocity_x")},
            "setpoint": logged[:, :3],
            "other": logged + 0.1,
            "low": logged + 0.08,
            "high": logged + 0.12,
            "off_setpoint": np.array([[0.0] * 3, [0.1] * 3]),
            "difference": np.full(6, 0.1),
            "band": np.full(6, 0.02),
            "stays": True,
            "lost": 0,
            "drawn": 1 + question.draws,
        }
        return question, FlownAgain(time=time, logged=logged, **{**values, **other})

    return make


@pytest.fixture
def workspace(qapp, tmp_path):
    """A workspace without a flight; settings go to a folder of the test's own."""
    made = workspace_in(tmp_path)
    yield made
    made.close()


@pytest.fixture(scope="module")
def shared_workspace(qapp, tmp_path_factory):
    """A workspace that the tests of a file share, for windows that take seconds to make."""
    made = workspace_in(tmp_path_factory.mktemp("gui"))
    yield made
    made.close()


@pytest.fixture(scope="module")
def shared_window(request, qapp, shared_workspace, tmp_path_factory):
    """The real window with all its screens made, while nothing flies, for the tests of a file."""
    with no_thread_more():
        yield from _window(request, qapp, shared_workspace, tmp_path_factory)
        shared_workspace.close()


def _window(request, qapp, shared_workspace, tmp_path_factory):
    shared_workspace.preferences.set("log_folder", str(tmp_path_factory.mktemp("logs")))
    apply_style(qapp, shared_workspace.look)  # first: a style takes seconds where a window stands
    made = MainWindow(shared_workspace, first="home", view3d=False)
    made.show()
    made.activateWindow()
    QtBot(request).waitUntil(lambda: made.stack.name == "home", timeout=120_000)
    for row in SCREENS:
        made.stack.screen_of(row.name)
    yield made
    made.close()
    made.deleteLater()  # nor does it stand in the way of the next file's
    qapp.sendPostedEvents(made, QEvent.Type.DeferredDelete)


@pytest.fixture
def qtbot(qtbot, monkeypatch):
    """Waits long enough for a machine that others keep busy, whatever a test says."""

    def patient(wait):
        def wait_longer(*args, timeout=0, **options):
            return wait(*args, timeout=max(timeout, PATIENCE), **options)

        return wait_longer

    for name in ("waitUntil", "waitSignal"):
        monkeypatch.setattr(qtbot, name, patient(getattr(qtbot, name)))
    return qtbot


@pytest.fixture
def unasked(workspace, monkeypatch):
    """Let no screen start processes that judge what flies out of a can."""
    monkeypatch.setattr(workspace.analysis, "ask", lambda question: None)
    monkeypatch.setattr(workspace.analysis, "warm_up", lambda: None)


@pytest.fixture
def show(workspace, monkeypatch):
    """Shows a view as the flight's newest."""

    def show_view(view):
        monkeypatch.setattr(workspace.flight, "_view", view)
        workspace.flight.viewed.emit(view)

    return show_view


class Orders:
    """A live flight that notes what it is asked for."""

    def __init__(self):
        self.given = []

    def __getattr__(self, name):
        if name == "checkpoint":  # the ghost asks for it, and no key
            return lambda: None
        return lambda *args: self.given.append((name, *args))


@pytest.fixture
def orders(window, workspace, canned, unasked, monkeypatch):
    """What a flight out of a can is asked for."""
    made = Orders()
    monkeypatch.setattr(
        workspace.flight, "order", lambda give, done=None, refused=None: give(made) and None
    )
    workspace.flight.begun.emit(canned.views[0])
    return made


def view_of(canned, phase, mode):
    """Return a view of a flight in a phase and a mode."""
    view = canned.views[0]
    return replace(view, phase=phase, snapshot=replace(view.snapshot, mode=mode))


@pytest.fixture
def told(workspace):
    """All that the workspace told its user."""
    return noted(workspace)


@pytest.fixture(autouse=True)
def no_thread_is_left(request):
    """Fail a test that leaves a thread alive; a window of many tests looks when it is closed."""
    shared = "shared_window" in request.fixturenames
    with nullcontext() if shared else no_thread_more():
        yield


@contextmanager
def no_thread_more():
    before = set(threading.enumerate())
    yield
    left = [each.name for each in set(threading.enumerate()) - before if each.is_alive()]
    assert not left, f"threads left alive: {', '.join(left)}"


@pytest.fixture
def statistic():
    """Return what reads a chart's statistics: the column that begins with a name, in a row."""

    def read(chart, row, column):
        table = chart.statistics
        heads = [table.horizontalHeaderItem(index).text() for index in range(table.columnCount())]
        index = next(index for index, head in enumerate(heads) if head.startswith(column))
        return table.item(row, index).text()

    return read


class Mouse:
    """Points at times and shares of the height of a chart, as a user does."""

    def __init__(self, chart: Chart) -> None:
        self._canvas = chart.canvas
        self._widget = chart.canvas.viewport()

    def place(self, time: float, share: float = 0.5) -> QPoint:
        """The pixel of a time, in a share of the height from below."""
        QApplication.processEvents()  # a layout may be new
        content, view = self._canvas.content, self._canvas.view
        low, high = view.viewRange()[1]
        at = QPointF(time - content.origin, low + share * (high - low))
        return self._canvas.mapFromScene(view.mapViewToScene(at))

    def move(self, time: float) -> None:
        """Point at a time."""
        QTest.mouseMove(self._widget, QPoint(5, 5))
        QTest.mouseMove(self._widget, self.place(time))

    def leave(self) -> None:
        """Point at what is no curve."""
        QTest.mouseMove(self._widget, QPoint(5, 5))

    def drag(
        self,
        first: tuple[float, float],
        last: tuple[float, float],
        held: Qt.KeyboardModifier = Qt.KeyboardModifier.NoModifier,
    ) -> None:
        """Draw a box from a time and share of the height to another, with a key held."""
        start, end, left = self.place(*first), self.place(*last), Qt.MouseButton.LeftButton
        QTest.mousePress(self._widget, left, held, start)
        for share in (0.3, 0.6, 1.0):
            way = end - start
            at = start + QPoint(round(share * way.x()), round(share * way.y()))
            QTest.qWait(20)  # a scene takes moves that are too quick for one
            place = QPointF(at)
            event = QMouseEvent(
                QEvent.Type.MouseMove, place, self._widget.mapToGlobal(place), left, left, held
            )
            QApplication.sendEvent(self._widget, event)
        QTest.mouseRelease(self._widget, left, held, end)

    def click_twice(self, time: float) -> None:
        """Click twice at a time."""
        QTest.mouseDClick(self._widget, Qt.MouseButton.LeftButton, pos=self.place(time))

    def wheel(self, time: float, steps: int, control: bool = False) -> None:
        """Turn the wheel at a time."""
        at = QPointF(self.place(time))
        held = Qt.KeyboardModifier.ControlModifier if control else Qt.KeyboardModifier.NoModifier
        event = QWheelEvent(
            *(at, self._widget.mapToGlobal(at), QPoint(), QPoint(0, 120 * steps)),
            *(Qt.MouseButton.NoButton, held, Qt.ScrollPhase.NoScrollPhase, False),
        )
        QApplication.sendEvent(self._widget, event)


@pytest.fixture
def mouse_on() -> Callable[[Chart], Mouse]:
    """The mouse over a chart."""
    return Mouse
