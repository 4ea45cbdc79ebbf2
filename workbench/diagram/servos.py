"""The servos of a vehicle in a diagram: what commands them, and what the law measures of joints."""

from dataclasses import replace

import numpy as np
from pydrake.systems.framework import DiagramBuilder, OutputPort

from workbench.common.errors import WorkbenchError
from workbench.common.plain_text import plain_name
from workbench.control.controller import Controller
from workbench.diagram.airframe import Airframe
from workbench.diagram.forces import chosen_values, joint_places
from workbench.plant.description import Description
from workbench.plant.formats.values import listed_names
from workbench.plant.servo import SERVO_SYSTEM
from workbench.plant.vehicle import Vehicle
from workbench.setup import Setup
from workbench.systems.servo_commands import ServoCommands


def commanded_joints(vehicle: Vehicle, controller: Controller) -> list[str]:
    """Return the joints whose servos the law commands, in the order of its commands.

    Raises:
        WorkbenchError: if the law names a joint without a servo, or one that tilts a rotor.
    """
    tilts, driven = [tilt.joint for tilt in vehicle.tilts], [each.joint for each in vehicle.servos]
    for name in controller.servos:
        if name not in driven:
            raise WorkbenchError(
                f"{controller.file}: SERVOS has '{plain_name(name)}', and {vehicle.name} has no "
                f"servo on such a joint: it has {listed_names(driven) or 'none'}"
            )
        if name in tilts:
            raise WorkbenchError(
                f"{controller.file}: SERVOS has '{plain_name(name)}', which makes the yaw moment "
                f"of {vehicle.name}: leave it out"
            )
    return [*tilts, *controller.servos]


def add_servo_commands(
    builder: DiagramBuilder, setup: Setup, airframe: Airframe, commands: OutputPort
) -> None:
    """Let the law's commands and live parameters drive the servos of an airframe.

    Args:
        builder: of the diagram.
        setup: its values have the setpoints of the servos that the law does not command.
        airframe: with the servos.
        commands: of the law (n + m + s), see `FlightComputer`.
    """
    servos = airframe.vehicle.servos
    if airframe.setpoints is None:
        return
    driven = [each.joint for each in servos]
    places = [driven.index(name) for name in commanded_joints(setup.vehicle, setup.controller)]
    system = builder.AddNamedSystem(
        SERVO_SYSTEM,
        ServoCommands(
            servos=[each.servo for each in servos],
            commanded=places,
            wanted=[setup.values[row.name] for row in setup.controller.setpoints],
            period=setup.rates.control_period,
        ),
    )
    builder.Connect(system.get_output_port(), airframe.setpoints)
    if places:
        wanted = servo_commands(builder, commands, len(setup.vehicle.rotors))
        builder.Connect(wanted, system.GetInputPort("commands"))


def servo_setpoints(builder: DiagramBuilder) -> OutputPort | None:
    """Return the port of what `add_servo_commands` added, None without servos."""
    if not builder.HasSubsystemNamed(SERVO_SYSTEM):
        return None
    return builder.GetSubsystemByName(SERVO_SYSTEM).get_output_port()


def rotor_commands(
    builder: DiagramBuilder, commands: OutputPort, rotors: int, name: str = "rotor_speeds"
) -> OutputPort:
    """Return the port of the rotors' commands among those of the law; the name is its system's."""
    return chosen_values(builder, name, commands, np.arange(rotors))


def servo_commands(builder: DiagramBuilder, commands: OutputPort, rotors: int) -> OutputPort:
    """Return the port of the servos' commands among those of the law: tilts, then its servos."""
    return chosen_values(builder, "servo_commands", commands, np.arange(rotors, commands.size()))


def measured_joints(
    builder: DiagramBuilder, airframe: Airframe, controller: Controller
) -> OutputPort:
    """Return the port of positions and velocities of the joints that a law commands (2 s)."""
    state = airframe.plant.get_state_output_port()
    places = joint_places(airframe.plant, controller.servos)
    return chosen_values(builder, "measured_joints", state, places)


def with_held_setpoints(description: Description, setup: Setup) -> Description:
    """Return a description whose servos start at the setpoints of a setup's values."""
    rows = setup.controller.setpoints
    names = [each.joint for each in setup.vehicle.free_servos(setup.controller.servos)]
    values = {name: setup.values[row.name] for name, row in zip(names, rows, strict=True)}
    joints = tuple(
        replace(
            joint,
            freedoms=tuple(
                replace(each, servo=replace(each.servo, start=each.servo.within(values[name])))
                if each.servo and name in values
                else each
                for name, each in zip(joint.freedom_names, joint.freedoms, strict=True)
            ),
        )
        for joint in description.model.joints
    )
    return replace(description, model=replace(description.model, joints=joints))
