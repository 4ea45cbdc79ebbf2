"""The real process, over real sockets of this machine."""

import asyncio
import contextlib
import os
import re
import signal
import socket
import ssl
import struct
import subprocess
import sys
import time
from multiprocessing import Pipe
from pathlib import Path

import pytest

from workbench.common.errors import WorkbenchError
from workbench.link import Client
from workbench.link.backplane import (
    ClientDisconnected,
    ClientRequest,
    Reply,
    ServerFailed,
    ServerStatus,
    VelocityCommand,
)
from workbench.link.messages import (
    ControlOwner,
    ControlState,
    LinkLossStage,
    ReleaseControl,
    RequestControl,
)
from workbench.link.server.acceptor import MAX_BEGUN_CONNECTIONS, MAX_PENDING_CONNECTIONS
from workbench.link.server.config import ServerConfig
from workbench.link.server.process import FlightConnection

ANY = ServerConfig(port=0)
RESET = struct.pack("ii", 1, 0)
LIMIT = 300.0
"""Generous: a busy machine is no failure [s]."""


def test_the_certificate_of_the_page_serves_a_client_that_checks_it(serve, tmp_path):
    """The command as docs/link.md has it, but for the address."""
    page = (Path(__file__).resolve().parents[3] / "docs" / "link.md").read_text(encoding="utf-8")
    [command] = re.findall(r"^openssl req .*?[^\\]$", page, re.DOTALL | re.MULTILINE)
    command = command.replace("192.168.1.20", "127.0.0.1")
    subprocess.run(command, shell=True, cwd=tmp_path, check=True, capture_output=True)
    cert, key = tmp_path / "drone.pem", tmp_path / "drone.key"
    config = ServerConfig(port=0, tls_cert=str(cert), tls_key=str(key))
    server = serve(config)
    with Client(f"127.0.0.1:{server.port}", tls=str(cert), reconnect=False) as client:
        assert client.hello.vehicle == "x500"
    key.chmod(0o640)
    with pytest.raises(WorkbenchError, match=r"others may read .* \(mode 0640\): run chmod 600"):
        config.check()


def descriptors(server):
    """Count its open files but /dev/null, which its loop keeps open from the first accept on."""
    found = 0
    for each in Path(f"/proc/{server.process.pid}/fd").iterdir():
        with contextlib.suppress(FileNotFoundError):  # closed meanwhile
            found += str(each.readlink()) != "/dev/null"
    return found


def wait_until(fits):
    end = time.monotonic() + LIMIT
    while not fits():
        assert time.monotonic() < end
        time.sleep(0.02)


def test_it_says_where_it_listens_and_serves(serve, parts):
    server = serve(ANY)
    assert isinstance(server.begun, ServerStatus)
    assert server.begun.address == f"127.0.0.1:{server.port}"
    with server.client() as client:
        assert client.answer("hello")["vehicle"] == "x500"
        client.send(parts.operation("subscribe", topics=["/dh_drone/time_data"]))
        client.answer("subscribe")
        server.flight.send(parts.published(3))
        frame = client.frame()
        assert (frame.topic, frame.flags, frame.t_ns) == (1, 2, 14648438)
        client.send(parts.acknowledgement(frame.seq), parts.command(6))
        assert server.hear_of(VelocityCommand).seq == 6
        client.send(parts.operation("request_control", 7, id=3, name="me"))
        assert server.hear_of(ClientRequest) == ClientRequest(1, RequestControl(3, "me"))
        server.flight.send(Reply(1, RequestControl(3, lease=5, expires=0.5)))
        assert client.answer("request_control")["lease"] == 5
        status = server.hear_of(ServerStatus, lambda record: record.clients)
        assert status.clients[0].address.startswith("127.0.0.1:")
    assert server.hear_of(ClientDisconnected) == ClientDisconnected(1)


def test_it_loads_neither_drake_nor_numpy():
    code = (
        "import sys, workbench.link.server.process\n"
        "print([n for n in ('pydrake', 'numpy', 'PyQt6', 'websockets') if n in sys.modules])"
    )
    root = Path(__file__).resolve().parents[3]
    done = subprocess.run([sys.executable, "-c", code], cwd=root, capture_output=True, check=True)
    assert done.stdout.strip() == b"[]"


