import pytest

from workbench.analysis.questions import FindRanges, Judge
from workbench.gui.analysis import Follower


@pytest.fixture
def follower(offline):
    analysis = offline.analysis
    made = Follower(analysis, Judge)
    made.set_seen(True)
    made.heard = []
    made.answered.connect(lambda question, _: made.heard.append(question))
    return made


def test_one_question_is_in_flight_and_the_newest_is_next(follower, offline, judge):
    for value in range(10):
        follower.ask(Judge({"kp_pitch": float(value)}))
    assert offline.analysis.asked == [Judge({"kp_pitch": 0.0})]
    offline.analysis.tell(*judge({"kp_pitch": 0.0}))
    assert offline.analysis.asked[1:] == [Judge({"kp_pitch": 9.0})]
    assert [dict(each.gains) for each in follower.heard] == [{"kp_pitch": 0.0}]


def test_nothing_is_asked_while_nobody_looks(follower, offline):
    follower.set_seen(False)
    follower.ask(Judge({"kp_pitch": 1.0}))
    assert offline.analysis.asked == []
    follower.set_seen(True)
    assert offline.analysis.asked == [Judge({"kp_pitch": 1.0})]


def test_what_is_known_is_not_asked_again(follower, offline, judge):
    follower.ask(Judge({"kp_pitch": 1.0}))
    offline.analysis.tell(*judge({"kp_pitch": 1.0}))
    follower.ask(Judge({"kp_pitch": 1.0}))
    assert len(offline.analysis.asked) == 1


def test_an_answer_to_somebody_else_lets_it_ask_again(follower, offline, judge):
    follower.ask(Judge({"kp_pitch": 1.0}))
    offline.analysis.tell(*judge({"kp_pitch": 7.0}))
    assert follower.heard == []
    assert offline.analysis.asked == [Judge({"kp_pitch": 1.0})] * 2


def test_a_refusal_is_told_and_the_next_question_goes_out(follower, offline):
    told = []
    follower.refused.connect(told.append)
    question = Judge({"kp_pitch": 1.0})
    follower.ask(question)
    follower.ask(Judge({"kp_pitch": 2.0}))
    offline.analysis.refused.emit(FindRanges({}), "not mine")
    assert told == []
    offline.analysis.refused.emit(question, "no such vehicle")
    assert told == ["no such vehicle"]
    assert offline.analysis.asked[-1] == Judge({"kp_pitch": 2.0})
