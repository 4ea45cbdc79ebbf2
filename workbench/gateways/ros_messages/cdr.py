"""Messages as bytes and back, as ROS 2 has them on the wire: CDR of version 1, little-endian."""

import struct
from collections.abc import Mapping, Sequence
from functools import cache
from typing import Any

from workbench.gateways.ros_messages.collecting import make_collector
from workbench.gateways.ros_messages.definitions import NUMBERS, Arity, Definition, MessageField
from workbench.gateways.ros_messages.layout import ENCAPSULATION, Layout, Shape, make_layout
from workbench.gateways.ros_messages.library import included

MOST_LAYOUTS = 256
"""Kept of a type; texts of many lengths would otherwise gather without end."""
_LENGTH = struct.Struct("<I")


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
