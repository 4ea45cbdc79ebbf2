"""Flight without a controller: a table of rotor commands from a scenario's start."""

import math
from collections.abc import Callable
from pathlib import Path

import numpy as np
from pydrake.systems.analysis import Simulator

from workbench.common.errors import sentences
from workbench.control.guidance import Reference
from workbench.diagram.open_loop import OpenLoop, make_open_loop
from workbench.plant.loading import make_vehicle
from workbench.plant.placing import body_state
from workbench.plant.variation import varied
from workbench.plant.vehicle import Vehicle
from workbench.scenario.configured import read_configured, read_configured_world, tell_world
from workbench.scenario.scenario import Scenario, check_scenario
from workbench.session.live_context import start_position
from workbench.session.recording import Recording
from workbench.systems.rotor_playback import RotorCommands, load_rotor_commands


def fly_open_loop(
    scenario: Scenario, table: Path, progress: Callable[[float], None] | None = None
) -> Recording:
    """Fly a CSV file of rotor thrusts for a scenario's duration.

    The vehicle begins as the scenario says, with its rotors at the first row's speeds; script,
    gains, sensors and flight mode play no part. The commands go through the rotors' lag. What
    there is none of is NaN in the recording: reference, mode and charge; clearance is not measured.

    Args:
        scenario: its vehicle, world, start, rates and duration are used.
        table: see `systems.rotor_playback.load_rotor_commands`; its last row holds to the end.
        progress: called with the flown share, 0 .. 1.

    Raises:
        WorkbenchError: if scenario or table cannot be flown.
    """
    check_scenario(scenario)
    description = read_configured(scenario.vehicle)
    vehicle = make_vehicle(description)
    commands = load_rotor_commands(table, vehicle)
    world = read_configured_world(scenario)
    tell_world(world)
    flown = varied(description, vehicle, scenario.vehicle.variation)
    bench = make_open_loop(flown, vehicle, scenario.rates, commands, world)
    simulator = Simulator(bench.diagram)
    _start(simulator, bench, scenario, vehicle, commands)
    slices = math.ceil(4.0 * scenario.duration)
    with sentences("the flight could not go on"):
        simulator.Initialize()
        for index in range(slices):
            simulator.AdvanceTo(scenario.duration * (index + 1) / slices)
            if progress:
                progress((index + 1) / slices)
    return _recording(simulator, bench, vehicle)


def _start(
    simulator: Simulator,
    bench: OpenLoop,
    scenario: Scenario,
    vehicle: Vehicle,
    commands: RotorCommands,
) -> None:
    """Put start and rotor speeds into the Context."""
    context = simulator.get_mutable_context()
    start, dynamics = scenario.start, bench.airframe.dynamics
    state = body_state(
        p_WB=start_position(start, vehicle),
        roll_pitch_yaw=start.roll_pitch_yaw,
        v_WB=start.velocity,
        w_WB=start.angular_velocity,
    )
    dynamics.place(dynamics.GetMyMutableContextFromRoot(context), state, commands.speeds[0])


def _recording(simulator: Simulator, bench: OpenLoop, vehicle: Vehicle) -> Recording:
    """Return everything flown."""
    context = simulator.get_context()
    time = bench.recorder.times(context)
    none = np.full((len(time), len(Reference._fields)), math.nan)
    signals = bench.recorder.signals(context)
    signals |= {"reference": none, "mode": none[:, :1], "charge": none[:, :1]}
    return Recording.from_signals(vehicle, time, signals)
