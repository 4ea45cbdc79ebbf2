"""The blocking client against a scripted server."""

import asyncio
import dataclasses
import inspect
import math
import socket
import subprocess
import sys
import threading
import time

import pytest

from workbench.errors import WorkbenchError
from workbench.link import Client, client
from workbench.link.answers import ByeSaid, Error, Nack, ParametersSaid, Released
from workbench.link.authentication import Tokens
from workbench.link.backplane import Hand, Stage
from workbench.link.client_control import Control
from workbench.link.control import AsyncControl
from workbench.link.operations import (
    FlightOp,
    GetParametersOp,
    Login,
    Ping,
    ReleaseControlOp,
    RequestControlOp,
    SetParametersOp,
    Subscribe,
)
from workbench.link.wire import Frame

TOKENS = Tokens("v" * 16, "c" * 16)
VELOCITY = (1.0, 2.0, 3.0, 4.0, 5.0, 6.0)
REST = (0.0, 0.0, 0.0, 0.0)


def said_of(kind, server):
    return [each for each in server.operations if isinstance(each, kind)]


def test_samples_come_in_order_with_values_by_name(server):
    with Client(server.address, name="me") as client:
        server.publish(5_000_000_000, velocity_data=VELOCITY, rotors=((1.0,) * 4, (2.0,) * 4))
        server.publish(5_004_882_812, velocity_data=VELOCITY)
        first, second, third = (next(client) for _ in range(3))
        assert (first.topic, first.t_ns) == ("/dh_drone/velocity_data", 5_000_000_000)
        assert first["v_x"] == 1.0 and first.values["w_z"] == 6.0
        assert second["thrust"] == (2.0,) * 4
        assert third.time == pytest.approx(5.004882812)
        assert client.latest("velocity_data") is client.latest("/dh_drone/velocity_data")
        assert client.latest("velocity_data").t_ns == third.t_ns
        assert client.latest("gps") is None
        assert client.dropped == 0
        assert client.connected and client.trouble == ""


def test_hello_tells_what_is_flown(server):
    with Client(server.address) as client:
        assert client.hello.vehicle == "dh_drone"
        assert client.hello.limits.level_speed == 8.0
        assert client.hello.topics[0].name == "/dh_drone/time_data"


def test_what_is_wanted_is_asked_for(server):
    with Client(server.address, name="me", topics=["velocity_data", "/x/y"], rate=20.0):
        assert server.operations == [
            Login(1, "me"),
            Subscribe(2, ("/dh_drone/velocity_data", "/x/y"), 20.0),
        ]


def test_each_batch_is_acknowledged(server, fakes):
    with Client(server.address) as client:
        for number in range(5):
            server.publish(number, velocity_data=VELOCITY, on_off_state=(1,))
        for _ in range(10):
            next(client)
        fakes.wait_until(lambda: server.peers[0].acknowledged == server.peers[0].seq)


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
        assert len(said_of(RequestControlOp, server)) == 1
        assert said_of(ReleaseControlOp, server)[0].lease == fakes.LEASE
    stamps = [t_ns for t_ns, _ in server.commands]
    assert server.commands[0] == (6_000_000_000, (fakes.LEASE, 15, 0.0, 0.0, 0.0, 0.0))
    assert {stamp for stamp in stamps} == {6_000_000_000, 6_500_000_000}
    flown = [values for _, values in server.commands if any(values[2:])]
    assert set(flown) == {(fakes.LEASE, 15, 1.0, 2.0, -0.5, 0.25)}
    assert len(flown) >= 5


def test_the_time_is_asked_for_where_no_states_come(server, fakes, monkeypatch):
    monkeypatch.setattr("workbench.link.line.QUIET", 3600.0)  # for which it asks too
    with Client(server.address, topics=()) as client, client.control():
        server.t_ns = 9_000_000_000  # nobody publishes it
        fakes.wait_until(lambda: server.commands and server.commands[-1][0] == 9_000_000_000)
    assert len(said_of(Ping, server)) >= 2


