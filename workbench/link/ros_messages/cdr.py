"""Messages as bytes, and where each value is in them: CDR of version 1, little-endian, as in ROS 2.

CDR aligns each number to its own size, counted from the end of the encapsulation (4 bytes). In
messages of one type with equal lengths of texts and sequences, all offsets are equal.
"""

import math
import struct
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass
from functools import cache
from itertools import groupby
from operator import itemgetter
from typing import Any

from workbench.link.ros_messages.definitions import (
    STRUCT_CODE_BY_ROS_TYPE,
    TEXT_TYPE,
    Arity,
    Definition,
    MessageField,
)
from workbench.link.ros_messages.library import included

CDR_ENCAPSULATION = b"\x00\x01\x00\x00"
"""The first bytes of a message: CDR of version 1, little-endian."""
BYTE_TYPES = ("uint8", "byte")
"""Types whose arrays are `bytes` instead of tuples of numbers."""
MAX_CACHED_LAYOUTS = 256
"""Largest number of cached layouts of a type; texts of many lengths would add ever more."""
_LENGTH_STRUCT = struct.Struct("<I")
ValueCollector = Callable[[Any, list[Any], list[int]], None]
"""Appends the values of a message to a list, and its lengths of texts and sequences to another."""


@dataclass(frozen=True)
class LayoutColumn:
    """Numbers of one field, or a text.

    Attributes:
        path: names of the nested fields and indices in arrays, joined by dots.
        offset: in the message, including the encapsulation.
        code: of one value in `struct`; s for a text, V for plain bytes.
        count: number of values, or of bytes.
        unit: of the field, or else of the message that contains it.
        array: whether the field is an array, even of one value.
    """

    path: str
    offset: int
    code: str
    count: int
    unit: str
    array: bool = False


@dataclass(frozen=True)
class MessageLayout:
    """The layout of a message.

    Attributes:
        packer: packs the encapsulation and all values, including lengths.
        columns: fields with values.
        lengths: offset and value of each length (uint32).
    """

    packer: struct.Struct
    columns: tuple[LayoutColumn, ...]
    lengths: tuple[tuple[int, int], ...]


class _LayoutBuilder:
    """Walks through a definition, and notes the offsets of its values.

    Args:
        definitions: by name.
        length_at: returns the length stated at an offset of the message.
        size: of the message, if it exists already [bytes].

    Raises:
        ValueError: by `message`, if the message would be longer than `size`.
    """

    def __init__(
        self,
        definitions: Mapping[str, Definition],
        length_at: Callable[[int], int],
        size: float = math.inf,
    ) -> None:
        self._definitions = definitions
        self._length_at = length_at
        self._size = size
        self._at = len(CDR_ENCAPSULATION)
        self._codes = [f"{self._at}s"]
        self._columns: list[LayoutColumn] = []
        self._lengths: list[tuple[int, int]] = []

    def layout(self, name: str) -> MessageLayout:
        """Return the layout of a message of a type."""
        self._message(self._definitions[name], "", "")
        packer = struct.Struct("<" + "".join(self._codes))
        return MessageLayout(packer, tuple(self._columns), tuple(self._lengths))

    def _message(self, definition: Definition, path: str, unit: str) -> None:
        for field in definition.fields:
            count = self._length() if field.arity is Arity.SEQUENCE else field.count
            self._values(field, path + field.name, field.unit or unit, count)

    def _values(self, field: MessageField, path: str, unit: str, count: int) -> None:
        array = field.arity is not Arity.ONE
        if field.type in BYTE_TYPES and array:
            self._columns.append(LayoutColumn(path, self._place("s", count), "V", count, unit))
        elif field.type in STRUCT_CODE_BY_ROS_TYPE:
            if count:
                code = STRUCT_CODE_BY_ROS_TYPE[field.type]
                offset = self._place(code, count)
                self._columns.append(LayoutColumn(path, offset, code, count, unit, array))
        else:
            for index in range(count):
                self._one(field, f"{path}.{index}" if array else path, unit)

    def _one(self, field: MessageField, path: str, unit: str) -> None:
        """Place one text or nested message."""
        if field.nested:
            self._message(self._definitions[field.type], f"{path}.", unit)
            return
        length = self._length() - 1  # without the terminating zero
        if length < 0:
            raise ValueError(f"the text {path} has no terminating zero")
        self._columns.append(LayoutColumn(path, self._place("s", length), "s", length, unit))
        self._place("x", 1)

    def _length(self) -> int:
        """Place the next length, and return it."""
        offset = self._place("I", 1)
        length = self._length_at(offset)
        self._lengths.append((offset, length))
        return length

    def _place(self, code: str, count: int) -> int:
        """Place values, aligned, and return their offset."""
        size = struct.calcsize(f"<{code}")
        gap = -(self._at - len(CDR_ENCAPSULATION)) % size
        if gap:
            self._codes.append(f"{gap}x")
        offset = self._at + gap
        self._codes.append(code if count == 1 and code != "s" else f"{count}{code}")
        self._at = offset + count * size
        if self._at > self._size:
            raise ValueError("a message is cut short")
        return offset


