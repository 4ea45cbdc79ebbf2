"""What goes between a live flight's process and the one that shows it: frozen records.

None carries an object of Drake's, so that who shows a flight need not load Drake.
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
    from workbench.scenario.excitation import Exciting
    from workbench.scenario.scenario import Scenario
    from workbench.session.recording import Recording
    from workbench.session.snapshot import Snapshot
    from workbench.systems.sensors.samples import Samples


class Phase(Enum):
    """Where a live flight is."""

    STARTING = "starting"
    FLYING = "flying"
    PAUSED = "paused"
    BROKEN = "broken"
    """The simulation cannot go on; what was flown is there, and it can begin again."""
    ENDED = "ended"
    """The process is gone."""


KEPT = 0.98
"""Share of real time, or of a slower speed that is asked for, from which a flight keeps it."""


@dataclass(frozen=True)
class Pace:
    """How well a flight keeps up with the wall clock.

    Attributes:
        asked: simulated seconds in a second that are wanted.
        achieved: that were flown over the last second or so.
        lag: largest wall time by which the flight was behind since the last report [s].
        given_up: wall time that was not flown as the machine was too slow, in all [s].
        slow: whether that happened within the last second.
    """

    asked: float
    achieved: float
    lag: float
    given_up: float
    slow: bool

    @property
    def too_slow(self) -> bool:
        """Whether the flight is slower than real time, and than asked, as the machine is."""
        return self.slow and self.achieved < KEPT * min(self.asked, 1.0)

    @property
    def text(self) -> str:
        """The speed in a few characters, with the speed that is asked for where that is missed."""
        reached = f"{self.achieved:.2f}\N{NO-BREAK SPACE}×"
        missed = self.slow and self.achieved < KEPT * self.asked
        return f"{reached} of {self.asked:g}\N{NO-BREAK SPACE}×" if missed else reached

    def __str__(self) -> str:
        reached = f"{self.achieved:.2f} times real time"
        if self.too_slow:
            return (
                f"this machine is too slow: {reached} instead of {self.asked:g}: let it fly "
                f"slower, or with fewer sensors"
            )
        if self.slow and self.achieved < KEPT * self.asked:
            return f"{reached}, the most that this machine reaches, instead of {self.asked:g}"
        return reached


# From the caller.


@dataclass(frozen=True)
class Begin:
    """The first message.

    Attributes:
        scenario: what to fly, see `Session`.
        settings: values that override those of its gains.
        draw: whether to draw it in Meshcat.
        stream: whether to send everything that is published, sample by sample; the flight's own
            recording is sparse then.
        watch: whether the controller's file takes over again whenever it is saved.
    """

    scenario: Scenario | Choice
    settings: Mapping[str, float]
    draw: bool
    stream: bool
    watch: bool = False


class Do(Enum):
    """What an `Order` asks for; it is answered by the simulated time [s], where nothing is said."""

    PAUSE = "pause"
    RESUME = "resume"
    RESET = "reset"
    SET_SPEED = "set the speed"
    """Fly so many seconds in a second."""
    FLY_ON = "fly on"
    """Fly on for a time [s] at once, in a pause."""
    GET = "get"
    """The answer is the value of a live parameter, by its name."""
    READ = "read"
    """The answer is what a sensor, by name or kind, delivered last."""
    GET_FLOWN = "get what was flown"
    """The answer is a `Flown`."""
    GET_CHECKPOINT = "get a checkpoint"
    """The answer is all that decides how the flight goes on."""
    EXCITE = "excite"
    """Fly an `Excitation` from the next control update on; the answer is its time."""
    MEASURE = "measure"
    """Measure a loop by an `Injection` from the next control update on; the answer is its time.
    With it comes whether the loop is one that holds a place."""
    STOP_EXCITING = "stop exciting"
    """Hover where it is, if an excitation or a measurement is flown."""
    FORESEE = "foresee"
    """Draw a way that is predicted instead of the one drawn before: when it is over, in simulated
    time [s], and places on it (N, 3) [m]; fewer than two draw none."""
    SERVE = "serve"
    """Start a server by a `ServerConfig`; the answer is its address."""
    STOP_SERVING = "stop serving"
    KEEP_LOG = "keep a log"
    """Write all that happens from the flight's start on to a file; the answer is its path."""
    STOP_LOG = "stop the log"
    """The answer is the log's path."""
    DISCONNECT = "disconnect"
    """Send a client away, by a `Disconnect`."""
    TAKE_OVER = "take over"
    """Take control for the operator."""
    GIVE_BACK = "give back"
    """Let clients ask for control again."""


