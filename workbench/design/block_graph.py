"""A Drake diagram as blocks and nets, and its picture in Graphviz's language DOT."""

import re
import shutil
import subprocess
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from itertools import zip_longest
from pathlib import Path
from typing import Any

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

from workbench.common.errors import WorkbenchError
from workbench.common.plain_text import LONGEST_TEXT, html_text, plain_name

RECORDER = "recorder"
OUTPUTS = "outputs"
NUMBERED = re.compile(r"[uy]\d+")
"""Names that Drake gives to unnamed ports."""
INSTALL = "install Graphviz (on Debian and Ubuntu: `sudo apt install graphviz`)"
TEXT, PICTURES = (".dot", ".gv"), (".svg", ".pdf", ".png")
"""Endings of files in DOT, and of those that Graphviz draws."""
_COLOURS = (
    "#0072B2", "#D55E00", "#009E73", "#AA4499", "#B8860B", "#4B5FBF", "#6B4C2A", "#2A8C9E",
)  # fmt: skip


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
    """Return the top level of a diagram, simplified for a readable picture.

    The scene graph and its plant, or the system that turns states into its poses, form one block.
    Logs and the systems that bundle signals for them form the recorder. Exported ports become
    blocks.
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
        listeners = diagram.GetInputPortLocators(InputPortIndex(index))
        for system, place in sorted(listeners, key=_order(diagram)):
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
    connections = [
        (system, int(index), feeder, int(place))
        for (system, index), (feeder, place) in diagram.connection_map().items()
    ]
    return sorted(connections, key=_order(diagram))


def _order(diagram: Diagram) -> Callable[[Sequence[Any]], tuple[int, int]]:
    """Return the key that sorts input ports (system, its port, ...) in the systems' order.

    Drake keeps them in the order of addresses, which differs from run to run.
    """
    places = {system.get_name(): place for place, system in enumerate(diagram.GetSystems())}
    return lambda each: (places[each[0].get_name()], int(each[1]))


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


def check_drawable(file: Path) -> None:
    """Check that a picture can be written to a file.

    Raises:
        WorkbenchError: if the file is neither a picture nor DOT, or is a picture and Graphviz is
            not installed.
    """
    if file.suffix not in (*TEXT, *PICTURES):
        known = ", ".join((*PICTURES, *TEXT))
        raise WorkbenchError(
            f"{file}: not a supported kind of picture: give it a name that ends in {known}"
        )
    if file.suffix in PICTURES and not has_graphviz():
        raise WorkbenchError(
            f"{file}: Graphviz draws the picture, and it is not installed: {INSTALL}, or write "
            f"DOT to {file.with_suffix('.dot')}"
        )


def has_graphviz() -> bool:
    """Return whether Graphviz is installed."""
    return shutil.which("dot") is not None


def draw_blocks(graph: BlockGraph, file: Path) -> None:
    """Write a block graph to a file that `check_drawable` accepts.

    Raises:
        WorkbenchError: if Graphviz fails.
    """
    dot = block_dot(graph)
    if file.suffix in TEXT:
        file.write_text(dot, encoding="utf-8")
        return
    command = ["dot", f"-T{file.suffix[1:]}", "-o", str(file)]
    done = subprocess.run(command, input=dot, capture_output=True, text=True, encoding="utf-8")
    if done.returncode:
        raise WorkbenchError(f"{file}: Graphviz cannot draw it: {done.stderr.strip()}: {INSTALL}")


def block_dot(graph: BlockGraph) -> str:
    """Return a block graph in DOT, with a node per system and an edge per connection.

    Edges from one source share a colour. Their tooltips show the signal and its size.
    """
    sources = list(dict.fromkeys(net.source.block for net in graph.nets))
    colours = {name: _COLOURS[place % len(_COLOURS)] for place, name in enumerate(sources)}
    blocks = {block.name: block for block in graph.blocks}
    last = "; ".join(_quoted(name) for name in (RECORDER, OUTPUTS) if name in blocks)
    lines = [
        f"digraph {_quoted(graph.name)} {{",
        '  graph [rankdir=LR, ranksep=1.2, nodesep=0.3, fontname="Helvetica"];',
        '  node [shape=plain, fontname="Helvetica", fontsize=11];',
        "  edge [arrowsize=0.6];",
        *(f"  {_quoted(block.name)} [label=<{_table(block)}>];" for block in graph.blocks),
        *(edge for net in graph.nets for edge in _edges(net, blocks, colours[net.source.block])),
        f"  {{ rank=sink; {last} }}",
        "}",
    ]
    return "\n".join(lines) + "\n"


def _table(block: Block) -> str:
    """Return a block as Graphviz's table: name and kind, then inputs at the left, outputs right."""
    rows = [
        f'<tr><td colspan="2"><b>{_shown(block.name)}</b><br/>'
        f'<font point-size="9" color="#555555">{_shown(block.kind)}</font></td></tr>'
    ]
    ports = zip_longest(_unique(block.inputs), _unique(block.outputs))
    for place, (one, other) in enumerate(ports):
        left = f'<td port="i{place}" align="left">{_shown(one)}</td>' if one else "<td></td>"
        right = f'<td port="o{place}" align="right">{_shown(other)}</td>' if other else "<td></td>"
        rows.append(f"<tr>{left}{right}</tr>")
    head = '<table border="1" cellborder="0" cellspacing="0" cellpadding="3" color="#4A5568">'
    return head + "".join(rows) + "</table>"


def _edges(net: Net, blocks: dict[str, Block], colour: str) -> list[str]:
    """Return a line for each connection of a net."""
    source = net.source
    size = f" ({net.size})" if net.size else ""
    tip = _quoted(f"{source.block}.{source.port}{size}")
    begin = f"{_quoted(source.block)}:o{_place(source.port, blocks[source.block].outputs)}:e"
    return [
        f"  {begin} -> {_quoted(sink.block)}:i{_place(sink.port, blocks[sink.block].inputs)}:w "
        f"[id={_quoted(f'{source.block}.{source.port}->{sink.block}.{sink.port}')}, "
        f'color="{colour}", tooltip={tip}];'
        for sink in net.sinks
    ]


def _unique(ports: tuple[str, ...]) -> list[str]:
    """Return the names of ports; signals of one name enter the recorder at one place."""
    return list(dict.fromkeys(ports))


def _place(port: str, ports: tuple[str, ...]) -> int:
    """Return where a port stands in its column."""
    return _unique(ports).index(port)


def _shown(name: str) -> str:
    """Return a name as HTML."""
    return html_text(plain_name(name))


def _quoted(name: str) -> str:
    """Return a name as DOT has it."""
    name = plain_name(name, LONGEST_TEXT)
    return '"' + name.replace("\\", "\\\\").replace('"', '\\"') + '"'
