"""Messages as bytes: what others decode, and what stands where."""

import random
import struct
from types import SimpleNamespace

import pytest
from mcap_ros2._dynamic import generate_dynamic, serialize_dynamic

from workbench.link.ros_messages.cdr import Codec, codec, encode
from workbench.link.ros_messages.definitions import (
    STRUCT_CODE_BY_ROS_TYPE,
    TEXT_TYPE,
    Arity,
    read_definition,
)
from workbench.link.ros_messages.library import definition, schema_text, type_names

LIMITS = {
    "int8": (-(2**7), 2**7 - 1),
    "uint8": (0, 2**8 - 1),
    "uint16": (0, 2**16 - 1),
    "int32": (-(2**31), 2**31 - 1),
    "uint32": (0, 2**32 - 1),
    "int64": (-(2**63), 2**63 - 1),
}


def one(kind: str, dice: random.Random):
    if kind == TEXT_TYPE:
        return "".join(dice.choices("abcé€ /", k=dice.randrange(9)))
    if kind == "bool":
        return dice.random() < 0.5
    if kind == "float32":
        return struct.unpack("<f", struct.pack("<f", dice.gauss(0.0, 1e3)))[0]
    if kind == "float64":
        return dice.gauss(0.0, 1e9)
    if kind in STRUCT_CODE_BY_ROS_TYPE:
        return dice.randint(*LIMITS[kind])
    return message(kind, dice)


def message(name: str, dice: random.Random) -> dict:
    """Return any values for a type."""
    values = {}
    for field in definition(name).fields:
        count = dice.randrange(5) if field.arity is Arity.SEQUENCE else field.count
        found = [one(field.type, dice) for _ in range(count)]
        values[field.name] = found[0] if field.arity is Arity.ONE else found
        if field.arity is not Arity.ONE and field.type == "uint8":
            values[field.name] = bytes(found)
    return values


def as_values(found):
    """Return what mcap-ros2-support decoded as mappings and lists."""
    if isinstance(found, list | tuple):
        return [as_values(each) for each in found]
    if hasattr(found, "__slots__"):
        return {name: as_values(getattr(found, name)) for name in found.__slots__}
    return found


def test_others_decode_every_type_and_write_the_same_bytes(case):
    for name in type_names():
        with case(name):
            dice = random.Random(name)
            decode = generate_dynamic(name, schema_text(name))[name]
            write = serialize_dynamic(name, schema_text(name))[name]
            for _ in range(40):
                values = message(name, dice)
                data = encode(name, values)
                assert as_values(decode(data)) == values
                assert data == bytes(write(values))


def test_the_layout_is_found_again_in_the_bytes(case):
    for name in type_names():
        with case(name):
            dice = random.Random(name)
            for _ in range(20):
                data = encode(name, message(name, dice))
                layout = codec(name).layout_of(data)
                assert layout.packer.size == len(data)
                flat = layout.packer.unpack(data)
                assert layout.packer.pack(*flat) == data
                for column in layout.columns:
                    assert column.offset + column.count <= len(data)


def test_bytes_of_a_small_message_are_as_written_by_hand():
    made = read_definition("a/msg/B", "uint8 a\nstring text\nfloat64 b\nuint16[] c\nint32[2] d\n")
    data = Codec((made,)).encode({"a": 7, "text": "hi", "b": 1.0, "c": [1, 2, 3], "d": [-1, 5]})
    assert data == bytes.fromhex(
        "00010000"  # little-endian CDR
        "07 000000"  # a, and what aligns the text's length to 4
        "03000000 686900"  # three bytes with the zero at the end
        "00"  # 11 bytes so far: a float64 stands at 16
        "00000000"
        "000000000000f03f"
        "03000000 0100 0200 0300"  # 34 bytes: an int32 stands at 36
        "0000"
        "ffffffff 05000000"
    )


def test_columns_say_where_numbers_stand_and_in_which_unit():
    name = "dh_drone_msgs/msg/VelocityData"
    values = {"header": {"stamp": {"sec": 1, "nanosec": 2}, "frame_id": "world"}}
    values |= {f"{kind}_{axis}": 0.5 for kind in "vw" for axis in "xyz"}
    data = encode(name, values | {"w_x": 0.25})
    columns = {column.path: column for column in codec(name).layout_of(data).columns}
    assert columns["w_x"].unit == "rad/s"
    assert struct.unpack_from("<f", data, columns["w_x"].offset) == (0.25,)
    assert columns["header.frame_id"].count == len("world")


@pytest.mark.parametrize(
    ("change", "error"),
    [
        ({"wind": [1.0, 2.0]}, ValueError),
        ({"wind": [1.0, 2.0, "three"]}, struct.error),
        ({"wind": None}, TypeError),
        ({"header": {}}, KeyError),
    ],
)
def test_values_that_do_not_fit_are_refused(change, error):
    values = {
        "header": {"stamp": {"sec": 0, "nanosec": 0}, "frame_id": ""},
        "wind": [1.0, 2.0, 3.0],
    }
    assert encode("dh_drone_msgs/msg/WindData", values)
    with pytest.raises(error):
        encode("dh_drone_msgs/msg/WindData", values | change)


def test_every_cut_of_a_message_is_a_sentence():
    name = "dh_drone_msgs/msg/Event"
    head = {"stamp": {"sec": 0, "nanosec": 0}, "frame_id": "world"}
    data = encode(name, {"header": head, "severity": 1, "said": "the rotor has stopped"})
    for size in range(len(data)):
        with pytest.raises(ValueError, match="message"):
            codec(name).layout_of(data[:size])
    with pytest.raises(ValueError, match="little-endian"):
        codec(name).layout_of(b"\0\0" + data[2:])


def test_texts_of_many_lengths_do_not_gather_without_end():
    found = Codec((read_definition("a/msg/B", "string said\n"),))
    for size in range(1000):
        found.encode({"said": "x" * size})
    assert len(vars(found)["_packers"]) <= 256


def test_attributes_are_no_values():
    with pytest.raises(TypeError):
        encode("builtin_interfaces/msg/Time", SimpleNamespace(sec=1, nanosec=2))
