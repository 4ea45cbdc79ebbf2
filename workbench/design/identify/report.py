"""The report on an identification: numbers, their confidence, and the sidecar.

The sidecar has rotors and body, and any command takes it with `--rotors`.
"""

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np
import yaml

from workbench.common.errors import WorkbenchError
from workbench.design.identify.fit import Fit, make_piece, model_rows
from workbench.design.identify.flight import SHARE, Flight
from workbench.design.identify.quantities import with_quantities
from workbench.design.identify.search import SHORTEST, Found, identify
from workbench.plant.gravity import GRAVITY
from workbench.plant.rotors import Rotor
from workbench.plant.vehicle import Vehicle

WELL, ROUGHLY, NOT = "well", "roughly", "not determined"
"""Verdicts on a quantity, from its interval."""
REFUTED = "refuted by the validation"
"""Verdict on a quantity of a model that predicts a part of the flight that it has not seen no
better than no model does."""
LONGER = "for longer, so that a part of the flight is left to validate with"
"""Flight that helps where no part could be held back."""
THREEFOLD = 3.0
"""Factor on the uncertainty of a well known quantity up to which it is roughly known."""
TOLD_APART = 0.3
"""Largest relative half width of the interval of the lag, to separate it from the delay."""
WHITE_SPAN = 1.0
"""Longest lag of the autocorrelation of prediction errors [s]."""
AHEAD = 0.2
"""Horizon of predictions of the angular velocity [s]."""
HELD_BACK = 0.2
"""Last share of a flight, held back from a second search."""
ABOUT_Z = ("inertia_z", "rotor_inertia")
"""Rows of quantities about z."""


@dataclass(frozen=True)
class Row:
    """An identified number.

    Attributes:
        name: its own.
        unit: SI.
        value: of it.
        low: lower end of its 95 % interval.
        high: its upper end.
        described: its value in the description, or None.
        verdict: `WELL`, `ROUGHLY`, `NOT` or `REFUTED`.
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


@dataclass(frozen=True)
class Prediction:
    """The errors of a model that predicts the last fifth of the flights, held back from its search.

    Attributes:
        force: RMS error of specific force along z [m/s²].
        constant_force: the same for a prediction by its mean.
        level: RMS error of specific force along x and y [m/s²].
        constant_level: the same for a prediction by their means.
        turn: RMS error of angular velocity after `ahead` [rad/s].
        constant_turn: the same for a prediction by a constant rate.
        ahead: [s].
    """

    force: float
    constant_force: float
    level: float
    constant_level: float
    turn: float
    constant_turn: float
    ahead: float

    @property
    def refuted(self) -> frozenset[str]:
        """What the model predicts no better than a constant does: force, level, turn."""
        pairs = {
            "force": (self.force, self.constant_force),
            "level": (self.level, self.constant_level),
            "turn": (self.turn, self.constant_turn),
        }
        # Not less, rather than more: an error that is no number refutes, too.
        return frozenset(name for name, (error, constant) in pairs.items() if not error < constant)


_SHOWN_BY = {
    "force": (
        *("rotor_lag", "delay", "lag_with_delay", "motor_constant", "thrust_to_weight"),
        *("hover_command", "voltage_exponent", "climb_drag"),
    ),
    "level": ("drag",),
    "turn": (
        *("rotor_lag", "delay", "lag_with_delay", "inertia_x", "inertia_y", "inertia_z"),
        *("rotor_inertia", "center_x", "center_y", "turn_imbalance", "gyro_delay"),
    ),
}
"""Rows that each part of the validation is about."""
_THROTTLE = "throttle doublets of 0.2 to 1 s, ± a quarter of hover thrust"
_TURNS = "quick roll and pitch doublets of 0.1 to 0.5 s"
_YAW = "yaw rate doublets of 0.5 to 2 s, as large as allowed"
_FAST = "level flight to and fro at 2 m/s and more, with velocity measured"


def rows_of(found: Found) -> list[Row]:
    """Return the results in the order of the table."""
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


def validated(rows: Sequence[Row], held_back: Prediction | None) -> list[Row]:
    """Return rows with the verdicts that the validation allows.

    Args:
        rows: with verdicts from their intervals.
        held_back: the validation; None without one, when no row is well known.
    """
    if held_back is None:
        return [
            replace(row, verdict=ROUGHLY, flight=LONGER) if row.verdict == WELL else row
            for row in rows
        ]
    found = []
    refuted, judged = refuted_parts(rows, held_back), judged_parts(rows)
    for row in rows:
        parts = {part for part in judged if row.name in _SHOWN_BY[part]}
        if parts and parts <= refuted:
            row = replace(row, verdict=REFUTED)
        elif parts & refuted and row.verdict == WELL:  # the lag, of which the other part is right
            row = replace(row, verdict=ROUGHLY)
        found.append(row)
    return found


def judged_parts(rows: Sequence[Row]) -> frozenset[str]:
    """Return the parts of the validation that count: rotation only with inertias."""
    turns = any(row.name.startswith("inertia") for row in rows)
    return frozenset(part for part in _SHOWN_BY if turns or part != "turn")


def refuted_parts(rows: Sequence[Row], held_back: Prediction) -> frozenset[str]:
    """Return the refuted parts among those that count."""
    return held_back.refuted & judged_parts(rows)


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

    This is where the curve finally crosses the weight. The interval is that of thrust over the
    slope of the curve.
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
    """Return whether lag and delay are separable, and whether the lag is one number."""
    if not found.fast:
        return "lag and delay are not judged"
    lag, low, high = _factor(found, "lag", found.vehicle.rotor_lag)
    alone = 0.5 * (high - low)
    _, first, last = _together(found, found.vehicle.rotor_lag)
    if found.apart:
        one, _, other, _ = found.apart
        known = found.vehicle.rotor_lag
        return (
            f"thrust shows a lag of {1e3 * known * math.exp(one):.1f} ms and turning one of "
            f"{1e3 * known * math.exp(other):.1f} ms: this difference is larger than chance "
            "explains, so the model is not exact; the interval includes both"
        )
    if alone > TOLD_APART * lag or 0.5 * (last - first) < 0.5 * alone:
        return "lag and delay cannot be separated: use lag_with_delay"
    return "lag and delay are separated"


def whiteness(fit: Fit, period: float) -> np.ndarray:
    """Return the autocorrelations (channels, lags) of the errors of prediction up to a second."""
    many = min(round(WHITE_SPAN / period), len(fit.innovations) // 4)
    centred = fit.innovations - fit.innovations.mean(axis=0)
    power = (centred**2).sum(axis=0)
    return np.array(
        [(centred[k:] * centred[:-k]).sum(axis=0) / power for k in range(1, many + 1)]
    ).T


def noise_densities(found: Found) -> tuple[float, float]:
    """Return the noise of gyro [rad/s/√Hz] and accelerometer [m/s²/√Hz] at the fastest half.

    It is the spread of second differences, which remove almost all of the motion in a flight.
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


