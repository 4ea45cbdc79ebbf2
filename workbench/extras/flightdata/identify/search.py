"""The whole search: which numbers a flight can be asked for, and what it says of each."""

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

import numpy as np
from scipy.stats import t as student

from workbench.common.errors import WorkbenchError
from workbench.extras.flightdata.identify.fit import FIT_CHANNELS, Fit, Fitter
from workbench.extras.flightdata.identify.flight import (
    MIN_COMMAND_RATE_HZ,
    IdentificationFlight,
    check_finite,
)
from workbench.extras.flightdata.identify.flight_piece import make_piece
from workbench.extras.flightdata.identify.quantities import (
    IdentifiedQuantity,
    identifiable_quantities,
)
from workbench.plant.vehicle import Vehicle

MIN_FREE_RUN_S = 3.0
"""Run of free flight that counts [s]."""
MIN_FREE_FLIGHT_S = 8.0
"""Shortest total time of free flight [s]."""
INTERVAL_CONFIDENCE = 0.95
LAG_RATIO_QUANTITY = IdentifiedQuantity("lag_turn", 0.0, 0.01, math.inf, "turn")
"""Logarithm of the ratio of the lag in rotation to that of thrust."""
BENCH_FORCE_M_S2, BENCH_RATE_RAD_S = 0.25, 0.05
"""Deviations of specific force [m/s²] and angular velocity [rad/s] below which nothing flies."""
BENCH_THRUST_M_S2 = 0.5
"""Deviation of the thrust over mass that commands should have made meanwhile [m/s²]."""


@dataclass(frozen=True)
class IdentificationResult:
    """What flights say of their vehicle.

    Attributes:
        vehicle: as it is described.
        flights: that were used.
        fit: the numbers with their covariance.
        apart: what thrust and turning say of the lag apart from each other, with deviations, as
            logarithms of factors; None where they agree, or only one of them was there.
        refused: what was not looked for, and why.
        seconds: of free flight.
    """

    vehicle: Vehicle
    flights: tuple[IdentificationFlight, ...]
    fit: Fit
    apart: tuple[float, float, float, float] | None
    refused: dict[str, str]
    seconds: float

    @property
    def fast(self) -> bool:
        """Whether the logs are fast enough to tell of lag and inertia."""
        return "turn_x" in self.fit.channels

    @property
    def quantile(self) -> float:
        """Deviations to either side that an interval of 95 % takes."""
        return float(student.ppf(0.5 + 0.5 * INTERVAL_CONFIDENCE, self.fit.freedom))


def identify(
    vehicle: Vehicle,
    flights: Sequence[IdentificationFlight],
    tell: Callable[[float], None] = lambda share: None,
    stopped: Callable[[], bool] = lambda: False,
) -> IdentificationResult:
    """Return what flights say of their vehicle.

    Args:
        vehicle: as it is described: geometry and mass are taken from it, the rest is where the
            search begins.
        flights: with the same kind of commands.
        tell: takes the share that is done.
        stopped: whether to end with the best so far.

    Raises:
        WorkbenchError: if they can tell nothing, with the reason.
    """
    for flight in flights:
        check_finite(flight)
        refuse_bench(flight)
    runs = [run for flight in flights for run in flight.pieces(MIN_FREE_RUN_S)]
    seconds = sum(len(run.time) * run.period for run in runs)
    names = ", ".join(flight.name for flight in flights)
    if seconds < MIN_FREE_FLIGHT_S:
        raise WorkbenchError(
            f"{names}: has {seconds:.1f} s of free flight in runs of {MIN_FREE_RUN_S:g} s and "
            "more: "
            f"{MIN_FREE_FLIGHT_S:g} s are the least; fly a minute, `workbench excite` plans it"
        )
    first = flights[0]
    mean_voltage = float(np.mean(np.concatenate([_mean_run_voltage(run) for run in runs])))
    pieces = [make_piece(run, vehicle, mean_voltage) for run in runs]
    channels, refused = _channels(flights)
    needs = {"force"} | {each.split("_")[0] for each in channels}
    needs |= {"climb"} if "level" in needs else set()
    asked = [each for each in identifiable_quantities(first, vehicle) if each.needs in needs]

    def fitter(
        quantities: Sequence[IdentifiedQuantity], fixed: dict[str, float], a: float, b: float
    ) -> Fitter:
        return Fitter(
            vehicle, pieces, quantities, channels, fixed,
            lambda share: tell(a + (b - a) * share), stopped,
        )  # fmt: skip

    both = "turn_x" in channels
    if not both or stopped():
        fit = fitter(asked, {}, 0.0, 1.0).fit()
        return IdentificationResult(vehicle, tuple(flights), fit, None, refused, seconds)
    wide = fitter([*asked, LAG_RATIO_QUANTITY], {}, 0.0, 0.6).fit()
    apart, deviation = wide.value(LAG_RATIO_QUANTITY.name), wide.deviation(LAG_RATIO_QUANTITY.name)
    start = wide.values[:-1]
    quantile = student.ppf(0.5 + 0.5 * INTERVAL_CONFIDENCE, wide.freedom)
    if abs(apart) <= quantile * deviation or stopped():
        fit = fitter(asked, {}, 0.6, 1.0).fit(start)
        return IdentificationResult(vehicle, tuple(flights), fit, None, refused, seconds)
    lag, spread, each = combined_lag(wide)
    rest = [quantity for quantity in asked if quantity.name != "lag"]
    fit = fitter(rest, {"lag": lag}, 0.6, 0.8).fit(start[1:])
    moved = fitter(rest, {"lag": lag + spread}, 0.8, 1.0).fit(fit.values)
    return IdentificationResult(
        vehicle, tuple(flights), _with_lag(fit, moved, lag, spread), each, refused, seconds
    )


