"""A hover check measures what was flown, and says what is not as demanded."""

import dataclasses
import math
from functools import partial
from types import SimpleNamespace

import numpy as np
import pytest

from workbench.common.quantity import number_or_dash
from workbench.design import hover_check
from workbench.design.hover_check import check_hover
from workbench.design.metrics import Demand
from workbench.design.plots_step import plot_hover
from workbench.design.step_response import USUAL_STEPS, fly_step
from workbench.scenario.scenario import Action, FigureEight, Scenario, ScenarioStart


@pytest.fixture(scope="module")
def shares():
    return []


SCENARIO = Scenario(
    start=ScenarioStart(mode="off"),
    script=[Action(at=1.0, velocity=[5.0, 0.0, 0.0])],
    figure_eight=FigureEight(),
    duration=99.0,
)
"""Its start, path and script are not flown."""
SHORT_STEP_S = 2.0


@pytest.fixture(scope="module")
def report(shares):
    """The shipped drone, with short steps."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(hover_check, "fly_step", partial(fly_step, duration=SHORT_STEP_S))
        return check_hover(SCENARIO, progress=shares.append)


@pytest.fixture(scope="module")
def bad_report():
    """A roll loop with no damping to speak of swings up from the nudge; yaw is not answered."""
    return check_hover(settings={"kp_roll": 20.0, "kd_roll": 2.0, "kp_yaw_rate": 0.0})


def demands(report) -> dict[tuple[str, str], Demand]:
    return {(demand.criterion, demand.quantity): demand for demand in report.demands}


@pytest.mark.slow
def test_the_shipped_drone_meets_everything():
    assert [demand.met for demand in check_hover(SCENARIO).demands] == [True] * 10


@pytest.mark.slow
def test_drift_and_tilt_are_those_of_ten_seconds(report):
    hover = report.hover
    assert hover.time[-1] - hover.time[0] == 10.0
    distance = np.sqrt(((hover.p_WB - [0.0, 0.0, 10.0]) ** 2).sum(axis=1))
    assert report.drift == pytest.approx(distance, abs=1e-12)
    assert report.tilt == pytest.approx(hover.tilt, abs=1e-6)  # it begins upright
    assert 1e-4 < report.drift.max() < 0.005  # the nudge shows, and is small beside the limit
    assert math.radians(0.001) < report.tilt.max() < math.radians(0.1)
    assert report.drift[-1] < 1e-5
    found = demands(report)
    assert found["hover", "drift"].value == report.drift.max()
    assert found["hover", "tilt"].value == report.tilt.max()
    assert report.rotor_use == pytest.approx(738.3 / 1100, rel=1e-2)


def test_steps_are_those_of_the_step_command(report):
    assert [(step.axis, step.amplitude) for step in report.steps] == list(USUAL_STEPS)
    alone = fly_step("x", 1.0, duration=SHORT_STEP_S)
    assert dataclasses.asdict(report.steps[0].metrics) == dataclasses.asdict(alone.metrics)
    assert demands(report)["x step", "overshoot"].value == alone.metrics.overshoot


def test_limits_are_the_issues(report):
    limits = {key: (d.limit, d.unit) for key, d in demands(report).items()}
    assert limits["hover", "drift"] == (0.05, "m")
    assert limits["hover", "tilt"] == (pytest.approx(math.radians(0.5)), "rad")
    for axis in ("x", "y", "z", "yaw"):
        assert limits[f"{axis} step", "overshoot"] == (15.0, "%")


def test_progress_goes_from_nothing_to_all(report, shares):
    assert shares == sorted(shares)
    assert 0.0 < shares[0] < 0.05
    assert shares[-1] == 1.0


@pytest.mark.slow
def test_a_hover_that_is_not_stable_is_seen(bad_report):
    found = demands(bad_report)
    missed = {key for key, demand in found.items() if not demand.met}
    assert {("hover", "drift"), ("hover", "tilt"), ("y step", "overshoot")} <= missed
    assert bad_report.drift[0] == 0.0


@pytest.mark.parametrize(("value", "met"), [(1.0, True), (1.001, False), (math.nan, False)])
def test_a_demand_is_met_up_to_its_limit_and_never_by_nan(value, met):
    assert Demand("hover", "drift", "m", value, 1.0).met is met


@pytest.mark.slow
def test_a_step_that_is_not_answered_is_not_met(bad_report):
    assert not demands(bad_report)["yaw step", "steady_state_error"].met


@pytest.mark.slow
def test_the_figure_shows_hover_and_steps_with_their_limits(report, bad_report, tmp_path):
    for each in (report, bad_report):
        figure = plot_hover(each)
        figure.savefig(tmp_path / "hover.png")
        titles = [axes.get_title(loc="left") for axes in figure.axes]
        assert titles[:2] == ["distance from where it began", "tilt away from where it began"]
        for title, step in zip(titles[2:], each.steps, strict=True):
            assert f"overshoot {number_or_dash(step.metrics.overshoot, '.1f')} %" in title
        drift, limit = figure.axes[0].get_lines()
        assert drift.get_ydata() == pytest.approx(1000.0 * each.drift)
        assert limit.get_ydata()[0] == 50.0
        response = figure.axes[2].get_lines()[1]
        assert np.interp(1.0, response.get_xdata(), response.get_ydata()) == pytest.approx(
            np.interp(1.0, each.steps[0].time, each.steps[0].response)
        )
        for axes in figure.axes:
            assert "[" in axes.get_ylabel()
            assert "[s]" in axes.get_xlabel()
            legend = axes.get_legend()
            if legend:
                assert not legend.get_window_extent().overlaps(axes.get_window_extent())


def test_tilt_is_from_the_attitude_in_which_a_hover_begins(monkeypatch):
    """A drone that hovers leaning does not tilt; the angle between two axes, by arccos."""
    angles = np.array([0.1, 0.1, 0.25, 0.02])
    z_axis_W = np.column_stack([np.sin(angles), np.zeros(4), np.cos(angles)])
    hover = SimpleNamespace(z_axis_W=z_axis_W, p_WB=np.zeros((4, 3)))
    flown = SimpleNamespace(recording=hover, exchange={}, ended="")
    monkeypatch.setattr(hover_check, "USUAL_STEPS", ())
    monkeypatch.setattr(hover_check, "_fly_hover", lambda setup, progress: flown)
    tilt = check_hover().tilt
    assert tilt[2:] == pytest.approx(np.arccos((z_axis_W @ z_axis_W[0])[2:]), rel=1e-9)
    assert tilt == pytest.approx([0.0, 0.0, 0.15, 0.08], abs=1e-12)
