"""The loop of a pole, by eigenvalues of the closed loop with another gain in that loop."""

import numpy as np

from workbench.design.judge.pole_loops import located_poles
from workbench.design.linear.operating_point import HOLDING_POINT
from workbench.design.linear.study import LinearStudy

FACTOR = 1e-4


def test_a_pole_belongs_to_the_loop_whose_gain_moves_it_most():
    """The hover of the cascaded law: each loop's error, times 1.0001, moves some poles."""
    model = LinearStudy().sampled(HOLDING_POINT)
    poles, loops, _ = located_poles(model)
    assert len(poles) == len(loops) > 10
    moved = []
    for loop in model.loops:
        _, b, c = model.cut(loop.error)
        z = np.linalg.eigvals(model.A + FACTOR * np.outer(b, c))
        found = np.log(z[np.abs(z) > 1e-9].astype(complex)) / model.period
        moved.append(np.abs(found[:, None] - poles[None]).min(axis=0) / np.abs(poles) / FACTOR)
    names = [loop.name for loop in model.loops]
    for place, loop in enumerate(loops):
        shifts = np.array([each[place] for each in moved])
        if loop:
            assert shifts[names.index(loop)] > 0.9 * shifts.max(), (poles[place], loop)
        else:
            assert shifts.max() < 0.02
    of_loop = {loop: np.abs(poles[[each == loop for each in loops]]) for loop in set(loops)}
    assert of_loop["position_x"].max() < of_loop["pitch"].min()
    assert {"pitch", "roll", "yaw_rate", "velocity_z"} < set(loops)
