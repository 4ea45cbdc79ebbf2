"""The margins of the loops that a controller states."""

import pytest

from workbench.common.resources import controllers_dir
from workbench.design.judge.loop_judgement import judge_loops
from workbench.design.linear.operating_point import OperatingPoint
from workbench.design.linear.study import LinearStudy
from workbench.scenario.scenario import Scenario

TEXT = (controllers_dir() / "pd.py").read_text(encoding="utf-8")


@pytest.mark.parametrize("kept", [4, 0])
def test_a_controller_without_loops_that_hold_is_judged(tmp_path, kept):
    path = tmp_path / "law.py"
    path.write_text(f"{TEXT}\nLOOPS = LOOPS[3 : 3 + {kept}]\n", encoding="utf-8")
    study = LinearStudy(Scenario(controller=str(path)))
    holding = study.sampled(OperatingPoint(hold=True))
    found = judge_loops(study.sampled(), holding)
    names = ("roll", "pitch", "yaw_rate", "position_x")[:kept]
    assert tuple(each.loop for each in found) == names
