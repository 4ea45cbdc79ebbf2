"""Sticks become commands: circle, mode 2, the drone's heading, limits, and when they are sent."""

import math
from dataclasses import replace

import pytest

from workbench.control.mode import FlightMode
from workbench.gui.flight_control import (
    LANDING_TEXT,
    ON_GROUND_TEXT,
    PAUSED_TEXT,
    manual_denial_reason,
)
from workbench.gui.joystick.pilot import CENTRE_STICKS_TEXT, CentringGate, CommandSender
from workbench.gui.joystick.piloting import (
    CENTRED_STICKS,
    ZERO_STICK_COMMAND,
    FlightLimits,
    Handling,
    StickCommand,
    Sticks,
    heading_velocity,
    within_circle,
)
from workbench.gui.joystick.response_view import axis_responses
from workbench.gui.joystick.state_bar import exceeded_limits_text
from workbench.link.messages import ControlOwner
from workbench.live.messages import Phase
from workbench.live.view import LiveView

STRAIGHT = Handling(8.0, 0.4)


def test_a_tap_near_an_obstacle_is_a_smaller_step(case):
    """A tenth of the stick, of a full stick that takes a second to the obstacle."""
    tap = Sticks(forward=0.1)
    for clearance, asked in ((math.inf, 0.8), (20.0, 0.8), (4.0, 0.4), (1.0, 0.1), (-0.1, 0.05)):
        with case(clearance):
            wish = STRAIGHT.near(clearance).wish(tap)
            assert wish.forward == pytest.approx(asked)
    turn = Sticks(turn=1.0)
    assert STRAIGHT.near(0.1).wish(turn).yaw_rate == -0.4  # turning brings it no nearer


def test_a_stick_stays_in_its_circle():
    assert within_circle(3.0, 4.0) == (0.6, 0.8)
    assert within_circle(0.3, -0.4) == (0.3, -0.4)
    assert within_circle(math.nan, 0.0) == (0.0, 0.0)


@pytest.mark.parametrize(
    ("sticks", "wish"),
    [
        (Sticks(forward=1.0), StickCommand(forward=8.0)),
        (Sticks(forward=-0.5), StickCommand(forward=-4.0)),
        (Sticks(right=1.0), StickCommand(left=-8.0)),
        (Sticks(climb=0.25), StickCommand(climb=2.0)),
        (Sticks(turn=1.0), StickCommand(yaw_rate=-0.4)),
        (CENTRED_STICKS, ZERO_STICK_COMMAND),
    ],
)
def test_sticks_ask_as_in_mode_2(sticks, wish):
    asked = STRAIGHT.wish(sticks)
    assert (asked.forward, asked.left, asked.climb, asked.yaw_rate) == pytest.approx(
        (wish.forward, wish.left, wish.climb, wish.yaw_rate)
    )


@pytest.mark.parametrize(
    ("yaw", "velocity"),
    [(0.0, (3.0, 1.0, 0.5)), (math.pi / 2, (-1.0, 3.0, 0.5)), (math.pi, (-3.0, -1.0, 0.5))],
)
def test_forward_is_where_the_nose_points(yaw, velocity):
    assert StickCommand(3.0, 1.0, 0.5).velocity(yaw) == pytest.approx(velocity)
    assert heading_velocity(velocity, yaw) == pytest.approx((3.0, 1.0, 0.5))


def test_a_limit_is_said_when_a_wish_is_beyond_it(workspace):
    def said(limits, *wish):
        text = exceeded_limits_text(limits, StickCommand(*wish), workspace.preferences)
        return text.replace("\N{NO-BREAK SPACE}", " ")

    limits = FlightLimits().after({"max_speed": 5.0, "max_climb_rate": 2.0, "kp_roll": 1.0})
    assert said(limits, 3.0, 4.0, 2.0, 9.0) == ""  # 5 m/s is the limit itself
    too_fast = "Limit: level speed is held to 5.00 m/s by max_speed, not 5.66 m/s."
    assert said(limits, 4.0, 4.0) == too_fast
    turning = said(limits.after({"max_yaw_rate": 0.2}), 0.0, 0.0, 0.0, -0.3)
    assert "turning is held to 11.5 °/s by max_yaw_rate, not 17.2 °/s" in turning
    climbs = "Limit: climb is held to 2.00 m/s by max_climb_rate, not 3.00 m/s."
    for climb in (3.0, -3.0):
        assert said(limits, 0.0, 0.0, climb) == climbs


