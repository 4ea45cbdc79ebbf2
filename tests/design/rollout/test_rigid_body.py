"""Oracle: Drake's discrete plant, one step of it."""

from pathlib import Path

import numpy as np
import pytest
from pydrake.multibody.math import SpatialForce
from pydrake.multibody.plant import ExternallyAppliedSpatialForce
from pydrake.systems.framework import DiagramBuilder

from workbench.design.rollout.rigid_body import fly_on, rigid_body
from workbench.plant.description import read_description
from workbench.plant.loading import make_vehicle
from workbench.plant.multibody import add_plant
from workbench.plant.variation import Variation, varied
from workbench.resources import find_model

STEP = 1 / 1024
DRONES = Path(__file__).resolve().parents[2] / "drones"
FILES = {
    "dh_drone": find_model("dh_drone"),
    "low_mass_quad": DRONES / "low_mass_quad.urdf.xacro",
    "h_quad": DRONES / "h_quad.urdf.xacro",
}


def random_motion(rng: np.random.Generator) -> tuple[np.ndarray, np.ndarray]:
    """Return a state, whose quaternion is not of unit length, and a wrench in B."""
    q_WB = rng.normal(size=4)
    q_WB *= rng.uniform(0.9, 1.1) / np.linalg.norm(q_WB)
    state = np.concatenate([q_WB, [3.0, -2.0, 50.0], 8.0 * rng.normal(size=3), rng.normal(size=3)])
    return state, np.concatenate([20.0 * rng.normal(size=3), rng.normal(size=3)])


@pytest.mark.parametrize("variation", [Variation(), Variation(mass=1.3, inertia=0.6)], ids=str)
@pytest.mark.parametrize("name", FILES)
def test_a_step_is_the_plants(name, variation):
    description = read_description(FILES[name])
    vehicle = make_vehicle(description)
    builder = DiagramBuilder()
    flown = varied(description, vehicle, variation)
    plant, _ = add_plant(builder, flown, time_step=STEP)
    diagram = builder.Build()
    root = diagram.CreateDefaultContext()
    context = plant.GetMyMutableContextFromRoot(root)
    base = plant.GetBodyByName(vehicle.base_link)
    rng = np.random.default_rng(1)
    for _ in range(10):
        state, wrench = random_motion(rng)
        plant.SetPositionsAndVelocities(context, state)
        R_WB = base.EvalPoseInWorld(context).rotation().matrix()
        force = ExternallyAppliedSpatialForce()
        force.body_index = base.index()
        force.F_Bq_W = SpatialForce(tau=R_WB @ wrench[3:], f=R_WB @ wrench[:3])
        plant.get_applied_spatial_force_input_port().FixValue(context, [force])
        after = plant.EvalUniquePeriodicDiscreteUpdate(context).get_vector().CopyToVector()
        body = rigid_body(vehicle, variation)
        assert fly_on(state, wrench, body, STEP, 1) == pytest.approx(after, abs=1e-12)


def test_steps_follow_one_another(vehicle):
    state, wrench = random_motion(np.random.default_rng(2))
    body = rigid_body(vehicle, Variation())
    one_by_one = tuple(state)
    for _ in range(5):
        one_by_one = fly_on(one_by_one, wrench, body, STEP, 1)
    assert fly_on(state, wrench, body, STEP, 5) == one_by_one
    assert fly_on(state, wrench, body, STEP, 0) == tuple(state)
