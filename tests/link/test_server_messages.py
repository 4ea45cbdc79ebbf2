"""What the server says is read as records, and what it may say later is no failure."""

import dataclasses
import json
import math
import struct

import pytest

from workbench.link.codes import DeniedError
from workbench.link.drone_topics import drone_topics
from workbench.link.hello import Hello, ParameterRow, ServerLimits
from workbench.link.json_fields import read_json
from workbench.link.message_json import read_message, write_message
from workbench.link.messages import (
    Bye,
    ControlOwner,
    ControlState,
    Error,
    FlightDone,
    LinkLossStage,
    Login,
    Nack,
    ParameterValues,
    Pong,
    ReleaseControl,
    RequestControl,
    Role,
    Subscribe,
)
from workbench.link.signal import TopicOptions
from workbench.link.wire import WireError

HELLO = Hello(
    server="drake-drone-workbench 1.0",
    session="0123456789abcdef",
    peer=3,
    vehicle="x500",
    nonce="0f" * 16,
    login=True,
    limits=ServerLimits(8.0, 3.0, 0.4),
    topics=drone_topics(
        TopicOptions(
            4,
            200,
            8,
            rates={"imu": 200, "gps": 5, "lidar": 10},
            rays=8,
            scan={"a": [[1.5, 2]]},
            frames=[("W", "B")],
        )
    ),
    parameters=(ParameterRow("kp_velocity_x", "1/s", 0.0, 50.0, 6.0, "gain"),),
)
STATE = ControlState(
    ControlOwner.CLIENT, 3, "joystick", LinkLossStage.HOLD, 0.7, "silent for 0.5 s"
)
SAID = [
    HELLO,
    Login(1, role=Role.COMMAND),
    Subscribe(2, ("/dh_drone/imu",)),
    RequestControl(3, lease=2**32 - 1, expires=0.5),
    ReleaseControl(4),
    ParameterValues(5, {"kp_velocity_x": 6.0}),
    ParameterValues(5, {}),
    FlightDone(6, "land", 2**62),
    STATE,
    Pong(7, 123),
    Nack("held", "another flies", id=8),
    Nack("scaled", "too fast", seq=0),
    Nack("bad_value", "no", id=0),
    Error("slow", "nothing was acknowledged for 5 s"),
    Bye(said="the server stops"),
]


def test_what_is_written_is_read(case):
    for said in SAID:
        with case(said):
            assert read_message(write_message(said)) == said


def test_each_says_its_operation(case):
    for said in SAID:
        with case(said):
            assert read_json(write_message(said))["op"] == said.op


def test_all_of_the_state_of_control_is_told():
    assert read_json(write_message(STATE)) == {
        "op": "control_state",
        "hand": "client",
        "peer": 3,
        "name": "joystick",
        "stage": "hold",
        "age": 0.7,
        "reason": "silent for 0.5 s",
    }


def test_an_age_without_end_is_null():
    never = dataclasses.replace(STATE, age=math.inf)
    assert read_json(write_message(never))["age"] is None
    assert read_message(write_message(never)).age == math.inf


def test_what_a_later_server_says_is_passed_over():
    assert read_message(b'{"op":"weather","rain":true}') is None
    assert read_message(b'{"op":"pong","id":1,"t_ns":2,"load":0.5}') == Pong(1, 2)
    assert read_message(b'{"op":"nack","code":"moody","said":"no","id":1}').code == "moody"


def test_what_a_terminal_might_obey_is_not_passed_on():
    said = read_message(b'{"op":"error","code":"x","said":"a\\u001b[2Jb\\n"}')
    assert said.said == r"a\x1b[2Jb\n"


def test_a_sentence_without_end_is_cut():
    said = read_message(write_message(Error("x", "a" * 60_000))).said
    assert said == "a" * 1024 + "… (60,000 characters)"


def test_each_field_is_asked_for_with_its_type(case):
    for said in SAID:
        with case(said):
            plain = read_json(write_message(said))
            for key in set(plain) - {"op"}:
                for wrong in ([[]], {"x": []}, True if key != "login" else 1):
                    broken = json.dumps(plain | {key: wrong}).encode()
                    with pytest.raises(DeniedError):
                        read_message(broken)


def test_hello_must_be_complete(case):
    for key in sorted(HELLO.values()):
        with case(key):
            values = {"op": "hello"} | HELLO.values()
            del values[key]
            with pytest.raises(DeniedError, match=f'hello: "{key}"'):
                read_message(json.dumps(values).encode())


def test_a_false_hello_is_refused_with_its_reason(case):
    for change, said in [
        ({"protocol": [2, 3]}, "the server speaks versions 2 to 3, this client 1"),
        ({"protocol": [1]}, '"protocol" must be 2 integers'),
        ({"protocol": [True, True]}, '"protocol" must be 2 integers'),
        ({"nonce": "00"}, "32 hexadecimal digits"),
        ({"topics": [{"id": 1}]}, "not the definition of a topic"),
        ({"topics": [HELLO.topics[0].definition()] * 2}, "two have the same number"),
        ({"limits": {}}, '"level_speed" must be a number'),
        ({"parameters": [{"name": "a"}]}, '"unit" must be'),
    ]:
        with case(change, said):
            with pytest.raises(DeniedError) as error:
                read_message(json.dumps({"op": "hello"} | HELLO.values() | change).encode())
            assert said in error.value.said


def test_a_client_needs_nothing_but_hello_to_decode():
    """As a stranger would: `struct` and the definition's own words."""
    said = json.loads(write_message(HELLO))
    for topic, definition in zip(HELLO.topics, said["topics"], strict=True):
        assert struct.calcsize(definition["struct"]) == topic.packer.size
        count = sum(1 if f["type"] == "char" else f["count"] for f in definition["fields"])
        assert len(struct.unpack(definition["struct"], bytes(topic.packer.size))) == count


def test_what_is_no_json_is_no_answer():
    with pytest.raises(WireError):
        read_message(b"hello")