def test_a_port_in_use_is_said_in_a_sentence(serve):
    with socket.create_server(("127.0.0.1", 0)) as taken:
        port = taken.getsockname()[1]
        server = serve(ServerConfig(port=port))
        assert isinstance(server.begun, ServerFailed)
        assert server.begun.said.startswith(f"port {port} at 127.0.0.1 is in use")


@pytest.mark.parametrize(
    ("config", "said"),
    [
        (ServerConfig("0.0.0.0", port=0), "others can reach 0.0.0.0"),
        (ServerConfig(port=0, token_file="/nowhere"), "/nowhere"),
        (ServerConfig(port=0, tls_cert="/nowhere", tls_key="/nowhere"), "/nowhere"),
    ],
)
def test_what_cannot_be_had_is_said_in_a_sentence(serve, config, said):
    server = serve(config)
    assert isinstance(server.begun, ServerFailed)
    assert said in server.begun.said


def test_an_address_of_another_machine_is_said_in_a_sentence(serve, tmp_path, certificate):
    cert, key = certificate
    path = tmp_path / "tokens"
    path.write_text("view: " + "v" * 20 + "\ncommand: " + "c" * 20 + "\n")
    path.chmod(0o600)
    server = serve(
        ServerConfig("203.0.113.1", port=0, token_file=str(path), tls_cert=cert, tls_key=key)
    )
    assert "203.0.113.1 is not an address of this machine" in server.begun.said


def test_it_says_goodbye_when_it_is_stopped(serve):
    server = serve(ANY)
    with server.client() as client:
        client.answer("hello")
        assert server.stop() == ""
        assert client.rest() == [{"op": "bye", "said": "the server stops"}]
    assert server.process.returncode == 0


def test_it_ends_with_its_flight(serve):
    server = serve(ANY)
    with server.client() as client:
        client.answer("hello")
        server.flight.close()
        assert client.rest()[-1]["op"] == "bye"
        assert server.process.wait(LIMIT) == 0


def test_what_is_no_frame_is_told_so_before_the_end(serve):
    server = serve(ANY)
    with server.client() as client:
        client.send(b"GET / HTTP/1.1\r\nHost: me\r\n\r\n" * 100)
        assert [each.get("code") for each in client.rest()] == [None, "magic"]


def test_a_reset_is_a_client_that_has_gone(serve, parts):
    server = serve(ANY)
    client = server.client()
    client.send(parts.command())
    server.hear_of(VelocityCommand)
    client.socket.setsockopt(socket.SOL_SOCKET, socket.SO_LINGER, RESET)
    client.socket.close()
    assert server.hear_of(ClientDisconnected) == ClientDisconnected(1)


def test_half_a_frame_and_then_nothing_is_a_client_that_has_gone(serve, parts):
    server = serve(ANY)
    with server.client() as client:
        client.send(parts.command(), parts.command().to_bytes()[:30])
        server.hear_of(VelocityCommand)
        client.socket.shutdown(socket.SHUT_WR)
        assert server.hear_of(ClientDisconnected) == ClientDisconnected(1)


def test_a_crowd_of_connections_leaves_nothing_behind(serve):
    server = serve(ANY)
    with server.client() as steady:
        steady.answer("hello")
        before = descriptors(server)
        crowd = [server.client() for _ in range(MAX_BEGUN_CONNECTIONS + 200)]
        server.hear_of(ServerStatus, lambda record: record.refusals.get("too_many", 0) > 200)
        assert descriptors(server) <= before + MAX_BEGUN_CONNECTIONS + MAX_PENDING_CONNECTIONS
        for each in crowd:
            each.socket.close()
        wait_until(lambda: descriptors(server) == before)
        server.hear_of(ServerStatus, lambda record: len(record.clients) == 1)


def test_a_client_beyond_the_places_is_told_so(serve):
    server = serve(ANY)
    clients = [server.client() for _ in range(12)]
    for each in clients:
        each.answer("hello")
    with server.client() as late:
        assert [each["code"] for each in late.rest()] == ["too_many"]
    with server.client(source="127.0.0.2") as other:
        other.answer("hello")
    for each in clients:
        each.socket.close()


