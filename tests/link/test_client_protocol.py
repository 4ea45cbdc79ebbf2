"""A client's side of a connection, without sockets."""

import pytest

from workbench.link.client_protocol import ClientOptions, ClientProtocol
from workbench.link.drone_topics import VELOCITY_SIGNAL, drone_topics
from workbench.link.hello import Hello, ServerLimits
from workbench.link.message_json import read_operation, write_message
from workbench.link.messages import Bye, Error, Nack, Ping, Pong, Subscribe
from workbench.link.signal import TopicOptions
from workbench.link.wire import Decoder, FrameFlag, FrameKind, WireFrame

TOPICS = drone_topics(TopicOptions(rotors=4, fast=200.0, slow=10.0))
HELLO = Hello("fake", "ab", 3, "x", "0" * 32, False, ServerLimits(8.0, 8.0, 0.4), TOPICS, ())


def control(said, seq=1, flags=0):
    return WireFrame(FrameKind.CONTROL, 0, flags, seq, 0, write_message(said)).to_bytes()


def data(topic, payload, seq=2, t_ns=7, flags=0, kind=FrameKind.DATA):
    return WireFrame(kind, topic, flags, seq, t_ns, payload).to_bytes()


def sent(protocol):
    return list(Decoder().feed(protocol.take_outgoing()))


def begun(options=None):
    protocol = ClientProtocol(options or ClientOptions())
    protocol.receive(control(HELLO) + control(Subscribe(2, ()), 2))
    assert protocol.ready
    return protocol


def test_bytes_may_come_one_at_a_time():
    protocol = ClientProtocol(ClientOptions())
    stream = control(HELLO) + control(Subscribe(2, ())) + data(VELOCITY_SIGNAL.id, bytes(24))
    for at in range(len(stream)):
        protocol.receive(stream[at : at + 1])
    assert protocol.ready and len(protocol.samples) == 1
    assert protocol.newest_ns == 7
    assert [read_operation(frame.payload) for frame in sent(protocol)] == [Subscribe(2)]


def test_the_last_of_a_batch_is_acknowledged_by_its_number():
    protocol = begun()
    protocol.take_outgoing()
    protocol.receive(
        data(VELOCITY_SIGNAL.id, bytes(24), 10)
        + data(VELOCITY_SIGNAL.id, bytes(24), 11, flags=FrameFlag.ACKNOWLEDGE)
    )
    (frame,) = sent(protocol)
    assert (frame.kind, frame.seq, frame.payload) == (FrameKind.ACKNOWLEDGEMENT, 11, b"")


def test_what_a_newer_server_says_besides_is_passed_over():
    protocol = begun()
    protocol.receive(data(999, b"abc", 3, flags=FrameFlag.ACKNOWLEDGE))
    protocol.receive(data(0, b"abc", 4, kind=0x85))
    protocol.receive(data(0, b'{"op":"dance"}', 5, kind=FrameKind.CONTROL))
    assert protocol.end is None and protocol.samples == []
    assert [frame.seq for frame in sent(protocol) if frame.kind == 2] == [3]


def test_numbers_of_frames_rise():
    protocol = begun()
    protocol.take_outgoing()
    for _ in range(3):
        protocol.send(Ping(protocol.new_id()))
    numbers = [frame.seq for frame in sent(protocol)]
    assert numbers == sorted(set(numbers)) and numbers[0] > 0


def test_the_time_is_that_of_the_last_state_or_of_a_pong():
    protocol = begun()
    assert protocol.newest_ns is None
    protocol.receive(data(VELOCITY_SIGNAL.id, bytes(24), t_ns=123))
    assert protocol.newest_ns == 123
    protocol.receive(control(Pong(3, 456)))
    assert protocol.newest_ns == 456


@pytest.mark.parametrize(
    ("stream", "code", "said"),
    [
        (data(VELOCITY_SIGNAL.id, bytes(23)), "bad_size", "has 23 bytes instead of 24"),
        (b"XX" + bytes(30), "magic", "cannot be understood"),
        (data(0, b"{}", kind=FrameKind.CONTROL), "bad_value", "cannot be understood"),
        (data(0, b"{", kind=FrameKind.CONTROL), "json", "not strict JSON"),
        (control(Error("slow", "you are slow")), "slow", "ended the connection: you are slow"),
        (control(Bye()), "bye", "it stops"),
    ],
)
def test_what_ends_it_is_a_sentence(stream, code, said):
    protocol = begun()
    protocol.receive(data(VELOCITY_SIGNAL.id, bytes(24)) + stream)
    assert protocol.end.code == code
    assert said in protocol.end.said
    assert len(protocol.samples) == 1  # what came before counts
    protocol.receive(control(Error("internal", "later")))
    assert protocol.end.code == code


@pytest.mark.parametrize(
    "stream", [data(VELOCITY_SIGNAL.id, bytes(24)), control(Pong(1, 2)), control(Subscribe(2, ()))]
)
def test_hello_comes_first(stream):
    protocol = ClientProtocol(ClientOptions())
    protocol.receive(stream)
    assert protocol.end.code == "hello"


def test_a_refused_subscription_ends_it():
    protocol = ClientProtocol(ClientOptions(topics=("/x",)))
    protocol.receive(control(HELLO))
    protocol.receive(control(Nack("unknown_topic", "there is no /x", id=2)))
    assert "there is no /x" in protocol.end.said
