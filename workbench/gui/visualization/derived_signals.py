"""Sources of the charts' series, and signals derived from others."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Protocol

import numpy as np

from workbench.common.series import TimedValues
from workbench.logs.expressions import Expression, parse_expression

OWN_TOPIC = "own"
"""Prefix of the names of the user's derived signals."""


class SeriesSource(Protocol):
    """Series by their names."""

    @property
    def units(self) -> Mapping[str, str]:
        """SI unit of every series, by name."""

    def series(self, name: str, since: float = ...) -> TimedValues:
        """Return times [s] and values from a time on (N).

        Raises:
            WorkbenchError: if there is no such series.
        """


@dataclass(frozen=True)
class DerivedSignal:
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


def true_signal(field: str) -> str:
    """Return the signal of the true motion of an estimated state, by its field."""
    return f"{'velocity_data' if field.startswith('v_') else 'position_data'}.{field}"


def _error_signal(axis: str, unit: str, response: str) -> DerivedSignal:
    text = f"command_velocity.{axis} - velocity_data.{response}"
    return DerivedSignal(f"error.{axis}", unit, text, "command minus response, in W")


def _estimate_bounds(field: str, unit: str) -> tuple[DerivedSignal, DerivedSignal]:
    """Return the estimate of a state minus, and plus, two standard deviations."""
    low, high = (f"estimate.{field} {sign} 2*estimate.sigma_{field}" for sign in "-+")
    return (
        DerivedSignal(f"bound.{field}_low", unit, low, "less 2 sigma"),
        DerivedSignal(f"bound.{field}_high", unit, high, "plus 2 sigma"),
    )


def _vector_length(of: str) -> str:
    return "sqrt(" + " + ".join(f"{of}_{axis}**2" for axis in "xyz") + ")"


ESTIMATED_STATES = (
    *(("x", "m"), ("y", "m"), ("z", "m")),
    *(("roll", "rad"), ("pitch", "rad"), ("yaw", "rad")),
    *(("v_x", "m/s"), ("v_y", "m/s"), ("v_z", "m/s")),
)
"""Fields and SI units of the states that an estimator gives."""
DERIVED_SIGNALS: tuple[DerivedSignal, ...] = (
    _error_signal("v_x", "m/s", "v_x"),
    _error_signal("v_y", "m/s", "v_y"),
    _error_signal("v_z", "m/s", "v_z"),
    _error_signal("yaw_rate", "rad/s", "w_z"),
    DerivedSignal(
        "derived.speed", "m/s", _vector_length("velocity_data.v"), "length of the velocity"
    ),
    DerivedSignal(
        "derived.distance",
        "m",
        _vector_length("position_data.displacement"),
        "from where the flight began",
    ),
    *(bound for field, unit in ESTIMATED_STATES for bound in _estimate_bounds(field, unit)),
)
"""Signals that every flight and log has, if it has their parts."""


class WithDerived:
    """A source together with the derived signals that it supports.

    Args:
        source: source of the other signals.
        derived: derived signals in order; later ones can use earlier ones.
    """

    def __init__(
        self, source: SeriesSource, derived: Sequence[DerivedSignal] = DERIVED_SIGNALS
    ) -> None:
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

    def series(self, name: str, since: float = -np.inf) -> TimedValues:
        """Return times [s] and values of a signal from a time on (N).

        Raises:
            WorkbenchError: if there is no such signal, or it cannot be computed.
        """
        if name not in self._derived:
            return self._source.series(name, since)
        if name not in self._full:
            self._full[name] = self._derived[name].parsed.find(self.units)
        return self._derived[name].parsed.series(self.series, self._full[name], since)
