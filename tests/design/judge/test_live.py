"""Oracle: the same from two models, one of steering and one of holding."""

import pytest

from workbench.control.controller_file import load_controller
from workbench.design.judge.loop_judgement import live_margins
from workbench.design.judge.margins import loop_margins
from workbench.design.linear.operating_point import OperatingPoint
from workbench.design.linear.study import LinearStudy

LOOPS = load_controller().loops


@pytest.mark.parametrize("gains", [{}, {"kp_pitch": 150.0, "kp_velocity_y": 6.0}])
def test_one_linearisation_gives_the_margins_of_both_models(gains):
    study = LinearStudy()
    models = {hold: study.sampled(OperatingPoint(hold=hold), gains) for hold in (False, True)}
    found = live_margins(study, gains)
    assert [live.loop for live in found] == [loop.name for loop in LOOPS]
    for live, loop in zip(found, LOOPS, strict=True):
        wanted = loop_margins(models[loop.hold], loop.actuator)
        assert vars(live.margins) == pytest.approx(vars(wanted), rel=1e-6, nan_ok=True)
