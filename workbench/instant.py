"""A flight at one time, all of it, so that another process can fly on from there."""

from dataclasses import dataclass


@dataclass(frozen=True)
class Instant:
    """Everything that decides how a flight goes on.

    Attributes:
        time: simulated [s].
    """

    time: float
