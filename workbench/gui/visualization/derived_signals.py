"""Sources of the charts' series, and signals derived from others."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Protocol

import numpy as np

from workbench.logs.expressions import Expression, Samples, parse_expression

OWN_TOPIC = "own"
"""Prefix of the names of the user's derived signals."""


class SeriesSource(Protocol):
    """Series by their names."""

    @property
    def units(self) -> Mapping[str, str]:
        """SI unit of every series, by name."""

    def series(self, name: str, since: float = ...) -> Samples:
        """Return times [s] and values from a time on (N).

        Raises:
            WorkbenchError: if there is no such series.
        """


@dataclass(frozen=True)
class Derived:
    """A signal made from others.

    Attributes:
        name: its name, TOPIC.FIELD.
        unit: SI unit.
        expression: the expression.
        help: description in words.
    """

    name: str = ""
    unit: str = "1"
    expression: str = ""
    help: str = ""

    def check(self) -> None:
        """Refuse an invalid expression.

        Raises:
            WorkbenchError: gives the position of an error.
        """
        _ = self.parsed

    @cached_property
    def parsed(self) -> Expression:
        """The parsed expression.

        Raises:
            WorkbenchError: if the text is invalid.
        """
        return parse_expression(self.expression)


def _error(axis: str, unit: str, response: str) -> Derived:
    text = f"command_velocity.{axis} - velocity_data.{response}"
    return Derived(f"error.{axis}", unit, text, "command minus response, in W")


def _bounds(field: str, unit: str) -> tuple[Derived, Derived]:
    """Return the estimate of a state minus, and plus, two standard deviations."""
    low, high = (f"estimate.{field} {sign} 2*estimate.sigma_{field}" for sign in "-+")
    return (
        Derived(f"bound.{field}_low", unit, low, "less 2 sigma"),
        Derived(f"bound.{field}_high", unit, high, "plus 2 sigma"),
    )


def _length(of: str) -> str:
    return "sqrt(" + " + ".join(f"{of}_{axis}**2" for axis in "xyz") + ")"


_ESTIMATED = (
    *(("x", "m"), ("y", "m"), ("z", "m")),
    *(("roll", "rad"), ("pitch", "rad"), ("yaw", "rad")),
    *(("v_x", "m/s"), ("v_y", "m/s"), ("v_z", "m/s")),
)
DERIVED: tuple[Derived, ...] = (
    _error("v_x", "m/s", "v_x"),
    _error("v_y", "m/s", "v_y"),
    _error("v_z", "m/s", "v_z"),
    _error("yaw_rate", "rad/s", "w_z"),
    Derived("derived.speed", "m/s", _length("velocity_data.v"), "length of the velocity"),
    Derived(
        "derived.distance",
        "m",
        _length("position_data.displacement"),
        "from where the flight began",
    ),
    *(bound for field, unit in _ESTIMATED for bound in _bounds(field, unit)),
)
"""Signals that every flight and log has, if it has their parts."""


class WithDerived:
    """A source together with the derived signals that it supports.

    Args:
        source: source of the other signals.
        derived: derived signals in order; later ones can use earlier ones.
    """

    def __init__(self, source: SeriesSource, derived: Sequence[Derived] = DERIVED) -> None:
        self._source = source
        self._derived = {each.name: each for each in derived}
        self._full: dict[str, dict[str, str]] = {}

    @property
    def units(self) -> Mapping[str, str]:
        """SI unit of every series, by name."""
        units = dict(self._source.units)
        self._full = {}
        for each in self._derived.values():
            if each.parsed.can_find(units):
                self._full[each.name] = each.parsed.find(units)
                units[each.name] = each.unit
        return units

    def series(self, name: str, since: float = -np.inf) -> Samples:
        """Return times [s] and values of a signal from a time on (N).

        Raises:
            WorkbenchError: if there is no such signal, or it cannot be computed.
        """
        if name not in self._derived:
            return self._source.series(name, since)
        if name not in self._full:
            self._full[name] = self._derived[name].parsed.find(self.units)
        return self._derived[name].parsed.series(self.series, self._full[name], since)
