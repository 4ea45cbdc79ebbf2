"""Topics: what a frame of data carries, field by field, so that a stranger can decode it."""

import hashlib
import json
import struct
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from enum import Enum
from functools import cached_property
from typing import Any

from workbench.link.wire import LARGEST

PREFIX = "/dh_drone/"
CODES = {"float32": "f", "float64": "d", "int32": "i", "uint32": "I", "int64": "q"}
"""Types of numbers, and what `struct` calls them; `char` is text in UTF-8, filled with zeros."""

LARGEST_NUMBER = 2**16 - 1
"""Of a topic, in the header."""

Value = float | int | str | tuple[float, ...]


class Direction(Enum):
    """Who sends a topic."""

    OUT = "out"
    """The server."""
    IN = "in"
    """A client, as a command."""
    BOTH = "both"


class Delivery(Enum):
    """What happens to a topic's frames where a client is slow."""

    STATE = "state"
    """The newest wins."""
    EVENT = "event"
    """Each one counts; a client that falls too far behind is disconnected."""


@dataclass(frozen=True)
class Field:
    """Some numbers of one kind, or a text.

    Attributes:
        name: in snake case.
        type: one of `CODES`, or char.
        unit: "1" where there is none, "" for a text.
        frame: in which it is expressed: W, B, S or "".
        count: numbers, or bytes of a text.
        low: least value that is sent; None where it has no bound.
        high: largest one.
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
        """What `struct` calls it."""
        if self.type == "char":
            return f"{self.count}s"
        return CODES[self.type] if self.count == 1 else f"{self.count}{CODES[self.type]}"

    @property
    def size(self) -> int:
        """Its bytes."""
        return struct.calcsize("<" + self.code)


@dataclass(frozen=True)
class Topic:
    """What a frame of data carries.

    Attributes:
        id: number in the header, 1 or more.
        name: as in `/dh_drone/velocity_data`.
        direction: who sends it.
        rate: frames in a simulated second, 0 for one that comes when something happens [1/s].
        fields: in their order, without gaps between.
        delivery: what counts where a client is slow.
        about: further facts, for instance the directions of a lidar's rays.
    """

    id: int
    name: str
    direction: Direction
    rate: float
    fields: tuple[Field, ...]
    delivery: Delivery = Delivery.STATE
    about: Mapping[str, object] = field(default_factory=dict)

    def __getstate__(self) -> dict[str, object]:
        """Leave out what cannot be sent to another process and is made again there."""
        return {key: value for key, value in self.__dict__.items() if key != "packer"}

    @cached_property
    def packer(self) -> struct.Struct:
        """Packs and unpacks the fields."""
        return struct.Struct("<" + "".join(each.code for each in self.fields))

    def pack(self, values: Sequence[Value]) -> bytes:
        """Return the payload of a value for each field; of several numbers, a sequence."""
        flat: list[object] = []
        for each, value in zip(self.fields, values, strict=True):
            if each.type == "char":
                flat.append(cut(str(value), each.count))
            elif each.count == 1:
                flat.append(value)
            else:
                flat.extend(value)  # type: ignore[arg-type]
        return self.packer.pack(*flat)

    def unpack(self, payload: bytes) -> dict[str, Value]:
        """Return the fields by name.

        Raises:
            ValueError: if the payload has not just the topic's size.
        """
        if len(payload) != self.packer.size:
            raise ValueError(
                f"{self.name} has {self.packer.size} bytes: {len(payload)} are no frame of it"
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
        """Return what HELLO says of the topic, with a hash of it."""
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
    """Return the topic that a definition, as HELLO has it, describes.

    Raises:
        ValueError: if it is no definition, or one that this version cannot unpack.
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
        raise ValueError(f"this is no topic's definition: {error!r}") from error
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
    """Return 16 hexadecimal digits of SHA-256 of a definition without its hash."""
    plain = {key: value for key, value in definition.items() if key != "hash"}
    text = json.dumps(plain, sort_keys=True, separators=(",", ":"), ensure_ascii=False)
    return hashlib.sha256(text.encode()).hexdigest()[:16]


def cut(text: str, size: int) -> bytes:
    """Return text in UTF-8, cut to a size without splitting a character."""
    return text.encode()[:size].decode("utf-8", "ignore").encode()
