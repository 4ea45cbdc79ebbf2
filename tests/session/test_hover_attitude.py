"""Whether a drone is at rest before a step of its attitude, from motions that are known."""

from types import SimpleNamespace

import numpy as np

from workbench.session.hover_attitude import attitude_unrest

SIZE = 0.1
"""Of the step [rad]."""


def unrest(estimated=False, **motion) -> float:
    still = {name: np.zeros(3) for name in ("v_WB", "w_WB", "vdot_WB")}
    moving = {name: np.array(values) for name, values in motion.items()}
    return attitude_unrest(
        SimpleNamespace(
            snapshot=lambda: SimpleNamespace(**(still | moving)),
            scenario=SimpleNamespace(is_estimated=estimated),
        ),
        SIZE,
    )


def test_any_motion_beyond_its_limit_is_no_rest(case):
    """5 cm/s, 0.05 rad/s of yaw; a hundredth of the step in a second, or of tilt over gravity."""
    assert unrest() == 0.0
    for name, limit, axes in (
        ("v_WB", 0.05, (0, 1, 2)),
        ("w_WB", 0.05, (2,)),
        ("w_WB", 0.01 * SIZE, (0, 1)),
        ("vdot_WB", 0.01 * SIZE * 9.81, (0, 1)),
    ):
        for axis in axes:
            for sign in (1.0, -1.0):
                unit = sign * np.eye(3)[axis]
                with case(name, axis, sign):
                    assert unrest(**{name: 0.95 * limit * unit}) < 1.0
                    assert unrest(**{name: 1.05 * limit * unit}) >= 1.0


def test_on_an_estimate_a_drone_may_tremble():
    turning = {"w_WB": [0.0045, 0.0, 0.0]}
    assert unrest(**turning) > 1.0
    assert unrest(estimated=True, **turning) < 1.0
