"""What was found, in numbers that people know: each with its interval, verdict, and what helps."""

import math
from dataclasses import dataclass

import numpy as np

from workbench.design.identify.fit import Fit, make_piece, model_rows
from workbench.design.identify.flight import SHARE
from workbench.design.identify.quantities import with_quantities
from workbench.design.identify.search import Found
from workbench.plant.gravity import GRAVITY
from workbench.plant.vehicle import Vehicle

WELL, ROUGHLY, NOT = "well", "roughly", "not determined"
"""Verdicts on excitation."""
THREEFOLD = 3.0
"""So many times what is well known is still roughly known."""
TOLD_APART = 0.3
"""Share of the lag that its interval may have to either side to be told from the delay."""
WHITE_SPAN = 1.0
"""Up to which errors of prediction are looked at for what hangs together [s]."""


@dataclass(frozen=True)
class Row:
    """A number that was identified.

    Attributes:
        name: its own.
        unit: SI.
        value: of it.
        low: end of its interval of 95 %, and so `high`.
        high: see there.
        described: what the description says; None where it says nothing.
        verdict: `WELL`, `ROUGHLY` or `NOT`.
        flight: that would narrow it.
    """

    name: str
    unit: str
    value: float
    low: float
    high: float
    described: float | None
    verdict: str
    flight: str


@dataclass(frozen=True)
class Prediction:
    """How well a model that has not seen them predicts the last fifth of the flights.

    Attributes:
        force: RMS error of specific force along z [m/s²], and that of its mean.
        constant_force: see there.
        turn: RMS error of angular velocity after `ahead` [rad/s], and that of the rate held.
        constant_turn: see there.
        ahead: [s].
    """

    force: float
    constant_force: float
    turn: float
    constant_turn: float
    ahead: float


_THROTTLE = "throttle doublets of 0.2 to 1 s, ± a quarter of hover thrust"
_TURNS = "quick roll and pitch doublets of 0.1 to 0.5 s"
_YAW = "yaw rate doublets of 0.5 to 2 s, as large as allowed"
_FAST = "level flight to and fro at 2 m/s and more, with velocity measured"


def rows_of(found: Found) -> list[Row]:
    """Return what was found, in the order in which it is read."""
    fit, vehicle = found.fit, found.vehicle
    half = 0.5 * vehicle.span
    names = set(fit.names)
    rows: list[Row] = []

    def add(
        name: str, unit: str, ends: tuple[float, float, float], described: float | None,
        limit: float, flight: str,
    ) -> None:  # fmt: skip
        value, low, high = ends
        verdict = _verdict(0.5 * (high - low), limit)
        if verdict == WELL and not fit.complete:
            verdict = ROUGHLY
        rows.append(Row(name, unit, value, low, high, described, verdict, flight))

    if found.fast:
        described_lag = vehicle.rotor_lag
        lag = _factor(found, "lag", described_lag)
        add("rotor_lag", "s", lag, described_lag, 0.15 * lag[0], _THROTTLE)
        add("delay", "s", _plain(found, "delay"), None, 0.003, _THROTTLE)
        add("lag_with_delay", "s", _together(found, described_lag), None, 0.15 * lag[0], _THROTTLE)
    if "thrust" in names:
        known = float(np.mean([each.motor_constant for each in vehicle.rotors]))
        thrust = _factor(found, "thrust", known)
        add("motor_constant", "N s^2", thrust, known, 0.03 * thrust[0], _THROTTLE)
    else:
        ends = thrust_at(found, 1.0)
        add("thrust_to_weight", "1", ends, vehicle.thrust_to_weight, 0.05 * ends[0], _THROTTLE)
        ends = hover_command(found)
        add("hover_command", "1", ends, None, 0.03, _THROTTLE)
        if "voltage" in names:
            add("voltage_exponent", "1", _plain(found, "voltage"), 1.0, 0.2, "a whole battery")
    for axis, (name, flight) in enumerate(
        (("inertia_x", _TURNS), ("inertia_y", _TURNS), ("inertia_z", _YAW))
    ):
        if name in names:
            known = float(vehicle.inertia[axis, axis])
            ends = _factor(found, name, known)
            add(name, "kg m^2", ends, known, 0.15 * ends[0], flight)
    if "spin_up" in names:
        known = float(np.mean([each.inertia for each in vehicle.rotors]))
        one = with_quantities(vehicle, fit.named | {"spin_up": 1.0})
        scale = float(np.mean([each.inertia for each in one.rotors]))
        ends = _plain(found, "spin_up", scale)
        add("rotor_inertia", "kg m^2", ends, known or None, 0.3 * abs(scale) * 0.1, _YAW)
        for axis, name in enumerate(("center_x", "center_y")):
            at = vehicle.p_BoBcm_B[axis]
            value, low, high = _plain(found, name, half)
            ends = (at + value, at + low, at + high)
            add(name, "m", ends, at, 0.02 * half, "a steady hover of 10 s")
        add("turn_imbalance", "1", _plain(found, "turn"), 0.0, 0.03, "a steady hover of 10 s")
        add("gyro_delay", "s", _plain(found, "gyro_delay"), None, 0.003, _TURNS)
    if "drag" in names:
        drag = _plain(found, "drag")
        add("drag", "1/s", drag, None, max(0.02, 0.25 * abs(drag[0])), _FAST)
        add("climb_drag", "1/s", _plain(found, "climb_drag"), None, 0.05, _FAST)
    return rows


