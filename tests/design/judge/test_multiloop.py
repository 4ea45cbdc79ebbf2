"""The disk margin of several loops at once, against closed forms and against flights."""

from dataclasses import dataclass

import control
import numpy as np
import pytest
from scipy.linalg import block_diag
from scipy.optimize import minimize

from workbench.design.judge.margins import all_margins
from workbench.design.judge.multiloop import (
    minimise_simplex,
    multiloop_margin,
    structured_singular_value,
)
from workbench.design.linear.operating_point import OperatingPoint
from workbench.design.linear.study import LinearStudy
from workbench.plant.variation import Variation
from workbench.scenario.scenario import Scenario, VehicleConfig

WRENCH = ["force", "moment_x", "moment_y", "moment_z"]


@dataclass(frozen=True)
class Square:
    """An open loop of python-control's with as many inputs as outputs, closed."""

    open_loop: control.StateSpace

    @property
    def period(self):
        return float(self.open_loop.dt or 0.0)

    @property
    def A(self):
        return self.open_loop.A - self.open_loop.B @ self.open_loop.C

    def B(self, names):
        return self.open_loop.B[:, list(names)]

    def C(self, names):
        return -self.open_loop.C[list(names)]

    def D(self, outputs, inputs):
        return np.zeros((len(outputs), len(inputs)))

    def cut(self, point):
        b, c = self.B([point])[:, 0], self.C([point])[0]
        return self.A - np.outer(b, c), b, c


def test_loops_that_do_not_meet_bear_what_the_weakest_bears():
    loops = [control.tf([4.0], [0.04, 1.0, 0.0]), control.tf([9.0], [0.01, 0.4, 1.0, 0.0])]
    parts = [control.ss(loop) for loop in loops]
    blocks = (block_diag(*(getattr(part, name) for part in parts)) for name in "ABCD")
    both = Square(control.ss(*blocks))
    found = multiloop_margin(both, [0, 1])
    s = 1j * np.geomspace(1e-3, 1e3, 20001)
    alone = [2.0 * np.abs((1.0 + loop(s)) / (1.0 - loop(s))).min() for loop in loops]  # of S - T
    assert found.disk_margin == pytest.approx(min(alone), rel=1e-5)
    assert list(found.alone.values()) == pytest.approx(alone, rel=1e-5)


def test_the_spinning_satellite_is_fragile_where_each_loop_bears_all():
    """The example of Seiler, Packard and Gahinet, of a spin a and K = I.

    S - T = (s - 1, -2 a; 2 a, s - 1) / (s + 1), a normal matrix, has its largest singular value
    a + √(a² + 1) at ω = √(a² + 1) - a: α = 2 (√(a² + 1) - a), which is 0.0998 for a = 10.
    """
    for a in (0.5, 10.0):
        system = control.ss(
            [[0.0, a], [-a, 0.0]], np.eye(2), [[1.0, a], [-a, 1.0]], np.zeros((2, 2))
        )
        found = multiloop_margin(Square(system), [0, 1])
        closed_form = 2.0 * (np.sqrt(a * a + 1.0) - a)
        assert list(found.alone.values()) == pytest.approx([2.0, 2.0])
        assert found.disk_margin == pytest.approx(closed_form, rel=1e-5)
        assert found.frequency == pytest.approx(0.5 * closed_form, rel=0.02)


def test_the_bound_is_met_by_a_change_of_all_loops():
    """From below, μ is the largest spectral radius of M with the loops' phases turned."""
    rng = np.random.default_rng(3)
    for k, near in ((2, 0.999), (3, 0.999), (3, 0.999), (4, 0.9)):
        M = rng.normal(size=(k, k)) + 1j * rng.normal(size=(k, k))
        M *= np.exp(rng.normal(size=k))[:, None]

        def less(turns, M=M):
            return -np.abs(np.linalg.eigvals(M * np.exp(1j * turns))).max()

        starts = rng.uniform(0.0, 2.0 * np.pi, size=(8, k))
        best = -min(minimize(less, start, method="Nelder-Mead").fun for start in starts)
        bound = structured_singular_value(M)
        assert near * bound < best <= bound * (1.0 + 1e-9), k


