"""Read and write the fields of numpy records in compiled code, by name.

numba reads `record.field[k, i]` as an array of its own. LLVM then cannot tell that two fields do
not overlap, and makes no vector instructions of a loop over `i`. The functions here address a field
as a constant offset from the record, which LLVM can tell apart. A field of several numbers is a
tuple.
"""

from typing import Any

import numpy as np
from llvmlite import ir
from numba.core import cgutils, types
from numba.core.extending import intrinsic as numba_intrinsic

intrinsic: Any = numba_intrinsic  # callers give less than what it decorates takes
BYTES = 8
"""Of each number in a record: all are float64 [bytes]."""


def packed_dtype(fields: dict[str, Any], whole: dict[str, tuple[str, ...]] | None = None) -> Any:
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
        count = (offsets[last] + formats[last].itemsize - offsets[begin]) // BYTES
        names, offsets = [*names, name], [*offsets, offsets[begin]]
        formats = [*formats, np.dtype((np.float64, (count,)))]
    return np.dtype({"names": names, "formats": formats, "offsets": offsets, "itemsize": size})


@intrinsic(prefer_literal=True)
def take(typingctx: Any, record: Any, field: Any, lane: Any) -> Any:
    """Return column `lane` of a field: a tuple if it has the shape (rows, lanes), else a number.

    The lane is not checked.
    """
    shape, place = _field(record, field)
    rows = 1 if len(shape) == 1 else shape[0]
    result = types.float64 if len(shape) == 1 else types.UniTuple(types.float64, rows)

    def codegen(context: Any, builder: Any, signature: Any, args: Any) -> Any:
        base = _numbers(builder, args[0])
        lane_value = context.cast(builder, args[2], signature.args[2], types.intp)
        found = [
            builder.load(_at(builder, _at(builder, base, place + row * shape[-1]), lane_value))
            for row in range(rows)
        ]
        return found[0] if len(shape) == 1 else context.make_tuple(builder, result, found)

    return result(record, field, lane), codegen


@intrinsic(prefer_literal=True)
def put(typingctx: Any, record: Any, field: Any, lane: Any, value: Any) -> Any:
    """Write column `lane` of a field, see `take`."""
    shape, place = _field(record, field)
    rows = 1 if len(shape) == 1 else shape[0]
    if (len(value) if isinstance(value, types.BaseTuple) else 1) != rows:
        raise TypeError(f"{field.literal_value} has {rows} rows, not those of {value}")

    def codegen(context: Any, builder: Any, signature: Any, args: Any) -> Any:
        base = _numbers(builder, args[0])
        lane_value = context.cast(builder, args[2], signature.args[2], types.intp)
        for row, number in enumerate(_parts(context, builder, signature.args[3], args[3])):
            target = _at(builder, _at(builder, base, place + row * shape[-1]), lane_value)
            builder.store(number, target)
        return context.get_dummy_value()

    return types.none(record, field, lane, value), codegen


@intrinsic(prefer_literal=True)
def fetch(typingctx: Any, record: Any, field: Any) -> Any:
    """Return a field of the shape (n,) as a tuple."""
    shape, place = _field(record, field)
    if len(shape) != 1:
        raise TypeError(f"{field.literal_value} has the shape {shape}, not one of one axis")
    result = types.UniTuple(types.float64, shape[0])

    def codegen(context: Any, builder: Any, signature: Any, args: Any) -> Any:
        base = _numbers(builder, args[0])
        found = [builder.load(_at(builder, base, place + k)) for k in range(shape[0])]
        return context.make_tuple(builder, result, found)

    return result(record, field), codegen


@intrinsic(prefer_literal=True)
def store(typingctx: Any, record: Any, field: Any, values: Any) -> Any:
    """Write a tuple to a field of the shape (n,)."""
    shape, place = _field(record, field)
    if len(values) != shape[0]:
        raise TypeError(f"{field.literal_value} has {shape[0]} numbers, not {len(values)}")

    def codegen(context: Any, builder: Any, signature: Any, args: Any) -> Any:
        base = _numbers(builder, args[0])
        for k, number in enumerate(_parts(context, builder, signature.args[2], args[2])):
            builder.store(number, _at(builder, base, place + k))
        return context.get_dummy_value()

    return types.none(record, field, values), codegen


def _field(record: Any, field: Any) -> tuple[tuple[int, ...], int]:
    """Return the shape of a field, and its place in a record of float64 numbers."""
    if not isinstance(field, types.StringLiteral):
        raise TypeError("write the name of a field as it is")
    kind = record.typeof(field.literal_value)
    return kind.shape, record.offset(field.literal_value) // BYTES


def _numbers(builder: Any, record: Any) -> Any:
    return builder.bitcast(record, ir.DoubleType().as_pointer())


def _at(builder: Any, base: Any, place: Any) -> Any:
    if isinstance(place, int):
        place = ir.Constant(ir.IntType(64), place)
    return builder.gep(base, [place], inbounds=True)


def _parts(context: Any, builder: Any, kind: Any, value: Any) -> list[Any]:
    """Return the numbers of a tuple, or of a number, as float64."""
    if isinstance(kind, (types.Number, types.Boolean)):
        return [context.cast(builder, value, kind, types.float64)]
    parts = zip(kind, cgutils.unpack_tuple(builder, value), strict=True)
    return [context.cast(builder, part, each, types.float64) for each, part in parts]
