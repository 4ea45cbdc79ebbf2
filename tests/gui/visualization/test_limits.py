"""Measured steps, and limits of a spec on the curves that they judge."""

from pathlib import Path

import numpy as np
import pytest

from workbench.common.resources import models_dir
from workbench.design.regress.signals import SIGNALS
from workbench.design.response_metrics import step_metrics
from workbench.gui.charts.curve import LIMIT
from workbench.gui.signals import Signals
from workbench.gui.visualization.chart_board import chart_signal, lines_over_time
from workbench.gui.visualization.layouts import STEPS, ChartSpec, Layout
from workbench.gui.visualization.log_messages import CaseLimits, SpecContents
from workbench.gui.visualization.log_worker import limits_of

SPEC = models_dir() / "specs" / "steps.spec.yaml"
STEP = ChartSpec("Steps", ("command_velocity.v_x", "velocity_data.v_x"), STEPS)


@pytest.fixture
def page(begun, workspace, canned):
    for some in canned.published:
        workspace.signals.add(some)
    begun.show_view(canned.views[-1])
    begun.charts.show_layout(Layout(charts=(STEP, ChartSpec("v", ("velocity_data.v_x",)))))
    begun.charts.refresh(3.0)
    return begun.charts


def test_the_flown_step_is_measured(page):
    """2 m/s along x, from 1 s on."""
    chart = page.board.panes[0].chart
    (step,) = chart.steps
    assert (step.begin, step.amplitude) == pytest.approx((1.0, 2.0), abs=0.02)
    time, flown = page._source.series("velocity_data.v_x")
    part = time >= step.begin
    wanted = step_metrics(time[part] - step.begin, flown[part], 2.0)
    assert step.metrics.numbers == pytest.approx(wanted.numbers, nan_ok=True)
    heads = [chart.statistics.horizontalHeaderItem(each).text() for each in range(4)]
    assert heads == ["Step", "At s", "By m/s", "rise_time s"]
    assert float(chart.statistics.item(0, 3).text()) == pytest.approx(wanted.rise_time, abs=1e-3)


def test_the_limits_of_a_spec_stand_where_they_judge(begun, page, qtbot):
    begun.open_spec(SPEC)
    qtbot.waitUntil(lambda: page.limits.isVisible())
    chart = page.board.panes[0].chart
    qtbot.waitUntil(lambda: len(chart.curves) > 2)
    drawn = {}
    for curve in chart.curves:
        if curve.colour == LIMIT:
            drawn.setdefault(curve.label, []).append(curve.samples(-np.inf))
    end = chart.steps[0].time[-1]
    (over,), settled, error = (
        drawn[name]
        for name in ("overshoot ≤ 5 %", "settling_time ≤ 0.9 s", "steady_state_error ≤ 1 %")
    )
    assert set(over[1]) == {2.0 * 1.05}
    assert [set(values) for _, values in settled] == [{2.0 * 0.98}, {2.0 * 1.02}]
    assert [time[0] for time, _ in settled] == [0.9, 0.9]
    assert [set(values) for _, values in error] == [{2.0 * 0.99}, {2.0 * 1.01}]
    assert error[0][0][0] == pytest.approx(0.8 * end)
    (_, low), (band_time, high) = drawn["baseline"]
    assert len(band_time) > 100 and (high - low >= 0.06 - 1e-9).all()
    assert "rise_time ≤ 0.4 s" in drawn and "rise_time ≥ 0.32 s" in drawn
    labels = [entry.label for entry in chart.legend.entries]
    assert len(set(labels)) == len(labels)
    chart.toggle_curve(labels.index("settling_time ≤ 0.9 s"))
    hidden = [curve.label for curve in chart.curves if not curve.visible]
    assert hidden == 2 * ["settling_time ≤ 0.9 s"]
    page.no_limits.click()
    qtbot.waitUntil(lambda: not any(each.colour == LIMIT for each in chart.curves))


def test_bounds_of_a_signal_are_levels_over_time(page):
    spec = SpecContents(
        Path("a.spec.yaml"),
        (
            CaseLimits("fast", "v_x", 2.0, {"maximum of v_x": (-np.inf, 2.2)}, {}),
            CaseLimits("calm", "v_x", np.nan, {"minimum": (-0.1, np.inf)}, {}),
            CaseLimits("imu", "", np.nan, {"mean of imu.f_z": (9.0, 10.0)}, {}),
        ),
    )
    page.show_limits(spec)
    chart = page.board.panes[1].chart
    chart.redraw()
    levels = {curve.label: curve.samples(0.0)[1][0] for curve in chart.curves[1:]}
    assert levels == {"fast: maximum ≤": 2.2, "calm: minimum ≥": -0.1}
    assert all(
        line.time[0] <= 0.0 and line.time[-1] >= 2.0 for line in chart.canvas.content.lines[1:]
    )
    assert lines_over_time(spec, "imu.specific_force.2") == [
        ("imu: mean ≥", 9.0),
        ("imu: mean ≤", 10.0),
    ]


def test_signals_of_specs_have_the_names_of_charts(canned):
    signals = Signals()
    signals.begin(canned.views[0].topics)
    without = {"tilt", "thrust", "rotor_use"}
    for name in [each.name for each in SIGNALS] + ["imu.f_z", "imu.w_x"]:
        number = name.rpartition("_")[2]
        if name in without or (number.isdecimal() and int(number) > 4):
            continue
        assert chart_signal(name) in signals.units, name
    assert {chart_signal(name) for name in without} == {""}
    assert chart_signal("radar.range") == ""


def test_every_shipped_spec_has_limits_to_draw():
    for path in (
        SPEC,
        SPEC.with_name("limits.spec.yaml"),
        SPEC.with_name("sensor-noise.spec.yaml"),
    ):
        spec = limits_of(path)
        assert spec.cases and all(case.limits or case.bands for case in spec.cases), path
