"""Gain schedules: a set of gains at each of several values of a measured quantity.

`pd@speed=0,4,8` is the controller `pd` with three sets of gains, for 0, 4 and 8 m/s. A gain k with
the sets k_1 ... k_n at q_1 < ... < q_n is, at the quantity q,

    k = k_1 + s_2 (k_2 - k_1) + ... + s_n (k_n - k_(n-1)),   s_i = (q - q_(i-1)) / (q_i - q_(i-1)),

with each s_i limited to 0 .. 1 (linear interpolation; Rugh and Shamma, "Research on gain
scheduling", Automatica 36, 2000, section 2). Gains are continuous in q, so commands do not jump
between sets. Equal sets fly exactly as the controller without a schedule, to the bit. Linear models
include the derivatives of the gains with respect to q.
"""

import re
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from types import SimpleNamespace
from typing import Any

from workbench.common.errors import WorkbenchError, find_named_row
from workbench.common.jitable import (
    give_unique_name,
    make_results_tuple,
    make_tuple_reader,
    register_jitable,
)
from workbench.common.vectors import Numbers
from workbench.control.guidance import (
    Gains,
    KnownBody,
    LawResult,
    LawSetpoint,
    MeasuredMotion,
    Memory,
)
from workbench.control.loop_points import Probes

MAX_GAIN_SETS = 8
_SCHEDULE_NUMBER = r"\d+(\.\d+)?"
_SCHEDULE_PATTERN = re.compile(r"(.+)@([a-z_]+)=([^@/]*)")


@register_jitable(forceinline=True)
def _speed(measured: MeasuredMotion, vehicle: KnownBody) -> float:
    v_x, v_y, v_z = measured.v_WBcm
    square = v_x * v_x + v_y * v_y + v_z * v_z
    if square > 0.0:  # the root has no derivative at 0
        square = square**0.5
    return square


@register_jitable(forceinline=True)
def _height(measured: MeasuredMotion, vehicle: KnownBody) -> float:
    return measured.p_WB[2]


@register_jitable(forceinline=True)
def _payload(measured: MeasuredMotion, vehicle: KnownBody) -> float:
    return vehicle.payload


@register_jitable(forceinline=True)
def _voltage(measured: MeasuredMotion, vehicle: KnownBody) -> float:
    return measured.voltage


@register_jitable(forceinline=True)
def _share(quantity: float, low: float, high: float) -> float:
    """Return s_i, which is 0 at `low` and below, and 1 at `high` and above."""
    share = (quantity - low) / (high - low)
    if share < 0.0:
        share = 0.0 * share
    if share > 1.0:
        share = 0.0 * share + 1.0
    return share


@dataclass(frozen=True)
class ScheduleQuantity:
    """A quantity that gains may be scheduled over.

    Attributes:
        name: of the quantity.
        unit: SI.
        read: returns it from `guidance.MeasuredMotion` and `guidance.KnownBody`.
    """

    name: str
    unit: str
    read: Callable[[MeasuredMotion, KnownBody], float]


SCHEDULE_QUANTITIES = (
    ScheduleQuantity("speed", "m/s", _speed),  # speed of the centre of mass over the ground
    ScheduleQuantity("height", "m", _height),  # height above the world's origin
    ScheduleQuantity("payload", "kg", _payload),  # mass of the payload that the law knows of
    ScheduleQuantity("voltage", "1", _voltage),  # voltage under load over that of the full battery
)


