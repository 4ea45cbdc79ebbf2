"""Oracles: Drake's accelerations of the same body, and what a free body keeps."""

import numpy as np
import pytest
from pydrake.common.eigen_geometry import Quaternion
from pydrake.math import RotationMatrix
from pydrake.systems.framework import DiagramBuilder
from scipy.integrate import solve_ivp

from workbench.dynamics.rigid_body import (
    body_acceleration,
    into_body,
    quaternion_rate,
    rigid_body,
    rotation,
)
from workbench.plant.multibody import add_plant

C = (0.03, -0.05, 0.1)
NOTHING = [0.0] * 3


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
        w_B = into_body(R, state[7:10])
        found = body_acceleration(R, w_B, wrench[:3], wrench[3:], *body)
        assert found == pytest.approx(wanted, rel=1e-9, abs=1e-9)


def rates(body, state):
    R, q, w = rotation(state[:4]), state[:4], state[7:10]
    six = body_acceleration(R, into_body(R, w), NOTHING, NOTHING, *body)
    return [*quaternion_rate(q, w), *state[10:13], *six]


@pytest.mark.parametrize("rate", [17.5, 8.8])
def test_a_free_body_keeps_angular_momentum_and_energy(vehicle, rate):
    """Torque-free, 5 s, beside a centre of mass that falls."""
    body = rigid_body(vehicle.mass, vehicle.inertia, C)
    state = np.zeros(13)
    state[0], state[7:10] = 1.0, rate * np.array([0.6, 0.5, 0.62450])

    def kept(state) -> tuple[np.ndarray, float]:
        w_B = np.array(into_body(rotation(state[:4]), state[7:10]))
        q = state[:4] / np.linalg.norm(state[:4])
        momentum = RotationMatrix(Quaternion(q)).matrix() @ vehicle.inertia @ w_B
        return momentum, float(w_B @ vehicle.inertia @ w_B)

    momentum, energy = kept(state)
    flown = solve_ivp(lambda _, x: rates(body, x), (0.0, 5.0), state, rtol=1e-9, atol=1e-9)
    after, after_energy = kept(flown.y[:, -1])
    assert np.linalg.norm(after - momentum) < 1e-5 * np.linalg.norm(momentum)
    assert after_energy == pytest.approx(energy, rel=1e-5)


def test_a_quaternion_keeps_its_length(vehicle):
    rng = np.random.default_rng(2)
    for q, w in zip(rng.normal(size=(20, 4)), rng.normal(size=(20, 3)), strict=True):
        assert q @ quaternion_rate(q, 10.0 * w) == pytest.approx(0.0, abs=1e-13)


def test_a_quaternion_of_any_length_turns_a_vector_alike():
    assert into_body(rotation([2.0, 0, 0, 2.0]), [1.0, 0, 0]) == pytest.approx([0, -1, 0])
