"""Measured loops of laws with slower parts."""

import math

import numpy as np
import pytest

from workbench.common.errors import WorkbenchError
from workbench.control.controller_file import load_controller
from workbench.design.judge.loop_measurement import fly_measurement
from workbench.design.judge.measured_loop import MIN_COHERENCE
from workbench.scenario.scenario import Injection, Scenario
from workbench.session.session import Session

LIGHT = {"turbulence": 7.7}


def close(found, least):
    """Within 1 dB and 5 degrees up to the bandwidth, where it is coherent."""
    measured = found.measured
    counts = (measured.coherence >= MIN_COHERENCE) & (measured.frequency <= found.margins.bandwidth)
    assert counts.sum() >= least, found.loop
    size, phase = found.worst()
    assert size <= 1.0 and math.degrees(phase) <= 5.0, (found.loop, size, math.degrees(phase))


def test_a_point_counts_at_the_rate_of_the_part_that_reads_it(case):
    """As the firmwares have it: PX4's position and attitude loops, Crazyflie's and Betaflight's
    outer loops run in every n-th update."""
    for name, wanted in (
        ("px4", {"position": 5, "velocity": 5, "attitude": 2, "rate": 1, "torque": 1}),
        ("crazyflie", {"position": 5, "velocity": 5, "attitude": 1, "rate": 1, "torque": 1}),
        ("betaflight", {"position": 8, "velocity": 8, "angle": 1, "rate": 1, "torque": 1}),
    ):
        for point, divider in load_controller(name).point_dividers.items():
            if not point.endswith("_setpoint"):
                with case((name, point)):
                    assert divider == wanted[point.split("_")[0]]
    # PX4's position part makes the setpoint of attitude, its attitude part that of the rates
    px4 = load_controller("px4").point_dividers
    assert (px4["roll_setpoint"], px4["roll_rate_setpoint"]) == (5, 1)
    assert set(load_controller("pd").point_dividers.values()) == {1}


def test_an_injection_is_held_over_the_updates_in_which_its_part_does_not_run():
    session = Session(Scenario(controller="px4"))
    session.tick(0.013)
    session.inject(Injection("velocity_z_error", 0.1, 20.0, 200.0, 3))
    while session.injecting < 1.0:
        session.tick(0.1)
    injected = session.injected
    assert injected.multisine.spacing == 5 / 512 and np.abs(injected.came).min() > 0.0
    with pytest.raises(WorkbenchError, match="up to 321.7 rad/s"):
        session.inject(Injection("velocity_z_error", 0.1, 20.0, 400.0, 3))


@pytest.mark.slow
def test_a_loop_of_a_law_with_parts_at_several_rates_is_that_of_the_model():
    """In light turbulence."""
    close(fly_measurement("pitch", scenario=Scenario(controller="px4"), settings=LIGHT), least=2)
