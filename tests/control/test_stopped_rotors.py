"""Oracles: linear programming, least squares within limits (both scipy's), and thrusts by hand."""

import itertools

import numpy as np
import pytest
from pydrake.autodiffutils import AutoDiffXd
from scipy.optimize import linprog, lsq_linear

from workbench.control.stopped_rotors import mix_without

DRAG = 0.02
"""Moment over thrust of each rotor [m]."""
MOST = 10.0


def ring(count, radius=0.5):
    """Return the columns for rotors around, each turning against its neighbours."""
    angles = 2.0 * np.pi * (np.arange(count) + 0.5) / count
    x, y = radius * np.cos(angles), radius * np.sin(angles)
    return np.array([np.ones(count), y, -x, -DRAG * (-1.0) ** np.arange(count)])


def coaxial():
    below = ring(4) * [[1.0], [1.0], [1.0], [-1.0]]
    return np.hstack([ring(4), below])


def uneven():
    columns = ring(6)
    columns[1:3, 1] += [0.1, -0.06]
    columns[:, 4] *= 0.9
    return columns


LAYOUTS = {
    "hexacopter": ring(6),
    "octocopter": ring(8),
    "coaxial": coaxial(),
    "uneven": uneven(),
    "quadrotor": ring(4),
    "dozen": ring(12),
}
LOST = [(0,), (4,), (0, 1), (0, 2), (0, 3)]
CASES = [
    pytest.param(layout, lost, id="-".join([layout, *map(str, lost)]))
    for layout, lost in itertools.product(LAYOUTS, LOST)
    if max(lost) < LAYOUTS[layout].shape[1]
]
each_case = pytest.mark.parametrize(("layout", "lost"), CASES)


class Broken:
    """A layout that has lost rotors."""

    def __init__(self, layout, lost):
        self.rows = LAYOUTS[layout]
        self.most = np.full(self.rows.shape[1], MOST)
        self.most[list(lost)] = 0.0
        self.effects = self.rows.T.tolist()
        self.bounds = [(0.0, most) for most in self.most]

    def __call__(self, wrench) -> np.ndarray:
        thrusts = [0.0] * len(self.most)
        mix_without(*map(float, wrench), self.effects, self.most.tolist(), thrusts)
        return np.array(thrusts)

    def wrenches(self, count, spread):
        """About what the rotors left can do."""
        rng = np.random.default_rng(8)
        for _ in range(count):
            thrusts = self.most * rng.uniform(0.0, 1.0, len(self.most))
            away = rng.normal(size=4) * (0.5 * np.abs(self.rows) @ self.most)
            yield self.rows @ thrusts + spread * rng.uniform() * away

    def range_of(self, row, rows, made):
        """Return the least and the most of a row that leaves other rows as they are, or None."""
        found = linprog(  # both in one program: to set it up takes longest
            np.concatenate([row, -row]),
            A_eq=np.kron(np.eye(2), rows),
            b_eq=np.tile(made, 2),
            bounds=2 * self.bounds,
        )
        return None if found.status != 0 else [row @ part for part in np.split(found.x, 2)]


@each_case
def test_limits_are_never_exceeded(layout, lost):
    broken = Broken(layout, lost)
    for spread in (0.0, 1.0, 100.0):
        for wrench in broken.wrenches(20, spread):
            thrusts = broken(wrench)
            assert np.all(thrusts >= 0.0)
            assert np.all(thrusts <= broken.most)


@each_case
def test_tilt_and_force_are_exact_wherever_thrusts_for_them_exist(layout, lost):
    """And yaw is then the nearest that these thrusts leave, but for a little smoothness."""
    broken = Broken(layout, lost)
    exact = 0
    for wrench in broken.wrenches(16, 0.1):
        room = broken.range_of(broken.rows[3], broken.rows[:3], wrench[:3])
        if room is None:
            continue
        exact += 1
        made = broken.rows @ broken(wrench)
        assert made[:3] == pytest.approx(wrench[:3], abs=2e-5)
        assert made[3] == pytest.approx(np.clip(wrench[3], *room), abs=0.02 * DRAG)
    assert exact >= 4 or len(broken.most) - len(lost) < 4


@each_case
def test_what_is_out_of_reach_comes_near_in_tilt_first_then_in_force(layout, lost):
    broken = Broken(layout, lost)
    left = np.flatnonzero(broken.most)
    arms = broken.rows[1:3, left]
    found = 0
    for wrench in [*broken.wrenches(10, 1.5), *broken.wrenches(6, 30.0)]:
        made = broken.rows @ broken(wrench)
        nearest = lsq_linear(arms, wrench[1:3], bounds=(0.0, MOST), method="bvls", tol=1e-14)
        reached = np.linalg.norm(arms @ nearest.x - wrench[1:3])
        assert np.linalg.norm(made[1:3] - wrench[1:3]) <= reached + 5e-3

        room = broken.range_of(broken.rows[0], broken.rows[1:3], made[1:3])
        if room is not None:  # the tilt made lies on the edge, and beside it by rounding
            found += 1
            assert made[0] == pytest.approx(np.clip(wrench[0], *room), abs=0.02)
    assert found == 16


