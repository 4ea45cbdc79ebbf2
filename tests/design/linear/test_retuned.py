"""Models for many gains, beside those that are linearised with them."""

from pathlib import Path

import numpy as np
import pytest

from workbench.design.linear.operating_point import OperatingPoint
from workbench.design.linear.retuned import TERMS, RetunedModels
from workbench.design.linear.study import LinearStudy
from workbench.plant.variation import Variation
from workbench.scenario.scenario import Scenario, VehicleConfig

DRONES = Path(__file__).parents[2] / "drones"
VARIATION = Variation(mass=0.8, inertia=1.3, rotor_lag=1.5)


def test_they_are_so_behind_filters_and_an_estimator():
    study, around = LinearStudy(Scenario(estimator="ekf")), {"gyro_lowpass": 40.0}
    filters = {**around, "derivative_lowpass": 10.0, "setpoint_lowpass": 5.0}
    models = RetunedModels(study, OperatingPoint(), {**study.gains, **filters})
    gains = {**study.gains, **filters, "kp_roll": 90.0, "kd_velocity_x": 0.2, "kd_pitch": 9.0}
    ours, linearised = models.model(gains), study.sampled(gains=gains)
    assert np.abs(ours.A - linearised.A).max() < 1e-11 * np.abs(linearised.A).max()


@pytest.mark.parametrize("hold", [False, True])
@pytest.mark.parametrize("name", ["dh_drone", str(DRONES / "tilted_quad.urdf.xacro")])
def test_they_are_those_of_a_new_linearisation(name, hold):
    vehicle = VehicleConfig(model=name, variation=VARIATION)
    study, point = LinearStudy(Scenario(vehicle=vehicle)), OperatingPoint(hold=hold)
    models = RetunedModels(study, point, study.gains)
    rng = np.random.default_rng(2)
    gains = dict(study.gains)
    for term in TERMS:
        gains[term.gain] = study.gains[term.gain] * rng.uniform(0.3, 2.0)
    ours, linearised = models.model(gains), study.sampled(point, gains)
    for part in ("A", "input_matrix", "output_matrix", "feedthrough"):
        expected = getattr(linearised, part)
        scale = np.abs(expected).max()
        assert np.abs(getattr(ours, part) - expected).max() < 1e-12 * scale
