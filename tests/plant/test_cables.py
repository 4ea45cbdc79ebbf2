"""The rate of a cable's length beside differences of the distance between its ends."""

import numpy as np
import pytest
from pydrake.math import RigidTransform, RollPitchYaw
from pydrake.multibody.math import SpatialVelocity
from pydrake.multibody.plant import MultibodyPlant
from pydrake.multibody.tree import SpatialInertia

from workbench.plant.cables import cable_distance, cable_stretch

P_UPPER, P_LOWER = np.array([0.1, -0.05, -0.2]), np.array([0.03, 0.02, 0.1])


@pytest.fixture
def pair():
    """Return a plant of two free bodies with its context, and an end on each."""
    plant = MultibodyPlant(0.0)
    inertia = SpatialInertia.SolidSphereWithMass(1.0, 0.1)
    bodies = [plant.AddRigidBody(name, inertia) for name in ("upper", "lower")]
    plant.Finalize()
    ends = tuple(zip(bodies, (P_UPPER, P_LOWER), strict=True))
    return plant, plant.CreateDefaultContext(), ends


def test_a_cable_gets_longer_as_its_ends_move_apart(pair):
    plant, context, ends = pair
    draw, step = np.random.default_rng(6), 1e-6
    for body, _ in ends:
        turn = RollPitchYaw(*draw.uniform(-1.0, 1.0, 3))
        plant.SetFreeBodyPose(context, body, RigidTransform(turn, draw.normal(size=3)))
    q = plant.GetPositions(context)
    v = draw.normal(size=plant.num_velocities())
    rate = cable_stretch(plant, context, ends) @ v
    dq = plant.MapVelocityToQDot(context, v)
    lengths = []
    for sign in (1.0, -1.0):
        plant.SetPositions(context, q + sign * step * dq)
        lengths.append(cable_distance(plant, context, ends))
    assert rate == pytest.approx((lengths[0] - lengths[1]) / (2.0 * step), rel=1e-6)


def test_a_cable_whose_ends_meet_gets_longer_as_its_load_falls(pair):
    plant, context, ends = pair
    (upper, _), (lower, _) = ends
    plant.SetFreeBodyPose(context, upper, RigidTransform())
    plant.SetFreeBodyPose(context, lower, RigidTransform(P_UPPER - P_LOWER))
    assert cable_distance(plant, context, ends) < 1e-12
    still, falling = np.zeros(6), np.array([0.0, 0.0, 0.0, 0.0, 0.0, -2.0])
    plant.SetFreeBodySpatialVelocity(context, upper, SpatialVelocity(still))
    plant.SetFreeBodySpatialVelocity(context, lower, SpatialVelocity(falling))
    stretch = cable_stretch(plant, context, ends) @ plant.GetVelocities(context)
    assert stretch == pytest.approx(2.0, abs=1e-12)
