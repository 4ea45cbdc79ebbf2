"""`workbench compile`: compile the default controller, once for this machine."""

import argparse
import time
from typing import TYPE_CHECKING, Any

from workbench.commands import ExitCode
from workbench.commands.options import add_command, add_json_option
from workbench.commands.printing import print_result

if TYPE_CHECKING:
    from workbench.scenario.scenario import Scenario

SCENARIOS = ("all-sensors", "estimate-ekf")
"""Together they call all compiled functions of a flight."""


def add_parser(commands: Any) -> None:
    """Add the command."""
    parser = add_command(
        commands,
        "compile",
        "Compile the default controller for commands, the app and batches, once for this machine.",
        "workbench compile",
        run,
    )
    add_json_option(parser)


def run(args: argparse.Namespace) -> int:
    """Compile in a process for each core."""
    from workbench.commands.progress import progress_bar
    from workbench.common.resources import find_scenario
    from workbench.design.executor.executor import Task, all_cores
    from workbench.scenario.scenario import Scenario, load_scenario

    began = time.monotonic()
    tasks = [Task(Scenario(), each) for each in (_fly_many, _fly_batch, _fly_measured)]
    tasks += [Task(load_scenario(find_scenario(name)), _fly) for name in SCENARIOS]
    with progress_bar("compiling") as show:
        for done, _ in enumerate(all_cores().run(tasks), 1):
            show(done / len(tasks))
    result = {"seconds": time.monotonic() - began}
    print_result(args, result, _print, result["seconds"])
    return ExitCode.DONE


def _print(seconds: float) -> None:
    print(f"the default controller is compiled, in {seconds:.0f} s")


def _fly(scenario: "Scenario") -> None:
    """Fly the first moment of a scenario, with a filter of the gyro: without one none is called."""
    from workbench.session.session import Session

    Session(scenario, {"gyro_lowpass": 60.0}).tick(0.1)


def _fly_measured(scenario: "Scenario") -> None:
    """Fly the first moment in compiled code, as measured steps do."""
    from workbench.session.session import Session

    Session(scenario, engine="compiled").tick(0.1)


def _fly_batch(scenario: "Scenario") -> None:
    """Fly a control period of a batch."""
    from workbench.design.rollout.batch import Batch

    Batch(1, scenario.vehicle, scenario.controller, threads=1).step()


def _fly_many(scenario: "Scenario") -> None:
    """Fly a step with one set of gains, as sweeps and searches do with thousands."""
    from workbench.design.rollout.engine import RolloutEngine
    from workbench.scenario.configured import configured_vehicle

    engine = RolloutEngine(configured_vehicle(scenario.vehicle), scenario.rates)
    engine.measure([engine.gains], "x", 1.0, duration=0.1)
