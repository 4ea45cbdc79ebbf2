"""How fast compiled flights of the shipped laws are beside `pd`'s: `python benchmarks/laws.py`.

All fly the same commands in turn, timed in processor time; asked for is half of `pd`'s rate. The
laws compile first, up to a minute each, so it is no part of `make bench`.
"""

import sys
import time

import numpy as np

from workbench.common.resources import find_model
from workbench.control.controller import DEFAULT, SHIPPED, load_controller
from workbench.design.rollout.engine import RolloutEngine
from workbench.design.rollout.starts import start_state
from workbench.gains.gains import flight_gains
from workbench.plant.loading import load_vehicle
from workbench.scenario.scenario import Rates, Start

FLIGHTS, DURATION, TURNS = 400, 2.0, 9
ASKED = 0.5


def main() -> int:
    """Print a line for each law; 1 if one is too slow."""
    vehicle = load_vehicle(find_model("dh_drone"), {})
    starts = np.tile(start_state(vehicle, Start(position=[0.0, 0.0, 50.0])), (FLIGHTS, 1))
    commands = np.tile([1.0, 0.5, 0.2, 0.1], (FLIGHTS, 1))
    taken: dict[str, list[float]] = {name: [] for name in SHIPPED}
    engines = {}
    for name in SHIPPED:
        law = load_controller(name)
        own = flight_gains(vehicle, controller=law)
        engines[name] = RolloutEngine(vehicle, Rates(), own=own, controller=law), [own] * FLIGHTS
    for turn in range(TURNS + 1):  # the first compiles
        for name, (engine, gains) in engines.items():
            begun = time.process_time()
            engine.fly_from(gains, starts, commands, duration=DURATION)
            if turn:
                taken[name].append(time.process_time() - begun)
    ratios = {
        name: float(np.median(np.divide(taken[DEFAULT], times))) for name, times in taken.items()
    }
    for name, ratio in ratios.items():
        print(f"{name:10} {ratio:5.2f} of the rate of {DEFAULT}, asked for is {ASKED}")
    return 0 if min(ratios.values()) >= ASKED else 1


if __name__ == "__main__":
    sys.exit(main())
