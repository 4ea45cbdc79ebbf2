"""A number that was identified, with its interval, and the verdict on it."""

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from workbench.extras.flightdata.identify.held_back import HeldBackPrediction
from workbench.extras.flightdata.identify.quantities import with_quantities
from workbench.extras.flightdata.identify.search import IdentificationResult
from workbench.plant.gravity import GRAVITY

WELL_KNOWN, ROUGHLY_KNOWN, NOT_DETERMINED = "well", "roughly", "not determined"
"""Verdicts on a quantity, from its interval."""
REFUTED = "refuted by the validation"
"""Verdict on a quantity of a model that predicts a part of the flight that it has not seen no
better than no model does."""
NOT_ENOUGH_MOTION = "not enough motion"
"""In place of a verdict: thrust or level force changes too little in the part that validates."""
LONGER_FLIGHT_TEXT = "for longer, so that a part of the flight is left to validate with"
"""Flight that helps where no part could be held back."""
ROUGHLY_KNOWN_FACTOR = 3.0
"""Factor on the uncertainty of a well known quantity up to which it is roughly known."""
SEPARABLE_LAG_SHARE = 0.3
"""Largest relative half width of the interval of the lag, to separate it from the delay."""


@dataclass(frozen=True)
class IdentifiedNumber:
    """An identified number.

    Attributes:
        name: its own.
        unit: SI.
        value: of it.
        low: lower end of its 95 % interval.
        high: its upper end.
        described: its value in the description, or None.
        verdict: `WELL_KNOWN`, `ROUGHLY_KNOWN`, `NOT_DETERMINED`, `REFUTED` or `NOT_ENOUGH_MOTION`.
        flight: one that would narrow the interval.
    """

    name: str
    unit: str
    value: float
    low: float
    high: float
    described: float | None
    verdict: str
    flight: str


VOLTAGE_EXPONENT = "voltage_exponent"
DRIFT_TEXT = (
    "voltage_exponent: the interval leaves out what drifts along a flight as the voltage does, "
    "such as motors that grow warm; compare the values of several flights"
)
"""Remark on its interval: blocks of three seconds do not show a drift, which is as slow as the
voltage. Two flights of one Crazyflie give 0.43 ± 0.11 and 1.29 ± 0.19."""
_VALIDATED_ROWS = {
    "force": (
        *("rotor_lag", "delay", "lag_with_delay", "motor_constant", "thrust_to_weight"),
        *("hover_command", VOLTAGE_EXPONENT, "climb_drag"),
    ),
    "level": ("drag",),
    "turn": (
        *("rotor_lag", "delay", "lag_with_delay", "inertia_x", "inertia_y", "inertia_z"),
        *("rotor_inertia", "center_x", "center_y", "turn_imbalance", "gyro_delay"),
    ),
}
"""Rows that each part of the validation is about."""
THROTTLE_DOUBLETS_TEXT = "throttle doublets of 0.2 to 1 s, ± a quarter of hover thrust"
_TILT_DOUBLETS = "quick roll and pitch doublets of 0.1 to 0.5 s"
_YAW_DOUBLETS = "yaw rate doublets of 0.5 to 2 s, as large as allowed"
FAST_LEVEL_FLIGHT_TEXT = "level flight to and fro at 2 m/s and more, with velocity measured"