def test_a_flight_faster_than_the_clock_gets_more_commands(server, fakes, monkeypatch):
    monkeypatch.setattr("workbench.link.control.PERIOD", 3600.0)
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
    monkeypatch.setattr("workbench.link.control.PERIOD", 3600.0)
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
        assert len(said_of(ReleaseControlOp, server)) == 1
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
        assert len(said_of(ReleaseControlOp, server)) == 1
        count = len(server.commands)
        time.sleep(0.2)  # four repetitions, were there any
        assert len(server.commands) == count


def test_control_that_another_holds_is_refused(server):
    server.refuse(RequestControlOp, "held", "Ada flies: ask again when control is released")
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
        lambda s, f: s.say(f.ControlStateSaid(Hand.CLIENT, 99, "", Stage.LIVE, 0.0, "another")),
        lambda s, f: s.say(f.ControlStateSaid(Hand.CLIENT, 1, "", Stage.HOLD, 0.5, "silent")),
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
        assert len(said_of(RequestControlOp, server)) == 1
        assert said_of(ReleaseControlOp, server) == []
        with client.control() as c:  # asked again
            c.velocity(0.0, 0.0, 0.0)
        assert len(said_of(RequestControlOp, server)) == 2


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
            isinstance(frame, Frame)
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


def test_a_velocity_that_was_reduced_says_so(server, fakes):
    server.answer = lambda peer, frame: (
        Nack("scaled", "the limit is 8 m/s", seq=frame.seq) if isinstance(frame, Frame) else None
    )
    with Client(server.address) as client, client.control() as c:
        c.velocity(9.0, 0.0, 0.0)
        fakes.wait_until(lambda: c.scaled == "the limit is 8 m/s")
        c.velocity(9.0, 0.0, 0.0)


def test_a_lost_first_command_is_said_again(server, fakes):
    server.answer = lambda peer, frame: (
        Nack("neutral_first", "zero first", seq=frame.seq)
        if isinstance(frame, Frame) and len(server.commands) == 3
        else None
    )
    with Client(server.address) as client, client.control() as c:
        c.velocity(1.0, 0.0, 0.0)
        fakes.wait_until(lambda: len(server.commands) > 4)
        c.velocity(1.0, 0.0, 0.0)
    speeds = [values[2] for _, values in server.commands]
    assert 0.0 in speeds[3:]


def test_flight_operations_and_parameters_are_answered(server, fakes):
    with Client(server.address) as client:
        assert client.parameters() == {"take_off_speed": 0.5}
        with client.control() as c:
            assert c.take_off(2.5) == 5.0
            assert [c.arm(), c.land(), c.stop()] == [5.0] * 3
            assert c.set(take_off_speed=0.25) == {"take_off_speed": 0.25}
    assert [(each.what, each.lease) for each in said_of(FlightOp, server)] == [
        (what, fakes.LEASE) for what in ("take_off", "arm", "land", "stop")
    ]
    assert said_of(FlightOp, server)[0].height == 2.5
    assert said_of(SetParametersOp, server)[0].values == {"take_off_speed": 0.25}


def test_a_refused_request_is_a_sentence(server):
    server.refuse(FlightOp, "not_now", "the drone flies already")
    with Client(server.address) as client, client.control() as c:
        with pytest.raises(WorkbenchError, match="refused: the drone flies already"):
            c.take_off()
        c.velocity(0.0, 0.0, 0.0)


def test_no_answer_is_a_sentence(server):
    usual = server.usual
    server.usual = lambda peer, operation: (
        None if isinstance(operation, GetParametersOp) else usual(peer, operation)
    )
    with Client(server.address) as client:
        inner = client._client
        waiting = inner.request(lambda id: GetParametersOp(id), ParametersSaid, limit=0.05)
        with pytest.raises(WorkbenchError, match=r"gave no answer within 0.05 s"):
            client.call(waiting)
        assert client.ping() == 5.0


def test_an_answer_of_another_kind_is_a_sentence(server):
    server.answer = lambda peer, operation: (
        Released(operation.id) if isinstance(operation, Ping) else None
    )
    with Client(server.address) as client, pytest.raises(WorkbenchError, match="something else"):
        client.ping()


