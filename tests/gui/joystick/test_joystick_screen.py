"""The joystick screen by mouse and keys, with a flight that answers."""

import math
import threading

import pytest
from PyQt6.QtCore import QPoint, Qt
from PyQt6.QtTest import QTest
from PyQt6.QtWidgets import QLineEdit, QMainWindow, QPushButton, QVBoxLayout, QWidget

from tests.gui.conftest import noted, workspace_in
from workbench.control.mode import FlightMode
from workbench.gui.flight_control import NO_FLIGHT_TEXT, ON_GROUND_TEXT, PAUSED_TEXT
from workbench.gui.joystick.game_pad import PadButton, PadReading
from workbench.gui.joystick.joystick_screen import JoystickScreen
from workbench.gui.joystick.pilot import CENTRE_STICKS_TEXT, StickDevice
from workbench.gui.joystick.piloting import CENTRED_STICKS, Sticks
from workbench.link import Client
from workbench.link.messages import ControlOwner
from workbench.link.server.config import ServerConfig
from workbench.live.choice import Choice
from workbench.live.messages import Phase
from workbench.live.orders import FlightOrder, NetworkOrder, SetSpeed
from workbench.scenario.scenario import Action

LONG = 30_000
"""Limit of a wait [ms]; nothing here takes so long."""


class Bench:
    """A window with the screen and a field beside it, over a flight of its own."""

    def __init__(self, folder):
        self.workspace = workspace_in(folder)
        self.told = noted(self.workspace)
        self.flight = self.workspace.flight
        self.screen = JoystickScreen(self.workspace)
        self.pilot = self.screen.pilot
        self.field, self.button = QLineEdit(), QPushButton("elsewhere")
        middle = QWidget()
        layout = QVBoxLayout(middle)
        for widget in (self.field, self.button, self.screen):
            layout.addWidget(widget)
        self.window = QMainWindow()
        self.window.setCentralWidget(middle)
        self.window.resize(900, 760)
        self.flight.begun.connect(self.screen.begin)
        self.flight.viewed.connect(self.screen.show_view)

    @property
    def snapshot(self):
        return self.flight.view.snapshot

    @property
    def asked(self):
        """Velocity and yaw rate that the flight is asked for."""
        return self.snapshot.reference[:4]

    def at(self, pad, x, y):
        return pad.place((x, y)).toPoint()

    def hold(self, pad, x, y):
        QTest.mousePress(pad, Qt.MouseButton.LeftButton, pos=self.at(pad, 0.0, 0.0))
        QTest.mouseMove(pad, self.at(pad, x, y))

    def let_go(self, pad):
        QTest.mouseRelease(pad, Qt.MouseButton.LeftButton, pos=QPoint(0, 0))

    def close(self):
        self.screen.release()
        self.window.close()
        self.screen.close_screen()
        self.workspace.close()


@pytest.fixture(scope="module")
def flown(qapp, tmp_path_factory):
    """A flight without sensors, whose process serves one test after another."""
    bench = Bench(tmp_path_factory.mktemp("joystick"))
    bench.flight.fly(Choice("network", sensors=()), {"take_off_speed": 2.0}, draw=False)
    bench.flight.live.wait()
    yield bench
    bench.close()


@pytest.fixture
def bench(flown, qtbot):
    """The drone hovering above its start with its first parameters, all sticks let go, in front."""
    flown.window.show()
    flown.window.activateWindow()
    qtbot.waitUntil(flown.window.isActiveWindow, timeout=LONG)
    flown.flight.do(FlightOrder.RESET)
    qtbot.waitUntil(
        lambda: flown.snapshot is not None and flown.snapshot.mode is FlightMode.OFF, timeout=LONG
    )
    state = flown.screen.state_bar.state
    qtbot.waitUntil(lambda: state.text() == ON_GROUND_TEXT, timeout=LONG)
    flown.flight.do(SetSpeed(5.0))
    QTest.mouseClick(flown.screen.state_bar.take_off, Qt.MouseButton.LeftButton)
    qtbot.waitUntil(lambda: flown.snapshot.mode is FlightMode.HOVERING, timeout=LONG)
    flown.flight.do(SetSpeed(1.0))
    flown.screen.setFocus()
    return flown


