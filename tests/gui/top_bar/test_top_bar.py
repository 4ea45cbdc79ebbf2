"""The top bar: what it says of a flight, and what its buttons order."""

import dataclasses
import math
from functools import partial
from types import SimpleNamespace

import pytest
from PyQt6.QtCore import Qt
from PyQt6.QtWidgets import QApplication, QMainWindow

from workbench.control.mode import FlightMode
from workbench.gui.actions import ACTION_TABLE
from workbench.gui.command_action import make_actions
from workbench.gui.flight_control import (
    AUTOPILOT_ENDED_TEXT,
    FlightControl,
    manual_denial_reason,
    possible_actions,
)
from workbench.gui.icons import ICON_STROKES
from workbench.gui.main_window import MainWindow
from workbench.gui.recorder import LogRecorder
from workbench.gui.status_strip import Chip
from workbench.gui.status_text import (
    BAD_TONE,
    PLAIN_TONE,
    WARNING_TONE,
    StatusText,
    autopilot_status,
    battery_status_text,
    link_status,
    mode_status,
    real_time_status,
    script_status,
    time_status,
    warnings_status,
)
from workbench.gui.top_bar import SpeedBox, TopBar, next_speed
from workbench.link.backplane import ClientStatus, ServerStatus
from workbench.link.messages import ControlOwner, ControlState, LinkLossStage, Role
from workbench.live.messages import AutopilotView, NetworkView, Pace, Phase
from workbench.live.orders import FlyOn, SetSpeed
from workbench.live.view import LiveView
from workbench.scenario.scenario import Action
from workbench.session.snapshot import NearestClearance

REQUESTED = ("arm", "take_off", "land", "stop")
"""Actions that ask the flight mode for what they are named after."""


@pytest.fixture
def view(canned):
    return canned.views[90]


def with_snapshot(view, **changes):
    return dataclasses.replace(view, snapshot=dataclasses.replace(view.snapshot, **changes))


def client(number):
    return ClientStatus(number, "here:1", "Ada", "tcp", Role.COMMAND, 60.0, 0.0, 0, 0)


def served(view, hand=ControlOwner.NOBODY, stage=LinkLossStage.LIVE, clients=0):
    server = ServerStatus("127.0.0.1:7", "", tuple(map(client, range(clients))), {}, ())
    control = ControlState(hand, 1, "Ada", stage, 0.0, "it was asked for")
    return dataclasses.replace(view, network=NetworkView(server, control))


@pytest.mark.parametrize("mode", list(FlightMode))
def test_every_mode_has_a_word_and_a_shape(view, mode):
    said = mode_status(with_snapshot(view, mode=mode))
    assert said.text == mode.label
    assert said.icon in ICON_STROKES


@pytest.mark.parametrize("phase", list(Phase))
def test_every_phase_has_a_word_and_a_shape(view, phase):
    said = mode_status(dataclasses.replace(view, phase=phase))
    assert said.icon in ICON_STROKES
    if phase is not Phase.FLYING:
        assert phase.value in said.text


def test_what_is_being_done_before_the_flight_is_said():
    view = LiveView(said="loading Drake")
    assert mode_status(view).text == "starting"
    assert time_status(view).text == "loading Drake"
    for said in (battery_status_text(view), real_time_status(view)):
        assert said.text == "–"
    assert warnings_status(view) == ()


@pytest.mark.parametrize(
    ("time", "text"), [(0.0, "0:00.0"), (59.99, "0:59.9"), (60.0, "1:00.0"), (3725.46, "1:02:05.4")]
)
def test_time_is_never_rounded_up(view, time, text):
    assert time_status(with_snapshot(view, time=time)).text == text


@pytest.mark.parametrize(
    ("charge", "text", "tone"),
    [
        (1.0, "100\N{NO-BREAK SPACE}%", PLAIN_TONE),
        (0.29, "29\N{NO-BREAK SPACE}% low", WARNING_TONE),
        (0.2, "20\N{NO-BREAK SPACE}% left", BAD_TONE),
    ],
)
def test_the_battery_says_low_in_words(view, charge, text, tone):
    view = dataclasses.replace(view, values={"battery_reserve": 0.2})
    said = battery_status_text(with_snapshot(view, charge=charge))
    assert (said.text, said.tone) == (text, tone)


