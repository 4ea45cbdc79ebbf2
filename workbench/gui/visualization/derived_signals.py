"""Where charts take their series from, and signals that are derived from others."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Protocol

import numpy as np

Series = tuple[np.ndarray, np.ndarray]


class SeriesSource(Protocol):
    """Series by their names."""

    @property
    def units(self) -> Mapping[str, str]:
        """SI unit of every series, by name."""

    def series(self, name: str, since: float = ...) -> tuple[np.ndarray, np.ndarray]:
        """Return times [s] and values from a time on (N).

        Raises:
            WorkbenchError: if there is no such series.
        """


@dataclass(frozen=True)
class Derived:
    """A signal made from others.

    Attributes:
        name: of it, DERIVED.FIELD.
        unit: SI.
        parts: names of the signals that it is made from; its times are those of the first.
        make: returns its values from theirs.
        help: what it is, in words.
    """

    name: str
    unit: str
    parts: tuple[str, ...]
    make: Callable[..., np.ndarray]
    help: str


def _length(*parts: np.ndarray) -> np.ndarray:
    squares: np.ndarray = np.sqrt(sum(part * part for part in parts))
    return squares


def _error(axis: str, unit: str, command: str, response: str) -> Derived:
    return Derived(
        f"error.{axis}",
        unit,
        (f"command_velocity.{command}", f"velocity_data.{response}"),
        lambda wanted, flown: wanted - flown,
        "command minus response, in W",
    )


def _bounds(field: str, unit: str) -> tuple[Derived, Derived]:
    """Return the estimate of a state less, and plus, two standard deviations."""
    parts = (f"estimate.{field}", f"estimate.sigma_{field}")
    return (
        Derived(
            f"bound.{field}_low", unit, parts, lambda x, sigma: x - 2.0 * sigma, "less 2 sigma"
        ),
        Derived(
            f"bound.{field}_high", unit, parts, lambda x, sigma: x + 2.0 * sigma, "plus 2 sigma"
        ),
    )


_ESTIMATED = (
    *(("x", "m"), ("y", "m"), ("z", "m")),
    *(("roll", "rad"), ("pitch", "rad"), ("yaw", "rad")),
    *(("v_x", "m/s"), ("v_y", "m/s"), ("v_z", "m/s")),
)
DERIVED: tuple[Derived, ...] = (
    _error("v_x", "m/s", "v_x", "v_x"),
    _error("v_y", "m/s", "v_y", "v_y"),
    _error("v_z", "m/s", "v_z", "v_z"),
    _error("yaw_rate", "rad/s", "yaw_rate", "w_z"),
    Derived(
        "derived.speed",
        "m/s",
        ("velocity_data.v_x", "velocity_data.v_y", "velocity_data.v_z"),
        _length,
        "length of the velocity",
    ),
    Derived(
        "derived.distance",
        "m",
        (
            "position_data.displacement_x",
            "position_data.displacement_y",
            "position_data.displacement_z",
        ),
        _length,
        "from where the flight began",
    ),
    *(bound for field, unit in _ESTIMATED for bound in _bounds(field, unit)),
)


class WithDerived:
    """A source with the derived signals that its own ones allow.

    Args:
        source: of the others.
    """

    def __init__(self, source: SeriesSource) -> None:
        self._source = source

    @property
    def units(self) -> Mapping[str, str]:
        """SI unit of every series, by name."""
        units = dict(self._source.units)
        units.update(
            {each.name: each.unit for each in DERIVED if all(part in units for part in each.parts)}
        )
        return units

    def series(self, name: str, since: float = -np.inf) -> Series:
        """Return times [s] and values of a signal from a time on (N).

        Raises:
            WorkbenchError: if there is no such signal.
        """
        for each in DERIVED:
            if each.name == name:
                return self._make(each, since)
        return self._source.series(name, since)

    def _make(self, derived: Derived, since: float) -> Series:
        time, first = self._source.series(derived.parts[0], since)
        parts = [first]
        for name in derived.parts[1:]:
            own, values = self._source.series(name, since)
            if len(own) == 0:
                return time[:0], first[:0]
            if len(own) != len(time) or own[0] != time[0]:
                values = np.interp(time, own, values)
            parts.append(values)
        return time, derived.make(*parts)
