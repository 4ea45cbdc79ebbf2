"""A number that a controller or an estimator remembers from one update to the next."""

from dataclasses import dataclass


@dataclass(frozen=True)
class State:
    """A number that is remembered, with its SI unit and its value at the start."""

    name: str
    unit: str
    initial: float = 0.0
