"""How a client finds its server, loses it, and tells who it is."""

import socket

import pytest

from workbench.common.errors import WorkbenchError
from workbench.link import Client
from workbench.link.authentication import Tokens
from workbench.link.messages import Bye, Error, Login, Ping, SetParameters, Subscribe

TOKENS = Tokens("v" * 16, "c" * 16)
VELOCITY = (1.0, 2.0, 3.0, 4.0, 5.0, 6.0)


def test_a_lost_connection_is_made_and_subscribed_to_again(server, fakes):
    with Client(server.address, topics=["velocity_data"]) as client:
        server.cut()
        fakes.wait_until(lambda: server.connections == 2 and client.connected)
        server.publish(7_000_000_000, velocity_data=VELOCITY)
        assert next(client).t_ns == 7_000_000_000
        assert [each.topics for each in server.heard(Subscribe)] == [
            ("/dh_drone/velocity_data",)
        ] * 2


def test_a_server_that_had_to_make_room_is_asked_again(server):
    """As long as strangers crowd at it, it may end a connection before the login."""
    greet = server.greet
    server.greet = lambda peer: greet(peer) if peer.number > 3 else peer.stream.close()
    with Client(server.address, reconnect=False) as client:
        assert client.parameters()
    assert server.connections == 4


def test_what_always_hangs_up_is_no_server(server):
    server.greet = lambda peer: peer.stream.close()
    with (
        pytest.raises(WorkbenchError, match=f"{server.address}: .*connection"),
        Client(server.address),
    ):
        pass
    assert server.connections > 1


def test_a_server_that_stopped_is_waited_for(server, fakes):
    with Client(server.address) as client:
        server.say(Bye(said="the flight is over"))
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
        server.say(Bye(said="the flight is over"))
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
    monkeypatch.setattr("workbench.link.sample.MAX_QUEUE_AGE_S", -1.0)
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
    monkeypatch.setattr("workbench.link.connection.GREETING_TIMEOUT_S", 0.1)
    server.greet = lambda peer: None
    with pytest.raises(WorkbenchError, match=r"sent no greeting within 0.1 s: .*TLS\?"):
        Client(server.address).__enter__()


def test_a_server_that_falls_silent_is_left(server, fakes, monkeypatch):
    monkeypatch.setattr("workbench.link.connection.PING_AFTER_S", 0.1)
    with Client(server.address) as client:
        server.answer = lambda peer, operation: None
        server.usual = lambda peer, operation: None
        fakes.wait_until(lambda: "silent" in client.trouble or "greeting" in client.trouble)


def test_tokens_tell_who_commands(fakes):
    server = fakes.FakeServer(TOKENS)
    try:
        with Client(server.address, token=TOKENS.command) as client:
            with client.control() as c:
                c.velocity(1.0, 0.0, 0.0)
                c.land()
                c.set(a=1.0)
            assert len(server.heard(SetParameters)) == 1
        with Client(server.address, token=TOKENS.view, role="view") as client:
            assert client.ping() == 5.0
        assert [each.token for each in server.heard(Login)] == [TOKENS.command, TOKENS.view]
    finally:
        server.close()


def test_a_token_goes_to_another_machine_over_tls_alone(server, monkeypatch):
    monkeypatch.setattr("workbench.link.connection.is_loopback", lambda host: False)
    with pytest.raises(WorkbenchError, match="is another machine, and without TLS anybody"):
        Client(server.address, token=TOKENS.view, role="view").__enter__()
    assert server.operations == []
    with Client(server.address) as client:  # without a token there is nothing to keep
        assert client.ping() == 5.0


@pytest.mark.parametrize(
    ("token", "role", "said"),
    [
        ("", None, "wants a token"),
        (TOKENS.view, None, "the token is wrong: take it from the line 'command:' of the"),
        (TOKENS.command, "view", "take it from the line 'view:' of the server's token file"),
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
