"""The flight core: plant, rotors and controller; continuous for design, sampled for flight."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
from pydrake.multibody.plant import MultibodyPlant
from pydrake.systems.framework import Diagram, DiagramBuilder, LeafSystem, OutputPort
from pydrake.systems.primitives import ConstantVectorSource, DiscreteTimeDelay, ZeroOrderHold

from workbench.control.controller import Controller
from workbench.control.flight_law import ComputerSettings, known_vehicle, law_constants
from workbench.diagram.airframe import (
    Airframe,
    add_airframe,
    add_battery,
    add_forces,
    connect_forces,
)
from workbench.dynamics.air.settings import calm_air
from workbench.plant.description import Description
from workbench.plant.loading import make_vehicle
from workbench.plant.multibody import add_plant
from workbench.plant.payload import laden_description, payload_of
from workbench.plant.variation import NOMINAL, Variation
from workbench.plant.vehicle import Vehicle
from workbench.plant.worlds.world import EMPTY, World
from workbench.scenario.parameters import parameter_table
from workbench.scenario.scenario import Rates
from workbench.systems.acceleration_estimate import make_acceleration_estimate
from workbench.systems.battery import voltage_drop
from workbench.systems.controller import SHORT, ContinuousController_
from workbench.systems.flight_computer import FlightComputer
from workbench.systems.moving_obstacles import add_moving_obstacles
from workbench.systems.recorder import Recorder, add_recorder
from workbench.systems.rotor_playback import RotorCommands, make_rotor_playback
from workbench.systems.rotors import Rotors

STATE_HOLD, STATE_DELAY = "state_hold", "state_delay"
"""Names of the systems that delay the state for the law: by a part of a control period, and by
whole ones; each only if there is such a delay."""
COMMAND_DELAY, COMMAND_HOLD = "command_delay", "command_hold"
"""Likewise for the commands of the rotors: whole periods, and a part of one."""
ROTOR_COMMANDS = "rotor_commands"
"""Name of the system that holds the commands of a table."""


def make_flight_core(
    controller: Controller, description: Description, vehicle: Vehicle, gains: Mapping[str, float]
) -> Diagram:
    """Return plant, rotors, drag and controller as one continuous diagram.

    It converts to AutoDiffXd, and `Linearize` of it is exact. The law knows `vehicle`; the plant
    is made of `description`, which may differ, see `plant.variation`. Both are without their
    payload, which comes from the gains.

    Input ports: reference (8) and guidance (22), see `control.guidance`; wind (3), the velocity of
    the air in W [m/s], zero if unconnected.
    Output ports: state (13), thrusts (n) [N], speeds (n) [rad/s].
    """
    builder = DiagramBuilder()
    plant, rotors = _add_continuous_vehicle(builder, description, vehicle, gains)
    state = plant.get_state_output_port()
    estimate = builder.AddNamedSystem("acceleration_estimate", make_acceleration_estimate())
    law = builder.AddNamedSystem(
        "controller",
        ContinuousController_[float](
            controller=controller,
            vehicle=vehicle,
            gains=law_gains(controller, vehicle, gains),
            payload=payload_of(gains),
        ),
    )
    builder.Connect(state, estimate.get_input_port())
    builder.Connect(state, law.GetInputPort("state"))
    builder.Connect(estimate.get_output_port(), law.GetInputPort("acceleration"))
    builder.Connect(law.get_output_port(), rotors.GetInputPort("commands"))
    for name in ("reference", "guidance"):
        builder.ExportInput(law.GetInputPort(name), name)
    builder.ExportOutput(state, "state")
    for name in ("thrusts", "speeds"):
        builder.ExportOutput(rotors.GetOutputPort(name), name)
    diagram = builder.Build()
    diagram.set_name("flight_core")
    return diagram


def make_vehicle_core(
    description: Description, vehicle: Vehicle, gains: Mapping[str, float]
) -> Diagram:
    """Return plant, rotors and drag without a controller as one continuous diagram.

    Input port: commands (n) of the rotors' speeds [rad/s]. Output ports: state (13), thrusts (n)
    [N], speeds (n) [rad/s]. It converts to AutoDiffXd.
    """
    builder = DiagramBuilder()
    plant, rotors = _add_continuous_vehicle(builder, description, vehicle, gains)
    builder.ExportInput(rotors.GetInputPort("commands"), "commands")
    builder.ExportOutput(plant.get_state_output_port(), "state")
    for name in ("thrusts", "speeds"):
        builder.ExportOutput(rotors.GetOutputPort(name), name)
    diagram = builder.Build()
    diagram.set_name("vehicle_core")
    return diagram


def _add_continuous_vehicle(
    builder: DiagramBuilder,
    description: Description,
    vehicle: Vehicle,
    gains: Mapping[str, float],
) -> tuple[MultibodyPlant, Rotors]:
    """Add Drake's plant with rotors, drag, and the port for the wind; that of commands is open."""
    whole = laden_description(description.undrawn().held(), payload_of(gains))
    plant, _ = add_plant(builder, whole, time_step=0.0)
    body = plant.GetBodyByName(description.base_link)
    flown = make_vehicle(description)
    rotors, body_forces = add_forces(builder, body, description.rotors, flown, gains)
    connect_forces(builder, plant, plant.get_state_output_port(), rotors, body_forces)
    builder.ExportInput(rotors.GetInputPort("wind"), "wind")
    builder.ConnectInput("wind", body_forces.GetInputPort("wind"))
    if vehicle.battery:
        supply = builder.AddNamedSystem("supply", ConstantVectorSource(full_supply(vehicle, gains)))
        builder.Connect(supply.get_output_port(), rotors.GetInputPort("supply"))
    return plant, rotors


