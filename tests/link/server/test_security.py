"""Who is let in, who may command, and what happens to all others; time is told."""

import struct

import pytest

from workbench.link.authentication import Tokens
from workbench.link.backplane import ClientRequest, VelocityCommand
from workbench.link.messages import Role

VIEW = "v" * 20
COMMAND = "c" * 20


@pytest.fixture
def guarded(parts):
    """Return a hub with tokens."""
    return parts.Room(tokens=Tokens(VIEW, COMMAND))


def enter(parts, room, role="command", address="10.0.0.1:5000"):
    """Return a client that has logged in."""
    client = room.connect(address)
    token = COMMAND if role == "command" else VIEW
    client.send(parts.operation("login", name="me", id=2, role=role, token=token))
    assert client.answer("login") == {"op": "login", "id": 2, "role": role}
    return client


def test_hello_asks_for_login(guarded):
    client = guarded.connect()
    assert client.answer("hello")["login"] is True
    assert client.session.role is None


@pytest.mark.parametrize("role", ["view", "command"])
def test_the_right_token_gives_the_role(guarded, parts, role):
    client = enter(parts, guarded, role)
    assert client.session.role is Role(role)
    assert client.session.name == "me"


WRONG = {
    "token": lambda older: {"role": "command", "token": "x" * 20},
    "token of the other role": lambda older: {"role": "command", "token": VIEW},
    "part of the token": lambda older: {"role": "command", "token": COMMAND[:-1]},
    "more than the token": lambda older: {"role": "command", "token": COMMAND + "c"},
    "empty token": lambda older: {"role": "command", "token": ""},
    "no token": lambda older: {"role": "command"},
    "no role": lambda older: {"token": COMMAND},
    "nothing": lambda older: {},
    "wrong token, right proof": lambda older: older(COMMAND) | {"token": "x" * 20},
    "proof of another token": lambda older: older("x" * 20),
    "proof of the other role": lambda older: older(VIEW, "view") | {"role": "command"},
    "proof on another connection": lambda older: older(COMMAND, server_nonce="00" * 16),
    "proof with another nonce": lambda older: older(COMMAND) | {"nonce": "cd" * 16},
    "no proof": lambda older: {"role": "command", "nonce": "ab" * 16},
}


@pytest.mark.parametrize("case", WRONG)
def test_a_wrong_login_ends_the_connection(guarded, parts, case):
    client = guarded.connect()
    nonce = client.answer("hello")["nonce"]

    def older(token, role="command", server_nonce=nonce):
        return parts.older_proof(token, role, server_nonce)

    client.send(parts.operation("login", **WRONG[case](older)), parts.operation("request_control"))
    assert client.answer("error")["code"] == "bad_login"
    assert client.transport.closed
    assert guarded.hub.refusals.counts == {"bad_login": 1}
    assert COMMAND not in str(guarded.hub.refusals.log)
    assert guarded.asked(VelocityCommand) == guarded.asked(ClientRequest) == []


def test_a_client_of_before_tokens_were_sent_flies_with_its_proofs_ignored(guarded, parts):
    client = guarded.connect()
    older = parts.older_proof(COMMAND, "command", client.answer("hello")["nonce"])
    client.send(parts.operation("login", name="old", **older))
    assert client.answer("login")["role"] == "command"
    client.send(parts.with_proof(parts.operation("request_control", 5, id=3)))
    client.send(parts.with_proof(parts.command(6, velocity=(1.0, 0.0, 0.0))), parts.command(6))
    assert [type(each) for each in guarded.told] == [
        ClientRequest,
        VelocityCommand,
        VelocityCommand,
    ]
    assert [each.velocity[0] for each in guarded.asked(VelocityCommand)] == [1.0, 0.0]
    assert client.is_in


@pytest.mark.parametrize("op", ["subscribe", "ping", "request_control", "nonsense"])
def test_before_login_all_else_ends_the_connection(guarded, parts, op):
    client = guarded.connect()
    client.send(parts.operation(op, topics=["*"]))
    assert client.answer("error")["code"] == "login"
    assert not client.is_in
    assert not guarded.asked(ClientRequest)


