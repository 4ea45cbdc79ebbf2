"""The report on an identification: numbers, their confidence, and the sidecar.

The sidecar has rotors and body, and any command takes it with `--rotors`.
"""

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from workbench.extras.flightdata.identify.fit import Fit
from workbench.extras.flightdata.identify.flight import IdentificationFlight
from workbench.extras.flightdata.identify.flight_piece import make_piece
from workbench.extras.flightdata.identify.held_back import (
    MIN_LEVEL_CHANGE_M_S2,
    MIN_THRUST_CHANGE_M_S2,
    HeldBackPrediction,
    held_back_prediction,
)
from workbench.extras.flightdata.identify.identified_number import (
    DRIFT_TEXT,
    FAST_LEVEL_FLIGHT_TEXT,
    THROTTLE_DOUBLETS_TEXT,
    VOLTAGE_EXPONENT,
    IdentifiedNumber,
    identified_rows,
    is_lag_separable,
    refuted_parts,
    thrust_to_weight_at,
    validated_numbers,
)
from workbench.extras.flightdata.identify.identified_sidecar import sidecar_text, yaw_scale
from workbench.extras.flightdata.identify.quantities import with_quantities
from workbench.extras.flightdata.identify.search import (
    MIN_FREE_RUN_S,
    IdentificationResult,
    identify,
)
from workbench.logs.motor_commands import FULL_SHARE_COMMANDS
from workbench.plant.vehicle import Vehicle

MAX_AUTOCORRELATION_LAG_S = 1.0
"""Longest lag of the autocorrelation of prediction errors [s]."""


def whiteness(fit: Fit, period: float) -> np.ndarray:
    """Return the autocorrelations (channels, lags) of the errors of prediction up to a second."""
    many = min(round(MAX_AUTOCORRELATION_LAG_S / period), len(fit.innovations) // 4)
    centred = fit.innovations - fit.innovations.mean(axis=0)
    power = (centred**2).sum(axis=0)
    return np.array(
        [(centred[k:] * centred[:-k]).sum(axis=0) / power for k in range(1, many + 1)]
    ).T


def noise_densities(found: IdentificationResult) -> tuple[float, float]:
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


def identified_vehicle(found: IdentificationResult) -> Vehicle:
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
    if found.flights[0].kind == FULL_SHARE_COMMANDS:
        values["thrust"] = math.log(
            max(thrust_to_weight_at(found, 1.0)[0], 0.1) / found.vehicle.thrust_to_weight
        )
    return with_quantities(found.vehicle, values)


@dataclass(frozen=True)
class IdentificationReport:
    """The report on an identification.

    Attributes:
        found: the result.
        rows: of the table.
        correlations: autocorrelations of the errors of prediction, see `whiteness`.
        noise: densities of gyro [rad/s/√Hz] and accelerometer [m/s²/√Hz].
        held_back: prediction of the last fifth by a search without it; None without one.
        sidecar: its text.
    """

    found: IdentificationResult
    rows: list[IdentifiedNumber]
    correlations: np.ndarray
    noise: tuple[float, float]
    held_back: HeldBackPrediction | None
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
        said = [is_lag_separable(self.found)] if self.found.fast else []
        said += [f"no {what}: {why}" for what, why in self.found.refused.items()]
        if any(row.name == VOLTAGE_EXPONENT for row in self.rows):
            said.append(DRIFT_TEXT)
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
            if "force" in of.quiet:
                said.append(
                    f"the part held back changes thrust by {of.constant_force:.2g} m/s² RMS: less "
                    f"than {MIN_THRUST_CHANGE_M_S2:g} m/s² is not enough motion to judge thrust "
                    f"by; fly {THROTTLE_DOUBLETS_TEXT}, to the end of the log"
                )
            if "level" in of.quiet and any(row.name == "drag" for row in self.rows):
                said.append(
                    f"the part held back changes level force by {of.constant_level:.2g} m/s² RMS: "
                    f"less than {MIN_LEVEL_CHANGE_M_S2:g} m/s² is not enough motion to judge drag "
                    f"by; fly {FAST_LEVEL_FLIGHT_TEXT}, to the end of the log"
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
            said.append(
                "the search was stopped, or no step made errors smaller although one should: its "
                "step is part of the intervals; use the numbers as a first guess"
            )
        return said

    def as_dictionary(self) -> dict[str, Any]:
        """Return the report for JSON."""
        return {
            "vehicle": self.vehicle.name,
            "seconds": self.seconds,
            "complete": self.found.fit.complete,
            "rows": self.rows,
            "refused": self.found.refused,
            "lag_and_delay": is_lag_separable(self.found),
            "noise": {"gyro": self.noise[0], "accelerometer": self.noise[1]},
            "coloured": self.coloured,
            "held_back": self.held_back,
        }


def make_report(
    vehicle: Vehicle,
    flights: Sequence[IdentificationFlight],
    logs: Sequence[Path | str],
    tell: Callable[[float], None] = lambda share: None,
    stopped: Callable[[], bool] = lambda: False,
) -> IdentificationReport:
    """Identify a vehicle, and return the report.

    Arguments and errors are those of `identify`; `logs` are the sources of the flights.
    """
    found = identify(vehicle, flights, lambda share: tell(0.6 * share), stopped)
    rows = identified_rows(found)
    piece = make_piece(found.flights[0].pieces(MIN_FREE_RUN_S)[0], found.vehicle)
    held_back = held_back_prediction(found, lambda share: tell(0.6 + 0.4 * share), stopped)
    return IdentificationReport(
        found=found,
        rows=validated_numbers(rows, held_back),
        correlations=whiteness(found.fit, piece.row),
        noise=noise_densities(found),
        held_back=held_back,
        sidecar=sidecar_text(identified_vehicle(found), rows, [Path(log) for log in logs]),
    )
