"""`workbench graph`: the picture says what the diagram is."""

import xml.etree.ElementTree as ET
from pathlib import Path

import pytest

DOCS = Path(__file__).resolve().parent.parent.parent / "docs"
SVG = "{http://www.w3.org/2000/svg}"


@pytest.fixture(scope="module")
def picture(run, tmp_path_factory):
    file = tmp_path_factory.mktemp("graph") / "diagram.svg"
    return run("graph", "--json", "--output", file), file


def test_every_system_is_named_in_the_picture(picture):
    said, file = picture
    assert said.code == 0
    texts = {element.text for element in ET.parse(file).getroot().iter(f"{SVG}text")}
    assert {block["name"] for block in said.json["blocks"]} <= texts
    assert {"controller", "modes", "battery", "recorder", "dynamics", "scene_graph"} <= texts


def test_every_net_of_the_picture_joins_known_ports(picture):
    said, _ = picture
    blocks = {block["name"]: block for block in said.json["blocks"]}
    assert said.json["nets"]
    for net in said.json["nets"]:
        assert net["source"]["port"] in blocks[net["source"]["block"]]["outputs"]
        for sink in net["sinks"]:
            assert sink["port"] in blocks[sink["block"]]["inputs"]


def test_the_core_has_its_ports(run, out):
    said = run("graph", "--core", "--output", out / "core.svg")
    assert said.code == 0
    assert "reference" in said.out
    assert "outputs.state" in said.out


def test_equal_diagrams_give_equal_pictures(run, out, picture):
    assert run("graph", "--output", out / "again.svg").code == 0
    assert (out / "again.svg").read_bytes() == picture[1].read_bytes()


def test_the_documentation_shows_the_diagram_that_flies(picture):
    assert (DOCS / "diagram.svg").read_bytes() == picture[1].read_bytes(), (
        "the diagram has changed: run `workbench graph --output docs/diagram.svg`"
    )


def test_bad_input_is_a_sentence(refused, tmp_path, out):
    assert f"{tmp_path}: is a folder" in refused("graph", "--output", tmp_path)
    assert "dh_drone" in refused("graph", "--model", "dh_dron", "--output", out.with_suffix(".svg"))
    assert not out.parent.exists()
