"""Topics: the fields of data frames, in a form that lets any program decode them."""

import hashlib
import json
import re
import struct
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from enum import Enum
from functools import cached_property
from typing import Any, cast

from workbench.link.wire import MAX_PAYLOAD_BYTES

PREFIX = "/dh_drone/"
STRUCT_CODES = {"float32": "f", "float64": "d", "int32": "i", "uint32": "I", "int64": "q"}
"""Types of numbers, and their codes in `struct`; `char` is text in UTF-8, padded with zeros."""

MAX_TOPIC_NUMBER = 2**16 - 1
"""Largest number of a topic, limited by the header."""

FieldValue = float | int | str | tuple[float, ...]


PART_NAMES = ("joints", "links", "cables")
"""Entries of `Topic.about` that name the parts of a drone whose values the fields have."""


def value_names(parts: Sequence[str], count: int) -> list[str]:
    """Return names of the values of a field: those of parts, or of a vector of each, else numbers.

    They are names of fields of ROS, too: in small letters, and numbers where parts have no others.

    Args:
        parts: names of the parts that the values are of.
        count: number of values.
    """
    plain = [re.sub(r"\W+", "_", part.lower(), flags=re.ASCII) for part in parts]
    if len(set(plain)) < len(plain) or not all(part[:1].isalpha() for part in plain):
        plain = []
    if len(plain) == count:
        return plain
    if 3 * len(plain) == count:
        return [f"{part}.{axis}" for part in plain for axis in "xyz"]
    return [str(index) for index in range(count)]


class TopicDirection(Enum):
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
        type: one of `STRUCT_CODES`, or char.
        unit: "1" for none, "" for a text.
        frame: it is expressed in: W, B, S or "".
        count: number of values, or of bytes of a text.
        low: smallest value, None for no bound.
        high: largest value, None for no bound.
        components: names of the values, a letter each; "" for numbers. Not on the wire.
    """

    name: str
    type: str
    unit: str
    frame: str = ""
    count: int = 1
    low: float | None = None
    high: float | None = None
    components: str = field(default="", compare=False)

    @property
    def code(self) -> str:
        """Its code in `struct`."""
        if self.type == "char":
            return f"{self.count}s"
        return (
            STRUCT_CODES[self.type] if self.count == 1 else f"{self.count}{STRUCT_CODES[self.type]}"
        )

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
    direction: TopicDirection
    rate: float
    fields: tuple[Field, ...]
    delivery: Delivery = Delivery.STATE
    about: Mapping[str, object] = field(default_factory=dict)

    def __getstate__(self) -> dict[str, object]:
        """Leave out the parts that cannot be pickled and are made again on demand."""
        return {
            key: value for key, value in self.__dict__.items() if key not in ("packer", "_places")
        }

    @cached_property
    def packer(self) -> struct.Struct:
        """Packs and unpacks the fields."""
        return struct.Struct("<" + "".join(each.code for each in self.fields))

    def pack(self, values: Sequence[FieldValue]) -> bytes:
        """Return the payload for a value of each field, a sequence for several numbers."""
        flat: list[object] = []
        for each, value in zip(self.fields, values, strict=True):
            if each.type == "char":
                flat.append(truncated_utf8(str(value), each.count))
            elif each.count == 1:
                flat.append(value)
            else:
                flat += cast(tuple[float, ...], value)
        return self.packer.pack(*flat)

    def unpack(self, payload: bytes) -> dict[str, FieldValue]:
        """Return the fields by name.

        Raises:
            ValueError: if the payload does not have the size of the topic.
        """
        if len(payload) != self.packer.size:
            raise ValueError(
                f"{self.name} has {self.packer.size} bytes: a frame with {len(payload)} does not "
                "fit"
            )
        flat = self.packer.unpack(payload)
        values: dict[str, Any] = {name: flat[place] for name, place in self._places}
        for each in self.fields:
            if each.type == "char":
                values[each.name] = values[each.name].rstrip(b"\0").decode("utf-8", "replace")
        return values

    @cached_property
    def _places(self) -> tuple[tuple[str, int | slice], ...]:
        """Names of the fields, and their places in an unpacked payload."""
        at, places = 0, []
        for each in self.fields:
            count = 1 if each.type == "char" else each.count
            places.append((each.name, at if count == 1 else slice(at, at + count)))
            at += count
        return tuple(places)

    def value_names(self, each: Field) -> list[str]:
        """Return the name of each value of a field, as in FIELD.INDEX; "" of the only one."""
        known: list[Any] = [self.about[key] for key in PART_NAMES if key in self.about]
        parts = known[0] if known and isinstance(known[0], list) else []
        return value_names(parts, each.count) if parts or each.count > 1 else [""]

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
            direction=TopicDirection(found["direction"]),
            rate=float(found["rate"]),
            fields=tuple(_field_from(each) for each in found["fields"]),
            delivery=Delivery(found["delivery"]),
            about=dict(found["about"]),
        )
    except (AttributeError, KeyError, TypeError, OverflowError, IndexError) as error:
        raise ValueError(f"this is not the definition of a topic: {error!r}") from error
    if type(topic.id) is not int or not 1 <= topic.id <= MAX_TOPIC_NUMBER:
        raise ValueError(f"{topic.name[:60]}: its number must be within 1 .. {MAX_TOPIC_NUMBER}")
    if sum(each.size for each in topic.fields) > MAX_PAYLOAD_BYTES:
        raise ValueError(f"{topic.name[:60]}: its fields are longer than a frame may be")
    names = [topic.name, *(each.name for each in topic.fields)]
    if len(set(names)) < len(names) or not all(name.isprintable() for name in names):
        raise ValueError(f"{topic.name[:60]!a}: a name comes twice, or cannot be printed")
    if topic.packer.format != found.get("struct"):
        raise ValueError(f"{topic.name[:60]}: its fields are not those of its struct string")
    return topic


def _field_from(said: Mapping[str, Any]) -> Field:
    made = Field(
        name=str(said["name"]),
        type=str(said["type"]),
        unit=str(said["unit"]),
        frame=str(said["frame"]),
        count=said["count"],
        low=said["range"][0],
        high=said["range"][1],
    )
    if type(made.count) is not int or not 1 <= made.count <= MAX_PAYLOAD_BYTES:
        raise ValueError(f"{made.name[:60]}: its count must be within 1 .. {MAX_PAYLOAD_BYTES}")
    if not all(_is_bound(each) for each in (made.low, made.high)):
        raise ValueError(f"{made.name[:60]}: its range must be two numbers or null")
    if made.type != "char" and made.type not in STRUCT_CODES:
        raise ValueError(f"{made.name[:60]}: its type {made.type[:60]!r} is unknown")
    return made


def _is_bound(value: object) -> bool:
    return value is None or (isinstance(value, int | float) and not isinstance(value, bool))


def definition_hash(definition: Mapping[str, object]) -> str:
    """Return 16 hexadecimal digits of the SHA-256 of a definition without its hash."""
    plain = {key: value for key, value in definition.items() if key != "hash"}
    text = json.dumps(plain, sort_keys=True, separators=(",", ":"), ensure_ascii=False)
    return hashlib.sha256(text.encode()).hexdigest()[:16]


def truncated_utf8(text: str, size: int) -> bytes:
    """Return text in UTF-8, truncated to a size without splitting a character."""
    return text.encode()[:size].decode("utf-8", "ignore").encode()
