"""A Drake diagram as blocks and nets: what a picture of it needs to know."""

import re
from dataclasses import dataclass

from pydrake.systems.framework import Diagram, InputPort, OutputPort, System
from pydrake.systems.primitives import VectorLogSink


@dataclass(frozen=True)
class Terminal:
    """A port of a block."""

    block: str
    port: str


@dataclass(frozen=True)
class Block:
    """A system, with those of its ports that are connected.

    Attributes:
        name: unique in the diagram.
        kind: class of the system, with its period where it is sampled.
        inputs: names of input ports.
        outputs: names of output ports.
    """

    name: str
    kind: str
    inputs: tuple[str, ...]
    outputs: tuple[str, ...]


@dataclass(frozen=True)
class Net:
    """An output port and every input port it feeds; `size` is 0 for structures."""

    source: Terminal
    sinks: tuple[Terminal, ...]
    size: int


@dataclass(frozen=True)
class BlockGraph:
    """A diagram's blocks and nets."""

    name: str
    blocks: tuple[Block, ...]
    nets: tuple[Net, ...]


def read_block_graph(diagram: Diagram) -> BlockGraph:
    """Return a diagram's top level; exported ports and the logs become blocks of their own."""
    sinks: dict[Terminal, list[Terminal]] = {}
    sizes: dict[Terminal, int] = {}

    def connect(source: Terminal, sink: Terminal, size: int) -> None:
        sinks.setdefault(source, []).append(sink)
        sizes[source] = size

    for (system, index), (feeder, port) in diagram.connection_map().items():
        output = feeder.get_output_port(port)
        connect(_terminal(feeder, output), _terminal(system, system.get_input_port(index)), output.size())
    for index in range(diagram.num_input_ports()):
        port = diagram.get_input_port(index)
        for system, inner in diagram.GetInputPortLocators(index):
            terminal = _terminal(system, system.get_input_port(inner))
            connect(Terminal(port.get_name(), "in"), terminal, port.size())
    for index in range(diagram.num_output_ports()):
        port = diagram.get_output_port(index)
        system, inner = diagram.get_output_port_locator(index)
        source = _terminal(system, system.get_output_port(inner))
        connect(source, Terminal("outputs", port.get_name()), port.size())
    nets = tuple(Net(source, tuple(ends), sizes[source]) for source, ends in sinks.items())
    return BlockGraph(diagram.get_name(), _blocks(diagram, nets), nets)


def _terminal(system: System, port: InputPort | OutputPort) -> Terminal:
    if isinstance(system, VectorLogSink):
        return Terminal("recorder", system.get_name().removeprefix("log_"))
    return Terminal(system.get_name(), port.get_name())


def _blocks(diagram: Diagram, nets: tuple[Net, ...]) -> tuple[Block, ...]:
    """Return every block that a net touches, systems in the diagram's order."""
    kinds = {
        system.get_name(): _kind(system)
        for system in diagram.GetSystems()
        if not isinstance(system, VectorLogSink)
    }
    inputs: dict[str, list[str]] = {name: [] for name in kinds}
    outputs: dict[str, list[str]] = {name: [] for name in kinds}
    for net in nets:
        outputs.setdefault(net.source.block, []).append(net.source.port)
        for sink in net.sinks:
            inputs.setdefault(sink.block, []).append(sink.port)
    names = dict.fromkeys([*inputs, *outputs])
    return tuple(
        Block(
            name,
            kinds.get(name, _PSEUDO_KINDS.get(name, "input port")),
            tuple(inputs.get(name, ())),
            tuple(outputs.get(name, ())),
        )
        for name in names
    )


_PSEUDO_KINDS = {"recorder": "logs", "outputs": "output ports"}


def _kind(system: System) -> str:
    """Return a system's class without its scalar type, and its period if it has one."""
    kind = re.sub(r"_?\U0001d4e3.*", "", type(system).__name__)
    timing = None if isinstance(system, Diagram) else system.GetUniquePeriodicDiscreteUpdateAttribute()
    if timing is None:
        return kind
    return f"{kind}, every {1000.0 * timing.period_sec():.3g} ms"
