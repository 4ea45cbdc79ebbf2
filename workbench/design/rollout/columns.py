"""Arrays of many flights that are written in place, and what is said where they cannot be."""

from collections.abc import Iterator, Mapping
from typing import Any

import numpy as np

from workbench.common.errors import WorkbenchError, unknown_name


def shown(values: Any) -> str:
    """Return how values from outside begin, on a line."""
    return " ".join(f"{values!r}".split())[:60]


def write(name: str, array: np.ndarray, values: Any) -> None:
    """Write values into an array, a number for all or an array of its shape.

    Args:
        name: of the array, for the message.
        array: that is written.
        values: from outside, so they may be anything.

    Raises:
        WorkbenchError: if they do not fit.
    """
    try:
        array[...] = values
    except (TypeError, ValueError):
        raise WorkbenchError(
            f"{name} of a batch is {shown(values)}: give a number, or an array {array.shape} of "
            "them"
        ) from None


class Columns(Mapping[str, np.ndarray]):
    """Arrays (n) by name; to set one, as `columns[name] = 3.0`, writes into the array."""

    def __init__(self, columns: Mapping[str, np.ndarray]) -> None:
        self._columns = dict(columns)

    def __getitem__(self, name: str) -> np.ndarray:
        if name not in self._columns:
            raise unknown_name("parameter of a batch", name, self._columns)
        return self._columns[name]

    def __setitem__(self, name: str, values: Any) -> None:
        write(name, self[name], values)

    def __contains__(self, name: object) -> bool:
        return name in self._columns

    def __iter__(self) -> Iterator[str]:
        return iter(self._columns)

    def __len__(self) -> int:
        return len(self._columns)
