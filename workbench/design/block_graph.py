"""A Drake diagram as blocks and nets: what a picture of it needs to know."""

import re
from dataclasses import dataclass

from pydrake.geometry import SceneGraph
from pydrake.multibody.plant import MultibodyPlant
from pydrake.systems.framework import (
    Diagram,
    InputPortIndex,
    OutputPortIndex,
    System,
)
from pydrake.systems.primitives import Multiplexer, VectorLogSink
from pydrake.systems.rendering import MultibodyPositionToGeometryPose

RECORDER = "recorder"
OUTPUTS = "outputs"
NUMBERED = re.compile(r"[uy]\d+")
"""How Drake names a port that nobody named."""


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
    """Return a diagram's top level, as simple as an honest picture allows.

    The scene graph is one block with its plant, or with what turns states into its poses; logs and
    what bundles signals for them are the recorder. Exported ports become blocks.
    """
    homes = _homes(diagram)
    sinks: dict[Terminal, list[Terminal]] = {}
    sizes: dict[Terminal, int] = {}

    def connect(source: Terminal, sink: Terminal, size: int) -> None:
        if source.block != sink.block:
            sinks.setdefault(source, []).append(sink)
            sizes[source] = size

    for system, index, feeder, place in _connections(diagram):
        output = feeder.get_output_port(place)
        port = system.get_input_port(index).get_name()
        source = Terminal(homes[feeder.get_name()], output.get_name())
        home = homes[system.get_name()]
        if home == RECORDER:
            port = source.block if NUMBERED.fullmatch(source.port) else source.port
        connect(source, Terminal(home, port), output.size())
    for index in range(diagram.num_input_ports()):
        outer = diagram.get_input_port(index)
        for system, place in diagram.GetInputPortLocators(InputPortIndex(index)):
            inner = Terminal(homes[system.get_name()], system.get_input_port(place).get_name())
            connect(Terminal(outer.get_name(), "y0"), inner, outer.size())
    for index in range(diagram.num_output_ports()):
        outer = diagram.get_output_port(index)
        system, place = diagram.get_output_port_locator(OutputPortIndex(index))
        inner = Terminal(homes[system.get_name()], system.get_output_port(place).get_name())
        connect(inner, Terminal(OUTPUTS, outer.get_name()), outer.size())
    nets = tuple(Net(source, tuple(ends), sizes[source]) for source, ends in sinks.items())
    return BlockGraph(diagram.get_name(), _blocks(diagram, nets, homes), nets)


def _connections(diagram: Diagram) -> list[tuple[System, int, System, int]]:
    """Return (listener, its port, feeder, its port) of each connection, in the systems' order."""
    places = {system.get_name(): place for place, system in enumerate(diagram.GetSystems())}
    connections = [
        (system, int(index), feeder, int(place))
        for (system, index), (feeder, place) in diagram.connection_map().items()
    ]
    return sorted(connections, key=lambda each: (places[each[0].get_name()], each[1]))


def _homes(diagram: Diagram) -> dict[str, str]:
    """Return the block that each system is drawn in, by name."""
    systems = diagram.GetSystems()
    homes = {system.get_name(): system.get_name() for system in systems}
    feeds: dict[str, list[System]] = {}
    for system, _, feeder, _ in _connections(diagram):
        feeds.setdefault(feeder.get_name(), []).append(system)
    for system in systems:
        name = system.get_name()
        listeners = feeds.get(name, [])
        bundles = isinstance(system, Multiplexer) and len(listeners) == 1
        if isinstance(system, VectorLogSink) or (
            bundles and isinstance(listeners[0], VectorLogSink)
        ):
            homes[name] = RECORDER
        if isinstance(system, SceneGraph):
            plants = [each.get_name() for each in listeners if isinstance(each, MultibodyPlant)]
            homes |= {each: f"{plant} + {name}" for plant in plants for each in (name, plant)}
        if isinstance(system, MultibodyPositionToGeometryPose):
            homes[name] = listeners[0].get_name()
    return homes


def _blocks(diagram: Diagram, nets: tuple[Net, ...], homes: dict[str, str]) -> tuple[Block, ...]:
    """Return every block that a net touches, systems in the diagram's order."""
    kinds: dict[str, list[str]] = {home: [] for home in homes.values()}
    for system in diagram.GetSystems():
        kinds[homes[system.get_name()]].append(_kind(system))
    kinds |= {RECORDER: ["logs"], OUTPUTS: ["output ports"]}
    inputs: dict[str, list[str]] = {name: [] for name in kinds}
    outputs: dict[str, list[str]] = {name: [] for name in kinds}
    for net in nets:
        outputs.setdefault(net.source.block, []).append(net.source.port)
        for sink in net.sinks:
            inputs.setdefault(sink.block, []).append(sink.port)
    return tuple(
        Block(
            name,
            ", ".join(kinds.get(name, ["input port"])),
            tuple(inputs.get(name, ())),
            tuple(outputs.get(name, ())),
        )
        for name in dict.fromkeys([*inputs, *outputs])
        if inputs.get(name) or outputs.get(name)
    )


def _kind(system: System) -> str:
    """Return a system's class without its scalar type, and its period if it has one."""
    kind = re.sub(r"_?\U0001d4e3.*", "", type(system).__name__)
    if isinstance(system, Diagram):
        return kind
    timing = system.GetUniquePeriodicDiscreteUpdateAttribute()
    return kind if timing is None else f"{kind} ({1000.0 * timing.period_sec():.3g} ms)"
