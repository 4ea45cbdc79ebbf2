"""The data files in vectors/, which nothing of ours wrote, mean to us what they say."""

import dataclasses
import importlib.util
import json
import math
from pathlib import Path

import pytest

from workbench.link.authentication import login_proof
from workbench.link.codes import DeniedError
from workbench.link.drone_topics import drone_topics
from workbench.link.message_json import read_operation, write_operation
from workbench.link.messages import Role
from workbench.link.signal import TopicOptions
from workbench.link.wire import MAX_PAYLOAD_BYTES, Decoder, WireError, WireFrame

VECTORS = Path(__file__).parent / "vectors"
OUTFIT = TopicOptions(
    rotors=4,
    fast=200,
    slow=8,
    rates={"imu": 200, "gps": 5, "lidar": 10},
    rays=4,
    frames=[("W", "B")],
)
TOPICS = {topic.id: topic for topic in drone_topics(OUTFIT)}


def read(name):
    return json.loads((VECTORS / f"{name}.json").read_text(encoding="utf-8"))


def data(text):
    found = b""
    for word in text.split():
        digits, _, count = word.partition("*")
        found += bytes.fromhex(digits) * int(count or 1)
    return found


def number(value):
    return float(value) if isinstance(value, str) and value.lstrip("-") in ("nan", "inf") else value


def same(found, expected):
    if isinstance(found, tuple):
        return len(found) == len(expected) and all(map(same, found, expected))
    if isinstance(found, float) and math.isnan(found):
        return math.isnan(number(expected))
    return found == number(expected)


def test_there_are_more_than_fifty():
    counts = {name: len(read(name)) for name in ("frames", "topics", "operations")}
    assert sum(counts.values()) > 50
    assert {vector["id"] for vector in read("topics")} == set(TOPICS)


def test_the_files_are_what_the_script_writes():
    spec = importlib.util.spec_from_file_location("make_vectors", VECTORS / "make_vectors.py")
    script = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(script)
    for name, text in script.vectors().items():
        assert (VECTORS / name).read_text(encoding="utf-8") == text, name


def test_a_stream(case):
    streams, older = read("frames"), read("proofs")["frames"]
    for vector in streams + older:
        for step in [1, 7, MAX_PAYLOAD_BYTES * 2]:
            with case(vector["name"], step):
                stream = data(vector["hex"])
                decoder = Decoder(vector.get("largest", MAX_PAYLOAD_BYTES))
                found, error = [], None
                try:
                    for begin in range(0, len(stream), step):
                        found += decoder.feed(stream[begin : begin + step])
                except WireError as refused:
                    error = refused.code
                    with pytest.raises(WireError):
                        list(decoder.feed(stream))
                expected = [
                    WireFrame(**each | {"payload": data(each["payload"])})
                    for each in vector["frames"]
                ]
                assert found[: len(expected)] == expected
                assert (len(found), error) == (len(expected), vector["error"])
                if error is None and vector not in older:
                    size = sum(24 + len(each.payload) for each in expected)
                    assert decoder.waiting == len(stream) - size


def test_a_frame_is_written_as_it_was_read(case):
    for vector in [
        each for each in read("frames") if len(each["frames"]) == 1 and not each["error"]
    ]:
        with case(vector["name"]):
            stream = data(vector["hex"])
            [frame] = Decoder().feed(stream)
            assert stream.startswith(frame.to_bytes())


def test_a_topic(case):
    for vector in read("topics"):
        with case(vector["name"]):
            topic, payload = TOPICS[vector["id"]], data(vector["hex"])
            values = topic.unpack(payload)
            assert topic.name == f"/dh_drone/{vector['name']}"
            assert topic.packer.format == vector["struct"]
            assert list(values) == list(vector["values"])
            for name, value in values.items():
                assert same(value, vector["values"][name]), name
            if "\ufffd" not in str(values):
                assert topic.pack(list(values.values())) == payload


OUR_RECORDS = {
    "RequestControlOp": "RequestControl",
    "ReleaseControlOp": "ReleaseControl",
    "FlightOp": "FlightOperation",
    "GetParametersOp": "GetParameters",
    "SetParametersOp": "SetParameters",
}
"""Records by the names that the vectors have for them, which never change."""
OUR_FIELDS = {"names": "get", "values": "set"}


def test_an_operation(case):
    for vector in read("operations"):
        with case(vector["text"][:60]):
            payload = data(vector["hex"])
            if vector["error"]:
                with pytest.raises((WireError, DeniedError)) as refused:
                    read_operation(payload)
                assert refused.value.code == vector["error"]
                assert isinstance(refused.value, WireError) == (vector["error"] == "json")
                continue
            record, values = vector["operation"]
            found = read_operation(payload)
            assert type(found).__name__ == OUR_RECORDS.get(record, record)
            values = {OUR_FIELDS.get(name, name): value for name, value in values.items()}
            shown = {
                name: list(v) if isinstance(v, tuple) else v for name, v in as_json(found).items()
            }
            # what only those have
            answers = {name: v for name, v in shown.items() if name not in values}
            assert not any(answers.values())
            assert shown == values | answers
            assert read_operation(write_operation(found)) == found


def as_json(record):
    found = {each.name: getattr(record, each.name) for each in dataclasses.fields(record)}
    return {n: v.value if isinstance(v, Role) else v for n, v in found.items()}


def test_the_proofs_of_a_login():
    vector = read("proofs")
    nonces = vector["server_nonce"], vector["client_nonce"]
    for role in Role:
        assert login_proof(vector["token"], role, *nonces) == vector["login_proof"][role.value]
