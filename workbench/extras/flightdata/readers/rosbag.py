"""Read bags of ROS 2, as `ros2 bag record` writes them.

Signals with names of the workbench come from standard messages, the first topic of each type;
all other numbers keep the names of the bag. A `PoseStamped` is a setpoint if the name of its topic
says so. Axes are those of REP-103: the body is forward, left, up, and the fixed frame has z up.

A message has the time of its header, or else that of the bag. If headers have another clock than
the bag, as in a simulation, messages without one have the time that headers show then.
"""

import re
from collections.abc import Iterator, Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np

from workbench.common.errors import WorkbenchError
from workbench.common.flight import Flight
from workbench.extras.flightdata.readers.axes import angles
from workbench.extras.flightdata.readers.rosbag_messages import bag_messages, is_rosbag
from workbench.extras.flightdata.readers.topic_log import (
    MessageTable,
    SignalRow,
    attitude_rows,
    first_names,
    topic_record,
)
from workbench.logs.logged_signal import (
    ACCELEROMETER_SIGNALS,
    GYRO_SIGNALS,
    SETPOINT_SIGNALS,
    component_names,
)
from workbench.logs.logged_topic import LoggedTopic
from workbench.logs.readers.log_reader import LogReader
from workbench.logs.readers.messages import Messages, read_topic
from workbench.logs.readers.rotations import continuous, vectors_in_world

ROSBAG_FORMAT = "ROS 2 bag"
MAX_BAG_TOPICS = 2000
MAX_HEADER_DELAY_NS = 60_000_000_000
"""Time between a header and its message in the bag above which their clocks differ [ns]."""
_SECOND_NS = 1e-9
_MIN_STAMP_NS = 1
"""Headers without a time have 0."""
_SETPOINT_WORDS = {"goal", "setpoint", "target", "command", "cmd", "reference", "desired"}
_IMU_TYPE, _POSE_TYPE = "sensor_msgs/msg/Imu", "geometry_msgs/msg/PoseStamped"
_SETPOINT_POSE = f"setpoint {_POSE_TYPE}"
_UNKNOWN_COVARIANCE = -1.0
"""First covariance of a quantity of an Imu that is not measured."""


def read_rosbag(path: Path) -> Flight:
    """Read a bag.

    Raises:
        WorkbenchError: if it cannot be read, or has no messages with numbers.
    """
    topics, remarks = [], []
    for topic in _bag_topics(path):
        if topic.damage:
            remarks.append(f"{topic.name} was left out: {topic.damage}")
        else:
            topics.append(topic)
    tables, kinds = {}, {}
    every, remark = _times(topics)
    first = min((int(times.min()) for times in every if len(times)), default=0)
    for topic, times in zip(topics, every, strict=True):
        fields = {
            name.replace(" ", "_"): column.values.astype(float)
            for name, column in topic.fields.items()
            if column.values.dtype.kind in "fiub"
        }
        if topic.type == _IMU_TYPE:
            _leave_out_unknown(fields)
        if fields:
            tables[topic.name] = MessageTable((times - first).astype(float), fields)
            kinds.setdefault(_kind(topic), topic.name)
    if not tables:
        raise WorkbenchError(f"{path}: has no messages with numbers: record topics of the flight")
    flight = topic_record(
        path,
        ROSBAG_FORMAT,
        tables,
        list(_rows(kinds)),
        tick=_SECOND_NS,
        noun="message",
        firmware="",
        parameters={},
        remarks=[*remarks, remark],
    )
    return replace(flight, clock_start=flight.clock_start + _SECOND_NS * first)


def _bag_topics(path: Path) -> list[LoggedTopic]:
    """Return the topics of a bag.

    Raises:
        WorkbenchError: if it cannot be read.
    """
    messages: dict[str, Messages] = {}
    definitions: dict[str, tuple[str, str]] = {}
    for name, kind, text, t_ns, data in bag_messages(path):
        if name not in definitions and len(definitions) >= MAX_BAG_TOPICS:
            raise WorkbenchError(f"{path}: has more than {MAX_BAG_TOPICS} topics")
        definitions.setdefault(name, (kind, text))
        messages.setdefault(name, Messages()).add(t_ns, memoryview(data))
    return [
        read_topic(name, kind, text, messages[name])
        if text
        else LoggedTopic(name, kind, np.empty(0), {}, damage=f"the bag does not define {kind}")
        for name, (kind, text) in definitions.items()
    ]


def _kind(topic: LoggedTopic) -> str:
    """Return the type of a topic, apart for poses that are setpoints."""
    words = set(re.split(r"[/_]", topic.name.lower()))
    return _SETPOINT_POSE if topic.type == _POSE_TYPE and words & _SETPOINT_WORDS else topic.type


