"""Numbers in children of an element."""

from pathlib import Path

import pytest

from workbench.common.errors import WorkbenchError
from workbench.extras.formats import sdf_node
from workbench.extras.formats.sdf_node import Node
from workbench.plant.formats.xml import Element

FILE = Path("drone.sdf")


def parent(tag: str, text: str) -> Node:
    element, child = Element("parent"), Element(tag)
    element.file = child.file = FILE
    child.text, child.line = text, 7
    element.append(child)
    return Node(element, FILE, (1, 9), "", "__model__")


def test_a_missing_or_empty_number_has_the_default():
    assert sdf_node.sdf_number(parent("mass", "2.5"), "mass", 1.0) == 2.5
    assert sdf_node.sdf_number(parent("mass", " "), "mass", 1.0) == 1.0
    assert sdf_node.sdf_number(parent("weight", "2.5"), "mass", 1.0) == 1.0


def test_three_numbers_are_three():
    assert sdf_node.sdf_triple(parent("xyz", "1 2 3"), "xyz", (0.0, 0.0, 1.0)) == (1.0, 2.0, 3.0)
    assert sdf_node.sdf_triple(parent("xyz", ""), "xyz", (0.0, 0.0, 1.0)) == (0.0, 0.0, 1.0)
    with pytest.raises(WorkbenchError, match="give it 3 numbers"):
        sdf_node.sdf_triple(parent("xyz", "1 2"), "xyz", (0.0, 0.0, 1.0))
