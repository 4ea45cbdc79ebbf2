"""Who is let in, who may command, and what happens to all others; time is told."""

import struct

import pytest

from workbench.link.authentication import Tokens
from workbench.link.backplane import Command, Request
from workbench.link.messages import Role

VIEW = "v" * 20
COMMAND = "c" * 20


@pytest.fixture
def guarded(parts):
    """Return a hub with tokens."""
    return parts.Room(tokens=Tokens(VIEW, COMMAND))


def enter(parts, room, role="command", address="10.0.0.1:5000"):
    """Return a client that has logged in, and the key of its session."""
    client = room.connect(address)
    token = COMMAND if role == "command" else VIEW
    fields, key = parts.login_of(token, role, client.answer("hello")["nonce"])
    client.send(parts.operation("login", name="me", id=2, **fields))
    assert client.answer("login") == {"op": "login", "id": 2, "role": role}
    return client, key


def test_hello_asks_for_login(guarded):
    client = guarded.connect()
    assert client.answer("hello")["login"] is True
    assert client.session.role is None


@pytest.mark.parametrize("role", ["view", "command"])
def test_the_right_proof_gives_the_role(guarded, parts, role):
    client, _ = enter(parts, guarded, role)
    assert client.session.role is Role(role)
    assert client.session.name == "me"


def wrong(parts, nonce, case):
    fields, _ = parts.login_of(COMMAND, "command", nonce)
    match case:
        case "token":
            return parts.login_of("x" * 20, "command", nonce)[0]
        case "token of the other role":
            return parts.login_of(VIEW, "command", nonce)[0]
        case "role changed afterwards":
            return parts.login_of(VIEW, "view", nonce)[0] | {"role": "command"}
        case "another connection's nonce":
            return parts.login_of(COMMAND, "command", "00" * 16)[0]
        case "client nonce changed afterwards":
            return fields | {"nonce": "cd" * 16}
        case "no proof":
            return {"role": "command", "nonce": fields["nonce"]}
        case "nothing":
            return {}
    raise ValueError(case)


@pytest.mark.parametrize(
    "case",
    [
        "token",
        "token of the other role",
        "role changed afterwards",
        "another connection's nonce",
        "client nonce changed afterwards",
        "no proof",
        "nothing",
    ],
)
def test_a_wrong_login_ends_the_connection(guarded, parts, case):
    client = guarded.connect()
    nonce = client.answer("hello")["nonce"]
    client.send(parts.operation("login", **wrong(parts, nonce, case)))
    assert client.answer("error")["code"] == "bad_login"
    assert client.transport.closed
    assert guarded.hub.refusals.counts == {"bad_login": 1}
    assert not guarded.asked(Command)


def test_a_login_that_was_heard_on_another_connection_is_of_no_use(guarded, parts):
    first, second = guarded.connect(), guarded.connect()
    fields, _ = parts.login_of(COMMAND, "command", first.answer("hello")["nonce"])
    second.send(parts.operation("login", **fields))
    assert second.answer("error")["code"] == "bad_login"


@pytest.mark.parametrize("op", ["subscribe", "ping", "request_control", "nonsense"])
def test_before_login_all_else_ends_the_connection(guarded, parts, op):
    client = guarded.connect()
    client.send(parts.operation(op, topics=["*"]))
    assert client.answer("error")["code"] == "login"
    assert not client.is_in
    assert not guarded.asked(Request)


@pytest.mark.parametrize(
    ("key", "value"), [("nonce", "ab"), ("proof", 7), ("role", "king"), ("name", "x" * 49)]
)
def test_a_login_that_cannot_be_read_names_the_value(guarded, parts, key, value):
    client = guarded.connect()
    fields, _ = parts.login_of(COMMAND, "command", client.answer("hello")["nonce"])
    client.send(parts.operation("login", **(fields | {key: value})))
    said = client.answer("error")
    assert said["code"] == "login"
    assert f'"{key}" must be' in said["said"]


def test_before_login_commands_and_acknowledgements_end_the_connection(guarded, parts):
    for frame in (parts.command(), parts.acknowledgement(1)):
        client = guarded.connect()
        client.send(frame)
        assert client.answer("error")["code"] == "login"
    assert not guarded.asked(Command)


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
    client, _ = enter(parts, guarded)
    client.send(head)
    assert client.is_in


def test_a_second_login_ends_the_connection_even_where_none_is_needed(room, parts):
    client = room.connect()
    client.send(parts.operation("login", name="one"))
    assert client.is_in
    client.send(parts.operation("login", name="other"))
    assert client.answer("error")["code"] == "bad_login"


def test_what_commands_needs_a_proof(guarded, parts):
    client, key = enter(parts, guarded)
    client.send(parts.proven(parts.operation("request_control", 5, id=3), key))
    client.send(parts.proven(parts.command(6), key))
    assert [type(each) for each in guarded.told] == [Request, Command]
    assert client.is_in