def identified_rows(found: IdentificationResult) -> list[IdentifiedNumber]:
    """Return the results in the order of the table."""
    fit, vehicle = found.fit, found.vehicle
    half = 0.5 * vehicle.span
    names = set(fit.names)
    rows: list[IdentifiedNumber] = []

    def add(
        name: str, unit: str, ends: tuple[float, float, float], described: float | None,
        limit: float, flight: str,
    ) -> None:  # fmt: skip
        value, low, high = ends
        verdict = _width_verdict(0.5 * (high - low), limit)
        if verdict == WELL_KNOWN and not fit.complete:
            verdict = ROUGHLY_KNOWN
        rows.append(IdentifiedNumber(name, unit, value, low, high, described, verdict, flight))

    if found.fast:
        described_lag = vehicle.rotor_lag
        lag = _factor(found, "lag", described_lag)
        add("rotor_lag", "s", lag, described_lag, 0.15 * lag[0], THROTTLE_DOUBLETS_TEXT)
        add("delay", "s", _plain_value(found, "delay"), None, 0.003, THROTTLE_DOUBLETS_TEXT)
        add(
            "lag_with_delay",
            "s",
            _total_delay(found, described_lag),
            None,
            0.15 * lag[0],
            THROTTLE_DOUBLETS_TEXT,
        )
    if "thrust" in names:
        known = float(np.mean([each.motor_constant for each in vehicle.rotors]))
        thrust = _factor(found, "thrust", known)
        add("motor_constant", "N s^2", thrust, known, 0.03 * thrust[0], THROTTLE_DOUBLETS_TEXT)
    else:
        ends = thrust_to_weight_at(found, 1.0)
        add(
            "thrust_to_weight",
            "1",
            ends,
            vehicle.thrust_to_weight,
            0.05 * ends[0],
            THROTTLE_DOUBLETS_TEXT,
        )
        ends = hover_command(found)
        add("hover_command", "1", ends, None, 0.03, THROTTLE_DOUBLETS_TEXT)
        if "voltage" in names:
            ends = _plain_value(found, "voltage")
            add(VOLTAGE_EXPONENT, "1", ends, 1.0, 0.2, "several whole batteries, and compare")
            if rows[-1].verdict == WELL_KNOWN:  # the interval leaves drift out, see DRIFT_TEXT
                rows[-1] = replace(rows[-1], verdict=ROUGHLY_KNOWN)
    for axis, (name, flight) in enumerate(
        (("inertia_x", _TILT_DOUBLETS), ("inertia_y", _TILT_DOUBLETS), ("inertia_z", _YAW_DOUBLETS))
    ):
        if name in names:
            known = float(vehicle.inertia[axis, axis])
            ends = _factor(found, name, known)
            add(name, "kg m^2", ends, known, 0.15 * ends[0], flight)
    if "spin_up" in names:
        known = float(np.mean([each.inertia for each in vehicle.rotors]))
        one = with_quantities(vehicle, fit.named | {"spin_up": 1.0})
        scale = float(np.mean([each.inertia for each in one.rotors]))
        ends = _plain_value(found, "spin_up", scale)
        add("rotor_inertia", "kg m^2", ends, known or None, 0.3 * abs(scale) * 0.1, _YAW_DOUBLETS)
        for axis, name in enumerate(("center_x", "center_y")):
            at = vehicle.p_BoBcm_B[axis]
            value, low, high = _plain_value(found, name, half)
            ends = (at + value, at + low, at + high)
            add(name, "m", ends, at, 0.02 * half, "a steady hover of 10 s")
        add("turn_imbalance", "1", _plain_value(found, "turn"), 0.0, 0.03, "a steady hover of 10 s")
        add("gyro_delay", "s", _plain_value(found, "gyro_delay"), None, 0.003, _TILT_DOUBLETS)
    if "drag" in names:
        drag = _plain_value(found, "drag")
        add("drag", "1/s", drag, None, max(0.02, 0.25 * abs(drag[0])), FAST_LEVEL_FLIGHT_TEXT)
        add(
            "climb_drag",
            "1/s",
            _plain_value(found, "climb_drag"),
            None,
            0.05,
            FAST_LEVEL_FLIGHT_TEXT,
        )
    return rows


def validated_numbers(
    rows: Sequence[IdentifiedNumber], held_back: HeldBackPrediction | None
) -> list[IdentifiedNumber]:
    """Return rows with the verdicts that the validation allows.

    Args:
        rows: with verdicts from their intervals.
        held_back: the validation; None without one, when no row is well known.
    """
    if held_back is None:
        return [
            replace(row, verdict=ROUGHLY_KNOWN, flight=LONGER_FLIGHT_TEXT)
            if row.verdict == WELL_KNOWN
            else row
            for row in rows
        ]
    found = []
    refuted, judged, quiet = refuted_parts(rows, held_back), judged_parts(rows), held_back.quiet
    for row in rows:
        parts = {part for part in judged if row.name in _VALIDATED_ROWS[part]}
        if parts and parts <= quiet:
            flight = THROTTLE_DOUBLETS_TEXT if "force" in parts else FAST_LEVEL_FLIGHT_TEXT
            row = replace(row, verdict=NOT_ENOUGH_MOTION, flight=flight)
        elif parts and parts <= refuted | quiet:
            row = replace(row, verdict=REFUTED)
        elif (
            parts & (refuted | quiet) and row.verdict == WELL_KNOWN
        ):  # the lag, of which the other part is right
            row = replace(row, verdict=ROUGHLY_KNOWN)
        found.append(row)
    return found


