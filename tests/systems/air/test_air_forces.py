"""A wrench commanded is the wrench applied."""

import numpy as np
import pytest
from pydrake.common.eigen_geometry import Quaternion
from pydrake.math import RigidTransform, RotationMatrix
from pydrake.multibody.plant import Propeller
from pydrake.systems.framework import DiagramBuilder

from workbench.plant.multibody import add_plant
from workbench.systems.air.air_forces import air_forces


def test_it_applies_force_and_moment_about_the_origin_in_the_body_frame(description, vehicle):
    builder = DiagramBuilder()
    plant, _ = add_plant(builder, description, time_step=0.0)
    forces = builder.AddSystem(Propeller(air_forces(plant, vehicle.base_link)))
    builder.Connect(plant.get_body_poses_output_port(), forces.get_body_poses_input_port())
    root = builder.Build().CreateDefaultContext()
    base = plant.GetBodyByName(vehicle.base_link)
    rng = np.random.default_rng(9)
    for _ in range(20):
        q = rng.normal(size=4)
        R_WB = RotationMatrix(Quaternion(q / np.linalg.norm(q)))
        pose = RigidTransform(R_WB, rng.normal(size=3))
        plant.SetFreeBodyPose(plant.GetMyMutableContextFromRoot(root), base, pose)
        wrench = rng.normal(size=6)
        context = forces.GetMyMutableContextFromRoot(root)
        forces.get_command_input_port().FixValue(context, wrench)
        applied = forces.get_spatial_forces_output_port().Eval(context)
        total = sum(F.F_Bq_W.Shift(-(R_WB @ F.p_BoBq_B)).get_coeffs() for F in applied)
        force, moment = R_WB @ wrench[:3], R_WB @ wrench[3:]
        assert total == pytest.approx([*moment, *force], abs=1e-12)
        assert {F.body_index for F in applied} == {base.index()}
