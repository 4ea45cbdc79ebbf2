"""A live flight and its server's process: begun and ended while it flies, and neither harms it."""

import contextlib
import math
import os
import signal
import socket
import threading
import time
from itertools import pairwise
from multiprocessing import Pipe
from pathlib import Path

import pytest

from workbench.common.errors import WorkbenchError
from workbench.ipc.worker_process import WorkerResult
from workbench.link import Client
from workbench.link.backplane import ServerStatus
from workbench.link.messages import ControlOwner, LinkLossStage
from workbench.link.server.config import ServerConfig
from workbench.live.flight import LiveFlight
from workbench.live.messages import Phase
from workbench.live.server_supervisor import ServerSupervisor

ENOUGH = 300.0
"""No test waits so long unless it fails [s]."""
EVENTS, PARAMETERS = "/dh_drone/events", "/dh_drone/parameters"


def wait_for(condition) -> None:
    end = time.monotonic() + ENOUGH
    while not condition():
        assert time.monotonic() < end, "it does not come about"
        time.sleep(0.01)


def children(pid: int) -> list[int]:
    text = Path(f"/proc/{pid}/task/{pid}/children").read_text()
    return [int(each) for each in text.split()]


def is_running(pid: int) -> bool:
    try:
        stat = Path(f"/proc/{pid}/stat").read_text()
    except (FileNotFoundError, ProcessLookupError):
        return False
    return stat.rpartition(")")[2].split()[0] not in "ZX"


def assert_flies_on(flight: LiveFlight) -> None:
    before = flight.latest().snapshot.time
    wait_for(lambda: flight.latest().snapshot.time > before + 0.05)
    assert flight.latest().phase is Phase.FLYING


@pytest.fixture(scope="module")
def flown():
    with LiveFlight() as flight:
        flight.wait(ENOUGH)
        yield flight
    assert not is_running(flight.pid)


@pytest.fixture
def flight(flown):
    """A flight that nobody serves."""
    yield flown
    flown.resume().result(ENOUGH)
    flown.stop_serving().result(ENOUGH)
    flown.stop_log().result(ENOUGH)
    flown.give_back().result(ENOUGH)
    wait_for(lambda: children(flown.pid) == [])
    assert_flies_on(flown)


@pytest.fixture
def address(flight):
    return flight.serve(ServerConfig(port=0)).result(ENOUGH)


def served(flight: LiveFlight) -> ServerStatus:
    wait_for(lambda: flight.latest().network.server is not None)
    return flight.latest().network.server


def test_a_flight_is_served_stopped_and_served_again_at_the_same_port(flight, address):
    port = int(address.rpartition(":")[2])
    for _ in range(3):
        with Client(address, reconnect=False) as client:
            assert client.hello.vehicle == "dh_drone"
            assert served(flight).address == address
            flight.stop_serving().result(ENOUGH)
            wait_for(lambda client=client: not client.connected)
            assert "goodbye" in client.trouble
        wait_for(lambda: flight.latest().network.server is None)
        assert flight.latest().network.said == ""
        assert_flies_on(flight)
        assert flight.serve(ServerConfig(port=port)).result(ENOUGH) == address


def test_orders_to_stop_and_serve_do_not_wait_for_each_other(flight, address):
    """Given all at once: the last server's port is free when the next one begins."""
    port = int(address.rpartition(":")[2])
    begun = []
    for _ in range(3):
        flight.stop_serving()
        begun.append(flight.serve(ServerConfig(port=port)))
    assert begun[-1].result(ENOUGH) == address
    for each in begun[:-1]:
        assert str(each.exception(ENOUGH)) == "the server was stopped"


def test_a_server_that_is_stopped_before_it_begins_says_so(flight):
    begun, stopped = flight.serve(ServerConfig(port=0)), flight.stop_serving()
    assert str(begun.exception(ENOUGH)) == "the server was stopped"
    stopped.result(ENOUGH)
    assert children(flight.pid) == []


@pytest.mark.parametrize(
    ("config", "word"),
    [
        (ServerConfig(port=70000), "70000"),
        (ServerConfig(port=-1), "-1"),
        (ServerConfig(host="no.such.host.invalid"), "no.such.host.invalid"),
        (ServerConfig(host="0.0.0.0", port=0), "token"),
        (ServerConfig(port=0, token_file="/nowhere/tokens"), "/nowhere/tokens"),
        (ServerConfig(port=0, tls_cert="/nowhere/cert.pem"), "key"),
    ],
    ids=["port", "negative", "host", "remote", "tokens", "certificate"],
)
def test_a_bad_configuration_is_a_sentence(flight, config, word):
    error = flight.serve(config).exception(ENOUGH)
    assert isinstance(error, WorkbenchError)
    assert word in str(error)
    assert "\n" not in str(error)
    assert_flies_on(flight)
    wait_for(lambda: children(flight.pid) == [])


