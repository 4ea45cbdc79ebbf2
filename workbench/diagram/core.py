"""The flight core: plant, rotors and controller; continuous for design, sampled for flight."""

from collections.abc import Mapping
from dataclasses import replace

import numpy as np
from pydrake.systems.framework import Diagram, DiagramBuilder, InputPort, LeafSystem, OutputPort
from pydrake.systems.primitives import (
    ConstantVectorSource,
    DiscreteTimeDelay,
    PassThrough,
    ZeroOrderHold,
)

from workbench.common.errors import WorkbenchError
from workbench.control.controller import Controller
from workbench.control.flight_law import ComputerSettings
from workbench.control.law_constants import known_vehicle, law_constants
from workbench.diagram.airframe import Airframe, add_airframe, add_battery_systems
from workbench.diagram.forces import (
    add_cables,
    add_forces,
    add_joint_forces,
    body_places,
    chosen_values,
    connect_forces,
)
from workbench.diagram.servos import (
    add_servo_commands,
    commanded_joints,
    measured_joints,
    rotor_commands,
    servo_commands,
    with_held_setpoints,
)
from workbench.dynamics.air.settings import calm_air
from workbench.plant.multibody import add_plant
from workbench.plant.payload import description_with_payload, payload_of
from workbench.plant.vehicle import Vehicle
from workbench.scenario.scenario import Rates
from workbench.setup import Setup
from workbench.systems.acceleration_estimate import make_acceleration_estimate
from workbench.systems.battery import voltage_drop
from workbench.systems.controller import DERIVATIVE_STEP_S, ContinuousController_
from workbench.systems.flight_computer import FlightComputer
from workbench.systems.moving_obstacles import add_moving_obstacles
from workbench.systems.recorder import SignalRecorder, add_recorder
from workbench.systems.rotor_playback import RotorCommands, make_rotor_playback
from workbench.systems.rotors import Rotors

STATE_HOLD, STATE_DELAY = "state_hold", "state_delay"
"""Names of the systems that delay the state for the law: by a part of a control period, and by
whole ones; each only if there is such a delay."""
COMMAND_DELAY, COMMAND_HOLD = "command_delay", "command_hold"
"""Likewise for the commands of the rotors: whole periods, and a part of one."""
ROTOR_COMMANDS = "rotor_commands"
"""Name of the system that holds the commands of a table."""


def make_flight_core(setup: Setup) -> Diagram:
    """Return plant, rotors, drag and controller as one continuous diagram.

    It converts to AutoDiffXd, and `Linearize` of it is exact. The law knows the setup's `vehicle`;
    the plant is made of what is `flown`, which may differ, see `plant.variation`. Both are without
    their payload, which comes from the values.

    Input ports: reference (8) and guidance (22), see `control.guidance`; wind (3), the velocity of
    the air in W [m/s], zero if unconnected.
    Output ports: state (13), thrusts (n) [N], speeds (n) [rad/s].
    """
    builder = DiagramBuilder()
    state, rotors, setpoints = _add_continuous_vehicle(builder, setup)
    estimate = builder.AddNamedSystem("acceleration_estimate", make_acceleration_estimate())
    law = builder.AddNamedSystem(
        "controller",
        ContinuousController_[float](
            controller=setup.controller,
            vehicle=setup.vehicle,
            gains=law_gains(setup.controller, setup.vehicle, setup.values),
            payload=payload_of(setup.values),
        ),
    )
    builder.Connect(state, estimate.get_input_port())
    builder.Connect(state, law.GetInputPort("state"))
    builder.Connect(estimate.get_output_port(), law.GetInputPort("acceleration"))
    if setup.controller.servos:
        raise WorkbenchError(
            f"{setup.controller.name} commands servos, so it has no continuous model: leave --time "
            "continuous out"
        )
    commands = law.get_output_port()
    n = len(setup.vehicle.rotors)
    builder.Connect(rotor_commands(builder, commands, n), rotors.GetInputPort("commands"))
    if setpoints is not None:
        builder.Connect(servo_commands(builder, commands, n), setpoints)
    for name in ("reference", "guidance"):
        builder.ExportInput(law.GetInputPort(name), name)
    builder.ExportOutput(state, "state")
    for name in ("thrusts", "speeds"):
        builder.ExportOutput(rotors.GetOutputPort(name), name)
    diagram = builder.Build()
    diagram.set_name("flight_core")
    return diagram


def make_vehicle_core(setup: Setup) -> Diagram:
    """Return plant, rotors and drag without a controller as one continuous diagram.

    Input port: commands (n + m + s), see `FlightComputer`. Output ports: state (13), thrusts (n)
    [N], speeds (n) [rad/s]. It converts to AutoDiffXd.
    """
    builder = DiagramBuilder()
    state, rotors, setpoints = _add_continuous_vehicle(builder, setup)
    if setpoints is None:
        builder.ExportInput(rotors.GetInputPort("commands"), "commands")
    else:
        n = len(setup.vehicle.rotors)
        whole = builder.AddNamedSystem("all_commands", PassThrough(n + setpoints.size()))
        commands = whole.get_output_port()
        builder.ExportInput(whole.get_input_port(), "commands")
        builder.Connect(rotor_commands(builder, commands, n), rotors.GetInputPort("commands"))
        builder.Connect(servo_commands(builder, commands, n), setpoints)
    builder.ExportOutput(state, "state")
    for name in ("thrusts", "speeds"):
        builder.ExportOutput(rotors.GetOutputPort(name), name)
    diagram = builder.Build()
    diagram.set_name("vehicle_core")
    return diagram


