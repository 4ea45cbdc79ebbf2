"""Place blocks, and the lanes on which nets pass between them, in columns."""

from collections.abc import Iterator
from dataclasses import dataclass, field

from workbench.design.block_graph import Block, BlockGraph, Net
from workbench.design.block_layers import layers_of

PORT_PITCH = 17.0
HEADER = 40.0
_SPACING = 26.0
_LANE_SPACING = 13.0
_SWEEPS = 24
_CHARACTER, _SMALL_CHARACTER = 7.4, 6.0
"""Widths of text [px], on the safe side."""


@dataclass
class Attachment:
    """Where a net meets an item: its port's name and height below the item's top."""

    net: int
    port: str
    offset: float = 0.0


@dataclass
class Item:
    """A block, or a lane (without a block) on which a net passes a column.

    `left` are attachments in the gap before the column, `right` those in the gap after it. A lane
    against the flow goes below everything else.
    """

    layer: int
    block: Block | None = None
    below: bool = False
    left: list[Attachment] = field(default_factory=list)
    right: list[Attachment] = field(default_factory=list)
    y: float = 0.0

    @property
    def height(self) -> float:
        """Of the box; a lane has none."""
        ports = max(len(self.left), len(self.right))
        return HEADER + PORT_PITCH * ports + 6.0 if self.block else 0.0

    @property
    def width(self) -> float:
        """Of the box, wide enough for its texts."""
        if self.block is None:
            return 0.0
        ports = sum(
            max((len(end.port) for end in ends), default=0) for ends in (self.left, self.right)
        )
        return 24.0 + max(
            _CHARACTER * len(self.block.name),
            _SMALL_CHARACTER * len(self.block.kind),
            _SMALL_CHARACTER * ports + 16.0,
        )


@dataclass(frozen=True)
class End:
    """One attachment of a net in a gap."""

    item: Item
    attachment: Attachment

    @property
    def y(self) -> float:
        """Its height in the picture."""
        return self.item.y + self.attachment.offset


@dataclass
class Layout:
    """Items column by column, top to bottom."""

    graph: BlockGraph
    layers: list[list[Item]]

    def left_ends(self, gap: int, net: int) -> list[End]:
        """Return a net's ends on the left side of a gap; gap g is before column g."""
        items = self.layers[gap - 1] if gap > 0 else []
        return [End(item, end) for item in items for end in item.right if end.net == net]

    def right_ends(self, gap: int, net: int) -> list[End]:
        """Return a net's ends on the right side of a gap."""
        items = self.layers[gap] if gap < len(self.layers) else []
        return [End(item, end) for item in items for end in item.left if end.net == net]


def lay_out(graph: BlockGraph) -> Layout:
    """Return blocks and lanes in places that keep nets short and rarely crossing."""
    columns = layers_of(graph)
    layout = Layout(graph, [[] for _ in range(max(columns.values()) + 1)])
    items = {block.name: Item(columns[block.name], block) for block in graph.blocks}
    for item in items.values():
        layout.layers[item.layer].append(item)
    for index, net in enumerate(graph.nets):
        items[net.source.block].right.append(Attachment(index, net.source.port))
        for sink in net.sinks:
            items[sink.block].left.append(Attachment(index, sink.port))
        for lane in _lanes(index, net, columns):
            layout.layers[lane.layer].append(lane)
    for sweep in range(_SWEEPS):
        forward = sweep % 2 == 0
        for layer in layout.layers if forward else reversed(layout.layers):
            _arrange(layout, [item for item in layer if not item.below], forward)
        _arrange_below(layout)
    _straighten(layout)
    top = min(item.y for layer in layout.layers for item in layer)
    for layer in layout.layers:
        for item in layer:
            item.y -= top
    return layout


def _lanes(index: int, net: Net, columns: dict[str, int]) -> Iterator[Item]:
    """Yield a lane for every column that a net passes on its way from its source to its sinks."""
    source = columns[net.source.block]
    gaps = [source + 1, *(columns[sink.block] for sink in net.sinks)]
    for layer in range(min(gaps), max(gaps)):
        ends = Attachment(index, ""), Attachment(index, "")
        yield Item(layer, None, layer <= source, [ends[0]], [ends[1]])


