"""What is known of a flight at one time, as the terminal shows it."""

import json
import math
import time
from collections.abc import Callable, Mapping
from dataclasses import dataclass

from workbench.link import Client
from workbench.link.messages import ControlState, Hand
from workbench.link.sample import Sample
from workbench.link.topics import PREFIX, Direction, Value

WINDOW = 1.0
"""Over which the rate is counted [s]."""
SMALL = 64
"""Topics with a field of more numbers than this are no reading for people."""


@dataclass(frozen=True)
class Picture:
    """What is known of a flight at one time.

    Attributes:
        vehicle: what is flown.
        address: of the server.
        trouble: why there is no connection, "" while there is one.
        control: who flies, None while that is unknown.
        mine: whether it is this client.
        rate: samples a second that come.
        age: of the newest state, by both computers' clocks [s]; None where it is unknown.
        strongest: thrust at the end of a bar [N].
        samples: the newest, by the topic's short name.
    """

    vehicle: str
    address: str
    trouble: str
    control: ControlState | None
    mine: bool
    rate: float
    age: float | None
    strongest: float
    samples: Mapping[str, Sample]

    @property
    def time(self) -> float | None:
        """Simulated time of the newest sample [s]."""
        return max((each.time for each in self.samples.values()), default=None)


class Camera:
    """Takes pictures of a flight.

    Args:
        client: of the flight's server, open.
        address: of the server, for people.
        clock: time now [s].
        wall: date [ns].
    """

    def __init__(
        self,
        client: Client,
        address: str,
        clock: Callable[[], float] = time.monotonic,
        wall: Callable[[], int] = time.time_ns,
    ) -> None:
        self._client = client
        self._address = address
        self._clock = clock
        self._wall = wall
        self._counted = (clock(), client.received)
        self._rate = 0.0
        self._strongest = 0.0

    def picture(self) -> Picture:
        """Return what is known now."""
        client = self._client
        hello = client.hello
        samples = {
            topic.name.removeprefix(PREFIX): sample
            for topic in hello.topics
            if topic.direction is not Direction.IN
            and all(field.count <= SMALL or field.type == "char" for field in topic.fields)
            and (sample := client.latest(topic.name)) is not None
        }
        if "rotors" in samples:
            thrusts = numbers(samples["rotors"], "thrust")
            # Bars of a drone that hovers are two thirds long until it has shown more.
            mean = sum(thrusts) / max(len(thrusts), 1)
            self._strongest = max(self._strongest, 1.5 * mean, *thrusts)
        control = client.control_state
        return Picture(
            vehicle=hello.vehicle,
            address=self._address,
            trouble=client.trouble,
            control=control,
            mine=control is not None and (control.hand, control.peer) == (Hand.CLIENT, hello.peer),
            rate=self._count(),
            age=self._age(samples.get("time_data")),
            strongest=self._strongest,
            samples=samples,
        )

    def _count(self) -> float:
        now, received = self._clock(), self._client.received
        since, before = self._counted
        if now - since >= WINDOW:
            self._rate = (received - before) / (now - since)
            self._counted = (now, received)
        elif self._rate == 0.0 and now > since:  # the first second has a rate too
            return (received - before) / (now - since)
        return self._rate

    def _age(self, sample: Sample | None) -> float | None:
        if sample is None:
            return None
        return max(0.0, (self._wall() - int(number(sample, "wall_ns"))) / 1e9)


def number(sample: Sample, field: str) -> float:
    """Return a field that is a number, NaN if there is none of that name."""
    value = sample.values.get(field)
    return value if isinstance(value, int | float) else math.nan


def numbers(sample: Sample, field: str) -> tuple[float, ...]:
    """Return a field of several numbers; of one, where the server has only one."""
    value = sample.values.get(field, ())
    return value if isinstance(value, tuple) else (number(sample, field),)


def text(sample: Sample, field: str) -> str:
    """Return a field that is a text, without what a terminal might obey."""
    value = str(sample.values.get(field, ""))
    return "".join(sign if sign.isprintable() else "?" for sign in value)


def as_json(picture: Picture) -> str:
    """Return the object; numbers are in SI units, and what is not finite is null."""
    control = picture.control
    said = {
        "vehicle": picture.vehicle,
        "address": picture.address,
        "connected": not picture.trouble,
        "trouble": picture.trouble,
        "time": picture.time,
        "rate": round(picture.rate, 1),
        "age": picture.age,
        "control": control
        and {
            "hand": control.hand.value,
            "peer": control.peer,
            "name": control.name,
            "stage": control.stage.value,
            "age": _plain(control.age),
            "reason": control.reason,
        },
        "topics": {
            name: {field: _plain(value) for field, value in sample.values.items()}
            for name, sample in picture.samples.items()
        },
    }
    return json.dumps(said, allow_nan=False, separators=(",", ":"))


def _plain(value: Value) -> object:
    if isinstance(value, tuple):
        return [_plain(each) for each in value]
    if isinstance(value, float) and not math.isfinite(value):
        return None
    return value