@pytest.mark.parametrize(
    ("key", "value"),
    [("token", 7), ("nonce", "ab"), ("proof", 7), ("role", "king"), ("name", "x" * 49)],
)
def test_a_login_that_cannot_be_read_names_the_value(guarded, parts, key, value):
    client = guarded.connect()
    client.send(parts.operation("login", **({"role": "command", "token": COMMAND} | {key: value})))
    said = client.answer("error")
    assert said["code"] == "login"
    assert f'"{key}" must be' in said["said"]


def test_before_login_commands_and_acknowledgements_end_the_connection(guarded, parts):
    for frame in (parts.command(), parts.acknowledgement(1)):
        client = guarded.connect()
        client.send(frame)
        assert client.answer("error")["code"] == "login"
    assert not guarded.asked(VelocityCommand)


def test_before_login_nothing_is_sent_but_hello(guarded, parts):
    client = guarded.connect()
    client.frames()
    guarded.hub.hear([parts.published(1)])
    assert client.frames() == []


def test_login_has_three_seconds_however_slowly_it_comes(guarded, parts):
    client = guarded.connect()
    data = parts.operation("login", name="x" * 40).to_bytes()
    for byte in data[:29]:
        client.send(bytes([byte]))
        guarded.wait(0.1)
    assert client.is_in
    guarded.wait(0.3)
    assert client.answer("error")["code"] == "login"
    assert not client.is_in


def test_before_login_4_kib_are_the_most_and_64_after_it(guarded, parts):
    head = struct.pack("<2sBBHHIIq", b"DH", 1, 0, 0, 0, 1, 4097, 0)
    client = guarded.connect()
    client.send(head)
    assert client.answer("error")["code"] == "length"
    client = enter(parts, guarded)
    client.send(head)
    assert client.is_in


def test_a_second_login_ends_the_connection_even_where_none_is_needed(room, parts):
    client = room.connect()
    client.send(parts.operation("login", name="one"))
    assert client.is_in
    client.send(parts.operation("login", name="other"))
    assert client.answer("error")["code"] == "bad_login"


def test_who_only_watches_may_not_command(guarded, parts):
    client = enter(parts, guarded, "view")
    client.send(parts.command(5), parts.operation("request_control", 6, id=3))
    client.send(parts.operation("parameters", 7, set={"kp_x": 1.0}, lease=4, id=4))
    codes = [(each["code"], each.get("seq"), each.get("id")) for each in client.said()]
    assert codes == [
        ("not_allowed", 5, None),
        ("not_allowed", None, 3),
        ("not_allowed", None, 4),
    ]
    assert guarded.told == []
    assert client.is_in


def test_the_17th_client_is_refused_and_comes_in_when_another_goes(room):
    clients = [room.connect(f"10.0.{n}.1:5") for n in range(17)]
    assert clients[16].session is None
    assert clients[16].answer("error")["code"] == "too_many"
    assert clients[16].transport.closed
    room.hub.lost(clients[0].session)
    assert room.connect("10.0.99.1:5").session


def test_who_has_not_logged_in_takes_no_place(guarded, parts):
    strangers = [guarded.connect(f"10.0.{n % 8}.1:{n}") for n in range(48)]
    assert all(stranger.is_in for stranger in strangers)
    inside = [enter(parts, guarded, address=f"10.0.{n}.1:9") for n in range(16)]
    assert all(client.is_in for client in inside)
    for stranger in strangers:
        guarded.hub.lost(stranger.session)
    assert guarded.hub._admission._inside.total() == 16


