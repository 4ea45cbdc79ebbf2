"""Waypoints by mouse on the Home screen's map, over a flight that answers."""

import math

import pytest
from PyQt6.QtCore import QPoint, QPointF, Qt
from PyQt6.QtGui import QWheelEvent
from PyQt6.QtTest import QTest
from PyQt6.QtWidgets import QApplication
from pytestqt.qtbot import QtBot

from tests.gui.conftest import PATIENCE, noted, workspace_in
from workbench.control.mode import FlightMode
from workbench.gui.flight_control import NO_FLIGHT_TEXT, ON_GROUND_TEXT
from workbench.gui.home.gps_card import MAP_HELP_TEXT
from workbench.gui.home.home_screen import HomeScreen
from workbench.gui.instruments.map_frame import MapPlace
from workbench.live.choice import Choice
from workbench.scenario.scenario import Action

LEFT, RIGHT = Qt.MouseButton.LeftButton, Qt.MouseButton.RightButton
SHIFT = Qt.KeyboardModifier.ShiftModifier


class Bench:
    """The screen over a flight of its own, and a mouse on its map."""

    def __init__(self, folder):
        self.workspace = workspace_in(folder)
        self.told = noted(self.workspace)
        self.flight = self.workspace.flight
        self.screen = HomeScreen(self.workspace)
        self.screen.resize(1190, 700)
        self.card = self.screen.cards["gps"]
        self.map, self.button = self.card.map, self.card.go_to
        self.route = self.card._route
        self.flight.begun.connect(self.screen.begin)
        self.flight.viewed.connect(self.screen.show_view)

    @property
    def now(self):
        return self.flight.view.snapshot

    @property
    def places(self):
        """Waypoints, level."""
        return [each[:2] for each in self.route.places]

    def at(self, east, north):
        return self.map.position_of(east, north).toPoint()

    def click(self, east, north, button=LEFT, held=Qt.KeyboardModifier.NoModifier):
        QTest.mouseClick(self.map.viewport(), button, held, self.at(east, north))

    def wheel(self, steps):
        at = QPointF(self.at(0.0, 0.0))
        event = QWheelEvent(
            *(at, self.map.mapToGlobal(at), QPoint(), QPoint(0, 120 * steps)),
            *(Qt.MouseButton.NoButton, Qt.KeyboardModifier.ControlModifier),
            *(Qt.ScrollPhase.NoScrollPhase, False),
        )
        QApplication.sendEvent(self.map.viewport(), event)

    def asked(self, place):
        """Whether the flight is asked to go to a place, to the pixel."""
        x, y, _, follows = self.now.reference[4:8]
        return follows == 1.0 and math.dist((x, y), place) < self.pixel

    @property
    def pixel(self):
        """Of the map [m]."""
        return self.map.view.viewPixelSize()[0]

    def close(self):
        self.screen.close()
        self.workspace.close()


@pytest.fixture(scope="module")
def flown(request, qapp, tmp_path_factory):
    """A drone between obstacles; it is flown by one test after another."""
    bench = Bench(tmp_path_factory.mktemp("map"))
    bench.screen.show()
    bench.screen.activateWindow()
    assert not bench.button.isEnabled() and bench.button.toolTip() == NO_FLIGHT_TEXT
    bench.flight.fly(Choice("network", sensors=()), {"take_off_speed": 2.0}, draw=False)
    bench.flight.live.wait()
    wait = QtBot(request).waitUntil
    wait(lambda: bench.button.toolTip() == ON_GROUND_TEXT, timeout=PATIENCE)
    assert not bench.button.isEnabled()
    bench.flight.do(Action(request="take_off"))
    yield bench
    bench.close()


@pytest.fixture
def bench(flown, qtbot):
    """The drone hovering, without waypoints, the button up."""
    qtbot.waitUntil(lambda: flown.now.mode in (FlightMode.HOVERING, FlightMode.CRUISING))
    qtbot.waitUntil(flown.button.isEnabled)
    assert flown.button.toolTip() == MAP_HELP_TEXT
    yield flown
    flown.flight.do(Action(velocity=[0.0, 0.0, 0.0], yaw_rate=0.0))
    qtbot.waitUntil(lambda: flown.now.reference[7] == 0.0)
    qtbot.waitUntil(lambda: not flown.route.places)
    flown.button.setChecked(False)
    flown.told.clear()


