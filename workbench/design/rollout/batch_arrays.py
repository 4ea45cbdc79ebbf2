"""Arrays of a batch of flights: their values, columns and setpoints."""

import dataclasses
import operator
from collections.abc import Iterator, Mapping, Sequence
from typing import Any, SupportsIndex

import numpy as np
from numpy.typing import ArrayLike

from workbench.common.errors import WorkbenchError, unknown_name

FlightSelection = np.ndarray | Sequence[bool] | Sequence[int] | slice | int | None
"""Flights, by a mask or by their numbers; None for all."""


def values_preview(values: object) -> str:
    """Return how values from outside begin, on a line."""
    return " ".join(f"{values!r}".split())[:60]


def write_values(name: str, array: np.ndarray, values: ArrayLike) -> None:
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
            f"{name} of a batch is {values_preview(values)}: give a number, or an array "
            f"{array.shape} of "
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

    def __setitem__(self, name: str, values: ArrayLike) -> None:
        write_values(name, self[name], values)

    def __contains__(self, name: object) -> bool:
        return name in self._columns

    def __iter__(self) -> Iterator[str]:
        return iter(self._columns)

    def __len__(self) -> int:
        return len(self._columns)


class BatchArrays:
    """Has arrays: to set one that is there writes into it, and no other one takes its place."""

    def __setattr__(self, name: str, value: Any) -> None:
        there = getattr(self, name, None)
        if name.startswith("_") or there is None:
            super().__setattr__(name, value)
        elif isinstance(there, np.ndarray) and there.flags.writeable:
            write_values(name, there, value)
        elif there is not value:
            raise WorkbenchError(
                f"{name} of a batch cannot be set: write its state, setpoint, parameters or starts"
            )


@dataclasses.dataclass(eq=False)
class BatchSetpoint(BatchArrays):
    """What is asked of n flights, in W.

    Attributes:
        velocity: (n, 3) [m/s].
        yaw_rate: (n) [rad/s].
        position: (n, 3) a point to go to [m], where `follow` is 1.
        follow: (n) whether it is gone to, 0 or 1; the velocity is added to what leads there.
    """

    velocity: np.ndarray
    yaw_rate: np.ndarray
    position: np.ndarray
    follow: np.ndarray


def parameter_columns(parameters: Mapping[str, Any], count: int) -> list[dict[str, float]]:
    """Return values by name of each flight."""
    if not isinstance(parameters, Mapping):
        raise WorkbenchError(
            f"the parameters of a batch are {parameters!r:.60}: give values by name, as "
            "{'wind_x': 3.0}"
        )
    columns = {}
    for name, values in parameters.items():
        try:
            column = np.broadcast_to(np.asarray(values, dtype=float), count)
        except (TypeError, ValueError):
            column = np.full(count, np.nan)
        if not np.isfinite(column).all():
            raise WorkbenchError(
                f"{name} of a batch is {values_preview(values)}: give a finite number, or {count} "
                "of them"
            )
        columns[name] = column.tolist()
    return [{name: column[k] for name, column in columns.items()} for k in range(count)]


def setpoint_views(references: np.ndarray) -> BatchSetpoint:
    """Return the views of references (n, 8), see `guidance.Reference`."""
    return BatchSetpoint(references[:, 0:3], references[:, 3], references[:, 4:7], references[:, 7])


def selected_flights(which: FlightSelection, count: int) -> np.ndarray:
    """Return the numbers (k) of those flights of a batch.

    Raises:
        WorkbenchError: if there is no such flight.
    """
    numbers = np.arange(count)
    if which is None:
        return numbers
    try:
        return np.atleast_1d(numbers[which])
    except (IndexError, TypeError, ValueError):
        raise WorkbenchError(
            f"no flights of a batch of {count} are {values_preview(which)}: give a mask of as "
            f"many, or numbers from 0 to {count - 1}"
        ) from None


def frozen_values(values: np.ndarray) -> np.ndarray:
    """Return values that nobody writes, as no flight would know of it."""
    values.setflags(write=False)
    return values


def checked_whole_number(name: str, number: SupportsIndex, least: int, most: int) -> int:
    """Return a whole number within limits.

    Raises:
        WorkbenchError: if it is not one.
    """
    try:
        found = operator.index(number)
    except TypeError:
        found = least - 1
    if not least <= found <= most:
        raise WorkbenchError(
            f"the {name} of a batch is {number!r:.60}: give a whole number from {least} to {most}"
        )
    return found