@pytest.mark.parametrize(
    ("asked", "achieved", "behind", "reached", "too_slow"),
    [
        (1.0, 1.0, False, "reached 1.00 ×", False),
        (1.0, 0.83, True, "reached 0.83 × of 1 ×", True),
        (1.0, 0.99, True, "reached 0.99 ×", False),  # a hiccup that is over
        (1.0, 0.62, False, "reached 0.62 ×", False),  # the first second
        (2.0, 2.0, False, "reached 2.00 ×", False),
        (2.0, 1.4, True, "reached 1.40 × of 2 ×", False),
        (10.0, 0.9, True, "reached 0.90 × of 10 ×", True),
        (0.5, 0.5, False, "reached 0.50 ×", False),
        (0.5, 0.3, True, "reached 0.30 × of 0.5 ×", True),
    ],
)
def test_too_slow_is_what_keeps_neither_real_time_nor_what_was_asked(
    view, asked, achieved, behind, reached, too_slow
):
    paced = dataclasses.replace(view, pace=Pace(asked, achieved, 0.1, 2.0, behind))
    said = real_time_status(paced)
    assert said.text.replace("\N{NO-BREAK SPACE}", " ") == reached
    assert ("too slow" in said.full) is too_slow
    assert (said.tone == WARNING_TONE) is too_slow
    warned = [each.text for each in warnings_status(paced)]
    assert warned == (["machine too slow"] if too_slow else [])
    paused = dataclasses.replace(paced, phase=Phase.PAUSED)
    assert warnings_status(paused) == ()


def test_the_obstacle_comes_before_slowness(view):
    near = NearestClearance(0.44, (1.0, 0.0, 0.0), True)
    view = with_snapshot(view, clearance=near)
    view = dataclasses.replace(view, pace=Pace(1.0, 0.5, 0.1, 2.0, True))
    said = warnings_status(view)
    assert [each.text for each in said] == ["obstacle 0.44\N{NO-BREAK SPACE}m", "machine too slow"]
    far = dataclasses.replace(near, warning=False, distance=math.inf)
    assert warnings_status(with_snapshot(view, clearance=far))[0].text == "machine too slow"


def test_the_link_says_who_watches_and_who_flies(view):
    assert link_status(view).text == "no server"
    assert link_status(served(view)).text == "0 clients, nobody flies"
    assert link_status(served(view, ControlOwner.OPERATOR, clients=1)).text == "1 client, you fly"
    assert link_status(served(view, ControlOwner.CLIENT, clients=2)).text == "2 clients, Ada flies"
    silent = link_status(served(view, ControlOwner.CLIENT, LinkLossStage.LOST, 1))
    assert (silent.text, silent.tone) == ("Ada silent: lost", WARNING_TONE)


@pytest.mark.parametrize(
    ("phase", "mode", "able", "unable"),
    [
        (Phase.FLYING, FlightMode.OFF, {"arm", "take_off"}, {"land", "hold", "step"}),
        (Phase.FLYING, FlightMode.ARMED, {"take_off"}, {"arm", "land", "step"}),
        (Phase.FLYING, FlightMode.CRUISING, {"land", "hold", "pause"}, {"arm", "take_off"}),
        (Phase.PAUSED, FlightMode.HOVERING, {"step", "pause", "reset"}, {"arm"}),
        (Phase.BROKEN, FlightMode.HOVERING, {"reset"}, {"pause", "step", "land"}),
        (Phase.ENDED, FlightMode.HOVERING, {"reset"}, {"pause", "record", "land"}),
    ],
)
def test_only_what_has_an_effect_can_be_pressed(view, phase, mode, able, unable):
    found = possible_actions(dataclasses.replace(with_snapshot(view, mode=mode), phase=phase))
    assert able <= found
    assert not unable & found


def test_an_autopilot_says_what_it_lost_and_that_it_has_ended(view):
    assert autopilot_status(view) is None
    law = SimpleNamespace(name="betaflight-sitl")
    view = dataclasses.replace(with_snapshot(view, mode=FlightMode.HOVERING), controller=law)
    for lost, tone in ((3, PLAIN_TONE), (30, WARNING_TONE)):
        flies = AutopilotView({"packets": 1024, "lost": lost})
        said = autopilot_status(dataclasses.replace(view, autopilot=flies))
        assert (said.text, said.tone) == (f"betaflight-sitl: {lost} lost", tone)
        assert f"{lost} of 1024 packets" in said.full
    ended = dataclasses.replace(flies, ended="it was killed: reset")
    view = dataclasses.replace(view, autopilot=ended)
    assert autopilot_status(view).tone == BAD_TONE and autopilot_status(view).full == ended.ended
    assert (mode_status(view).text, mode_status(view).tone) == ("hovering, held", BAD_TONE)
    assert mode_status(view).full == ended.ended
    assert possible_actions(view) == {"stop", "pause", "reset", "speed", "record"}
    assert manual_denial_reason(view) == AUTOPILOT_ENDED_TEXT
    anew = dataclasses.replace(view, phase=Phase.STARTING, said="Betaflight: arms", autopilot=None)
    assert time_status(anew).text == "Betaflight: arms" and not possible_actions(anew)


