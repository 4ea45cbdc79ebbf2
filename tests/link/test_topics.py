"""A topic's definition is enough to pack and unpack it, and a false one is refused."""

import copy
import json
import math
import struct

import pytest

from workbench.link.drone_topics import drone_topics
from workbench.link.signal import TopicOptions
from workbench.link.topics import (
    Delivery,
    Field,
    Topic,
    TopicDirection,
    definition_hash,
    topic_from,
    truncated_utf8,
    value_names,
)

TOPIC = Topic(
    5,
    "/dh_drone/test",
    TopicDirection.OUT,
    100.0,
    (
        Field("count", "uint32", "1"),
        Field("said", "char", "", count=6),
        Field("p", "float64", "m", "W", 3, low=-1.0),
    ),
    Delivery.EVENT,
    {"more": [1, 2]},
)


def test_fields_stand_in_a_row_without_gaps():
    payload = TOPIC.pack([7, "ab", (1.0, 2.0, 0.1)])
    assert payload == struct.pack("<I6sddd", 7, b"ab", 1.0, 2.0, 0.1)
    assert TOPIC.unpack(payload) == {"count": 7, "said": "ab", "p": (1.0, 2.0, 0.1)}


@pytest.mark.parametrize("size", [0, 33, 35, 65536])
def test_another_size_is_no_frame_of_it(size):
    with pytest.raises(ValueError, match=f"has 34 bytes: a frame with {size} does not fit"):
        TOPIC.unpack(bytes(size))


def test_a_text_is_cut_between_characters():
    assert truncated_utf8("aüb", 2) == b"a"
    assert truncated_utf8("aüb", 3) == "aü".encode()
    assert TOPIC.unpack(TOPIC.pack([0, "öööö", (0, 0, 0)]))["said"] == "ööö"
    assert TOPIC.unpack(TOPIC.pack([0, "ööaö", (0, 0, 0)]))["said"] == "ööa"


def test_what_is_no_text_is_shown_and_does_not_raise():
    assert TOPIC.unpack(b"\0" * 4 + b"a\xff\0b\0\0" + bytes(24))["said"] == "a\ufffd\0b"


def test_a_definition_survives_json():
    said = json.loads(json.dumps(TOPIC.definition()))
    assert topic_from(said) == TOPIC
    assert said["struct"] == "<I6s3d"
    assert topic_from(said).definition() == TOPIC.definition()


def test_the_hash_follows_the_definition():
    said = TOPIC.definition()
    assert definition_hash(said) == said["hash"]
    assert definition_hash(said | {"rate": 99.0}) != said["hash"]
    assert len(said["hash"]) == 16


@pytest.mark.parametrize("key", ["id", "name", "direction", "rate", "fields", "delivery", "about"])
def test_a_definition_without_a_part_is_refused(key):
    said = TOPIC.definition()
    del said[key]
    with pytest.raises(ValueError, match="not the definition of a topic"):
        topic_from(said)


def test_a_false_definition_is_refused(case):
    for path, value in [
        (("id",), 0),
        (("id",), 65536),
        (("id",), True),
        (("id",), "5"),
        (("direction",), "up"),
        (("direction",), []),
        (("delivery",), None),
        (("rate",), "x"),
        (("rate",), 10**400),
        (("fields",), 5),
        (("fields",), [5]),
        (("fields", 0, "type"), "float16"),
        (("fields", 0, "type"), "uint32\0"),
        (("fields", 0, "name"), "said"),
        (("fields", 0, "name"), "\x1b[2J"),
        (("name",), "\n"),
        (("fields", 0, "count"), 0),
        (("fields", 0, "count"), -1),
        (("fields", 0, "count"), 1.0),
        (("fields", 0, "count"), 10**12),
        (("fields", 0, "count"), 20_000),
        (("fields", 0, "range"), []),
        (("fields", 0, "range"), ["low", "high"]),
        (("fields", 0, "range"), [False, True]),
        (("struct",), "<I6s2d"),
        (("struct",), None),
        (("about",), 3),
    ]:
        with case(path, value):
            said = copy.deepcopy(TOPIC.definition())
            inner = said
            for step in path[:-1]:
                inner = inner[step]
            inner[path[-1]] = value
            with pytest.raises(ValueError):
                topic_from(said)


def test_every_topic_survives_packing_of_any_floats():
    for topic in drone_topics(
        TopicOptions(
            4, 200, 8, rates={"imu": 200, "gps": 5, "lidar": 10}, rays=3, frames=[("W", "B")]
        )
    ):
        values = [
            "x"
            if each.type == "char"
            else 1
            if "int" in each.type
            else math.inf
            if each.count == 1
            else [math.inf] * each.count
            for each in topic.fields
        ]
        found = topic.unpack(topic.pack(values))
        assert [
            list(each) if isinstance(each, tuple) else each for each in found.values()
        ] == values


def test_a_topic_that_no_frame_can_carry_is_refused():
    def said(count):
        field = Field("p", "float64", "m", "W", count)
        return Topic(1, "/dh_drone/big", TopicDirection.OUT, 1.0, (field,)).definition()

    assert topic_from(said(8192)).packer.size == 65536
    with pytest.raises(ValueError, match="its fields are longer than a frame may be"):
        topic_from(said(8193))


@pytest.mark.parametrize(
    ("parts", "count", "names"),
    [
        (["arm", "Leg 1"], 2, ["arm", "leg_1"]),
        (["arm"], 1, ["arm"]),
        (["body", "foot"], 6, ["body.x", "body.y", "body.z", "foot.x", "foot.y", "foot.z"]),
        (["a.b", "a b"], 2, ["0", "1"]),  # which would be one name
        (["", "1st"], 2, ["0", "1"]),
        ([], 3, ["0", "1", "2"]),
    ],
)
def test_values_have_the_names_of_parts_where_these_are_names(parts, count, names):
    assert value_names(parts, count) == names
    field = Field("force", "float32", "N", "W", count)
    about = {"links": parts} if parts else {}
    topic = Topic(25, "/dh_drone/test", TopicDirection.OUT, 1.0, (field,), about=about)
    assert topic.value_names(field) == names
    assert TOPIC.value_names(TOPIC.fields[0]) == [""]
