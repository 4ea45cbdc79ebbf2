"""What becomes of a client, by what it does and does not; time is told."""

import json
import math
import struct

import pytest
from websockets.protocol import OPEN
from websockets.server import ServerProtocol

from workbench.control.controller_file import load_controller
from workbench.link.authentication import Tokens
from workbench.link.backplane import (
    ClientDisconnected,
    ClientRequest,
    CommandRefusal,
    Disconnect,
    Reply,
    ServerStatus,
    StopServer,
    VelocityCommand,
)
from workbench.link.drone_topics import EVENTS_SIGNAL, drone_topics
from workbench.link.messages import (
    ControlOwner,
    ControlState,
    FlightDone,
    FlightOperation,
    GetParameters,
    LinkLossStage,
    ParameterValues,
    ReleaseControl,
    RequestControl,
    Role,
    SetParameters,
)
from workbench.link.server.client_session import FRAME_COST_BYTES
from workbench.link.server.hub import STRANGERS_WORK_BYTES, TURN_WORK_BYTES
from workbench.link.server.rate_limiter import (
    FRAME_BURST_COUNT,
    MIN_READ_PAUSE_S,
    OPERATION_BURST_BYTES,
    OPERATION_BYTES_PER_S,
    RateLimiter,
)
from workbench.link.server.web_socket import WebSocket
from workbench.link.signal import TopicOptions
from workbench.link.wire import MAX_OPERATION_BYTES, FrameFlag, FrameKind

MASK = b"\x11\x22\x33\x44"
HELD = ControlState(ControlOwner.CLIENT, 3, "phone", LinkLossStage.LIVE, 0.1, "it asked")


def test_hello_comes_first_and_says_all_that_is_needed(room, parts):
    client = room.connect()
    (frame,) = client.frames()
    said = json.loads(frame.payload)
    assert (frame.kind, frame.topic, frame.seq) == (0, 0, 1)
    assert said["op"] == "hello"
    assert said["protocol"] == [1, 1]
    assert said["vehicle"] == "x500"
    assert said["login"] is False
    assert said["peer"] == 1
    assert bytes.fromhex(said["nonce"]) and len(said["nonce"]) == 32
    assert said["limits"]["clients"] == 16
    assert said["limits"]["clients_an_address"] == 4
    assert [each["name"] for each in said["topics"]][0] == "/dh_drone/time_data"
    assert said["parameters"][0]["name"] == "kp_x"


def test_no_two_clients_have_the_same_nonce_or_number(room):
    hellos = [room.connect(f"10.0.0.{n}:1").answer("hello") for n in range(1, 9)]
    assert len({hello["nonce"] for hello in hellos}) == 8
    assert [hello["peer"] for hello in hellos] == list(range(1, 9))


def test_nothing_comes_before_it_is_subscribed_to(room, parts):
    client = room.connect()
    client.frames()
    room.hub.hear([parts.published(1)])
    assert client.frames() == []
    client.send(parts.operation("subscribe", topics=["/dh_drone/velocity_data"], id=5))
    said = client.answer("subscribe")
    assert (said["id"], said["topics"]) == (5, ["/dh_drone/velocity_data"])
    room.hub.hear([parts.published(2)])
    (frame,) = client.frames()
    assert (frame.kind, frame.topic, frame.t_ns) == (FrameKind.DATA, 3, 9765625)
    assert frame.flags == FrameFlag.ACKNOWLEDGE


def test_all_topics_come_with_a_star(room, parts):
    client = room.connect()
    client.send(parts.operation("subscribe", topics=["*"]))
    client.frames()
    got = set()
    for step in range(1, 9):
        room.hub.hear([parts.published(step, (*parts.STATES, EVENTS_SIGNAL.id))])
        got |= {frame.topic for frame in client.acknowledge()}
    assert got == {*parts.STATES, EVENTS_SIGNAL.id}


