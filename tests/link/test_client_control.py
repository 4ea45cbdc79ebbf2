"""A program that commands: its velocity, how long it counts, and how control ends."""

import inspect
import math
import time

import pytest

from workbench.common.errors import WorkbenchError
from workbench.link import Client
from workbench.link.control import AsyncControl, Control
from workbench.link.messages import (
    ControlOwner,
    LinkLossStage,
    Nack,
    Ping,
    ReleaseControl,
    RequestControl,
)
from workbench.link.wire import WireFrame

VELOCITY = (1.0, 2.0, 3.0, 4.0, 5.0, 6.0)
REST = (0.0, 0.0, 0.0, 0.0)


def test_control_begins_neutral_repeats_itself_and_is_released(server, fakes):
    with Client(server.address, name="me") as client:
        server.publish(6_000_000_000, velocity_data=VELOCITY)
        next(client)
        with client.control() as c:
            fakes.wait_until(lambda: server.commands)
            c.velocity(1.0, 2.0, -0.5, 0.25)
            fakes.wait_until(lambda: len(server.commands) > 6)
            server.publish(6_500_000_000, velocity_data=VELOCITY)
            fakes.wait_until(lambda: server.commands[-1][0] == 6_500_000_000)
            assert c.lost == ""
        assert len(server.heard(RequestControl)) == 1
        assert server.heard(ReleaseControl)[0].lease == fakes.LEASE
    stamps = [t_ns for t_ns, _ in server.commands]
    assert server.commands[0] == (6_000_000_000, (fakes.LEASE, 15, 0.0, 0.0, 0.0, 0.0))
    assert {stamp for stamp in stamps} == {6_000_000_000, 6_500_000_000}
    flown = [values for _, values in server.commands if any(values[2:])]
    assert set(flown) == {(fakes.LEASE, 15, 1.0, 2.0, -0.5, 0.25)}
    assert len(flown) >= 5


def test_the_time_is_asked_for_where_no_states_come(server, fakes, monkeypatch):
    monkeypatch.setattr("workbench.link.connection.PING_AFTER_S", 3600.0)  # for which it asks too
    with Client(server.address, topics=()) as client, client.control():
        server.t_ns = 9_000_000_000  # nobody publishes it
        fakes.wait_until(lambda: server.commands and server.commands[-1][0] == 9_000_000_000)
    assert len(server.heard(Ping)) >= 2


def test_a_flight_faster_than_the_clock_gets_more_commands(server, fakes, monkeypatch):
    monkeypatch.setattr("workbench.link.control.COMMAND_PERIOD_S", 3600.0)
    with Client(server.address) as client, client.control():
        fakes.wait_until(lambda: server.commands)
        for step in range(1, 41):
            t_ns = 6_000_000_000 + step * 200_000_000
            server.publish(t_ns, velocity_data=VELOCITY)
            fakes.wait_until(lambda t_ns=t_ns: server.commands[-1][0] == t_ns)


def test_a_velocity_lapses_where_the_program_says_nothing_more(server, fakes):
    with Client(server.address) as client, client.control() as c:
        c.velocity(1.0, 0.0, 0.0, hold=0.2)
        fakes.wait_until(lambda: any(values[2] for _, values in server.commands))
        fakes.wait_until(lambda: server.commands[-1][1][2] == 0.0)
        count = len(server.commands)
        fakes.wait_until(lambda: len(server.commands) > count)  # it still has the drone
        assert c.lost == ""
        c.velocity(1.0, 0.0, 0.0, hold=math.inf)
        fakes.wait_until(lambda: server.commands[-1][1][2] == 1.0)


def test_a_velocity_lapses_in_a_flight_faster_than_the_clock(server, fakes, monkeypatch):
    monkeypatch.setattr("workbench.link.control.COMMAND_PERIOD_S", 3600.0)
    with Client(server.address) as client, client.control() as c:
        c.velocity(1.0, 0.0, 0.0, hold=1e-9)
        fakes.wait_until(lambda: server.commands[-1][1][2] == 1.0)
        server.publish(9_000_000_000, velocity_data=VELOCITY)
        fakes.wait_until(lambda: server.commands[-1] == (9_000_000_000, (fakes.LEASE, 15) + REST))


