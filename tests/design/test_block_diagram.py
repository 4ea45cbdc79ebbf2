"""Block diagrams: what is read of a Drake diagram, and that the picture shows it legibly."""

import itertools
import xml.etree.ElementTree as ET

import pytest
from pydrake.systems.framework import DiagramBuilder
from pydrake.systems.primitives import (
    Adder,
    ConstantVectorSource,
    Gain,
    Integrator,
    LogVectorOutput,
    Multiplexer,
    ZeroOrderHold,
)

from workbench.design.block_graph import Net, Terminal, read_block_graph
from workbench.design.block_layers import layers_of
from workbench.design.block_layout import lay_out
from workbench.design.block_svg import block_svg
from workbench.design.block_wires import route
from workbench.session.session import Session


def make_loop():
    """Return: source and feedback -> sum -> gain -> hold -> integrator, which is logged."""
    builder = DiagramBuilder()
    source = builder.AddNamedSystem("source", ConstantVectorSource([1.0, 2.0]))
    total = builder.AddNamedSystem("sum", Adder(2, 2))
    gain = builder.AddNamedSystem("gain", Gain(2.0, 2))
    hold = builder.AddNamedSystem("hold", ZeroOrderHold(0.01, 2))
    integrator = builder.AddNamedSystem("integrator", Integrator(2))
    bundle = builder.AddNamedSystem("bundle", Multiplexer([2, 2]))
    builder.Connect(source.get_output_port(), total.get_input_port(0))
    builder.Connect(integrator.get_output_port(), total.get_input_port(1))
    builder.Connect(total.get_output_port(), gain.get_input_port())
    builder.Connect(gain.get_output_port(), hold.get_input_port())
    builder.Connect(hold.get_output_port(), integrator.get_input_port())
    builder.Connect(integrator.get_output_port(), bundle.get_input_port(0))
    builder.Connect(total.get_output_port(), bundle.get_input_port(1))
    LogVectorOutput(bundle.get_output_port(), builder, 0.1).set_name("log")
    builder.ExportOutput(gain.get_output_port(), "answer")
    diagram = builder.Build()
    diagram.set_name("loop")
    return diagram


@pytest.fixture(scope="module", params=["loop", "workbench"])
def graph(request):
    return read_block_graph(make_loop() if request.param == "loop" else Session().diagram)


@pytest.fixture(scope="module")
def loop():
    return read_block_graph(make_loop())


def test_nets_are_the_diagrams_connections(loop):
    nets = {net.source.block: net for net in loop.nets}
    assert nets["source"] == Net(Terminal("source", "y0"), (Terminal("sum", "u0"),), 2)
    assert {sink.block for sink in nets["sum"].sinks} == {"gain", "recorder"}
    assert Terminal("outputs", "answer") in nets["gain"].sinks
    assert Terminal("recorder", "integrator") in nets["integrator"].sinks


def test_kinds_tell_the_class_and_the_period(loop):
    kinds = {block.name: block.kind for block in loop.blocks}
    assert kinds["gain"] == "Gain"
    assert kinds["hold"] == "ZeroOrderHold (10 ms)"
    assert kinds["recorder"] == "logs"


def test_signals_run_to_the_right_except_feedback(loop):
    layers = layers_of(loop)
    order = ["source", "sum", "gain", "hold", "integrator", "recorder"]
    assert [layers[name] for name in order] == sorted(layers[name] for name in order)
    assert len({layers[name] for name in order}) == len(order)
    assert layers["outputs"] == layers["recorder"]


def test_boxes_do_not_overlap_and_lanes_pass_between_them(graph):
    for layer in lay_out(graph).layers:
        for one, other in itertools.combinations(layer, 2):
            high, low = sorted((one, other), key=lambda item: item.y)
            if one.block or other.block:
                assert high.y + high.height <= low.y


def test_ports_lie_within_their_boxes(graph):
    for layer in lay_out(graph).layers:
        for item in filter(lambda item: item.block, layer):
            for end in item.left + item.right:
                assert 0.0 < end.offset < item.height


def test_every_net_is_one_connected_drawing(graph):
    layout = lay_out(graph)
    routing = route(layout)
    for wire, net in zip(routing.wires, graph.nets, strict=True):
        assert len(wire.heads) == len(net.sinks)
        reached = [wire.lines[0]]
        waiting = list(wire.lines[1:])
        while touching := [line for line in waiting if any(meet(line, one) for one in reached)]:
            reached += touching
            waiting = [line for line in waiting if line not in touching]
        assert not waiting, net.source


def meet(one, other):
    """Return whether two upright or level lines touch."""
    return all(
        max(min(a1, a2), min(b1, b2)) <= min(max(a1, a2), max(b1, b2)) + 1e-9
        for a1, a2, b1, b2 in (
            (one.x1, one.x2, other.x1, other.x2),
            (one.y1, one.y2, other.y1, other.y2),
        )
    )


def test_no_line_runs_through_a_box(graph):
    layout = lay_out(graph)
    routing = route(layout)
    boxes = [
        (column.x, item.y, column.x + column.width, item.y + item.height)
        for layer, column in zip(layout.layers, routing.columns, strict=True)
        for item in layer
        if item.block
    ]
    for wire in routing.wires:
        for line in wire.lines:
            left, right = sorted((line.x1, line.x2))
            top, bottom = sorted((line.y1, line.y2))
            for x1, y1, x2, y2 in boxes:
                inside = left < x2 - 1 and right > x1 + 1 and top < y2 - 1 and bottom > y1 + 1
                assert not inside, graph.nets[wire.net].source


def test_the_picture_is_svg_that_names_everything(graph):
    root = ET.fromstring(block_svg(graph))
    texts = [element.text for element in root.iter("{http://www.w3.org/2000/svg}text")]
    for block in graph.blocks:
        assert block.name in texts
        for ports in (block.inputs, block.outputs):
            assert len(ports) < 2 or set(ports) <= set(texts)
    titles = [element.text for element in root.iter("{http://www.w3.org/2000/svg}title")]
    assert len(titles) == len(graph.nets) + 1
