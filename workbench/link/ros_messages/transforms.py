"""The tree of frames as ROS 2 transforms, by REP-105: `world`, `map`, `odom`, then the drone.

The simulation knows the true pose, so `map` and `odom` equal `world`. A drone whose base link has
another name also has `base_link`, at the same place.
"""

from collections.abc import Mapping, Sequence
from typing import Any

from workbench.link.ros_messages.making import (
    ROS_BODY_FRAME,
    ROS_MAP_FRAME,
    ROS_ODOM_FRAME,
    ROS_WORLD_FRAME,
    MessageMaker,
    header,
    quaternion_message,
    vector_message,
)
from workbench.link.topics import Topic

POSE_NUMBERS = 7
"""Numbers of a pose: x, y, z [m], and a quaternion w, x, y, z."""
_SAME_POSE = (0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0)


def base_frame(topic: Topic) -> str:
    """Return the name of the frame of the drone's base link, from the topic frames."""
    frames: Any = topic.about.get("frames", ())
    return next((str(child) for parent, child in frames if parent == ROS_WORLD_FRAME), "")


def transforms_maker(topic: Topic) -> MessageMaker:
    """Return the maker of one message with all frames, for logs and viewers.

    A log has no `/tf_static`, as whoever plays it may not know that it is for later readers, too.
    """
    moving, fixed = moving_transforms_maker(topic), fixed_transforms_maker(topic)

    def make(t_ns: int, values: Mapping[str, Any]) -> dict[str, Any]:
        parts = (moving(t_ns, values), fixed(t_ns, values))
        return {"transforms": [each for part in parts for each in part["transforms"]]}

    return make


def moving_transforms_maker(topic: Topic) -> MessageMaker:
    """Return the maker of the message of `/tf`: frames that move in their parents.

    A server that does not state which frames move has all of them here.
    """
    base, moving = base_frame(topic), topic.about.get("moving")
    chosen = [
        (ROS_ODOM_FRAME if child == base else parent, child, index)
        for index, (parent, child) in enumerate(_pairs(topic))
        if moving is None or child in _names(moving)
    ]

    def make(t_ns: int, values: Mapping[str, Any]) -> dict[str, Any]:
        return {"transforms": _placed(t_ns, chosen, values["poses"])}

    return make


def fixed_transforms_maker(topic: Topic) -> MessageMaker:
    """Return the maker of the message of `/tf_static`: frames fixed in their parents."""
    pairs, base, moving = _pairs(topic), base_frame(topic), topic.about.get("moving")
    names = {child for _, child in pairs}
    same = [(ROS_WORLD_FRAME, ROS_MAP_FRAME), (ROS_MAP_FRAME, ROS_ODOM_FRAME)]
    if base and ROS_BODY_FRAME not in names:
        same.append((base, ROS_BODY_FRAME))
    chosen = [
        (parent, child, index)
        for index, (parent, child) in enumerate(pairs)
        if moving is not None and child not in _names(moving)
    ]

    def make(t_ns: int, values: Mapping[str, Any]) -> dict[str, Any]:
        fixed = [_transform(t_ns, *pair, _SAME_POSE) for pair in same]
        return {"transforms": fixed + _placed(t_ns, chosen, values["poses"])}

    return make


def _pairs(topic: Topic) -> list[tuple[str, str]]:
    """Return parent and child of each frame."""
    frames: Any = topic.about["frames"]
    return [(str(parent), str(child)) for parent, child in frames]


def _names(moving: Any) -> set[str]:
    return set(map(str, moving))


def _placed(
    t_ns: int, chosen: Sequence[tuple[str, str, int]], poses: Sequence[float]
) -> list[dict[str, Any]]:
    """Return the transforms of some frames: parent, child and place in the poses of all."""
    return [
        _transform(t_ns, parent, child, poses[POSE_NUMBERS * index : POSE_NUMBERS * (index + 1)])
        for parent, child, index in chosen
    ]


def _transform(t_ns: int, parent: str, child: str, pose: Sequence[float]) -> dict[str, Any]:
    """Return a geometry_msgs/msg/TransformStamped."""
    return {
        "header": header(t_ns, parent),
        "child_frame_id": child,
        "transform": {
            "translation": vector_message(pose[:3]),
            "rotation": quaternion_message(pose[3:]),
        },
    }
