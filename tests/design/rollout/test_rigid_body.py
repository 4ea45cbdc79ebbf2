"""Oracle: Drake's discrete plant, one step of it."""

from pathlib import Path

import numpy as np
import pytest
from pydrake.multibody.math import SpatialForce
from pydrake.multibody.plant import ExternallyAppliedSpatialForce
from pydrake.systems.framework import DiagramBuilder

from workbench.design.rollout.rigid_body import (
    held_load,
    moved,
    rigid_body,
    rotation,
    velocity_changes,
)
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
        load = held_load(wrench, body.mass, body.p_BoBcm_B, STEP)
        turning = [STEP * number for number in body.inverse]
        R_WB, c, inertia = rotation(state[:4]), body.p_BoBcm_B, body.inertia
        changes = velocity_changes(R_WB, state[7:10], load, inertia, turning, c, STEP)
        stepped = moved(state, R_WB, changes, STEP)
        assert stepped == pytest.approx(after, abs=1e-12)