def add_sampled_core(
    builder: DiagramBuilder,
    controller: Controller,
    description: Description,
    vehicle: Vehicle,
    gains: Mapping[str, float],
    rates: Rates,
) -> tuple[Airframe, FlightComputer]:
    """Add the same core as it flies: stepped vehicle and sampled controller."""
    airframe = add_airframe(builder, description.undrawn(), gains, rates=rates)
    if vehicle.battery:
        add_battery(builder, airframe, vehicle, **parameter_values("battery", gains))
    return airframe, add_computer(builder, controller, airframe, vehicle, gains, rates)


def add_computer(
    builder: DiagramBuilder,
    controller: Controller,
    airframe: Airframe,
    vehicle: Vehicle,
    gains: Mapping[str, float],
    rates: Rates,
    variation: Variation = NOMINAL,
    sensed: OutputPort | None = None,
    voltage: OutputPort | None = None,
) -> FlightComputer:
    """Add the sampled controller, and connect the airframe.

    Args:
        builder: of the diagram.
        controller: its law runs.
        airframe: the vehicle.
        vehicle: as the law knows it.
        gains: parameter values by name.
        rates: periods of sampled systems.
        variation: has the delays, see `STATE_HOLD` and `COMMAND_DELAY`.
        sensed: the motion (13) for the law, if it is not the airframe's.
        voltage: of the battery (1) for the law, if it is not the true one.
    """
    computer = builder.AddNamedSystem(
        "controller",
        FlightComputer(
            controller=controller,
            vehicle=vehicle,
            gains=gains,
            period=rates.control_period,
            payload=payload_of(gains),
            settings=ComputerSettings(**parameter_values("computer", gains)),
        ),
    )
    delays = variation.delays(rates.physics_step, rates.control_period)
    state, commands = sensed or airframe.sensed, computer.GetOutputPort("commands")
    late, look = delays.seen
    age, since = delays.acting
    if look:  # an update sees the last one that was held
        state = _held(builder, STATE_HOLD, state, rates, look)
    state = _delayed(builder, STATE_DELAY, state, rates, late - 1 if look else late)
    commands = _delayed(builder, COMMAND_DELAY, commands, rates, age)
    if since:
        commands = _held(builder, COMMAND_HOLD, commands, rates, since)
    builder.Connect(state, computer.GetInputPort("state"))
    builder.Connect(commands, airframe.commands)
    told = voltage or airframe.rotors.GetOutputPort("voltage")
    builder.Connect(told, computer.GetInputPort("voltage"))
    return computer


