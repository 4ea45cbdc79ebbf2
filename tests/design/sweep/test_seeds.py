"""Chance in a study of many flights: a row has its seed, and flies alike wherever it flies."""

from functools import partial

import numpy as np
import pytest

from workbench.common.errors import WorkbenchError
from workbench.design.executor.executor import InThisProcess
from workbench.design.step_response import fly_step
from workbench.design.sweep.best import prove_best, why_no_best
from workbench.design.sweep.full_flights import fly_full
from workbench.design.sweep.ranges import parse_range
from workbench.design.sweep.sweep import sample_candidates, sweep
from workbench.scenario.scenario import Scenario
from workbench.scenario.sensors_config import SensorsConfig

HERE = partial(fly_full, executor=InThisProcess())


def test_a_rows_seed_is_that_of_its_turbulence():
    settings = {"turbulence": 3.0}
    table = sweep(["seed=7..8:2"], axis="x", duration=0.5, settings=settings, fly=HERE)
    peaks = table.column("peak")
    assert table.column("seed").tolist() == [7.0, 8.0]
    assert peaks[0] != peaks[1]
    scenario = Scenario(sensors=SensorsConfig(seed=8))
    step = fly_step("x", 1.0, duration=0.5, scenario=scenario, settings=settings)
    assert peaks[1] == step.metrics.peak
    assert table.present.tolist() == [0.0]


@pytest.mark.parametrize("method", ["random", "sobol"])
def test_seeds_are_whole_and_follow_from_the_tables_own(method):
    ranges = [parse_range("vary.mass=0.9..1.1"), parse_range("seed=0..1000000")]
    rows = sample_candidates(ranges, method, 64, 5)
    assert (rows[:, 1] == np.round(rows[:, 1])).all()
    assert len(set(rows[:, 1])) > 60
    np.testing.assert_array_equal(sample_candidates(ranges, method, 64, 5), rows)
    np.testing.assert_array_equal(
        sample_candidates(ranges, method, 128, 5)[:64], rows
    )  # more, not others
    assert not np.array_equal(sample_candidates(ranges, method, 64, 6), rows)


@pytest.mark.parametrize("text", ["seed=-1..4", "seed=0.5..4", "seed=0..3000000000"])
def test_what_is_no_seed_is_refused(text):
    with pytest.raises(WorkbenchError, match="give a whole number 0 .. 2147483647"):
        parse_range(text)


def test_compiled_flights_have_the_same_chance():
    study = partial(sweep, ["seed=7..8:2"], axis="x", duration=0.5, settings={"turbulence": 3.0})
    compiled, full = study(), study(fly=HERE)
    np.testing.assert_allclose(compiled.values, full.values, rtol=2e-3, atol=1e-3)
    assert abs(np.diff(compiled.column("peak"))[0]) > 0.005


def test_luck_is_no_best_candidate(make_table):
    table = make_table([[1.0] * 9, [2.0] * 9], [np.nan, np.nan], "seed=0..1:2")
    assert prove_best(table, "rise_time") is None
    assert "the seed is random" in why_no_best(table, "rise_time")
