"""The forces in joints against their equations, and their derivatives."""

import math

import numpy as np
import pytest
from pydrake.autodiffutils import InitializeAutoDiff

from workbench.plant.servo import Servo
from workbench.systems.joint_forces import (
    FRICTION_SPEED,
    JointForces_,
    JointRow,
    servo_effort,
)

LIMITED = JointRow("limited", 0, 0, -0.5, 1.0, 200.0, 3.0, 0.0)
ROUGH = JointRow("rough", 1, 1, -math.inf, math.inf, 0.0, 0.0, 0.4)
FOLLOWER = JointRow("follower", 2, 2, -math.inf, math.inf, 0.0, 0.0, 0.0)._replace(
    leader=0, multiplier=-2.0, offset=0.1, mimic_stiffness=1e4, mimic_damping=50.0
)


def forces(q, v) -> np.ndarray:
    """Return the forces at positions and velocities (3 each)."""
    system = JointForces_[float](rows=(LIMITED, ROUGH, FOLLOWER), positions=3, velocities=3)
    context = system.CreateDefaultContext()
    system.GetInputPort("state").FixValue(context, np.concatenate([q, v]))
    return system.get_output_port().Eval(context)


@pytest.mark.parametrize(
    ("q", "v", "force"),
    [
        (0.9, 5.0, 0.0),
        (1.2, 0.0, -200.0 * 0.2),
        (1.2, 4.0, -200.0 * 0.2 - 3.0 * 4.0),
        (1.2, -20.0, 0.0),  # it does not pull
        (-0.6, 0.0, 200.0 * 0.1),
        (-0.6, -1.0, 200.0 * 0.1 + 3.0),
        (-0.6, 20.0, 0.0),  # nor back, on its way out
    ],
)
def test_a_limit_pushes_back_and_never_pulls(q, v, force):
    follows = -2.0 * q + 0.1, -2.0 * v  # so that the follower has no force
    found = forces([q, 0.0, follows[0]], [v, 0.0, follows[1]])
    assert found.tolist() == pytest.approx([force, 0.0, 0.0], abs=1e-9)


def test_friction_is_dry_but_smooth():
    for v in (-2.0, 0.003, 0.5):
        expected = -0.4 * math.tanh(math.asinh(v / FRICTION_SPEED))
        assert forces([0, 0, 0.1], [0, v, 0])[1] == pytest.approx(expected, rel=1e-12)


def test_a_follower_does_no_work_on_what_follows_exactly():
    """The forces on follower and leader are f and -a f, so their power is f de/dt."""
    error, change, rate = 0.01, 0.0, 3.0
    found = forces([0.2, 0.0, -0.4 + 0.1 + error], [rate, 0.0, -2.0 * rate + change])
    assert found.tolist() == pytest.approx([-2.0 * 1e4 * error, 0.0, -1e4 * error])
    assert found @ [rate, 0.0, -2.0 * rate] == pytest.approx(0.0, abs=1e-9)


def test_it_has_the_derivatives_of_its_equations():
    system = JointForces_[float](
        rows=(LIMITED, ROUGH, FOLLOWER), positions=3, velocities=3
    ).ToAutoDiffXd()
    context = system.CreateDefaultContext()
    state = np.array([1.2, 0.0, -2.3, 0.0, 0.0, 0.0])
    system.GetInputPort("state").FixValue(context, InitializeAutoDiff(state).ravel())
    found = np.array([each.derivatives() for each in system.get_output_port().Eval(context)])
    servo, damping = 1e4, 50.0
    expected = [
        [-200.0 - 4.0 * servo, 0, -2.0 * servo, -3.0 - 4.0 * damping, 0, -2.0 * damping],
        [0, 0, 0, 0, -0.4 / FRICTION_SPEED, 0],
        [-2.0 * servo, 0, -servo, -2.0 * damping, 0, -damping],
    ]
    assert np.abs(found - expected).max() < 1e-9


@pytest.mark.parametrize("sign", [1.0, -1.0])
@pytest.mark.parametrize(
    ("kind", "setpoint", "effort"),
    [
        ("position", 0.5, 20.0 * 0.5 - 2.0 * 0.1),  # stiffness (r - q) - damping v, at q = 0
        ("position", 5.0, 12.0),
        ("velocity", 1.0, 2.0 * (1.0 - 0.1)),
        ("velocity", 9.0, 12.0),
        ("effort", 3.0, 3.0),
        ("effort", 50.0, 12.0),
    ],
)
def test_a_servo_pushes_and_pulls_up_to_its_limit(kind, setpoint, effort, sign):
    servo = Servo(kind, stiffness=20.0, damping=2.0, max_effort=12.0)
    assert servo_effort(servo, sign * setpoint, 0.0, sign * 0.1) == pytest.approx(sign * effort)
