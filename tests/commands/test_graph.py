"""`workbench graph`: the picture says what the diagram is."""

import re
import shutil
import xml.etree.ElementTree as ET
from pathlib import Path

import pytest

DOCS = Path(__file__).resolve().parent.parent.parent / "docs"
SVG = "{http://www.w3.org/2000/svg}"


@pytest.fixture(scope="module")
def drawn(run, tmp_path_factory):
    file = tmp_path_factory.mktemp("graph") / "diagram.dot"
    return run("graph", "--json", "--output", file), file


def connections(dot):
    """Return the edges of a DOT text."""
    return sorted(re.findall(r'\[id="(.+?)"', dot.read_text()))


def drawn_connections(svg):
    """Return the edges of Graphviz's picture."""
    groups = ET.parse(svg).getroot().iter(f"{SVG}g")
    return sorted(each.get("id") for each in groups if each.get("class") == "edge")


def test_every_system_is_named_and_every_net_joins_known_ports(drawn):
    said, file = drawn
    assert said.code == 0
    blocks = {block["name"]: block for block in said.json["blocks"]}
    assert {"plant + scene_graph", "rotors", "body_forces", "flight_imu", "controller"} <= set(
        blocks
    )
    assert {"modes", "battery", "recorder"} <= set(blocks)
    for name in blocks:
        assert f'"{name}" [label=' in file.read_text()
    assert len(connections(file)) == sum(len(net["sinks"]) for net in said.json["nets"]) > 10
    for net in said.json["nets"]:
        assert net["source"]["port"] in blocks[net["source"]["block"]]["outputs"]
        for sink in net["sinks"]:
            assert sink["port"] in blocks[sink["block"]]["inputs"]


def test_the_core_has_its_ports(run, out):
    said = run("graph", "--core", "--output", out / "core.dot")
    assert said.code == 0
    assert "reference" in said.out
    assert "outputs.state" in said.out


def test_equal_diagrams_give_equal_text(run, out, drawn):
    assert run("graph", "--output", out / "again.dot").code == 0
    assert (out / "again.dot").read_bytes() == drawn[1].read_bytes()


def test_the_documentation_shows_the_diagram_that_flies(drawn):
    """Graphviz's versions place blocks differently, so only what they connect is compared."""
    assert drawn_connections(DOCS / "diagram.svg") == connections(drawn[1]), (
        "the diagram has changed: run `workbench graph --output docs/diagram.svg`"
    )


@pytest.mark.skipif(shutil.which("dot") is None, reason="Graphviz draws it: install graphviz")
def test_graphviz_draws_it(run, out, drawn):
    assert run("graph", "--output", out / "diagram.svg").code == 0
    assert drawn_connections(out / "diagram.svg") == connections(drawn[1])


def test_without_graphviz_it_is_text(run, refused, drawn, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("PATH", "")
    said = run("graph")
    assert said.code == 0 and "controller" in said.out
    assert "Graphviz is not installed: for a picture, install Graphviz" in said.err
    assert Path("out/diagram.dot").read_bytes() == drawn[1].read_bytes()
    assert "or write DOT to a.dot" in refused("graph", "--output", "a.svg")


def test_bad_input_is_a_sentence(refused, tmp_path, out):
    assert f"{tmp_path}: is a folder" in refused("graph", "--output", tmp_path)
    assert "ends in .svg, .pdf" in refused("graph", "--output", out.with_suffix(".jpg"))
    assert "dh_drone" in refused("graph", "--model", "dh_dron", "--output", out.with_suffix(".dot"))
    assert not out.parent.exists()