def test_nothing_flies_and_that_is_said(workspace, qtbot):
    screen = JoystickScreen(workspace)
    qtbot.addWidget(screen)
    screen.show()
    assert screen.state_bar.state.text() == NO_FLIGHT_TEXT
    assert not screen.state_bar.take_off.isVisible()
    QTest.mousePress(screen.left_pad, Qt.MouseButton.LeftButton, pos=QPoint(20, 20))
    assert screen.pilot.barred == NO_FLIGHT_TEXT
    screen.close_screen()


def test_the_knob_stays_in_its_circle_and_springs_back(workspace, qtbot):
    screen = JoystickScreen(workspace)
    qtbot.addWidget(screen)
    screen.resize(760, 600)
    screen.show()
    pad = screen.right_pad
    middle = pad.place((0.0, 0.0)).toPoint()
    QTest.mousePress(pad, Qt.MouseButton.LeftButton, pos=middle)
    QTest.mouseMove(pad, middle + QPoint(300, -400))
    assert pad.stick == pytest.approx((0.6, 0.8), abs=0.005)  # whole pixels
    QTest.mouseRelease(pad, Qt.MouseButton.LeftButton, pos=middle + QPoint(300, -400))
    assert pad.stick == (0.0, 0.0)
    screen.close_screen()


def test_a_stick_that_is_dragged_flies_and_one_that_is_let_go_stops(bench, qtbot):
    bench.hold(bench.screen.right_pad, 0.0, 0.5)
    speed = min(8.0, bench.pilot.clearance)  # at full stick a second to the obstacle
    asked = speed * (0.7 * 0.4737 + 0.3 * 0.4737**3)
    assert bench.pilot.wish.forward == pytest.approx(asked, rel=0.05)
    qtbot.waitUntil(lambda: bench.asked[0] == pytest.approx(asked, rel=0.05), timeout=LONG)
    qtbot.waitUntil(lambda: bench.snapshot.v_WB[0] > 0.8 * asked, timeout=LONG)
    assert bench.screen.state_bar.state.text() == "You fly, by mouse."
    bench.let_go(bench.screen.right_pad)
    qtbot.waitUntil(lambda: bench.asked == (0.0, 0.0, 0.0, 0.0), timeout=LONG)


def test_forward_is_along_the_nose_once_the_drone_has_turned(bench, qtbot):
    bench.hold(bench.screen.left_pad, 1.0, 0.0)  # to the right: clockwise from above
    qtbot.waitUntil(lambda: bench.snapshot.roll_pitch_yaw[2] < -0.5, timeout=LONG)
    bench.let_go(bench.screen.left_pad)
    bench.hold(bench.screen.right_pad, 0.0, 0.4)
    qtbot.waitUntil(lambda: math.hypot(*bench.asked[:2]) > 1.0, timeout=LONG)
    yaw = bench.snapshot.roll_pitch_yaw[2]
    assert math.atan2(bench.asked[1], bench.asked[0]) == pytest.approx(yaw, abs=0.05)
    bench.let_go(bench.screen.right_pad)


def test_a_held_key_flies_and_its_repeats_count_nothing(bench, qtbot):
    QTest.keyPress(bench.screen, Qt.Key.Key_W)
    assert bench.pilot.device is StickDevice.KEYBOARD
    qtbot.waitUntil(lambda: bench.asked[2] > 2.0, timeout=LONG)
    assert bench.screen.left_pad.stick[1] > 0.3  # the stick on the screen follows
    QTest.keyRelease(bench.screen, Qt.Key.Key_W)
    qtbot.waitUntil(lambda: bench.asked[2] == 0.0, timeout=LONG)


