"""Definitions of messages as text."""

import pytest

from workbench.common.errors import WorkbenchError
from workbench.link.ros_messages.definitions import (
    Arity,
    MessageField,
    read_definition,
    split_schema,
)
from workbench.link.ros_messages.library import definition, included, schema_text, type_names

PAPER = (
    "AccelerationData",
    "DroneState",
    "DroneTime",
    "ForceTorqueData",
    "OnOffState",
    "PositionData",
    "VelocityData",
)


def test_fields_are_read_with_arity_unit_and_package():
    found = read_definition(
        "a_msgs/msg/All",
        "# a comment\n"
        "int32 SOME=3\n"
        "\n"
        "float32 v_x    # [m/s] east\n"
        "float64[36] covariance\n"
        "uint8[] data\n"
        "string[] names\n"
        "Part own\n"
        "std_msgs/Header header\n"
        "int8 status -2\n",
    )
    assert found.fields == (
        MessageField("v_x", "float32", Arity.ONE, 1, "m/s"),
        MessageField("covariance", "float64", Arity.FIXED, 36, ""),
        MessageField("data", "uint8", Arity.SEQUENCE, 1, ""),
        MessageField("names", "string", Arity.SEQUENCE, 1, ""),
        MessageField("own", "a_msgs/msg/Part", Arity.ONE, 1, ""),
        MessageField("header", "std_msgs/msg/Header", Arity.ONE, 1, ""),
        MessageField("status", "int8", Arity.ONE, 1, ""),
    )
    assert [field.nested for field in found.fields] == [False] * 4 + [True] * 2 + [False]


@pytest.mark.parametrize(
    ("line", "said"),
    [
        ("float32", "'float32' is not a field"),
        ("float32 Upper", "is not a field"),
        ("float3 x", "unknown type 'float3'"),
        ("int32[<=4 x", "is not a field"),
    ],
)
def test_a_line_that_is_no_field_is_named(line, said):
    with pytest.raises(WorkbenchError, match="a/msg/B, line 2") as caught:
        read_definition("a/msg/B", f"int32 fine\n{line}\n")
    assert said in str(caught.value)


def test_the_papers_interfaces_are_there():
    assert {f"dh_drone_msgs/msg/{name}" for name in PAPER} <= set(type_names())


def test_every_type_and_what_it_includes_is_there(case):
    for name in type_names():
        with case(name):
            names = [each.name for each in included(name)]
            assert names[0] == name
            assert len(set(names)) == len(names)
            assert all(field.name for each in included(name) for field in each.fields)


def test_a_schema_is_split_into_what_it_was_made_of():
    name = "tf2_msgs/msg/TFMessage"
    assert tuple(split_schema(name, schema_text(name)).values()) == included(name)


def test_an_unknown_type_names_a_near_one():
    with pytest.raises(WorkbenchError, match="did you mean 'std_msgs/msg/Header'"):
        definition("std_msgs/msg/Heade")
