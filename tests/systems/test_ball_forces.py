"""The torques in ball joints against MuJoCo's, rotations of scipy, and their derivatives."""

import math

import numpy as np
import pytest
from pydrake.autodiffutils import InitializeAutoDiff
from scipy.spatial.transform import Rotation

from workbench.systems.ball_forces import (
    FRICTION_SPEED,
    STOP_DAMPING_RATIO,
    STOP_RATE_RAD_S,
    BallRow,
    ball_quaternion,
    ball_torque,
)
from workbench.systems.joint_forces import JointForces_

MOBILITY = np.array([[4.0, 0.5, 0.0], [0.5, 2.0, 0.0], [0.0, 0.0, 10.0]])
FREE = BallRow("socket", 0, 0, math.inf, 0.0, 0.0, 0.0, MOBILITY)
NO_TURN = (1.0, 0.0, 0.0, 0.0)
ANGLES = ((0.3, -0.7, 1.1), (2.5, 1.3, -2.0), (-1.0, 0.2, 3.0))


@pytest.mark.parametrize("angles", ANGLES)
def test_a_spring_and_a_limit_are_those_of_mujoco(angles):
    """Its torques are in the child, and its limit has the direction of its constraint."""
    mujoco = pytest.importorskip("mujoco")
    model = mujoco.MjModel.from_xml_string(
        '<mujoco><compiler angle="radian"/><worldbody><body>'
        '<joint name="socket" type="ball" stiffness="0.8" range="0 0.5"/>'
        '<geom type="box" size=".1 .2 .3"/></body></worldbody></mujoco>'
    )
    data = mujoco.MjData(model)
    R = Rotation.from_euler("xyz", angles)
    data.qpos[:] = R.as_quat(scalar_first=True)
    mujoco.mj_forward(model, data)
    q = ball_quaternion(angles, NO_TURN)
    spring = ball_torque(FREE._replace(stiffness=0.8), q, (0.0, 0.0, 0.0))
    assert R.inv().apply(spring) == pytest.approx(data.qfrc_spring, abs=1e-9)
    limited = R.inv().apply(ball_torque(FREE._replace(max_angle=0.5), q, (0.0, 0.0, 0.0)))
    along = data.efc_J.reshape(-1, 3)[0]
    assert data.nefc == 1 and np.linalg.norm(along) == pytest.approx(1.0)
    assert limited / np.linalg.norm(limited) == pytest.approx(along, abs=1e-9)


@pytest.mark.parametrize("angles", ANGLES)
@pytest.mark.parametrize("speed", [0.0, 3.0, -500.0])
def test_a_limit_is_a_stiff_spring_with_damping_that_never_pulls(angles, speed):
    """Of the inertia that turns about the axis n of the rotation: 1 / (n · M⁻¹ n)."""
    turned = Rotation.from_euler("xyz", angles).as_rotvec()
    angle = float(np.linalg.norm(turned))
    n = turned / angle
    row = FREE._replace(max_angle=angle - 0.01)
    stop = STOP_RATE_RAD_S**2 * 0.01 + 2.0 * STOP_DAMPING_RATIO * STOP_RATE_RAD_S * speed
    torque = max(0.0, stop) / (n @ MOBILITY @ n)
    q = ball_quaternion(angles, NO_TURN)
    assert ball_torque(row, q, speed * n) == pytest.approx(-torque * n, abs=1e-9)
    within = FREE._replace(max_angle=angle + 1e-6)
    assert ball_torque(within, q, speed * n) == [0.0, 0.0, 0.0]


def test_friction_is_dry_about_each_axis_of_the_child():
    R = Rotation.from_euler("xyz", ANGLES[0])
    q = ball_quaternion(ANGLES[0], NO_TURN)
    found = ball_torque(FREE._replace(friction=0.2), q, R.apply([3.0, -5.0, 0.0]))
    smooth = [x / math.hypot(x, FRICTION_SPEED) for x in (3.0, -5.0, 0.0)]
    assert R.inv().apply(found) == pytest.approx([-0.2 * x for x in smooth], abs=1e-9)


@pytest.mark.parametrize("angles", [(0.0, 0.0, 0.0), *ANGLES])
def test_it_has_the_derivatives_of_its_equations(angles):
    """By central differences, also where the joint begins and its rotation has no axis."""
    row = FREE._replace(stiffness=0.8, friction=0.2, max_angle=0.5, position=1, velocity=2)
    sizes = {"positions": 5, "velocities": 6}
    state = np.concatenate([[9.0], angles, [9.0, 8.0, 7.0], [0.4, -0.3, 0.2], [6.0]])
    system = JointForces_[float](rows=(), balls=(row,), **sizes)

    def forces(at: np.ndarray) -> np.ndarray:
        context = system.CreateDefaultContext()
        system.GetInputPort("state").FixValue(context, at)
        return system.GetOutputPort("generalized_forces").Eval(context)

    exact = system.ToAutoDiffXd()
    context = exact.CreateDefaultContext()
    exact.GetInputPort("state").FixValue(context, InitializeAutoDiff(state).ravel())
    values = exact.GetOutputPort("generalized_forces").Eval(context)
    found = np.array([np.resize(each.derivatives(), state.size) for each in values[2:5]])
    steps = 1e-6 * np.eye(state.size)
    expected = np.array([(forces(state + h) - forces(state - h)) / 2e-6 for h in steps]).T
    assert not expected[[0, 1, 5]].any()
    assert found == pytest.approx(expected[2:5], rel=1e-5, abs=1e-5)