def test_a_lost_connection_is_made_and_subscribed_to_again(server, fakes):
    with Client(server.address, topics=["velocity_data"]) as client:
        server.cut()
        fakes.wait_until(lambda: server.connections == 2 and client.connected)
        server.publish(7_000_000_000, velocity_data=VELOCITY)
        assert next(client).t_ns == 7_000_000_000
        assert [each.topics for each in said_of(Subscribe, server)] == [
            ("/dh_drone/velocity_data",)
        ] * 2


def test_a_server_that_stopped_is_waited_for(server, fakes):
    with Client(server.address) as client:
        server.say(ByeSaid("the flight is over"))
        server.close()
        fakes.wait_until(lambda: "nobody listens" in client.trouble)
        assert not client.connected
        with pytest.raises(WorkbenchError, match="not connected: nobody listens"):
            client.parameters()
        server.listen(server.port)
        fakes.wait_until(lambda: client.connected)
        assert client.parameters()


def test_without_reconnection_the_end_is_an_error_of_the_loop(server):
    with Client(server.address, reconnect=False) as client:
        server.publish(1, velocity_data=VELOCITY)
        server.say(ByeSaid("the flight is over"))
        with pytest.raises(WorkbenchError, match="said goodbye: the flight is over"):
            for sample in client:
                assert sample.t_ns == 1


def test_whom_the_operator_sent_away_does_not_come_back(server):
    with Client(server.address) as client:
        server.say(Error("disconnected", "the operator ended it"))
        with pytest.raises(WorkbenchError, match="the operator ended it"):
            next(client)
    assert server.connections == 1


def test_waiting_requests_end_with_the_connection(server):
    server.answer = lambda peer, operation: server.cut() if isinstance(operation, Ping) else None
    with Client(server.address) as client, pytest.raises(WorkbenchError, match="connection"):
        client.ping()


def test_a_slow_program_gets_the_newest_and_knows_what_it_missed(server, fakes, monkeypatch):
    monkeypatch.setattr("workbench.link.inbox.PATIENCE", -1.0)
    with Client(server.address) as client:
        for number in range(1, 101):
            server.publish(number, velocity_data=VELOCITY)
        fakes.wait_until(lambda: client.latest("velocity_data").t_ns == 100)
        assert next(client).t_ns == 100
        assert client.dropped == 99


def free_port():
    with socket.create_server(("127.0.0.1", 0)) as listener:
        return listener.getsockname()[1]


def test_nobody_listening_is_a_sentence(fakes):
    port = free_port()
    with pytest.raises(WorkbenchError, match=f"nobody listens at 127.0.0.1:{port}: start"):
        Client(f"127.0.0.1:{port}").__enter__()


def test_something_else_listening_is_a_sentence(server):
    server.greet = lambda peer: peer.stream.sendall(b"SSH-2.0-OpenSSH_9.2p1 and what follows\r\n")
    with pytest.raises(WorkbenchError, match="cannot be understood: a frame begins with b'SS'"):
        Client(server.address).__enter__()


def test_a_silent_server_is_a_sentence(server, monkeypatch):
    monkeypatch.setattr("workbench.link.line.LIMIT", 0.1)
    server.greet = lambda peer: None
    with pytest.raises(WorkbenchError, match=r"sends no greeting within 0.1 s: .*TLS\?"):
        Client(server.address).__enter__()


def test_a_server_that_falls_silent_is_left(server, fakes, monkeypatch):
    monkeypatch.setattr("workbench.link.line.QUIET", 0.1)
    with Client(server.address) as client:
        server.answer = lambda peer, operation: None
        server.usual = lambda peer, operation: None
        fakes.wait_until(lambda: "silent" in client.trouble or "greeting" in client.trouble)


def test_tokens_prove_who_commands(fakes):
    server = fakes.FakeServer(TOKENS)
    try:
        with Client(server.address, token=TOKENS.command) as client:
            with client.control() as c:
                c.velocity(1.0, 0.0, 0.0)
                c.land()
                c.set(a=1.0)
            assert len(said_of(SetParametersOp, server)) == 1
            assert server.unproven == []
        with Client(server.address, token=TOKENS.view, role="view") as client:
            assert client.ping() == 5.0
    finally:
        server.close()