def test_an_unknown_topic_changes_nothing(room, parts):
    client = room.connect()
    client.send(parts.operation("subscribe", topics=["/dh_drone/imu_data"], id=3))
    said = client.answer("nack")
    assert (said["id"], said["code"]) == (3, "unknown_topic")
    room.hub.hear([parts.published(1)])
    assert client.frames() == []


def test_who_commands_is_told_to_all_and_to_whoever_comes(room):
    first = room.connect()
    first.frames()
    room.hub.hear([HELD])
    said = first.answer("control_state")
    assert (said["hand"], said["peer"], said["name"]) == ("client", 3, "phone")
    assert (said["stage"], said["age"], said["reason"]) == ("live", 0.1, "it asked")
    assert [each["op"] for each in room.connect("b:1").said()] == ["hello", "control_state"]


def test_a_command_reaches_the_flight_as_it_stood_in_its_frame(room, parts):
    client = room.connect()
    client.send(parts.command(9, 77, (1.0, -2.0, 0.5), 0.25, axes=7, t_ns=123))
    assert room.told == [VelocityCommand(1, 9, 123, 77, 7, (1.0, -2.0, 0.5), 0.25)]


@pytest.mark.parametrize(
    ("said", "asked"),
    [
        ({"op": "request_control", "name": "me"}, RequestControl(4, "me")),
        ({"op": "request_control"}, RequestControl(4, "client 1")),
        ({"op": "release_control", "lease": 8}, ReleaseControl(4, 8)),
        (
            {"op": "flight", "what": "take_off", "height": 2.5, "lease": 8},
            FlightOperation(4, "take_off", 2.5, 8),
        ),
        ({"op": "parameters", "get": ["kp_x"]}, GetParameters(4, ("kp_x",))),
        (
            {"op": "parameters", "set": {"kp_x": 3}, "lease": 8},
            SetParameters(4, {"kp_x": 3.0}, 8),
        ),
    ],
)
def test_requests_reach_the_flight_and_its_reply_the_client(room, parts, said, asked):
    client, other = room.connect(), room.connect()
    client.frames(), other.frames()
    client.send(parts.operation(**said, id=4))
    assert room.told == [ClientRequest(1, asked)]
    room.hub.hear([Reply(1, FlightDone(4, "land", 5))])
    assert client.said() == [{"op": "flight", "id": 4, "what": "land", "applied_ns": 5}]
    assert other.said() == []


def test_a_refusal_of_the_flight_is_a_nack_of_the_frame(room, parts):
    client = room.connect()
    room.hub.hear([CommandRefusal(1, 9, "too_fast", "over twice the limit")])
    said = client.answer("nack")
    assert (said["seq"], said["code"], said["said"]) == (9, "too_fast", "over twice the limit")
    assert room.hub.refusals.counts == {"too_fast": 1}


def test_a_reply_that_json_has_no_numbers_for_is_a_nack(room, parts):
    client = room.connect()
    room.hub.hear([Reply(1, ParameterValues(4, {"a": float("nan")}))])
    assert client.answer("nack")["id"] == 4


def test_what_is_for_a_client_that_has_gone_is_nothing(room, parts):
    client = room.connect()
    told, sent = list(room.told), bytes(client.transport.data)
    room.hub.hear(
        [Reply(9, ReleaseControl(1)), CommandRefusal(9, 1, "held", ""), Disconnect(9, "")]
    )
    assert (room.told, bytes(client.transport.data)) == (told, sent)


def test_more_requests_than_16_wait_for_the_flight_in_vain(room, parts):
    client = room.connect()
    for id in range(1, 18):
        client.send(parts.operation("parameters", get=[], id=id))
    assert len(room.told) == 16
    assert client.answer("nack")["id"] == 17
    room.hub.hear([Reply(1, ParameterValues(1, {}))])
    client.send(parts.operation("parameters", get=[], id=18))
    assert len(room.told) == 17


def test_a_ping_is_answered_with_the_flights_time(room, parts):
    client = room.connect()
    room.hub.hear([parts.published(2)])
    client.send(parts.operation("ping", id=2))
    assert client.answer("pong") == {"op": "pong", "id": 2, "t_ns": 9765625}


