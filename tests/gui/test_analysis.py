"""What screens hear of the analyst, and what the banner does."""

import dataclasses
import os
import signal
from pathlib import Path

import pytest
from PyQt6.QtCore import QThread

from workbench.analysis.queries import (
    DrawMap,
    FindRanges,
    Judge,
    Predict,
    RegressionCase,
    RequestedStep,
    Sensitivities,
    Tune,
)
from workbench.control.controller_file import load_controller
from workbench.gui.analysis import Analysis
from workbench.gui.notices import Notices, Severity
from workbench.scenario.scenario import Scenario, VehicleConfig

ENOUGH = 120_000
"""No test waits so long unless it fails [ms]."""
STEP = RequestedStep("x", 2.0, 1.0)


class Heard:
    """What an analysis said, by kind, and in which thread."""

    def __init__(self, analysis):
        self.refused = []
        self.threads = set()
        self.searched = []
        self.answers = []
        analysis.answered.connect(self.keep)
        analysis.searched.connect(self.searched.append)
        analysis.refused.connect(self.refuse)

    def of(self, kind):
        """Return the answered questions of a kind, in order."""
        return [question for question, _ in self.answers if isinstance(question, kind)]

    def keep(self, question, reply):
        self.threads.add(QThread.currentThread())
        self.answers.append((question, reply))

    def refuse(self, question, said):
        self.threads.add(QThread.currentThread())
        self.refused.append((question, said))


@pytest.fixture
def analysis(qapp):
    notices = Notices()
    made = Analysis(notices)
    made.banner = []
    notices.told.connect(made.banner.append)
    yield made
    made.close()


@pytest.fixture
def heard(analysis):
    return Heard(analysis)


def test_answers_come_by_the_signal_of_their_kind_in_the_thread_of_the_screens(
    qtbot, analysis, heard
):
    analysis.begin(Scenario(), {"kp_roll": 200.0})
    analysis.ask(FindRanges({}))
    analysis.ask(DrawMap({}, "kp_pitch", "kd_pitch", "overshoot", STEP))
    analysis.ask(Predict({}, STEP))
    analysis.ask(Judge({"kd_roll": 20.0}))
    qtbot.waitUntil(lambda: bool(heard.of(FindRanges) and heard.of(DrawMap)), timeout=ENOUGH)
    assert heard.of(Judge)[0].gains == {"kd_roll": 20.0}
    assert heard.of(Predict)[0].step == STEP
    assert heard.threads == {QThread.currentThread()}
    assert not heard.refused
    assert not analysis.banner


def test_of_many_questions_the_last_is_answered_last_and_no_word_is_said_of_the_others(
    qtbot, analysis, heard
):
    analysis.begin(Scenario(), {})
    for number in range(100):
        analysis.ask(Judge({"kp_roll": 100.0 + number}))
    last = {"kp_roll": 199.0}
    qtbot.waitUntil(
        lambda: bool(heard.of(Judge)) and heard.of(Judge)[-1].gains == last, timeout=ENOUGH
    )
    assert len(heard.of(Judge)) < 50
    assert not heard.refused
    assert not analysis.banner


def test_before_a_flight_there_is_nothing_to_judge(analysis, heard):
    analysis.warm_up()
    analysis.stop()
    analysis.ask(Judge({}))
    assert heard.refused == [(Judge({}), "there is nothing to judge yet: open a scenario first")]
    assert not analysis.banner
    analysis.ask(Sensitivities({}, STEP))
    assert [each.severity for each in analysis.banner] == [Severity.WARNING]


def test_what_comes_in_streams_is_refused_beside_it_and_the_rest_in_the_banner_too(
    qtbot, analysis, heard, tmp_path
):
    analysis.begin(Scenario(), {})
    analysis.ask(Judge({"kp_rol": 1.0}))
    qtbot.waitUntil(lambda: len(heard.refused) == 1, timeout=ENOUGH)
    assert heard.refused[0][0] == Judge({"kp_rol": 1.0})
    assert "did you mean 'kp_roll'" in heard.refused[0][1]
    assert not analysis.banner
    analysis.ask(RegressionCase(tmp_path / "a.yaml", {}, STEP))
    qtbot.waitUntil(lambda: len(heard.refused) == 2, timeout=ENOUGH)
    assert "name it NAME.workbench.yaml" in analysis.banner[0].what


def test_nothing_starts_before_it_is_needed_and_the_same_flight_keeps_it(qtbot, analysis, heard):
    scenario, settings = Scenario(), {"kp_roll": 200.0}
    analysis.begin(scenario, settings)
    assert analysis.pids == (None, None, None)
    analysis.ask(Judge({}))
    qtbot.waitUntil(lambda: len(heard.of(Judge)) == 1, timeout=ENOUGH)
    before = analysis.pids
    analysis.begin(Scenario(), dict(settings))  # as after a reset
    analysis.ask(Judge({}))
    qtbot.waitUntil(lambda: len(heard.of(Judge)) == 2, timeout=ENOUGH)
    assert analysis.pids == before
    assert before[1] is None


