"""Shares of a sweep, on executors whose order and end are known; for real ones see test_cluster."""

from functools import partial

import numpy as np
import pytest

from workbench.design.sweep import compiled_flights, kept_flights
from workbench.design.sweep.compiled_flights import fly_fastest
from workbench.design.sweep.sweep import sweep

GAIN = "kp_velocity_x"
STEP = {"axis": "x", "duration": 1.0}


class Disordered:
    """Runs tasks in an order of its own, until it is stopped."""

    def __init__(self, *order):
        self.order = order
        self.tasks = 0

    def run(self, tasks, stop=None):
        for index in self.order:
            self.tasks += 1
            yield index, tasks[index].run()
            if stop and stop():
                return


@pytest.fixture(autouse=True)
def made_up_flights(monkeypatch):
    """Each flight is measured as the value of its own gain, in shares of two, kept at once."""

    def fly(case, setup, candidates, *, threads):
        assert threads == 1  # a worker has a core
        values = np.array([[each.settings[GAIN]] for each in candidates])
        yield range(len(candidates)), values, np.full(len(candidates), np.nan)

    monkeypatch.setattr(compiled_flights, "fly_compiled", fly)
    monkeypatch.setattr(compiled_flights, "CANDIDATES_PER_SHARE", 2)
    monkeypatch.setattr(kept_flights, "FIRST_WRITE_DELAY_S", 0.0)


def test_shares_come_back_to_their_places():
    told = []
    fly = partial(fly_fastest, cluster=Disordered(3, 2, 1, 0))
    table = sweep([f"{GAIN}=1..6:6"], **STEP, fly=fly, progress=told.append)
    assert table.values[:, 0].tolist() == [1.0, 2.0, 3.0, 4.0, 5.0, 6.0]
    assert table.present_values[0] == table.present[0]  # the first of all, so seven in four shares
    assert told == pytest.approx([1 / 7, 3 / 7, 5 / 7, 1.0])


def test_a_stop_keeps_whole_shares_and_the_next_sweep_flies_the_others(tmp_path):
    """The share of the present gains is one of them, though another was the first to come back."""
    file = tmp_path / "x.csv.unfinished"
    first, second = Disordered(3, 0, 2, 1), Disordered(1, 0)
    part = sweep(
        [f"{GAIN}=1..6:6"],
        **STEP,
        fly=partial(fly_fastest, cluster=first),
        stop=lambda: True,
        kept=file,
    )
    assert part.values[:, 0].tolist() == [1.0, 6.0]
    assert part.present_values[0] == part.present[0]
    whole = sweep([f"{GAIN}=1..6:6"], **STEP, fly=partial(fly_fastest, cluster=second), kept=file)
    assert (first.tasks, second.tasks) == (2, 2)
    np.testing.assert_array_equal(whole.values[:, 0], [1.0, 2.0, 3.0, 4.0, 5.0, 6.0])
