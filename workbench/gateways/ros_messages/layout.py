"""Where each number of a message stands in its bytes, for given lengths of texts and sequences.

CDR aligns each number to its own size, counted from behind the four bytes that say how the rest is
written. For messages of equal lengths all places are equal, so they are worked out once.
"""

import struct
from collections.abc import Iterator, Mapping
from dataclasses import dataclass

from workbench.gateways.ros_messages.definitions import (
    NUMBERS,
    TEXT,
    Arity,
    Definition,
    MessageField,
)

ENCAPSULATION = b"\x00\x01\x00\x00"
"""What begins a message: CDR of version 1, little-endian."""
BYTES = ("uint8", "byte")
"""Types of which many are `bytes`, not a tuple of numbers."""
Shape = tuple[int, ...]
"""Lengths of the texts (bytes) and sequences (values) of a message, in their order."""


@dataclass(frozen=True)
class Column:
    """Some numbers of one field, or a text.

    Attributes:
        path: names down to the field with dots between, places in arrays too.
        offset: in the bytes, encapsulation included.
        code: what `struct` calls one value; s for a text, V for plain bytes.
        count: values, or bytes.
        unit: of the field, or else of what it is in.
        array: whether it is one, even of a single value.
    """

    path: str
    offset: int
    code: str
    count: int
    unit: str
    array: bool = False


@dataclass(frozen=True)
class Layout:
    """A message's places.

    Attributes:
        packer: packs the encapsulation and all values, lengths among them.
        columns: fields with values.
        lengths: places of the lengths (uint32), and what stands there.
    """

    packer: struct.Struct
    columns: tuple[Column, ...]
    lengths: tuple[tuple[int, int], ...]


def make_layout(definitions: Mapping[str, Definition], name: str, shape: Shape) -> Layout:
    """Return the layout of a type for a shape."""
    builder = _Builder(definitions, iter(shape))
    builder.message(definitions[name], "", "")
    return Layout(
        struct.Struct("<" + "".join(builder.codes)),
        tuple(builder.columns),
        tuple(builder.lengths),
    )


class _Builder:
    """Goes through a definition, and notes what stands where."""

    def __init__(self, definitions: Mapping[str, Definition], shape: Iterator[int]) -> None:
        self._definitions = definitions
        self._shape = shape
        self._at = len(ENCAPSULATION)
        self.codes = [f"{self._at}s"]
        self.columns: list[Column] = []
        self.lengths: list[tuple[int, int]] = []

    def message(self, definition: Definition, path: str, unit: str) -> None:
        for field in definition.fields:
            self._field(field, path + field.name, field.unit or unit)

    def _field(self, field: MessageField, path: str, unit: str) -> None:
        if field.arity is Arity.ONE:
            self._values(field, path, unit, 1)
        elif field.arity is Arity.FIXED:
            self._values(field, path, unit, field.count)
        else:
            self._values(field, path, unit, self._length(0))

    def _values(self, field: MessageField, path: str, unit: str, count: int) -> None:
        if field.type in BYTES and field.arity is not Arity.ONE:
            self.columns.append(Column(path, self._place("s", count), "V", count, unit))
            return
        if field.type in NUMBERS:
            if count:
                code = NUMBERS[field.type]
                array = field.arity is not Arity.ONE
                at = self._place(code, count)
                self.columns.append(Column(path, at, code, count, unit, array))
            return
        for index in range(count):
            each = path if field.arity is Arity.ONE else f"{path}.{index}"
            if field.type == TEXT:
                length = self._length(1)
                self.columns.append(Column(each, self._place("s", length), "s", length, unit))
                self._place("x", 1)
            else:
                self.message(self._definitions[field.type], f"{each}.", unit)

    def _length(self, more: int) -> int:
        """Place the next length of the shape, with a text's closing zero as `more`."""
        length = next(self._shape)
        self.lengths.append((self._place("I", 1), length + more))
        return length

    def _place(self, code: str, count: int) -> int:
        """Place values, aligned, and return where they begin."""
        size = struct.calcsize(f"<{code}")
        gap = -(self._at - len(ENCAPSULATION)) % size
        if gap:
            self.codes.append(f"{gap}x")
        begin = self._at + gap
        self.codes.append(code if count == 1 and code != "s" else f"{count}{code}")
        self._at = begin + count * size
        return begin
