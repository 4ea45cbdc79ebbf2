"""Draw nets as horizontal and vertical lines: each gap between columns has a track for each net."""

from dataclasses import dataclass

from workbench.design.block_layout import Layout

_TRACK_PITCH = 11.0
_MARGIN = 16.0


@dataclass(frozen=True)
class Line:
    """A straight piece of a net."""

    x1: float
    y1: float
    x2: float
    y2: float


@dataclass(frozen=True)
class Wire:
    """A net's lines, the dots where it branches, and the points at which it enters a block."""

    net: int
    lines: tuple[Line, ...]
    dots: tuple[tuple[float, float], ...]
    heads: tuple[tuple[float, float], ...]


@dataclass(frozen=True)
class Column:
    """Where a column of blocks stands; all its blocks are as wide as it is."""

    x: float
    width: float


@dataclass(frozen=True)
class Routing:
    """All wires, the columns, and the width of the picture."""

    wires: tuple[Wire, ...]
    columns: tuple[Column, ...]
    width: float


@dataclass(frozen=True)
class _Crossing:
    """A net in a gap: heights of its ends on either side."""

    net: int
    left: tuple[float, ...]
    right: tuple[float, ...]

    @property
    def span(self) -> tuple[float, float]:
        ends = self.left + self.right
        return min(ends), max(ends)


def route(layout: Layout) -> Routing:
    """Return the wires of a layout."""
    nets = range(len(layout.graph.nets))
    gaps = []
    for gap in range(len(layout.layers) + 1):
        crossings = [
            _Crossing(
                net,
                tuple(end.y for end in layout.left_ends(gap, net)),
                tuple(end.y for end in layout.right_ends(gap, net)),
            )
            for net in nets
        ]
        gaps.append(_in_order([each for each in crossings if each.left or each.right]))
    columns, tracks, x = [], [], 0.0
    for gap, crossings in enumerate(gaps):
        tracks.append({c.net: x + _MARGIN + _TRACK_PITCH * i for i, c in enumerate(crossings)})
        x += 2.0 * _MARGIN + _TRACK_PITCH * max(0, len(crossings) - 1) if crossings else 0.0
        if gap < len(layout.layers):
            columns.append(Column(x, max(item.width for item in layout.layers[gap])))
            x += columns[-1].width
    wires = tuple(_wire(layout, net, tracks, columns) for net in nets)
    return Routing(wires, tuple(columns), x)


def _in_order(crossings: list[_Crossing]) -> list[_Crossing]:
    """Return a gap's nets so ordered from left to right that few lines cross or coincide."""
    order = sorted(crossings, key=lambda each: each.span)
    for each in [*order, *order]:  # move each to its best place, twice
        rest = [other for other in order if other is not each]
        tries = [[*rest[:place], each, *rest[place:]] for place in range(len(order))]
        order = min(tries, key=_total_conflicts)
    return order


def _total_conflicts(order: list[_Crossing]) -> int:
    return sum(_conflicts(a, b) for i, a in enumerate(order) for b in order[i + 1 :])


def _conflicts(a: _Crossing, b: _Crossing) -> int:
    """Count where nets meet if `a` has its track left of `b`'s."""
    crossing = sum(a.span[0] < y < a.span[1] for y in b.left)
    crossing += sum(b.span[0] < y < b.span[1] for y in a.right)
    coinciding = sum(abs(y - other) < 4.0 for y in b.left for other in a.right)
    return crossing + 20 * coinciding


def _wire(layout: Layout, net: int, tracks: list[dict[int, float]], columns: list[Column]) -> Wire:
    """Return one net's lines, gap by gap and column by column."""
    lines: list[Line] = []
    dots: list[tuple[float, float]] = []
    heads: list[tuple[float, float]] = []
    for gap, track in enumerate(tracks):
        if net not in track:
            continue
        x = track[net]
        lefts, rights = layout.left_ends(gap, net), layout.right_ends(gap, net)
        heights = sorted(end.y for end in lefts + rights)
        lines.append(Line(x, heights[0], x, heights[-1]))
        dots += [(x, y) for y in _branches([e.y for e in lefts], [e.y for e in rights])]
        for end in lefts:
            column = columns[gap - 1]
            begin = column.x + column.width if end.item.block else column.x
            lines.append(Line(begin, end.y, x, end.y))
        for end in rights:
            lines.append(Line(x, end.y, columns[gap].x, end.y))
            if end.item.block:
                heads.append((columns[gap].x, end.y))
    return Wire(net, tuple(_joined(lines)), tuple(dots), tuple(heads))


def _joined(lines: list[Line]) -> list[Line]:
    """Return lines with level ones that continue each other made one."""
    upright = [line for line in lines if line.y1 != line.y2]
    level: list[Line] = []
    for line in sorted((line for line in lines if line.y1 == line.y2), key=lambda e: (e.y1, e.x1)):
        if level and level[-1].y1 == line.y1 and line.x1 <= level[-1].x2:
            level[-1] = Line(level[-1].x1, line.y1, max(level[-1].x2, line.x2), line.y1)
        else:
            level.append(line)
    return upright + level


def _branches(lefts: list[float], rights: list[float]) -> list[float]:
    """Return the heights at which a vertical line has three or more arms."""
    heights = lefts + rights
    return [
        y
        for y in sorted(set(heights))
        if heights.count(y) + (y > min(heights)) + (y < max(heights)) > 2
    ]