@pytest.mark.parametrize("topics", [(), (1, 2)])
def test_who_comes_during_a_pause_is_told_the_flights_time(room, parts, topics):
    room.hub.hear([parts.published(2, topics)])
    client = room.connect()
    client.send(parts.operation("ping", id=2))
    assert client.answer("pong") == {"op": "pong", "id": 2, "t_ns": 9765625}


def test_where_commands_are_not_allowed_all_only_watch(parts):
    room = parts.Room(allow_commands=False)
    client = room.connect()
    client.send(parts.operation("login", name="me", role="command"))
    assert client.answer("login")["role"] == "view"
    client.send(parts.command(9), parts.operation("request_control", id=3))
    codes = [(each["code"], each.get("id"), each.get("seq")) for each in client.said()]
    assert codes == [("not_allowed", None, 9), ("not_allowed", 3, None)]
    assert room.told == []


def test_the_flight_learns_at_once_that_a_client_has_gone(room):
    client = room.connect()
    room.hub.lost(client.session)
    room.hub.lost(client.session)
    assert room.told == [ClientDisconnected(1)]


def test_goodbye_ends_the_connection(room, parts):
    client = room.connect()
    client.send(parts.operation("bye"))
    assert client.answer("bye")
    assert client.transport.closed
    assert room.told == [ClientDisconnected(1)]


def test_the_operator_disconnects_a_client_with_a_reason(room):
    client, other = room.connect(), room.connect()
    room.hub.hear([Disconnect(1, "you are too loud")])
    said = client.answer("error")
    assert (said["code"], said["said"]) == ("disconnected", "you are too loud")
    assert client.transport.closed
    assert other.is_in


def test_when_the_server_stops_all_are_told(room):
    clients = [room.connect(), room.connect()]
    room.hub.hear([StopServer.STOP])
    assert room.hub.stopped.is_set()
    room.hub.stop("the server stops")
    assert [each.answer("bye")["said"] for each in clients] == ["the server stops"] * 2
    assert all(each.transport.closed for each in clients)


def test_a_client_that_acknowledges_nothing_is_out_in_five_seconds(room, parts):
    client, other = room.connect(), room.connect()
    for each in (client, other):
        each.send(parts.operation("subscribe", topics=["*"]))
    for step in range(1, 49):
        room.hub.hear([parts.published(step)])
        other.acknowledge()
        room.wait(0.1)
    assert client.is_in
    room.hub.hear([parts.published(50)])
    other.acknowledge()
    room.wait(0.4)
    said = client.answer("error")
    assert said["code"] == "slow"
    assert client.transport.closed
    assert other.is_in


def test_a_write_that_is_blocked_for_two_seconds_ends_the_connection(room, parts):
    client, other = room.connect(), room.connect()
    client.transport.stuck = True
    client.send(parts.operation("ping"))
    room.wait(1.9)
    assert client.is_in
    room.wait(0.3)
    assert client.transport.closed
    assert other.is_in
    assert room.hub.refusals.counts == {"slow": 1}


def test_answers_that_nobody_reads_are_64_at_most(room, parts):
    client = room.connect()
    client.transport.stuck = True
    client.transport.data += bytes(40_000)
    for id in range(64):
        client.send(parts.operation("ping", id=id))
    assert client.is_in
    client.send(parts.operation("ping", id=65))
    assert not client.is_in
    assert room.hub.refusals.counts == {"overflow": 1}


def test_the_clients_status_is_told_twice_a_second_and_on_change(room, parts):
    client = room.connect("10.0.0.9:7")
    client.send(parts.operation("login", name="phone", role="view"))
    room.hub.tick()
    (status,) = room.asked(ServerStatus)
    (peer,) = status.clients
    assert (peer.peer, peer.address, peer.name) == (1, "10.0.0.9:7", "phone")
    assert (peer.transport, peer.role) == ("tcp", Role.VIEW)
    assert (peer.rate, peer.age, peer.dropped, peer.refused) == (0.0, 0.0, 0, 0)
    room.wait(2.0)
    assert 4 <= len(room.asked(ServerStatus)) - 1 <= 5
    room.hub.lost(client.session)
    room.hub.tick()
    assert room.asked(ServerStatus)[-1].clients == ()


