"""The sampled core in still air, of systems that all convert to AutoDiffXd."""

from collections.abc import Mapping
from dataclasses import dataclass

from pydrake.multibody.plant import MultibodyPlant
from pydrake.systems.framework import Diagram, DiagramBuilder
from pydrake.systems.primitives import Demultiplexer, ZeroOrderHold

from workbench.diagram.airframe import add_airframe_in_air
from workbench.diagram.core import add_computer, add_drag
from workbench.plant.description import Description
from workbench.plant.vehicle import Vehicle
from workbench.scenario import Rates
from workbench.systems.air.continuous_drag import ContinuousDrag
from workbench.systems.flight_computer import FlightComputer


@dataclass(frozen=True)
class SampledCore:
    """Plant, rotors, drag and law as they fly, and nothing else.

    Attributes:
        diagram: with the inputs reference (8) and guidance (22).
        plant: discrete.
        computer: the law with the rotors.
        drag: at any moment.
        held_drag: the same, sampled with the law as `Air` samples it.
    """

    diagram: Diagram
    plant: MultibodyPlant
    computer: FlightComputer
    drag: ContinuousDrag
    held_drag: ZeroOrderHold


def make_sampled_core(
    description: Description, vehicle: Vehicle, gains: Mapping[str, float], rates: Rates
) -> SampledCore:
    """Return the workbench's dynamics in calm air, without flight mode, battery and recorder.

    Every system of it converts to AutoDiffXd, and it flies as the workbench does.

    Args:
        description: what flies.
        vehicle: as the law knows it.
        gains: parameter values by name.
        rates: of physics and control.
    """
    builder = DiagramBuilder()
    airframe, wrench = add_airframe_in_air(
        builder, description.undrawn(), vehicle, physics_step=rates.physics_step
    )
    computer = add_computer(builder, airframe, description.rotors, vehicle, gains, rates)
    n = len(vehicle.rotors)
    split = builder.AddNamedSystem("split", Demultiplexer([n, n + 3]))
    held = builder.AddNamedSystem("held_drag", ZeroOrderHold(rates.control_period, 6))
    builder.Connect(computer.GetOutputPort("memory"), split.get_input_port())
    drag = add_drag(builder, airframe.state, split.get_output_port(0), vehicle, gains)
    builder.Connect(drag.get_output_port(), held.get_input_port())
    builder.Connect(held.get_output_port(), wrench)
    for name in ("reference", "guidance"):
        builder.ExportInput(computer.GetInputPort(name), name)
    builder.ExportOutput(airframe.state, "state")
    diagram = builder.Build()
    diagram.set_name("sampled_core")
    return SampledCore(diagram, airframe.plant, computer, drag, held)
