"""Tuning as a transaction, with a flight and an analyst that answer when the test says so."""

import pytest

from workbench.analysis.questions import FindRanges, Judge
from workbench.analysis.replies import Judged
from workbench.common.errors import WorkbenchError
from workbench.gui.gains.gain_desk import GainDesk
from workbench.gui.gains.gain_state import Mark

NAME = "kp_velocity_x"


def test_a_move_within_the_known_range_is_ordered_at_once(bench):
    bench.know(kp_velocity_x=(1.0, 8.0))
    bench.desk.propose(NAME, 7.9)
    assert bench.flight.given == [(NAME, 7.9)]
    assert not [each for each in bench.analysis.asked if isinstance(each, Judge)]
    assert bench.desk.flown[NAME] == 7.9


def test_a_move_beyond_the_known_range_is_judged_before_it_flies(bench):
    bench.know(kp_velocity_x=(1.0, 8.0))
    bench.desk.propose(NAME, 8.1)
    assert bench.flight.given == []
    assert bench.analysis.asked[-1].gains[NAME] == 8.1
    bench.analysis.judge(stable=True)
    assert bench.flight.given == [(NAME, 8.1)]


def test_without_any_knowledge_a_move_is_judged(bench):
    bench.desk.propose(NAME, 3.1)
    assert bench.flight.given == []
    bench.analysis.judge(stable=True)
    assert bench.flight.given == [(NAME, 3.1)]


def test_two_gains_halfway_each_are_known_and_further_are_judged(bench):
    bench.know(kp_velocity_x=(1.0, 5.0), kp_roll=(50.0, 250.0))
    bench.desk.propose(NAME, 4.0)
    bench.desk.propose("kp_roll", 200.0)
    assert bench.flight.given == [(NAME, 4.0), ("kp_roll", 200.0)]
    bench.desk.propose("kp_roll", 201.0)
    assert len(bench.flight.given) == 2
    assert isinstance(bench.analysis.asked[-1], Judge)


def test_what_is_unstable_is_named_and_not_flown_until_confirmed(bench, qtbot):
    with qtbot.waitSignal(bench.desk.doubt_raised) as doubt:
        bench.desk.propose("kp_roll", 900.0)
        bench.analysis.judge(stable=False, said="a swing grows through roll")
    assert doubt.args == ["a swing grows through roll"]
    assert bench.flight.given == []
    bench.desk.confirm()
    assert bench.flight.given == [("kp_roll", 900.0)]
    assert bench.desk.doubt == ""


def test_back_proposes_what_flies_again(bench):
    bench.desk.propose("kp_roll", 900.0)
    bench.analysis.judge(stable=False)
    bench.desk.back()
    assert bench.desk.proposed["kp_roll"] == 150.0
    assert bench.desk.doubt == ""
    bench.analysis.judged.emit(Judged({"kp_roll": 900.0}, (), None, True, ""))
    assert bench.flight.given == []


def test_confirm_without_a_doubt_flies_nothing(bench):
    bench.desk.propose(NAME, 4.0)
    bench.desk.confirm()
    assert bench.flight.given == []


def test_an_analyst_that_refuses_leaves_a_doubt_that_can_be_confirmed(bench):
    bench.desk.propose(NAME, 4.0)
    bench.analysis.refused.emit(bench.analysis.asked[-1], "its process has died")
    assert "could not be judged" in bench.desk.doubt
    assert "its process has died" in bench.desk.doubt
    count = len(bench.analysis.asked)
    bench.analysis.judged.emit(Judged({NAME: 11.0}, (), None, True, ""))
    assert len(bench.analysis.asked) == count  # nothing is waited for any more
    bench.desk.confirm()
    assert bench.flight.given == [(NAME, 4.0)]


def test_an_analyst_that_is_silent_leaves_a_doubt_and_may_still_answer(bench, qtbot):
    bench.desk.propose(NAME, 4.0)
    qtbot.waitUntil(lambda: bench.desk.doubt != "", timeout=10000)
    assert "not known yet" in bench.desk.doubt
    bench.analysis.judge(stable=True)
    assert bench.flight.given == [(NAME, 4.0)]
    assert bench.desk.doubt == ""


def test_an_answer_about_earlier_gains_flies_nothing(bench):
    bench.desk.propose(NAME, 4.0)
    first = bench.analysis.asked[-1]
    bench.desk.propose(NAME, 29.0)
    bench.analysis.judged.emit(Judged(first.gains, (), None, True, ""))
    assert bench.flight.given == []


def test_an_answer_to_somebody_else_lets_the_question_be_asked_again(bench):
    bench.desk.propose(NAME, 4.0)
    count = len(bench.analysis.asked)
    bench.analysis.judged.emit(Judged({NAME: 11.0}, (), None, True, ""))
    assert len(bench.analysis.asked) == count + 1
    assert bench.analysis.asked[-1].gains[NAME] == 4.0


