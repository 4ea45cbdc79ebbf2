"""All that is said of an identification: numbers, how far to trust them, and the sidecar."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np

from workbench.common.errors import WorkbenchError
from workbench.design.identify.fit import make_piece
from workbench.design.identify.flight import Flight
from workbench.design.identify.result import (
    Prediction,
    Row,
    coloured_share,
    identified_vehicle,
    noise_densities,
    predicted,
    rows_of,
    told_apart,
    whiteness,
)
from workbench.design.identify.search import SHORTEST, Found, identify
from workbench.design.identify.sidecar import sidecar_text, yaw_scale
from workbench.plant.vehicle import Vehicle

HELD_BACK = 0.2
"""Last share of a flight that a second search does not see."""


@dataclass(frozen=True)
class Report:
    """What is said of an identification.

    Attributes:
        vehicle: as it is described.
        found: what was found.
        rows: in numbers that people know.
        seconds: of free flight.
        correlations: autocorrelations of the errors of prediction, see `whiteness`.
        coloured: share of them beyond their bound.
        noise: densities of gyro [rad/s/√Hz] and accelerometer [m/s²/√Hz].
        held_back: what a search without the last fifth predicts of it; None without one.
        sidecar: the file's text.
    """

    vehicle: Vehicle
    found: Found
    rows: list[Row]
    seconds: float
    correlations: np.ndarray
    coloured: float
    noise: tuple[float, float]
    held_back: Prediction | None
    sidecar: str

    @property
    def sentences(self) -> list[str]:
        """What is to be known beside the table."""
        said = [told_apart(self.found)] if self.found.fast else []
        said += [f"no {what}: {why}" for what, why in self.found.refused.items()]
        if any(row.name.startswith("inertia") for row in self.rows):
            said.append(
                f"inertias hold for a mass of {self.vehicle.mass:.4g} kg and the described arms: "
                "they go with both, and that about z with the described moment constant"
            )
            if (scale := yaw_scale(identified_vehicle(self.found))) < 1.0:
                said.append(
                    "no body has more about z than about x and y together: the sidecar has "
                    f"{scale:.3g} times the moment constant, and all that turns about z"
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
                f"held back by itself: thrust within {of.force:.2g} m/s² RMS (unchanged "
                f"{of.constant_force:.2g})"
                + (
                    f", angular velocity {of.ahead:g} s ahead within {of.turn:.2g} rad/s "
                    f"(unchanged {of.constant_turn:.2g})"
                    if any(row.name.startswith("inertia") for row in self.rows)
                    else ""
                )
            )
        if not self.found.fit.complete:
            said.append("the search did not come to its end: take the numbers for a first guess")
        return said

    def as_dictionary(self) -> dict[str, Any]:
        """Return it for JSON."""
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
    logs: Sequence[Path],
    tell: Callable[[float], None] = lambda share: None,
    stopped: Callable[[], bool] = lambda: False,
) -> Report:
    """Identify, and say how far to trust it.

    Arguments and errors are those of `identify`; `logs` are where the flights come from.
    """
    found = identify(vehicle, flights, lambda share: tell(0.6 * share), stopped)
    rows = rows_of(found)
    run = found.flights[0].pieces(SHORTEST)[0]
    voltage = 1.0 if run.voltage is None else float(np.mean(run.voltage))
    piece = make_piece(run, voltage, found.vehicle)
    correlations = whiteness(found.fit, piece.period * piece.every * piece.block)
    return Report(
        vehicle=vehicle,
        found=found,
        rows=rows,
        seconds=found.seconds,
        correlations=correlations,
        coloured=coloured_share(correlations, len(found.fit.innovations)),
        noise=noise_densities(found),
        held_back=_held_back(found, lambda share: tell(0.6 + 0.4 * share), stopped),
        sidecar=sidecar_text(identified_vehicle(found), rows, logs),
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
