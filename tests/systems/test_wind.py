"""The wind as a system: its parts as the pure functions of `dynamics.air`, and its seeds."""

import numpy as np
import pytest
from pydrake.systems.analysis import Simulator

from workbench.dynamics.air.normals import NORMALS_PER_SAMPLE, draw_normals
from workbench.dynamics.air.settings import WIND_FIELDS, AirSettings
from workbench.dynamics.air.update import turbulent_wind
from workbench.systems.noise import noise_seed
from workbench.systems.wind import Wind

PERIOD = 1 / 128
STATE = np.array([1.0, *[0.0] * 5, 20.0, 0.0, 0.0, 0.0, 3.0, -1.0, 0.5])
SEED = 5


def blowing(settings, seed=SEED, periods=64, changes=None):
    """Return the wind in the middle of control periods (N, 3).

    Args:
        settings: at the begin.
        seed: of the turbulence.
        periods: their number.
        changes: settings from the begin of a period on, by its number.
    """
    wind = Wind(settings=settings, period=PERIOD)
    simulator = Simulator(wind)
    context = simulator.get_mutable_context()
    wind.GetInputPort("state").FixValue(context, STATE)
    wind.set_seed(context, seed)
    found = []
    for number in range(periods):
        if number in (changes or {}):
            values = list(changes[number][: len(WIND_FIELDS)])
            context.get_mutable_numeric_parameter(0).SetFromVector(values)
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


def test_turbulence_that_begins_anew_remembers_nothing_of_before():
    """From the same period on, with the same noise, as air that was calm until then."""
    calm, rough = AirSettings(), AirSettings(turbulence=8.0)
    again = blowing(rough, periods=40, changes={10: calm, 20: rough})
    first = blowing(calm, periods=40, changes={20: rough})
    assert np.abs(again[:10]).min() > 0.0 and not again[10:20].any()
    assert again[20:] == pytest.approx(first[20:])


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