class Sent:
    """What a courier sent, and a clock to be set."""

    def __init__(self):
        self.now, self.commands = 0.0, []
        self.courier = CommandSender(self._take, lambda: self.now)

    def _take(self, velocity, yaw_rate):
        self.commands.append((*velocity, yaw_rate))

    def put(self, now, x, yaw_rate=0.0):
        self.now = now
        self.courier.put((x, 0.0, 0.0), yaw_rate)


def test_at_most_thirty_commands_a_second_are_sent():
    sent = Sent()
    for tick in range(1000):
        sent.put(tick / 1000, 1.0 + tick)
    assert 28 <= len(sent.commands) <= 30


def test_an_unchanged_wish_is_repeated_once_a_second():
    sent = Sent()
    for tick in range(310):
        sent.put(tick / 100, 2.0)
    assert sent.commands == [(2.0, 0.0, 0.0, 0.0)] * 4


def test_zero_is_sent_at_once_and_only_once():
    sent = Sent()
    sent.put(0.0, 2.0)
    sent.put(0.001, 0.0)
    sent.put(0.5, 0.0)
    assert sent.commands == [(2.0, 0.0, 0.0, 0.0), (0.0, 0.0, 0.0, 0.0)]


def test_zero_is_not_sent_to_who_was_never_asked():
    sent = Sent()
    sent.put(0.0, 0.0)
    sent.courier.stop()
    assert sent.commands == []


def test_a_trembling_heading_is_no_change():
    sent = Sent()
    sent.put(0.0, 2.0)
    sent.put(0.1, 2.002)
    sent.put(0.2, 2.01)
    sent.put(0.3, 2.01, yaw_rate=0.01)
    assert [command[0] for command in sent.commands] == [2.0, 2.01, 2.01]


def with_mode(view, mode):
    return replace(view, snapshot=replace(view.snapshot, mode=mode))


def test_the_gate_says_why_sticks_do_not_count(canned):
    flying = canned.views[-1]
    assert manual_denial_reason(flying) == ""
    assert manual_denial_reason(with_mode(flying, FlightMode.OFF)) == ON_GROUND_TEXT
    assert manual_denial_reason(with_mode(flying, FlightMode.LANDING)) == LANDING_TEXT
    assert manual_denial_reason(replace(flying, phase=Phase.PAUSED)) == PAUSED_TEXT
    assert manual_denial_reason(LiveView()) != ""


def test_a_stick_held_while_it_did_not_count_must_be_let_go_first():
    gate = CentringGate()
    assert gate.pass_on(PAUSED_TEXT, False, ControlOwner.NOBODY) == PAUSED_TEXT
    assert gate.pass_on("", False, ControlOwner.NOBODY) == CENTRE_STICKS_TEXT
    assert gate.pass_on("", True, ControlOwner.NOBODY) == ""
    assert gate.pass_on("", False, ControlOwner.NOBODY) == ""


def test_a_client_does_not_lose_the_drone_to_a_stick_that_was_held_before():
    gate = CentringGate()
    assert gate.pass_on("", False, ControlOwner.NOBODY) == ""
    assert gate.pass_on("", False, ControlOwner.CLIENT) == CENTRE_STICKS_TEXT
    assert gate.pass_on("", True, ControlOwner.CLIENT) == ""
    assert gate.pass_on("", False, ControlOwner.CLIENT) == ""


def test_the_answer_is_along_the_heading_and_to_the_right(canned):
    snapshot = replace(
        canned.views[-1].snapshot,
        roll_pitch_yaw=(0.0, 0.0, math.pi / 2),  # the nose points to y
        v_WB=(1.0, 2.0, 0.5),
        w_WB=(0.0, 0.0, -0.1),
        reference=(0.0, 3.0, 0.0, 0.2, 0.0, 0.0, 0.0, 0.0),
    )
    rows = axis_responses(snapshot, STRAIGHT, FlightLimits(6.0, 5.0, 0.3))
    flown = [row.flown for row in rows]
    asked = [row.asked for row in rows]
    assert flown == pytest.approx([2.0, 1.0, 0.5, 0.1])
    assert asked == pytest.approx([3.0, 0.0, 0.0, -0.2])
    assert [row.limit for row in rows] == [6.0, 6.0, 5.0, 0.3]


def test_a_drone_on_its_way_to_a_place_is_asked_for_no_speed(canned):
    snapshot = replace(
        canned.views[-1].snapshot, reference=(0.0, 0.0, 0.0, 0.0, 1.0, 2.0, 3.0, 1.0)
    )
    assert [row.asked for row in axis_responses(snapshot, STRAIGHT, FlightLimits())] == [None] * 4