def test_a_port_in_use_is_a_sentence_and_the_flight_goes_on(flight):
    with contextlib.closing(socket.create_server(("127.0.0.1", 0))) as taken:
        port = taken.getsockname()[1]
        error = flight.serve(ServerConfig(port=port)).exception(ENOUGH)
        assert isinstance(error, WorkbenchError)
        assert f"port {port}" in str(error)
        wait_for(lambda: flight.latest().network.said == str(error))
        assert flight.latest().network.server is None
        assert_flies_on(flight)
    assert flight.serve(ServerConfig(port=port)).result(ENOUGH) == f"127.0.0.1:{port}"


def test_there_is_one_server(flight):
    first, second = (flight.serve(ServerConfig(port=0)) for _ in range(2))
    assert "already" in str(second.exception(ENOUGH))
    address = first.result(ENOUGH)
    assert "already" in str(flight.serve(ServerConfig(port=0)).exception(ENOUGH))
    assert served(flight).address == address


def test_the_view_shows_who_is_there_who_flies_and_the_log(flight, address, tmp_path):
    path = tmp_path / "flight.mcap"
    assert flight.keep_log(path).result(ENOUGH) == str(path)
    assert flight.latest().network.log == str(path)
    with Client(address, name="Ada") as client:
        wait_for(lambda: [each.name for each in served(flight).clients] == ["Ada"])
        flight.pause().result(ENOUGH)  # so that no silence costs the lease
        with client.control():
            wait_for(lambda: flight.latest().network.control.hand is ControlOwner.CLIENT)
            control = flight.latest().network.control
            assert (control.name, control.stage) == ("Ada", LinkLossStage.LIVE)
            (peer,) = served(flight).clients
            assert control.peer == peer.peer
            flight.take_over().result(ENOUGH)
            assert flight.latest().network.control.hand is ControlOwner.OPERATOR
            flight.give_back().result(ENOUGH)
            assert flight.latest().network.control.hand is ControlOwner.NOBODY
    wait_for(lambda: served(flight).clients == ())
    assert flight.stop_log().result(ENOUGH) == str(path)
    assert flight.latest().network.log == ""
    assert path.stat().st_size > 0


@pytest.mark.parametrize("times", [1, pytest.param(2, marks=pytest.mark.slow)])
def test_a_server_that_is_killed_is_started_again_at_the_same_address(flight, tmp_path, times):
    """The flight goes on, the drone holds, and clients come back with the tokens they had."""
    tokens = tmp_path / "tokens"
    tokens.write_text("view: " + "v" * 20 + "\ncommand: " + "c" * 20 + "\n")
    tokens.chmod(0o600)
    config = ServerConfig(port=0, web=True, token_file=str(tokens))
    address = flight.serve(config).result(ENOUGH)
    page = served(flight).page
    with Client(address, name="Ada", token="c" * 20, topics=[EVENTS]) as client:
        for _ in range(times):
            flight.pause().result(ENOUGH)
            with client.control() as control:
                (server,) = children(flight.pid)
                os.kill(server, signal.SIGKILL)
                wait_for(lambda control=control: control.lost)
            flight.resume().result(ENOUGH)
            assert_flies_on(flight)
            wait_for(lambda server=server: server not in children(flight.pid))
            wait_for(lambda: flight.latest().network.server is not None)
            assert (served(flight).address, served(flight).page) == (address, page)
            assert flight.latest().network.control.hand is ControlOwner.NOBODY
            wait_for(lambda: client.connected)
            assert client.ping() > 0.0
    assert flight.latest().network.said == ""


@pytest.fixture
def dying(monkeypatch):
    """Return a supervisor of servers that are no processes, the times of their starts and a clock.

    Each of them ends after a time that the test gives, or before it listens for None.
    """
    now, begun, lasts = [0.0], [], []

    class Dying:
        wait_time = math.inf

        def __init__(self, config, flight):
            begun.append((now[0], config.port, config.web_port))
            self.connection, self._far = Pipe(duplex=False)
            self._lasts = lasts.pop(0)
            self._due = now[0] + (self._lasts or 0.0)
            self._told = self._lasts is None

        def flush(self):
            pass

        def received(self, most):
            if not self._told:
                self._told = True
                yield ServerStatus("here:7", "http://here:8/", (), {}, ())
            if now[0] >= self._due:
                raise EOFError

        def cause(self):
            return "the server's process was killed"

        def close(self):
            self.connection.close()
            self._far.close()

    def live(seconds):
        end = now[0] + seconds
        while now[0] < end:
            try:
                for record in server.received(9) if (server := supervisor.attend()) else ():
                    supervisor.note(record)
            except EOFError:
                supervisor.lost()
            if supervisor._ending:
                supervisor._ending._thread.join()
            now[0] += 0.01

    monkeypatch.setattr("workbench.live.server_supervisor.ServerProcess", Dying)
    supervisor = ServerSupervisor(lambda: None, lambda: 0.0, lambda: now[0])
    return supervisor, begun, lasts, live