@pytest.mark.slow  # five seconds by the clock, which test_hub.py simulates
def test_a_client_that_stops_reading_is_out_and_others_get_everything(serve, parts):
    server = serve(ANY)
    with server.client() as still, server.client() as good:
        for client in (still, good):
            client.send(parts.operation("subscribe", topics=["*"]))
        good.answer("subscribe")
        times = []
        begun = time.monotonic()
        step = 0
        while time.monotonic() < begun + LIMIT:
            step += 1
            server.flight.send(parts.published(step, (1, 2)))
            for _ in range(2):
                frame = good.frame()
                if frame.flags & 2:
                    good.send(parts.acknowledgement(frame.seq))
                times.append(frame.t_ns)
            if server.flight.poll():
                record = server.flight.recv()
                if isinstance(record, ServerStatus) and "slow" in record.refusals:
                    break
            time.sleep(0.01)
        assert time.monotonic() - begun >= 4.5
        assert times == [round(n * 1e9 / 204.8) for n in range(1, step + 1) for _ in "12"]
        assert still.rest()[-1]["code"] == "slow"


@pytest.mark.slow
def test_a_flight_that_stands_still_harms_no_client(serve, parts):
    server = serve(ANY)
    with server.client() as client:
        client.answer("hello")
        for seq in range(1, 600):  # nobody reads these at the flight's end
            client.send(parts.command(seq))
        client.send(parts.operation("ping", 600))
        assert client.answer("pong")
        commands = []
        while not commands or commands[-1].seq < 599:
            commands.append(server.hear_of(VelocityCommand))
        assert len(commands) < 300
        assert [each.seq for each in commands] == sorted(each.seq for each in commands)


def test_who_commands_is_told_to_who_comes_later(serve):
    server = serve(ANY)
    server.flight.send(
        ControlState(ControlOwner.OPERATOR, 0, "operator", LinkLossStage.LIVE, 0.0, "it pleased")
    )
    with server.client() as client:
        assert client.answer("control_state")["hand"] == "operator"


def test_tls_serves_as_tcp_does(serve, parts, certificate):
    cert, key = certificate
    server = serve(ServerConfig(port=0, tls_cert=cert, tls_key=key))
    context = ssl.create_default_context(cafile=cert)
    with server.client(context=context) as client:
        client.answer("hello")
        client.send(parts.operation("subscribe", topics=["*"]))
        client.answer("subscribe")
        server.flight.send(parts.published(1))
        assert client.frame().topic == 1
        status = server.hear_of(ServerStatus, lambda record: record.clients)
        assert status.clients[0].transport == "tls"
        client.send(b"nonsense")
        assert client.rest()[-1]["code"] == "magic"


def test_a_plain_client_at_a_tls_port_is_refused_and_counted(serve, parts, certificate):
    cert, key = certificate
    server = serve(ServerConfig(port=0, tls_cert=cert, tls_key=key))
    with server.client() as client:
        client.send(parts.operation("ping"))
        try:
            while client.socket.recv(1000):
                pass
        except ConnectionResetError:
            pass
    status = server.hear_of(ServerStatus, lambda record: record.refusals)
    assert status.refusals == {"tls": 1}
    assert "connect with TLS" in status.log[-1]


@pytest.mark.slow
def test_who_never_shakes_hands_takes_no_place(serve, certificate):
    cert, key = certificate
    server = serve(ServerConfig(port=0, tls_cert=cert, tls_key=key))
    before = descriptors(server)
    silent = [server.client() for _ in range(60)]
    wait_until(lambda: descriptors(server) == before)
    for each in silent:
        each.socket.close()
    server.hear_of(ServerStatus, lambda record: sum(record.refusals.values()) == 60)


def test_a_crowd_of_who_never_shakes_hands_keeps_nobody_out(serve, certificate):
    cert, key = certificate
    server = serve(ServerConfig(port=0, tls_cert=cert, tls_key=key))
    context = ssl.create_default_context(cafile=cert)
    silent = [server.client() for _ in range(MAX_BEGUN_CONNECTIONS + 16)]
    server.hear_of(ServerStatus, lambda record: record.refusals.get("too_many", 0) >= 16)
    with server.client(context=context) as client:
        assert client.answer("hello")
    for each in silent:
        each.socket.close()


