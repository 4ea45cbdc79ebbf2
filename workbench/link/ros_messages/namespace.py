"""The ROS 2 namespace of a vehicle, by REP-144 and the rules for names of topics."""

import re

from workbench.link.topics import PREFIX

DEFAULT_NAMESPACE = "drone"
"""Namespace of a vehicle whose name has no letter or digit of ROS."""


def ros_namespace(vehicle: str) -> str:
    """Return the ROS 2 namespace of a vehicle, such as `crazyflie`, without slashes.

    What ROS does not allow in names becomes an underscore; a name does not begin with a digit.

    Args:
        vehicle: its name.
    """
    name = re.sub(r"__+", "_", re.sub(r"[^A-Za-z0-9]", "_", vehicle)).strip("_")
    if not name:
        return DEFAULT_NAMESPACE
    return f"{DEFAULT_NAMESPACE}_{name}" if name[0].isdigit() else name


def in_namespace(topic: str, namespace: str) -> str:
    """Return a topic of the link in another namespace; `/tf` and `/clock` stay as they are."""
    if not topic.startswith(PREFIX):
        return topic
    return f"/{namespace}/{topic.removeprefix(PREFIX)}"


def link_topic(topic: str, namespace: str) -> str:
    """Return the name that a topic in a namespace has in the link; reverses `in_namespace`."""
    own = f"/{namespace}/"
    return PREFIX + topic.removeprefix(own) if topic.startswith(own) else topic
