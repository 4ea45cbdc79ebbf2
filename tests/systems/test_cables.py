"""The pull of a cable on two bodies in any motion, against vectors by scipy and numpy."""

import numpy as np
import pytest
from pydrake.multibody.tree import BodyIndex
from scipy.spatial.transform import Rotation

from workbench.systems.cables import CableRow, Cables_

K, C, LENGTH = 300.0, 4.0, 0.5
PLACES = ((0.1, -0.2, -0.05), (0.03, 0.04, 0.06))
NO_STRETCH = np.zeros(0)
ROW = CableRow("sling", (BodyIndex(3), BodyIndex(5)), PLACES, LENGTH, K, C, NO_STRETCH, hooked=True)


def body(random, p):
    """Return attitude, place, angular velocity and velocity in W of a body, and its state (13)."""
    R, w, v = Rotation.random(random_state=random), *random.uniform(-1.0, 1.0, (2, 3))
    return R, p, w, v, [*R.as_quat(scalar_first=True), *p, *w, *v]


@pytest.mark.parametrize("seed", range(5))
def test_a_cable_pulls_along_itself_at_both_ends_and_damps_the_speed_of_its_ends(seed):
    random = np.random.default_rng(seed)
    bodies = body(random, random.normal(size=3)), body(random, np.array([0.0, 0.0, -4.0]))
    arms = [R.apply(place) for (R, *_), place in zip(bodies, PLACES, strict=True)]
    ends = [p + arm for (_, p, *_), arm in zip(bodies, arms, strict=True)]
    speeds = [v + np.cross(w, arm) for (_, _, w, v, _), arm in zip(bodies, arms, strict=True)]
    apart = ends[1] - ends[0]
    distance = np.linalg.norm(apart)
    along = apart / distance
    tension = K * (distance - LENGTH) + C * along @ (speeds[1] - speeds[0])
    assert tension > 0.0
    system = Cables_[float](rows=(ROW,))
    context = system.CreateDefaultContext()
    system.GetInputPort("state").FixValue(context, np.concatenate([each[4] for each in bodies]))
    assert system.GetOutputPort("tensions").Eval(context) == pytest.approx([tension])
    assert system.GetOutputPort("ends").Eval(context) == pytest.approx(np.concatenate(ends))
    found = system.GetOutputPort("spatial_forces").Eval(context)
    for applied, index, arm, sign in zip(found, ROW.bodies, arms, (1.0, -1.0), strict=True):
        assert applied.body_index == index
        force = sign * tension * along
        assert applied.F_Bq_W.translational() == pytest.approx(force)
        assert applied.F_Bq_W.rotational() == pytest.approx(np.cross(arm, force))