def test_nothing_but_stop_can_be_pressed_before_the_flight_begins():
    assert possible_actions(LiveView()) == frozenset()


def test_arrows_go_to_the_next_usual_speed(case):
    for factor, up, following in [
        (1.0, True, 2.0),
        (1.0, False, 0.5),
        (1.3, True, 2.0),
        (1.3, False, 1.0),
        (10.0, True, 20.0),
        (20.0, True, 20.0),
        (0.1, False, 0.1),
        (0.02, False, 0.02),
    ]:
        with case(factor, up, following):
            assert next_speed(factor, up=up) == following


def test_a_speed_is_wanted_once_it_is_entered(qtbot):
    box = SpeedBox()
    qtbot.addWidget(box)
    box.show()
    wanted = []
    box.edited.connect(wanted.append)
    box.selectAll()
    qtbot.keyClicks(box, "0.25")
    assert wanted == []
    qtbot.keyClick(box, Qt.Key.Key_Return)
    assert wanted == [0.25]
    qtbot.keyClick(box, Qt.Key.Key_Up)
    assert wanted == [0.25, 0.5]


def test_the_flight_s_speed_is_shown_without_an_echo(qtbot):
    box = SpeedBox()
    qtbot.addWidget(box)
    wanted = []
    box.edited.connect(wanted.append)
    box.show_factor(5.0)
    assert (box.value(), wanted) == (5.0, [])


def test_a_chip_changes_only_where_its_words_do(qtbot, workspace, monkeypatch):
    chip = Chip("Battery", workspace.look)
    qtbot.addWidget(chip)
    drawn = []
    monkeypatch.setattr(chip, "_draw", lambda: drawn.append(1))
    said = StatusText("87 %", "battery", PLAIN_TONE, "battery 87 %")
    chip.show_said(said)
    chip.show_said(StatusText("87 %", "battery", PLAIN_TONE, "battery 87 %"))
    assert drawn == [1]
    chip.show_said(dataclasses.replace(said, text="86 %"))
    assert drawn == [1]
    chip.show_said(dataclasses.replace(said, tone=BAD_TONE))
    assert drawn == [1, 1]
    assert chip.accessibleName() == "Battery: battery 87 %"


@pytest.fixture
def bar(qtbot, workspace, view, monkeypatch):
    window = QMainWindow()
    qtbot.addWidget(window)
    orders = []
    monkeypatch.setattr(workspace.flight, "do", lambda order, **_: orders.append(order))
    monkeypatch.setattr(workspace.flight, "_view", view)
    control = FlightControl(workspace.flight, workspace.preferences)
    recorder = LogRecorder(workspace.flight, workspace.preferences, workspace.notices)
    done = {row.name: getattr(control, row.name, lambda: None) for row in ACTION_TABLE}
    done |= {name: partial(control.request, name) for name in REQUESTED}
    made = TopBar(workspace, make_actions(window, done, workspace.keys), control, recorder)
    window.setCentralWidget(made)
    made.orders = orders
    window.show()
    yield made
    window.close()


def test_a_checked_button_is_as_large_as_before(bar, style, workspace):
    style(workspace.look)
    button = bar.button("view_3d")
    before = button.sizeHint()
    button.defaultAction().setChecked(True)
    assert button.isChecked() and button.sizeHint() == before


@pytest.mark.parametrize("name", REQUESTED)
def test_a_button_orders_what_it_says(bar, qtbot, name):
    qtbot.mouseClick(bar.button(name), Qt.MouseButton.LeftButton)
    assert bar.orders == [Action(request=name)]


@pytest.mark.parametrize("name", ["land", "stop", "hold"])
def test_a_script_is_shown_until_hold_land_or_stop_end_it(
    bar, qtbot, view, workspace, monkeypatch, name
):
    """Otherwise its next order would start the rotors again, or leave the place."""
    waiting = dataclasses.replace(view, next_action=Action(at=65.5, request="take_off"))
    monkeypatch.setattr(workspace.flight, "_view", waiting)
    bar.show_view(waiting)
    assert bar.strip.script.text == "script: 1:05.5 take off"
    assert bar.strip.script.isVisibleTo(bar)
    qtbot.mouseClick(bar.button(name), Qt.MouseButton.LeftButton)
    assert bar.orders[-1] == Action(request=name)
    bar.show_view(view)
    assert not bar.strip.script.isVisibleTo(bar)