def test_a_limit_needs_no_judgement(bench):
    bench.desk.propose("max_tilt", 0.5)
    assert bench.flight.given == [("max_tilt", 0.5)]


@pytest.mark.parametrize("value", [float("nan"), float("inf"), -1.0, 30.5])
def test_what_the_table_refuses_never_reaches_the_flight(bench, qtbot, value):
    bench.know()
    with qtbot.waitSignal(bench.desk.complained) as complaint:
        bench.desk.propose(NAME, value)
    assert complaint.args[0] == NAME
    assert complaint.args[1].startswith("kp_velocity_x is ")
    assert bench.flight.given == []
    assert bench.desk.proposed[NAME] == 3.0
    with qtbot.waitSignal(bench.desk.complained) as complaint:
        bench.desk.propose(NAME, 4.0)
    assert complaint.args == [NAME, ""]


def test_a_set_with_one_bad_value_is_refused_whole(bench):
    bench.know()
    with pytest.raises(WorkbenchError, match="kp_roll"):
        bench.desk.adopt({NAME: 4.0, "kp_roll": float("nan")}, "a search")
    assert bench.flight.given == []
    assert bench.desk.proposed[NAME] == 3.0


def test_on_enter_nothing_flies_before_apply(bench, workspace):
    workspace.preferences.set("apply_gains", "on Enter")
    bench.know()
    bench.desk.propose(NAME, 4.0)
    assert bench.flight.given == []
    assert bench.desk.mark(NAME) is Mark.PROPOSED
    assert bench.desk.said() == "1 gain proposed, not flown"
    bench.desk.apply()
    assert bench.flight.given == [(NAME, 4.0)]
    assert bench.desk.said() == "1 gain tried, not kept"


def test_an_answer_flies_nothing_that_was_proposed_after_it_was_entered(bench, workspace):
    workspace.preferences.set("apply_gains", "on Enter")
    bench.desk.propose(NAME, 4.0)
    bench.desk.apply()
    entered = bench.analysis.asked[-1]
    bench.desk.propose(NAME, 30.0)
    bench.analysis.judged.emit(Judged(entered.gains, (), None, True, ""))
    assert bench.flight.given == []
    assert bench.desk.unflown == (NAME,)


def test_a_doubt_about_other_gains_cannot_be_confirmed(bench, workspace):
    workspace.preferences.set("apply_gains", "on Enter")
    bench.desk.propose("kp_roll", 900.0)
    bench.desk.apply()
    bench.analysis.judge(stable=False)
    bench.desk.propose("kp_roll", 2000.0)
    assert bench.desk.doubt == ""
    bench.desk.confirm()
    assert bench.flight.given == []


def test_what_is_left_of_doubted_gains_is_judged_anew(bench):
    bench.desk.adopt({NAME: 4.0, "kp_roll": 900.0}, "a search")
    bench.analysis.judge(stable=False)
    bench.desk.back(["kp_roll"])
    assert bench.analysis.asked[-1].gains["kp_roll"] == 150.0
    bench.analysis.judge(stable=True)
    assert bench.flight.given == [(NAME, 4.0)]
    assert bench.desk.doubt == ""


def test_undo_takes_a_doubt_about_what_was_entered_back(bench, workspace):
    workspace.preferences.set("apply_gains", "on Enter")
    bench.desk.propose(NAME, 4.0)
    bench.desk.propose("kp_roll", 900.0)
    bench.desk.apply()
    bench.analysis.judge(stable=False)
    bench.desk.undo()
    assert bench.desk.doubt == ""
    bench.desk.confirm()
    assert bench.flight.given == []


def test_a_change_by_a_client_lets_doubted_gains_be_judged_anew(bench):
    bench.desk.propose(NAME, 4.0)
    bench.analysis.judge(stable=False)
    bench.flight.publish(2.0, kp_roll=140.0)
    assert bench.analysis.asked[-1].gains["kp_roll"] == 140.0
    assert bench.analysis.asked[-1].gains[NAME] == 4.0


def test_before_any_flight_a_value_is_refused_in_a_sentence(bench, workspace, qtbot):
    desk = GainDesk(bench.flight, bench.analysis, workspace.preferences, workspace.notices)
    with qtbot.waitSignal(desk.complained) as complaint:
        desk.propose(NAME, 4.0)
    assert complaint.args[0] == NAME
    assert "begin a flight" in complaint.args[1]
    desk.close()


def test_ranges_are_looked_for_once_gains_have_rested(bench, qtbot):
    bench.know()
    for value in (3.1, 3.2, 3.3):
        bench.desk.propose(NAME, value)
    assert not bench.desk.ranges_fresh

    def asked():
        return [each for each in bench.analysis.asked if isinstance(each, FindRanges)]

    qtbot.waitUntil(lambda: len(asked()) > 0, timeout=10000)
    assert [each.gains[NAME] for each in asked()] == [3.3]
    bench.know()
    assert bench.desk.ranges_fresh