@pytest.mark.slow
def test_another_flight_forgets_what_was_asked_and_judges_anew(qtbot, analysis, heard):
    analysis.begin(Scenario(), {})
    analysis.ask(Judge({}))
    qtbot.waitUntil(lambda: len(heard.of(Judge)) == 1, timeout=ENOUGH)
    before = analysis.pids[0]
    analysis.ask(Judge({"kp_yaw_rate": 5.0}))
    analysis.ask(Tune({}, ()))
    analysis.begin(Scenario(vehicle=VehicleConfig(args={"mass": "2.0"})), {})
    analysis.ask(Judge({"kd_roll": 22.0}))
    qtbot.waitUntil(lambda: heard.of(Judge)[-1].gains == {"kd_roll": 22.0}, timeout=ENOUGH)
    assert len(heard.of(Judge)) == 2
    assert analysis.pids[0] != before
    qtbot.waitUntil(lambda: not Path(f"/proc/{before}").exists(), timeout=ENOUGH)
    assert not heard.refused
    assert not analysis.banner


@pytest.mark.slow
def test_an_answer_on_its_way_when_another_flight_begins_is_not_shown(qtbot, analysis, heard):
    analysis.begin(Scenario(), {})
    analysis.ask(Judge({"kp_roll": 180.0}))
    # no events are handled meanwhile; answers come in the order of questions
    analysis._analyst.ask(Predict({}, STEP)).result(ENOUGH / 1000)
    analysis.begin(Scenario(), {"kp_roll": 200.0})
    analysis.ask(Judge({"kd_roll": 22.0}))
    qtbot.waitUntil(lambda: bool(heard.of(Judge)), timeout=ENOUGH)
    assert [each.gains for each in heard.of(Judge)] == [{"kd_roll": 22.0}]


@pytest.mark.slow
def test_a_search_tells_how_it_goes_and_can_be_stopped(qtbot, analysis, heard):
    analysis.begin(Scenario(), {})
    analysis.ask(Tune({}, ("x.rise_time <= 0.1", "pitch.phase_margin >= 70deg")))
    qtbot.waitUntil(lambda: bool(heard.searched), timeout=ENOUGH)
    analysis.stop()
    qtbot.waitUntil(lambda: bool(heard.of(Tune)), timeout=ENOUGH)
    assert heard.answers[-1][1].stopped
    assert heard.threads == {QThread.currentThread()}


def test_a_killed_analyst_is_told_and_asked_again(qtbot, analysis, heard):
    analysis.begin(Scenario(), {})
    analysis.warm_up()
    qtbot.waitUntil(lambda: analysis.pids[0] is not None, timeout=ENOUGH)
    analysis.ask(Judge({}))
    os.kill(analysis.pids[0], signal.SIGKILL)
    qtbot.waitUntil(lambda: bool(heard.refused or heard.of(Judge)), timeout=ENOUGH)
    analysis.ask(Judge({"kd_roll": 22.0}))
    qtbot.waitUntil(
        lambda: bool(heard.of(Judge)) and heard.of(Judge)[-1].gains == {"kd_roll": 22.0},
        timeout=ENOUGH,
    )


@pytest.mark.slow
def test_an_analyst_that_has_given_up_is_another_one_once_the_scenario_is_opened_again(
    qtbot, analysis, heard
):
    analysis.begin(Scenario(), {})
    killed = {None}
    while not heard.refused or "open the scenario again" not in heard.refused[-1][1]:
        said = len(heard.refused)
        analysis.ask(Judge({}))
        if len(killed) <= 3:
            qtbot.waitUntil(lambda: analysis.pids[0] not in killed, timeout=ENOUGH)
            killed.add(analysis.pids[0])
            os.kill(analysis.pids[0], signal.SIGKILL)
        qtbot.waitUntil(lambda said=said: len(heard.refused) > said, timeout=ENOUGH)
    analysis.begin(Scenario(), {})
    analysis.ask(Judge({}))
    qtbot.waitUntil(lambda: bool(heard.of(Judge)), timeout=ENOUGH)


def test_another_text_of_the_controller_is_judged_anew(analysis):
    law = load_controller()
    analysts = []
    for controller in (law, law, dataclasses.replace(law, text=law.text + "# edited"), law):
        analysis.begin(Scenario(), {"kp_roll": 200.0}, controller)
        analysts.append(analysis._analyst)
    assert [analysts.index(each) for each in analysts] == [0, 0, 2, 3]