@pytest.mark.parametrize(
    ("lasts", "pauses"),
    [
        ([3.0] * 8, [0.1] * 8),  # killed again and again: each restart serves
        ([0.0] * 8, [1.0] * 8),  # each serves for a moment
        ([3.0, None, None, 3.0, None, None], [0.1, 0.5, 1.0, 0.1, 0.5, 1.0]),
    ],
    ids=["killed", "unstable", "late"],
)
def test_a_server_that_has_served_is_always_started_again(dying, lasts, pauses):
    supervisor, begun, left, live = dying
    left += [*lasts, 1e9]
    supervisor.serve(1, ServerConfig(port=0, web=True))
    while left:
        assert supervisor.serves or supervisor.starts_again or supervisor._ending
        live(0.1)
    live(0.1)
    assert [
        round(after - before - (lasted or 0.0), 1)
        for ((before, *_), (after, *_)), lasted in zip(pairwise(begun), lasts, strict=True)
    ] == pauses
    assert {(port, page) for _, port, page in begun[1:]} == {(7, 8)}
    assert supervisor.status and not supervisor.starts_again and supervisor.said == ""


def test_a_server_that_cannot_be_started_again_is_given_up_with_a_sentence(dying):
    """The pauses grow, and an order to stop or to serve ends them."""
    supervisor, begun, lasts, live = dying
    lasts += [3.0, *[None] * 5]
    supervisor.serve(1, ServerConfig(port=0, web=True))
    live(15.0)
    assert [round(after - before, 1) for (before, *_), (after, *_) in pairwise(begun)] == [
        3.1, 0.5, 1.0, 2.0, 4.0,
    ]  # fmt: skip
    assert "was killed; 5 restarts have failed" in supervisor.said
    assert not supervisor.starts_again and not supervisor.serves
    assert supervisor.answers == [WorkerResult(1, "here:7")]
    lasts += [0.0]
    supervisor.serve(2, ServerConfig(port=0))
    live(0.05)
    assert supervisor.starts_again
    supervisor.stop(3)
    live(5.0)
    assert len(begun) == 7
    assert (supervisor.starts_again, supervisor.said) == (False, "")


def test_a_log_that_loses_its_file_is_said_and_is_no_success(flight, tmp_path):
    path = tmp_path / "flight.mcap"
    flight.keep_log(path).result(ENOUGH)
    path.unlink()
    wait_for(lambda: "moved or deleted" in flight.latest().network.log_said)
    assert flight.latest().network.log == ""
    assert flight.stop_log().result(ENOUGH) == ""
    flight.keep_log(path).result(ENOUGH)
    assert flight.latest().network.log_said == ""
    path.unlink()
    assert flight.stop_log().result(ENOUGH) == ""
    assert "moved or deleted" in flight.latest().network.log_said


def test_a_server_that_stands_still_is_ended_while_the_flight_flies(flight, address):
    (server,) = children(flight.pid)
    os.kill(server, signal.SIGSTOP)
    before = flight.latest().snapshot.time
    stopped = flight.stop_serving()
    wait_for(lambda: flight.latest().snapshot.time > before or stopped.done())
    assert flight.latest().snapshot.time > before  # while the server has two seconds for goodbye
    stopped.result(ENOUGH)
    assert not is_running(server)


def test_parameters_that_a_client_sets_are_the_flights_and_known_to_all(flight, address):
    with Client(address, topics=[PARAMETERS, EVENTS]) as watching, Client(address) as flying:
        flight.pause().result(ENOUGH)
        with flying.control() as control:
            assert control.set(kp_velocity_x=4.5, kp_roll=55.0)["kp_roll"] == 55.0
            assert flight.get("kp_velocity_x").result(ENOUGH) == 4.5
            with pytest.raises(WorkbenchError, match="kp_pitch"):
                control.set(kp_roll=66.0, kp_pitch=1e9)
            assert flight.get("kp_roll").result(ENOUGH) == 55.0  # all or none
            flight.set("kp_roll", 44.0).result(ENOUGH)
            assert watching.parameters("kp_roll") == {"kp_roll": 44.0}
            found = heard(watching, lambda found: len(found) == 3, PARAMETERS)
    assert [(each["name"], each["value"]) for each in found] == [
        ("kp_velocity_x", 4.5),
        ("kp_roll", 55.0),
        ("kp_roll", 44.0),
    ]