def _verdict(width: float, limit: float) -> str:
    return WELL if width <= limit else ROUGHLY if width <= THREEFOLD * limit else NOT


def _factor(found: Found, name: str, described: float) -> tuple[float, float, float]:
    value, width = found.fit.value(name), found.quantile * found.fit.deviation(name)
    ends = [described * math.exp(each) for each in (value, value - width, value + width)]
    return ends[0], ends[1], ends[2]


def _plain(found: Found, name: str, scale: float = 1.0) -> tuple[float, float, float]:
    value, width = found.fit.value(name), found.quantile * found.fit.deviation(name)
    return scale * value, scale * value - abs(scale) * width, scale * value + abs(scale) * width


def _together(found: Found, described: float) -> tuple[float, float, float]:
    """Return lag and delay in all, which many flights know better than either [s]."""
    fit = found.fit
    lag = described * math.exp(fit.value("lag"))
    slope = np.zeros(len(fit.names))
    slope[fit.names.index("lag")] = lag
    slope[fit.names.index("delay")] = 1.0
    width = found.quantile * math.sqrt(slope @ fit.covariance @ slope)
    value = lag + fit.value("delay")
    return value, value - width, value + width


def thrust_at(found: Found, command: float) -> tuple[float, float, float]:
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


def hover_command(found: Found) -> tuple[float, float, float]:
    """Return the command at which thrust is the weight, and its interval.

    Where the curve comes to the weight for good; that of thrust over its slope is the interval.
    """
    grid = np.linspace(0.02, 1.0, 491)
    thrust = np.array([thrust_at(found, command)[0] for command in grid])
    below = np.flatnonzero(thrust < 1.0)
    place = min(int(below[-1]) + 1 if len(below) else 0, len(grid) - 1)
    value, low, high = thrust_at(found, grid[place])
    slope = max(0.1, float(np.gradient(thrust, grid)[place]))
    at = float(grid[place]) + (1.0 - value) / slope if len(below) else float(grid[0])
    width = 0.5 * (high - low) / slope
    return at, at - width, at + width


def told_apart(found: Found) -> str:
    """Return whether lag and delay can be told apart, and whether the lag is one number."""
    if not found.fast:
        return "nothing is said of lag and delay"
    lag, low, high = _factor(found, "lag", found.vehicle.rotor_lag)
    alone = 0.5 * (high - low)
    _, first, last = _together(found, found.vehicle.rotor_lag)
    if found.apart:
        one, _, other, _ = found.apart
        known = found.vehicle.rotor_lag
        return (
            f"thrust shows a lag of {1e3 * known * math.exp(one):.1f} ms and turning one of "
            f"{1e3 * known * math.exp(other):.1f} ms: more apart than chance has it, so the model "
            "is not exact; the interval holds both"
        )
    if alone > TOLD_APART * lag or 0.5 * (last - first) < 0.5 * alone:
        return "lag and delay cannot be told apart: take lag_with_delay"
    return "lag and delay are told apart"


