"""A block diagram as SVG text."""

import xml.etree.ElementTree as ET

from workbench.design.block_graph import NUMBERED, BlockGraph
from workbench.design.block_layout import Item, lay_out
from workbench.design.block_wires import Column, Line, Wire, route

_COLORS = (
    "#0072B2", "#D55E00", "#009E73", "#AA4499", "#B8860B", "#4B5FBF", "#6B4C2A", "#2A8C9E",
)  # fmt: skip
_BORDER = 18.0
_TITLE = 34.0
_FONT = "DejaVu Sans, Verdana, Helvetica, sans-serif"


def block_svg(graph: BlockGraph) -> str:
    """Return a picture of a block graph: a box a system, a line a net, ports named in the boxes."""
    layout = lay_out(graph)
    routing = route(layout)
    height = max(item.y + item.height for layer in layout.layers for item in layer)
    width = routing.width + 2.0 * _BORDER
    height += 2.0 * _BORDER + _TITLE
    svg = ET.Element(
        "svg",
        xmlns="http://www.w3.org/2000/svg",
        viewBox=f"0 0 {width:.0f} {height:.0f}",
        width=f"{width:.0f}",
        height=f"{height:.0f}",
    )
    svg.set("font-family", _FONT)
    ET.SubElement(svg, "title").text = f"block diagram of {graph.name}"
    ET.SubElement(svg, "rect", width="100%", height="100%", fill="white")
    _text(svg, _BORDER, _BORDER + 8.0, graph.name, size=16, weight="bold")
    picture = ET.SubElement(svg, "g", transform=f"translate({_BORDER:g} {_BORDER + _TITLE:g})")
    sources = list(dict.fromkeys(net.source.block for net in graph.nets))
    for wire in routing.wires:
        source = graph.nets[wire.net].source
        color = _COLORS[sources.index(source.block) % len(_COLORS)]
        _draw_wire(picture, wire, color, f"{source.block}.{source.port}", graph.nets[wire.net].size)
    for layer, column in zip(layout.layers, routing.columns, strict=True):
        for item in layer:
            if item.block:
                _draw_box(picture, item, column)
    ET.indent(svg)
    return ET.tostring(svg, encoding="unicode") + "\n"


def _draw_box(parent: ET.Element, item: Item, column: Column) -> None:
    """Draw a block with its name, its kind and the names of its ports."""
    block = item.block
    if block is None:
        return
    box = ET.SubElement(parent, "g")
    ET.SubElement(
        box,
        "rect",
        x=f"{column.x:g}",
        y=f"{item.y:g}",
        width=f"{column.width:g}",
        height=f"{item.height:g}",
        rx="4",
        fill="#F6F8FB",
        stroke="#33415C",
    )
    middle = column.x + 0.5 * column.width
    _text(box, middle, item.y + 16.0, block.name, size=12, weight="bold", anchor="middle")
    _text(box, middle, item.y + 31.0, block.kind, size=9.5, color="#5A6478", anchor="middle")
    sides = (
        ("start", column.x + 8.0, item.left),
        ("end", column.x + column.width - 6.0, item.right),
    )
    for anchor, x, ends in sides:
        for end in ends:
            if len(ends) > 1 or not NUMBERED.fullmatch(end.port):  # a number says nothing alone
                _text(box, x, item.y + end.offset + 3.5, end.port, size=10, anchor=anchor)


def _draw_wire(parent: ET.Element, wire: Wire, color: str, name: str, size: int) -> None:
    """Draw a net over a white rim, so that what it crosses is seen to pass below."""
    group = ET.SubElement(parent, "g", stroke=color, fill="none")
    ET.SubElement(group, "title").text = f"{name} ({size})" if size else name
    path = " ".join(map(_path, wire.lines))
    ET.SubElement(group, "path", {"d": path, "stroke": "white", "stroke-width": "4.5"})
    ET.SubElement(group, "path", {"d": path, "stroke-width": "1.4", "stroke-linecap": "round"})
    for x, y in wire.dots:
        ET.SubElement(group, "circle", cx=f"{x:g}", cy=f"{y:.1f}", r="2.6", fill=color)
    for x, y in wire.heads:
        ET.SubElement(group, "path", d=f"M{x:g},{y:.1f} l-7,-3.5 v7 z", fill=color)


def _path(line: Line) -> str:
    return f"M{line.x1:g},{line.y1:.1f} L{line.x2:g},{line.y2:.1f}"


def _text(
    parent: ET.Element,
    x: float,
    y: float,
    text: str,
    *,
    size: float,
    weight: str = "normal",
    color: str = "#1B2434",
    anchor: str = "start",
) -> None:
    """Write a text."""
    element = ET.SubElement(parent, "text", x=f"{x:g}", y=f"{y:.1f}", fill=color)
    element.set("font-size", f"{size:g}")
    element.set("font-weight", weight)
    element.set("text-anchor", anchor)
    element.text = text