def test_a_hexacopter_hovers_without_one_with_the_opposite_one_at_rest():
    """By hand: of the four others, each carries a quarter, and their moments cancel."""
    for dead in range(6):
        wanted = np.full(6, 5.0)
        wanted[[dead, (dead + 3) % 6]] = 0.0
        broken = Broken("hexacopter", (dead,))
        assert broken([20.0, 0.0, 0.0, 0.0]) == pytest.approx(wanted, abs=1e-5)


def test_a_hexacopter_can_be_turned_one_way_only():
    """By hand: rotor 4 at e needs e more of 2 and 6 than of 3 and 5, which all turn one way.

    With rotors 1, 3, 5 making -DRAG of yaw for each newton, that is a moment of +3 e DRAG.
    """
    broken = Broken("hexacopter", (0,))
    for yaw in (0.01, 0.03, 0.06):
        thrusts = broken([20.0, 0.0, 0.0, yaw])
        assert broken.rows @ thrusts == pytest.approx([20.0, 0.0, 0.0, yaw], abs=1e-6)
        assert thrusts[3] == pytest.approx(yaw / (3.0 * DRAG), rel=1e-4)
        against = broken([20.0, 0.0, 0.0, -yaw])
        assert broken.rows @ against == pytest.approx([20.0, 0.0, 0.0, 0.0], abs=1e-6)


def test_what_all_rotors_left_can_make_takes_the_least_thrusts():
    """Those of the pseudo-inverse of their columns, as with all rotors."""
    for layout, dead in (("octocopter", 2), ("coaxial", 0), ("dozen", 5)):
        broken = Broken(layout, (dead,))
        left = np.flatnonzero(broken.most)
        for yaw in (-0.02, 0.0, 0.02):
            wrench = np.array([4.0 * len(left), 0.3, -0.2, yaw])
            thrusts = np.linalg.pinv(broken.rows[:, left]) @ wrench
            assert np.all((thrusts > 0.0) & (thrusts < MOST))
            assert broken(wrench)[left] == pytest.approx(thrusts, abs=1e-4)


def test_a_small_change_of_the_wrench_changes_the_thrusts_little():
    for layout, lost in (("hexacopter", (0,)), ("octocopter", (0, 2)), ("uneven", (3,))):
        broken = Broken(layout, lost)
        ways = broken.wrenches(5, 0.5)
        for begin, end in itertools.pairwise(ways):
            along = [broken(begin + share * (end - begin)) for share in np.linspace(0, 1, 501)]
            assert np.abs(np.diff(along, axis=0)).max() < 1.0


@pytest.mark.parametrize("left", [0, 1, 2])
def test_however_few_are_left_it_gives_an_answer(left):
    broken = Broken("octocopter", tuple(range(left, 8)))
    for wrench in ([40.0, 0.0, 0.0, 0.0], [40.0, 1.0, -2.0, 0.1], [0.0] * 4, [1e9, -1e9, 1e9, 1e9]):
        thrusts = broken(wrench)
        assert np.isfinite(thrusts).all()
        assert np.count_nonzero(thrusts) <= left


@pytest.mark.parametrize("lost", [(0,), (0, 1)])
def test_with_derivatives_it_gives_the_same_numbers(lost):
    broken = Broken("hexacopter", lost)
    for wrench in broken.wrenches(10, 0.5):
        carried = [0.0] * 6
        variables = [AutoDiffXd(value, np.eye(4)[i]) for i, value in enumerate(wrench)]
        mix_without(*variables, broken.effects, broken.most.tolist(), carried)
        numbers = [f.value() if isinstance(f, AutoDiffXd) else f for f in carried]
        assert numbers == pytest.approx(broken(wrench), abs=1e-9)


def test_derivatives_are_those_of_small_differences():
    broken = Broken("octocopter", (0,))
    most = broken.most.tolist()
    wrench = np.array([30.0, 0.4, -0.3, 0.01])
    thrusts = [0.0] * 8
    variables = [AutoDiffXd(value, np.eye(4)[i]) for i, value in enumerate(wrench)]
    mix_without(*variables, broken.effects, most, thrusts)
    assert thrusts[0] == 0.0
    jacobian = np.array([thrust.derivatives() for thrust in thrusts[1:]])
    for i, small in enumerate(1e-4 * np.eye(4)):
        differences = (broken(wrench + small) - broken(wrench - small)) / 2e-4
        assert jacobian[:, i] == pytest.approx(differences[1:], abs=1e-4)