def test_a_server_that_was_killed_leaves_its_clients_with_an_end(serve):
    server = serve(ANY)
    with server.client() as client:
        client.answer("hello")
        os.kill(server.process.pid, signal.SIGKILL)
        assert client.rest() == []


def command(peer, seq):
    return VelocityCommand(peer, seq, 0, 7, 15, (0.0, 0.0, 0.0), 0.0)


def test_records_go_both_ways_and_its_end_is_noticed():
    here, there = Pipe()

    async def run():
        heard, ended = [], asyncio.Event()
        side = FlightConnection(here)
        side.tell(command(1, 1))
        side.start(heard.extend, ended.set)
        assert await asyncio.to_thread(there.recv) == command(1, 1)
        await asyncio.to_thread(lambda: [there.send(number) for number in range(10_000)])
        there.close()
        await asyncio.wait_for(ended.wait(), LIMIT)
        await side.close()
        return heard

    assert asyncio.run(run()) == list(range(10_000))


def test_a_flight_that_stands_still_is_not_waited_for():
    """More than the buffer holds: the loop goes on, and all arrives once the flight reads."""
    here, there = Pipe()

    async def run():
        side = FlightConnection(here)
        side.start(lambda records: None, lambda: None)
        for peer in range(1, 2001):
            side.tell(command(peer, 1))
        found = await asyncio.to_thread(lambda: [there.recv().peer for _ in range(2000)])
        await side.close()
        return found

    assert asyncio.run(run()) == list(range(1, 2001))
    there.close()


def status(page):
    return ServerStatus("a:1", page, (), {}, ())


ASKS = ClientRequest(3, RequestControl(1, "me"))
RELEASES = ClientRequest(3, ReleaseControl(2, 77))
COMMANDS = [command(3, seq) for seq in range(6)]


@pytest.mark.parametrize(
    ("told", "sent"),
    [
        (  # the first one may be the neutral one that a new holder has to begin with
            [command(peer, seq) for seq in range(1000) for peer in (1, 2)],
            [command(1, 0), command(2, 0), command(1, 999), command(2, 999)],
        ),
        (  # a command never comes before what was asked before it
            [*COMMANDS[:2], ASKS, command(2, 5), *COMMANDS[2:5]],
            [*COMMANDS[:2], ASKS, command(2, 5), COMMANDS[2], COMMANDS[4]],
        ),
        ([status(page) for page in "abc"], [status("c")]),
        (
            [ASKS, COMMANDS[1], ClientDisconnected(3)],
            [],
        ),  # of who was never heard of, nothing counts
    ],
)
def test_of_what_waits_the_newest_counts(told, sent):
    assert what_a_flight_gets([], told) == sent


@pytest.mark.parametrize(
    ("told", "sent"),
    [
        (
            [COMMANDS[2], RELEASES, ClientDisconnected(3)],
            [RELEASES, ClientDisconnected(3)],
        ),  # goodbye undoes no release
        ([COMMANDS[2], ClientDisconnected(3)], [ClientDisconnected(3)]),
    ],
)
def test_what_a_client_asked_before_it_went_counts_if_the_flight_knows_it(told, sent):
    assert what_a_flight_gets([ASKS], told) == [ASKS, *sent]


def what_a_flight_gets(before, told):
    """Return what a flight reads that had read some records, stood still, and then goes on."""
    here, there = Pipe()
    filler = ClientRequest(9, RequestControl(0, "x" * 900_000))  # more than any buffer holds

    async def run():
        connection = FlightConnection(here)
        connection.start(lambda records: None, lambda: None)
        for record in before:
            connection.tell(record)
        connection.tell(filler)
        for record in told:
            connection.tell(record)
        connection.tell(ClientRequest(9, RequestControl(0, "end")))

        def read():
            found = []
            while (record := there.recv()) != ClientRequest(9, RequestControl(0, "end")):
                found.append(record)
            return found

        found = await asyncio.to_thread(read)
        await connection.close()
        return [record for record in found if record != filler]

    try:
        return asyncio.run(run())
    finally:
        there.close()