def test_the_status_tells_rate_and_age_of_what_was_acknowledged(room, parts, monkeypatch):
    monkeypatch.setattr("time.time_ns", lambda: 5_000_000_000)
    client = room.connect()
    client.send(parts.operation("subscribe", topics=["*"]))
    client.frames()
    for step in range(1, 11):
        room.hub.hear([parts.published(step, range(1, 9), wall_ns=4_750_000_000)])
        client.acknowledge()
    (peer,) = room.hub.status().clients
    assert (peer.rate, peer.age) == (82.0, 0.25), "hello and an answer were read too"


def test_a_fault_of_the_servers_own_ends_one_connection_only(room, parts, monkeypatch, caplog):
    client, other = room.connect(), room.connect()
    monkeypatch.setattr(client.session, "_operate", lambda frame, now: 1 / 0)
    client.send(parts.operation("ping"))
    assert client.answer("error")["code"] == "internal"
    other.send(parts.operation("ping"))
    assert other.answer("pong")
    assert "ZeroDivisionError" in caplog.text


def test_a_flood_is_read_at_a_thousand_frames_a_second(room, parts):
    client = room.connect()
    client.frames()
    flood = b"".join(parts.operation("ping", seq).to_bytes() for seq in range(2000))
    pause = client.send(flood)
    answered = len(client.said())
    assert pause > 0.0
    assert answered <= 201
    began = room.now
    while pause > 0.0:
        room.now += pause
        pause = client.go_on()
        answered += len(client.said())
    assert answered == 2000
    assert 1.5 <= room.now - began <= 2.5


def test_what_a_client_does_not_use_is_not_saved_up(case):
    """After an hour of silence it may send 200 frames, 128 KiB or 2 operations at once, no more."""
    for most, spend in (
        (199, lambda limiter, now: limiter.take_frame()),  # the next is waited for
        (128, lambda limiter, now: limiter.take(1024, now)),
        (2, lambda limiter, now: limiter.take_operation(MAX_OPERATION_BYTES)),
    ):
        with case(most):
            limiter, now = RateLimiter(0.0), 3600.0
            assert limiter.pause(now) == 0.0
            for _ in range(most):
                spend(limiter, now)
                assert limiter.pause(now) == 0.0
            spend(limiter, now)
            assert limiter.pause(now) > 0.0


@pytest.mark.parametrize("piece", [b"", b"D"], ids=["nothing", "a byte of a frame"])
def test_pieces_that_finish_no_frame_are_read_at_a_thousand_a_second(room, piece):
    head = struct.pack("<2sBBHHIIq", b"DH", 1, 0, 0, 0, 1, 4000, 0)
    client = room.connect()
    client.send(head)
    begun, pieces = room.now, 0
    while room.now < begun + 2.0:
        pause = client.send(piece)
        pieces += 1
        while pause > 0.0:
            room.now += pause
            pause = client.go_on()
        assert pieces < 10_000, "nothing holds it up"
    assert 1900 <= pieces <= 2300
    assert client.is_in


def test_a_client_that_has_its_last_words_coming_is_held_up_too(room, parts):
    client = room.connect()
    client.session.last_due = room.now + 1.0
    client.session.bye("goodbye")
    assert max(client.send(b"x") for _ in range(300)) > 0.0
    assert client.is_in


def test_acknowledgements_are_no_flood(room, parts):
    client = room.connect()
    client.send(parts.operation("subscribe", topics=["*"]))
    client.frames()
    for step in range(1, 2000):
        room.hub.hear([parts.published(step, range(1, 9))])
        for frame in client.frames():
            if frame.flags & FrameFlag.ACKNOWLEDGE:
                assert client.send(parts.acknowledgement(frame.seq)) == 0.0


