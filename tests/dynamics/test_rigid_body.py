"""Oracles: Drake's accelerations of the same body, and what a free body keeps."""

import numpy as np
import pytest
from pydrake.common.eigen_geometry import Quaternion
from pydrake.math import RotationMatrix
from pydrake.systems.framework import DiagramBuilder

from workbench.dynamics.rigid_body import (
    accelerations,
    into_body,
    middle,
    moved,
    rigid_body,
    rotation,
)
from workbench.plant.multibody import add_plant

C = (0.03, -0.05, 0.1)
STILL = [0.0] * 6


def test_accelerations_are_drakes(description, vehicle):
    builder = DiagramBuilder()
    plant, _ = add_plant(builder, description, time_step=0.0)
    context = plant.GetMyMutableContextFromRoot(builder.Build().CreateDefaultContext())
    body = rigid_body(vehicle.mass, vehicle.inertia, vehicle.p_BoBcm_B)
    rng = np.random.default_rng(1)
    for _ in range(20):
        q = rng.normal(size=4)
        state = np.concatenate([q / np.linalg.norm(q), [3.0, -2.0, 50.0], 8 * rng.normal(size=6)])
        wrench = np.concatenate([20.0 * rng.normal(size=3), rng.normal(size=3)])
        plant.SetPositionsAndVelocities(context, state)
        R_WB = RotationMatrix(Quaternion(state[:4])).matrix()
        forces = np.concatenate([R_WB @ wrench[3:], R_WB @ wrench[:3]])
        plant.get_applied_generalized_force_input_port().FixValue(context, forces)
        wanted = plant.get_generalized_acceleration_output_port().Eval(context)
        R = rotation(state[:4])
        found = accelerations(R, into_body(R, state[7:10]), STILL, 0.0, wrench, *body)
        assert found == pytest.approx(wanted, rel=1e-9, abs=1e-9)


@pytest.mark.parametrize(("rate", "step"), [(17.5, 1 / 1024), (8.8, 1 / 1024), (17.5, 1 / 512)])
def test_a_free_body_keeps_angular_momentum_and_energy(vehicle, rate, step):
    """Torque-free, 5 s: within 0.01 and 0.05 %, and four times that at twice the step."""
    body = rigid_body(vehicle.mass, vehicle.inertia, C)
    state = np.zeros(13)
    state[0], state[7:10] = 1.0, rate * np.array([0.6, 0.5, 0.62450])
    last = accelerations(rotation(state[:4]), state[7:10], STILL, 0.0, STILL, *body)

    def kept() -> tuple[np.ndarray, float]:
        w_B = np.array(into_body(rotation(state[:4]), state[7:10]))
        momentum = RotationMatrix(Quaternion(state[:4])).matrix() @ vehicle.inertia @ w_B
        return momentum, float(w_B @ vehicle.inertia @ w_B)

    momentum, energy = kept()
    for _ in range(round(5.0 / step)):
        R, w, _ = middle(state, last, step)
        last = accelerations(R, into_body(R, w), last, step, STILL, *body)
        state = np.array(moved(state, last, step))
        state[:4] /= np.linalg.norm(state[:4])
    after, after_energy = kept()
    share = (step * 1024) ** 2
    assert np.linalg.norm(after - momentum) < share * 1e-4 * np.linalg.norm(momentum)
    assert abs(after_energy - energy) < share * 5e-4 * energy


def test_a_quaternion_keeps_its_length(vehicle):
    body = rigid_body(vehicle.mass, vehicle.inertia, C)
    state, last = np.array([1.0, *[0.0] * 6, 20.0, -15.0, 10.0, 0.0, 0.0, 0.0]), STILL
    for _ in range(2048):
        R, w, _ = middle(state, last, 1 / 1024)
        last = accelerations(R, into_body(R, w), last, 1 / 1024, STILL, *body)
        state = np.array(moved(state, last, 1 / 1024))
        assert state[:4] @ state[:4] == pytest.approx(1.0, abs=1e-12)


def test_a_quaternion_of_any_length_turns_a_vector_alike():
    assert into_body(rotation([2.0, 0, 0, 2.0]), [1.0, 0, 0]) == pytest.approx([0, -1, 0])
