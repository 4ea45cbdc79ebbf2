"""A workspace with nothing of the user's in it, a flight in a can for it to show, and a mouse."""

import gc
import threading
from collections.abc import Callable, Iterator
from contextlib import contextmanager, nullcontext
from dataclasses import dataclass, replace
from functools import partial

import pytest
from PyQt6.QtCore import QCoreApplication, QEvent, QPoint, QPointF, QSettings, Qt
from PyQt6.QtGui import QMouseEvent, QWheelEvent
from PyQt6.QtTest import QTest
from PyQt6.QtWidgets import QApplication, QWidget
from pytestqt.qtbot import QtBot

from workbench.gui import click_guard
from workbench.gui.charts.chart import Chart
from workbench.gui.main_window import MainWindow
from workbench.gui.preferences import Preferences
from workbench.gui.screen_table import SCREEN_TABLE
from workbench.gui.start.sketches import Sketches
from workbench.gui.style import apply_style
from workbench.gui.theme import Look
from workbench.gui.workspace import make_workspace
from workbench.link.backplane import Published
from workbench.live.messages import Pace, Phase
from workbench.live.orders import FlightOrder
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


@pytest.fixture
def workspace(request, qapp, tmp_path):
    """That of the shared window, if the test has it; else one without a flight.

    Its settings go to a folder of the test's own.
    """
    if "shared_window" in request.fixturenames:
        yield request.getfixturevalue("shared_workspace")
        return
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
    """The real window with all its screens made, while nothing flies, for the tests of a file.

    No process draws the files of its start page; `start/test_start_screen.py` has one.
    """
    with no_thread_more(), own_style(qapp) as style, pytest.MonkeyPatch.context() as patch:
        patch.setattr(Sketches, "ask", lambda sketches, kind, path: None)
        style(shared_workspace.look)  # first: a style takes seconds where a window stands
        yield from _window(request, qapp, shared_workspace, tmp_path_factory)
        shared_workspace.close()


@pytest.fixture
def window(shared_window):
    """The shared window in front; its keys are the usual ones again after the test."""
    shared_window.activateWindow()
    yield shared_window
    shared_window.workspace.keys.reset()


@pytest.fixture
def style(request, qapp):
    """Return what gives the app its style until the end of the test; a shared window has one."""
    assert "shared_window" not in request.fixturenames
    with own_style(qapp) as styled:
        yield styled


@contextmanager
def own_style(app: QApplication) -> Iterator[Callable[[Look], None]]:
    """Return what styles the app: later tests have it plain again, and take half the time.

    Screens that earlier tests left would be styled, too.
    """
    gc.collect()
    delete_widgets()
    name, font, palette = app.style().name(), app.font(), app.palette()
    yield partial(apply_style, app)
    app.setStyleSheet("")
    app.setPalette(palette)
    app.setFont(font)
    app.setStyle(name)


def delete_widgets() -> None:
    """Delete the widgets that are to be deleted later, as an event loop does; no test has one."""
    QCoreApplication.sendPostedEvents(None, QEvent.Type.DeferredDelete)


def _window(request, qapp, shared_workspace, tmp_path_factory):
    shared_workspace.preferences.set("log_folder", str(tmp_path_factory.mktemp("logs")))
    made = MainWindow(shared_workspace, first="home", view3d=False)
    made.show()
    made.activateWindow()
    QtBot(request).waitUntil(lambda: made.stack.name == "home", timeout=120_000)
    for row in SCREEN_TABLE:
        made.stack.screen_of(row.name)
    yield made
    made.close()
    made.deleteLater()  # nor does it stand in the way of the next file's
    delete_widgets()


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


@pytest.fixture(autouse=True)
def hasty():
    """Let buttons act on the mouse at once: a test aims at what it clicks, see `click_guard`.

    By a patch of its own: a test's `monkeypatch` is undone before its workspace closes.
    """
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(click_guard, "FRESH_BUTTON_S", 0.0)
        yield


@pytest.fixture
def guarded_clock(hasty, monkeypatch):
    """The clock of guarded buttons, which a test sets forward by half a second [s]."""
    now = [100.0]
    monkeypatch.setattr(click_guard, "FRESH_BUTTON_S", 0.5)
    monkeypatch.setattr(click_guard, "monotonic", lambda: now[0])
    return now


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


@pytest.fixture
def orders(window, workspace, canned, unasked, monkeypatch):
    """What a flight out of a can is asked for."""
    made = []

    def do(order, done=None, refused=None):
        if order is not FlightOrder.GET_CHECKPOINT:  # the ghost asks for it, and no key
            made.append(order)

    monkeypatch.setattr(workspace.flight, "do", do)
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
    delete_widgets()


@pytest.fixture(autouse=True)
def nothing_is_held():
    """Release the mouse and the keys after a test: Qt's double click leaves its button pressed.

    The app asks Qt for what is pressed, so the next test would be one with a button held.
    """
    held = QApplication.mouseButtons(), QApplication.keyboardModifiers()
    assert held == (Qt.MouseButton.NoButton, Qt.KeyboardModifier.NoModifier)
    yield
    pressed = QApplication.mouseButtons()
    for button in (
        Qt.MouseButton.LeftButton,
        Qt.MouseButton.MiddleButton,
        Qt.MouseButton.RightButton,
    ):
        if pressed & button:
            QTest.mouseRelease(QWidget(), button)
    if QApplication.keyboardModifiers() != Qt.KeyboardModifier.NoModifier:
        QTest.keyRelease(QWidget(), Qt.Key.Key_Shift)


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

    def wheel(
        self,
        time: float,
        steps: int,
        held: Qt.KeyboardModifier = Qt.KeyboardModifier.ControlModifier,
    ) -> bool:
        """Turn the wheel at a time; return whether the chart took it from the page."""
        at = QPointF(self.place(time))
        event = QWheelEvent(
            *(at, self._widget.mapToGlobal(at), QPoint(), QPoint(0, 120 * steps)),
            *(Qt.MouseButton.NoButton, held, Qt.ScrollPhase.NoScrollPhase, False),
        )
        QApplication.sendEvent(self._widget, event)
        return event.isAccepted()


@pytest.fixture
def mouse_on() -> Callable[[Chart], Mouse]:
    """The mouse over a chart."""
    return Mouse
