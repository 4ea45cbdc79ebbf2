"""S, T, KS and GS against python-control's, of plant and law taken apart, and against margins."""

import dataclasses
import math

import control
import numpy as np
import pytest

from workbench.common.errors import WorkbenchError
from workbench.design.judge.gang_of_four import control_point, gang_of_four
from workbench.design.judge.margins import loop_margins
from workbench.design.linear.linearize import linearize
from workbench.design.linear.operating_point import OperatingPoint
from workbench.design.linear.study import LinearStudy
from workbench.scenario.scenario import Scenario

HOLDING = OperatingPoint(hold=True)


def response(system, frequency):
    """A system's response by python-control."""
    found = control.frequency_response(system, frequency)
    return np.squeeze(found.frdata if hasattr(found, "frdata") else found.fresp)


def close(found, wanted):
    """Equal in size and phase, relative to the largest nearby."""
    np.testing.assert_allclose(found, wanted, rtol=1e-6, atol=1e-9 * np.abs(wanted).max())


@pytest.mark.parametrize(
    ("controller", "name"),
    [("pid", "roll_rate"), ("geometric", "velocity_z"), ("indi", "yaw_rate")],
)
def test_all_four_are_those_of_plant_and_law(controller, name):
    """Loops through which nothing else goes: their law and their plant are found alone."""
    model = LinearStudy(Scenario(controller=controller)).sampled()
    loop = model.controller.loop(name)
    found = gang_of_four(model, loop)
    opened = model.opened([loop.error])
    law = opened.state_space([loop.error], [loop.actuator])
    plant = -opened.state_space([loop.actuator], [loop.error])
    # S and T by hand: feedback with 1 makes a system without states, which warns on NumPy 2.5
    loop_response = response(law * plant, found.frequency)
    close(found.open_loop, loop_response)
    close(found.sensitivity, 1.0 / (1.0 + loop_response))
    close(found.complementary_sensitivity, loop_response / (1.0 + loop_response))
    for system, curve in (
        (control.feedback(law, plant), found.control_sensitivity),
        (control.feedback(plant, law), found.load_sensitivity),
    ):
        close(curve, response(system, found.frequency))


@pytest.mark.parametrize(
    ("name", "cut"), [("velocity_x", "actuator"), ("pitch", "error"), ("position_y", "actuator")]
)
def test_curves_are_those_of_linearize(name, cut):
    """Whatever else goes through the loop: the path of `workbench linearize` says the same."""
    model = LinearStudy().sampled(HOLDING if name.startswith("position") else OperatingPoint())
    loop = model.controller.loop(name)
    found = gang_of_four(model, loop, cut)
    close(found.open_loop, response(linearize(loop=name, cut=cut), found.frequency))
    control_name = control_point(model, loop)
    point = {"at": HOLDING} if loop.hold else {}
    ends = {"inputs": [loop.error, control_name], "outputs": [loop.error, control_name]}
    closed = response(linearize(**ends, **point), found.frequency)
    close(found.control_sensitivity, closed[1, 0])
    close(found.load_sensitivity, -closed[0, 1])


def test_noise_on_a_velocity_is_answered_by_its_gain():
    """A proportional law asks for its gain times what is left of the noise: KS = k S."""
    study = LinearStudy(Scenario(controller="geometric"))
    model = study.sampled(gains={"k_velocity_z": 3.0})
    found = gang_of_four(model, model.controller.loop("velocity_z"), "error")
    np.testing.assert_allclose(found.control_sensitivity, 3.0 * found.sensitivity, rtol=1e-4)
    assert (found.error_unit, found.control_unit) == ("m/s", "m/s^2")
    # a constant load of 1 m/s² leaves 1 / k of velocity
    assert abs(found.load_sensitivity[0]) == pytest.approx(1.0 / 3.0, rel=1e-3)


@pytest.mark.parametrize("cut", ["actuator", "error"])
def test_margins_read_off_the_curves_are_those_of_the_table(steering, holding, cut):
    for loop in steering.loops:
        model = holding if loop.hold else steering
        found, wanted = gang_of_four(model, loop, cut), loop_margins(model, loop.point(cut))
        assert dataclasses.asdict(found.margins) == pytest.approx(dataclasses.asdict(wanted))
        size, log = 20.0 * np.log10(np.abs(found.open_loop)), np.log(found.frequency)
        place = np.flatnonzero((size[:-1] > 0.0) & (size[1:] <= 0.0))[-1]
        share = size[place] / (size[place] - size[place + 1])
        crossover = math.exp(log[place] + share * (log[place + 1] - log[place]))
        assert crossover == pytest.approx(wanted.crossover, rel=1e-3)
        phase = np.unwrap(np.angle(found.open_loop))
        turn = np.interp(math.log(wanted.crossover), log, phase) + math.pi
        margin = abs(math.remainder(turn, 2.0 * math.pi))
        assert math.degrees(margin) >= math.degrees(wanted.phase_margin) - 0.1
        if loop.name in ("roll", "pitch", "velocity_x"):
            assert math.degrees(margin) == pytest.approx(math.degrees(wanted.phase_margin), abs=0.1)
        peak = np.abs(found.sensitivity).max()
        assert peak == pytest.approx(wanted.peak_sensitivity, rel=2e-3)


def test_a_loop_without_a_place_of_its_own_asks_by_the_one_inside(steering, holding):
    controller = steering.controller
    assert control_point(holding, controller.loop("position_x")) == "acceleration_x"
    assert control_point(steering, controller.loop("pitch")) == "pitch_acceleration"
    pid = LinearStudy(Scenario(controller="pid")).sampled()
    assert control_point(pid, pid.controller.loop("roll")) == "angular_acceleration_x"
    alone = dataclasses.replace(controller.loop("velocity_x"), actuator="", axis="")
    found = gang_of_four(steering, alone)
    assert found.control == found.error == "velocity_x_error"
    close(found.control_sensitivity, found.sensitivity)
    close(found.load_sensitivity, found.complementary_sensitivity)


def test_another_cut_is_refused(steering):
    with pytest.raises(WorkbenchError, match="place to cut a loop"):
        gang_of_four(steering, steering.loops[0], "middle")
