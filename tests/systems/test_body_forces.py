"""Drag and push on a body against their closed forms."""

import numpy as np
import pytest
from pydrake.multibody.tree import BodyIndex
from scipy.spatial.transform import Rotation

from workbench.systems.body_forces import BodyForces_

AREA, DENSITY = 0.2, 1.1
CENTRE = (0.01, -0.02, 0.03)
BODY = BodyIndex(1)


@pytest.fixture
def forces():
    return BodyForces_[float](body=BODY, drag_area=AREA, air_density=DENSITY, p_BoBcm_B=CENTRE)


def fixed(forces, state, wind=None, push=None):
    context = forces.CreateDefaultContext()
    forces.GetInputPort("state").FixValue(context, state)
    for name, values in (("wind", wind), ("push", push)):
        if values is not None:
            forces.GetInputPort(name).FixValue(context, values)
    return context


def wrench(forces, context) -> np.ndarray:
    (force,) = forces.GetOutputPort("spatial_forces").Eval(context)
    assert force.body_index == BODY
    return np.array(force.F_Bq_W.get_coeffs())


def drawn(seed):
    rng = np.random.default_rng(seed)
    state = rng.normal(size=13) * 2.0
    return state, rng.normal(size=3) * 5.0, rng.normal(size=9)


def closed_form(state, wind, push) -> np.ndarray:
    """Return the wrench by scipy's rotations."""
    R_WB = Rotation.from_quat(state[[1, 2, 3, 0]]).as_matrix()
    arm = R_WB @ CENTRE
    v = state[10:13] + np.cross(state[7:10], arm) - wind
    drag = -0.5 * DENSITY * AREA * np.linalg.norm(v) * v
    moment = np.cross(arm, drag) + np.cross(R_WB @ push[3:6], push[:3]) + R_WB @ push[6:9]
    return np.concatenate([moment, drag + push[:3]])


def test_drag_acts_at_the_centre_of_mass_and_a_push_at_its_point(forces):
    for seed in range(20):
        given = drawn(seed)
        found = wrench(forces, fixed(forces, *given))
        assert found == pytest.approx(closed_form(*given), rel=1e-9, abs=1e-9)


def test_unconnected_the_air_is_still_and_nothing_pushes(forces):
    state, *_ = drawn(1)
    wanted = closed_form(state, np.zeros(3), np.zeros(9))
    assert wrench(forces, fixed(forces, state)) == pytest.approx(wanted, rel=1e-9, abs=1e-9)


def test_area_density_and_centre_are_live(forces):
    context = fixed(forces, *drawn(2)[:2])
    before = wrench(forces, context)
    for live in ([2 * AREA, DENSITY], [AREA, 2 * DENSITY]):
        context.get_mutable_numeric_parameter(0).SetFromVector(live)
        assert wrench(forces, context) == pytest.approx(2.0 * before)
    context.get_mutable_numeric_parameter(1).SetFromVector([0.0, 0.0, 0.0])
    assert wrench(forces, context)[:3].tolist() == [0.0, 0.0, 0.0]


def test_it_converts(forces):
    context = fixed(forces, *drawn(3))
    twin = forces.ToAutoDiffXd()
    mirror = twin.CreateDefaultContext()
    mirror.SetTimeStateAndParametersFrom(context)
    twin.FixInputPortsFrom(forces, context, mirror)
    (force,) = twin.GetOutputPort("spatial_forces").Eval(mirror)
    carried = [value.value() for value in force.F_Bq_W.get_coeffs()]
    assert carried == pytest.approx(wrench(forces, context), rel=1e-12)
