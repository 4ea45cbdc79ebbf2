"""Measured steps, and limits of a spec on the curves that they judge."""

from pathlib import Path

import numpy as np
import pytest

from workbench.common.resources import models_dir
from workbench.design.regress.signals import RECORDED_SIGNALS
from workbench.design.step_metrics import step_metrics
from workbench.design.step_responses import LoggedStep
from workbench.gui.charts.chart_kind import STEP_CHART
from workbench.gui.charts.curve import LIMIT_COLOUR, CurveStyle, fixed_source
from workbench.gui.charts.step_chart import StepChart
from workbench.gui.signals import Signals
from workbench.gui.visualization.layouts import ChartLayout, ChartSpec
from workbench.gui.visualization.limit_lines import chart_signal, limits_of_step, lines_over_time
from workbench.gui.visualization.log_worker import spec_limits
from workbench.gui.visualization.spec_limits import CaseLimits, SpecContents

SPEC = models_dir() / "specs" / "steps.workbench.yaml"
STEP = ChartSpec("Steps", ("command_velocity.v_x", "velocity_data.v_x"), STEP_CHART)


@pytest.fixture
def page(begun, workspace, canned):
    for some in canned.published:
        workspace.signals.add(some)
    begun.show_view(canned.views[-1])
    begun.charts.show_layout(ChartLayout(charts=(STEP, ChartSpec("v", ("velocity_data.v_x",)))))
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
        if curve.colour == LIMIT_COLOUR:
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
    chart.toggle_entry(labels.index("settling_time ≤ 0.9 s"))
    hidden = [curve.label for curve in chart.curves if not curve.visible]
    assert hidden == 2 * ["settling_time ≤ 0.9 s"]
    page.no_limits.click()
    qtbot.waitUntil(lambda: not any(each.colour == LIMIT_COLOUR for each in chart.curves))


def test_limits_of_a_step_downwards_are_those_of_the_nearest_case_downwards_on_its_sides():
    """Of a step of -2 by hand: beyond it by 5 % is -2.1, and to the wrong side by 3 % is 0.06."""
    time = np.linspace(0.0, 3.0, 301)
    response = -2.0 * (1.0 - np.exp(-3.0 * time))
    step = LoggedStep(1.0, -2.0, time, response, step_metrics(time, response, -2.0))
    bounds = {"overshoot": 5.0, "undershoot": 3.0, "peak": 2.2}
    cases = [
        CaseLimits(f"{command:g}", "v_x", command, {"overshoot": (-np.inf, other)}, {})
        for command, other in ((0.1, 1.0), (-9.0, 2.0))  # one is nearer, but upwards
    ]
    limits = {name: (-np.inf, bound) for name, bound in bounds.items()}
    cases.insert(1, CaseLimits("-5", "v_x", -5.0, limits, {}))
    spec = SpecContents(Path("a.workbench.yaml"), tuple(cases))
    drawn = limits_of_step(spec, "velocity_data.v_x", step)
    levels = {each.name.partition(" ")[0]: set(each.values) for each in drawn}
    wanted = {"overshoot": -2.1, "undershoot": 0.06, "peak": -2.2}
    assert {name: value for name, (value,) in levels.items()} == pytest.approx(wanted)


def test_bounds_of_a_signal_are_levels_over_time(page):
    spec = SpecContents(
        Path("a.workbench.yaml"),
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
    for name in [each.name for each in RECORDED_SIGNALS] + ["imu.f_z", "imu.w_x"]:
        number = name.rpartition("_")[2]
        if name in without or (number.isdecimal() and int(number) > 4):
            continue
        assert chart_signal(name) in signals.units, name
    assert {chart_signal(name) for name in without} == {""}
    assert chart_signal("radar.range") == ""


def test_every_shipped_spec_has_limits_to_draw():
    for path in (
        SPEC,
        SPEC.with_name("limits.workbench.yaml"),
        SPEC.with_name("sensor-noise.workbench.yaml"),
    ):
        spec = spec_limits(path)
        assert spec.cases and all(case.limits or case.bands for case in spec.cases), path


def test_steps_of_an_angular_rate_are_listed_in_degrees_the_newest_first(qtbot, workspace):
    """Of 0.25 and 0.5 rad/s, followed at once: 14.32 and 28.65 °/s, each by its own colour."""
    time = np.arange(0.0, 9.0, 0.01)
    asked = np.select([time < 2.0, time < 5.0], [0.0, 0.25], 0.75)
    chart = StepChart(workspace)
    qtbot.addWidget(chart)
    chart.add_curve("asked", "rad/s", fixed_source(time, asked))
    chart.add_curve("flown", "rad/s", fixed_source(time, asked))
    chart.refresh(9.0)
    chart.make()
    chart.redraw()
    table = chart.statistics
    assert table.horizontalHeaderItem(2).text() == "By °/s"
    rows = [[table.item(row, column).text() for column in range(3)] for row in range(2)]
    assert rows == [["step 2", "5.00", "28.65"], ["step 1", "2.00", "14.32"]]
    first, second = chart.curves[:2]
    assert (first.style, second.style) == (CurveStyle.FAINT, CurveStyle.SOLID)
    assert first.colour != second.colour


def test_the_command_is_that_of_ones_own_step_beside_another_flight(qtbot, workspace):
    time = np.arange(0.0, 9.0, 0.01)
    own, other = (fixed_source(time, size * (time >= 2.0)) for size in (0.5, 2.0))
    chart = StepChart(workspace)
    qtbot.addWidget(chart)
    chart.add_curve("asked", "m/s", own)
    chart.add_curve("flown", "m/s", own)
    chart.add_over(other, "flown · b", "m/s", other, 3)
    chart.refresh(9.0)
    chart.make()
    assert [step.amplitude for step in chart.steps] == [0.5, 2.0]
    (command,) = (curve for curve in chart.curves if curve.label == "command")
    assert set(command.samples(0.0)[1]) == {0.5}
