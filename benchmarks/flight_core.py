"""How much of the bare plant's speed is left with rotors, controller and flight mode around it.

Three diagrams of the same plant at the same step fly side by side, in short turns so that a noisy
machine disturbs all alike: the floor (C++ Propeller, constant thrusts, no Python), the flight core
in closed loop with rotor dynamics and flight mode, and the whole workbench with its recorder.
"""

import statistics
import time
from dataclasses import dataclass

import numpy as np
from pydrake.math import RigidTransform
from pydrake.systems.analysis import Simulator
from pydrake.systems.framework import Diagram, DiagramBuilder

from workbench.diagram.airframe import add_airframe
from workbench.diagram.core import add_sampled_core
from workbench.diagram.workbench import make_workbench
from workbench.gains import vehicle_gains
from workbench.parameters import parameters_of
from workbench.plant.description import read_description
from workbench.plant.gravity import GRAVITY
from workbench.plant.loading import make_vehicle
from workbench.resources import find_model
from workbench.scenario import Rates
from workbench.systems.flight_mode import FlightMode, Settings, initial_state
from workbench.systems.mode_manager import ModeManager

HEIGHT = 5.0
SLICE = 0.125
TURNS = 80


@dataclass(frozen=True)
class SpeedRow:
    """Real-time factor of one diagram, and its ratio to the floor's, turn by turn."""

    name: str
    best_real_time_factor: float
    median_ratio: float
    lower_quartile: float
    upper_quartile: float


def measure() -> list[SpeedRow]:
    """Return a row for floor, flight core and workbench."""
    description = read_description(find_model("dh_drone"))
    vehicle = make_vehicle(description)
    gains = vehicle_gains(vehicle)
    rates = Rates()
    settings = Settings(**{row.name: gains[row.name] for row in parameters_of("modes")})
    at = [0.0, 0.0, HEIGHT]

    builder = DiagramBuilder()
    airframe = add_airframe(builder, description, vehicle, physics_step=rates.physics_step)
    floor = Simulator(builder.Build())
    context = airframe.forces.GetMyMutableContextFromRoot(floor.get_mutable_context())
    n = len(vehicle.rotors)
    airframe.thrusts.FixValue(context, np.full(n, vehicle.mass * GRAVITY / n))

    builder = DiagramBuilder()
    airframe, computer = add_sampled_core(builder, description, vehicle, gains, rates)
    modes = builder.AddNamedSystem(
        "modes",
        ModeManager(
            period=rates.mode_period, settings=settings, standing_height=vehicle.ground_clearance
        ),
    )
    builder.Connect(airframe.state, modes.GetInputPort("state"))
    builder.Connect(modes.GetOutputPort("guidance"), computer.GetInputPort("guidance"))
    core = Simulator(builder.Build())
    root = core.get_mutable_context()
    mode_context = modes.GetMyMutableContextFromRoot(root)
    modes.GetInputPort("reference").FixValue(mode_context, np.zeros(8))
    modes.GetInputPort("request").FixValue(mode_context, np.zeros(3))
    modes.GetInputPort("charge").FixValue(mode_context, [1.0])
    computer_context = computer.GetMyMutableContextFromRoot(root)
    computer.GetInputPort("reference").FixValue(computer_context, np.zeros(8))
    computer.set_rotors(computer_context, vehicle.hover_speeds, np.zeros(3))
    modes.set_mode(mode_context, initial_state(FlightMode.HOVERING, at), at)

    bench = make_workbench(description, vehicle, gains, rates)
    whole = Simulator(bench.diagram)
    root = whole.get_mutable_context()
    computer = bench.computer
    computer.set_rotors(
        computer.GetMyMutableContextFromRoot(root), vehicle.hover_speeds, np.zeros(3)
    )
    bench.modes.set_mode(
        bench.modes.GetMyMutableContextFromRoot(root), initial_state(FlightMode.HOVERING, at), at
    )

    simulators = {"floor": floor, "flight core": core, "workbench": whole}
    for simulator in simulators.values():
        _lift(simulator, vehicle.base_link)
        simulator.Initialize()
        simulator.AdvanceTo(SLICE)
    times: dict[str, list[float]] = {name: [] for name in simulators}
    for turn in range(2, TURNS + 2):
        for name, simulator in simulators.items():
            begin = time.perf_counter()
            simulator.AdvanceTo(turn * SLICE)
            times[name].append(time.perf_counter() - begin)
    return [_row(name, times[name], times["floor"]) for name in simulators]


def _lift(simulator: Simulator, base_link: str) -> None:
    """Put the drone in the air."""
    diagram = simulator.get_system()
    assert isinstance(diagram, Diagram)
    plant = diagram.GetSubsystemByName("plant")
    context = plant.GetMyMutableContextFromRoot(simulator.get_mutable_context())
    plant.SetFreeBodyPose(
        context, plant.GetBodyByName(base_link), RigidTransform([0.0, 0.0, HEIGHT])
    )


def _row(name: str, times: list[float], floor: list[float]) -> SpeedRow:
    ratios = [base / own for base, own in zip(floor, times, strict=True)]
    low, median, high = statistics.quantiles(ratios, n=4)
    return SpeedRow(name, SLICE / min(times), median, low, high)


def show(rows: list[SpeedRow]) -> None:
    """Print the table."""
    print("diagram       best RTF   ratio to floor (median, quartiles)")
    for row in rows:
        print(
            f"{row.name:12s} {row.best_real_time_factor:9.1f}   {row.median_ratio:.3f}"
            f"  ({row.lower_quartile:.3f} .. {row.upper_quartile:.3f})"
        )


if __name__ == "__main__":
    show(measure())