def whiteness(fit: Fit, period: float) -> np.ndarray:
    """Return the autocorrelations (channels, lags) of the errors of prediction up to a second."""
    many = min(round(WHITE_SPAN / period), len(fit.innovations) // 4)
    centred = fit.innovations - fit.innovations.mean(axis=0)
    power = (centred**2).sum(axis=0)
    return np.array(
        [(centred[k:] * centred[:-k]).sum(axis=0) / power for k in range(1, many + 1)]
    ).T


def coloured_share(correlations: np.ndarray, many: int) -> float:
    """Return the share of autocorrelations beyond their bound of 95 %; 0.05 for white errors."""
    return float((np.abs(correlations) > 1.96 / math.sqrt(many)).mean())


def noise_densities(found: Found) -> tuple[float, float]:
    """Return the noise of gyro [rad/s/√Hz] and accelerometer [m/s²/√Hz] at the fastest half.

    It is the spread of second differences, which leave of a flight's motion next to nothing.
    """
    gyro, force = [], []
    for flight in found.flights:
        for run in flight.pieces(1.0):
            bend = math.sqrt(6.0)
            gyro.append(np.median(np.abs(np.diff(run.gyro, 2, axis=0))) / 0.6745 / bend)
            force.append(np.median(np.abs(np.diff(run.force, 2, axis=0))) / 0.6745 / bend)
    rate = found.flights[0].rate
    return float(np.mean(gyro)) / math.sqrt(0.5 * rate), float(np.mean(force)) / math.sqrt(
        0.5 * rate
    )


def predicted(found: Found, ahead: float = 0.2) -> Prediction:
    """Return how well what was found predicts flights, from each instant onwards.

    Args:
        found: from other flights, or another part of them.
        ahead: how far angular velocity is predicted [s].
    """
    force, mean, turn, held = [], [], [], []
    for flight in found.flights:
        for run in flight.pieces(ahead + 0.5):
            voltage = 1.0 if run.voltage is None else float(np.mean(run.voltage))
            piece = make_piece(run, voltage, found.vehicle)
            rows = model_rows(found.vehicle, found.fit.named, piece)
            skip = round(0.3 / (piece.period * piece.every * piece.block))
            force.append((piece.force - rows[:, 3:])[skip:, 2])
            mean.append((piece.force[:, 2] - piece.force[:, 2].mean())[skip:])
            period = piece.period * piece.every * piece.block
            many = max(1, round(ahead / period))
            went = np.cumsum(piece.turn, axis=0) * period
            should = np.cumsum(rows[:, :3], axis=0) * period
            change = went[many:] - went[:-many]
            turn.append((change - should[many:] + should[:-many])[skip:])
            held.append(change[skip:])

    def rms(parts: list[np.ndarray]) -> float:
        return float(np.sqrt(np.mean(np.concatenate([part.ravel() for part in parts]) ** 2)))

    return Prediction(rms(force), rms(mean), rms(turn), rms(held), ahead)


def identified_vehicle(found: Found) -> Vehicle:
    """Return the vehicle that was found; a log of shares knows no speed of a rotor.

    There the described largest speed stays, and the motor constant is such that thrust at it is
    that of the full command.
    """
    values = found.fit.named
    if not found.fast:
        values |= {"lag": 0.0}
    for name in ("drag", "climb_drag"):
        if name in values:
            values[name] = max(0.0, values[name])
    if "spin_up" in values:
        values["spin_up"] = max(0.0, values["spin_up"])
    if found.flights[0].kind == SHARE:
        values["thrust"] = math.log(
            max(thrust_at(found, 1.0)[0], 0.1) / found.vehicle.thrust_to_weight
        )
    return with_quantities(found.vehicle, values)