@dataclass(frozen=True)
class GainSchedule:
    """A quantity, and its values that have a set of gains.

    Attributes:
        quantity: over which gains are scheduled.
        values: in its unit, ascending; 2 to 8 of them.
    """

    quantity: ScheduleQuantity
    values: tuple[float, ...]

    @property
    def label(self) -> str:
        """The part of a controller's name after the @."""
        return f"{self.quantity.name}={','.join(f'{value:g}' for value in self.values)}"

    @property
    def suffixes(self) -> tuple[str, ...]:
        """The suffix of a gain's name in each set."""
        return tuple(f"_at_{value:g}".replace(".", "_") for value in self.values)

    def where(self, number: int) -> str:
        """Return the quantity's value of a set, in words."""
        unit = "" if self.quantity.unit == "1" else f" {self.quantity.unit}"
        return f"at {self.quantity.name} {self.values[number]:g}{unit}"

    def names(self, gain: str) -> tuple[str, ...]:
        """Return the names of a gain in each set."""
        return tuple(gain + suffix for suffix in self.suffixes)

    def number_of(self, name: str) -> int | None:
        """Return the set that a gain belongs to, None for a parameter that is not scheduled."""
        fits = [number for number, suffix in enumerate(self.suffixes) if name.endswith(suffix)]
        return fits[0] if fits else None

    def nearest(self, quantity: float) -> int:
        """Return the number of the set with the largest weight at a value."""
        return min(range(len(self.values)), key=lambda k: abs(self.values[k] - quantity))

    def value(
        self,
        *,
        height: float = 0.0,
        velocity: Sequence[float] = (0.0, 0.0, 0.0),
        payload: float = 0.0,
        voltage: float = 1.0,
    ) -> float:
        """Return the quantity of a flight, in SI units.

        Args:
            height: above the world's origin.
            velocity: of the centre of mass in W (3).
            payload: known mass of the payload.
            voltage: see `guidance.MeasuredMotion`.
        """
        measured: Any = SimpleNamespace(p_WB=(0.0, 0.0, height), v_WBcm=velocity, voltage=voltage)
        body: Any = SimpleNamespace(payload=payload)
        return float(self.quantity.read(measured, body))

    def between(self, sets: Sequence[float], quantity: float) -> float:
        """Return a gain at a value, interpolated between its sets (n); see the module."""
        found = sets[0]
        for k in range(1, len(self.values)):
            share = _share(quantity, self.values[k - 1], self.values[k])
            found = found + share * (sets[k] - sets[k - 1])
        return found

    def update(
        self, law: Callable[..., LawResult], gains: Any, scheduled: Sequence[str], key: str
    ) -> Callable[..., LawResult]:
        """Return the update of a controller with scheduled gains, which compiles if its law does.

        Args:
            law: `update` without a schedule.
            gains: type of its `g`.
            scheduled: names of the gains that have sets.
            key: see `give_unique_name`.
        """
        read, values = self.quantity.read, self.values
        shares = make_results_tuple(
            [_step_share(*ends, key) for ends in zip(values[:-1], values[1:], strict=True)], key
        )
        parts = make_results_tuple(
            [
                _blended(self.names(name), key) if name in scheduled else _unscheduled(name)
                for name in gains._fields
            ],
            key,
        )

        @register_jitable(forceinline=True)
        def update(
            measured: MeasuredMotion,
            setpoint: LawSetpoint,
            g: Gains,
            vehicle: KnownBody,
            memory: Memory,
            dt: float,
            loops: Probes,
        ) -> LawResult:
            now = gains(*parts(g, shares(read(measured, vehicle))))
            return law(measured, setpoint, now, vehicle, memory, dt, loops)

        return give_unique_name(update, key)


def _step_share(low: float, high: float, key: str) -> Callable[[float], float]:
    """Return the share of the way from one value of the quantity to the next, of the quantity."""

    @register_jitable(forceinline=True)
    def share(quantity: float) -> float:
        return _share(quantity, low, high)

    return give_unique_name(share, f"{low}_{high}_{key}")


def _unscheduled(name: str) -> Callable[[Gains, Numbers], float]:
    """Return a gain without sets, of gains and shares."""

    @register_jitable(forceinline=True)
    def part(g: Gains, shares: Numbers) -> float:
        return getattr(g, name)

    return give_unique_name(part, name)


def _blended(names: Sequence[str], key: str) -> Callable[[Gains, Numbers], float]:
    """Return a gain between its sets, of gains and the shares of the ways between them."""
    sets_of = make_tuple_reader(names, f"{names[0]}_{key}")

    @register_jitable(forceinline=True)
    def part(g: Gains, shares: Numbers) -> float:
        sets = sets_of(g)
        found = sets[0]
        for k in range(len(shares)):
            found = found + shares[k] * (sets[k + 1] - sets[k])
        return found

    return give_unique_name(part, f"{names[0]}_{key}")


def split_label(name: str) -> tuple[str, str]:
    """Return a controller's name or file, and the label of its schedule, "" without one."""
    found = _SCHEDULE_PATTERN.fullmatch(name)
    return (found[1], f"{found[2]}={found[3]}") if found else (name, "")


def with_label(name: str, label: str) -> str:
    """Return a controller's name or file with the label of its schedule, "" for none."""
    return f"{name}@{label}" if label else name


def parse_schedule(label: str) -> GainSchedule:
    """Return the schedule of a label such as `speed=0,4,8`.

    Raises:
        WorkbenchError: if the label is not valid.
    """
    name, _, given = label.partition("=")
    quantity = find_named_row("quantity for a schedule", name, SCHEDULE_QUANTITIES)
    try:
        values = tuple(float(value) for value in given.split(","))
    except ValueError:
        values = ()
    if not (
        2 <= len(values) <= MAX_GAIN_SETS
        and all(value >= 0.0 and re.fullmatch(_SCHEDULE_NUMBER, f"{value:g}") for value in values)
        and all(float(f"{value:g}") == value for value in values)
        and all(low < high for low, high in zip(values, values[1:], strict=False))
    ):
        raise WorkbenchError(
            f"@{label} is not a schedule: write 2 to {MAX_GAIN_SETS} ascending values, 0 or more, "
            "of "
            "six digits at most, as pd@speed=0,4,8"
        )
    return GainSchedule(quantity, values)
