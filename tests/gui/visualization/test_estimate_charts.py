"""The charts of an estimate, on the stream of a flight on one."""

import numpy as np
import pytest

from workbench.gui.signals import Signals
from workbench.gui.visualization.derived_signals import WithDerived
from workbench.gui.visualization.layouts import LAYOUT_PRESETS
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
