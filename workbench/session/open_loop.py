"""Flights without a controller, under a table of rotor commands."""

import math
from collections.abc import Callable
from pathlib import Path

import numpy as np
from pydrake.systems.analysis import Simulator
from pydrake.systems.framework import Context

from workbench.common.errors import drake_error_sentences
from workbench.control.guidance import Reference
from workbench.diagram.airframe import Airframe
from workbench.diagram.core import ROTOR_COMMANDS, make_open_loop
from workbench.plant.placing import body_state
from workbench.plant.vehicle import Vehicle
from workbench.scenario.configured import log_world_remarks
from workbench.scenario.scenario import Scenario
from workbench.session.integration import Integration
from workbench.session.live_context import start_position
from workbench.session.recording import Recording
from workbench.setup import Setup, make_setup
from workbench.systems.recorder import SignalRecorder
from workbench.systems.rotor_playback import load_rotor_commands


def fly_open_loop(
    scenario: Scenario, table: Path, progress: Callable[[float], None] | None = None
) -> Recording:
    """Fly a CSV file of rotor thrusts for a scenario's duration.

    The vehicle starts as the scenario states, with its rotors at the speeds of the first row;
    script, gains, sensors and flight mode have no effect. The commands pass through the rotors'
    lag. Absent signals are NaN in the recording: reference, mode and charge; clearance is not
    measured.

    Args:
        scenario: source of vehicle, world, start, rates and duration.
        table: see `systems.rotor_playback.load_rotor_commands`; its last row holds to the end.
        progress: called with the flown share, 0 .. 1.

    Raises:
        WorkbenchError: if scenario or table cannot be flown.
    """
    setup = make_setup(scenario)
    scenario, vehicle = setup.scenario, setup.vehicle
    commands = load_rotor_commands(table, vehicle)
    log_world_remarks(setup.world)
    diagram, airframe, recorder = make_open_loop(setup, commands)
    simulator = Simulator(diagram)
    place_at_start(simulator.get_mutable_context(), airframe, setup, commands.speeds[0])
    held = diagram.GetSubsystemByName(ROTOR_COMMANDS)
    held.GetMyMutableContextFromRoot(simulator.get_mutable_context()).SetDiscreteState(
        commands.speeds[0]
    )
    integration = Integration(simulator, airframe, scenario.rates)
    slices = math.ceil(4.0 * scenario.duration)
    steps = scenario.duration / scenario.rates.physics_step
    with drake_error_sentences("the flight could not begin"):
        simulator.Initialize()
    for index in range(slices):
        integration.advance(round(steps * (index + 1) / slices))
        if progress:
            progress((index + 1) / slices)
    return recorded(simulator.get_context(), recorder, vehicle)


def place_at_start(context: Context, airframe: Airframe, setup: Setup, speeds: np.ndarray) -> None:
    """Write the start of a setup and rotor speeds (n) [rad/s] to the Context."""
    start = setup.scenario.start
    state = body_state(
        p_WB=start_position(start, setup.vehicle),
        roll_pitch_yaw=start.roll_pitch_yaw,
        v_WB=start.velocity,
        w_WB=start.angular_velocity,
    )
    airframe.place(context, state, speeds)


def recorded(context: Context, recorder: SignalRecorder, vehicle: Vehicle) -> Recording:
    """Return everything flown; signals that only a controller has are NaN."""
    time = recorder.times(context)
    none = np.full((len(time), len(Reference._fields)), math.nan)
    signals = dict(recorder.signals(context))
    signals |= {"reference": none, "mode": none[:, :1], "charge": none[:, :1]}
    return Recording.from_signals(vehicle, time, signals)