def test_a_velocity_that_counts_for_two_seconds_is_the_rule():
    for kind in (Control, AsyncControl):
        assert inspect.signature(kind.velocity).parameters["hold"].default == 2.0


@pytest.mark.parametrize("hold", [0.0, -1.0, math.nan])
def test_a_velocity_for_no_time_is_refused(server, hold):
    with (
        Client(server.address) as client,
        client.control() as c,
        pytest.raises(WorkbenchError, match="cannot be held for"),
    ):
        c.velocity(1.0, 0.0, 0.0, hold=hold)
    assert all(not any(values[2:]) for _, values in server.commands)


def test_direct_control_repeats_nothing(server, fakes):
    with Client(server.address) as client:
        with client.direct_control() as c:
            c.velocity(1.0, 0.0, 0.0)
            fakes.wait_until(lambda: len(server.commands) == 2)
            server.publish(9_000_000_000, velocity_data=VELOCITY)
            assert next(client).t_ns == 9_000_000_000
            time.sleep(0.2)  # four repetitions, were there any
            assert len(server.commands) == 2
            c.velocity(2.0, 0.0, 0.0)
            fakes.wait_until(lambda: len(server.commands) == 3)
            assert c.land() == 9.0
        assert len(server.heard(ReleaseControl)) == 1
    assert [values[2] for _, values in server.commands] == [0.0, 1.0, 2.0]


def test_a_refusal_of_an_older_lease_says_nothing_of_this_one(server, fakes):
    with Client(server.address) as client:
        with client.control() as c:
            c.velocity(1.0, 0.0, 0.0)
            fakes.wait_until(lambda: len(server.commands) > 4)
        with client.control() as c:
            # The older lease had at least four frames: subscription, ping, request, command.
            for code in ("not_holder", "too_fast", "scaled", "neutral_first"):
                server.say(Nack(code, "late", seq=5))
            client.ping()  # they have been heard
            assert (c.lost, c.scaled) == ("", "")
            c.velocity(1.0, 0.0, 0.0)


def test_control_is_released_after_an_exception(server):
    with Client(server.address) as client:
        with pytest.raises(ZeroDivisionError), client.control():
            1 / 0  # noqa: B018
        assert len(server.heard(ReleaseControl)) == 1
        count = len(server.commands)
        time.sleep(0.2)  # four repetitions, were there any
        assert len(server.commands) == count


def test_control_that_another_holds_is_refused(server):
    server.refuse(RequestControl, "held", "Ada flies: ask again when control is released")
    with (
        Client(server.address) as client,
        pytest.raises(WorkbenchError, match="Ada flies"),
        client.control(),
    ):
        raise AssertionError
    assert server.commands == []


@pytest.mark.parametrize(
    "lose",
    [
        lambda s, f: s.cut(),
        lambda s, f: s.say(s.nobody("the operator took over")),
        lambda s, f: s.say(
            f.ControlState(ControlOwner.CLIENT, 99, "", LinkLossStage.LIVE, 0.0, "another")
        ),
        lambda s, f: s.say(
            f.ControlState(ControlOwner.CLIENT, 1, "", LinkLossStage.HOLD, 0.5, "silent")
        ),
        lambda s, f: s.say(Nack("not_holder", "the lease is another's", seq=99)),
    ],
)
def test_lost_control_raises_at_the_next_call_and_is_not_taken_again(server, fakes, lose):
    with Client(server.address) as client:
        with client.control() as c:
            c.velocity(1.0, 0.0, 0.0)
            lose(server, fakes)
            fakes.wait_until(lambda: c.lost)
            for call in (lambda: c.velocity(1.0, 0.0, 0.0), c.land, lambda: c.set(a=1.0)):
                with pytest.raises(WorkbenchError, match="control was lost: .*; ask again"):
                    call()
        fakes.wait_until(lambda: client.connected)
        assert len(server.heard(RequestControl)) == 1
        assert server.heard(ReleaseControl) == []
        with client.control() as c:  # asked again
            c.velocity(0.0, 0.0, 0.0)
        assert len(server.heard(RequestControl)) == 2


