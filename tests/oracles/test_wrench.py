"""`wrench_matrix` against what the plant feels: generalised forces by inverse dynamics."""

import numpy as np
import pytest
from pydrake.common.eigen_geometry import Quaternion
from pydrake.math import RotationMatrix
from pydrake.multibody.tree import MultibodyForces

from workbench.plant.rotors import wrench_matrix


def felt(rig) -> np.ndarray:
    """Return torque about the base link's origin and force, in W, of all but gravity."""
    forces = MultibodyForces(rig.plant)
    rig.plant.CalcForceElementsContribution(rig.context, forces)
    return rig.plant.CalcInverseDynamics(rig.context, rig.accelerations(), forces)


def test_thrusts_act_on_the_plant_as_the_wrench_matrix_says(rig):
    rng = np.random.default_rng(22)
    vehicle = rig.vehicle
    matrix = wrench_matrix(vehicle.rotors, vehicle.p_BoBcm_B)
    constants = np.array([rotor.motor_constant for rotor in vehicle.rotors])
    for _ in range(200):
        q = rng.normal(size=4)
        q /= np.linalg.norm(q)
        speeds = rng.uniform(0, 1100, 4)
        rig.set_state([*q, *rng.uniform(5, 9, 3), *rng.uniform(-5, 5, 6)])
        rig.set_speeds(speeds)
        wrench_B = matrix @ (constants * speeds**2)
        R_WB = RotationMatrix(Quaternion(q)).matrix()
        force, moment = R_WB @ wrench_B[:3], R_WB @ wrench_B[3:]
        about_origin = moment + np.cross(R_WB @ vehicle.p_BoBcm_B, force)
        assert felt(rig) == pytest.approx(np.concatenate([about_origin, force]), abs=1e-9)
