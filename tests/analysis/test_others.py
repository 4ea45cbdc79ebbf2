"""Another controller than the one that flies, against a scenario that is flown by that one."""

import pytest

from workbench.analysis.queries import (
    DrawFrequency,
    Judge,
    OtherControllerQuery,
    Predict,
    RequestedStep,
)
from workbench.analysis.subject import AnalysedVehicle
from workbench.common.errors import WorkbenchError
from workbench.design.judge.report import judge
from workbench.design.step_response import fly_step
from workbench.scenario.scenario import Scenario

LQI = Scenario(controller="lqi")


@pytest.mark.slow
def test_another_controller_has_its_own_gains_and_the_margins_of_the_judge(answer):
    about = AnalysedVehicle(Scenario(), {"kp_pitch": 50.0, "max_tilt": 0.3})
    reply = answer(OtherControllerQuery("lqi", Judge({})), about)
    expected = {loop.loop: loop.actuator for loop in judge(LQI).loops}
    assert len(reply.loops) == len(expected) > 3
    for loop in reply.loops:
        assert loop.phase_margin == pytest.approx(expected[loop.name].phase_margin, rel=1e-3)
        assert loop.disk_margin == pytest.approx(expected[loop.name].disk_margin, rel=1e-3)
    loop = reply.loops[0]
    curves = answer(OtherControllerQuery("lqi", DrawFrequency({}, loop.name)), about)
    assert curves.margins.phase_margin == pytest.approx(loop.phase_margin, rel=1e-6)
    assert about.gains({})["kp_pitch"] == 50.0


def test_filters_that_fly_act_on_the_other_one_too(answer):
    plain, slow = (
        {loop.name: loop for loop in answer(OtherControllerQuery("pid", Judge(gains))).loops}
        for gains in ({}, {"gyro_lowpass": 20.0})
    )
    for name in ("roll_rate", "pitch_rate"):
        assert slow[name].phase_margin < plain[name].phase_margin - 0.2
    # as settings of the flight, too; its gains are of another law
    about = AnalysedVehicle(Scenario(), {"gyro_lowpass": 20.0, "kp_pitch": 300.0})
    for loop in answer(OtherControllerQuery("pid", Judge({})), about).loops:
        assert loop.phase_margin == pytest.approx(slow[loop.name].phase_margin, rel=1e-9)


@pytest.mark.slow  # its machine code may have to be made
def test_a_step_of_another_controller_is_as_the_diagram_flies_it(answer):
    predicted = answer(OtherControllerQuery("lqi", Predict({}, RequestedStep("x", 1.0, 2.0))))
    flown = fly_step("x", 1.0, duration=2.0, scenario=LQI)
    assert predicted.response == pytest.approx(flown.response, abs=1e-3)


def test_a_controller_that_is_none_is_a_sentence(answer):
    with pytest.raises(WorkbenchError, match="pqr"):
        answer(OtherControllerQuery("pqr", Judge({})))