def test_a_control_block_that_is_left_cannot_be_used(server):
    with Client(server.address) as client:
        with client.control() as c:
            pass
        with pytest.raises(WorkbenchError, match="it was released"):
            c.velocity(0.0, 0.0, 0.0)
        with pytest.raises(WorkbenchError, match="nobody asked for control"):
            client.control().velocity(0.0, 0.0, 0.0)


@pytest.mark.parametrize("number", [float("nan"), float("inf"), 1e300])
def test_no_velocity_is_refused_before_it_is_sent(server, number):
    with Client(server.address) as client, client.control() as c:
        with pytest.raises(WorkbenchError, match="must be finite numbers"):
            c.velocity(0.0, number, 0.0)
        c.velocity(0.0, 0.0, 0.0)
    assert all(not any(values[2:]) for _, values in server.commands)


def test_a_velocity_that_was_refused_raises_once_and_stops(server, fakes):
    def too_fast(peer, frame):
        if (
            isinstance(frame, WireFrame)
            and fakes.BY_NAME["command_velocity"].unpack(frame.payload)["v_x"]
        ):
            return Nack("too_fast", "the level speed is 99 m/s", seq=frame.seq)
        return None

    server.answer = too_fast
    with Client(server.address) as client, client.control() as c:
        c.velocity(99.0, 0.0, 0.0)
        fakes.wait_until(lambda: len(server.commands) > 5)
        with pytest.raises(WorkbenchError, match="the level speed is 99 m/s"):
            c.velocity(98.0, 0.0, 0.0)
        c.velocity(0.0, 0.0, 0.0)
        assert server.commands[-1][1][2] == 0.0


def test_refusals_of_what_was_told_already_are_not_told_again(server, fakes):
    """Repetitions are on their way while the first refusal comes back."""
    seqs = []

    def note(peer, frame):
        if isinstance(frame, WireFrame) and server.commands[-1][1][2] == 99.0:
            seqs.append(frame.seq)

    server.answer = note
    with Client(server.address) as client, client.control() as c:
        c.velocity(99.0, 0.0, 0.0)
        fakes.wait_until(lambda: len(seqs) > 2)
        server.say(Nack("too_fast", "99 m/s", seq=seqs[0]))
        client.ping()  # it has been heard
        with pytest.raises(WorkbenchError, match="99 m/s"):
            c.velocity(1.0, 0.0, 0.0)
        server.say(Nack("too_fast", "99 m/s", seq=seqs[1]))
        client.ping()
        c.velocity(1.0, 0.0, 0.0)


def test_a_velocity_that_was_reduced_says_so(server, fakes):
    server.answer = lambda peer, frame: (
        Nack("scaled", "the limit is 8 m/s", seq=frame.seq)
        if isinstance(frame, WireFrame)
        else None
    )
    with Client(server.address) as client, client.control() as c:
        c.velocity(9.0, 0.0, 0.0)
        fakes.wait_until(lambda: c.scaled == "the limit is 8 m/s")
        c.velocity(9.0, 0.0, 0.0)


def test_a_lost_first_command_is_said_again(server, fakes):
    server.answer = lambda peer, frame: (
        Nack("neutral_first", "zero first", seq=frame.seq)
        if isinstance(frame, WireFrame) and len(server.commands) == 3
        else None
    )
    with Client(server.address) as client, client.control() as c:
        c.velocity(1.0, 0.0, 0.0)
        fakes.wait_until(lambda: len(server.commands) > 4)
        c.velocity(1.0, 0.0, 0.0)
    speeds = [values[2] for _, values in server.commands]
    assert 0.0 in speeds[3:]
