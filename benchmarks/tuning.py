"""Do searches from bad gains end in good ones: `python benchmarks/tuning.py [MODEL]`.

Each run starts from the vehicle's gains, every one scaled by a random factor between 0.2 and 5,
and has the wishes that follow from the vehicle. It counts when the gain file meets them on the full
diagram. It takes some six seconds a run, so it is not part of `make bench`.
"""

import argparse
import math
import sys
import time

import numpy as np

from workbench.common.resources import find_model
from workbench.control.controller import Controller
from workbench.control.controller_file import load_controller
from workbench.control.installed_laws import DEFAULT_CONTROLLER
from workbench.design.tune.tuner import Tuner
from workbench.gains.gain_choice import flight_gains
from workbench.plant.loading import load_vehicle
from workbench.plant.vehicle import Vehicle
from workbench.scenario.scenario import Scenario, VehicleConfig

LEAST, MOST = 0.2, 5.0


def scaled_gains(vehicle: Vehicle, law: Controller, seed: int) -> dict[str, float]:
    """Return a controller's gains, each scaled at random within its parameter's limits."""
    rng = np.random.default_rng(seed)
    gains = {}
    for name, value in flight_gains(vehicle, controller=law).items():
        if any(name in loop.gains for loop in law.loops):
            row = law.table.find(name)
            factor = math.exp(rng.uniform(math.log(LEAST), math.log(MOST)))
            gains[name] = min(row.maximum, max(row.minimum, factor * value))
    return gains


def main() -> int:
    """Run, print a line a run, and return 0 if all wishes were met each time."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("model", nargs="?", default="dh_drone")
    parser.add_argument("--controller", default=DEFAULT_CONTROLLER, metavar="NAME")
    parser.add_argument("--arg", action="append", default=[], metavar="NAME:=VALUE")
    parser.add_argument("--runs", type=int, default=50)
    options = parser.parse_args()
    args = dict(text.split(":=", 1) for text in options.arg)
    vehicle = load_vehicle(find_model(options.model), args)
    law = load_controller(options.controller)
    met = 0
    for seed in range(options.runs):
        config = VehicleConfig(model=options.model, args=dict(args))
        scenario = Scenario(vehicle=config, controller=options.controller)
        begun = time.process_time()
        found = Tuner(scenario, settings=scaled_gains(vehicle, law, seed), seed=seed).run()
        met += found.met
        unmet = sum(not result.required.met(result.before) for result in found.results)
        print(
            f"run {seed}: {'met' if found.met else 'NOT met'}, {unmet} of "
            f"{len(found.results)} demands unmet before, {found.evaluations} candidates, "
            f"{time.process_time() - begun:.1f} s of processor",
            flush=True,
        )
    print(f"{met} of {options.runs} met the wishes on the full diagram")
    return 0 if met == options.runs else 1


if __name__ == "__main__":
    sys.exit(main())
