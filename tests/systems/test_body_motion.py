"""The motion of chosen bodies beside what Drake's plant says of each."""

import numpy as np
import pytest
from pydrake.math import RigidTransform, RollPitchYaw
from pydrake.multibody.math import SpatialAcceleration, SpatialVelocity
from pydrake.multibody.tree import BodyIndex

from workbench.systems.body_motion import BodyMotion_

CHOSEN = (2, 1)
"""Not in the order of the plant, and without the world."""


def test_states_and_accelerations_are_those_of_the_chosen_bodies_in_their_order():
    draw = np.random.default_rng(3)
    poses = [
        RigidTransform(RollPitchYaw(*draw.uniform(-1.0, 1.0, 3)), draw.normal(size=3))
        for _ in range(3)
    ]
    velocities = [SpatialVelocity(draw.normal(size=6)) for _ in range(3)]
    accelerations = [SpatialAcceleration(draw.normal(size=6)) for _ in range(3)]
    system = BodyMotion_[float](bodies=[BodyIndex(each) for each in CHOSEN])
    context = system.CreateDefaultContext()
    for name, values in (
        ("body_poses", poses),
        ("spatial_velocities", velocities),
        ("spatial_accelerations", accelerations),
    ):
        system.GetInputPort(name).FixValue(context, values)
    states = system.GetOutputPort("state").Eval(context).reshape(2, 13)
    found = system.GetOutputPort("acceleration").Eval(context).reshape(2, 6)
    for body, state, acceleration in zip(CHOSEN, states, found, strict=True):
        w, x, y, z = state[:4]
        R = np.array(  # of a unit quaternion, by hand
            [
                [1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)],
                [2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)],
                [2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)],
            ]
        )
        assert pytest.approx(R, abs=1e-12) == poses[body].rotation().matrix()
        assert state[4:7].tolist() == poses[body].translation().tolist()
        assert state[7:13].tolist() == velocities[body].get_coeffs().tolist()
        assert acceleration.tolist() == accelerations[body].get_coeffs().tolist()