def test_near_an_obstacle_keys_and_mouse_are_gentle(bench, qtbot):
    """By hand: within a second of the obstacle, at 2.4 m no more than 2.4 m/s of the 8 m/s."""
    pilot = bench.pilot
    QTest.keyPress(bench.screen, Qt.Key.Key_W)
    qtbot.waitUntil(lambda: pilot.sticks.climb == 1.0, timeout=LONG)
    assert 0.5 < pilot.clearance < 7.0
    assert pilot.wish.climb == pytest.approx(pilot.clearance)
    line = bench.screen._keys_line
    qtbot.waitUntil(lambda: "An obstacle is" in line.text(), timeout=LONG)
    assert "keys and mouse command" in line.text()
    QTest.keyRelease(bench.screen, Qt.Key.Key_W)
    bench.hold(bench.screen.right_pad, 0.0, 1.0)
    assert pilot.wish.forward == pytest.approx(pilot.clearance, rel=0.05)
    bench.let_go(bench.screen.right_pad)
    qtbot.waitUntil(lambda: bench.asked == (0.0, 0.0, 0.0, 0.0), timeout=LONG)


def test_keys_fly_with_the_focus_on_a_button_elsewhere_but_not_in_a_field(bench, qtbot):
    bench.button.setFocus()
    QTest.keyPress(bench.button, Qt.Key.Key_Up)
    assert bench.pilot.device is StickDevice.KEYBOARD
    qtbot.waitUntil(lambda: math.hypot(*bench.asked[:2]) > 0.5, timeout=LONG)
    bench.field.setFocus()  # lets go of everything
    qtbot.waitUntil(lambda: bench.asked == (0.0, 0.0, 0.0, 0.0), timeout=LONG)
    QTest.keyClick(bench.field, Qt.Key.Key_W)
    assert bench.field.text() == "w"
    assert bench.pilot.device is StickDevice.NONE


def test_another_screen_lets_go(bench, qtbot):
    bench.hold(bench.screen.right_pad, 0.5, 0.0)
    qtbot.waitUntil(lambda: math.hypot(*bench.asked[:2]) > 0.5, timeout=LONG)
    bench.screen.hide()
    qtbot.waitUntil(lambda: bench.asked == (0.0, 0.0, 0.0, 0.0), timeout=LONG)
    bench.screen.show()
    assert bench.pilot.sticks == CENTRED_STICKS


def test_another_window_lets_go(bench, qtbot):
    bench.hold(bench.screen.right_pad, 0.5, 0.0)
    qtbot.waitUntil(lambda: math.hypot(*bench.asked[:2]) > 0.5, timeout=LONG)
    other = QMainWindow()
    qtbot.addWidget(other)
    other.show()
    other.activateWindow()
    qtbot.waitUntil(lambda: bench.asked == (0.0, 0.0, 0.0, 0.0), timeout=LONG)
    assert bench.screen.right_pad.stick == (0.0, 0.0)


def test_a_pause_lets_go_and_the_stick_must_be_centred_after_it(bench, qtbot):
    flight, pad = bench.flight, bench.screen.right_pad
    bench.hold(pad, 0.0, -0.5)
    qtbot.waitUntil(lambda: math.hypot(*bench.asked[:2]) > 0.5, timeout=LONG)
    flight.do(FlightOrder.PAUSE)
    qtbot.waitUntil(lambda: bench.asked == (0.0, 0.0, 0.0, 0.0), timeout=LONG)
    assert bench.screen.state_bar.state.text() == PAUSED_TEXT
    flight.do(FlightOrder.RESUME)
    qtbot.waitUntil(lambda: flight.view.phase is Phase.FLYING, timeout=LONG)
    qtbot.waitUntil(lambda: bench.pilot.barred == CENTRE_STICKS_TEXT, timeout=LONG)
    assert bench.asked == (0.0, 0.0, 0.0, 0.0)
    bench.let_go(pad)
    assert bench.pilot.barred == ""


def test_a_game_pad_flies_and_its_buttons_ask(bench, qtbot, monkeypatch):
    reading = [PadReading("a pad", Sticks(climb=-0.5), ())]
    monkeypatch.setattr(bench.pilot.pads, "read", lambda: reading[0])
    bench.pilot.listen_to_pads(True)
    reading[0] = PadReading("a pad", CENTRED_STICKS, ())
    qtbot.waitUntil(lambda: bench.pilot.pad_name == "a pad", timeout=LONG)
    reading[0] = PadReading("a pad", Sticks(climb=0.5), ())
    qtbot.waitUntil(lambda: bench.asked[2] > 1.0, timeout=LONG)
    assert bench.pilot.device is StickDevice.PAD
    bench.pilot.listen_to_pads(False)  # the window is in the background
    qtbot.waitUntil(lambda: bench.asked[2] == 0.0, timeout=LONG)
    asked = []
    monkeypatch.setattr(bench.pilot, "_request", asked.append)
    bench.pilot.listen_to_pads(True)
    reading[0] = PadReading("a pad", CENTRED_STICKS, (PadButton.LAND,))
    qtbot.waitUntil(lambda: "land" in asked, timeout=LONG)
    reading[0] = None