@pytest.mark.parametrize(
    "make",
    [
        lambda parts: parts.command(5),
        lambda parts: parts.operation("request_control", 5),
        lambda parts: parts.operation("release_control", 5, lease=1),
        lambda parts: parts.operation("flight", 5, what="stop", lease=1),
        lambda parts: parts.operation("parameters", 5, set={"kp_x": 1}, lease=1),
    ],
    ids=["command", "request_control", "release_control", "flight", "set"],
)
@pytest.mark.parametrize("case", ["missing", "forged", "of another session", "bit turned"])
def test_a_proof_that_is_missing_or_wrong_ends_the_connection(guarded, parts, make, case):
    client, key = enter(parts, guarded)
    _, other = enter(parts, guarded)
    frame = make(parts)
    data = {
        "missing": frame.to_bytes(),
        "forged": parts.proven(frame, bytes(32)),
        "of another session": parts.proven(frame, other),
        "bit turned": parts.proven(frame, key)[:-17] + b"\x7f" + parts.proven(frame, key)[-16:],
    }[case]
    told = list(guarded.told)
    client.send(data)
    said = client.answer("error")
    assert said["code"] in ("proof", "json") if case == "bit turned" else said["code"] == "proof"
    assert not client.is_in
    assert [each for each in guarded.told if each not in told] == guarded.told[-1:]


def test_what_only_asks_needs_no_proof(guarded, parts):
    client, _ = enter(parts, guarded)
    client.send(parts.operation("parameters", get=[]), parts.operation("ping"))
    assert client.answer("pong")


@pytest.mark.parametrize("seq", [5, 4, 0])
def test_a_frame_that_is_played_again_ends_the_connection(guarded, parts, seq):
    client, key = enter(parts, guarded)
    client.send(parts.proven(parts.command(5), key))
    client.send(parts.proven(parts.command(seq), key))
    assert client.answer("error")["code"] == "seq"
    assert len(guarded.asked(Command)) == 1


def test_who_only_watches_may_not_command(guarded, parts):
    client, key = enter(parts, guarded, "view")
    client.send(parts.proven(parts.command(5), key))
    client.send(parts.proven(parts.operation("request_control", 6, id=3), key))
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
    inside = [enter(parts, guarded, address=f"10.0.{n}.1:9")[0] for n in range(16)]
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
    inside = [enter(parts, guarded, address=other)[0] for other in others]
    late = guarded.connect(address)
    fields, key = parts.login_of(COMMAND, "command", late.answer("hello")["nonce"])
    late.send(
        parts.operation("login", **fields),
        parts.proven(parts.operation("request_control", 2), key),
    )
    (said,) = late.said()
    assert (said["op"], said["code"]) == ("error", "too_many")
    assert not late.is_in
    assert not guarded.asked(Request)
    guarded.hub.lost(inside[0].session)
    assert enter(parts, guarded, address=address)[0].is_in


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
    assert enter(parts, guarded, address=f"{host}:99")[0].is_in


@pytest.mark.parametrize("which", ["room", "guarded"])
def test_logging_in_twice_is_no_guess(request, parts, which):
    place = request.getfixturevalue(which)
    for _ in range(8):
        if which == "guarded":
            client, _ = enter(parts, place)
        else:
            client = place.connect()
            client.send(parts.operation("login", name="me"))
        client.send(parts.operation("login", 3, name="me"))
        assert client.answer("error")["code"] == "bad_login"
    assert place.connect().session


def test_a_good_login_clears_the_bad_ones(guarded, parts):
    for _ in range(3):
        guess(parts, guarded, "10.0.0.1:1")
    enter(parts, guarded)
    for _ in range(4):
        assert guess(parts, guarded, "10.0.0.1:1") == "bad_login"


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
    assert not room.asked(Request), "what comes after it is not read"
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
        (lambda p: p.Frame(1, 1, 0, 9, 0, bytes(16)), "unknown_topic", {"seq": 9}),
        (lambda p: p.Frame(1, 999, 0, 9, 0, b""), "unknown_topic", {"seq": 9}),
        (lambda p: p.Frame(1, 8, 0, 9, 0, bytes(23)), "bad_size", {"seq": 9}),
        (lambda p: p.Frame(1, 8, 0, 9, 0, bytes(25)), "bad_size", {"seq": 9}),
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
    client.send(parts.Frame(0x85, 0, 0, 1, 0, b"from the future"), parts.operation("ping"))
    assert client.answer("pong")


def test_the_log_of_refusals_is_short(room, parts):
    for n in range(100):
        client = room.connect(f"10.0.{n}.1:1")
        client.send(parts.operation("dance" * 9))
        room.hub.lost(client.session)
    assert len(room.hub.refusals.log) == 20
    assert all(len(line) <= 200 for line in room.hub.refusals.log)
    assert room.hub.refusals.counts == {"unknown_op": 100}
