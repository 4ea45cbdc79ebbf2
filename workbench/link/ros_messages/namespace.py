"""The ROS 2 namespace of a vehicle, by REP-144 and the rules for names of topics."""

import re

from workbench.link.topics import PREFIX

DEFAULT_NAMESPACE = "drone"
"""Namespace of a vehicle whose name has no letter or digit of ROS."""


def ros_name(text: str, prefix: str) -> str:
    """Return a name that ROS 2 allows: what it does not allow becomes a single underscore.

    Args:
        text: the name.
        prefix: before a name that would begin with a digit, and in place of one without any letter
            or digit of ROS.
    """
    name = re.sub(r"[^A-Za-z0-9]+", "_", text).strip("_")
    return name if name[:1].isalpha() else f"{prefix}_{name}".rstrip("_")


def ros_namespace(vehicle: str) -> str:
    """Return the ROS 2 namespace of a vehicle by its name, as `crazyflie`, without slashes."""
    return ros_name(vehicle, DEFAULT_NAMESPACE)


def in_namespace(topic: str, namespace: str) -> str:
    """Return a topic of the link in another namespace; `/tf` and `/clock` stay as they are."""
    if not topic.startswith(PREFIX):
        return topic
    return f"/{namespace}/{topic.removeprefix(PREFIX)}"


def link_topic(topic: str, namespace: str) -> str:
    """Return the name that a topic in a namespace has in the link; reverses `in_namespace`."""
    own = f"/{namespace}/"
    return PREFIX + topic.removeprefix(own) if topic.startswith(own) else topic
