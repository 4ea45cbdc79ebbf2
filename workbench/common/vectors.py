"""Types of vectors, for functions that run in three ways.

Such a function does plain arithmetic. Its numbers are `float` in flight, Drake's AutoDiffXd in
linear models, and float64 in machine code; its annotations name the first.
"""

from collections.abc import Iterable, Iterator
from typing import Protocol, overload

Vector3 = tuple[float, float, float]
Quaternion = tuple[float, float, float, float]
"""w, x, y, z."""
Matrix3 = tuple[float, float, float, float, float, float, float, float, float]
"""Row by row."""
Symmetric3 = tuple[float, float, float, float, float, float]
"""A symmetric matrix: xx, xy, xz, yy, yz, zz."""
Wrench = tuple[float, float, float, float]
"""Force along z [N], and moment [N·m]."""


class Numbers(Protocol):
    """Numbers in a row: a tuple, a list or an array."""

    @overload
    def __getitem__(self, place: int, /) -> float: ...
    @overload
    def __getitem__(self, part: slice, /) -> "Numbers": ...
    def __len__(self) -> int: ...
    def __iter__(self) -> Iterator[float]: ...


class MutableNumbers(Numbers, Protocol):
    """Numbers in a row that may be changed: a list or an array."""

    def __setitem__(self, place: int, number: float, /) -> None: ...


def float_triple(vector: Iterable[float]) -> Vector3:
    """Return a vector as three floats, without negative zeros."""
    x, y, z = (float(value) + 0.0 for value in vector)
    return (x, y, z)
