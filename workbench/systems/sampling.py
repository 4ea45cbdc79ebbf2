"""Sampling is wiring: a hold behind a port, where a period is given."""

from pydrake.systems.framework import DiagramBuilder, OutputPort
from pydrake.systems.primitives import ZeroOrderHold


def add_hold(builder: DiagramBuilder, port: OutputPort, period: float) -> OutputPort:
    """Return `port` sampled and held every `period` seconds, or `port` itself where that is 0."""
    if period == 0.0:
        return port
    name = f"{port.get_system().get_name()}_{port.get_name()}_hold"
    hold = builder.AddNamedSystem(name, ZeroOrderHold(period, port.size()))
    builder.Connect(port, hold.get_input_port())
    return hold.get_output_port()
