"""The inertia of a rotor about its axis, by hand, from every way of writing rotors."""

import dataclasses

import numpy as np
import pytest
from pydrake.math import RigidTransform, RollPitchYaw

from workbench.plant.description import read_rotors
from workbench.plant.model import Inertial, Link
from workbench.plant.remarks import Remarks
from workbench.plant.rotor_sources.motor_constants import spin_inertia

PLUGIN = """<plugin name="motor" filename="librotors_gazebo_motor_model.so">
  <jointName>joint_0</jointName><linkName>rotor_0</linkName><turningDirection>cw</turningDirection>
  <motorConstant>1e-5</motorConstant>{more}</plugin>"""
SIDECAR = """rotors: [{{joint: joint_0, direction: cw, motor_constant: 1.0e-5,
  moment_constant: 0.02, time_constant_up: 0.01, time_constant_down: 0.02,
  max_rot_velocity: 900{more}}}]"""
LINKED = 3e-5
"""Of the rotor's link about its joint's axis."""


def rotor_link(pose, name="rotor_0", mass=0.01, moments=(1e-6, 2e-5, LINKED), X_LI=None) -> Link:
    inertial = Inertial(mass, X_LI or RigidTransform(), moments, (0.0, 0.0, 0.0))
    return Link(name, pose, inertial, (), ())


@pytest.fixture
def spun(model, joint):
    """Return the inertia about a joint of links that hang on it, and what is remarked."""

    def spin(*links, axis=(0.0, 0.0, 1.0), kind="continuous", slowdown=1.0):
        remarks = Remarks()
        first, *others = links
        hinge = joint("joint_0", first, axis=axis, kind=kind)
        fixed = [
            dataclasses.replace(joint(f"weld_{i}", other, kind="fixed"), parent=first.name)
            for i, other in enumerate(others)
        ]
        quad = model(links=links, joints=[hinge, *fixed])
        found = spin_inertia(
            quad,
            hinge,
            motor_constant=1e-5,
            slowdown=slowdown,
            file=quad.source,
            remarks=remarks,
        )
        return found, [remark.kind for remark in remarks.found]

    return spin


def test_what_turns_counts_about_the_axis(spun):
    """About the joint's line: by its own axes, turned axes, Steiner's rule, and what is welded."""
    here = RigidTransform([0.2, 0.0, 0.05])
    plain = rotor_link(here)
    turned = rotor_link(here, X_LI=RigidTransform(RollPitchYaw(np.pi / 2, 0, 0), np.zeros(3)))
    aside = rotor_link(here, X_LI=RigidTransform([0.03, 0.04, 5.0]))
    weightless = rotor_link(here, mass=0.0)
    blade = rotor_link(RigidTransform([0.2, 0.1, 0.05]), "blade", mass=0.002)
    empty = Link("rotor_0", here, None, (), ())
    for links, settings, expected in (
        ([plain], {}, 3e-5),
        ([plain], {"axis": (0.0, 0.6, 0.8)}, 0.36 * 2e-5 + 0.64 * 3e-5),
        ([turned], {}, 2e-5),
        ([aside], {}, 3e-5 + 0.01 * 0.05**2),
        ([weightless], {}, 0.0),
        ([plain, blade], {}, 3e-5 + 3e-5 + 0.002 * 0.1**2),
        ([plain], {"kind": "fixed"}, 0.0),
        ([empty], {}, 0.0),
    ):
        found, remarks = spun(*links, **settings)
        assert found == pytest.approx(expected, rel=1e-12)
        assert remarks == []


def test_an_inertia_written_for_a_slower_simulation_is_the_rotors_own_again(spun):
    """A propeller of 10 g with 1e-5 N s² is some 24 cm across: at most 7e-5 kg m²."""
    for written, slowdown, expected, remarks in (
        (6e-5, 10.0, 6e-5, []),  # possible as it is
        (3e-4, 10.0, 3e-5, ["repaired"]),
        (3e-4, 1.0, 3e-4, ["assumed"]),  # nothing says why
        (3e-3, 10.0, 3e-3, ["assumed"]),  # nor is it so much
        (1e-7, 10.0, 1e-7, ["assumed"]),  # a placeholder
    ):
        link = rotor_link(RigidTransform(), moments=(1e-6, written, written))
        found, noted = spun(link, slowdown=slowdown)
        assert (found, noted) == (pytest.approx(expected), remarks)


def test_it_is_read_in_every_way_of_writing_rotors(model, tmp_path):
    """What is stated counts more than the link, 0 too."""
    quad = model()
    rotor = rotor_link(quad.links[1].X_ML)
    paper = '<plugin filename="libSetVelocity.so"><joint1>joint_0</joint1><link1>rotor_0</link1>{}'
    tag = "<rotorInertia>{}</rotorInertia>"
    sidecar = tmp_path / "mine.yaml"
    for plugin, beside, expected in (
        (PLUGIN.format(more=""), None, LINKED),
        (PLUGIN.format(more=tag.format(4e-5)), None, 4e-5),
        (PLUGIN.format(more=tag.format(0)), None, 0.0),
        (paper.format("</plugin>"), None, LINKED),
        (paper.format(f"{tag.format(4e-5)}</plugin>"), None, 4e-5),
        ("", SIDECAR.format(more=""), LINKED),
        ("", SIDECAR.format(more=", inertia: 4e-5"), 4e-5),
        ("", SIDECAR.format(more=", inertia: 0"), 0.0),
    ):
        described = model(plugin)
        links = (described.links[0], rotor, *described.links[2:])
        described = dataclasses.replace(described, links=links)
        if beside:
            sidecar.write_text(beside)
        found = read_rotors(described, "base", Remarks(), sidecar if beside else None)
        assert [each.inertia for each in found] == [pytest.approx(expected)]