def test_eight_clients_get_eight_topics_without_a_gap(room, parts):
    clients = [room.connect(f"10.0.0.{n}:1") for n in range(8)]
    for client in clients:
        client.send(parts.operation("subscribe", topics=["*"]))
        client.frames()
    got = [[] for _ in clients]
    for step in range(1, 251):
        room.hub.hear([parts.published(step, range(1, 9))])
        for client, frames in zip(clients, got, strict=True):
            frames += client.acknowledge()
    for frames in got:
        for topic in range(1, 9):
            times = [frame.t_ns for frame in frames if frame.topic == topic]
            assert times == [round(step * 1e9 / 204.8) for step in range(1, 251)]
        assert [frame.seq for frame in frames] == list(range(3, 2003))


def test_viewers_share_the_work_of_a_turn_and_who_flies_has_its_own(parts):
    """Work is counted, not timed: what nine greedy viewers are given between two turns."""
    turns = []
    room = parts.Room(an_address=16, call_soon=turns.append)
    pilot, *viewers = [room.connect() for _ in range(10)]
    flies = ControlState(
        ControlOwner.CLIENT, pilot.session.number, "Ada", LinkLossStage.LIVE, 0.0, "Ada flies"
    )
    room.hub.hear([flies])
    largest = parts.saying({"op": "ping", "deep": [{}] * 2035}, 1)
    assert MAX_OPERATION_BYTES - 100 < len(largest.payload) <= MAX_OPERATION_BYTES
    greedy = b"".join([largest.to_bytes()] * 3 + [parts.operation("ping").to_bytes()] * 100)
    for each in (pilot, *viewers):
        each.frames()
    waiting = [each for each in viewers if each.send(greedy) > 0.0]
    assert len(waiting) == len(viewers)
    most, answered, began = 0, dict.fromkeys(viewers, 0), room.now
    while waiting:
        pilot.send(parts.operation("ping"))
        assert pilot.answer("pong"), "whatever the others have used up"
        most = max(most, room.hub._worked)
        room.now += 0.02
        assert len(turns) <= 1
        for call in turns[:]:
            turns.remove(call)
            call()
        waiting = [each for each in waiting if each.go_on() > 0.0]
        for each in viewers:
            answered[each] += sum(said["op"] == "pong" for said in each.said())
        counts = [answered[each] for each in waiting]
        assert not counts or max(counts) - min(counts) <= 60, "nobody is left behind"
    assert TURN_WORK_BYTES <= most < TURN_WORK_BYTES + MAX_OPERATION_BYTES + 200
    assert set(answered.values()) == {103}
    least = (3 * MAX_OPERATION_BYTES - OPERATION_BURST_BYTES) / OPERATION_BYTES_PER_S
    assert room.now - began >= 0.9 * least, "to read operations has a price of its own"


def test_an_operation_that_is_too_long_ends_the_connection_before_it_is_read(room, parts):
    client = room.connect()
    frame = parts.saying({"op": "ping", "long": "x" * MAX_OPERATION_BYTES}, 1).to_bytes()
    client.send(frame[:24])
    said = client.answer("error")
    assert (said["code"], str(MAX_OPERATION_BYTES) in said["said"]) == ("length", True)
    assert not client.is_in


def test_all_that_may_be_set_or_subscribed_to_fits_into_one_operation():
    """As long-winded as JSON can be: a blank after each sign, and all digits of each number."""
    values = {row.name: -1.2345678901234567e-300 for row in load_controller().table}
    largest = {"op": "parameters", "id": 2**32 - 1, "set": values, "lease": 2**32 - 1}
    assert len(json.dumps(largest, indent=2)) < MAX_OPERATION_BYTES
    outfit = TopicOptions(12, 200.0, 8.0, rates={"imu": 100.0, "gps": 5.0, "lidar": 10.0}, rays=360)
    topics = [topic.name for topic in drone_topics(outfit)]
    assert len(json.dumps({"op": "subscribe", "topics": topics}, indent=2)) < MAX_OPERATION_BYTES