def predicted(found: Found) -> Prediction:
    """Return the errors of predictions of flights by a result, from each instant onwards.

    Args:
        found: result from other flights, or another part of them.
    """
    force, mean, level, means, turn, held = [], [], [], [], [], []
    for flight in found.flights:
        for run in flight.pieces(AHEAD + 0.5):
            piece = make_piece(run, found.vehicle)
            rows = model_rows(found.vehicle, found.fit.named, piece)
            skip = round(0.3 / piece.row)
            error, change = piece.force - rows[:, 3:], piece.force - piece.force.mean(axis=0)
            force.append(error[skip:, 2])
            mean.append(change[skip:, 2])
            level.append(error[skip:, :2])
            means.append(change[skip:, :2])
            many = max(1, round(AHEAD / piece.row))
            went = np.cumsum(piece.turn, axis=0) * piece.row
            should = np.cumsum(rows[:, :3], axis=0) * piece.row
            change = went[many:] - went[:-many]
            turn.append((change - should[many:] + should[:-many])[skip:])
            held.append(change[skip:])

    def rms(parts: list[np.ndarray]) -> float:
        return float(np.sqrt(np.mean(np.concatenate([part.ravel() for part in parts]) ** 2)))

    return Prediction(rms(force), rms(mean), rms(level), rms(means), rms(turn), rms(held), AHEAD)