@pytest.mark.parametrize(
    ("token", "role", "said"),
    [
        ("", None, "wants a token"),
        (TOKENS.view, None, "the proof is wrong; is the token that of the role 'command'?"),
        (TOKENS.command, "view", "is the token that of the role 'view'?"),
    ],
)
def test_a_wrong_token_is_a_sentence(fakes, token, role, said):
    server = fakes.FakeServer(TOKENS)
    try:
        with pytest.raises(WorkbenchError, match=said.replace("?", r"\?")):
            Client(server.address, token=token, role=role).__enter__()
        assert server.connections == 1
    finally:
        server.close()


@pytest.mark.parametrize(
    ("options", "said"),
    [
        ({"role": "pilot"}, "unknown role 'pilot'"),
        ({"rate": 0.0}, "the rate 0.0 is not within"),
        ({"rate": float("nan")}, "the rate nan"),
        ({"name": "x" * 49}, "at most 48 bytes"),
        ({"name": "a\x1b[2J"}, "that can be printed"),
        ({"address": "h:x"}, "the port 'x'"),
    ],
)
def test_wrong_arguments_are_sentences(options, said):
    with pytest.raises(WorkbenchError, match=said):
        Client(**options)


def test_a_client_that_is_not_open_says_so(server):
    never = Client(server.address)
    for use in (lambda: never.hello, never.parameters, never.control().__enter__):
        with pytest.raises(WorkbenchError, match="not open: write `with Client"):
            use()
    with never:
        pass
    with pytest.raises(WorkbenchError, match="not open"):
        never.parameters()
    with pytest.raises(WorkbenchError, match="opened once"):
        never.__enter__()
    assert list(never) == []


def test_closing_says_goodbye_and_ends_the_thread(server, fakes):
    with Client(server.address):
        assert "link client" in {thread.name for thread in threading.enumerate()}
    assert "link client" not in {thread.name for thread in threading.enumerate()}
    fakes.wait_until(lambda: type(server.operations[-1]).__name__ == "Bye")


def test_a_reader_who_waits_is_let_go_when_the_client_closes(server):
    client = Client(server.address)
    done = []
    with client:
        reader = threading.Thread(target=lambda: done.append(list(client)))
        reader.start()
    reader.join(20.0)
    assert done == [[]]


def test_a_client_that_cannot_begin_is_a_sentence(monkeypatch):
    def fail():
        raise OSError(24, "Too many open files")

    monkeypatch.setattr(asyncio.events, "new_event_loop", fail)
    client = Client("127.0.0.1:1")
    with pytest.raises(WorkbenchError, match="the client cannot begin: .*Too many open files"):
        client.__enter__()
    assert list(client) == []


def break_loop():
    raise SystemExit


def test_nobody_waits_for_a_thread_that_has_ended(server):
    client = Client(server.address)
    with pytest.raises(WorkbenchError, match="thread has ended"), client, client.control() as c:
        client.post(break_loop)
        assert list(client) == []
        for use in (client.ping, lambda: c.velocity(0.0, 0.0, 0.0), client.parameters):
            with pytest.raises(WorkbenchError, match="thread has ended"):
                use()


def test_who_waits_for_an_answer_hears_that_the_thread_has_ended(server):
    usual = server.usual
    client = Client(server.address)

    def never(peer, operation):
        if not isinstance(operation, GetParametersOp):
            return usual(peer, operation)
        client.post(break_loop)
        return None

    server.usual = never
    with pytest.raises(WorkbenchError, match="thread has ended"), client:
        client.parameters()


def test_the_room_is_cheap_to_import():
    code = "import sys, workbench.link; print('asyncio' in sys.modules, 'ssl' in sys.modules)"
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True)
    assert done.stdout.split() == ["False", "False"], done.stderr
    assert client.Client is Client


def test_a_server_without_commands_is_a_sentence(server):
    full = server.hello
    server.hello = lambda peer: dataclasses.replace(full(peer), topics=full(peer).topics[:3])
    with Client(server.address) as client, pytest.raises(WorkbenchError, match="no commands"):
        client.control().__enter__()
    assert said_of(RequestControlOp, server) == []
