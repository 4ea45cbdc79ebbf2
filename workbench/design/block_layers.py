"""Sort blocks into columns so that signals run from left to right, as far as loops allow."""

from collections import deque

from workbench.design.block_graph import OUTPUTS, RECORDER, BlockGraph

_LISTENERS = (RECORDER, OUTPUTS)
"""Blocks that only listen; they stand in the last column."""

Edge = tuple[str, str]


def layers_of(graph: BlockGraph) -> dict[str, int]:
    """Return the column of each block, from 0.

    An edge to a block that fewer steps lead to from the sources is feedback. Along the others a
    block stands right of all that feed it, and a source just left of the first that it feeds.
    """
    edges = [
        (net.source.block, sink.block)
        for net in graph.nets
        for sink in net.sinks
        if sink.block not in _LISTENERS
    ]
    steps = _steps_from_sources(graph, edges)
    forward: list[Edge] = []
    for edge in sorted(edges, key=lambda edge: steps[edge[0]] - steps[edge[1]]):
        if steps[edge[0]] <= steps[edge[1]] and not _leads(edge[1], edge[0], forward):
            forward.append(edge)
    layers = dict.fromkeys(steps, 0)
    for _ in layers:  # the longest path has at most so many edges
        for a, b in forward:
            layers[b] = max(layers[b], layers[a] + 1)
    for name in layers:
        fed = [layers[b] for a, b in forward if a == name]
        if fed and name not in [b for _, b in forward]:
            layers[name] = min(fed) - 1
    last = max(layers.values()) + 1
    return layers | {b.name: last for b in graph.blocks if b.name in _LISTENERS}


def _steps_from_sources(graph: BlockGraph, edges: list[Edge]) -> dict[str, int]:
    """Return how many edges lead to each block from the nearest block without inputs."""
    steps = {block.name: 0 for block in graph.blocks if not block.inputs}
    waiting = deque(steps)
    rest = deque(block.name for block in graph.blocks if block.name not in _LISTENERS)
    while waiting or rest:
        name = waiting.popleft() if waiting else rest.popleft()
        steps.setdefault(name, 0)
        for a, b in edges:
            if a == name and b not in steps:
                steps[b] = steps[name] + 1
                waiting.append(b)
    return steps


def _leads(start: str, end: str, edges: list[Edge]) -> bool:
    """Return whether a path leads from start to end."""
    reached = {start}
    for _ in edges:
        reached |= {b for a, b in edges if a in reached}
    return end in reached
