"""Block diagrams: what is read of a Drake diagram, and the DOT text of it."""

import re

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

from workbench.design.block_graph import (
    Block,
    BlockGraph,
    Net,
    Terminal,
    block_dot,
    read_block_graph,
)
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


def test_the_text_has_a_node_a_block_and_an_edge_a_connection(graph):
    text = block_dot(graph)
    nodes = re.findall(r'^  "([^"]+)" \[label=<(.*)>\];$', text, re.MULTILINE)
    assert [name for name, _ in nodes] == [block.name for block in graph.blocks]
    cells = {
        (name, port): said
        for name, table in nodes
        for port, said in re.findall(r'<td port="(\w+)" align="\w+">([^<]+)</td>', table)
    }
    edges = [
        (Terminal(a, cells[a, out]), Terminal(b, cells[b, into]))
        for a, out, b, into in re.findall(
            r'^  "(.+)":(o\d+):e -> "(.+)":(i\d+):w ', text, re.MULTILINE
        )
    ]
    assert edges == [(net.source, sink) for net in graph.nets for sink in net.sinks]
    assert ('tooltip="gain.y0 (2)"' in text) == (graph.name == "loop")


def test_names_may_have_any_letters():
    ends = Terminal('a "<&\\', "<b>"), Terminal("c & d", "e")
    blocks = Block(ends[0].block, "A<B>", (), ("<b>",)), Block("c & d", "C", ("e",), ())
    text = block_dot(BlockGraph("x", blocks, (Net(ends[0], (ends[1],), 1),)))
    assert '"a \\"<&\\\\":o0:e -> "c & d":i0:w' in text
    assert ">&lt;b&gt;</td>" in text and "A&lt;B&gt;" in text