def _straighten(layout: Layout) -> None:
    """Lead a net that passes several columns straight on, where one height is free in all."""
    lanes: dict[int, list[Item]] = {}
    for layer in layout.layers:
        for item in layer:
            if item.block is None and not item.below:
                lanes.setdefault(item.left[0].net, []).append(item)
    for group in lanes.values():
        free = [
            y
            for y in sorted({lane.y for lane in group})
            if all(_is_free(layout.layers[lane.layer], lane, y) for lane in group)
        ]
        if free:
            for lane in group:
                lane.y = free[0]


def _is_free(layer: list[Item], lane: Item, y: float) -> bool:
    """Return whether a lane may pass a column at a height."""
    return all(
        not item.y - _LANE_SPACING < y < item.y + item.height + _LANE_SPACING
        for item in layer
        if item is not lane
    )


def _arrange_below(layout: Layout) -> None:
    """Lead each net that runs against the flow straight along below all it passes."""
    floors = [
        max((item.y + item.height for item in layer if not item.below), default=0.0)
        for layer in layout.layers
    ]
    lanes: dict[int, list[Item]] = {}
    for layer in layout.layers:
        for item in layer:
            if item.below:
                lanes.setdefault(item.left[0].net, []).append(item)
    for group in sorted(lanes.values(), key=len):
        y = max(floors[lane.layer] for lane in group) + _LANE_SPACING
        for lane in group:
            lane.y = floors[lane.layer] = y


def _arrange(layout: Layout, layer: list[Item], forward: bool) -> None:
    """Move a column's items towards what they are connected to, without overlap."""
    for item in layer:
        _arrange_ports(layout, item)
    wanted = {id(item): _wanted(layout, item, forward) for item in layer}
    layer.sort(key=lambda item: wanted[id(item)] + 0.5 * item.height)
    # The least squares places in a given order: pool items that would overlap into one block.
    shifts = [0.0]
    for above, below in zip(layer, layer[1:], strict=False):
        lanes = above.block is None and below.block is None
        shifts.append(shifts[-1] + above.height + (_LANE_SPACING if lanes else _SPACING))
    pools: list[list[float]] = []
    for item, shift in zip(layer, shifts, strict=True):
        pools.append([wanted[id(item)] - shift])
        while len(pools) > 1 and _mean(pools[-2]) >= _mean(pools[-1]):
            pools[-2:] = [pools[-2] + pools[-1]]
    places = [_mean(pool) for pool in pools for _ in pool]
    for item, place, shift in zip(layer, places, shifts, strict=True):
        item.y = place + shift


def _arrange_ports(layout: Layout, item: Item) -> None:
    """Sort a block's ports by the heights of what they are connected to."""
    if item.block is None:
        return
    for gap, ends in ((item.layer, item.left), (item.layer + 1, item.right)):
        heights = {
            id(end): _mean(
                [
                    other.y
                    for other in layout.left_ends(gap, end.net) + layout.right_ends(gap, end.net)
                    if other.attachment is not end
                ]
                or [item.y]
            )
            for end in ends
        }
        ends.sort(key=lambda end: heights[id(end)])
        for index, end in enumerate(ends):
            end.offset = HEADER + PORT_PITCH * (index + 0.5)


def _wanted(layout: Layout, item: Item, forward: bool) -> float:
    """Return where an item's nets would run straight, looking back or ahead."""
    before = [
        other.y - end.offset for end in item.left for other in layout.left_ends(item.layer, end.net)
    ]
    after = [
        other.y - end.offset
        for end in item.right
        for other in layout.right_ends(item.layer + 1, end.net)
    ]
    near = (before or after) if forward else (after or before)
    return _mean(near) if near else item.y


def _mean(values: list[float]) -> float:
    return sum(values) / len(values)
