"""Topics: the fields of data frames, in a form that lets any program decode them."""

import hashlib
import json
import struct
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from enum import Enum
from functools import cached_property
from typing import Any, cast

from workbench.link.wire import LARGEST

PREFIX = "/dh_drone/"
CODES = {"float32": "f", "float64": "d", "int32": "i", "uint32": "I", "int64": "q"}
"""Types of numbers, and their codes in `struct`; `char` is text in UTF-8, padded with zeros."""

LARGEST_NUMBER = 2**16 - 1
"""Largest number of a topic, limited by the header."""

Value = float | int | str | tuple[float, ...]


class Direction(Enum):
    """The sender of a topic."""

    OUT = "out"
    """The server."""
    IN = "in"
    """A client, as a command."""
    BOTH = "both"


class Delivery(Enum):
    """The handling of the frames of a topic for a slow client."""

    STATE = "state"
    """The newest frame replaces older ones."""
    EVENT = "event"
    """Each frame counts; a client that falls too far behind is disconnected."""


@dataclass(frozen=True)
class Field:
    """A field: numbers of one type, or a text.

    Attributes:
        name: in snake case.
        type: one of `CODES`, or char.
        unit: "1" for none, "" for a text.
        frame: it is expressed in: W, B, S or "".
        count: number of values, or of bytes of a text.
        low: smallest value, None for no bound.
        high: largest value, None for no bound.
    """

    name: str
    type: str
    unit: str
    frame: str = ""
    count: int = 1
    low: float | None = None
    high: float | None = None

    @property
    def code(self) -> str:
        """Its code in `struct`."""
        if self.type == "char":
            return f"{self.count}s"
        return CODES[self.type] if self.count == 1 else f"{self.count}{CODES[self.type]}"

    @property
    def size(self) -> int:
        """Its size in bytes."""
        return struct.calcsize("<" + self.code)


@dataclass(frozen=True)
class Topic:
    """The content of data frames.

    Attributes:
        id: number in the header, 1 or more.
        name: such as `/dh_drone/velocity_data`.
        direction: who sends it.
        rate: frames per simulated second [1/s], 0 for events.
        fields: in order, without gaps.
        delivery: handling of frames for a slow client.
        about: further data, such as the directions of the rays of a lidar.
    """

    id: int
    name: str
    direction: Direction
    rate: float
    fields: tuple[Field, ...]
    delivery: Delivery = Delivery.STATE
    about: Mapping[str, object] = field(default_factory=dict)

    def __getstate__(self) -> dict[str, object]:
        """Leave out the parts that cannot be pickled and are made again on demand."""
        return {key: value for key, value in self.__dict__.items() if key != "packer"}

    @cached_property
    def packer(self) -> struct.Struct:
        """Packs and unpacks the fields."""
        return struct.Struct("<" + "".join(each.code for each in self.fields))

    def pack(self, values: Sequence[Value]) -> bytes:
        """Return the payload for a value of each field, a sequence for several numbers."""
        flat: list[object] = []
        for each, value in zip(self.fields, values, strict=True):
            if each.type == "char":
                flat.append(cut(str(value), each.count))
            elif each.count == 1:
                flat.append(value)
            else:
                flat += cast(tuple[float, ...], value)
        return self.packer.pack(*flat)

    def unpack(self, payload: bytes) -> dict[str, Value]:
        """Return the fields by name.

        Raises:
            ValueError: if the payload does not have the size of the topic.
        """
        if len(payload) != self.packer.size:
            raise ValueError(
                f"{self.name} has {self.packer.size} bytes: a frame with {len(payload)} does not "
                "fit"
            )
        flat = iter(self.packer.unpack(payload))
        values: dict[str, Value] = {}
        for each in self.fields:
            if each.type == "char":
                values[each.name] = next(flat).rstrip(b"\0").decode("utf-8", "replace")
            elif each.count == 1:
                values[each.name] = next(flat)
            else:
                values[each.name] = tuple(next(flat) for _ in range(each.count))
        return values

    def definition(self) -> dict[str, object]:
        """Return the definition of the topic for HELLO, with its hash."""
        said: dict[str, object] = {
            "id": self.id,
            "name": self.name,
            "direction": self.direction.value,
            "rate": self.rate,
            "delivery": self.delivery.value,
            "struct": self.packer.format,
            "fields": [
                {
                    "name": each.name,
                    "type": each.type,
                    "count": each.count,
                    "unit": each.unit,
                    "frame": each.frame,
                    "range": [each.low, each.high],
                }
                for each in self.fields
            ],
            "about": dict(self.about),
        }
        return said | {"hash": definition_hash(said)}


def topic_from(definition: Mapping[str, object]) -> Topic:
    """Return the topic for a definition from HELLO.

    Raises:
        ValueError: if the definition is invalid, or this version cannot unpack it.
    """
    found: Mapping[str, Any] = definition
    try:
        topic = Topic(
            id=found["id"],
            name=str(found["name"]),
            direction=Direction(found["direction"]),
            rate=float(found["rate"]),
            fields=tuple(_field(each) for each in found["fields"]),
            delivery=Delivery(found["delivery"]),
            about=dict(found["about"]),
        )
    except (AttributeError, KeyError, TypeError, OverflowError, IndexError) as error:
        raise ValueError(f"this is not the definition of a topic: {error!r}") from error
    if type(topic.id) is not int or not 1 <= topic.id <= LARGEST_NUMBER:
        raise ValueError(f"{topic.name[:60]}: its number must be within 1 .. {LARGEST_NUMBER}")
    if sum(each.size for each in topic.fields) > LARGEST:
        raise ValueError(f"{topic.name[:60]}: its fields are longer than a frame may be")
    names = [topic.name, *(each.name for each in topic.fields)]
    if len(set(names)) < len(names) or not all(name.isprintable() for name in names):
        raise ValueError(f"{topic.name[:60]!a}: a name comes twice, or cannot be printed")
    if topic.packer.format != found.get("struct"):
        raise ValueError(f"{topic.name[:60]}: its fields are not those of its struct string")
    return topic


def _field(said: Mapping[str, Any]) -> Field:
    made = Field(
        name=str(said["name"]),
        type=str(said["type"]),
        unit=str(said["unit"]),
        frame=str(said["frame"]),
        count=said["count"],
        low=said["range"][0],
        high=said["range"][1],
    )
    if type(made.count) is not int or not 1 <= made.count <= LARGEST:
        raise ValueError(f"{made.name[:60]}: its count must be within 1 .. {LARGEST}")
    if not all(_is_bound(each) for each in (made.low, made.high)):
        raise ValueError(f"{made.name[:60]}: its range must be two numbers or null")
    if made.type != "char" and made.type not in CODES:
        raise ValueError(f"{made.name[:60]}: its type {made.type[:60]!r} is unknown")
    return made


def _is_bound(value: object) -> bool:
    return value is None or (isinstance(value, int | float) and not isinstance(value, bool))


def definition_hash(definition: Mapping[str, object]) -> str:
    """Return 16 hexadecimal digits of the SHA-256 of a definition without its hash."""
    plain = {key: value for key, value in definition.items() if key != "hash"}
    text = json.dumps(plain, sort_keys=True, separators=(",", ":"), ensure_ascii=False)
    return hashlib.sha256(text.encode()).hexdigest()[:16]


def cut(text: str, size: int) -> bytes:
    """Return text in UTF-8, truncated to a size without splitting a character."""
    return text.encode()[:size].decode("utf-8", "ignore").encode()
