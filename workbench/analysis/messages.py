"""What goes between who asks an analyst and its processes, besides requests: frozen records."""

from collections.abc import Mapping
from dataclasses import dataclass

from workbench.analysis.replies import Searched
from workbench.scenario.scenario import Scenario

# From the caller.


@dataclass(frozen=True)
class Begin:
    """The first message.

    Attributes:
        scenario: whose vehicle is judged.
        settings: values of the live parameters, over those of its gains.
        niceness: added to the process's own, so that a flight beside it goes first.
    """

    scenario: Scenario
    settings: Mapping[str, float]
    niceness: int


@dataclass(frozen=True)
class Stop:
    """End what was asked up to a number: a search keeps its best, other work is given up."""

    number: int


# From the process.


@dataclass(frozen=True)
class Preparing:
    """What is being done before any answer, as compiling, in words."""

    said: str


@dataclass(frozen=True)
class Progressed:
    """How a long question goes."""

    number: int
    searched: Searched
