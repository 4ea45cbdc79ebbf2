"""What of a drone touches what in Drake's scene graph, and what the springs of its joints do."""

import numpy as np
import pytest
from pydrake.geometry import Role, Sphere
from pydrake.math import RigidTransform
from pydrake.systems.framework import DiagramBuilder

from tests.jointed import drone, joint, link
from workbench.plant.description import read_description
from workbench.plant.multibody import add_plant

SIDES = (0.3, 0.2, 0.1)
RADIUS, LENGTH = 0.15, 0.08
SHAPES = {
    "box": ('<box size="0.3 0.2 0.1"/>', SIDES),
    "cylinder": (
        f'<cylinder radius="{RADIUS}" length="{LENGTH}"/>',
        (2.0 * RADIUS, 2.0 * RADIUS, LENGTH),
    ),
}


def built(path: str):
    """Return a drone's plant and scene graph, the context of the plant, and what holds it."""
    builder = DiagramBuilder()
    plant, scene_graph = add_plant(builder, read_description(path), time_step=0.0)
    diagram = builder.Build()
    root = diagram.CreateDefaultContext()
    return plant, scene_graph, plant.GetMyMutableContextFromRoot(root), (diagram, root)


@pytest.mark.parametrize("name", SHAPES)
def test_the_spheres_at_corners_touch_the_faces_from_inside(tmp_path, name):
    """So a drone rests on its faces: all spheres together are as wide as the shape on each axis."""
    shape, sides = SHAPES[name]
    parts = link("pad", 0.1, shape=shape) + joint("weld", "fixed", "base", "pad", (0, 0, -0.2))
    plant, scene_graph, *_ = built(drone(tmp_path, parts))
    inspector = scene_graph.model_inspector()
    frame = plant.GetBodyFrameIdOrThrow(plant.GetBodyByName("base").index())
    ends = []
    for geometry in inspector.GetGeometries(frame, Role.kProximity):
        if isinstance(sphere := inspector.GetShape(geometry), Sphere):
            centre = inspector.GetPoseInFrame(geometry).translation()
            ends.append((centre - sphere.radius(), centre + sphere.radius()))
    low, high = np.min([low for low, _ in ends], axis=0), np.max([high for _, high in ends], axis=0)
    assert 0.5 * (low + high) == pytest.approx([0.0, 0.0, -0.2], abs=1e-9)
    assert high - low == pytest.approx(sides, abs=1e-9)


def test_bodies_of_a_drone_that_overlap_do_not_touch(tmp_path):
    parts = ""
    for name, parent in (("a", "base"), ("b", "a"), ("c", "b")):
        parts += link(name, 0.1, shape='<sphere radius="0.1"/>')
        parts += joint(f"to_{name}", "continuous", parent, name)
    plant, _, context, _held = built(drone(tmp_path, parts))
    for height, contacts in ((5.0, 0), (0.05, 3)):  # below 0.1 m each touches the ground
        base = plant.GetBodyByName("base")
        plant.SetFreeBodyPose(context, base, RigidTransform([0.0, 0.0, height]))
        results = plant.get_contact_results_output_port().Eval(context)
        assert results.num_point_pair_contacts() == contacts


def test_a_spring_of_a_joint_pulls_to_its_rest(tmp_path):
    """k (rest - q), the arm's centre of mass on its hinge, so that nothing else turns it."""
    spring = '<dynamics stiffness="2.0" rest="0.3"/>'
    parts = link("arm", 0.1) + joint("hinge", "continuous", "base", "arm", more=spring)
    plant, _, context, _held = built(drone(tmp_path, parts))
    base, hinge = plant.GetBodyByName("base"), plant.GetJointByName("hinge")
    plant.SetFreeBodyPose(context, base, RigidTransform([0.0, 0.0, 5.0]))
    for angle in (-0.2, 0.3, 0.8):
        hinge.set_angle(context, angle)
        slopes = plant.get_generalized_acceleration_output_port().Eval(context)
        torques = plant.CalcMassMatrix(context) @ slopes
        torque = torques[hinge.velocity_start()]
        assert torque == pytest.approx(2.0 * (0.3 - angle), abs=1e-9)
