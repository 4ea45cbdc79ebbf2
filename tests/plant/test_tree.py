"""The base link of a model, and what of it flies."""

import dataclasses
from pathlib import Path

import pytest
from pydrake.math import RigidTransform

from workbench.common.errors import WorkbenchError
from workbench.plant.model import Freedom, Inertial, Joint, Link, Mimic, Model
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
        ("body r1 leg1 leg2", ["body-r1", "leg1-body", "leg2-body"], "body"),
        ("body r1 arm hand", ["body-r1", "body-arm", "hand-arm"], "body"),
        ("body r1 arm hand", ["body-r1", "hand-arm", "arm-body:revolute"], "body"),
        ("body r1 imu", ["body-r1", "imu-body"], "imu"),  # one rigid body
    ],
)
def test_the_base_is_the_root_that_carries_most_or_the_canonical_link(links, joints, base):
    drone = model(links, *joints)
    turn = (Freedom("revolute"),)
    joints = tuple(
        dataclasses.replace(each, freedoms=turn) if each.kind == "revolute" else each
        for each in drone.joints
    )
    canonical = drone.links[0].name
    drone = dataclasses.replace(drone, joints=joints, canonical_link=canonical)
    assert find_base_link(drone) == base


@pytest.mark.parametrize(
    ("links", "joints", "said"),
    [
        ("a b", ["a-b", "b-a"], "here there is none"),
        ("world a b", ["world-a", "a-b"], "fixed to the world"),
        ("a", ["world-a"], "fixed to the world"),
        ("a b", ["a-b", "world-b"], "'b' is fixed to the world by the joint 'world-b'"),
        ("a world", ["a-world"], "a link is named 'world'"),
    ],
)
def test_what_cannot_fly_freely_is_refused(links, joints, said):
    with pytest.raises(WorkbenchError, match=said):
        find_base_link(model(links, *joints))


def test_all_that_hangs_below_is_found_in_loops_too():
    assert links_below(model("a b c d", "a-b", "b-c", "c-b"), "a") == {"a", "b", "c"}


def test_joints_without_a_range_are_held_and_said():
    remarks = Remarks()
    drone = model("body r leg", "body-r:continuous", "body-leg:revolute")
    flying_tree(drone, "body", {"body-r"}, remarks)
    (remark,) = remarks.found
    assert (remark.kind, remark.element) == ("held", "joint 'body-leg'")
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


def test_a_joint_named_from_its_far_end_keeps_what_hangs_on_it():
    """In SDF the arm is the child of both; the tip would be left out, with its mass."""
    drone = model("body arm tip nail", "body-arm:revolute", "tip-arm:revolute", "tip-nail")
    freedoms = (Freedom("revolute", (0.0, 0.0, 1.0), lower=-0.5, upper=1.0),)
    joints = tuple(
        dataclasses.replace(each, freedoms=freedoms) if each.kind == "revolute" else each
        for each in drone.joints
    )
    remarks = Remarks()
    mass = Inertial(1.0, IDENTITY, (1.0, 1.0, 1.0), (0.0, 0.0, 0.0))
    links = tuple(dataclasses.replace(each, inertial=mass) for each in drone.links)
    drone = dataclasses.replace(drone, links=links, joints=joints)
    found = flying_tree(drone, "body", set(), remarks)
    assert [link.name for link in found.links] == ["body", "arm", "tip", "nail"]
    turned = found.joint("tip-arm")
    assert (turned.parent, turned.child) == ("arm", "tip")
    (freedom,) = turned.freedoms  # the tip turns back where the arm would turn
    assert freedom.axis_J == (0.0, 0.0, -1.0)
    assert (freedom.lower, freedom.upper) == (-0.5, 1.0)
    assert [each.element for each in remarks.found] == ["joint 'tip-arm'"]


def followers(names: str, *follows: str, **freedom) -> Model:
    """Return a chain of links, with joints "a", "b" .. between; each follows one, "" for none."""
    mass = Inertial(1.0, IDENTITY, (1.0, 1.0, 1.0), (0.0, 0.0, 0.0))
    links = tuple(Link(name, IDENTITY, mass, (), ()) for name in ("body", *names.split()))
    turn = Freedom("revolute", **freedom)
    joints = tuple(
        Joint(
            "abc"[i],
            "revolute",
            links[i].name,
            links[i + 1].name,
            IDENTITY,
            turn.axis_J,
            (turn,),
            Mimic(leader, 2.0, 0.1) if leader else None,
        )
        for i, leader in enumerate(follows)
    )
    return Model(Path("m.sdf"), "m", links, joints, (), (), ())


@pytest.mark.parametrize(
    ("follows", "names"),
    [("ba", "'a' and 'b'"), ("bca", "'a', 'b' and 'c'"), ("bcb", "'b' and 'c'")],
)
def test_joints_that_follow_each_other_are_refused_by_name(follows, names):
    drone = followers(" ".join(["arm", "tip", "nail"][: len(follows)]), *follows)
    with pytest.raises(WorkbenchError, match=f"joints {names} follow each other"):
        flying_tree(drone, "body", set(), Remarks())


def test_a_follower_of_a_follower_begins_where_both_ratios_bring_it():
    """By hand: c begins at its lower limit 0.2, b at 2 · 0.2 + 0.1, and a at 2 · 0.5 + 0.1."""
    drone = followers("arm tip nail", "b", "c", "", lower=0.2, upper=3.0)
    tree = flying_tree(drone, "body", set(), Remarks())
    starts = [tree.joint(name).freedoms[0].start for name in "abc"]
    assert starts == pytest.approx([1.1, 0.5, 0.2])


def test_a_follower_of_a_follower_of_a_held_joint_is_held():
    drone = followers("arm tip nail", "b", "c", "")
    held = dataclasses.replace(drone.joint("c"), freedoms=())
    drone = dataclasses.replace(drone, joints=(*drone.joints[:2], held))
    tree = flying_tree(drone, "body", set(), Remarks())
    assert not any(tree.joint(name).moves for name in "abc")


@pytest.mark.parametrize(("axis", "leader"), [(0, "arm::1"), (1, "arm::2"), (2, "")])
def test_a_joint_follows_the_axis_of_a_joint_with_several_that_it_names(axis, leader):
    mass = Inertial(1.0, IDENTITY, (1.0, 1.0, 1.0), (0.0, 0.0, 0.0))
    links = tuple(Link(name, IDENTITY, mass, (), ()) for name in ("body", "rod", "tip"))
    turn = Freedom("revolute")
    joints = (
        Joint("arm", "universal", "body", "rod", IDENTITY, turn.axis_J, (turn, turn)),
        Joint(
            "hand",
            "revolute",
            "rod",
            "tip",
            IDENTITY,
            turn.axis_J,
            (turn,),
            Mimic("arm", 2, 0, axis),
        ),
    )
    drone = Model(Path("m.sdf"), "m", links, joints, (), (), ())
    assert joints[0].reversed().place_of(axis) == (1, 0, 2)[axis]
    if not leader:
        with pytest.raises(WorkbenchError, match="'hand' follows 'arm', which has no such axis"):
            flying_tree(drone, "body", set(), Remarks())
        return
    assert flying_tree(drone, "body", set(), Remarks()).joint("hand").mimic.joint == leader
    far = dataclasses.replace(joints[0], parent="rod", child="body")  # named from its far end
    drone = dataclasses.replace(drone, joints=(far, joints[1]))
    assert flying_tree(drone, "body", set(), Remarks()).joint("hand").mimic.joint == leader