def test_a_client_flies_until_a_stick_is_moved(bench, qtbot):
    flight, bar = bench.flight, bench.screen.state_bar
    addresses = []
    flight.do(ServerConfig(port=0), done=addresses.append)
    qtbot.waitUntil(lambda: bool(addresses), timeout=LONG)
    lost, leave = threading.Event(), threading.Event()
    client = threading.Thread(target=fly_until_lost, args=(addresses[0], lost, leave))
    given: list[float] = []
    flight.do(NetworkOrder.GIVE_BACK, done=given.append)
    qtbot.waitUntil(lambda: bool(given), timeout=LONG)  # a client that asks earlier is refused
    client.start()
    try:
        qtbot.waitUntil(lambda: bar.control.text().startswith("tuner flies"), timeout=LONG)
        assert bar.take_over.isVisible()
        # a stick that moves before the pilot has seen the client counts as held all along
        qtbot.waitUntil(lambda: bench.pilot._gate._hand is ControlOwner.CLIENT, timeout=LONG)
        bench.hold(bench.screen.right_pad, 0.0, 0.4)
        qtbot.waitUntil(
            lambda: flight.view.network.control.hand is ControlOwner.OPERATOR, timeout=LONG
        )
        qtbot.waitUntil(lambda: math.hypot(*bench.asked[:2]) > 1.0, timeout=LONG)
        qtbot.waitUntil(lost.is_set, timeout=LONG)
        assert bar.give_back.isVisible()
        QTest.mouseClick(bar.give_back, Qt.MouseButton.LeftButton)
        qtbot.waitUntil(
            lambda: flight.view.network.control.hand is ControlOwner.NOBODY, timeout=LONG
        )
        assert bench.asked == (0.0, 0.0, 0.0, 0.0)
        bench.let_go(bench.screen.right_pad)
    finally:
        leave.set()
        client.join()
        flight.do(NetworkOrder.STOP_SERVING)
    qtbot.waitUntil(lambda: flight.view.network.server is None, timeout=LONG)


def test_a_limit_that_holds_a_wish_back_is_said(bench, qtbot):
    bench.flight.do(Action(set={"max_speed": 1.0}))
    qtbot.waitUntil(lambda: bench.pilot.limits.level == 1.0, timeout=LONG)
    bench.hold(bench.screen.right_pad, 0.0, 1.0)
    qtbot.waitUntil(lambda: "max_speed" in bench.screen.state_bar.control.text(), timeout=LONG)
    assert "held to 1.00\N{NO-BREAK SPACE}m/s" in bench.screen.state_bar.control.text()
    bench.let_go(bench.screen.right_pad)
    assert "max_speed" not in bench.screen.state_bar.control.text()


def test_sliders_change_the_feel_and_are_kept(workspace, told, qtbot):
    screen = JoystickScreen(workspace)
    qtbot.addWidget(screen)
    screen.show()
    slider = screen.handling.sliders["stick_expo"]
    slider.setFocus()
    QTest.keyClick(slider, Qt.Key.Key_Home)
    assert workspace.preferences.number("stick_expo") == 0.0
    assert screen.pilot.handling.expo == 0.0
    workspace.preferences.set("stick_dead_band", 0.25)
    assert screen.handling.sliders["stick_dead_band"].value() == 100  # of 200 up to 0.5
    assert told == []
    screen.close_screen()


def fly_until_lost(address, lost, leave):
    """Hold control until the operator takes it."""
    with Client(address, name="tuner", topics=["drone_state"]) as client:
        with client.control() as control:
            while not leave.is_set() and not control.lost:
                leave.wait(0.02)
            lost.set()
        leave.wait()
