"""Differences between compiled flights and the full diagram.

Each vehicle flies with random gains, from half to twice its own, for 5 s after a random command of
up to 8 m/s. Every second flight starts thrown, turning and at any attitude. The limit is 0.001 m/s
and 0.005 rad/s at any time of any flight. Published vehicles are included if `../shared/models`
has them.

`python benchmarks/agreement.py --figure FILE.png` draws every flight.
"""

import argparse
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from matplotlib.figure import Figure

from workbench.design.rollout.agreement import Agreement, agreement, random_trials
from workbench.gains.gain_choice import flight_gains
from workbench.scenario.configured import configured_vehicle
from workbench.scenario.scenario import Scenario, VehicleConfig

ROOT = Path(__file__).resolve().parent.parent
DRONES, SHARED = ROOT / "tests/drones", ROOT / "../shared/models"
VEHICLES = {
    "dh_drone": VehicleConfig(),
    "coaxial_x8": VehicleConfig(str(DRONES / "coaxial_x8.urdf.xacro")),
    "tilted_quad": VehicleConfig(str(DRONES / "tilted_quad.urdf.xacro"), {"forward": "5"}),
    "hummingbird": VehicleConfig(
        str(SHARED / "rotors_description/urdf/hummingbird.xacro"), {"namespace": "hummingbird"}
    ),
    "cf2x": VehicleConfig(str(SHARED / "gym_pybullet_drones/cf2x.urdf")),
    "x500": VehicleConfig(str(SHARED / "px4_gazebo_models/x500/model.sdf")),
}
FLIGHTS, SEED = 50, 0
VELOCITY, ANGULAR_VELOCITY = 1e-3, 5e-3
"""Asked for [m/s, rad/s]."""


@dataclass(frozen=True)
class AgreementRow:
    """What a vehicle's flights came to.

    Attributes:
        vehicle: name.
        flights: number of flights of 5 s, each with other gains and commands.
        saturated: flights in which a rotor ran at its limit.
        lost: flights that turned over or fell; they are compared up to then.
        velocity: largest difference [m/s].
        angular_velocity: the same [rad/s].
    """

    vehicle: str
    flights: int
    saturated: int
    lost: int
    velocity: float
    angular_velocity: float


def measure(flights: int = FLIGHTS) -> list[AgreementRow]:
    """Fly every vehicle that is there."""
    return [
        AgreementRow(
            name,
            flights,
            int(found.saturated.sum()),
            int(found.lost.sum()),
            float(found.velocity.max()),
            float(found.angular_velocity.max()),
        )
        for name, found in fly_all(flights).items()
    ]


def fly_all(flights: int) -> dict[str, Agreement]:
    """Return how each vehicle's flights agree."""
    found = {}
    for name, config in VEHICLES.items():
        if config.model and not (config.model == "dh_drone" or Path(config.model).exists()):
            continue
        vehicle = configured_vehicle(config)
        trials = random_trials(vehicle, flight_gains(vehicle, config.gains), flights, SEED)
        found[name] = agreement(Scenario(vehicle=config), trials)
    return found


def show(rows: list[AgreementRow]) -> None:
    """Print the table."""
    print("vehicle      flights saturated lost   velocity   angular velocity, largest differences")
    for row in rows:
        print(
            f"{row.vehicle:12} {row.flights:7} {row.saturated:9} {row.lost:4}"
            f" {row.velocity:7.1e} m/s {row.angular_velocity:9.1e} rad/s"
        )


def draw(found: dict[str, Agreement]) -> Figure:
    """Return a picture of every flight beside what is asked for."""
    figure = Figure(figsize=(8.2, 4.6), layout="constrained")
    axes = figure.subplots()
    for name, each in found.items():
        least = np.finfo(float).eps / 4.0
        across, along = np.maximum(each.velocity, least), np.maximum(each.angular_velocity, least)
        axes.loglog(across, along, ".", label=f"{name}: {len(across)}", alpha=0.6)
    axes.axvline(VELOCITY, color="0.4", linestyle="--")
    axes.axhline(ANGULAR_VELOCITY, color="0.4", linestyle="--")
    axes.annotate(
        "asked for", (VELOCITY, ANGULAR_VELOCITY), (-4, 4), textcoords="offset points", ha="right"
    )
    axes.set_xlabel("largest difference in velocity [m/s]")
    axes.set_ylabel("largest difference in angular velocity [rad/s]")
    axes.set_title("Flights of 5 s, compiled and on the full diagram")
    axes.legend(title="flights", loc="upper left", bbox_to_anchor=(0.02, 0.85))
    axes.grid(alpha=0.3)
    return figure


def main() -> None:
    """Draw the picture that is asked for, or print the table."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--figure", type=Path, help="file of the picture")
    arguments = parser.parse_args()
    if arguments.figure:
        draw(fly_all(FLIGHTS)).savefig(arguments.figure, dpi=100)
    else:
        show(measure())


if __name__ == "__main__":
    main()
