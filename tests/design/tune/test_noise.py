"""Noise amplification, beside a simulated one and a closed form."""

import math
from dataclasses import dataclass

import numpy as np
import pytest

from workbench.design.judge.noise import noise_effects
from workbench.design.linear.operating_point import OperatingPoint
from workbench.design.linear.study import LinearStudy
from workbench.design.tune.case import NOMINAL_CASE
from workbench.design.tune.measure import Instruments
from workbench.design.tune.noise_amplification import RATE_NOISE_INPUTS, noise_amplification
from workbench.design.tune.requirement import Requirement
from workbench.design.tune.wish import parse_wish
from workbench.scenario.scenario import Scenario
from workbench.setup import make_setup


@dataclass(frozen=True)
class Output:
    name: str


@dataclass(frozen=True)
class Model:
    """A scalar filter x+ = a x + n, thrust = c x + d n, beside an integrator that nobody reads."""

    a: float
    c: float
    d: float
    outputs = (Output("v_x"), Output("thrust_1"))

    @property
    def A(self):
        return np.array([[self.a, 0.0], [1.0, 1.0]])

    def B(self, names):
        assert tuple(names) == RATE_NOISE_INPUTS
        return np.array([[1.0, 0.0, 0.0], [0.0, 0.0, 0.0]])

    def C(self, names):
        assert names == ["thrust_1"]
        return np.array([[self.c, 0.0]])

    def D(self, outputs, inputs):
        return np.array([[self.d, 0.0, 0.0]])


@pytest.mark.parametrize(("a", "c", "d"), [(0.5, 2.0, 0.0), (-0.9, 1.0, 3.0), (0.0, 1.0, 1.0)])
def test_a_filter_passes_what_its_series_says(a, c, d):
    expected = math.sqrt(c * c / (1.0 - a * a) + d * d)
    assert noise_amplification(Model(a, c, d)) == pytest.approx(expected)


def test_what_is_unstable_has_no_rms():
    assert noise_amplification(Model(1.01, 1.0, 0.0)) == math.inf


def test_the_drones_is_what_its_model_does_with_noise():
    """Simulated with random numbers; 60000 periods leave two percent."""
    model = LinearStudy().sampled()
    names = [f"thrust_{index}" for index in range(1, 5)]
    A, B, C, D = (
        model.A,
        model.B(RATE_NOISE_INPUTS),
        model.C(names),
        model.D(names, RATE_NOISE_INPUTS),
    )
    noise = np.random.default_rng(1).standard_normal((60000, 3))
    x, thrusts = np.zeros(len(A)), []
    for sample in noise:
        thrusts.append(C @ x + D @ sample)
        x = A @ x + B @ sample
    simulated = np.array(thrusts)[1000:].std(axis=0).max()
    assert noise_amplification(model) == pytest.approx(simulated, rel=0.02)


def test_a_heading_that_wanders_with_the_one_remembered_shakes_no_rotor():
    """`geometric` remembers the heading asked for: a pole on the unit circle, of no thrust."""
    study = LinearStudy(Scenario(controller="geometric"))
    assert 0.3 < noise_amplification(study.sampled()) < 1.2
    assert noise_amplification(study.sampled(gains={"k_rate_xy": 0.0})) == math.inf


def test_a_wish_bounds_the_noise_of_the_rotors_commands():
    """As the effects of all sensors have it, of whichever gains; and filters calm it."""
    instruments = Instruments(make_setup(Scenario(estimator="ekf"), {"gyro_lowpass": 60.0}))
    (wish,) = parse_wish("rotors.command_noise<=1")
    wanted = Requirement(wish, NOMINAL_CASE, wish.bound)
    rough = {**instruments.base, "kd_roll": 2.0 * instruments.base["kd_roll"]}
    found = instruments.measure([instruments.base, rough], [wanted])[:, 0]
    study = LinearStudy(Scenario(estimator="ekf"))
    *_, every = noise_effects(study, OperatingPoint(), {"gyro_lowpass": 60.0})
    assert found[0] == pytest.approx(every.worst_command, rel=1e-6)
    assert found[1] > 1.1 * found[0]
    plain = Instruments(make_setup(Scenario(estimator="ekf")))
    assert plain.measure([plain.base], [wanted])[0, 0] > 1.2 * found[0]