def _leave_out_unknown(fields: dict[str, np.ndarray]) -> None:
    """Leave out the quantities of an Imu that it does not measure, in place."""
    for quantity in ("orientation", "angular_velocity", "linear_acceleration"):
        covariance = fields.get(f"{quantity}_covariance.0", np.zeros(1))
        for name in fields:
            if name.startswith(f"{quantity}."):
                fields[name] = np.where(covariance == _UNKNOWN_COVARIANCE, np.nan, fields[name])


def _header_times(topic: LoggedTopic) -> np.ndarray | None:
    """Return the times in the headers of a topic (n) [ns], None unless all have one."""
    stamps = topic.stamps_ns
    known = stamps is not None and len(stamps) > 0 and (stamps >= _MIN_STAMP_NS).all()
    return stamps if known else None


def _times(topics: Sequence[LoggedTopic]) -> tuple[list[np.ndarray], str]:
    """Return the times of the messages of each topic [ns], and a remark on clocks that differ.

    The clock is that of the topic with a header that has the most messages.
    """
    stamped = [each for each in topics if _header_times(each) is not None]
    if not stamped:
        return [each.t_ns for each in topics], ""
    clock = max(stamped, key=lambda each: len(each.t_ns))
    shown = _header_times(clock)
    assert shown is not None
    delay = float(np.median(clock.t_ns - shown))
    order = np.argsort(clock.t_ns, kind="stable")
    received, shown = clock.t_ns[order], np.maximum.accumulate(shown[order])

    def converted(times: np.ndarray) -> np.ndarray:
        inside = np.clip(times, received[0], received[-1])
        offsets = np.interp(inside, received, (shown - received).astype(float))
        return times + np.rint(offsets).astype(np.int64)

    differs = abs(delay) > MAX_HEADER_DELAY_NS
    found, other = [], []
    for topic in topics:
        stamps = _header_times(topic)
        if stamps is not None and (
            abs(float(np.median(topic.t_ns - stamps)) - delay) <= MAX_HEADER_DELAY_NS
        ):
            found.append(stamps)
            continue
        found.append(converted(topic.t_ns) if differs else topic.t_ns)
        if differs or stamps is not None:
            other.append(topic.name)
    if not other:
        return found, ""
    listed = first_names(other)
    return found, f"{listed}: the time is that of arrival, on the clock of {clock.name}'s headers"


def _rows(topics: dict[str, str]) -> Iterator[SignalRow]:
    """Yield what standard messages become, from the first topic of each type."""
    if topic := topics.get("nav_msgs/msg/Odometry"):
        yield from _pose_rows(topic, "pose.pose.")
        turn = component_names("pose.pose.orientation.", "wxyz")
        for kind, symbol, unit in (("linear", "v", "m/s"), ("angular", "w", "rad/s")):
            yield SignalRow(
                topic,
                (*turn, *component_names(f"twist.twist.{kind}.")),
                component_names(f"velocity_data.{symbol}_"),
                unit,
                lambda values: vectors_in_world(values[:, :4], values[:, 4:]),
            )
    if topic := topics.get(_POSE_TYPE):
        yield from _pose_rows(topic, "pose.")
    if topic := topics.get(_SETPOINT_POSE):
        yield SignalRow(topic, component_names("pose.position."), SETPOINT_SIGNALS, "m")
        yield SignalRow(
            topic,
            component_names("pose.orientation.", "wxyz"),
            ("setpoint.yaw",),
            "rad",
            lambda values: angles(continuous(values))[:, 2:],
        )
    if topic := topics.get(_IMU_TYPE):
        yield SignalRow(topic, component_names("angular_velocity."), GYRO_SIGNALS, "rad/s")
        yield SignalRow(
            topic, component_names("linear_acceleration."), ACCELEROMETER_SIGNALS, "m/s^2"
        )
        yield from attitude_rows(
            topic, component_names("orientation.", "wxyz"), "position_data", continuous, "attitude"
        )


def _pose_rows(topic: str, path: str) -> Iterator[SignalRow]:
    """Yield the rows of a pose at a path in the messages of a topic."""
    yield SignalRow(
        topic, component_names(f"{path}position."), component_names("position_data."), "m"
    )
    yield from attitude_rows(
        topic,
        component_names(f"{path}orientation.", "wxyz"),
        "position_data",
        continuous,
        "attitude",
    )


LOG_READER = LogReader(
    ROSBAG_FORMAT,
    "a bag of ROS 2 (.mcap, .db3)",
    lambda _, head: is_rosbag(head),
    lambda file: read_rosbag(file.path),
    place=55,
    endings=(".db3",),
    needs_plain=True,
)
