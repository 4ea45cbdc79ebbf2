import math
import time

import pytest

from workbench.gateways.monitor.pilot import Pilot, Sticks
from workbench.link import Client
from workbench.link.messages import FlightOperation, ReleaseControl, RequestControl

POSITION = (0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0)


class Clock:
    now = 50.0

    def __call__(self):
        return self.now


def said_of(kind, server):
    return [each for each in server.operations if isinstance(each, kind)]


def test_keys_take_control_fly_and_give_it_back(server, fakes):
    clock = Clock()
    with Client(server.address) as client:
        pilot = Pilot(client, clock)
        assert pilot.key("c") and pilot.flying and pilot.said == "you fly"
        pilot.key("+")
        pilot.key("w")
        fakes.wait_until(lambda: server.commands[-1][1][2] == 1.5)
        clock.now += 1.0  # nobody holds the key
        pilot.tick()
        fakes.wait_until(lambda: server.commands[-1][1][2] == 0.0)
        pilot.key("up")
        fakes.wait_until(lambda: server.commands[-1][1][4] == 1.5)
        pilot.key("space")
        fakes.wait_until(lambda: server.commands[-1][1][4] == 0.0)
        for key in "tlx":
            pilot.key(key)
        pilot.key("c")
        assert not pilot.flying
    assert [each.what for each in said_of(FlightOperation, server)] == ["take_off", "land", "stop"]
    assert len(said_of(ReleaseControl, server)) == 1


@pytest.mark.parametrize("key", ["t", "l", "x"])
def test_an_operation_lets_go_of_the_sticks_before_it_waits(server, fakes, key):
    flown = []
    server.answer = lambda peer, operation: (
        flown.append(server.commands[-1][1][2]) if isinstance(operation, FlightOperation) else None
    )
    with Client(server.address) as client:
        pilot = Pilot(client, Clock())
        pilot.key("c")
        pilot.key("w")
        fakes.wait_until(lambda: server.commands[-1][1][2] == 1.0)
        pilot.key(key)
        pilot.release()
    assert flown == [0.0]


def test_a_pilot_who_hangs_is_silent(server, fakes):
    with Client(server.address) as client:
        pilot = Pilot(client, Clock())
        pilot.key("c")
        pilot.key("w")
        fakes.wait_until(lambda: server.commands[-1][1][2] == 1.0)
        count = len(server.commands)
        for step in range(1, 4):  # nobody calls tick; the flight goes on
            server.publish(9_000_000_000 + step * 200_000_000, position_data=POSITION)
        fakes.wait_until(lambda: client.received == 3)
        time.sleep(0.2)  # four repetitions, were there any
        assert len(server.commands) == count
        pilot.tick()
        fakes.wait_until(lambda: len(server.commands) == count + 1)
        pilot.tick()  # the same again: a pilot who is there is heard
        fakes.wait_until(lambda: len(server.commands) == count + 2)
        pilot.release()


def test_without_control_nothing_is_sent(server):
    with Client(server.address) as client:
        pilot = Pilot(client, Clock())
        for key in ("w", "t", "x", "space"):
            pilot.said = ""
            pilot.key(key)
            assert pilot.said == ("" if key == "space" else "press C to take control first")
        assert not pilot.key("z")
        pilot.release()
    assert server.commands == []
    assert said_of(RequestControl, server) == []


def test_a_refusal_is_a_sentence(server):
    server.refuse(RequestControl, "held", "Ada flies")
    with Client(server.address) as client:
        pilot = Pilot(client, Clock())
        pilot.key("c")
        assert not pilot.flying
        assert pilot.said == "refused: Ada flies"


def test_lost_control_is_said_and_not_taken_again(server, fakes):
    with Client(server.address) as client:
        pilot = Pilot(client, Clock())
        pilot.key("c")
        server.say(server.nobody("the operator took over"))
        fakes.wait_until(lambda: client.control_state.reason == "the operator took over")
        fakes.wait_until(lambda: pilot.tick() or not pilot.flying)
        assert pilot.said == "control was lost: the operator took over; press C to ask again"
        pilot.key("w")
    assert len(said_of(RequestControl, server)) == 1
    assert said_of(ReleaseControl, server) == []


@pytest.fixture
def sticks():
    return Sticks(level_speed=8.0, climb_rate=2.0, yaw_rate=0.3)


@pytest.mark.parametrize(
    ("key", "asked"),
    [
        ("w", (1.0, 0.0, 0.0, 0.0)),
        ("s", (-1.0, 0.0, 0.0, 0.0)),
        ("a", (0.0, 1.0, 0.0, 0.0)),
        ("d", (0.0, -1.0, 0.0, 0.0)),
        ("up", (0.0, 0.0, 1.0, 0.0)),
        ("down", (0.0, 0.0, -1.0, 0.0)),
        ("left", (0.0, 0.0, 0.0, 0.3)),
        ("right", (0.0, 0.0, 0.0, -0.3)),
    ],
)
def test_each_key_moves_its_stick(sticks, key, asked):
    assert sticks.press(key, 10.0)
    assert sticks.asked(10.1, yaw=0.0) == pytest.approx(asked)


def test_ahead_is_along_the_heading(sticks):
    sticks.press("w", 0.0)
    assert sticks.asked(0.0, math.pi / 2)[:2] == pytest.approx((0.0, 1.0))
    sticks.let_go()
    sticks.press("a", 0.0)
    assert sticks.asked(0.0, math.pi / 2)[:2] == pytest.approx((-1.0, 0.0))


@pytest.mark.parametrize(
    ("time", "speed"), [(0.0, 1.0), (0.3, 1.0), (0.45, 0.5), (0.6, 0.0), (100.0, 0.0)]
)
def test_a_key_counts_a_while_and_fades(sticks, time, speed):
    sticks.press("w", 5.0)
    assert sticks.asked(5.0 + time, 0.0)[0] == pytest.approx(speed)


def test_a_key_that_comes_again_goes_on(sticks):
    for tick in range(20):
        sticks.press("w", 0.25 * tick)
        assert sticks.asked(0.25 * tick + 0.2, 0.0)[0] == 1.0


def test_the_last_of_two_opposite_keys_counts(sticks):
    sticks.press("w", 0.0)
    sticks.press("s", 0.1)
    assert sticks.asked(0.1, 0.0)[0] == -1.0


def test_two_keys_are_no_faster_than_one(sticks):
    sticks.press("w", 0.0)
    sticks.press("d", 0.0)
    x, y, *_ = sticks.asked(0.0, 0.3)
    assert math.hypot(x, y) == pytest.approx(1.0)


def test_letting_go_stops_at_once(sticks):
    for key in ("w", "a", "up", "left"):
        sticks.press(key, 0.0)
    sticks.let_go()
    assert sticks.asked(0.0, 0.0) == (0.0, 0.0, 0.0, 0.0)


def test_speed_goes_up_and_down_within_the_limits(sticks):
    sticks.press("w", 0.0)
    sticks.press("up", 0.0)
    for _ in range(20):
        sticks.faster()
    assert sticks.speed == 8.0
    assert sticks.asked(0.0, 0.0)[0::2] == pytest.approx((8.0, 2.0))
    for _ in range(20):
        sticks.slower()
    assert sticks.speed == 0.1


def test_other_keys_mean_nothing(sticks):
    assert not sticks.press("z", 0.0)
    assert sticks.asked(0.0, 0.0) == (0.0, 0.0, 0.0, 0.0)
