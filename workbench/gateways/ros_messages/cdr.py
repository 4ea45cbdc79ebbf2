"""Messages as bytes and back, as ROS 2 has them on the wire: CDR of version 1, little-endian."""

import struct
from collections.abc import Callable, Mapping, Sequence
from functools import cache
from itertools import groupby
from operator import itemgetter
from typing import Any

from workbench.gateways.ros_messages.definitions import (
    NUMBERS,
    TEXT,
    Arity,
    Definition,
    MessageField,
)
from workbench.gateways.ros_messages.layout import BYTES, ENCAPSULATION, Layout, Shape, make_layout
from workbench.gateways.ros_messages.library import included

Collect = Callable[[Any, list[Any], list[int]], None]
"""Adds the values of a message to a row, and the lengths of its texts and sequences to another."""
MOST_LAYOUTS = 256
"""Kept of a type; texts of many lengths would otherwise gather without end."""
_LENGTH = struct.Struct("<I")


def make_collector(definitions: Mapping[str, Definition], name: str) -> Collect:
    """Return what puts the values of a message of a type in a row, as `struct` wants them.

    A definition is turned into functions once, as thousands of messages a second are encoded:
    fields that follow each other and are one number each are read by a single `itemgetter`.
    """
    steps: list[Collect] = []
    for plain, group in groupby(definitions[name].fields, key=_is_number):
        fields = list(group)
        if plain:
            steps.append(_numbers([field.name for field in fields]))
        else:
            steps += [_field(definitions, field) for field in fields]

    def collect(values: Any, flat: list[Any], shape: list[int]) -> None:
        for step in steps:
            step(values, flat, shape)

    return collect


def _is_number(field: MessageField) -> bool:
    return field.type in NUMBERS and field.arity is Arity.ONE


def _numbers(names: Sequence[str]) -> Collect:
    if len(names) == 1:
        name = names[0]
        return lambda values, flat, shape: flat.append(values[name])
    get = itemgetter(*names)
    return lambda values, flat, shape: flat.extend(get(values))


def _field(definitions: Mapping[str, Definition], field: MessageField) -> Collect:
    """Return what collects a field that is not just one number."""
    name = field.name
    several = _several(definitions, field)
    if field.arity is Arity.SEQUENCE:

        def sequence(values: Any, flat: list[Any], shape: list[int]) -> None:
            value = values[name]
            shape.append(len(value))
            flat.append(len(value))
            several(value, flat, shape)

        return sequence
    if field.arity is Arity.FIXED:

        def fixed(values: Any, flat: list[Any], shape: list[int]) -> None:
            value = values[name]
            if len(value) != field.count:
                raise ValueError(f"{name} has {len(value)} values: {field.count} are needed")
            several(value, flat, shape)

        return fixed
    one = _one(definitions, field)
    return lambda values, flat, shape: one(values[name], flat, shape)


def _several(definitions: Mapping[str, Definition], field: MessageField) -> Collect:
    """Return what collects the values of an array."""
    if field.type in BYTES:
        return lambda value, flat, shape: flat.append(bytes(value))
    if field.type in NUMBERS:
        return lambda value, flat, shape: flat.extend(value)
    one = _one(definitions, field)

    def each(value: Any, flat: list[Any], shape: list[int]) -> None:
        for item in value:
            one(item, flat, shape)

    return each


def _one(definitions: Mapping[str, Definition], field: MessageField) -> Collect:
    """Return what collects one text or message."""
    return _text if field.type == TEXT else make_collector(definitions, field.type)


def _text(value: str, flat: list[Any], shape: list[int]) -> None:
    data = value.encode()
    shape.append(len(data))
    flat += (len(data) + 1, data)


class Codec:
    """Encodes messages of one type, and finds out how the bytes of one are laid out.

    Args:
        definitions: of the type and of all that it includes, the type's own first.
    """

    def __init__(self, definitions: Sequence[Definition]) -> None:
        self._definitions = {each.name: each for each in definitions}
        self._name = definitions[0].name
        self._layouts: dict[Shape, Layout] = {}
        self._collect = make_collector(self._definitions, self._name)

    def encode(self, values: Mapping[str, Any]) -> bytes:
        """Return the bytes of a message.

        Args:
            values: by name of the field; messages within are mappings themselves, several values a
                sequence, or bytes of uint8.

        Raises:
            KeyError, TypeError, ValueError, struct.error: if they do not fit the definition.
        """
        flat: list[Any] = [ENCAPSULATION]
        shape: list[int] = []
        self._collect(values, flat, shape)
        return self.layout(tuple(shape)).packer.pack(*flat)

    def layout(self, shape: Shape) -> Layout:
        """Return where everything stands for lengths of texts and sequences."""
        found = self._layouts.get(shape)
        if found is None:
            if len(self._layouts) >= MOST_LAYOUTS:
                self._layouts.clear()
            found = make_layout(self._definitions, self._name, shape)
            self._layouts[shape] = found
        return found

    def layout_of(self, data: bytes) -> Layout:
        """Return where everything stands in a message.

        Raises:
            ValueError: if the bytes are no message of this type.
        """
        if data[:2] != ENCAPSULATION[:2]:
            raise ValueError(f"a message begins with {data[:4]!r}: it is not little-endian CDR")
        shape: list[int] = []
        try:
            self._measure(self._definitions[self._name].fields, data, len(ENCAPSULATION), shape)
            layout = self.layout(tuple(shape))
        except struct.error as error:
            raise ValueError(f"a message of {self._name} is cut short") from error
        if layout.packer.size > len(data):
            raise ValueError(f"a message of {self._name} is cut short")
        return layout

    def _measure(
        self, fields: Sequence[MessageField], data: bytes, at: int, shape: list[int]
    ) -> int:
        """Add the lengths of fields that begin at a place to `shape`; return where they end."""
        for field in fields:
            count = field.count
            if field.arity is Arity.SEQUENCE:
                at = _aligned(at, 4)
                count = _LENGTH.unpack_from(data, at)[0]
                at += 4
                if count > len(data):
                    raise ValueError(f"{field.name} has {count} values: the message is shorter")
                shape.append(count)
            if field.type in NUMBERS:
                size = struct.calcsize(NUMBERS[field.type])
                at = _aligned(at, size) + size * count if count else at
                continue
            for _ in range(count):
                at = self._measure_one(field, data, at, shape)
        return at

    def _measure_one(self, field: MessageField, data: bytes, at: int, shape: list[int]) -> int:
        if field.nested:
            return self._measure(self._definitions[field.type].fields, data, at, shape)
        at = _aligned(at, 4)
        length = _LENGTH.unpack_from(data, at)[0]
        if not 1 <= length <= len(data) - at - 4:
            raise ValueError(f"the text {field.name} has {length} bytes: the message is shorter")
        shape.append(length - 1)
        return at + 4 + length


@cache
def codec(name: str) -> Codec:
    """Return what encodes and decodes messages of a type that is shipped, as std_msgs/msg/Header.

    Raises:
        WorkbenchError: if there is none.
    """
    return Codec(included(name))


def encode(name: str, values: Mapping[str, Any]) -> bytes:
    """Return the bytes of a message of a type that is shipped; see `Codec.encode`."""
    return codec(name).encode(values)


def _aligned(at: int, size: int) -> int:
    """Return the next place where a number of a size may stand."""
    return at + -(at - len(ENCAPSULATION)) % size