def test_a_click_flies_there_at_the_present_height(bench, qtbot):
    bench.click(3.0, 0.0)
    assert bench.places == []  # the button was not pressed
    QTest.mouseClick(bench.button, LEFT)
    bench.click(3.0, 0.0)
    assert not bench.button.isChecked()
    (place,) = bench.route.places
    assert place[:2] == pytest.approx((3.0, 0.0), abs=bench.pixel)
    assert place[2] == pytest.approx(bench.now.p_WB[2], abs=0.05)
    qtbot.waitUntil(lambda: bench.asked((3.0, 0.0)))
    qtbot.waitUntil(lambda: math.dist(bench.now.p_WB, place) < 0.3)
    assert bench.places  # the last one is held, and shown


def test_a_click_keeps_the_height_to_which_the_drone_is_on_its_way(bench, qtbot):
    x, y, z = bench.now.p_WB
    bench.flight.do(Action(go_to=[x, y, z + 0.5]))
    qtbot.waitUntil(lambda: bench.now.reference[4:8] == (x, y, z + 0.5, 1.0))
    QTest.mouseClick(bench.button, LEFT)
    bench.click(3.0, 0.0)
    assert [height for *_, height in bench.route.places] == [z + 0.5]


def test_several_are_flown_in_turn_and_one_is_taken_away(bench, qtbot):
    QTest.mouseClick(bench.button, LEFT)
    for place in ((3.0, 0.0), (3.0, 3.0), (-3.0, 3.0)):
        bench.click(*place, held=SHIFT)
    assert bench.button.isChecked()
    assert len(bench.places) == 3 and bench.route.present == 0
    bench.click(3.0, 3.0, RIGHT)
    assert [round(x) for x, _ in bench.places] == [3, -3]
    bench.click(8.0, -8.0, RIGHT)  # nothing is there
    assert len(bench.places) == 2
    qtbot.waitUntil(lambda: bench.asked((-3.0, 3.0)))
    assert bench.route.present == 1
    assert "waypoint 2 of 2" in bench.map.spoken
    bench.click(3.0, 0.0, RIGHT)  # the one before: the next one is still flown to
    assert [round(x) for x, _ in bench.places] == [-3] and bench.route.present == 0
    assert bench.asked((-3.0, 3.0))
    bench.click(-3.0, 3.0, RIGHT)  # the one that is flown to: it brakes and stays
    assert bench.places == []
    qtbot.waitUntil(lambda: bench.now.reference[7] == 0.0)
    assert bench.told == []


def test_escape_sets_none(bench, qtbot):
    QTest.mouseClick(bench.button, LEFT)
    assert bench.map.armed
    QTest.keyClick(bench.screen, Qt.Key.Key_Escape)
    assert not bench.map.armed and not bench.button.isChecked()
    bench.click(3.0, 0.0)
    assert bench.places == []


def test_inside_of_an_obstacle_it_is_refused_with_its_name(bench, qtbot):
    mast = next(each for each in bench.flight.view.outlines if each.name == "mast")
    middle = [sum(each) / len(mast.corners) for each in zip(*mast.corners, strict=True)]
    bench.wheel(-1)
    QTest.mouseClick(bench.button, LEFT)
    QTest.mouseMove(bench.map.viewport(), bench.at(*middle))
    assert bench.map.say_place(bench.map.under)[-1].startswith("mast, 0.00 to 8.00")
    bench.click(*middle)
    assert bench.places == []
    said, _, height = bench.told[-1].what.rpartition(" at a height of ")
    assert said == "this place is inside 'mast'"
    assert float(height.removesuffix(" m")) == pytest.approx(bench.now.p_WB[2], abs=0.15)
    bench.wheel(1)


def test_a_stick_ends_them(bench, qtbot):
    QTest.mouseClick(bench.button, LEFT)
    bench.click(3.0, 3.0)
    qtbot.waitUntil(lambda: bench.asked((3.0, 3.0)))
    bench.flight.do(Action(velocity=[0.0, -0.5, 0.0], yaw_rate=0.0))
    qtbot.waitUntil(lambda: bench.places == [])
    assert "the drone got another command" in bench.told[-1].what


def test_the_pointer_is_told_where_it_is(bench):
    """North of home by 1 m is 9.0e-6 degrees of latitude: 1 m over 6 368 km on this ellipsoid."""
    south, north = MapPlace(0.0, -2.0), MapPlace(0.0, 2.0)
    low, high = (float(bench.card._say_place(each)[0].rstrip("°")) for each in (south, north))
    assert high - low == pytest.approx(math.degrees(4.0 / 6_368_000.0), abs=2e-7)
    QTest.mouseMove(bench.map.viewport(), bench.at(1.0, 2.0))
    under = bench.map.under
    assert (under.east, under.north) == pytest.approx((1.0, 2.0), abs=bench.pixel)


def test_the_wheel_shows_more_and_less_of_the_world(bench):
    before = bench.map.frame.reach
    bench.wheel(-1)
    assert bench.map.frame.reach > before
    bench.wheel(1)
    assert bench.map.frame.reach == before