def _held(
    builder: DiagramBuilder, name: str, port: OutputPort, rates: Rates, step: int
) -> OutputPort:
    """Return a port that is held from some physics step of each control period to the next."""
    hold = ZeroOrderHold(rates.control_period, port.size(), step * rates.physics_step)
    builder.AddNamedSystem(name, hold)
    builder.Connect(port, hold.get_input_port())
    return hold.get_output_port()


def _delayed(
    builder: DiagramBuilder, name: str, port: OutputPort, rates: Rates, periods: int
) -> OutputPort:
    """Return a port delayed by some control periods, if any, for readers between updates."""
    if not periods:
        return port
    # sampling is the first period: at an update, the output is the previously held value
    delay = DiscreteTimeDelay(rates.control_period, periods - 1, port.size())
    builder.AddNamedSystem(name, delay)
    builder.Connect(port, delay.get_input_port())
    return delay.get_output_port()


def full_supply(vehicle: Vehicle, gains: Mapping[str, float]) -> tuple[float, float, float, float]:
    """Return the supply of the rotors by a full battery, see `Rotors_`."""
    if vehicle.battery is None:
        return (1.0, 0.0, 0.0, 1.0)
    drop = voltage_drop(vehicle, gains["battery_duration"])
    return (1.0, drop, gains["sag_compensation"], 1.0)


def law_gains(controller: Controller, vehicle: Vehicle, gains: Mapping[str, float]) -> list[float]:
    """Return all numbers of a continuous controller's gains, see `Controller.gains`.

    Args:
        controller: whose.
        vehicle: as the law knows it, without its payload.
        gains: parameter values by name.
    """
    known = known_vehicle(law_constants(vehicle, payload_of(gains)))
    return controller.gains(gains, known, SHORT)


def parameter_values(system: str, gains: Mapping[str, float]) -> dict[str, Any]:
    """Return one system's parameters by name."""
    return {row.name: gains[row.name] for row in parameter_table().of(system)}


@dataclass(frozen=True)
class OpenLoop:
    """The airframe under rotor commands from outside the diagram, without a controller."""

    diagram: Diagram
    airframe: Airframe
    recorder: Recorder


def make_open_loop(
    description: Description,
    vehicle: Vehicle,
    rates: Rates,
    commands: RotorCommands | LeafSystem,
    world: World = EMPTY,
) -> OpenLoop:
    """Return the airframe with a source of rotor commands instead of a controller, and a recorder.

    The source is a table, or a system whose only output is speeds (n) [rad/s].

    It has a battery if the description has one.

    Rotors get a table's commands at its rows if these begin with control periods, else at every
    physics step: a step of the integrator sees constant commands. Moving obstacles of a world are
    left out, as they have no contact.
    """
    builder = DiagramBuilder()
    calm = parameter_table().defaults() | calm_air(vehicle)._asdict()
    airframe = add_airframe(builder, description.undrawn(), calm, rates=rates, world=world)
    add_moving_obstacles(builder, airframe.plant, airframe.scene_graph, world)
    if vehicle.battery:
        add_battery(
            builder, airframe, vehicle, **parameter_values("battery", parameter_table().defaults())
        )
    if isinstance(commands, RotorCommands):
        source = make_rotor_playback(commands)
        of_rows = commands.time / rates.control_period
        aligned = np.abs(of_rows - of_rows.round()).max() < 1e-6
        period = rates.control_period if aligned else rates.physics_step
        hold = ZeroOrderHold(period, len(vehicle.rotors))
        playback = builder.AddNamedSystem("rotor_playback", source)
        held = builder.AddNamedSystem(ROTOR_COMMANDS, hold)
        builder.Connect(playback.get_output_port(), held.get_input_port())
    else:
        held = builder.AddNamedSystem("rotor_playback", commands)
    builder.Connect(held.get_output_port(), airframe.commands)
    recorder = add_recorder(builder, airframe.signals(held.get_output_port()), rates.record_period)
    diagram = builder.Build()
    diagram.set_name("open_loop")
    return OpenLoop(diagram, airframe, recorder)
