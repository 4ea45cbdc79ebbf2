"""The blocking client against a scripted server."""

import asyncio
import dataclasses
import subprocess
import sys
import threading
import time

import pytest

from workbench.common.errors import WorkbenchError
from workbench.link import Client, client
from workbench.link.messages import (
    FlightOperation,
    GetParameters,
    Login,
    ParameterValues,
    Ping,
    ReleaseControl,
    RequestControl,
    SetParameters,
    Subscribe,
)

VELOCITY = (1.0, 2.0, 3.0, 4.0, 5.0, 6.0)


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


def test_flight_operations_and_parameters_are_answered(server, fakes):
    with Client(server.address) as client:
        assert client.parameters() == {"take_off_speed": 0.5}
        with client.control() as c:
            assert c.take_off(2.5) == 5.0
            assert [c.arm(), c.land(), c.stop()] == [5.0] * 3
            assert c.set(take_off_speed=0.25) == {"take_off_speed": 0.25}
    assert [(each.what, each.lease) for each in server.heard(FlightOperation)] == [
        (what, fakes.LEASE) for what in ("take_off", "arm", "land", "stop")
    ]
    assert server.heard(FlightOperation)[0].height == 2.5
    assert server.heard(SetParameters)[0].set == {"take_off_speed": 0.25}


def test_a_refused_request_is_a_sentence(server):
    server.refuse(FlightOperation, "not_now", "the drone flies already")
    with Client(server.address) as client, client.control() as c:
        with pytest.raises(WorkbenchError, match="refused: the drone flies already"):
            c.take_off()
        c.velocity(0.0, 0.0, 0.0)


def test_no_answer_is_a_sentence(server):
    usual = server.usual
    server.usual = lambda peer, operation: (
        None if isinstance(operation, GetParameters) else usual(peer, operation)
    )
    with Client(server.address) as client:
        waiting = client.request(lambda id: GetParameters(id), ParameterValues, limit=0.05)
        with pytest.raises(WorkbenchError, match=r"gave no answer within 0.05 s"):
            client.loop.call(waiting)
        assert client.ping() == 5.0


def test_an_answer_of_another_kind_is_a_sentence(server):
    server.answer = lambda peer, operation: (
        ReleaseControl(operation.id) if isinstance(operation, Ping) else None
    )
    with Client(server.address) as client, pytest.raises(WorkbenchError, match="something else"):
        client.ping()


@pytest.mark.parametrize(
    ("options", "said"),
    [
        ({"role": "pilot"}, "unknown role 'pilot'"),
        ({"rate": 0.0}, "the rate 0.0 is not within"),
        ({"rate": float("nan")}, "the rate nan"),
        ({"name": "x" * 49}, "at most 48 bytes"),
        ({"name": "a\x1b[2J"}, "printable text"),
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
        client.loop.post(break_loop)
        assert list(client) == []
        for use in (client.ping, lambda: c.velocity(0.0, 0.0, 0.0), client.parameters):
            with pytest.raises(WorkbenchError, match="thread has ended"):
                use()


def test_who_waits_for_an_answer_hears_that_the_thread_has_ended(server):
    usual = server.usual
    client = Client(server.address)

    def never(peer, operation):
        if not isinstance(operation, GetParameters):
            return usual(peer, operation)
        client.loop.post(break_loop)
        return None

    server.usual = never
    with pytest.raises(WorkbenchError, match="thread has ended"), client:
        client.parameters()


def test_a_loop_that_is_closed_is_a_sentence_before_its_thread_has_ended(monkeypatch, server):
    run, told = asyncio.run, threading.Event()

    def run_and_wait(work):
        try:
            run(work)
        finally:
            told.wait(20.0)

    monkeypatch.setattr(asyncio, "run", run_and_wait)
    client = Client(server.address)
    client.__enter__()
    loop = client.loop._loop.result()
    client.loop.post(break_loop)
    while not loop.is_closed():
        time.sleep(0.001)
    for use in (client.ping, lambda: client.loop.post(break_loop)):
        with pytest.raises(WorkbenchError, match="thread has ended"):
            use()
    told.set()
    client.loop.stop()


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
    assert server.heard(RequestControl) == []
