"""Messages as columns."""

import numpy as np
import pytest

from workbench.common.errors import WorkbenchError
from workbench.link.ros_messages.cdr import encode
from workbench.link.ros_messages.definitions import SCHEMA_SEPARATOR
from workbench.link.ros_messages.library import schema_text
from workbench.logs.logged_topic import LoggedTopic
from workbench.logs.readers.messages import Messages, read_topic

HEADER = {"stamp": {"sec": 1, "nanosec": 2}, "frame_id": "world"}
ACTION, WIND = "dh_drone_msgs/msg/PilotAction", "dh_drone_msgs/msg/WindData"


def encoded(kind: str, *values: dict) -> list[bytes]:
    return [encode(kind, {"header": HEADER, **each}) for each in values]


def logged(kind: str, *messages: bytes) -> LoggedTopic:
    kept = Messages()
    for number, message in enumerate(messages):
        kept.add(1_000_000 * number, memoryview(message))
    return read_topic("/dh_drone/a", kind, schema_text(kind), kept)


def test_columns_have_names_units_and_times():
    wind = logged(WIND, *encoded(WIND, {"wind": [1, 2, 3]}, {"wind": [4, 5, 6]}))
    assert [*wind.columns] == ["wind.0", "wind.1", "wind.2"]
    series = wind.columns["wind.1"]
    assert (series.name, series.unit) == ("a.wind.1", "m/s")
    assert series.values.tolist() == [2.0, 5.0]
    assert series.time == pytest.approx([0.0, 0.001])
    assert wind.stamps == pytest.approx([1.000000002] * 2)


def test_messages_of_one_size_may_be_laid_out_differently():
    said = [("ab", "cdef"), ("a", "cdef"), ("", "abcd")]
    messages = encoded(ACTION, *({"step": 5, "by": by, "action": what} for by, what in said))
    assert len(set(map(len, messages))) == 1
    topic = logged(ACTION, *messages, *encoded(ACTION, {"step": 6, "by": "abc", "action": "d"}))
    said = [*said, ("abc", "d")]
    assert topic.columns["by"].values.tolist() == [by for by, _ in said]
    assert topic.columns["action"].values.tolist() == [what for _, what in said]
    assert topic.columns["step"].values.tolist() == [5, 5, 5, 6]


def test_what_a_message_has_not_is_left_open():
    kind = "dh_drone_msgs/msg/RotorData"
    rows = {"speed": [1, 2], "thrust": []}, {"speed": [3], "thrust": [4]}
    topic = logged(kind, *encoded(kind, *rows))
    assert topic.columns["speed.0"].values.tolist() == [1.0, 3.0]
    assert np.isnan(topic.columns["speed.1"].values).tolist() == [False, True]


def test_a_text_that_is_always_empty_is_a_column():
    topic = logged(ACTION, *encoded(ACTION, *[{"step": 1, "by": "", "action": "{}"}] * 3))
    assert topic.columns["by"].values.tolist() == ["", "", ""]


def test_messages_that_cannot_be_decoded_are_a_sentence(case):
    (whole,) = encoded(ACTION, {"step": 1, "by": "a", "action": "{}"})
    huge = "float64[4000000000] x\n"
    nested = f"a/msg/B x\n{SCHEMA_SEPARATOR}\nMSG: a/msg/B\na/msg/B x\n"
    for schema, message, said in (
        (schema_text(ACTION), whole[:-3], "shorter|cut short"),
        (schema_text(ACTION), b"", "little-endian"),
        ("float64 x\nfloat64 x\n", whole, "name"),
        ("float64[x] x\n", whole, "is not a field"),
        (huge, whole, "cut short"),
        (nested, whole, "recursion"),
        ("Missing x\n", whole, "Missing"),
    ):
        with case(said):
            kept = Messages()
            kept.add(0, memoryview(message))
            topic = read_topic("/dh_drone/a", ACTION, schema, kept)
            assert (topic.short, topic.fields, topic.t_ns.tolist()) == ("a", {}, [0])
            with pytest.raises(WorkbenchError, match=f"/dh_drone/a: cannot be decoded: .*({said})"):
                assert topic.columns


def test_a_part_of_the_time_has_the_points_of_its_clouds():
    kind = "sensor_msgs/msg/PointCloud2"
    fields = [
        {"name": name, "offset": 4 * i, "datatype": 7, "count": 1} for i, name in enumerate("xyz")
    ]
    clouds = [np.arange(3 * n, dtype="<f4").reshape(n, 3) for n in (2, 0, 3)]
    topic = logged(
        kind,
        *encoded(
            kind,
            *(
                {
                    "height": 1,
                    "width": len(each),
                    "fields": fields,
                    "is_bigendian": False,
                    "point_step": 12,
                    "row_step": 12 * len(each),
                    "data": each.tobytes(),
                    "is_dense": True,
                }
                for each in clouds
            ),
        ),
    )
    assert topic.points["y"].values.tolist() == np.concatenate(clouds)[:, 1].tolist()
    assert topic.points["z"].time.tolist() == [0.0, 0.0, 0.002, 0.002, 0.002]