class Codec:
    """Encodes messages of one type, and returns the layout of encoded ones.

    Args:
        definitions: of the type, first, and of all types included in it.
    """

    def __init__(self, definitions: Sequence[Definition]) -> None:
        self._definitions = {each.name: each for each in definitions}
        self._name = definitions[0].name
        self._packers: dict[tuple[int, ...], struct.Struct] = {}
        self._collect = _collector(self._definitions, self._name)

    def encode(self, values: Mapping[str, Any]) -> bytes:
        """Return the bytes of a message.

        Args:
            values: by name of the field; nested messages are mappings, arrays are sequences, or
                bytes for uint8.

        Raises:
            KeyError, TypeError, ValueError, struct.error: if they do not fit the definition.
        """
        flat: list[Any] = [CDR_ENCAPSULATION]
        lengths: list[int] = []
        self._collect(values, flat, lengths)
        shape = tuple(lengths)
        packer = self._packers.get(shape)
        if packer is None:
            if len(self._packers) >= MAX_CACHED_LAYOUTS:
                self._packers.clear()
            stated = iter(shape)
            builder = _LayoutBuilder(self._definitions, lambda _: next(stated))
            packer = self._packers[shape] = builder.layout(self._name).packer
        return packer.pack(*flat)

    def layout_of(self, data: bytes) -> MessageLayout:
        """Return the layout of a message.

        Raises:
            ValueError: if the bytes are not a message of this type.
        """
        if data[:2] != CDR_ENCAPSULATION[:2]:
            raise ValueError(f"a message begins with {data[:4]!r}: it is not little-endian CDR")

        def length_at(offset: int) -> int:
            length: int = _LENGTH_STRUCT.unpack_from(data, offset)[0]
            if length > len(data):
                raise ValueError(f"{length} values are stated: the message is shorter")
            return length

        try:
            return _LayoutBuilder(self._definitions, length_at, len(data)).layout(self._name)
        except ValueError as error:
            raise ValueError(f"{self._name}: {error}") from error


@cache
def codec(name: str) -> Codec:
    """Return the codec of a shipped type, such as std_msgs/msg/Header.

    Raises:
        WorkbenchError: if the type is unknown.
    """
    return Codec(included(name))


def encode(name: str, values: Mapping[str, Any]) -> bytes:
    """Return the bytes of a message of a shipped type; see `Codec.encode`."""
    return codec(name).encode(values)


def _collector(definitions: Mapping[str, Definition], name: str) -> ValueCollector:
    """Return a function that collects the values of a message of a type, in the order of `struct`.

    Thousands of messages are encoded per second, so a definition is converted to functions once. A
    single `itemgetter` reads consecutive fields of one number each.
    """
    steps: list[ValueCollector] = []
    for plain, group in groupby(definitions[name].fields, key=_is_single_number):
        fields = list(group)
        if plain:
            steps.append(_numbers_collector([field.name for field in fields]))
        else:
            steps += [_field_collector(definitions, field) for field in fields]

    def collect(values: Mapping[str, Any], flat: list[Any], lengths: list[int]) -> None:
        for step in steps:
            step(values, flat, lengths)

    return collect


def _is_single_number(field: MessageField) -> bool:
    return field.type in STRUCT_CODE_BY_ROS_TYPE and field.arity is Arity.ONE


def _numbers_collector(names: Sequence[str]) -> ValueCollector:
    """Return the collector of fields that are one number each."""
    if len(names) == 1:
        name = names[0]
        return lambda values, flat, lengths: flat.append(values[name])
    get = itemgetter(*names)
    return lambda values, flat, lengths: flat.extend(get(values))


def _field_collector(definitions: Mapping[str, Definition], field: MessageField) -> ValueCollector:
    """Return the collector of a field other than a single number."""
    name, count = field.name, field.count
    one = _value_collector(definitions, field)
    several = _array_collector(field, one)

    def sequence(values: Mapping[str, Any], flat: list[Any], lengths: list[int]) -> None:
        value = values[name]
        lengths.append(len(value))
        flat.append(len(value))
        several(value, flat, lengths)

    def fixed(values: Mapping[str, Any], flat: list[Any], lengths: list[int]) -> None:
        value = values[name]
        if len(value) != count:
            raise ValueError(f"{name} has {len(value)} values: {count} are needed")
        several(value, flat, lengths)

    def single(values: Mapping[str, Any], flat: list[Any], lengths: list[int]) -> None:
        one(values[name], flat, lengths)

    return {Arity.SEQUENCE: sequence, Arity.FIXED: fixed, Arity.ONE: single}[field.arity]


def _value_collector(definitions: Mapping[str, Definition], field: MessageField) -> ValueCollector:
    """Return the collector of one value of a field."""
    if field.nested:
        return _collector(definitions, field.type)
    return (
        _collect_text
        if field.type == TEXT_TYPE
        else lambda value, flat, lengths: flat.append(value)
    )


def _array_collector(field: MessageField, one: ValueCollector) -> ValueCollector:
    """Return the collector of the values of an array."""
    if field.type in BYTE_TYPES:
        return lambda value, flat, lengths: flat.append(bytes(value))
    if field.type in STRUCT_CODE_BY_ROS_TYPE:
        return lambda value, flat, lengths: flat.extend(value)

    def each(value: Iterable[Any], flat: list[Any], lengths: list[int]) -> None:
        for item in value:
            one(item, flat, lengths)

    return each


def _collect_text(value: str, flat: list[Any], lengths: list[int]) -> None:
    data = value.encode()
    lengths.append(len(data) + 1)  # with the terminating zero
    flat += (len(data) + 1, data)