def identified_vehicle(found: Found) -> Vehicle:
    """Return the identified vehicle; a log of shares has no rotor speeds.

    In that case the described largest speed stays, and the motor constant is chosen for the thrust
    of the full command at it.
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


def sidecar_text(vehicle: Vehicle, rows: Sequence[Row], logs: Sequence[Path]) -> str:
    """Return the YAML of the sidecar.

    Args:
        vehicle: the identified one.
        rows: with the intervals.
        logs: used, for its head.
    """
    inertia = vehicle.inertia
    products = (inertia[0, 1], inertia[0, 2], inertia[1, 2])
    scale = yaw_scale(vehicle)
    moments = (inertia[0, 0], inertia[1, 1], scale * inertia[2, 2])
    content: dict[str, Any] = {
        "body": {
            "mass": vehicle.mass,
            "center_of_mass": [float(each) for each in vehicle.p_BoBcm_B],
            "inertia": [float(each) for each in (*moments, *products)],
        },
        "identified": [
            {
                "name": row.name,
                "unit": row.unit,
                "value": _short(part * row.value),
                "low": _short(part * row.low),
                "high": _short(part * row.high),
            }
            for row in rows
            for part in [scale if row.name in ABOUT_Z else 1.0]
        ],
        "rotors": [_rotor(rotor, vehicle.base_link, scale) for rotor in vehicle.rotors],
    }
    if vehicle.battery:
        pack = vehicle.battery
        content["battery"] = {
            "capacity": pack.capacity,
            "resistance": pack.resistance,
            "open_circuit_voltage": [list(point) for point in pack.open_circuit_voltage],
            **{
                name: value
                for name in ("hover_duration", "sag_compensation")
                if (value := getattr(pack, name)) is not None
            },
        }
    names = ", ".join(log.name for log in logs)
    head = (
        f"# {vehicle.name} as identified by `workbench identify` from {names}.\n"
        f"# For any command: --model {vehicle.source.name} --rotors THIS_FILE\n"
    )
    return head + yaml.safe_dump(content, sort_keys=False, default_flow_style=None, width=100)


def yaw_scale(vehicle: Vehicle) -> float:
    """Return the factor on the inertia about z, and on all other quantities about z.

    A log only yields the inertia about z over the moment constant. If with the described constant
    it exceeds those about x and y together, which is impossible, both are reduced.
    """
    inertia = vehicle.inertia
    return float(min(1.0, (inertia[0, 0] + inertia[1, 1]) / inertia[2, 2]))


def _rotor(rotor: Rotor, base_link: str, scale: float) -> dict[str, Any]:
    """Return a rotor as `plant.rotor_sources.sidecar` has it."""
    where: dict[str, Any] = {"name": rotor.name}
    direction = rotor.direction
    where["link"] = base_link
    where["position"] = [_short(each, 9) for each in rotor.p_BR]
    where["axis"] = [_short(each, 9) for each in rotor.axis_B]
    return where | {
        "direction": "ccw" if direction > 0 else "cw",
        "motor_constant": _short(rotor.motor_constant),
        "linear_motor_constant": _short(rotor.linear_motor_constant),
        "moment_constant": _short(scale * rotor.moment_constant),
        "time_constant_up": _short(rotor.time_constant_up),
        "time_constant_down": _short(rotor.time_constant_down),
        "max_rot_velocity": _short(rotor.max_rot_velocity),
        "rotor_drag_coefficient": _short(rotor.rotor_drag_coefficient),
        "rolling_moment_coefficient": _short(rotor.rolling_moment_coefficient),
        "inertia": _short(scale * rotor.inertia),
        "inflow_coefficient": _short(rotor.inflow_coefficient),
        "ground_effect_coefficient": _short(rotor.ground_effect_coefficient),
        "propeller_radius": _short(rotor.propeller_radius),
    }


def _short(value: float, digits: int = 6) -> float:
    return float(f"{value:.{digits}g}")


@dataclass(frozen=True)
class Report:
    """The report on an identification.

    Attributes:
        found: the result.
        rows: of the table.
        correlations: autocorrelations of the errors of prediction, see `whiteness`.
        noise: densities of gyro [rad/s/√Hz] and accelerometer [m/s²/√Hz].
        held_back: prediction of the last fifth by a search without it; None without one.
        sidecar: its text.
    """

    found: Found
    rows: list[Row]
    correlations: np.ndarray
    noise: tuple[float, float]
    held_back: Prediction | None
    sidecar: str

    @property
    def vehicle(self) -> Vehicle:
        """The described vehicle."""
        return self.found.vehicle

    @property
    def seconds(self) -> float:
        """Duration of free flight [s]."""
        return self.found.seconds

    @property
    def coloured(self) -> float:
        """Share of autocorrelations beyond their bound of 95 %; 0.05 for white errors."""
        bound = 1.96 / math.sqrt(len(self.found.fit.innovations))
        return float((np.abs(self.correlations) > bound).mean())

    @property
    def sentences(self) -> list[str]:
        """Remarks in addition to the table."""
        said = [told_apart(self.found)] if self.found.fast else []
        said += [f"no {what}: {why}" for what, why in self.found.refused.items()]
        if any(row.name.startswith("inertia") for row in self.rows):
            said.append(
                f"inertias are for a mass of {self.vehicle.mass:.4g} kg and the described arms: "
                "they scale with both, and that about z with the described moment constant"
            )
            if (scale := yaw_scale(identified_vehicle(self.found))) < 1.0:
                said.append(
                    "no body has a larger moment about z than about x and y together: the sidecar "
                    f"has {scale:.3g} times the moment constant, and all that turns about z"
                )
        said.append(
            f"noise: gyro {self.noise[0]:.2g} rad/s/√Hz, accelerometer {self.noise[1]:.2g} m/s²/√Hz"
        )
        said.append(
            f"errors of prediction: {100 * self.coloured:.0f} % of autocorrelations beyond their "
            "bound, 5 % if nothing is missing in the model"
        )
        if self.held_back:
            of = self.held_back
            said.append(
                f"validation: thrust within {of.force:.2g} m/s² RMS (unchanged "
                f"{of.constant_force:.2g})"
                + (
                    f", angular velocity {of.ahead:g} s ahead within {of.turn:.2g} rad/s "
                    f"(unchanged {of.constant_turn:.2g})"
                    if any(row.name.startswith("inertia") for row in self.rows)
                    else ""
                )
            )
            if refuted := refuted_parts(self.rows, of):
                names = {"force": "thrust", "level": "level force", "turn": "rotation"}
                said.append(
                    f"the model predicts {' and '.join(names[each] for each in sorted(refuted))} "
                    "of the part held back no better than a constant does: do not use the refuted "
                    "numbers; check units, axes and the order of the motors, and whether the "
                    "commands are those of the rotors"
                )
        if not self.found.fit.complete:
            said.append("the search did not finish: use the numbers as a first guess")
        return said

    def as_dictionary(self) -> dict[str, Any]:
        """Return the report for JSON."""
        return {
            "vehicle": self.vehicle.name,
            "seconds": self.seconds,
            "complete": self.found.fit.complete,
            "rows": self.rows,
            "refused": self.found.refused,
            "lag_and_delay": told_apart(self.found),
            "noise": {"gyro": self.noise[0], "accelerometer": self.noise[1]},
            "coloured": self.coloured,
            "held_back": self.held_back,
        }


def make_report(
    vehicle: Vehicle,
    flights: Sequence[Flight],
    logs: Sequence[Path | str],
    tell: Callable[[float], None] = lambda share: None,
    stopped: Callable[[], bool] = lambda: False,
) -> Report:
    """Identify a vehicle, and return the report.

    Arguments and errors are those of `identify`; `logs` are the sources of the flights.
    """
    found = identify(vehicle, flights, lambda share: tell(0.6 * share), stopped)
    rows = rows_of(found)
    piece = make_piece(found.flights[0].pieces(SHORTEST)[0], found.vehicle)
    held_back = _held_back(found, lambda share: tell(0.6 + 0.4 * share), stopped)
    return Report(
        found=found,
        rows=validated(rows, held_back),
        correlations=whiteness(found.fit, piece.row),
        noise=noise_densities(found),
        held_back=held_back,
        sidecar=sidecar_text(identified_vehicle(found), rows, [Path(log) for log in logs]),
    )


def _held_back(
    found: Found, tell: Callable[[float], None], stopped: Callable[[], bool]
) -> Prediction | None:
    """Return what a search without the last part of the flights predicts of it."""
    first, last = [], []
    for flight in found.flights:
        count = int(flight.good.sum())
        seen = np.cumsum(flight.good) <= (1.0 - HELD_BACK) * count
        first.append(replace(flight, good=flight.good & seen))
        last.append(replace(flight, good=flight.good & ~seen))
    if stopped():
        return None
    try:
        blind = identify(found.vehicle, first, tell, stopped)
    except WorkbenchError:  # what is left is too short to be identified from
        return None
    rest = replace(blind, flights=tuple(last))
    if stopped() or not any(flight.pieces(1.0) for flight in last):
        return None
    return predicted(rest)