def combined_lag(wide: Fit) -> tuple[float, float, tuple[float, float, float, float]]:
    """Return the lag that two measurements of it give which do not agree, and its deviation.

    Thrust and turning are taken for two draws around one number, with the spread that they show
    (random effects: DerSimonian and Laird, "Meta-analysis in clinical trials", 1986).

    Returns:
        Logarithms of factors: the lag, its deviation, and those of thrust and of turning apart.
    """
    i, j = wide.names.index("lag"), wide.names.index(LAG_RATIO_QUANTITY.name)
    cover = wide.covariance
    thrust, turning = wide.values[i], wide.values[i] + wide.values[j]
    one = cover[i, i]
    other = cover[i, i] + cover[j, j] + 2.0 * cover[i, j]
    between = max(0.0, 0.5 * (wide.values[j] ** 2 - cover[j, j]))
    weights = np.array([1.0 / (one + between), 1.0 / (other + between)])
    lag = float(weights @ (thrust, turning) / weights.sum())
    spread = float(np.sqrt(1.0 / weights.sum()))
    return lag, spread, (thrust, math.sqrt(one), turning, math.sqrt(other))


def _with_lag(fit: Fit, moved: Fit, lag: float, spread: float) -> Fit:
    """Return a fit at a fixed lag with the lag's own spread in all numbers.

    Args:
        fit: at the lag.
        moved: at the lag and a deviation.
        lag: logarithm of its factor.
        spread: its deviation.
    """
    along = np.concatenate(([spread], moved.values - fit.values))
    covariance = np.outer(along, along)
    covariance[1:, 1:] += fit.covariance
    return replace(
        fit,
        names=("lag", *fit.names),
        values=np.concatenate(([lag], fit.values)),
        covariance=covariance,
    )


def _mean_run_voltage(run: IdentificationFlight) -> np.ndarray:
    return np.ones(len(run.time)) if run.voltage is None else run.voltage


def _channels(flights: Sequence[IdentificationFlight]) -> tuple[list[str], dict[str, str]]:
    """Return what is heard of flights, and what is not asked for, with the reason."""
    refused: dict[str, str] = {}
    rate = min(min(each.rate, each.command_rate or each.rate) for each in flights)
    channels = list(FIT_CHANNELS)
    if rate < MIN_COMMAND_RATE_HZ:
        channels = [each for each in channels if not each.startswith("turn")]
        refused["rotor lag, inertia, centre of mass, gyro delay"] = (
            f"{rate:.0f} samples a second: a rate loop closes faster than that, so commands are "
            f"aliased; log gyro and motors at {MIN_COMMAND_RATE_HZ:.0f} Hz or more, 500 if you can"
        )
    if any(each.velocity is None for each in flights):
        channels = [each for each in channels if not each.startswith("level")]
        refused["drag"] = (
            "the log has no velocity: fly with motion capture, GPS or optical flow, and log the "
            "velocity and the attitude"
        )
    return channels, refused


def refuse_bench(flight: IdentificationFlight) -> None:
    """Refuse a log in which motors run and nothing moves.

    Raises:
        WorkbenchError: if the drone was tied down, or without propellers.
    """
    runs = flight.pieces(MIN_FREE_RUN_S)
    if not runs:
        return
    force = np.concatenate([run.force[:, 2] for run in runs])
    gyro = np.concatenate([run.gyro for run in runs])
    commands = np.concatenate([run.commands for run in runs]).mean(axis=1)
    share = commands / max(float(np.mean(commands)), 1e-12)
    thrust = 9.8 * float(np.std(share**2))
    still = (
        float(np.std(force)) < BENCH_FORCE_M_S2 and float(gyro.std(axis=0).max()) < BENCH_RATE_RAD_S
    )
    if still and thrust > BENCH_THRUST_M_S2:
        raise WorkbenchError(
            f"{flight.name}: the motors' commands change thrust by {thrust:.1f} m/s² and nothing "
            "moves: this is a bench log, tied down or without propellers; identify needs a flight"
        )
