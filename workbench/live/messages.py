"""Messages between a live flight's process and the process that shows it: frozen records.

None contains an object of Drake's, so a process that shows a flight need not load Drake.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from enum import Enum
from typing import TYPE_CHECKING

from workbench.control.controller import Controller

if TYPE_CHECKING:
    from workbench.link.backplane import Published, ServerStatus
    from workbench.link.messages import ControlState
    from workbench.live.choice import Choice
    from workbench.plant.formats.xacro import XacroArgument
    from workbench.scenario.excitation import ActiveExcitation
    from workbench.scenario.scenario import Action, Scenario
    from workbench.session.recording import Recording
    from workbench.session.snapshot import Snapshot
    from workbench.systems.sensors.samples import RecordedSamples


class Phase(Enum):
    """State of a live flight."""

    STARTING = "starting"
    FLYING = "flying"
    PAUSED = "paused"
    BROKEN = "broken"
    """The simulation cannot continue; everything flown so far is available, and it can restart."""
    ENDED = "ended"
    """The process has ended."""


MIN_PACE_SHARE = 0.98
"""A flight keeps up if it reaches this share of real time, or of a slower requested speed."""


@dataclass(frozen=True)
class Pace:
    """How well a flight keeps up with the wall clock.

    Attributes:
        asked: requested number of simulated seconds per second.
        achieved: simulated seconds per second over the last second or so.
        lag: largest lag behind the wall clock since the last report [s].
        given_up: total wall time that was not flown because the machine was too slow [s].
        slow: whether that happened within the last second.
    """

    asked: float
    achieved: float
    lag: float
    given_up: float
    slow: bool

    @property
    def too_slow(self) -> bool:
        """Whether a slow machine keeps the flight below real time and below the requested speed."""
        return self.slow and self.achieved < MIN_PACE_SHARE * min(self.asked, 1.0)

    @property
    def text(self) -> str:
        """The speed as short text, with the requested speed if the flight misses it."""
        reached = f"{self.achieved:.2f}\N{NO-BREAK SPACE}×"
        missed = self.slow and self.achieved < MIN_PACE_SHARE * self.asked
        return f"{reached} of {self.asked:g}\N{NO-BREAK SPACE}×" if missed else reached

    def __str__(self) -> str:
        reached = f"{self.achieved:.2f} times real time"
        if self.too_slow:
            return (
                f"this machine is too slow: {reached} instead of {self.asked:g}: let it fly "
                f"slower, or with fewer sensors"
            )
        if self.slow and self.achieved < MIN_PACE_SHARE * self.asked:
            return f"{reached}, the most that this machine reaches, instead of {self.asked:g}"
        return reached


# From the caller.


@dataclass(frozen=True)
class FlightStart:
    """The first message.

    Attributes:
        scenario: what to fly, see `Session`.
        settings: parameter values that override those of the scenario's gains.
        draw: whether to draw it in Meshcat.
        stream: whether to send everything that is published, sample by sample; the flight's own
            recording is then sparse.
        watch: whether the controller's file is loaded again whenever it is saved.
    """

    scenario: Scenario | Choice
    settings: Mapping[str, float]
    draw: bool
    stream: bool
    watch: bool = False


CLOSE_MESSAGE = "close"
"""The last message."""


# From the flight's process.


@dataclass(frozen=True)
class ViewChange:
    """Attributes of the `LiveView` with new values.

    Attributes:
        values: new values, by name of the attribute.
    """

    values: Mapping[str, object]


@dataclass(frozen=True)
class FlightNotice:
    """A remark about something that was read or built."""

    said: str


@dataclass(frozen=True)
class ControllerChange:
    """Another controller, or another text of its file, now flies.

    Attributes:
        controller: the flying controller.
        values: present values of the live parameters, by name.
        named: the controller as a scenario names it.
        gains: its gain file, "" without one.
    """

    controller: Controller
    values: Mapping[str, float]
    named: str
    gains: str


@dataclass(frozen=True)
class HardHit:
    """A hard hit.

    Attributes:
        time: simulated [s].
        speed: change of the drone's velocity [m/s].
    """

    time: float
    speed: float


@dataclass(frozen=True)
class AutopilotView:
    """State of the exchange with a program that runs the law.

    Attributes:
        exchange: statistics since the program's start, see `LawProgram.report`; empty before.
        ended: why the program ended in flight, and what to do; "" while it runs.
    """

    exchange: Mapping[str, float]
    ended: str = ""


@dataclass(frozen=True)
class NetworkView:
    """State of the network and the log.

    Attributes:
        server: its last status, None if no server runs.
        control: who has control, None until this is known.
        said: why the server ended; else "".
        starts_again: whether the server ended by itself and is being restarted.
        log: path of the present log, "" without one.
        log_said: why the last log is incomplete; else "".
    """

    server: ServerStatus | None = None
    control: ControlState | None = None
    said: str = ""
    log: str = ""
    starts_again: bool = False
    log_said: str = ""


@dataclass(frozen=True)
class FlightReport:
    """The present of a flight.

    Attributes:
        phase: state of the flight.
        said: progress of a start; why the flight is broken, or has ended; else "".
        snapshot: the newest one, None until the flight has begun.
        pace: how well the flight keeps up with the wall clock.
        network: who is connected and who has control.
        exciting: the present excitation, None without one.
        flight: number of the flight in its process; a reset starts the next one.
        excitation_ended: why the last excitation ended early, else "".
        hit: the last hard hit of this flight, None before the first.
        measuring: flown share of a measurement, 0 .. 1, None without one.
        autopilot: state of the program that runs the law, None without one.
        lasting: what those warnings of the flight say whose cause lasts.
        next_action: next action of the scenario's script, None without one.
    """

    phase: Phase = Phase.STARTING
    said: str = "starting a process"
    snapshot: Snapshot | None = None
    pace: Pace | None = None
    network: NetworkView = NetworkView()
    exciting: ActiveExcitation | None = None
    flight: int = 0
    excitation_ended: str = ""
    hit: HardHit | None = None
    measuring: float | None = None
    autopilot: AutopilotView | None = None
    lasting: tuple[str, ...] = ()
    next_action: Action | None = None


@dataclass(frozen=True)
class StreamedRecords:
    """What was published since the last message of this class.

    Attributes:
        published: topics in order of time.
        lost: number of times left out before them because the reader was too slow.
    """

    published: tuple[Published, ...]
    lost: int


@dataclass(frozen=True)
class FlightFailure:
    """The flight cannot start, or ends: a sentence, and missing arguments of its xacro file."""

    said: str
    needed: tuple[XacroArgument, ...] = ()


@dataclass(frozen=True)
class FlownSoFar:
    """Everything flown since the start.

    Attributes:
        recording: recording of the flight.
        samples: samples of the sensors, if the scenario keeps them.
        scenario: scenario that repeats the flight to the bit: its script has the pilot's actions.
    """

    recording: Recording
    samples: tuple[RecordedSamples, ...]
    scenario: Scenario
