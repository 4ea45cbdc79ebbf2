"""Small sweeps, flown once."""

import numpy as np
import pytest

from workbench.design.metrics import FLOWN_METRICS
from workbench.design.sweep.case import SweepCase
from workbench.design.sweep.ranges import parse_range
from workbench.design.sweep.sweep import sweep
from workbench.design.sweep.table import SweepTable

NAN = float("nan")


@pytest.fixture(scope="session")
def lost_table():
    """Six candidates along x, of which the stiffest are lost."""
    return sweep(["kp_pitch=100..2000:3", "kp_velocity_x=3..6:2"], axis="x", amplitude=1.0)


@pytest.fixture
def make_table():
    """Return a table of made-up numbers: a candidate a row of the metrics of a flight."""

    def make(values, diverged_at, *texts, method="grid"):
        values = np.array(values, dtype=float)
        ranges = tuple(map(parse_range, texts or ["kp_roll=100..400:4"]))
        count = len(values)
        parameters = np.column_stack([np.linspace(r.low, r.high, count) for r in ranges])
        return SweepTable(
            case=SweepCase("x", 2.0),
            vehicle="quad",
            ranges=ranges,
            method=method,
            seed=0,
            planned=count,
            metrics=FLOWN_METRICS,
            parameters=parameters,
            values=values,
            diverged_at=np.array(diverged_at, dtype=float),
            present=np.array([r.low for r in ranges]),
            present_values=values[0],
        )

    return make
