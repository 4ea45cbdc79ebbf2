"""How fast compiled flights of the shipped laws and on estimates are: `python benchmarks/laws.py`.

All fly the same commands in turn, timed in processor time, beside `pd` on the truth. Asked for is
half of its rate of other laws, and a quarter of it on an estimate with all filters. They compile
first, up to a minute each, so it is not part of `make bench`.
"""

import sys
import time
from dataclasses import dataclass

import numpy as np

from workbench.common.resources import find_model
from workbench.control.controller_file import load_controller
from workbench.control.installed_laws import DEFAULT_CONTROLLER, installed_laws
from workbench.design.rollout.candidates import start_state
from workbench.design.rollout.engine import RolloutEngine
from workbench.design.rollout.sensor_set import make_sensor_set
from workbench.estimation.settings import COMPLEMENTARY, EKF, TRUTH
from workbench.gains.gain_choice import flight_gains
from workbench.plant.loading import load_vehicle
from workbench.scenario.scenario import Scenario, ScenarioStart
from workbench.setup import make_setup

FLIGHTS, DURATION, TURNS = 400, 2.0, 9
FILTERS = {
    "gyro_lowpass": 80.0,
    "gyro_notch": 120.0,
    "accel_lowpass": 30.0,
    "derivative_lowpass": 30.0,
    "setpoint_lowpass": 5.0,
    "command_steps": 2000.0,
}


@dataclass(frozen=True)
class Kind:
    """What flies.

    Attributes:
        law: name of a controller.
        estimator: name of what tells it the motion.
        filters: whether all work.
        seeds: whether each flight has noise of its own.
        asked: share of the rate of `pd` on the truth; 0 of what is only shown.
    """

    law: str
    estimator: str = TRUTH
    filters: bool = False
    seeds: bool = False
    asked: float = 0.5

    def __str__(self) -> str:
        parts = [self.law, self.estimator, "filters" * self.filters, "seeds" * self.seeds]
        return ", ".join(filter(None, parts))


KINDS = (
    *(Kind(name) for name in installed_laws()),
    Kind(DEFAULT_CONTROLLER, TRUTH, filters=True),
    Kind(DEFAULT_CONTROLLER, COMPLEMENTARY, filters=True, asked=0.0),
    Kind(DEFAULT_CONTROLLER, EKF, asked=0.25),
    Kind(DEFAULT_CONTROLLER, EKF, filters=True, asked=0.25),
    Kind(DEFAULT_CONTROLLER, EKF, filters=True, seeds=True, asked=0.0),
)


def main() -> int:
    """Print a line for each kind; 1 if one is too slow."""
    vehicle = load_vehicle(find_model("dh_drone"), {})
    starts = np.tile(start_state(vehicle, ScenarioStart(position=[0.0, 0.0, 50.0])), (FLIGHTS, 1))
    commands = np.tile([1.0, 0.5, 0.2, 0.1], (FLIGHTS, 1))
    taken: dict[Kind, list[float]] = {kind: [] for kind in KINDS}
    engines = {}
    for kind in KINDS:
        law, scenario = load_controller(kind.law), Scenario(estimator=kind.estimator)
        own = flight_gains(vehicle, controller=law)
        senses = make_sensor_set(make_setup(scenario))
        engines[kind] = RolloutEngine(
            vehicle, scenario.rates, own=own, controller=law, senses=senses
        )
    for turn in range(TURNS + 1):  # the first compiles
        for kind, engine in engines.items():
            gains = [engine.gains | (FILTERS if kind.filters else {})] * FLIGHTS
            seeds = range(FLIGHTS) if kind.seeds else None
            begun = time.process_time()
            engine.fly_from(gains, starts, commands, duration=DURATION, seeds=seeds)
            if turn:
                taken[kind].append(time.process_time() - begun)
    beside = taken[Kind(DEFAULT_CONTROLLER)]
    enough = True
    for kind, times in taken.items():
        ratio = float(np.median(np.divide(beside, times)))
        enough &= ratio >= kind.asked
        asked = f", asked for is {kind.asked}" if kind.asked else ""
        print(f"{kind!s:32} {ratio:5.2f} of the rate of {DEFAULT_CONTROLLER}{asked}")
    return 0 if enough else 1


if __name__ == "__main__":
    sys.exit(main())
