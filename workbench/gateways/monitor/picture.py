"""The state of a served flight at one time, for the terminal."""

import json
import math
import time
from collections.abc import Callable, Mapping
from dataclasses import dataclass

from workbench.common.plain_text import LONGEST_TEXT, plain_name
from workbench.link import Client
from workbench.link.messages import ControlState, Hand
from workbench.link.sample import Sample
from workbench.link.topics import PREFIX, Direction, Value

WINDOW = 1.0
"""Time over which samples are counted [s]."""
SMALL = 64
"""Largest number of values in a field of the topics shown."""


@dataclass(frozen=True)
class Picture:
    """The state of a served flight at one time.

    Attributes:
        vehicle: its name.
        address: of the server.
        trouble: why there is no connection, "" while there is one.
        control: who flies, None if unknown.
        mine: whether this client flies.
        rate: of received samples [1/s].
        age: of the newest state, by the clocks of both computers [s]; None if unknown.
        strongest: thrust of a full bar [N].
        samples: the newest ones by short name of the topic.
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
        client: of the server, open.
        address: of the server, to show.
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
        """Return the present picture."""
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
            # At first, the bars of a hovering drone have two thirds of the full length.
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
        elif self._rate == 0.0 and now > since:  # the rate in the first second
            return (received - before) / (now - since)
        return self._rate

    def _age(self, sample: Sample | None) -> float | None:
        if sample is None:
            return None
        return max(0.0, (self._wall() - int(number(sample, "wall_ns"))) / 1e9)


def number(sample: Sample, field: str) -> float:
    """Return a field that is a number, NaN if there is no such field."""
    value = sample.values.get(field)
    return value if isinstance(value, int | float) else math.nan


def numbers(sample: Sample, field: str) -> tuple[float, ...]:
    """Return a field of several numbers, or of one number as a tuple."""
    value = sample.values.get(field, ())
    return value if isinstance(value, tuple) else (number(sample, field),)


def text(sample: Sample, field: str) -> str:
    """Return a field that is a text, as one line without control characters."""
    return plain_name(str(sample.values.get(field, "")), LONGEST_TEXT)


def as_json(picture: Picture) -> str:
    """Return the picture as JSON in SI units; numbers that are not finite are null."""
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
