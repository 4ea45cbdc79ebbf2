"""Oracle: two known signals."""

import numpy as np
import pytest
from pydrake.systems.analysis import Simulator
from pydrake.systems.framework import DiagramBuilder
from pydrake.systems.primitives import ConstantVectorSource, TrajectorySource
from pydrake.trajectories import PiecewisePolynomial

from workbench.systems.recorder import add_recorder

PERIOD = 1 / 16


@pytest.fixture
def flown():
    """One second of (t, 2 t) beside the constant 7."""
    builder = DiagramBuilder()
    ramp = PiecewisePolynomial.FirstOrderHold([0.0, 10.0], [[0.0, 10.0], [0.0, 20.0]])
    moving = builder.AddSystem(TrajectorySource(ramp))
    still = builder.AddSystem(ConstantVectorSource([7.0]))
    ports = {"moving": moving.get_output_port(), "still": still.get_output_port()}
    recorder = add_recorder(builder, ports, PERIOD)
    simulator = Simulator(builder.Build())
    simulator.AdvanceTo(1.0)
    return recorder, simulator


def test_every_signal_is_recorded_every_period_under_its_name(flown):
    recorder, simulator = flown
    context = simulator.get_context()
    times = recorder.times(context)
    assert times.tolist() == [PERIOD * i for i in range(17)]
    signals = recorder.signals(context)
    assert list(signals) == ["moving", "still"]
    assert signals["moving"] == pytest.approx(np.column_stack([times, 2.0 * times]))
    assert signals["still"].tolist() == [[7.0]] * 17


def test_now_is_the_present_between_samples(flown):
    recorder, simulator = flown
    simulator.AdvanceTo(1.03)
    now = recorder.now(simulator.get_context())
    assert now["moving"] == pytest.approx([1.03, 2.06])
    assert now["still"].tolist() == [7.0]


def test_what_is_returned_is_a_copy(flown):
    recorder, simulator = flown
    context = simulator.get_context()
    recorder.times(context)[:] = -1.0
    recorder.signals(context)["moving"][:] = -1.0
    assert recorder.times(context).min() == 0.0
    assert recorder.signals(context)["moving"].min() == 0.0