def test_answers_of_the_flight_are_charged_as_well(room, parts):
    client = room.connect()
    values = {f"parameter_{number}": 0.5 for number in range(256)}
    pause = 0.0
    for id in range(8):
        pause = max(pause, client.send(parts.operation("parameters", get=[], id=id)))
        room.hub.hear([Reply(1, ParameterValues(id, values))])
    assert pause > 0.0


def test_who_is_silent_is_asked_and_gives_its_place_to_others_unless_it_answers(parts):
    room = parts.Room()
    silent, reading, pinging = [room.connect(f"10.0.0.{n}:1") for n in range(3)]
    room.hub.hear(
        [ControlState(ControlOwner.NOBODY, 0, "", LinkLossStage.LIVE, math.inf, "nobody yet")]
    )
    asked = 0
    for second in range(60):
        asked += sum(bool(each.flags & FrameFlag.ACKNOWLEDGE) for each in reading.acknowledge())
        pinging.send(parts.operation("ping", second))
        assert not any(each.flags & FrameFlag.ACKNOWLEDGE for each in pinging.frames())
        room.wait(1.0)
        assert silent.is_in == (second < 10)
    assert 9 <= asked <= 12
    assert silent.answer("error")["code"] == "slow"
    assert reading.is_in and pinging.is_in
    assert room.hub.status().clients[0].rate == 0.0, "a question is no data"


def test_strangers_have_a_part_of_a_turn_and_the_newest_is_first(parts):
    """Each answer of the page costs time, so only some are given in a turn of the loop."""
    turns, answered = [], []
    room = parts.Room(call_soon=turns.append)

    def stranger(number, work):
        def answer():
            answered.append(number)
            return work

        return answer

    for number in range(6):
        room.hub.later(stranger(number, STRANGERS_WORK_BYTES // 2))
    room.hub.later(stranger("gone", 0))
    assert answered == [0, 1]
    for expected in ([0, 1, "gone", 5, 4], [0, 1, "gone", 5, 4, 3, 2]):
        [turn] = turns
        turns.clear()
        turn()
        assert answered == expected


def test_the_pieces_of_a_web_socket_share_the_turns_of_the_loop(parts):
    """Empty ones, which carry no frame, as any: else four viewers take the loop for themselves."""
    turns = []
    room = parts.Room(call_soon=turns.append)
    protocol = ServerProtocol(state=OPEN)
    viewer = room.connect()
    socket = WebSocket(protocol, lambda data: None, lambda: None)
    viewer.session._decoder = socket
    socket.received += bytes([0x02, 0x80, *MASK]) + bytes([0x00, 0x80, *MASK]) * 1000
    pause = room.hub.receive(viewer.session, 6006)
    assert room.hub._worked == TURN_WORK_BYTES and 0.0 < pause < 1e-3, "the others have their turn"
    done = TURN_WORK_BYTES // FRAME_COST_BYTES
    while room.hub.receive(viewer.session) < MIN_READ_PAUSE_S:
        done += TURN_WORK_BYTES // FRAME_COST_BYTES
        [turn] = turns
        turns.clear()
        turn()
    assert done <= FRAME_BURST_COUNT + TURN_WORK_BYTES // FRAME_COST_BYTES, (
        "and so many come in a second at most"
    )


def test_a_crowd_of_strangers_is_no_news_to_the_flight(parts):
    """Nor to the operator, whose table would have a row for each, ten times a second."""
    room = parts.Room(tokens=Tokens("v" * 20, "c" * 20))
    room.wait(0.1)
    room.told.clear()
    crowd = [room.connect(f"10.0.{n}.1:1") for n in range(40)]
    for each in crowd[:20]:
        room.hub.lost(each.session)
    room.wait(0.3)
    assert not room.asked(ServerStatus)
    room.wait(0.3)
    [status] = room.asked(ServerStatus)
    assert [each.peer for each in status.clients] == list(range(21, 29))
    owner = room.connect()
    owner.send(parts.operation("login", role="command", token="c" * 20))
    room.told.clear()
    room.wait(0.1)
    [status] = room.asked(ServerStatus)
    assert [each.peer for each in status.clients] == [*range(21, 29), 41]