@pytest.mark.parametrize(
    ("order", "text"),
    [
        (Action(yaw_rate=0.0), "yaw rate"),
        (Action(go_to=[0.0, 0.0, 1.0], set={"wind_x": 1.0}), "go to a place"),
        (Action(set={"wind_x": 1.0}), "set wind_x"),
        (Action(set={"wind_x": 1.0, "wind_y": 1.0}), "set parameters"),
        (Action(set={"k" * 200: 1.0}), "set kkkkkkkkkkkkkkkkkkkk"),
        (Action(controller="px4"), "controller"),
        (Action(end_script=True), "end of the script"),
        (Action(), "no order"),
    ],
)
def test_the_chip_of_the_script_says_when_and_what(view, order, text):
    waiting = dataclasses.replace(view, next_action=dataclasses.replace(order, at=5.0))
    shown = script_status(waiting).text
    assert shown.startswith(f"script: 0:05.0 {text}") and len(shown) < 70


@pytest.mark.parametrize("order", [Action(at=5.0, request="take_off"), Action(set={"k" * 99: 1.0})])
def test_the_chip_of_the_script_cuts_no_other_text(bar, view, order, qtbot):
    bar.setFixedWidth(928)  # in a window of 1024 px
    load = StatusText("load hooked, slack", "hook")
    bar.show_view(dataclasses.replace(view, next_action=order))
    bar.strip.load.show_said(load)
    bar.strip.load.show()
    bar.show()
    QApplication.processEvents()
    chips = [chip for chip in bar.strip.findChildren(Chip) if chip.isVisible()]
    assert bar.strip.script in chips and bar.strip.load in chips
    for chip in chips:
        if chip is not bar.strip.script:
            assert chip.width() >= chip.sizeHint().width(), chip.text
    assert chips[-1].geometry().right() < bar.strip.width()
    assert bar.strip.script.width() >= bar.strip.script.minimumSizeHint().width()
    if order.request:
        assert bar.strip.script.width() >= bar.strip.script.sizeHint().width()


def test_hold_brakes_whatever_is_flown(bar, qtbot):
    qtbot.mouseClick(bar.button("hold"), Qt.MouseButton.LeftButton)
    assert bar.orders == [Action(velocity=[0.0] * 3, yaw_rate=0.0), Action(request="hold")]


def test_a_step_is_one_control_period(bar, qtbot):
    qtbot.mouseClick(bar.button("step"), Qt.MouseButton.LeftButton)
    assert bar.orders == [FlyOn(1 / 128)]


def test_the_speed_box_orders_a_speed(bar, qtbot):
    qtbot.keyClick(bar.speed, Qt.Key.Key_Up)
    assert bar.orders == [SetSpeed(2.0)]


def test_the_bar_follows_the_flight(bar, workspace, view):
    workspace.flight.viewed.emit(with_snapshot(view, mode=FlightMode.LANDING, time=61.27))
    assert bar.badge.text == "landing"
    assert bar.strip.time.text == "1:01.2"
    assert bar.speed.value() == 1.0


def test_every_button_has_a_name_with_its_key_and_all_but_stop_take_the_focus(bar):
    for name in ("arm", "take_off", "hold", "land", "stop", "pause", "step", "reset", "record"):
        button = bar.button(name)
        assert "," in button.accessibleName(), name
        takes_focus = bool(button.focusPolicy() & Qt.FocusPolicy.TabFocus)
        assert takes_focus == (name != "stop"), name  # no key but F12 stops the rotors
    assert "0.01 to 20" in bar.speed.accessibleName()


def test_no_text_is_cut_at_the_smallest_width(bar, view):
    for mode in FlightMode:
        bar.show_view(dataclasses.replace(with_snapshot(view, mode=mode), phase=Phase.PAUSED))
    bar.strip.recording.show()
    bar.strip.recording.show_said(StatusText("612:03  1.23 GB", "record", BAD_TONE))
    assert bar.minimumSizeHint().width() <= 1190


def test_a_window_that_begins_narrow_cuts_no_word(qapp, qtbot, style, workspace):
    """It is 1024 px wide before it is shown, as where that size was kept."""
    style(workspace.look)
    window = MainWindow(workspace, first="home", view3d=False)
    qtbot.addWidget(window)
    window.resize(1024, 700)
    window.show()
    for _ in range(5):  # a layout may ask for another one
        qapp.processEvents()
    stop = window.top_bar.button("stop")
    assert stop.width() >= stop.sizeHint().width()
    window.close()
