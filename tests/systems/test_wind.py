"""The wind as a system: its parts as the pure functions of `dynamics.air`, and its seeds."""

import numpy as np
import pytest
from pydrake.systems.analysis import Simulator

from workbench.dynamics.air.normals import NORMALS_PER_SAMPLE, draw_normals
from workbench.dynamics.air.settings import AirSettings
from workbench.dynamics.air.update import turbulent_wind
from workbench.systems.noise import noise_seed
from workbench.systems.wind import Wind

PERIOD = 1 / 128
STATE = np.array([1.0, *[0.0] * 5, 20.0, 0.0, 0.0, 0.0, 3.0, -1.0, 0.5])
SEED = 5


def blowing(settings, seed=SEED, periods=64):
    """Return the wind in the middle of control periods (N, 3)."""
    wind = Wind(settings=settings, period=PERIOD)
    simulator = Simulator(wind)
    context = simulator.get_mutable_context()
    wind.GetInputPort("state").FixValue(context, STATE)
    wind.set_seed(context, seed)
    found = []
    for number in range(periods):
        simulator.AdvanceTo((number + 0.5) * PERIOD)
        found.append(wind.get_output_port().Eval(context).copy())
    return np.array(found)


def test_turbulence_is_that_of_the_pure_functions():
    live = {"wind_x": 4.0, "wind_y": -2.0, "turbulence": 8.0}
    settings = AirSettings(**live)
    eddies, after, wanted = np.zeros(6), np.zeros(6), []
    for number in range(64):
        noise = np.empty(NORMALS_PER_SAMPLE)
        with np.errstate(over="ignore"):
            draw_normals(float(noise_seed(SEED, "air")), number, noise)
        blown = turbulent_wind(settings, STATE, noise, eddies, PERIOD, after)
        wanted.append(np.array(blown) + [4.0, -2.0, 0.0])
        eddies = after.copy()
    assert blowing(settings) == pytest.approx(np.array(wanted), rel=1e-9)


def test_a_gust_is_that_of_its_time():
    """MIL-F-8785C: 1 - cos over its duration."""
    found = blowing(AirSettings(wind_z=1.0, gust_x=6.0, gust_start=0.1, gust_duration=0.2))
    time = PERIOD * (np.arange(64) + 0.5)
    inside = (time > 0.1) & (time < 0.3)
    share = np.where(inside, 0.5 * (1.0 - np.cos(2.0 * np.pi * (time - 0.1) / 0.2)), 0.0)
    assert found[:, 0] == pytest.approx(6.0 * share, abs=1e-12)
    assert found[:, 2] == pytest.approx(np.ones(64))


def test_without_turbulence_noise_changes_nothing():
    settings = AirSettings(wind_x=3.0)
    assert blowing(settings, 1).tolist() == blowing(settings, 2).tolist()


def test_equal_seeds_give_equal_winds():
    settings = AirSettings(turbulence=15.0)
    assert blowing(settings, 1).tolist() == blowing(settings, 1).tolist()
    assert blowing(settings, 1).tolist() != blowing(settings, 2).tolist()