@pytest.mark.parametrize(
    ("address", "others"),
    [("10.0.0.9:1", [f"10.0.{n}.1:5" for n in range(16)]), ("10.0.0.9:1", ["10.0.0.9:5"] * 4)],
    ids=["all", "of an address"],
)
def test_a_login_without_a_place_left_is_refused(guarded, parts, address, others):
    inside = [enter(parts, guarded, address=other) for other in others]
    late = guarded.connect(address)
    late.answer("hello")
    late.send(
        parts.operation("login", role="command", token=COMMAND),
        parts.operation("request_control", 2),
    )
    (said,) = late.said()
    assert (said["op"], said["code"]) == ("error", "too_many")
    assert not late.is_in
    assert not guarded.asked(ClientRequest)
    guarded.hub.lost(inside[0].session)
    assert enter(parts, guarded, address=address).is_in


def test_the_5th_client_from_an_address_is_refused(room):
    clients = [room.connect(f"10.0.0.1:{n}") for n in range(5)]
    assert clients[4].answer("error")["code"] == "too_many"
    assert room.connect("10.0.0.2:1").session
    room.hub.lost(clients[2].session)
    assert room.connect("10.0.0.1:9").session


@pytest.mark.parametrize("host", ["127.0.0.1", "[::1]", "[::ffff:127.0.0.1]"])
def test_programs_of_this_machine_may_have_12_places(room, host):
    clients = [room.connect(f"{host}:{n}") for n in range(13)]
    assert clients[0].answer("hello")["limits"]["clients_an_address"] == 12
    assert clients[11].session
    assert clients[12].answer("error")["code"] == "too_many"
    assert room.connect("10.0.0.2:1").session


def guess(parts, room, address="10.0.0.7:1"):
    client = room.connect(address)
    if client.session is None:
        return client.answer("error")["code"]
    client.send(parts.operation("login"))
    return client.answer("error")["code"]


def test_who_guesses_tokens_waits_longer_and_longer(guarded, parts):
    assert [guess(parts, guarded) for _ in range(4)] == ["bad_login"] * 4
    assert guess(parts, guarded) == "back_off"
    assert guarded.connect("10.0.0.8:1").session, "others may come in"
    guarded.now += 1.1
    assert guess(parts, guarded) == "bad_login"
    guarded.now += 1.1
    assert guess(parts, guarded) == "back_off"
    guarded.now += 1.0
    for _ in range(8):
        assert guess(parts, guarded) == "bad_login"
        guarded.now += 60.1
    assert guarded.hub.refusals.counts["back_off"] == 2


def test_who_guesses_on_many_connections_at_once_waits_too(guarded, parts):
    clients = [guarded.connect("10.0.0.7:1") for _ in range(6)]
    for client in clients:
        client.send(parts.operation("login"))
    codes = [client.answer("error")["code"] for client in clients]
    assert codes == ["bad_login"] * 4 + ["back_off"] * 2


def test_an_ipv6_network_guesses_as_one(guarded, parts):
    for n in range(4):
        assert guess(parts, guarded, f"[2001:db8::{n}]:1") == "bad_login"
    assert guess(parts, guarded, "[2001:db8::99]:1") == "back_off"
    assert guess(parts, guarded, "[2001:db8:0:1::1]:1") == "bad_login"


@pytest.mark.parametrize("host", ["127.0.0.1", "[::1]"])
def test_bad_logins_of_this_machine_are_answered_late_and_lock_nobody_out(guarded, parts, host):
    for n in range(8):
        client = guarded.connect(f"{host}:{n}")
        client.frames()
        client.send(parts.operation("login"), parts.operation("ping", 2))
        guarded.wait(0.9)
        assert client.said() == []
        guarded.wait(0.2)
        assert [each["code"] for each in client.said()] == ["bad_login"]
        assert client.transport.closed
    assert enter(parts, guarded, address=f"{host}:99").is_in


@pytest.mark.parametrize("which", ["room", "guarded"])
def test_logging_in_twice_is_no_guess(request, parts, which):
    place = request.getfixturevalue(which)
    for _ in range(8):
        if which == "guarded":
            client = enter(parts, place)
        else:
            client = place.connect()
            client.send(parts.operation("login", name="me"))
        client.send(parts.operation("login", 3, name="me"))
        assert client.answer("error")["code"] == "bad_login"
    assert place.connect().session


