"""Oracles: the pseudo-inverse where nothing saturates, linear programming where something does."""

import numpy as np
import pytest
from pydrake.autodiffutils import AutoDiffXd
from scipy.optimize import linprog
from scipy.sparse import block_diag, coo_array

from workbench.control.mixer import mix
from workbench.plant.rotors import Rotor, allocation_matrix, wrench_matrix
from workbench.plant.tilt import Tilt, TiltedRotor


def rotor(x, y, direction, axis_B=(0.0, 0.0, 1.0), largest=10.0) -> Rotor:
    return Rotor(
        name="r",
        joint="",
        link="",
        p_BR=(x, y, 0.0),
        axis_B=axis_B,
        direction=direction,
        motor_constant=largest / 1000.0**2,
        moment_constant=0.016,
        time_constant_up=0.01,
        time_constant_down=0.02,
        max_rot_velocity=1000.0,
    )


def ring(count, radius=0.25):
    angles = 2.0 * np.pi * (np.arange(count) + 0.5) / count
    return [rotor(radius * np.cos(a), radius * np.sin(a), (-1) ** i) for i, a in enumerate(angles)]


LAYOUTS = {
    "quad": (ring(4), (0.0, 0.0, 0.0)),
    "hexa": (ring(6), (0.0, 0.0, 0.0)),
    "octo": (ring(8), (0.0, 0.0, 0.0)),
    "quad, mass off the middle": (ring(4), (0.06, -0.04, 0.01)),
    "quad, long tail and unlike motors": (
        [
            rotor(0.2, 0.3, -1, largest=12.0),
            rotor(-0.4, 0.15, 1, largest=8.0),
            rotor(-0.4, -0.15, -1, largest=8.0),
            rotor(0.2, -0.3, 1, largest=12.0),
        ],
        (-0.05, 0.01, 0.0),
    ),
    "hexa, one rotor moved and one tilted": (
        [
            *ring(6)[:4],
            rotor(0.1, -0.4, 1),
            rotor(0.25, -0.1, -1, (0.0, 0.1, np.sqrt(0.99))),
        ],
        (0.02, 0.0, 0.0),
    ),
    "octo, mass off the middle": (ring(8), (0.03, 0.05, 0.0)),
}


class Mixer:
    """A layout with its matrices and limits."""

    def __init__(self, layout):
        self.rotors, p_BoBcm_B = LAYOUTS[layout]
        self.allocation = allocation_matrix(self.rotors, p_BoBcm_B)
        self.rows = wrench_matrix(self.rotors, p_BoBcm_B)[2:]
        self.high = np.array([rotor.max_thrust for rotor in self.rotors])
        self.low = 0.01 * self.high

    def __call__(self, wrench) -> np.ndarray:
        thrusts = [0.0] * len(self.rotors)
        rows = self.allocation.tolist()
        mix(*map(float, wrench), rows, self.low.tolist(), self.high.tolist(), thrusts)
        return np.array(thrusts)

    def fits(self, thrusts, slack=1e-9) -> bool:
        return bool(np.all(thrusts >= self.low - slack) and np.all(thrusts <= self.high + slack))

    def largest_tilt_shares(self, wrenches) -> np.ndarray:
        """Largest t <= 1 of each for which force F and t times the tilting moment fit, F free.

        One program for all, of which no two share a variable: it takes as long as a few alone.
        """
        columns = [self.allocation[:, 1:3] @ wrench[1:3] for wrench in wrenches]
        both = [np.column_stack([column, self.allocation[:, 0]]) for column in columns]
        found = linprog(
            [-1.0, 0.0] * len(both),
            A_ub=block_diag([coo_array(np.vstack([each, -each])) for each in both]),
            b_ub=np.tile(np.concatenate([self.high, -self.low]), len(both)),
            bounds=[(None, 1.0), (None, None)] * len(both),
        )
        return found.x[::2]

    def room(self, base, column) -> tuple[float, float]:
        """Return the range of c for which base + c column fits."""
        ends = np.sort(np.array([(self.low - base), (self.high - base)]) / column, axis=0)
        return float(ends[0].max()), float(ends[1].min())


@pytest.fixture(params=LAYOUTS, ids=lambda name: name.replace(" ", "_"))
def mixer(request):
    return Mixer(request.param)


def random_wrenches(mixer, count, spread):
    """Wrenches about hover; a spread of 1 is about what the rotors can do at most."""
    rng = np.random.default_rng(5)
    scale = 0.5 * np.abs(mixer.rows) @ mixer.high
    wrenches = rng.uniform(-spread, spread, (count, 4)) * scale
    wrenches[:, 0] += scale[0]
    return wrenches


def test_what_fits_is_the_pseudo_inverse_exactly(mixer):
    wrenches = random_wrenches(mixer, 2000, 0.3)
    fitting = [w for w in wrenches if mixer.fits(mixer.allocation @ w, slack=0.0)]
    assert len(fitting) > 200
    thrusts = np.array([mixer(wrench) for wrench in fitting])
    assert np.abs(thrusts - fitting @ mixer.allocation.T).max() <= 1e-12
    assert np.abs(thrusts @ mixer.rows.T - fitting).max() <= 1e-12


def test_thrusts_never_leave_the_limits(mixer):
    for spread in (0.5, 1.5, 10.0):
        for wrench in random_wrenches(mixer, 1000, spread):
            assert mixer.fits(mixer(wrench))