def test_scaling_changes_no_bound():
    rng = np.random.default_rng(4)
    M = rng.normal(size=(4, 4)) + 1j * rng.normal(size=(4, 4))
    scale = np.exp([3.0, -5.0, 0.0, 7.0])
    bound = structured_singular_value(M)
    assert bound <= np.linalg.norm(M, 2)
    assert structured_singular_value(M * scale[:, None] / scale, -np.log(scale)) == pytest.approx(
        bound, rel=1e-3
    )


def test_at_the_plants_input_one_loop_is_what_it_is_where_it_was(study, steering):
    """A tilt's actuator is all of its moment, but for what the other axes take of it."""
    model = study.plant_input()
    found = multiloop_margin(model)
    by_point = all_margins(steering, ["roll_acceleration", "pitch_acceleration", "acceleration_z"])
    for name, there in zip(("moment_x", "moment_y", "force"), by_point, strict=True):
        assert found.alone[name] == pytest.approx(there.disk_margin, rel=1e-3)
    assert found.disk_margin <= min(found.alone.values()) * (1.0 + 1e-6)
    assert found.disk_margin > 0.6


def test_it_adds_delays_and_changes_no_pole(study):
    for variation in (Variation(), Variation(sensing_delay=0.003, command_delay=0.011)):
        late = study.like(Scenario(vehicle=VehicleConfig(variation=variation)))
        model, plain = late.plant_input(), late.sampled()
        m = len(plain.A)
        np.testing.assert_array_equal(model.A[:m, :m], plain.A)
        assert not model.A[m:, :m].any()
        assert [signal.name for signal in model.inputs] == WRENCH
        assert all(margins.stable for margins in all_margins(model, WRENCH))


def test_a_delay_of_the_rotors_beyond_the_margin_makes_it_unstable(case):
    """Of a law that looks at its own commands, too: it knows them before the rotors do."""
    for name, gains in (("pd", {}), ("indi", {"spin_up_feedforward": 1.0})):
        study = LinearStudy(Scenario(controller=name))
        margins = all_margins(study.plant_input(gains=gains), WRENCH)
        least = min(each.delay_margin for each in margins)
        for share, stable in ((0.9, True), (1.1, False)):
            with case(name, share):
                variation = Variation(command_delay=share * least)
                vehicle = VehicleConfig(variation=variation)
                late = study.like(Scenario(controller=name, vehicle=vehicle))
                found = multiloop_margin(late.plant_input(gains=gains))
                assert (found.disk_margin > 0.0) is stable


def test_every_point_of_flight_has_one(study):
    for point in (OperatingPoint(velocity=(5.0, 0.0, 0.0)), OperatingPoint(yaw_rate=0.3)):
        assert 0.3 < multiloop_margin(study.plant_input(point)).disk_margin < 1.0


def test_the_search_for_scales_makes_scipys_steps():
    """To the bit, also where the number of calls ends it: in the valley of Rosenbrock."""

    def valley(x):
        return float((100.0 * (x[1:] - x[:-1] ** 2) ** 2 + (1.0 - x[:-1]) ** 2).sum())

    def size(x):
        return float(np.abs(x - 0.3).max())

    rng = np.random.default_rng(4)
    for count in (1, 2, 3, 5, 8):
        for function in (valley, size):
            corners = rng.normal(size=(count + 1, count))
            options = {"initial_simplex": corners, "xatol": 1e-5, "fatol": 1e-7}
            oracle = minimize(function, corners[0], method="Nelder-Mead", options=options)
            assert minimise_simplex(function, corners.copy(), 1e-5, 1e-7) == oracle.fun