def test_events_tell_who_flies(flight, address):
    with Client(address, topics=[EVENTS]) as watching, Client(address, name="Ada") as flying:
        flight.pause().result(ENOUGH)
        with flying.control():
            flight.take_over().result(ENOUGH)
        wanted = "the operator took over"
        found = heard(watching, lambda found: found[-1]["said"] == wanted, EVENTS)
    assert "Ada took control" in [each["said"] for each in found]


def test_who_connects_after_another_controller_took_over_is_told_of_its_parameters(flight, address):
    names = ("kp_roll", "q_tilt")
    with Client(address, topics=[PARAMETERS, EVENTS]) as watching:
        assert [row.name for row in watching.hello.parameters if row.name in names] == ["kp_roll"]
        flight.fly_controller("lqi").result(ENOUGH)
        found = heard(watching, lambda found: found[-1]["name"] == "q_tilt", PARAMETERS)
        assert watching.parameters("q_tilt") == {"q_tilt": found[-1]["value"]}
        with pytest.raises(WorkbenchError, match="hello lists them"):
            watching.parameters("kp_roll")
        again = "the controller has other parameters: connect again to list them"
        heard(watching, lambda found: found[-1]["said"] == again, EVENTS)
    with Client(address) as late:
        assert [row.name for row in late.hello.parameters if row.name in names] == ["q_tilt"]
    flight.fly_controller("pd").result(ENOUGH)


def heard(client: Client, is_enough, topic: str) -> list:
    """Return a topic's samples up to what is waited for; a guard ends a wait that fails."""
    found: list = []
    guard = threading.Timer(ENOUGH, client._samples.close)  # not Ctrl-C: that ends all tests
    guard.start()
    try:
        for sample in client:
            if sample.topic == topic:
                found.append(sample)
                if is_enough(found):
                    return found
    finally:
        guard.cancel()
        guard.join()
    raise AssertionError("the connection has ended")


def test_the_operator_sends_a_client_away(flight, address):
    with (
        Client(address, name="Ada", reconnect=False) as bad,
        Client(address, name="Bob", reconnect=False) as good,
    ):
        wait_for(lambda: len(served(flight).clients) == 2)
        (peer,) = [each.peer for each in served(flight).clients if each.name == "Ada"]
        flight.disconnect(peer, "you are in the way").result(ENOUGH)
        wait_for(lambda: not bad.connected)
        assert "you are in the way" in bad.trouble
        wait_for(lambda: [each.name for each in served(flight).clients] == ["Bob"])
        assert good.connected


def test_who_has_control_starts_the_flight_again(flight, address):
    with Client(address, topics=["drone_state"]) as client:
        with pytest.raises(WorkbenchError, match="asked for control"):
            client.control().request("reset")
        wait_for(lambda: flight.latest().snapshot.time > 1.0)
        number = flight.latest().flight
        with client.control() as control:
            control.request("reset")
        wait_for(lambda: flight.latest().flight == number + 1)
        wait_for(lambda: client.latest("drone_state").time < 1.0)
        assert client.control_state.hand is ControlOwner.NOBODY


def test_a_reset_of_the_flight_keeps_its_server(flight, address):
    with Client(address, name="Ada", topics=["/dh_drone/time_data"], rate=50) as client:
        wait_for(lambda: client.latest("/dh_drone/time_data") is not None)
        flight.pause().result(ENOUGH)
        with client.control() as control:
            assert flight.reset().result(ENOUGH) == 0.0
            assert flight.latest().network.control.hand is ControlOwner.NOBODY
            wait_for(lambda: control.lost)
        wait_for(lambda: client.ping() == 0.0)
        with client.control() as control:
            assert control.set(kp_roll=51.0) == {"kp_roll": 51.0}


@pytest.mark.parametrize(
    "stopped", [pytest.param(False, marks=pytest.mark.slow), True], ids=["running", "standing"]
)
def test_closing_a_flight_leaves_no_process(stopped):
    flight = LiveFlight()
    flight.wait(ENOUGH)
    flight.serve(ServerConfig(port=0)).result(ENOUGH)
    (server,) = children(flight.pid)
    if stopped:
        os.kill(server, signal.SIGSTOP)
    flight.close(ENOUGH)
    assert not is_running(flight.pid)
    assert not is_running(server)


@pytest.mark.slow
def test_a_server_ends_with_a_flight_that_is_killed(flight):
    other = LiveFlight()
    other.wait(ENOUGH)
    other.serve(ServerConfig(port=0)).result(ENOUGH)
    (server,) = children(other.pid)
    os.kill(other.pid, signal.SIGKILL)
    wait_for(lambda: not is_running(server))
    other.close()
