"""All that is said of an identification: numbers, how far to trust them, and the sidecar.

The sidecar is the file of rotors and body that any `--model` takes.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np
import yaml

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
from workbench.plant.rotors import Rotor
from workbench.plant.vehicle import Vehicle

ABOUT_Z = ("inertia_z", "rotor_inertia")


def sidecar_text(vehicle: Vehicle, rows: Sequence[Row], logs: Sequence[Path]) -> str:
    """Return the sidecar's YAML.

    Args:
        vehicle: that was identified.
        rows: with the intervals.
        logs: that it comes from, for its head.
    """
    inertia = vehicle.inertia
    products = (inertia[0, 1], inertia[0, 2], inertia[1, 2])
    scale = yaw_scale(vehicle)
    moments = (inertia[0, 0], inertia[1, 1], scale * inertia[2, 2])
    content = {
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
        }
    names = ", ".join(log.name for log in logs)
    head = (
        f"# {vehicle.name} as identified by `workbench identify` from {names}.\n"
        f"# For any command: --model {vehicle.source.name} --rotors THIS_FILE\n"
    )
    return head + yaml.safe_dump(content, sort_keys=False, default_flow_style=None, width=100)


def yaw_scale(vehicle: Vehicle) -> float:
    """Return what the inertia about z is to be taken times, with all that turns about z.

    A log has the inertia about z over the moment constant alone. Where the described constant makes
    it more than those about x and y together, which no body's is, both are smaller.
    """
    inertia = vehicle.inertia
    return float(min(1.0, (inertia[0, 0] + inertia[1, 1]) / inertia[2, 2]))


def _rotor(rotor: Rotor, base_link: str, scale: float) -> dict[str, Any]:
    """Return a rotor as `plant.rotor_sources.sidecar_file` has it."""
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
