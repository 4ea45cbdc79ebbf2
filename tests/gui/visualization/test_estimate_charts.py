"""The charts of an estimate, on the stream of a flight on one."""

import numpy as np
import pytest

from workbench.gui.charts.curve import CurveStyle
from workbench.gui.signals import Signals
from workbench.gui.visualization.derived_signals import WithDerived
from workbench.gui.visualization.layouts import LAYOUT_PRESETS, ChartSpec
from workbench.gui.visualization.signal_catalog import estimate_label
from workbench.scenario.scenario import Scenario
from workbench.session.session import Session
from workbench.systems.bridge import Bridge


@pytest.fixture(scope="module")
def source():
    session = Session(Scenario(estimator="ekf"), bridge=Bridge())
    session.tick(1.0)
    signals = Signals()
    signals.begin(session.topics)
    signals.add([each.published for each in session.drain()])
    return WithDerived(signals)


def test_a_flight_on_an_estimate_has_every_signal_of_its_charts(source):
    wanted = {name for chart in LAYOUT_PRESETS["Estimate"] for name in chart.signals}
    assert len(wanted) == 4 * len(LAYOUT_PRESETS["Estimate"])
    assert wanted <= set(source.units)
    assert source.units["bound.roll_low"] == "rad"


def test_the_bounds_are_two_deviations_away(source):
    _, known = source.series("estimate.z")
    _, sigma = source.series("estimate.sigma_z")
    assert len(known) > 100 and sigma.min() > 0.0
    for name, sign in (("bound.z_low", -2.0), ("bound.z_high", 2.0)):
        assert np.array_equal(source.series(name)[1], known + sign * sigma)


def test_the_legend_tells_truth_estimate_and_bounds_apart(begun, source):
    begun.charts.board.show_board(LAYOUT_PRESETS["Estimate"], source)
    curves = begun.charts.board.panes[0].chart.curves
    assert [curve.label for curve in curves] == ["x", "x estimate", "x \N{MINUS SIGN} 2σ", "x + 2σ"]
    assert [curve.style for curve in curves[2:]] == [CurveStyle.FAINT] * 2
    assert curves[2].colour == curves[3].colour == curves[1].colour != curves[0].colour


@pytest.mark.parametrize(
    ("signals", "labels"),
    [
        (("estimate.x", "position_data.x"), ["x estimate", "x"]),
        (("estimate.x", "bound.x_high"), ["x estimate", "x + 2σ"]),
        (("estimate.x", "bound.y_high", "position_data.y"), ["x", "y + 2σ", "y"]),
    ],
)
def test_an_estimate_is_named_so_wherever_its_truth_or_bounds_are(begun, source, signals, labels):
    """Whatever is drawn or added first."""
    charts = [ChartSpec("One", signals), ChartSpec("Other")]
    begun.charts.board.show_board(charts, source)
    all_at_once, one_by_one = begun.charts.board.panes
    for name in signals:
        one_by_one.add_signal(name)
    for pane in (all_at_once, one_by_one):
        assert [curve.label for curve in pane.chart.curves] == labels
        assert pane.spec.signals == signals
    assert estimate_label("estimate.x", ("setpoint.x", "estimate.x")) == ""
