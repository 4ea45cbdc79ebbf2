"""Messages as columns."""

import numpy as np
import pytest

from workbench.common.errors import WorkbenchError
from workbench.gateways.ros_messages.cdr import encode
from workbench.gateways.ros_messages.library import schema_text
from workbench.logs.series import LoggedTopic

HEADER = {"stamp": {"sec": 1, "nanosec": 2}, "frame_id": "world"}
ACTION = "dh_drone_msgs/msg/PilotAction"


def logged(kind: str, *values: dict) -> LoggedTopic:
    messages = [encode(kind, {"header": HEADER, **each}) for each in values]
    t_ns = [1_000_000 * number for number in range(len(messages))]
    return LoggedTopic("/dh_drone/a", "a", kind, schema_text(kind), t_ns, messages)


def test_columns_have_names_units_and_times():
    wind = logged("dh_drone_msgs/msg/WindData", {"wind": [1, 2, 3]}, {"wind": [4, 5, 6]})
    assert [*wind.columns] == ["wind.0", "wind.1", "wind.2"]
    series = wind.columns["wind.1"]
    assert (series.name, series.unit) == ("a.wind.1", "m/s")
    assert series.values.tolist() == [2.0, 5.0]
    assert series.time == pytest.approx([0.0, 0.001])


def test_messages_of_one_size_may_be_laid_out_differently():
    said = [("ab", "cdef"), ("a", "cdef"), ("", "abcd")]
    topic = logged(ACTION, *({"step": 5, "by": by, "action": what} for by, what in said))
    assert len({len(message) for message in topic.messages}) == 1
    assert topic.columns["by"].values.tolist() == [by for by, _ in said]
    assert topic.columns["action"].values.tolist() == [what for _, what in said]
    assert topic.columns["step"].values.tolist() == [5, 5, 5]


def test_what_a_message_has_not_is_left_open():
    kind = "dh_drone_msgs/msg/RotorData"
    topic = logged(kind, {"speed": [1, 2], "thrust": []}, {"speed": [3], "thrust": [4]})
    assert topic.columns["speed.0"].values.tolist() == [1.0, 3.0]
    assert np.isnan(topic.columns["speed.1"].values).tolist() == [False, True]


def test_a_text_that_is_always_empty_is_a_column():
    topic = logged(ACTION, *[{"step": 1, "by": "", "action": "{}"}] * 3)
    assert topic.columns["by"].values.tolist() == ["", "", ""]


def test_a_message_that_cannot_be_decoded_is_a_sentence():
    topic = logged(ACTION, {"step": 1, "by": "a", "action": "{}"})
    broken = LoggedTopic(topic.name, "a", ACTION, topic.schema, [0], [topic.messages[0][:-3]])
    with pytest.raises(WorkbenchError, match="/dh_drone/a: cannot be decoded"):
        assert broken.columns