def test_a_good_login_clears_the_bad_ones_of_its_address_alone(guarded, parts):
    for _ in range(4):
        guess(parts, guarded, "10.0.0.7:1")
    for _ in range(3):
        guess(parts, guarded, "10.0.0.1:1")
    enter(parts, guarded)
    for _ in range(4):
        assert guess(parts, guarded, "10.0.0.1:1") == "bad_login"
    assert guess(parts, guarded, "10.0.0.7:1") == "back_off"


def test_guessers_are_not_remembered_without_bound(guarded, parts):
    for n in range(1000):
        guess(parts, guarded, f"10.{n // 250}.{n % 250}.1:1")
    assert len(guarded.hub._admission._guesses) <= 256
    assert not guarded.hub._admission._inside


BAD_FRAMES = {
    "magic": b"GET / HTTP/1.1\r\n\r\n" + bytes(24),
    "version": struct.pack("<2sBBHHIIq", b"DH", 2, 0, 0, 0, 1, 0, 0),
    "kind": struct.pack("<2sBBHHIIq", b"DH", 1, 3, 0, 0, 1, 0, 0),
    "length": struct.pack("<2sBBHHIIq", b"DH", 1, 0, 0, 0, 1, 2**32 - 1, 0),
    "json": struct.pack("<2sBBHHIIq", b"DH", 1, 0, 0, 0, 1, 1, 0) + b"{",
}


@pytest.mark.parametrize("code", BAD_FRAMES)
def test_what_is_no_frame_ends_the_connection_and_no_other(room, parts, code):
    client, other = room.connect(), room.connect()
    client.send(BAD_FRAMES[code], parts.operation("request_control"))
    said = client.answer("error")
    assert said["code"] == code
    assert said["said"]
    assert client.transport.closed
    assert not room.asked(ClientRequest), "what comes after it is not read"
    assert room.hub.refusals.counts == {code: 1}
    assert "10.0.0.1:5000" in room.hub.refusals.log[-1]
    other.send(parts.operation("ping"))
    assert other.answer("pong")


@pytest.mark.parametrize(
    ("make", "code", "names"),
    [
        (lambda p: p.operation("dance", id=3), "unknown_op", {"id": 3}),
        (lambda p: p.operation("flight", what="dance", lease=1, id=3), "bad_value", {"id": 3}),
        (lambda p: p.operation("subscribe", topics=["x"], id=3), "unknown_topic", {"id": 3}),
        (lambda p: p.WireFrame(1, 1, 0, 9, 0, bytes(16)), "unknown_topic", {"seq": 9}),
        (lambda p: p.WireFrame(1, 999, 0, 9, 0, b""), "unknown_topic", {"seq": 9}),
        (lambda p: p.WireFrame(1, 8, 0, 9, 0, bytes(23)), "bad_size", {"seq": 9}),
        (lambda p: p.WireFrame(1, 8, 0, 9, 0, bytes(25)), "bad_size", {"seq": 9}),
    ],
)
def test_what_cannot_be_done_is_refused_and_the_connection_goes_on(room, parts, make, code, names):
    client = room.connect()
    client.send(make(parts), parts.operation("ping"))
    nack, pong = client.said()[1:]
    assert nack["code"] == code
    assert {name: nack[name] for name in names} == names
    assert pong["op"] == "pong"
    assert room.told == []
    assert room.hub.status().clients[0].refused == 1


def test_a_kind_that_may_be_skipped_is_skipped(room, parts):
    client = room.connect()
    client.send(parts.WireFrame(0x85, 0, 0, 1, 0, b"from the future"), parts.operation("ping"))
    assert client.answer("pong")


def test_the_log_of_refusals_is_short(room, parts):
    for n in range(100):
        client = room.connect(f"10.0.{n}.1:1")
        client.send(parts.operation("dance" * 9))
        room.hub.lost(client.session)
    assert len(room.hub.refusals.log) == 20
    assert all(len(line) <= 200 for line in room.hub.refusals.log)
    assert room.hub.refusals.counts == {"unknown_op": 100}