def test_tilting_moment_comes_first_then_force_then_yaw(mixer):
    shrunk, force_cut, yaw_cut = 0, 0, 0
    wrenches = random_wrenches(mixer, 250, 1.2)
    wrenches = [each for each in wrenches if not mixer.fits(mixer.allocation @ each)]
    for wrench, share in zip(wrenches, mixer.largest_tilt_shares(wrenches), strict=True):
        made = mixer.rows @ mixer(wrench)
        assert made[1:3] == pytest.approx(share * wrench[1:3], abs=1e-7)

        base = mixer.allocation[:, 1:3] @ made[1:3]
        least, most = mixer.room(base, mixer.allocation[:, 0])
        assert made[0] == pytest.approx(np.clip(wrench[0], least, max(most, least)), abs=1e-6)

        base = base + mixer.allocation[:, 0] * made[0]
        least, most = mixer.room(base, mixer.allocation[:, 3])
        yaw = np.clip(wrench[3], min(least, 0.0), max(most, 0.0))
        assert made[3] == pytest.approx(yaw, abs=1e-6)

        shrunk += share < 1.0 - 1e-9
        force_cut += abs(made[0] - wrench[0]) > 1e-6
        yaw_cut += abs(made[3] - wrench[3]) > 1e-6
    assert min(shrunk, force_cut, yaw_cut) > 20


def test_yaw_never_takes_from_tilt_or_force(mixer):
    """The same wrench with and without a huge yaw moment: tilt and force stay as they were."""
    wrenches = random_wrenches(mixer, 500, 0.5)
    without, with_yaw = (
        np.array([mixer.rows @ mixer([*wrench[:3], yaw]) for wrench in wrenches])
        for yaw in (0.0, 100.0)
    )
    assert np.abs(with_yaw[:, :3] - without[:, :3]).max() <= 1e-6
    assert np.all(with_yaw[:, 3] >= without[:, 3] - 1e-9)


def test_full_thrust_gives_way_to_a_small_roll():
    """By hand: four rotors of at most 10 N, 45 N and 0.5 N·m asked for, arms of 0.25 / sqrt 2 m.

    Each must give or take 0.5 / (4 * 0.17678) = 0.7071 N for the roll, so 4 * (10 - 0.7071) is
    left for the force.
    """
    quad = Mixer("quad")
    force, roll, pitch, yaw = quad.rows @ quad([45.0, 0.5, 0.0, 0.0])
    assert roll == pytest.approx(0.5)
    assert force == pytest.approx(4.0 * (10.0 - 0.5 * np.sqrt(2.0)))
    assert (pitch, yaw) == pytest.approx((0.0, 0.0), abs=1e-12)


def test_upside_down_and_falling_it_idles_and_still_tilts():
    """No downward force exists, so rotors idle at 0.1 N except for what the roll needs."""
    quad = Mixer("quad")
    thrusts = quad([-20.0, 0.5, 0.0, 0.0])
    assert thrusts.min() == pytest.approx(0.1)
    assert (quad.rows @ thrusts)[1] == pytest.approx(0.5)


def test_the_same_numbers_with_derivatives():
    quad = Mixer("quad")
    rows, low, high = quad.allocation.tolist(), quad.low.tolist(), quad.high.tolist()
    for wrench in random_wrenches(quad, 200, 0.8):
        thrusts = [0.0] * 4
        variables = [AutoDiffXd(value, np.eye(4)[i]) for i, value in enumerate(wrench)]
        mix(*variables, rows, low, high, thrusts)
        assert [thrust.value() for thrust in thrusts] == pytest.approx(quad(wrench), abs=1e-12)


def test_derivatives_unsaturated_are_the_allocation():
    quad = Mixer("quad")
    rows, low, high = quad.allocation.tolist(), quad.low.tolist(), quad.high.tolist()
    thrusts = [0.0] * 4
    wrench = [18.6, 0.1, -0.1, 0.02]
    mix(*[AutoDiffXd(v, np.eye(4)[i]) for i, v in enumerate(wrench)], rows, low, high, thrusts)
    jacobian = np.array([thrust.derivatives() for thrust in thrusts])
    assert jacobian == pytest.approx(quad.allocation, abs=1e-12)


def test_tilts_stay_within_their_limits_whatever_is_asked():
    """A tricopter with a tail that tilts, and one whose tail turns back as the force grows."""
    arm = 0.25
    places = [(arm / 2.0, 0.2, 1), (arm / 2.0, -0.2, -1), (-arm, 0.0, 1)]
    rotors = [rotor(*each) for each in places]
    tilt = Tilt("tail", -0.5, 0.4, (TiltedRotor(2, (-arm, 0.0, 0.0), (1.0, 0.0, 0.0)),))
    allocation = allocation_matrix(rotors, (0.0, 0.0, 0.0), (tilt,))
    rows = np.column_stack([wrench_matrix(rotors, (0.0, 0.0, 0.0)), tilt.column(rotors, (0, 0, 0))])
    assert np.abs(rows[2:] @ allocation - np.eye(4)).max() < 1e-12
    assert abs(allocation[3, 0]) > 0.01  # drag torque of the odd rotor
    least, most = [0.1] * 3 + [-2.0], [10.0] * 3 + [1.6]
    generator = np.random.default_rng(3)
    full = 0
    for _ in range(3000):
        asked = generator.uniform(-1.0, 1.0, 4) * [20.0, 2.0, 2.0, 1.0] + [12.0, 0.0, 0.0, 0.0]
        found = [0.0] * 4
        mix(*asked.tolist(), allocation.tolist(), least, most, found)
        assert np.all(np.array(found) >= np.array(least) - 1e-12)
        assert np.all(np.array(found) <= np.array(most) + 1e-12)
        exact = allocation @ asked
        if np.all(exact >= least) and np.all(exact <= most):
            assert found == pytest.approx(exact.tolist(), abs=1e-12)
            full += 1
    assert full > 100
