"""The demands of a reproduced step, at and beyond their limits."""

import math
from dataclasses import replace

import numpy as np
import pytest

from workbench.design.reproduce import (
    PAPER_FIGURES,
    ReproducedRow,
    implied_t90,
    mean_until,
    paper_checks,
    unmet_demands,
)
from workbench.design.step_metrics import StepMetrics
from workbench.design.step_response import Coupling, StepResponse

STILL = Coupling(0.0, 0.0, 0.0, 0.0)


def make_row(axis, *, acceleration=1.0, force=1.0, overshoot=0.0, error=0.0, coupling=STILL):
    """Return a row whose means are these multiples of the paper's."""
    paper = next(figure for figure in PAPER_FIGURES if figure.axis == axis)
    metrics = StepMetrics(0.4, 0.8, overshoot, 0.0, 1.0, 5.0, 1.0, error)
    flight = StepResponse(None, axis, paper.command, metrics, 0.8, coupling)
    mean = acceleration * paper.mean_acceleration
    return ReproducedRow(paper, flight, 0.9 * paper.command / mean, mean, force * paper.mean_force)


@pytest.mark.parametrize("axis", ["x", "y", "z", "yaw"])
def test_the_papers_own_numbers_meet_every_demand(axis):
    assert unmet_demands([make_row(axis)]) == []


def test_mean_acceleration_within_five_percent(case):
    for sign in [-1, 1]:
        for axis in ["x", "y", "z", "yaw"]:
            with case(sign, axis):
                assert unmet_demands([make_row(axis, acceleration=1 + sign * 0.049)]) == []
                (sentence,) = unmet_demands([make_row(axis, acceleration=1 + sign * 0.051)])
                assert f"mean acceleration of the {axis} step" in sentence
                assert "within 5 %" in sentence


@pytest.mark.parametrize(("axis", "limit"), [("x", 0.05), ("y", 0.05), ("z", 0.03)])
def test_mean_force_within_its_axis_limit(axis, limit):
    assert unmet_demands([make_row(axis, force=1 + limit - 1e-3)]) == []
    assert len(unmet_demands([make_row(axis, force=1 - limit - 1e-3)])) == 1


def test_yaw_torque_is_reported_and_not_demanded():
    row = make_row("yaw", force=0.01)
    assert unmet_demands([row]) == []
    torque = next(check for check in paper_checks(row) if check.quantity == "mean torque")
    assert torque.difference == pytest.approx(-99.0)
    assert torque.demand == ""


@pytest.mark.parametrize(
    ("change", "word"),
    [
        ({"overshoot": 5.1}, "overshoot"),
        ({"error": 1.1}, "steady-state error"),
        ({"coupling": replace(STILL, z=0.051)}, "height change"),
        ({"coupling": replace(STILL, y=-0.011)}, "drift along y"),
        ({"overshoot": math.nan}, "overshoot"),
        ({"acceleration": math.nan}, "mean acceleration"),
    ],
)
def test_what_is_out_of_its_limit_is_named_once(change, word):
    (sentence,) = unmet_demands([make_row("x", **change)])
    assert sentence.startswith(word)


def test_height_may_change_while_climbing():
    assert unmet_demands([make_row("z", coupling=replace(STILL, z=1.0))]) == []


def test_the_papers_accelerations_imply_rise_times():
    implied = {figure.axis: implied_t90(make_row(figure.axis)) for figure in PAPER_FIGURES}
    assert implied == pytest.approx({"z": 0.5, "x": 0.45, "y": 0.45, "yaw": 0.545}, abs=1e-3)


def test_a_mean_until_a_time_between_samples_is_that_of_the_line_between_them():
    """Of t², samples 0.1 s apart: the trapezoids up to 0.25 s have an area of 0.00563 m."""
    time = np.arange(0.0, 3.0, 0.1)
    area = 0.1 * (0.01 / 2.0) + 0.1 * (0.01 + 0.04) / 2.0 + 0.05 * (0.04 + 0.065) / 2.0
    assert mean_until(time, time**2, 0.25) == pytest.approx(area / 0.25)
    assert mean_until(time, 3.0 * time, 0.77) == pytest.approx(3.0 * 0.77 / 2.0)