@dataclass(frozen=True)
class Order:
    """What is asked of a flight besides an `Action`.

    Attributes:
        what: is asked.
        value: that belongs to it, see `Do`; None where nothing does.
    """

    what: Do
    value: object = None


CLOSE = "close"
"""The last message."""


# From the flight's process.


@dataclass(frozen=True)
class Changed:
    """Attributes of the `LiveView` that have other values now.

    Attributes:
        values: by the attribute's name.
    """

    values: Mapping[str, object]


@dataclass(frozen=True)
class Told:
    """A remark on what was read or built."""

    said: str


@dataclass(frozen=True)
class TakenOver:
    """Another controller flies, or another text of its file.

    Attributes:
        controller: that flies.
        values: of the live parameters now, by name.
        named: the controller as a scenario names it.
        gains: its gain file, "" without.
    """

    controller: Controller
    values: Mapping[str, float]
    named: str
    gains: str


@dataclass(frozen=True)
class Hit:
    """A hard hit.

    Attributes:
        time: simulated [s].
        speed: by how much it changed the drone's velocity [m/s].
    """

    time: float
    speed: float


@dataclass(frozen=True)
class AutopilotView:
    """How the exchange with a program goes that runs the law.

    Attributes:
        exchange: numbers of it since the program's start, by name, see `Program.report`; none
            before.
        ended: why the program has ended in flight, and what to do; "" while it lives.
    """

    exchange: Mapping[str, float]
    ended: str = ""


@dataclass(frozen=True)
class NetworkView:
    """How the network and the log do.

    Attributes:
        server: as it said last, None where none runs.
        control: who flies, None until it was said.
        said: why there is no server any more; "" else.
        starts_again: whether the server has ended by itself and is being started again.
        log: path of the log that is being written, "" without.
        log_said: why the last log is not whole; "" else.
    """

    server: ServerStatus | None = None
    control: ControlState | None = None
    said: str = ""
    log: str = ""
    starts_again: bool = False
    log_said: str = ""


@dataclass(frozen=True)
class Report:
    """The present: where the flight is, a sentence where it is broken, its network, and more.

    `exciting` is the excitation that is flown, None while none is; `flight` counts the flights that
    this process has begun, one at its start and one with every reset; `excitation_ended` says why
    the last excitation ended before it was over, "" where it did not; `hit` is the last hard hit,
    if any; `measuring` is how much of a measurement is flown, 0 .. 1, None while none is;
    `autopilot` is the program that runs the law, None where none does.
    """

    phase: Phase
    said: str
    snapshot: Snapshot
    pace: Pace
    network: NetworkView
    exciting: Exciting | None
    flight: int
    excitation_ended: str = ""
    hit: Hit | None = None
    measuring: float | None = None
    autopilot: AutopilotView | None = None


@dataclass(frozen=True)
class Streamed:
    """What was published since the last of these.

    Attributes:
        published: in the order of time.
        lost: how many before them were left out, as the reader was too slow.
    """

    published: tuple[Published, ...]
    lost: int


@dataclass(frozen=True)
class Failed:
    """The flight cannot begin, or ends: a sentence, and arguments that its xacro file needs."""

    said: str
    needed: tuple[XacroArgument, ...] = ()


@dataclass(frozen=True)
class Flown:
    """All that was flown since the start.

    Attributes:
        recording: of the flight.
        samples: of the sensors, where the scenario keeps them.
        scenario: which flies the same again, to the bit: what the pilot did is in its script.
    """

    recording: Recording
    samples: tuple[Samples, ...]
    scenario: Scenario
