"""A block diagram in Graphviz's language DOT, and the picture that Graphviz makes of it."""

import shutil
import subprocess
from html import escape
from itertools import zip_longest
from pathlib import Path

from workbench.common.errors import WorkbenchError
from workbench.design.block_graph import OUTPUTS, RECORDER, Block, BlockGraph, Net

INSTALL = "install Graphviz (on Debian and Ubuntu: `sudo apt install graphviz`)"
TEXT, PICTURES = (".dot", ".gv"), (".svg", ".pdf", ".png")
"""Endings of files in DOT, and of those that Graphviz draws."""
_COLOURS = (
    "#0072B2", "#D55E00", "#009E73", "#AA4499", "#B8860B", "#4B5FBF", "#6B4C2A", "#2A8C9E",
)  # fmt: skip


def check_drawable(file: Path) -> None:
    """Refuse a file that cannot be written here.

    Raises:
        WorkbenchError: if it is no picture and no DOT, or a picture and Graphviz is not installed.
    """
    if file.suffix not in (*TEXT, *PICTURES):
        known = ", ".join((*PICTURES, *TEXT))
        raise WorkbenchError(f"{file}: no kind of picture: give it a name that ends in {known}")
    if file.suffix in PICTURES and not has_graphviz():
        raise WorkbenchError(
            f"{file}: Graphviz draws the picture, and it is not installed: {INSTALL}, or write "
            f"DOT to {file.with_suffix('.dot')}"
        )


def has_graphviz() -> bool:
    """Return whether Graphviz is installed."""
    return shutil.which("dot") is not None


def draw_blocks(graph: BlockGraph, file: Path) -> None:
    """Write a block graph to a file that `check_drawable` lets pass.

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
    """Return a block graph in DOT: a node a system with its ports, an edge for each connection.

    Edges of one source have one colour, and tell their signal and its size as tooltips.
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
        f'<tr><td colspan="2"><b>{escape(block.name)}</b><br/>'
        f'<font point-size="9" color="#555555">{escape(block.kind)}</font></td></tr>'
    ]
    ports = zip_longest(_unique(block.inputs), _unique(block.outputs))
    for place, (one, other) in enumerate(ports):
        left = f'<td port="i{place}" align="left">{escape(one)}</td>' if one else "<td></td>"
        right = f'<td port="o{place}" align="right">{escape(other)}</td>' if other else "<td></td>"
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


def _quoted(name: str) -> str:
    """Return a name as DOT has it."""
    return '"' + name.replace("\\", "\\\\").replace('"', '\\"') + '"'
