"""Types for DDS, and bytes of messages: Cyclone's own encoder, which we do not use, judges ours."""

import random

import pytest
from rosbags import typesys as rosbags

pytest.importorskip("cyclonedds", reason="install the extra `ros2` to try it")

from workbench.common.errors import WorkbenchError
from workbench.extras.gateways.ros2_dds import dds_name, message_type
from workbench.extras.gateways.ros2_definitions import (
    CLOCK_TYPE,
    gateway_types,
    included_definitions,
)
from workbench.link.ros_messages.definitions import STRUCT_CODE_BY_ROS_TYPE, TEXT_TYPE, Arity
from workbench.link.ros_messages.library import type_names

LIMITS = {"B": (0, 255), "b": (-128, 127), "H": (0, 65535), "h": (-32768, 32767)}
LIMITS |= {"I": (0, 2**32 - 1), "i": (-(2**31), 2**31 - 1)}
LIMITS |= {"Q": (0, 2**64 - 1), "q": (-(2**63), 2**63 - 1)}


def example(definitions, kind, draw):
    """Return values of a type, and the same as Cyclone wants them: as a list of arguments."""
    if kind == TEXT_TYPE:
        return "".join(draw.choices("abcä€ ", k=draw.randrange(9)))
    if kind in STRUCT_CODE_BY_ROS_TYPE:
        code = STRUCT_CODE_BY_ROS_TYPE[kind]
        if code == "?":
            return draw.random() < 0.5
        return draw.uniform(-9.0, 9.0) if code in "fd" else draw.randint(*LIMITS[code])
    values = {}
    for field in definitions[kind].fields:
        if field.arity is Arity.ONE:
            values[field.name] = example(definitions, field.type, draw)
        else:
            count = field.count if field.arity is Arity.FIXED else draw.randrange(5)
            many = [example(definitions, field.type, draw) for _ in range(count)]
            values[field.name] = bytes(many) if field.type in ("uint8", "byte") else tuple(many)
    return values


def as_idl(value, kind):
    """Return values as instances of Cyclone's types."""
    if isinstance(value, dict):
        inner = kind.__annotations__
        return kind(**{name: as_idl(each, inner[name]) for name, each in value.items()})
    if isinstance(value, tuple):
        (element,) = kind.__metadata__
        return [as_idl(each, element.subtype) for each in value]
    return value


def test_the_bytes_are_those_that_cyclone_makes(case):
    for name in (*type_names(), *gateway_types()):
        with case(name):
            kind, draw = message_type(name), random.Random(name)
            definitions = {each.name: each for each in included_definitions(name)}
            for _ in range(5):
                values = example(definitions, name, draw)
                # Cyclone fills up to four bytes only when it writes.
                expected = as_idl(values, kind.idl).serialize(use_version_2=False)
                assert kind.sample(values).serialize() == expected


def test_types_are_final_and_without_keys_and_named_as_in_ros(case):
    for name in (*type_names(), *gateway_types()):
        with case(name):
            idl = message_type(name).idl.__idl__
            idl.populate()
            assert idl.keyless
            assert idl.v1_machine is not None
            assert idl.idl_transformed_typename == dds_name(name)


def test_each_message_of_the_gateway_alone_has_the_type_hash_of_ros(case):
    """RIHS01 of REP-2016 covers names and types of all fields; rosbags has ROS 2's definitions."""
    theirs = rosbags.get_typestore(rosbags.Stores.ROS2_JAZZY)
    # rosbags reads a `char` in a text as uint8, unlike its own Gid,
    # and a bounded sequence has the bytes of any other
    left_out = ("rmw_dds_common/", "rcl_interfaces/msg/ParameterDescriptor")
    names = [n for n in gateway_types() if "/msg/" in n and not n.startswith(left_out)]
    assert "trajectory_msgs/msg/JointTrajectory" in names
    assert "rcl_interfaces/msg/ParameterEvent" in names
    for name in names:
        with case(name):
            ours = rosbags.get_typestore(rosbags.Stores.EMPTY)
            for each in included_definitions(name):
                ours.register(rosbags.get_types_from_msg(each.text, each.name))
            assert ours.hash_rihs01(name) == theirs.hash_rihs01(name)


def test_the_name_is_that_of_ros_in_dds():
    assert dds_name("nav_msgs/msg/Odometry") == "nav_msgs::msg::dds_::Odometry_"


def test_the_clock_is_two_integers():
    data = message_type(CLOCK_TYPE).sample({"clock": {"sec": 1, "nanosec": 2}}).serialize()
    assert data == bytes([0, 1, 0, 0, 1, 0, 0, 0, 2, 0, 0, 0])


def test_an_unknown_type_is_named():
    with pytest.raises(WorkbenchError, match="unknown type of message 'a/msg/B'"):
        message_type("a/msg/B")