def judged_parts(rows: Sequence[IdentifiedNumber]) -> frozenset[str]:
    """Return the parts of the validation that count: rotation only with inertias."""
    turns = any(row.name.startswith("inertia") for row in rows)
    return frozenset(part for part in _VALIDATED_ROWS if turns or part != "turn")


def refuted_parts(
    rows: Sequence[IdentifiedNumber], held_back: HeldBackPrediction
) -> frozenset[str]:
    """Return the refuted parts among those that count."""
    return held_back.refuted & judged_parts(rows)


def _width_verdict(width: float, limit: float) -> str:
    return (
        WELL_KNOWN
        if width <= limit
        else ROUGHLY_KNOWN
        if width <= ROUGHLY_KNOWN_FACTOR * limit
        else NOT_DETERMINED
    )


def _factor(found: IdentificationResult, name: str, described: float) -> tuple[float, float, float]:
    value, width = found.fit.value(name), found.quantile * found.fit.deviation(name)
    ends = [described * math.exp(each) for each in (value, value - width, value + width)]
    return ends[0], ends[1], ends[2]


def _plain_value(
    found: IdentificationResult, name: str, scale: float = 1.0
) -> tuple[float, float, float]:
    value, width = found.fit.value(name), found.quantile * found.fit.deviation(name)
    return scale * value, scale * value - abs(scale) * width, scale * value + abs(scale) * width


def _total_delay(found: IdentificationResult, described: float) -> tuple[float, float, float]:
    """Return lag and delay in all, which many flights know better than either [s]."""
    fit = found.fit
    lag = described * math.exp(fit.value("lag"))
    slope = np.zeros(len(fit.names))
    slope[fit.names.index("lag")] = lag
    slope[fit.names.index("delay")] = 1.0
    width = found.quantile * math.sqrt(slope @ fit.covariance @ slope)
    value = lag + fit.value("delay")
    return value, value - width, value + width


def thrust_to_weight_at(found: IdentificationResult, command: float) -> tuple[float, float, float]:
    """Return thrust over weight at a command (0 .. 1) at the mean voltage, and its interval."""
    fit = found.fit
    most = sum(rotor.max_thrust for rotor in found.vehicle.rotors)
    scale = most / (found.vehicle.mass * GRAVITY)
    slope = np.zeros(len(fit.names))
    for power in range(3):
        slope[fit.names.index(f"curve_{power}")] = scale * command**power
    value = float(slope @ fit.values)
    width = found.quantile * math.sqrt(slope @ fit.covariance @ slope)
    return value, value - width, value + width


def hover_command(found: IdentificationResult) -> tuple[float, float, float]:
    """Return the command at which thrust is the weight, and its interval.

    This is where the curve finally crosses the weight. The interval is that of thrust over the
    slope of the curve.
    """
    grid = np.linspace(0.02, 1.0, 491)
    thrust = np.array([thrust_to_weight_at(found, command)[0] for command in grid])
    below = np.flatnonzero(thrust < 1.0)
    place = min(int(below[-1]) + 1 if len(below) else 0, len(grid) - 1)
    value, low, high = thrust_to_weight_at(found, grid[place])
    slope = max(0.1, float(np.gradient(thrust, grid)[place]))
    at = float(grid[place]) + (1.0 - value) / slope if len(below) else float(grid[0])
    width = 0.5 * (high - low) / slope
    return at, at - width, at + width


def is_lag_separable(found: IdentificationResult) -> str:
    """Return whether lag and delay are separable, and whether the lag is one number."""
    if not found.fast:
        return "lag and delay are not judged"
    lag, low, high = _factor(found, "lag", found.vehicle.rotor_lag)
    alone = 0.5 * (high - low)
    _, first, last = _total_delay(found, found.vehicle.rotor_lag)
    if found.apart:
        one, _, other, _ = found.apart
        known = found.vehicle.rotor_lag
        return (
            f"thrust shows a lag of {1e3 * known * math.exp(one):.1f} ms and turning one of "
            f"{1e3 * known * math.exp(other):.1f} ms: this difference is larger than chance "
            "explains, so the model is not exact; the interval includes both"
        )
    if alone > SEPARABLE_LAG_SHARE * lag or 0.5 * (last - first) < 0.5 * alone:
        return "lag and delay cannot be separated: use lag_with_delay"
    return "lag and delay are separated"