def _add_continuous_vehicle(
    builder: DiagramBuilder, setup: Setup
) -> tuple[OutputPort, Rotors, InputPort | None]:
    """Add Drake's plant with rotors, drag, and the port for the wind; that of commands is open.

    Return the port of the state of its base link (13), the rotors, and the port for
    setpoints of the servos that the law commands, if any.
    """
    flown, values = setup.flown, setup.values
    whole = description_with_payload(flown.undrawn(), payload_of(values))
    plant, _ = add_plant(builder, whole, time_step=0.0)
    plant.set_name("plant")
    places = body_places(plant, plant.GetBodyByName(flown.base_link))
    state = chosen_values(builder, "body_state", plant.get_state_output_port(), places)
    rotors, body_forces = add_forces(
        builder, plant, whole, flown.rotors, setup.flown_vehicle, values
    )
    cables = add_cables(builder, plant, whole)
    connect_forces(builder, plant, state, rotors, body_forces, cables)
    commanded = commanded_joints(setup.vehicle, setup.controller)
    held = with_held_setpoints(whole, setup)
    *_, setpoints = add_joint_forces(builder, plant, held, commanded)
    builder.ExportInput(rotors.GetInputPort("wind"), "wind")
    builder.ConnectInput("wind", body_forces.GetInputPort("wind"))
    if setup.vehicle.battery:
        full = full_supply(setup.vehicle, values)
        supply = builder.AddNamedSystem("supply", ConstantVectorSource(full))
        builder.Connect(supply.get_output_port(), rotors.GetInputPort("supply"))
    return state, rotors, setpoints


def add_sampled_core(builder: DiagramBuilder, setup: Setup) -> tuple[Airframe, FlightComputer]:
    """Add the same core as it flies: stepped vehicle and sampled controller."""
    flown, vehicle = setup.flown.undrawn(), setup.flown_vehicle
    airframe = add_airframe(builder, flown, setup.values, rates=setup.rates, vehicle=vehicle)
    if setup.vehicle.battery:
        add_battery_systems(builder, airframe, setup.vehicle, **setup.of_system("battery"))
    return airframe, add_computer(builder, setup, airframe)


def add_computer(
    builder: DiagramBuilder,
    setup: Setup,
    airframe: Airframe,
    sensed: OutputPort | None = None,
    voltage: OutputPort | None = None,
) -> FlightComputer:
    """Add the sampled controller, and connect the airframe.

    Args:
        builder: of the diagram.
        setup: its law runs; its variation has the delays, see `STATE_HOLD` and `COMMAND_DELAY`.
        airframe: the vehicle.
        sensed: the motion (13) for the law, if it is not the airframe's.
        voltage: of the battery (1) for the law, if it is not the true one.
    """
    rates = setup.rates
    computer = builder.AddNamedSystem(
        "controller",
        FlightComputer(
            controller=setup.controller,
            vehicle=setup.vehicle,
            gains=setup.values,
            period=rates.control_period,
            payload=payload_of(setup.values),
            settings=ComputerSettings(**setup.of_system("computer")),
        ),
    )
    delays = setup.variation.delays(rates.physics_step, rates.control_period)
    state, commands = sensed or airframe.sensed, computer.GetOutputPort("commands")
    late, look = delays.sensing_delay
    age, since = delays.command_delay
    if look:  # an update sees the last one that was held
        state = _held(builder, STATE_HOLD, state, rates, look)
    state = _delayed(builder, STATE_DELAY, state, rates, late - 1 if look else late)
    commands = _delayed(builder, COMMAND_DELAY, commands, rates, age)
    if since:
        commands = _held(builder, COMMAND_HOLD, commands, rates, since)
    builder.Connect(state, computer.GetInputPort("state"))
    n = len(setup.vehicle.rotors)
    builder.Connect(rotor_commands(builder, commands, n), airframe.commands)
    add_servo_commands(builder, setup, airframe, commands)
    if setup.controller.servos:
        joints = measured_joints(builder, airframe, setup.controller)
        builder.Connect(joints, computer.GetInputPort("joints"))
    voltage = voltage or airframe.rotors.GetOutputPort("voltage")
    builder.Connect(voltage, computer.GetInputPort("voltage"))
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
    return controller.gains(gains, known, DERIVATIVE_STEP_S)


def make_open_loop(
    setup: Setup, commands: RotorCommands | LeafSystem
) -> tuple[Diagram, Airframe, SignalRecorder]:
    """Return a diagram of the airframe with a source of rotor commands instead of a controller, the
    airframe, and the recorder.

    The source is a table, or a system whose only output is speeds (n) [rad/s].

    It has a battery if the description has one. The air is calm.

    Rotors get a table's commands at its rows if these begin with control periods, else at every
    physics step: a step of the integrator sees constant commands. Moving obstacles of a world are
    left out, as they have no contact.
    """
    vehicle, rates, world = setup.vehicle, setup.rates, setup.world
    calm = replace(setup, values=setup.table.defaults() | calm_air(vehicle)._asdict())
    builder = DiagramBuilder()
    airframe = add_airframe(
        builder,
        calm.flown.undrawn(),
        calm.values,
        rates=rates,
        vehicle=calm.flown_vehicle,
        world=world,
    )
    add_moving_obstacles(builder, airframe.scene_graph, world)
    if vehicle.battery:
        add_battery_systems(builder, airframe, vehicle, **calm.of_system("battery"))
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
    return diagram, airframe, recorder
