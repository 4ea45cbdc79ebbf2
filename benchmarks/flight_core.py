"""The speed of the flight core compared with the bare plant.

Diagrams of the same drone fly in short alternating turns, so that other load affects all of them
equally. Times are processor times. Three diagrams are bare plants under constant thrusts without
Python in the loop:

- as described: Drake's plant of the description, one body for each link, with all drawn shapes;
- turning: a body with four propellers that turn on their joints, 21 states and no shapes.
  It is the floor that the flight core is compared with;
- one body: the plant of the flight, with the propellers as part of the body, 13 states. It is
  faster, so the ratio of the flight core to it is smaller.

The flight core is the closed loop with rotor dynamics and flight mode; the workbench has everything
that a session has. There are three pairs of rates: those of a session; about those of
gym-pybullet-drones (240 Hz, and a command every fifth step); and about the rate of RotorPy's own
loop (100 Hz).
"""

import time
from dataclasses import dataclass

from flyers import HEIGHT, Flyer, Hangar
from spread import Spread, ratios, spread, text

from workbench.scenario.scenario import Rates

SLICE = 0.25
"""Of a turn [s]."""
TURNS = 40
RATES = (
    Rates(),
    Rates(physics_step=1 / 256, control_period=5 / 256, mode_period=5 / 32, record_period=5 / 256),
    Rates(physics_step=1 / 128, control_period=1 / 128),
)
TURNING, ONE_BODY = "floor, turning", "floor, one body"


@dataclass(frozen=True)
class SpeedRow:
    """How fast one diagram flies; ratios are to the floors of the same physics step.

    Attributes:
        name: what flies.
        physics_rate: [Hz].
        control_rate: [Hz].
        real_time_factor: simulated time over processor time, turn by turn.
        to_turning: speed relative to the plant with turning propellers.
        to_one_body: speed relative to the plant of one body.
    """

    name: str
    physics_rate: float
    control_rate: float
    real_time_factor: Spread
    to_turning: Spread
    to_one_body: Spread


def measure() -> list[SpeedRow]:
    """Return the rows of all pairs of rates."""
    return [row for rates in RATES for row in _measure(rates)]


def _measure(rates: Rates) -> list[SpeedRow]:
    """Return rows for bare plants, flight core and workbench."""
    hangar = Hangar()
    flyers = {
        "as described": hangar.described(rates),
        TURNING: hangar.spinning_floor(rates),
        ONE_BODY: hangar.floor(rates),
        "flight core": hangar.core(rates),
        "workbench": hangar.workbench(rates),
    }
    for flyer in flyers.values():
        flyer.simulator.AdvanceTo(SLICE)
    times: dict[str, list[float]] = {name: [] for name in flyers}
    for turn in range(2, TURNS + 2):
        for name, flyer in flyers.items():
            begin = time.process_time()
            flyer.simulator.AdvanceTo(turn * SLICE)
            times[name].append(time.process_time() - begin)
    for name, flyer in flyers.items():
        _check(name, flyer)
    return [
        SpeedRow(
            name,
            1.0 / rates.physics_step,
            1.0 / rates.control_period,
            spread([SLICE / own for own in times[name]]),
            ratios(times[TURNING], times[name]),
            ratios(times[ONE_BODY], times[name]),
        )
        for name in flyers
    ]


def _check(name: str, flyer: Flyer) -> None:
    """Refuse figures of a flight that did not hold its height."""
    if not abs(flyer.height() - HEIGHT) < 0.5:
        raise RuntimeError(f"{name} is at {flyer.height():.2f} m, and not at {HEIGHT:g} m")


def show(rows: list[SpeedRow]) -> None:
    """Print the table."""
    print(f"{'physics, law':>15}  {'':19}  {'RTF':>5}  {'speed over that of the floor':^45}")
    print(f"{'Hz':>15}  {'':19}  {'':5}  {'turning':^22} {'one body':^22}")
    for row in rows:
        rates = f"{row.physics_rate:.0f}, {row.control_rate:.0f}"
        print(
            f"{rates:>15}  {row.name:19}  {row.real_time_factor.median:5.1f}  "
            f"{text(row.to_turning):22} {text(row.to_one_body):22}"
        )


if __name__ == "__main__":
    show(measure())
