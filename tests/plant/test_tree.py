"""The base link of a model, and what of it flies."""

from pathlib import Path

import pytest
from pydrake.math import RigidTransform

from workbench.common.errors import WorkbenchError
from workbench.plant.model import Joint, Link, Model
from workbench.plant.remarks import Remarks
from workbench.plant.tree import find_base_link, flying_tree, links_below

IDENTITY = RigidTransform()


def model(links: str, *joints: str) -> Model:
    """Build a model from names; a joint is `parent-child` or `parent-child:kind`."""
    found = []
    for text in joints:
        ends, _, kind = text.partition(":")
        parent, child = ends.split("-")
        found.append(Joint(ends, kind or "fixed", parent, child, IDENTITY, (0.0, 0.0, 1.0)))
    parts = tuple(Link(name, IDENTITY, None, (), ()) for name in links.split())
    return Model(Path("m.sdf"), "m", parts, tuple(found), (), (), ())


@pytest.mark.parametrize(
    ("links", "joints", "base"),
    [
        ("a", [], "a"),
        ("rotor body", ["body-rotor"], "body"),
        ("stray body r1 r2", ["body-r1", "body-r2"], "body"),
    ],
)
def test_the_base_is_the_root_that_carries_most(links, joints, base):
    assert find_base_link(model(links, *joints)) == base


@pytest.mark.parametrize(
    ("links", "joints", "said"),
    [
        ("a b", ["a-b", "b-a"], "here there is none"),
        ("world a b", ["world-a", "a-b"], "fixed to the world"),
        ("a", ["world-a"], "fixed to the world"),
        ("a world", ["a-world"], "a link is named 'world'"),
    ],
)
def test_what_cannot_fly_freely_is_refused(links, joints, said):
    with pytest.raises(WorkbenchError, match=said):
        find_base_link(model(links, *joints))


def test_all_that_hangs_below_is_found_in_loops_too():
    assert links_below(model("a b c d", "a-b", "b-c", "c-b"), "a") == {"a", "b", "c"}


def test_joints_that_turn_no_rotor_are_held_and_said():
    remarks = Remarks()
    drone = model("body r leg", "body-r:continuous", "body-leg:revolute")
    flying_tree(drone, "body", {"body-r"}, remarks)
    (remark,) = remarks.found
    assert (remark.kind, remark.element) == ("ignored", "joint 'body-leg'")
    assert "held at zero" in remark.text


def test_what_does_not_hang_on_the_base_is_left_out_and_said():
    remarks = Remarks()
    kept = flying_tree(model("body r stray far", "body-r", "stray-far"), "body", set(), remarks)
    assert [link.name for link in kept.links] == ["body", "r"]
    assert [joint.name for joint in kept.joints] == ["body-r"]
    assert {remark.element for remark in remarks.found} == {"link 'stray'", "link 'far'"}


def test_a_second_joint_on_a_link_is_left_out_and_said():
    remarks = Remarks()
    kept = flying_tree(model("a b c", "a-b", "a-c", "b-c"), "a", set(), remarks)
    assert [joint.name for joint in kept.joints] == ["a-b", "a-c"]
    assert remarks.found[0].element == "joint 'b-c'"
