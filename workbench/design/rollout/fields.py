"""Read and write the fields of numpy records in compiled code, by name.

numba reads `record.field[k, i]` as an array of its own. LLVM then cannot tell that two fields do
not overlap, and makes no vector instructions of a loop over `i`. The functions here address a field
as a constant offset from the record, which LLVM can tell apart. A field of several numbers is a
tuple.
"""

from collections.abc import Callable, Sequence
from typing import Any

import numpy as np
from llvmlite import ir
from numba.core import cgutils, types
from numba.core.base import BaseContext
from numba.core.extending import intrinsic as numba_intrinsic
from numba.core.typing.context import BaseContext as TypingContext
from numba.core.typing.templates import Signature

intrinsic: Any = numba_intrinsic  # callers give less than what it decorates takes
Values = Sequence[ir.Value]
Intrinsic = tuple[Signature, Callable[[BaseContext, ir.IRBuilder, Signature, Values], ir.Value]]
"""What an intrinsic gives numba: its signature, and what writes its code."""
NUMBER_BYTES = 8
"""Of each number in a record: all are float64 [bytes]."""


def packed_dtype(
    fields: dict[str, Any], whole: dict[str, tuple[str, ...]] | None = None
) -> np.dtype:
    """Return the type of a record of float64 numbers.

    Args:
        fields: shape of each field, () for a number; or the type of a record within it.
        whole: name of a field that covers several ones which follow each other: their numbers.
    """
    names, formats, offsets, end = [], [], [], 0
    for name, kind in fields.items():
        form = kind if isinstance(kind, np.dtype) else np.dtype((np.float64, kind))
        names, formats, offsets = [*names, name], [*formats, form], [*offsets, end]
        end += form.itemsize
    size = end
    for name, parts in (whole or {}).items():
        begin, last = names.index(parts[0]), names.index(parts[-1])
        count = (offsets[last] + formats[last].itemsize - offsets[begin]) // NUMBER_BYTES
        names, offsets = [*names, name], [*offsets, offsets[begin]]
        formats = [*formats, np.dtype((np.float64, (count,)))]
    return np.dtype({"names": names, "formats": formats, "offsets": offsets, "itemsize": size})


@intrinsic(prefer_literal=True)
def get_lane(
    typingctx: TypingContext, record: types.Record, field: types.StringLiteral, lane: types.Type
) -> Intrinsic:
    """Return column `lane` of a field: a tuple if it has the shape (rows, lanes), else a number.

    The lane is not checked.
    """
    shape, place = _field_layout(record, field)
    rows = 1 if len(shape) == 1 else shape[0]
    result = types.float64 if len(shape) == 1 else types.UniTuple(types.float64, rows)

    def codegen(
        context: BaseContext, builder: ir.IRBuilder, signature: Signature, args: Values
    ) -> ir.Value:
        base = _record_numbers(builder, args[0])
        lane_value = context.cast(builder, args[2], signature.args[2], types.intp)
        found = [
            builder.load(
                _element_pointer(
                    builder, _element_pointer(builder, base, place + row * shape[-1]), lane_value
                )
            )
            for row in range(rows)
        ]
        return found[0] if len(shape) == 1 else context.make_tuple(builder, result, found)

    return result(record, field, lane), codegen


@intrinsic(prefer_literal=True)
def set_lane(
    typingctx: TypingContext,
    record: types.Record,
    field: types.StringLiteral,
    lane: types.Type,
    value: types.Type,
) -> Intrinsic:
    """Write column `lane` of a field, see `get_lane`."""
    shape, place = _field_layout(record, field)
    rows = 1 if len(shape) == 1 else shape[0]
    if (len(value) if isinstance(value, types.BaseTuple) else 1) != rows:
        raise TypeError(f"{field.literal_value} has {rows} rows, not those of {value}")

    def codegen(
        context: BaseContext, builder: ir.IRBuilder, signature: Signature, args: Values
    ) -> ir.Value:
        base = _record_numbers(builder, args[0])
        lane_value = context.cast(builder, args[2], signature.args[2], types.intp)
        for row, number in enumerate(_tuple_numbers(context, builder, signature.args[3], args[3])):
            target = _element_pointer(
                builder, _element_pointer(builder, base, place + row * shape[-1]), lane_value
            )
            builder.store(number, target)
        return context.get_dummy_value()

    return types.none(record, field, lane, value), codegen


@intrinsic(prefer_literal=True)
def get_field(
    typingctx: TypingContext, record: types.Record, field: types.StringLiteral
) -> Intrinsic:
    """Return a field of the shape (n,) as a tuple."""
    shape, place = _field_layout(record, field)
    if len(shape) != 1:
        raise TypeError(f"{field.literal_value} has the shape {shape}, not one of one axis")
    result = types.UniTuple(types.float64, shape[0])

    def codegen(
        context: BaseContext, builder: ir.IRBuilder, signature: Signature, args: Values
    ) -> ir.Value:
        base = _record_numbers(builder, args[0])
        found = [builder.load(_element_pointer(builder, base, place + k)) for k in range(shape[0])]
        return context.make_tuple(builder, result, found)

    return result(record, field), codegen


@intrinsic(prefer_literal=True)
def set_field(
    typingctx: TypingContext,
    record: types.Record,
    field: types.StringLiteral,
    values: types.BaseTuple,
) -> Intrinsic:
    """Write a tuple to a field of the shape (n,)."""
    shape, place = _field_layout(record, field)
    if len(values) != shape[0]:
        raise TypeError(f"{field.literal_value} has {shape[0]} numbers, not {len(values)}")

    def codegen(
        context: BaseContext, builder: ir.IRBuilder, signature: Signature, args: Values
    ) -> ir.Value:
        base = _record_numbers(builder, args[0])
        for k, number in enumerate(_tuple_numbers(context, builder, signature.args[2], args[2])):
            builder.store(number, _element_pointer(builder, base, place + k))
        return context.get_dummy_value()

    return types.none(record, field, values), codegen


def _field_layout(record: types.Record, field: types.Type) -> tuple[tuple[int, ...], int]:
    """Return the shape of a field, and its place in a record of float64 numbers."""
    if not isinstance(field, types.StringLiteral):
        raise TypeError("write the name of a field as it is")
    kind: Any = record.typeof(field.literal_value)
    return kind.shape, record.offset(field.literal_value) // NUMBER_BYTES


def _record_numbers(builder: ir.IRBuilder, record: ir.Value) -> ir.Value:
    return builder.bitcast(record, ir.DoubleType().as_pointer())


def _element_pointer(builder: ir.IRBuilder, base: ir.Value, place: int | ir.Value) -> ir.Value:
    if isinstance(place, int):
        place = ir.Constant(ir.IntType(64), place)
    return builder.gep(base, [place], inbounds=True)


def _tuple_numbers(
    context: BaseContext, builder: ir.IRBuilder, kind: types.Type, value: ir.Value
) -> list[ir.Value]:
    """Return the numbers of a tuple, or of a number, as float64."""
    if isinstance(kind, (types.Number, types.Boolean)):
        return [context.cast(builder, value, kind, types.float64)]
    several: Any = kind
    parts = zip(several, cgutils.unpack_tuple(builder, value), strict=True)
    return [context.cast(builder, part, each, types.float64) for each, part in parts]
