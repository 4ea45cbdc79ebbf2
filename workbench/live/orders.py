"""Orders to a live flight, a frozen record each; those that fly the drone are an `Action`.

Unless stated otherwise, the answer is the simulated time at which an order took effect [s]. The
flight checks what an order contains, and refuses it with a sentence.
"""

from dataclasses import dataclass
from enum import Enum

import numpy as np

from workbench.link.backplane import Disconnect
from workbench.link.server.config import ServerConfig
from workbench.scenario.excitation import Excitation
from workbench.scenario.scenario import Action, Injection


class FlightOrder(Enum):
    """Orders to the flight that have no argument."""

    PAUSE = "pause"
    RESUME = "resume"
    RESET = "reset"
    STOP_EXCITING = "stop exciting"
    """Hover in place, if an excitation or a measurement is flown."""
    GET_FLOWN = "get what was flown"
    """The answer is a `FlownSoFar`."""
    GET_CHECKPOINT = "get a checkpoint"
    """The answer is the state that determines the rest of the flight."""


class NetworkOrder(Enum):
    """Orders to the flight's network and log that have no argument."""

    STOP_SERVING = "stop serving"
    """Disconnect all clients and end the server."""
    STOP_LOG = "stop the log"
    """The answer is the log's path."""
    TAKE_OVER = "take over"
    """Take control for the operator; an `Action` that flies does that, too."""
    GIVE_BACK = "give back"
    """Allow clients to request control again."""


@dataclass(frozen=True)
class SetSpeed:
    """Fly this number of simulated seconds per second, 0.01 to 20."""

    factor: float


@dataclass(frozen=True)
class FlyOn:
    """Fly on for a time [s], up to 60, as fast as possible; only while paused."""

    duration: float


@dataclass(frozen=True)
class GetParameter:
    """The answer is the present value of a live parameter."""

    name: str


@dataclass(frozen=True)
class GetReading:
    """The answer is the last delivered `Reading` of a sensor, by name or kind; None without one."""

    sensor: str


@dataclass(frozen=True)
class MeasureLoop:
    """Measure a loop by an injection; the answer is its start time [s].

    `LiveView.measured` has the measurement after each of its periods. It ends as an excitation
    does, and the drone returns to its start.

    Attributes:
        injection: see `design.judge.loop_measurement`.
        hold: whether the loop is one that holds a place.
    """

    injection: Injection
    hold: bool


@dataclass(frozen=True)
class ShowPrediction:
    """Draw a predicted path in Meshcat, in place of the last one.

    Attributes:
        ends: simulated time until which it is shown [s].
        p_WB: points on it (N, 3) [m]; fewer than two draw none.
    """

    ends: float
    p_WB: np.ndarray


@dataclass(frozen=True)
class KeepLog:
    """Write a log (MCAP) from the flight's start on; the answer is its path.

    After a reset it continues in the next file.
    """

    path: str


LiveOrder = (
    Action  # fly, or change what flies
    | FlightOrder
    | Excitation  # fly it; the answer is its start, the next control update [s]
    | MeasureLoop
    | SetSpeed
    | FlyOn
    | GetParameter
    | GetReading
    | ShowPrediction
    | NetworkOrder
    | ServerConfig  # let clients watch and fly; the answer is the server's address
    | Disconnect  # of a client, by its number in `latest().network.server.clients`
    | KeepLog
)
"""What `LiveFlight.do` takes."""
