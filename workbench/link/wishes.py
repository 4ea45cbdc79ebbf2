"""What a client wants to be and to get, checked before anything is sent."""

import math
from collections.abc import Sequence
from dataclasses import dataclass, field

from workbench.common.errors import WorkbenchError, unknown_name
from workbench.link.drone_topics import LONGEST_NAME
from workbench.link.operations import FASTEST, SLOWEST, Role
from workbench.link.topics import PREFIX

ALL = "*"


@dataclass(frozen=True)
class Wishes:
    """What a client wants to be and to get.

    Attributes:
        name: what it calls itself.
        token: of its role; empty where it has none.
        role: what it wants to do.
        topics: names, or "*" for all.
        rate: largest frames a second of each topic; None for all there are [1/s].
    """

    name: str = ""
    token: str = field(default="", repr=False)
    role: Role = Role.COMMAND
    topics: tuple[str, ...] = (ALL,)
    rate: float | None = None


def make_wishes(
    name: str, token: str, role: Role | str | None, topics: Sequence[str], rate: float | None
) -> Wishes:
    """Return the wishes that a user's words mean.

    Raises:
        WorkbenchError: if one of them cannot be.
    """
    if not name.isprintable() or len(name.encode()) > LONGEST_NAME:
        raise WorkbenchError(
            f"the name {name[:LONGEST_NAME]!r} is none: at most {LONGEST_NAME} bytes that can be "
            "printed"
        )
    if rate is not None and not (math.isfinite(rate) and SLOWEST <= rate <= FASTEST):
        raise WorkbenchError(f"the rate {rate} is not within {SLOWEST:g} .. {FASTEST:g} a second")
    if isinstance(topics, str):
        topics = (topics,)
    try:
        wanted = Role.COMMAND if role is None else Role(role)
    except ValueError:
        raise unknown_name("role", str(role), (each.value for each in Role)) from None
    return Wishes(name, token, wanted, tuple(full_name(topic) for topic in topics), rate)


def full_name(topic: str) -> str:
    """Return a topic's name with the part that all have in common."""
    return topic if topic == ALL or topic.startswith("/") else PREFIX + topic
