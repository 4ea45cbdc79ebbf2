import pytest

from workbench.analysis.questions import FindRanges, Judge
from workbench.gui.tuning.follower import Follower
from workbench.gui.tuning.judgement import _answers


@pytest.fixture
def follower(desk_room):
    analysis = desk_room.analysis
    made = Follower(analysis, analysis.judged, Judge, _answers)
    made.set_seen(True)
    made.heard = []
    made.answered.connect(made.heard.append)
    return made


def test_one_question_is_in_flight_and_the_newest_is_next(follower, desk_room, judge):
    for value in range(10):
        follower.ask(Judge({"kp_pitch": float(value)}))
    assert desk_room.analysis.asked == [Judge({"kp_pitch": 0.0})]
    desk_room.analysis.judged.emit(judge({"kp_pitch": 0.0}))
    assert desk_room.analysis.asked[1:] == [Judge({"kp_pitch": 9.0})]
    assert [dict(each.gains) for each in follower.heard] == [{"kp_pitch": 0.0}]


def test_nothing_is_asked_while_nobody_looks(follower, desk_room):
    follower.set_seen(False)
    follower.ask(Judge({"kp_pitch": 1.0}))
    assert desk_room.analysis.asked == []
    follower.set_seen(True)
    assert desk_room.analysis.asked == [Judge({"kp_pitch": 1.0})]


def test_what_is_known_is_not_asked_again(follower, desk_room, judge):
    follower.ask(Judge({"kp_pitch": 1.0}))
    desk_room.analysis.judged.emit(judge({"kp_pitch": 1.0}))
    follower.ask(Judge({"kp_pitch": 1.0}))
    assert len(desk_room.analysis.asked) == 1


def test_an_answer_to_somebody_else_lets_it_ask_again(follower, desk_room, judge):
    follower.ask(Judge({"kp_pitch": 1.0}))
    desk_room.analysis.judged.emit(judge({"kp_pitch": 7.0}))
    assert follower.heard == []
    assert desk_room.analysis.asked == [Judge({"kp_pitch": 1.0})] * 2


def test_a_refusal_is_told_and_the_next_question_goes_out(follower, desk_room):
    told = []
    follower.refused.connect(told.append)
    question = Judge({"kp_pitch": 1.0})
    follower.ask(question)
    follower.ask(Judge({"kp_pitch": 2.0}))
    desk_room.analysis.refused.emit(FindRanges({}), "not mine")
    assert told == []
    desk_room.analysis.refused.emit(question, "no such vehicle")
    assert told == ["no such vehicle"]
    assert desk_room.analysis.asked[-1] == Judge({"kp_pitch": 2.0})
